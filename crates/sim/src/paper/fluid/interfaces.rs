//! Which tension acts at a place near the surface (Section 4.1 and Fig. 5).
//!
//! The closest point of the surface to `x` is `x_φ = x − φ n`. The dual cell closest to it that has liquid on one side, and air or
//! solid on the other, tells which tension acts.

use super::cells::{CellTypes, Face, FaceType};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::lattice_points;

/// Half the width of the search, in cells, at first and where that finds nothing near enough.
const SEARCH_CELLS: [usize; 2] = [1, 2];

/// Interface of the liquid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interface {
    /// With air: the diamonds of Fig. 5.
    LiquidAir,
    /// With a solid: the triangles of Fig. 5.
    LiquidSolid,
}

/// The interface at a point of the surface, m. Of equally near dual cells the first one counts; with none in two cells it is
/// liquid–air.
pub fn interface_at<const D: usize>(types: &CellTypes<D>, x: &Vector<D>) -> Interface {
    let mut found = None;
    for reach in SEARCH_CELLS {
        found = closest_interface(types, x, reach);
        // Dual cells outside the search are farther away than this.
        if found.is_some_and(|(distance, _)| distance <= reach as f64 * types.grid().dx) {
            break;
        }
    }
    found.map_or(Interface::LiquidAir, |(_, interface)| interface)
}

/// The closest interface among the faces of the cells within `reach` cells, with its distance, m.
fn closest_interface<const D: usize>(
    types: &CellTypes<D>,
    x: &Vector<D>,
    reach: usize,
) -> Option<(f64, Interface)> {
    let (grid, middle) = (types.grid(), types.grid().cell_at(x));
    let low = middle.map(|i| i.saturating_sub(reach));
    let high = std::array::from_fn(|a| (middle[a] + reach + 1).min(grid.cells[a]));
    let mut best: Option<(f64, Interface)> = None;
    for at in lattice_points([low, high]) {
        let cell = grid.lattice().index(at);
        for face in (0..D).flat_map(|axis| types.faces(cell, axis)) {
            let Some(interface) = interface_of(types, face) else { continue };
            let distance = (types.center(face) - x).norm();
            if best.is_none_or(|(nearest, _)| distance < nearest) {
                best = Some((distance, interface));
            }
        }
    }
    best
}

/// The interface at a face.
fn interface_of<const D: usize>(types: &CellTypes<D>, face: Face) -> Option<Interface> {
    match types.face(face) {
        FaceType::LiquidAir => Some(Interface::LiquidAir),
        FaceType::LiquidSolid => Some(Interface::LiquidSolid),
        _ => None,
    }
}
