//! The wetted part of the liquid's surface, for drawing.
//!
//! The surfaces of liquid and solids are made apart and agree to a fraction of a cell. Where the liquid's lies above the solid's, a renderer
//! sees a gap of air, which reflects everything. So wetted vertices are moved below the closest solid, or wetted faces are left out. The
//! simulation does not use these meshes.

use crate::folder::Frame;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::ply::PlyMesh;
use meniscus_numerics::mesh::{FacetBvh, SurfaceMesh};

/// Largest distance from a solid, in cells, of wetted vertices that are moved. A vertex lies in the cell that the surface crosses; beside a
/// plate of 1.5 cells, which the liquid meets as if it had 2.5, it is half a cell away.
const REACH_CELLS: f64 = 1.0;
/// The same of their neighbours on the free surface, in cells. Chosen by looking at pictures.
const NEIGHBOUR_REACH_CELLS: f64 = 0.6;
/// Depth of moved vertices below the solid's surface in our own pictures in 3D, in cells: enough against rounding. Chosen by looking at
/// pictures.
const SEAM_DEPTH_CELLS: f64 = 0.05;
/// The same in 2D, in cells; it also hides half of the width of the liquid's outline. Chosen by looking at pictures.
const DRAWN_DEPTH_CELLS: f64 = 0.3;
/// Depth of wetted vertices for other renderers, in cells: at most half of the thinnest solid, which has a cell if it is rigid, and more
/// than the 0.35 cells by which the two surfaces differed in a run of `drop-on-soft-plate` with an early version.
const SUNK_DEPTH_CELLS: f64 = 0.5;

/// Treatment of the wetted faces of the liquid's surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WettedFaces {
    /// They stay where they are.
    #[default]
    Keep,
    /// They are moved half a cell into the solid.
    Sink,
    /// They are left out, so that the surface is open.
    Remove,
}

impl WettedFaces {
    /// Changes the liquid's surface of a frame in so many dimensions with cells of `dx` m.
    pub fn apply(self, frame: &mut Frame, dimension: usize, dx: f64) {
        match (self, dimension) {
            (Self::Keep, _) => {}
            (Self::Sink, 2) => sink::<2>(frame, &Depths::of_export(dx)),
            (Self::Sink, _) => sink::<3>(frame, &Depths::of_export(dx)),
            (Self::Remove, _) => remove(&mut frame.liquid),
        }
    }
}

/// Whether each vertex of the liquid lies on a solid.
fn wetted_vertices(liquid: &PlyMesh) -> Vec<bool> {
    let kinds = liquid.scalars.get("kind").map_or(&[][..], |kinds| kinds);
    (0..liquid.positions.len()).map(|v| kinds.get(v).is_some_and(|kind| *kind >= 1.0)).collect()
}

/// Moves the wetted vertices of a frame's liquid below the closest solid.
pub(crate) fn sink<const D: usize>(frame: &mut Frame, depths: &Depths) {
    let wetted = wetted_vertices(&frame.liquid);
    let to_vector = |p: &[f64; 3]| Vector::<D>::from_fn(|a, _| p[a]);
    let surface = |mesh: &PlyMesh| SurfaceMesh::<D> {
        positions: mesh.positions.iter().map(to_vector).collect(),
        facets: facets(mesh),
    };
    let solids: Vec<SurfaceMesh<D>> = frame.solids.values().map(surface).collect();
    let mut points: Vec<Vector<D>> = frame.liquid.positions.iter().map(to_vector).collect();
    move_below(&mut points, &facets(&frame.liquid), &wetted, &solids, depths);
    for (to, from) in frame.liquid.positions.iter_mut().zip(&points) {
        (0..D).for_each(|a| to[a] = from[a]);
    }
}

/// The triangles of a mesh, in 2D its edges.
fn facets<const D: usize>(mesh: &PlyMesh) -> Vec<[u32; D]> {
    match D {
        2 => mesh.edges.iter().map(|edge| std::array::from_fn(|k| edge[k])).collect(),
        _ => mesh.faces.iter().map(|face| std::array::from_fn(|k| face[k])).collect(),
    }
}

/// How far and how deep vertices are moved.
pub(crate) struct Depths {
    /// Size of a cell, m.
    dx: f64,
    /// Depth of wetted vertices, in cells.
    wetted: f64,
    /// Largest distance from a solid of their neighbours that are moved, in cells.
    neighbour_reach: f64,
}

impl Depths {
    /// For our own pictures in 3D: just below the surface.
    pub(crate) fn of_picture(dx: f64) -> Self {
        Self { dx, wetted: SEAM_DEPTH_CELLS, neighbour_reach: NEIGHBOUR_REACH_CELLS }
    }

    /// For pictures in 2D, where the solids are drawn over the liquid and its free surface stays as it is.
    pub(crate) fn of_drawing(dx: f64) -> Self {
        Self { dx, wetted: DRAWN_DEPTH_CELLS, neighbour_reach: 0.0 }
    }

    /// For other renderers.
    fn of_export(dx: f64) -> Self {
        Self { dx, wetted: SUNK_DEPTH_CELLS, neighbour_reach: NEIGHBOUR_REACH_CELLS }
    }
}

/// Moves wetted vertices, and their neighbours, below the surface of the closest solid.
pub(crate) fn move_below<const D: usize>(
    points: &mut [Vector<D>],
    facets: &[[u32; D]],
    wetted: &[bool],
    solids: &[SurfaceMesh<D>],
    depths: &Depths,
) {
    let &Depths { dx, wetted: depth, neighbour_reach } = depths;
    let mut reach: Vec<f64> = wetted.iter().map(|&wet| if wet { REACH_CELLS * dx } else { 0.0 }).collect();
    for facet in facets.iter().filter(|f| f.iter().any(|&v| wetted[v as usize])) {
        facet.iter().for_each(|&v| reach[v as usize] = reach[v as usize].max(neighbour_reach * dx));
    }
    let trees: Vec<FacetBvh<D>> = solids.iter().map(FacetBvh::new).collect();
    for (v, point) in points.iter_mut().enumerate().filter(|(v, _)| reach[*v] > 0.0) {
        let closest = |(tree, mesh): (&FacetBvh<D>, _)| Some((tree.closest_point(point, reach[v])?, mesh));
        let near = trees.iter().zip(solids).filter_map(closest);
        let nearest = near.min_by(|a, b| a.0.distance_squared.total_cmp(&b.0.distance_squared));
        let Some((at, mesh)) = nearest else { continue };
        let mesh: &SurfaceMesh<D> = mesh;
        let out = mesh.area_vector(at.facet as usize).try_normalize(0.0).unwrap_or_else(Vector::zeros);
        let below = if wetted[v] { depth } else { SEAM_DEPTH_CELLS };
        *point = at.point - out * (below * dx);
    }
}

/// Removes the faces, in 2D the edges, all of whose vertices lie on a solid.
fn remove(liquid: &mut PlyMesh) {
    let wetted = wetted_vertices(liquid);
    let is_free = |corners: &[u32]| !corners.iter().all(|v| wetted[*v as usize]);
    liquid.faces.retain(|face| is_free(face));
    liquid.edges.retain(|edge| is_free(edge));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of liquid, whose lower side is wetted, on a plate below y = 0.1.
    fn frame() -> Frame {
        let mesh = |corners: [[f64; 2]; 4]| PlyMesh {
            positions: corners.map(|[x, y]| [x, y, 0.0]).to_vec(),
            edges: vec![[0, 1], [1, 2], [2, 3], [3, 0]],
            ..PlyMesh::default()
        };
        let mut liquid = mesh([[0.4, 0.12], [0.6, 0.09], [0.6, 0.8], [0.4, 0.8]]);
        liquid.scalars.insert("kind".into(), vec![1.0, 1.0, 0.0, 0.0]);
        let plate = mesh([[0.0, 0.0], [1.0, 0.0], [1.0, 0.1], [0.0, 0.1]]);
        Frame { liquid, solids: [("plate".to_owned(), plate)].into(), ..Frame::default() }
    }

    #[test]
    fn wetted_faces_are_sunk_or_removed() {
        let mut sunk = frame();
        WettedFaces::Sink.apply(&mut sunk, 2, 0.05);
        let heights: Vec<f64> = sunk.liquid.positions.iter().map(|p| p[1]).collect();
        assert!((heights[0] - 0.075).abs() < 1e-12 && (heights[1] - 0.075).abs() < 1e-12, "{heights:?}");
        assert_eq!(heights[2..], [0.8, 0.8]);
        let mut open = frame();
        WettedFaces::Remove.apply(&mut open, 2, 0.05);
        assert_eq!(open.liquid.edges, [[1, 2], [2, 3], [3, 0]]);
        let mut same = frame();
        WettedFaces::Keep.apply(&mut same, 2, 0.05);
        assert_eq!(same.liquid, frame().liquid);
    }
}
