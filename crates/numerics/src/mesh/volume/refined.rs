//! Quadratic simplices as meshes of linear ones: each divided at the middles of its edges.
//!
//! A quadratic simplex has nodes at its corners `x_i` and on its edges, `x_ij`; a place within it with barycentric coordinates `b` is
//!
//! ```text
//! x = Σ_i b_i (2 b_i − 1) x_i + 4 Σ_{i<j} b_i b_j x_ij
//! ```
//!
//! (Zienkiewicz & Taylor, "The Finite Element Method", vol. 1, on the quadratic triangle and tetrahedron). Divided regularly it is `2^D`
//! linear simplices on the same nodes: one at each corner, and what remains in the middle, in 3D an octahedron that is cut into four
//! around its shortest diagonal (J. Bey, "Tetrahedral grid refinement", Computing 55 (1995) 355). All that asks for surfaces, volumes
//! or places uses the linear simplices; only what is elastic knows that they belong together. They follow each other in the mesh,
//! `2^D` of each parent, those at the corners first, and the simplex at corner `i` has node `x_ij` as its vertex `j`: so the
//! parents need no memory of their own ([`VolumeMesh::parents`]).

use super::{Simplex, VolumeMesh};
use crate::Vector;

/// Nodes of a quadratic simplex in 3D, the most.
const MOST: usize = 10;

/// The nodes of a quadratic simplex: its `D + 1` corners, then those on its edges in the order of [`edges`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parent<const D: usize> {
    nodes: [u32; MOST],
}

impl<const D: usize> Parent<D> {
    /// Its nodes: 6 in 2D, 10 in 3D.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes[..(D + 1) * (D + 2) / 2]
    }
}

/// Edges of a simplex: pairs of its vertices, the lower one first.
pub fn edges<const D: usize>() -> impl Iterator<Item = (usize, usize)> {
    (0..=D).flat_map(|i| (i + 1..=D).map(move |j| (i, j)))
}

impl<const D: usize> VolumeMesh<D> {
    /// Every simplex divided into `2^D` at the middles of its edges: a mesh of quadratic simplices. The vertices keep their numbers,
    /// the middles follow.
    pub fn divided(&self) -> Self {
        let all = self.edges();
        let count = self.positions.len();
        let mut positions = self.positions.clone();
        positions.extend(
            all.iter().map(|[a, b]| (self.positions[*a as usize] + self.positions[*b as usize]) * 0.5),
        );
        let middle = |a: u32, b: u32| {
            let edge = [a.min(b), a.max(b)];
            (count + all.partition_point(|e| *e < edge)) as u32
        };
        let mut simplices = Vec::with_capacity(self.simplices.len() << D);
        for simplex in &self.simplices {
            let corners: Vec<u32> = simplex.vertices().collect();
            for (i, at) in corners.iter().enumerate() {
                let vertex = |j: usize| if i == j { *at } else { middle(*at, corners[j]) };
                simplices.push(Simplex { root: vertex(0), rest: std::array::from_fn(|k| vertex(k + 1)) });
            }
            let node = |i: usize, j: usize| middle(corners[i], corners[j]);
            within(&node, &positions, &mut simplices);
        }
        Self { positions, simplices }
    }

    /// The quadratic simplices that the mesh's simplices are the parts of, as [`divided`](Self::divided) leaves them; none where they
    /// are of no such.
    pub fn parents(&self) -> Option<Vec<Parent<D>>> {
        let parts = self.simplices.chunks_exact(1 << D);
        if !parts.remainder().is_empty() {
            return None;
        }
        parts.map(|parts| parent(parts)).collect()
    }
}

/// Adds the simplices between those at the corners; `node` tells the node on an edge.
fn within<const D: usize>(
    node: &dyn Fn(usize, usize) -> u32,
    positions: &[Vector<D>],
    simplices: &mut Vec<Simplex<D>>,
) {
    let mut push = |vertices: &[u32]| {
        let simplex = Simplex { root: vertices[0], rest: std::array::from_fn(|k| vertices[k + 1]) };
        simplices.push(simplex.upright(positions));
    };
    if D == 2 {
        return push(&[node(1, 2), node(0, 2), node(0, 1)]);
    }
    // Diagonals of the octahedron, each with the ring around it.
    let diagonals = [(0, 1, 2, 3), (0, 2, 3, 1), (0, 3, 1, 2)];
    let length = |(a, b, c, d): &(usize, usize, usize, usize)| {
        (positions[node(*a, *b) as usize] - positions[node(*c, *d) as usize]).norm()
    };
    let shortest = diagonals.iter().map(length).fold(f64::INFINITY, f64::min);
    // Of diagonals that are alike to rounding the first, so that moved meshes are divided alike.
    let Some((a, b, c, d)) = diagonals.iter().find(|e| length(e) <= shortest * (1.0 + 1e-9)).copied() else {
        return;
    };
    let ring = [node(a, c), node(b, c), node(b, d), node(a, d)];
    for k in 0..4 {
        push(&[node(a, b), node(c, d), ring[k], ring[(k + 1) % 4]]);
    }
}

/// The quadratic simplex of `2^D` parts.
fn parent<const D: usize>(parts: &[Simplex<D>]) -> Option<Parent<D>> {
    let vertex = |i: usize, j: usize| if j == 0 { parts[i].root } else { parts[i].rest[j - 1] };
    let mut nodes = [0; MOST];
    (0..=D).for_each(|i| nodes[i] = vertex(i, i));
    for (k, (i, j)) in edges::<D>().enumerate() {
        if vertex(i, j) != vertex(j, i) {
            return None;
        }
        nodes[D + 1 + k] = vertex(i, j);
    }
    let parent = Parent { nodes };
    let known = |part: &Simplex<D>| part.vertices().all(|v| parent.nodes().contains(&v));
    parts.iter().all(known).then_some(parent)
}

#[cfg(test)]
mod tests {
    use super::super::block::block;
    use super::*;

    fn division<const D: usize>() {
        let coarse = block::<D>([2; D], &Vector::repeat(1.0));
        let fine = coarse.divided();
        assert_eq!(fine.check(), Ok(()));
        assert!((fine.volume() - coarse.volume()).abs() < 1e-14);
        assert_eq!(fine.positions.len(), 5usize.pow(D as u32));
        assert_eq!(coarse.parents(), None);
        let parents = fine.parents().unwrap();
        assert_eq!(parents.len(), coarse.simplices.len());
        for (parent, simplex) in parents.iter().zip(&coarse.simplices) {
            let corners: Vec<u32> = simplex.vertices().collect();
            assert_eq!(parent.nodes()[..=D], corners);
            for (k, (i, j)) in edges::<D>().enumerate() {
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
}
