//! Quality measures of a volume mesh, and checks for defects.
//!
//! The shape of a simplex is measured by its dihedral angles (2D: angles) and by its radius ratio, `D` times the inradius
//! over the circumradius: 1 for a regular simplex, 0 for a flat one (J. Shewchuk, "What is a good linear finite element?",
//! 2002). Both follow from the gradients of the barycentric coordinates in any dimension.

use super::{Simplex, VolumeMesh};
use crate::Vector;
use std::fmt;
use thiserror::Error;

/// Volume of a simplex, over the cube (2D: square) of its longest edge, below which it is degenerate.
const MIN_RELATIVE_VOLUME: f64 = 1e-9;

/// Quality measures of a volume mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshQuality {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles (2D) or tetrahedra (3D).
    pub simplices: usize,
    /// Number of facets of the boundary.
    pub boundary_facets: usize,
    /// Number of connected components; facets connect simplices.
    pub components: usize,
    /// Length of the shortest edge, mean length, length of the longest edge, m.
    pub edge_lengths: [f64; 3],
    /// Smallest dihedral angle (2D: angle), rad, and its simplex.
    pub smallest_angle: (f64, usize),
    /// Largest dihedral angle (2D: angle), rad, and its simplex.
    pub largest_angle: (f64, usize),
    /// Smallest volume of a simplex, m³ (2D: m²), and that simplex.
    pub smallest_volume: (f64, usize),
    /// Smallest radius ratio (1: regular, 0: flat), and its simplex.
    pub worst_radius_ratio: (f64, usize),
    /// Total volume, m³ (2D: m²).
    pub volume: f64,
}

/// Shape of one simplex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimplexShape {
    /// Smallest and largest dihedral angle (2D: angle), rad.
    pub angles: [f64; 2],
    /// `D` times the inradius over the circumradius: 1 for a regular simplex, 0 for a flat one.
    pub radius_ratio: f64,
}

/// Defects that make a volume mesh unusable. Numbers count from 0.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MeshDefect {
    /// A vertex of a simplex does not exist or is repeated.
    #[error("element {simplex} has a vertex that does not exist, or the same vertex twice")]
    Vertex {
        /// Number of the simplex.
        simplex: usize,
    },
    /// A coordinate is not a finite number.
    #[error("vertex {vertex} has a coordinate that is not a finite number")]
    NotFinite {
        /// Number of the vertex.
        vertex: usize,
    },
    /// Simplices are inverted.
    #[error(
        "{count} elements are inverted, the first is element {simplex} near {near:?} m with volume {volume:e}"
    )]
    Inverted {
        /// Number of inverted simplices.
        count: usize,
        /// Number of the first.
        simplex: usize,
        /// Its volume, m³ (2D: m²).
        volume: f64,
        /// Its centre, m.
        near: Vec<f64>,
    },
    /// Simplices are degenerate.
    #[error(
        "{count} elements are flat, the first is element {simplex} near {near:?} m with volume {volume:e}"
    )]
    Degenerate {
        /// Number of degenerate simplices.
        count: usize,
        /// Number of the first.
        simplex: usize,
        /// Its volume, m³ (2D: m²).
        volume: f64,
        /// Its centre, m.
        near: Vec<f64>,
    },
    /// More than two simplices share a facet, or two lie on the same side of it.
    #[error("the elements on facet {facet:?} near {near:?} m overlap")]
    Overlap {
        /// The facet's vertices.
        facet: Vec<u32>,
        /// Position of its first vertex, m.
        near: Vec<f64>,
    },
    /// The boundary touches itself at a vertex or along an edge.
    #[error("the boundary touches itself at vertex {vertex} near {near:?} m")]
    NonManifold {
        /// Number of the vertex.
        vertex: usize,
        /// Its position, m.
        near: Vec<f64>,
    },
    /// The mesh has several connected components.
    #[error("the mesh consists of {count} parts that are not connected")]
    Disconnected {
        /// Number of components.
        count: usize,
    },
}

impl<const D: usize> Simplex<D> {
    /// Its angles and radius ratio; `None` if it is flat.
    pub fn shape(&self, positions: &[Vector<D>]) -> Option<SimplexShape> {
        let edges = self.edges(positions);
        let inverse = edges.try_inverse()?;
        // Gradients of the barycentric coordinates: those of all vertices but the first, then that of the first.
        let mut gradients = [Vector::<D>::zeros(); 4];
        let mut circumcenter = Vector::<D>::zeros();
        for k in 0..D {
            gradients[k] = inverse.row(k).transpose();
            gradients[D] -= gradients[k];
            circumcenter += gradients[k] * (0.5 * edges.column(k).norm_squared());
        }
        let gradients = &gradients[..=D];
        let inradius = 1.0 / gradients.iter().map(|g| g.norm()).sum::<f64>();
        let mut angles = [f64::INFINITY, 0.0f64];
        for i in 0..=D {
            for j in 0..i {
                let cosine = -gradients[i].dot(&gradients[j]) / (gradients[i].norm() * gradients[j].norm());
                let angle = cosine.clamp(-1.0, 1.0).acos();
                angles = [angles[0].min(angle), angles[1].max(angle)];
            }
        }
        let radius_ratio = D as f64 * inradius / circumcenter.norm();
        (radius_ratio.is_finite() && angles[1] > 0.0).then_some(SimplexShape { angles, radius_ratio })
    }

    /// The mean of its vertices, m.
    pub fn center(&self, positions: &[Vector<D>]) -> Vector<D> {
        self.vertices().map(|v| positions[v as usize]).sum::<Vector<D>>() / (D + 1) as f64
    }
}

impl<const D: usize> VolumeMesh<D> {
    /// The edges, each with its lower vertex first, sorted.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::with_capacity(self.simplices.len() * D * (D + 1) / 2);
        for simplex in &self.simplices {
            let vertices: Vec<u32> = simplex.vertices().collect();
            for i in 0..=D {
                (0..i).for_each(|j| {
                    edges.push([vertices[i].min(vertices[j]), vertices[i].max(vertices[j])]);
                });
            }
        }
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Measures the mesh. All vertices must exist. A flat simplex gets angle and radius ratio 0.
    pub fn quality(&self) -> MeshQuality {
        let edges = self.edges();
        let length = |e: &[u32; 2]| (self.positions[e[0] as usize] - self.positions[e[1] as usize]).norm();
        let mean = crate::par::sum(edges.len(), |i| length(&edges[i])) / edges.len().max(1) as f64;
        let shortest = edges.iter().map(length).fold(f64::INFINITY, f64::min);
        let mut out = MeshQuality {
            vertices: self.positions.len(),
            simplices: self.simplices.len(),
            boundary_facets: self.boundary().len(),
            components: self.component_count(),
            edge_lengths: [shortest, mean, edges.iter().map(length).fold(0.0, f64::max)],
            smallest_angle: (f64::INFINITY, 0),
            largest_angle: (0.0, 0),
            smallest_volume: (f64::INFINITY, 0),
            worst_radius_ratio: (f64::INFINITY, 0),
            volume: self.volume(),
        };
        let least = |best: &mut (f64, usize), value: f64, i: usize| {
            if value < best.0 {
                *best = (value, i);
            }
        };
        for (i, simplex) in self.simplices.iter().enumerate() {
            let flat = SimplexShape { angles: [0.0, 0.0], radius_ratio: 0.0 };
            let shape = simplex.shape(&self.positions).unwrap_or(flat);
            least(&mut out.smallest_angle, shape.angles[0], i);
            if shape.angles[1] > out.largest_angle.0 {
                out.largest_angle = (shape.angles[1], i);
            }
            least(&mut out.smallest_volume, simplex.volume(&self.positions), i);
            least(&mut out.worst_radius_ratio, shape.radius_ratio, i);
        }
        out
    }

    /// Number of connected components; facets connect simplices.
    pub fn component_count(&self) -> usize {
        let mut facets = Vec::with_capacity(self.simplices.len() * (D + 1));
        for (i, simplex) in self.simplices.iter().enumerate() {
            for k in 0..=D {
                let mut facet = simplex.facet(k);
                facet.sort_unstable();
                facets.push((facet, i));
            }
        }
        facets.sort_unstable();
        let mut parent: Vec<usize> = (0..self.simplices.len()).collect();
        let mut count = parent.len();
        for pair in facets.windows(2).filter(|p| p[0].0 == p[1].0) {
            let [a, b] = [pair[0].1, pair[1].1].map(|i| root(&mut parent, i));
            if a != b {
                parent[a.max(b)] = a.min(b);
                count -= 1;
            }
        }
        count
    }

    /// The connected component of each vertex, counted from 0; here common vertices connect simplices.
    pub fn vertex_components(&self) -> Vec<u32> {
        let mut parent: Vec<usize> = (0..self.positions.len()).collect();
        for simplex in &self.simplices {
            for v in simplex.others {
                let [a, b] = [simplex.root, v].map(|v| root(&mut parent, v as usize));
                parent[a.max(b)] = a.min(b);
            }
        }
        // A root is the first vertex of its component.
        let mut numbers = vec![0; parent.len()];
        let mut count = 0;
        for v in 0..parent.len() {
            let first = root(&mut parent, v);
            if first == v {
                numbers[v] = count;
                count += 1;
            } else {
                numbers[v] = numbers[first];
            }
        }
        numbers
    }

    /// Checks that the mesh is usable and has one component.
    ///
    /// # Errors
    /// The first defect found.
    pub fn check(&self) -> Result<(), MeshDefect> {
        self.check_elements()?;
        match self.component_count() {
            0 | 1 => Ok(()),
            count => Err(MeshDefect::Disconnected { count }),
        }
    }

    /// As [`check`](Self::check), but several components are allowed.
    ///
    /// # Errors
    /// The first defect found.
    pub fn check_elements(&self) -> Result<(), MeshDefect> {
        self.check_vertices()?;
        self.check_volumes()?;
        self.check_boundary()
    }

    fn check_vertices(&self) -> Result<(), MeshDefect> {
        let finite = |x: &Vector<D>| x.iter().all(|c| c.is_finite());
        if let Some(vertex) = self.positions.iter().position(|x| !finite(x)) {
            return Err(MeshDefect::NotFinite { vertex });
        }
        let wrong = |s: &Simplex<D>| {
            let mut vertices: Vec<u32> = s.vertices().collect();
            vertices.sort_unstable();
            vertices.dedup();
            vertices.len() <= D || vertices.iter().any(|v| *v as usize >= self.positions.len())
        };
        match self.simplices.iter().position(wrong) {
            Some(simplex) => Err(MeshDefect::Vertex { simplex }),
            None => Ok(()),
        }
    }

    fn check_volumes(&self) -> Result<(), MeshDefect> {
        let relative = |s: &Simplex<D>| s.volume(&self.positions) / self.longest_edge(s).powi(D as i32);
        let found = |bad: &dyn Fn(f64) -> bool| {
            let mut all = (0..self.simplices.len()).filter(|i| bad(relative(&self.simplices[*i])));
            let simplex = all.next()?;
            let near = self.simplices[simplex].center(&self.positions).as_slice().to_vec();
            Some((1 + all.count(), simplex, self.simplices[simplex].volume(&self.positions), near))
        };
        if let Some((count, simplex, volume, near)) = found(&|v| v < -MIN_RELATIVE_VOLUME) {
            return Err(MeshDefect::Inverted { count, simplex, volume, near });
        }
        // NaN counts as degenerate.
        if let Some((count, simplex, volume, near)) =
            found(&|v| v.is_nan() || (-MIN_RELATIVE_VOLUME..MIN_RELATIVE_VOLUME).contains(&v))
        {
            return Err(MeshDefect::Degenerate { count, simplex, volume, near });
        }
        Ok(())
    }

    fn longest_edge(&self, s: &Simplex<D>) -> f64 {
        let corners: Vec<Vector<D>> = s.vertices().map(|v| self.positions[v as usize]).collect();
        let to = |a: &Vector<D>| corners.iter().map(|b| (a - b).norm_squared()).fold(0.0, f64::max);
        corners.iter().map(to).fold(0.0, f64::max).sqrt()
    }

    fn check_boundary(&self) -> Result<(), MeshDefect> {
        let near = |v: u32| self.positions[v as usize].as_slice().to_vec();
        let mut facets = Vec::with_capacity(self.simplices.len() * (D + 1));
        for simplex in &self.simplices {
            for k in 0..=D {
                let facet = simplex.facet(k);
                let mut key = facet;
                key.sort_unstable();
                facets.push((key, !is_even_permutation(&facet)));
            }
        }
        facets.sort_unstable();
        for same in facets.chunk_by(|a, b| a.0 == b.0) {
            if same.len() > 2 || (same.len() == 2 && same[0].1 == same[1].1) {
                return Err(MeshDefect::Overlap { facet: same[0].0.to_vec(), near: near(same[0].0[0]) });
            }
        }
        let boundary = self.boundary();
        match non_manifold_vertex(&boundary) {
            Some(v) => Err(MeshDefect::NonManifold { vertex: v as usize, near: near(v) }),
            None => Ok(()),
        }
    }
}

/// A vertex around which the facets of a closed boundary do not form a single fan (2D: without exactly two facets), if any.
pub(super) fn non_manifold_vertex<const D: usize>(boundary: &[[u32; D]]) -> Option<u32> {
    let mut stars: Vec<(u32, usize)> =
        boundary.iter().enumerate().flat_map(|(i, f)| f.map(|v| (v, i))).collect();
    stars.sort_unstable();
    let torn = |star: &[(u32, usize)]| {
        let v = star[0].0;
        if D == 2 {
            return star.len() != 2;
        }
        // Walk from facet to facet across the edges at the vertex; each edge joins two facets.
        let others = |f: &[u32; D]| -> Vec<u32> { f.iter().copied().filter(|w| *w != v).collect() };
        let edges: Vec<Vec<u32>> = star.iter().map(|s| others(&boundary[s.1])).collect();
        let (mut at, mut through) = (0, edges[0][0]);
        for step in 1..=edges.len() {
            let mut next = (0..edges.len()).filter(|i| *i != at && edges[*i].contains(&through));
            let (Some(other), None) = (next.next(), next.next()) else { return true };
            through = if edges[other][0] == through { edges[other][1] } else { edges[other][0] };
            at = other;
            if at == 0 {
                return step != edges.len();
            }
        }
        true
    };
    stars.chunk_by(|a, b| a.0 == b.0).find(|star| torn(star)).map(|star| star[0].0)
}

/// Whether the permutation that sorts the vertices of a facet is even.
fn is_even_permutation<const D: usize>(facet: &[u32; D]) -> bool {
    let inversions = (0..D).map(|i| (0..i).filter(|j| facet[*j] > facet[i]).count()).sum::<usize>();
    inversions.is_multiple_of(2)
}

/// The representative of a set, with path compression.
fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

impl fmt::Display for MeshQuality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [short, mean, long] = self.edge_lengths;
        write!(
            f,
            "{} vertices, {} elements in {} part(s), {} boundary facets; edges {short:.4e} to {long:.4e} m, mean \
             {mean:.4e} m; angles {:.2} to {:.2} degrees; radius ratio at least {:.3}; volume {:.6e}, smallest {:.3e}",
            self.vertices,
            self.simplices,
            self.components,
            self.boundary_facets,
            self.smallest_angle.0.to_degrees(),
            self.largest_angle.0.to_degrees(),
            self.worst_radius_ratio.0,
            self.volume,
            self.smallest_volume.0,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::volume::block::block;

    /// A regular simplex: the D unit vectors and the point (c, …, c) at the same distance from each of them.
    fn regular<const D: usize>() -> VolumeMesh<D> {
        let unit = |a: usize| Vector::<D>::from_fn(|b, _| if a == b { 1.0 } else { 0.0 });
        let c = (1.0 - (1.0 + D as f64).sqrt()) / D as f64;
        let mut positions: Vec<Vector<D>> = (0..D).map(unit).collect();
        positions.push(Vector::repeat(c));
        let simplex = Simplex { root: D as u32, others: std::array::from_fn(|k| k as u32) };
        let simplices = vec![simplex.oriented(&positions)];
        VolumeMesh { positions, simplices }
    }

    fn defects<const D: usize>() {
        let mesh = regular::<D>();
        let shape = mesh.simplices[0].shape(&mesh.positions).unwrap();
        let angle = (1.0 / D as f64).acos();
        assert!((shape.angles[0] - angle).abs() < 1e-12 && (shape.angles[1] - angle).abs() < 1e-12);
        assert!((shape.radius_ratio - 1.0).abs() < 1e-12);
        assert_eq!((mesh.check(), mesh.component_count()), (Ok(()), 1));
        let quality = mesh.quality();
        assert!(quality.edge_lengths.iter().all(|e| (e - 2.0f64.sqrt()).abs() < 1e-12));
        assert_eq!((quality.vertices, quality.simplices, quality.boundary_facets), (D + 1, 1, D + 1));

        let mut inverted = mesh.clone();
        inverted.simplices[0].others.swap(0, 1);
        assert!(matches!(inverted.check(), Err(MeshDefect::Inverted { simplex: 0, count: 1, .. })));
        let mut flat = mesh.clone();
        flat.positions[D] = flat.positions[0] * 0.5 + flat.positions[1] * 0.5;
        assert!(matches!(flat.check(), Err(MeshDefect::Degenerate { simplex: 0, .. })));
        assert_eq!(flat.quality().worst_radius_ratio.0, 0.0);
        let mut twice = mesh.clone();
        twice.simplices.push(twice.simplices[0]);
        assert!(matches!(twice.check(), Err(MeshDefect::Overlap { .. })));
        let mut strange = mesh.clone();
        strange.simplices[0].others[0] = 9;
        assert_eq!(strange.check(), Err(MeshDefect::Vertex { simplex: 0 }));
        let mut infinite = mesh.clone();
        infinite.positions[1][0] = f64::NAN;
        assert_eq!(infinite.check(), Err(MeshDefect::NotFinite { vertex: 1 }));

        // A second simplex that shares only the last vertex, then one that shares none.
        let mut pinched = mesh.clone();
        pinched.positions.extend((0..D).map(|k| mesh.positions[D] * 2.0 - mesh.positions[k]));
        let others = std::array::from_fn(|k| (D + 1 + k) as u32);
        pinched.simplices.push(Simplex { root: D as u32, others }.oriented(&pinched.positions));
        assert!(matches!(pinched.check(), Err(MeshDefect::NonManifold { vertex, .. }) if vertex == D));
        pinched.positions.push(mesh.positions[D] - Vector::repeat(0.01));
        pinched.simplices[1].root = 2 * D as u32 + 1;
        assert_eq!(pinched.check_elements(), Ok(()));
        assert_eq!(pinched.check(), Err(MeshDefect::Disconnected { count: 2 }));
    }

    #[test]
    fn defects_of_volumes_are_named() {
        defects::<2>();
        defects::<3>();
        // Two tetrahedra of a block that share an edge but no facet.
        let mut mesh = block::<3>([1; 3], &Vector::repeat(1.0));
        mesh.simplices = vec![mesh.simplices[0], mesh.simplices[5]];
        assert!(matches!(mesh.check_elements(), Err(MeshDefect::NonManifold { .. })));
    }
}
