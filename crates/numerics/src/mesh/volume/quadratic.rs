//! Quadratic simplices, stored as linear ones by subdivision at the edge midpoints.
//!
//! A quadratic simplex has nodes at its corners `x_i` and on its edges, `x_ij`. At barycentric coordinates `b` the position is
//!
//! ```text
//! x = Σ_i b_i (2 b_i − 1) x_i + 4 Σ_{i<j} b_i b_j x_ij
//! ```
//!
//! (Zienkiewicz & Taylor, "The Finite Element Method", vol. 1). Subdivision gives `2^D` linear simplices on the same nodes: one at
//! each corner, and those in the middle, in 3D an octahedron that is cut into four around its shortest diagonal (J. Bey,
//! "Tetrahedral grid refinement", Computing 55 (1995) 355). Surfaces, volumes and positions use the linear simplices; only elasticity
//! uses the quadratic ones. The `2^D` parts of a parent are consecutive in the mesh, those at the corners first, and the part at corner
//! `i` has node `x_ij` as its vertex `j`, so parents need no storage ([`VolumeMesh::quadratic_simplices`]).

use super::{Simplex, VolumeMesh};
use crate::mesh::surface::area_vector;
use crate::{Matrix, Vector};
use std::collections::BTreeMap;

/// Nodes of a quadratic simplex in 3D.
const MAX_NODES: usize = 10;
/// Corners of each facet in 3D, and the nodes on its edges, in the order of [`QuadraticSimplex::nodes`].
const FACET_NODES: [[[usize; 3]; 2]; 4] =
    [[[0, 1, 2], [4, 5, 7]], [[0, 1, 3], [4, 6, 8]], [[0, 2, 3], [5, 6, 9]], [[1, 2, 3], [7, 8, 9]]];
/// Largest displacement of an edge node, over the length of the edge. A displacement by this much along a straight edge makes the map
/// singular; across the edge it gives an arc of 106 degrees.
pub(super) const MAX_NODE_DISPLACEMENT_EDGES: f64 = 0.25;
/// Smallest allowed ratio of curved to straight volume of a part, and of the Jacobian determinants at a node. The ratios fall linearly
/// with the displacement: half way to a singular map, half is left.
const MIN_VOLUME_RATIO: f64 = 0.5;

/// Polynomial order of the simplices of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ElementOrder {
    /// Each simplex of the mesh is a linear one.
    Linear,
    /// Each group of `2^D` simplices of the mesh forms a quadratic one.
    #[default]
    Quadratic,
}

/// Nodes of a quadratic simplex: its `D + 1` corners, then those on its edges in the order of [`edge_pairs`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QuadraticSimplex<const D: usize> {
    nodes: [u32; MAX_NODES],
}

impl<const D: usize> QuadraticSimplex<D> {
    /// Its nodes: 6 in 2D, 10 in 3D.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes[..(D + 1) * (D + 2) / 2]
    }

    /// Jacobian of the position by barycentric coordinates 1 to D, from the [`shape_function_gradients`] `slopes`, m.
    pub fn jacobian(&self, slopes: &[Vector<D>], positions: &[Vector<D>]) -> Matrix<D> {
        let at = self.nodes().iter().map(|v| positions[*v as usize]);
        at.zip(slopes).fold(Matrix::zeros(), |sum, (x, slope)| sum + x * slope.transpose())
    }
}

/// Facet of a quadratic simplex in 3D.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QuadraticFacet {
    /// Its corners.
    pub corners: [u32; 3],
    /// The nodes on its edges.
    pub edges: [u32; 3],
}

impl QuadraticFacet {
    /// Its nodes with the values of their shape functions in its centre: -1/9 for a corner, 4/9 on an edge.
    pub fn center_weights(&self) -> impl Iterator<Item = (u32, f64)> {
        let corners = self.corners.into_iter().map(|v| (v, -1.0 / 9.0));
        corners.chain(self.edges.into_iter().map(|v| (v, 4.0 / 9.0)))
    }
}

/// Edges of a simplex: pairs of its vertices, the lower one first.
pub fn edge_pairs<const D: usize>() -> impl Iterator<Item = (usize, usize)> {
    (0..=D).flat_map(|i| (i + 1..=D).map(move |j| (i, j)))
}

/// Gradients of the shape functions of all nodes by barycentric coordinates 1 to D at coordinates `b`; coordinate 0 is 1 minus the
/// others.
pub fn shape_function_gradients<const D: usize>(b: &[f64]) -> Vec<Vector<D>> {
    let along = |i: usize| Vector::<D>::from_fn(|r, _| if i == 0 { -1.0 } else { f64::from(r + 1 == i) });
    let corner = |i: usize| along(i) * (4.0 * b[i] - 1.0);
    let middle = |(i, j): (usize, usize)| (along(i) * b[j] + along(j) * b[i]) * 4.0;
    (0..=D).map(corner).chain(edge_pairs::<D>().map(middle)).collect()
}

impl<const D: usize> VolumeMesh<D> {
    /// Divides every simplex into `2^D` at the midpoints of its edges: a mesh of quadratic simplices. The vertices keep their numbers;
    /// the midpoints follow.
    pub fn subdivided(&self) -> Self {
        let all = self.edges();
        let count = self.positions.len();
        let mut positions = self.positions.clone();
        positions.extend(all.iter().map(|[a, b]| (self.position(*a) + self.position(*b)) * 0.5));
        let middle = |a: u32, b: u32| {
            let edge = [a.min(b), a.max(b)];
            (count + all.partition_point(|e| *e < edge)) as u32
        };
        let mut simplices = Vec::with_capacity(self.simplices.len() << D);
        for simplex in &self.simplices {
            let corners: Vec<u32> = simplex.vertices().collect();
            for (i, at) in corners.iter().enumerate() {
                let vertex = |j: usize| if i == j { *at } else { middle(*at, corners[j]) };
                simplices.push(Simplex { root: vertex(0), others: std::array::from_fn(|k| vertex(k + 1)) });
            }
            let node = |i: usize, j: usize| middle(corners[i], corners[j]);
            push_inner_simplices(&node, &positions, &mut simplices);
        }
        Self { positions, simplices }
    }

    /// As [`subdivided`](Self::subdivided), with the nodes on the given edges shifted (m) where simplices stay well shaped. Edges have
    /// their lower vertex first.
    pub fn subdivided_curved(&self, shifts: &[([u32; 2], Vector<D>)]) -> Self {
        let (mut mesh, all) = (self.subdivided(), self.edges());
        let Some(parents) = mesh.quadratic_simplices() else { return mesh };
        let straight = mesh.positions.clone();
        for (edge, shift) in shifts {
            let Ok(number) = all.binary_search(edge) else { continue };
            mesh.positions[self.positions.len() + number] += shift;
        }
        // Each round makes at least one node straight again.
        for _ in 0..mesh.positions.len() {
            let bad: Vec<usize> =
                (0..parents.len()).filter(|k| !mesh.is_well_shaped(&parents[*k], *k, &straight)).collect();
            if bad.is_empty() {
                break;
            }
            for v in bad.iter().flat_map(|k| parents[*k].nodes()) {
                mesh.positions[*v as usize] = straight[*v as usize];
            }
        }
        mesh
    }

    /// The quadratic simplices whose parts are the mesh's simplices in the order of [`subdivided`](Self::subdivided), if they are.
    pub fn quadratic_simplices(&self) -> Option<Vec<QuadraticSimplex<D>>> {
        let parts = self.simplices.chunks_exact(1 << D);
        if !parts.remainder().is_empty() {
            return None;
        }
        parts.map(quadratic_simplex).collect()
    }

    /// Facets of quadratic simplices in 3D that may be on the boundary, each with its three corners and the nodes on its edges; the key
    /// is the sorted list of the latter. In 2D a facet's centre is a node, and the result is empty.
    pub fn quadratic_facets(&self) -> BTreeMap<[u32; 3], QuadraticFacet> {
        let parents = if D == 3 { self.quadratic_simplices().unwrap_or_default() } else { Vec::new() };
        let of = |parent: &QuadraticSimplex<D>| {
            FACET_NODES.map(|[corners, edges]| {
                let [corners, edges] = [corners, edges].map(|nodes| nodes.map(|k| parent.nodes[k]));
                let mut key = edges;
                key.sort_unstable();
                (key, QuadraticFacet { corners, edges })
            })
        };
        parents.iter().flat_map(of).collect()
    }

    pub(super) fn position(&self, v: u32) -> Vector<D> {
        self.positions[v as usize]
    }

    /// The edges of the boundary, sorted, each with its mean unit normal.
    pub(super) fn boundary_edges(&self) -> Vec<([u32; 2], Vector<D>)> {
        let mut sides: Vec<([u32; 2], Vector<D>)> = Vec::new();
        for facet in self.boundary() {
            let across = area_vector(&facet.map(|v| self.position(v)));
            for i in 0..D {
                sides.extend((0..i).map(|j| ([facet[i].min(facet[j]), facet[i].max(facet[j])], across)));
            }
        }
        sides.sort_by_key(|s| s.0);
        let mean = |same: &[([u32; 2], Vector<D>)]| {
            let sum: Vector<D> = same.iter().map(|s| s.1).sum();
            Some((same[0].0, sum.try_normalize(0.0)?))
        };
        sides.chunk_by(|a, b| a.0 == b.0).filter_map(mean).collect()
    }

    /// Whether the quadratic simplex `number` keeps enough of the volumes that it has with nodes at `straight`.
    fn is_well_shaped(&self, parent: &QuadraticSimplex<D>, number: usize, straight: &[Vector<D>]) -> bool {
        let parts = &self.simplices[number << D..(number + 1) << D];
        let fair = |s: &Simplex<D>| s.volume(&self.positions) >= MIN_VOLUME_RATIO * s.volume(straight);
        let volume = |x: &[Vector<D>], b: &[f64]| {
            let jacobian = parent.jacobian(&shape_function_gradients(b), x);
            let simplex = Simplex::<D> { root: 0, others: std::array::from_fn(|k| k as u32 + 1) };
            let mut corners = vec![Vector::zeros()];
            corners.extend(jacobian.column_iter().map(|c| c.into_owned()));
            simplex.volume(&corners)
        };
        let corner = |i: usize| (0..=D).map(|k| f64::from(k == i)).collect::<Vec<f64>>();
        let middle = |(i, j)| (0..=D).map(|k| 0.5 * f64::from(k == i || k == j)).collect::<Vec<f64>>();
        let mut places = (0..=D).map(corner).chain(edge_pairs::<D>().map(middle));
        parts.iter().all(fair)
            && places.all(|b| volume(&self.positions, &b) >= MIN_VOLUME_RATIO * volume(straight, &b))
    }
}

/// Adds the simplices between those at the corners; `node` gives the node on an edge.
fn push_inner_simplices<const D: usize>(
    node: &dyn Fn(usize, usize) -> u32,
    positions: &[Vector<D>],
    simplices: &mut Vec<Simplex<D>>,
) {
    let mut push = |vertices: &[u32]| {
        let simplex = Simplex { root: vertices[0], others: std::array::from_fn(|k| vertices[k + 1]) };
        simplices.push(simplex.oriented(positions));
    };
    if D == 2 {
        return push(&[node(1, 2), node(0, 2), node(0, 1)]);
    }
    // Diagonals of the octahedron: nodes of opposite edges.
    let diagonals = [(0, 1, 2, 3), (0, 2, 3, 1), (0, 3, 1, 2)];
    let length = |(a, b, c, d): &(usize, usize, usize, usize)| {
        (positions[node(*a, *b) as usize] - positions[node(*c, *d) as usize]).norm()
    };
    let shortest = diagonals.iter().map(length).fold(f64::INFINITY, f64::min);
    // Of diagonals equal to rounding the first, so that moved meshes are divided alike.
    let Some((a, b, c, d)) = diagonals.iter().find(|e| length(e) <= shortest * (1.0 + 1e-9)).copied() else {
        return;
    };
    let ring = [node(a, c), node(b, c), node(b, d), node(a, d)];
    for k in 0..4 {
        push(&[node(a, b), node(c, d), ring[k], ring[(k + 1) % 4]]);
    }
}

/// The quadratic simplex with the given `2^D` parts, if they form one.
fn quadratic_simplex<const D: usize>(parts: &[Simplex<D>]) -> Option<QuadraticSimplex<D>> {
    let vertex = |i: usize, j: usize| if j == 0 { parts[i].root } else { parts[i].others[j - 1] };
    let mut nodes = [0; MAX_NODES];
    (0..=D).for_each(|i| nodes[i] = vertex(i, i));
    for (k, (i, j)) in edge_pairs::<D>().enumerate() {
        if vertex(i, j) != vertex(j, i) {
            return None;
        }
        nodes[D + 1 + k] = vertex(i, j);
    }
    let parent = QuadraticSimplex { nodes };
    let known = |part: &Simplex<D>| part.vertices().all(|v| parent.nodes().contains(&v));
    parts.iter().all(known).then_some(parent)
}

#[cfg(test)]
mod tests {
    use super::super::block::block;
    use super::*;

    fn division<const D: usize>() {
        let coarse = block::<D>([2; D], &Vector::repeat(1.0));
        let fine = coarse.subdivided();
        assert_eq!(fine.check(), Ok(()));
        assert!((fine.volume() - coarse.volume()).abs() < 1e-14);
        assert_eq!(fine.positions.len(), 5usize.pow(D as u32));
        assert_eq!(coarse.quadratic_simplices(), None);
        let parents = fine.quadratic_simplices().unwrap();
        assert_eq!(parents.len(), coarse.simplices.len());
        for (parent, simplex) in parents.iter().zip(&coarse.simplices) {
            let corners: Vec<u32> = simplex.vertices().collect();
            assert_eq!(parent.nodes()[..=D], corners);
            for (k, (i, j)) in edge_pairs::<D>().enumerate() {
                let at = |v: u32| fine.positions[v as usize];
                let middle = (at(corners[i]) + at(corners[j])) * 0.5;
                assert!((at(parent.nodes()[D + 1 + k]) - middle).norm() < 1e-15);
            }
        }
    }

    #[test]
    fn quadratic_simplices_are_known_by_their_parts() {
        division::<2>();
        division::<3>();
    }

    /// Nodes on a ball's surface reduce the volume error about as much as halving the edges.
    fn curved<const D: usize>(volume: f64) {
        let distance = |x: &Vector<D>| x.norm() - 1.0;
        let (low, high) = (Vector::repeat(-1.0), Vector::repeat(1.0));
        let coarse = super::super::stuff(&distance, &low, &high, 0.5).unwrap();
        let mesh = coarse.subdivided_onto(&distance);
        assert_eq!(mesh.check(), Ok(()));
        let off = |x: &Vector<D>| (x.norm() - 1.0).abs();
        let (surface, _) = mesh.surface();
        let on = surface.positions.iter().filter(|x| off(x) < 1e-9).count();
        let [lost, straight] = [&mesh, &coarse].map(|m| 1.0 - m.volume() / volume);
        println!(
            "{D}D: {on} of {} nodes on the surface, volume lost {lost:.4}, straight {straight:.4}",
            surface.positions.len()
        );
        assert!(on * 100 >= 98 * surface.positions.len() && lost < 0.3 * straight);
    }

    #[test]
    fn nodes_go_to_the_surface() {
        curved::<2>(std::f64::consts::PI);
        curved::<3>(4.0 / 3.0 * std::f64::consts::PI);
    }
}
