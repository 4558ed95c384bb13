//! The map `W_s` from the velocities of surface vertices to faces (Section 5.1).
//!
//! Row `f` has the weights of the surface within the dual cell of face `f`: each facet is sampled, and every sample in the dual cell
//! gives its share of the facet's area to the facet's vertices by its barycentric weights. Rows are normalised to one. The component of
//! the face's axis is mapped, `u_f = Σ_k W_fk v_k · e_a`, and impulses on faces are distributed by the transpose.
//!
//! A face without a sample, which the surface only touches, takes the closest point of the surface; such faces are counted.
//!
//! So a rigid motion is mapped exactly to its velocity at the centre of the samples ([`SolidMap::centers`]). Limit: this is up to half a
//! cell away from the centre of the face.

use super::sparse_matrix::{Entry, SparseMatrix};
use crate::paper::fluid::cells::{CellTypes, Face};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::mesh::{FacetBvh, SurfaceMesh};

/// Samples along an edge as long as a cell.
const SAMPLES_PER_CELL: f64 = 6.0;

/// `W_s` for some faces.
#[derive(Clone, Debug)]
pub struct SolidMap<const D: usize> {
    /// The faces of its rows, sorted.
    pub faces: Vec<Face>,
    /// The weights; its columns are the vertices of the surface.
    pub weights: SparseMatrix,
    /// For each row the weighted mean of the positions of the vertices, m: the centre of its samples.
    pub centers: Vec<Vector<D>>,
    /// Number of faces without samples.
    pub unsampled: u64,
}

impl<const D: usize> SolidMap<D> {
    /// The map of sorted faces from a surface, which may be that of several solids.
    pub fn new(types: &CellTypes<D>, faces: Vec<Face>, mesh: &SurfaceMesh<D>) -> Self {
        let mut rows: Vec<Vec<Entry>> = vec![Vec::new(); faces.len()];
        for f in 0..mesh.facets.len() {
            let (corners, area) = (mesh.corners(f), mesh.area_vector(f).norm());
            let samples = samples(&corners, types.grid().dx / SAMPLES_PER_CELL);
            let share = area / samples.len() as f64;
            for weights in &samples {
                let x = (0..D).map(|k| corners[k] * weights[k]).sum();
                for axis in 0..D {
                    let Some(index) = dual_cell(types.grid(), axis, &x) else { continue };
                    let Ok(row) = faces.binary_search(&Face { axis, index }) else { continue };
                    rows[row].extend((0..D).map(|k| (mesh.facets[f][k], share * weights[k])));
                }
            }
        }
        let unsampled = rows.iter().filter(|row| row.is_empty()).count() as u64;
        let tree = (unsampled > 0).then(|| FacetBvh::new(mesh));
        for (row, face) in rows.iter_mut().zip(&faces).filter(|(row, _)| row.is_empty()) {
            let closest = tree.as_ref().and_then(|t| t.closest_point(&types.center(*face), f64::INFINITY));
            let Some(closest) = closest else { continue };
            row.extend(mesh.facets[closest.facet as usize].into_iter().zip(closest.weights));
        }
        let normalised = |row: Vec<Entry>| {
            let sum: f64 = row.iter().map(|entry| entry.1).sum();
            row.into_iter().map(|(vertex, weight)| (vertex, weight / sum)).collect::<Vec<_>>()
        };
        let weights = SparseMatrix::new(mesh.positions.len(), rows.into_iter().map(normalised));
        let center = |row: usize| {
            weights.row(row).iter().map(|(v, weight)| mesh.positions[*v as usize] * *weight).sum()
        };
        let centers = (0..faces.len()).map(center).collect();
        Self { faces, weights, centers, unsampled }
    }

    /// The map to the faces from the unknowns of solids, through the map from these unknowns to the velocities of the surface's vertices,
    /// whose rows are the components vertex by vertex.
    pub fn from_unknowns(&self, embedding: &SparseMatrix) -> SparseMatrix {
        self.on_components().product(embedding)
    }

    /// The map with all components of the vertices' velocities as columns, vertex by vertex.
    pub fn on_components(&self) -> SparseMatrix {
        let row = |(i, face): (usize, &Face)| {
            let component = |vertex: u32| vertex * D as u32 + face.axis as u32;
            self.weights.row(i).iter().map(|(v, weight)| (component(*v), *weight)).collect::<Vec<_>>()
        };
        SparseMatrix::new(D * self.weights.columns(), self.faces.iter().enumerate().map(row))
    }
}

/// The surfaces of several solids as one mesh, solid by solid.
pub fn joined<const D: usize>(surfaces: &[SurfaceMesh<D>]) -> SurfaceMesh<D> {
    let mut all = SurfaceMesh::default();
    for surface in surfaces {
        let first = all.positions.len() as u32;
        all.positions.extend(&surface.positions);
        all.facets.extend(surface.facets.iter().map(|facet| facet.map(|v| v + first)));
    }
    all
}

/// The face normal to an axis whose dual cell contains a point, m.
fn dual_cell<const D: usize>(grid: &Grid<D>, axis: usize, x: &Vector<D>) -> Option<usize> {
    let lattice = grid.face_lattice(axis);
    let mut at = [0; D];
    for a in 0..D {
        let shift = if a == axis { 0.5 } else { 0.0 };
        let place = x[a] / grid.dx + grid.margin_cells[a][0] as f64 + shift;
        if place < 0.0 || place >= lattice.extent[a] as f64 {
            return None;
        }
        at[a] = place as usize;
    }
    Some(lattice.index(at))
}

/// Barycentric weights of the centres of equal parts of a facet, whose edges are at most `spacing` (m) long.
fn samples<const D: usize>(corners: &[Vector<D>; D], spacing: f64) -> Vec<[f64; D]> {
    let edge = |k: usize| (corners[(k + 1) % D] - corners[k]).norm();
    let longest = (0..D).map(edge).fold(0.0, f64::max);
    let parts = (longest / spacing).ceil().max(1.0) as usize;
    let weights = |a: f64, b: f64| {
        let [a, b] = [a, b].map(|w| w / parts as f64);
        std::array::from_fn(|k| [1.0 - a - b, a, b][k])
    };
    if D == 2 {
        return (0..parts).map(|i| weights(i as f64 + 0.5, 0.0)).collect();
    }
    let mut all = Vec::with_capacity(parts * parts);
    for i in 0..parts {
        for j in 0..parts - i {
            // The part at (i, j), and the inverted one beside it.
            for turned in 0..if i + j + 1 < parts { 2 } else { 1 } {
                let third = (1 + turned) as f64 / 3.0;
                all.push(weights(i as f64 + third, j as f64 + third));
            }
        }
    }
    all
}
