//! Force balance of the free surface around a contact line on a deformable solid.
//!
//! The surface has no mass: the tension of the rest of the surface on the part near a piece of the line acts on the solid
//! at the line and on the enclosed liquid. A line that moves freely pulls along the solid as in equilibrium, and the liquid
//! gets the difference. A line pinned at an edge of the solid does not move the liquid, and the solid gets the full tension
//! at any angle (Gibbs). The capillary force that acts on the liquid decides between the two.

use crate::free_surface::dual_cell::DualCell;
use crate::free_surface::interface_faces::InterfaceFace;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use std::collections::HashMap;

/// Distances from the line, in cells, up to which the surface fully belongs to it, and from which on it does not: the
/// line's force on the liquid is smoothed with the curvature over some cells (with 1.5 and 3 the forces on a sheet's halves
/// were wrong by a tenth of the tension).
const FULL_SHARE_DISTANCE_CELLS: f64 = 4.0;
const ZERO_SHARE_DISTANCE_CELLS: f64 = 6.0;
/// Distance from the interface, in cells, beyond which a cell is no corner of a dual cell that the interface crosses.
const MAX_INTERFACE_DISTANCE_CELLS: f64 = 2.0;

/// The cells near pieces of contact lines.
pub struct LineNeighbourhood(HashMap<usize, NearestPiece>);

/// The piece nearest to a cell.
struct NearestPiece {
    /// Index of the piece.
    piece: usize,
    /// Distance to it, in cells.
    distance_cells: f64,
    /// Share of the cell's surface that belongs to it.
    share: f64,
}

impl LineNeighbourhood {
    /// The neighbourhood of pieces at these places (m); `phi` is the signed distance to the interface in each cell, m.
    pub fn new<const D: usize>(grid: &Grid<D>, phi: &[f64], places: &[Vector<D>]) -> Self {
        let (lattice, reach) =
            (grid.lattice(), (ZERO_SHARE_DISTANCE_CELLS + MAX_INTERFACE_DISTANCE_CELLS).ceil() as isize);
        let foot = |at: [usize; D]| closest_on_interface_cells(grid, phi, at);
        let width = 2 * reach as usize + 1;
        let mut near: HashMap<usize, NearestPiece> = HashMap::new();
        for (number, place) in places.iter().enumerate() {
            let from = (place - grid.lower_corner([0; D])) / grid.dx;
            for n in 0..width.pow(D as u32) {
                let mut rest = n;
                let at: [isize; D] = std::array::from_fn(|a| {
                    let step = (rest % width) as isize - reach;
                    rest /= width;
                    from[a].floor() as isize + step
                });
                if (0..D).any(|a| at[a] < 0 || at[a] >= lattice.extent[a] as isize) {
                    continue;
                }
                let at = at.map(|i| i as usize);
                let cell = lattice.index(at);
                if phi[cell].abs() > MAX_INTERFACE_DISTANCE_CELLS * grid.dx {
                    continue;
                }
                let distance_cells = (foot(at) - from).norm();
                if distance_cells >= ZERO_SHARE_DISTANCE_CELLS {
                    continue;
                }
                let way = ((ZERO_SHARE_DISTANCE_CELLS - distance_cells)
                    / (ZERO_SHARE_DISTANCE_CELLS - FULL_SHARE_DISTANCE_CELLS))
                    .min(1.0);
                let here =
                    NearestPiece { piece: number, distance_cells, share: way * way * (3.0 - 2.0 * way) };
                if near.get(&cell).is_none_or(|old| distance_cells < old.distance_cells) {
                    near.insert(cell, here);
                }
            }
        }
        Self(near)
    }

    /// Adds for each piece the force of the rest of the surface on the part near it, over `γ Δ^(D−2)`: `−Σ A (1 − ν νᵀ) ∇s` over the
    /// dual cells, with the area `A` and the normal `ν` of the surface in each and the share `s`.
    pub fn add_tension<const D: usize>(&self, phi: &[f64], dual_cells: &[DualCell], sums: &mut [Vector<D>]) {
        let slope = |k: usize, a: usize| (if k >> a & 1 == 1 { 1.0 } else { -1.0 }) / (1 << (D - 1)) as f64;
        for cube in dual_cells.iter().filter(|c| c.area > 0.0) {
            let corners = &cube.corners[..1 << D];
            let belong = || corners.iter().map(|c| self.0.get(&(*c as usize)));
            if belong().all(|b| b.is_none()) {
                continue;
            }
            let value = |k: usize| phi[corners[k] as usize];
            let normal = Vector::<D>::from_fn(|a, _| (0..1 << D).map(|k| slope(k, a) * value(k)).sum());
            let Some(normal) = normal.try_normalize(0.0) else { continue };
            for (k, belongs) in belong().enumerate() {
                let Some(NearestPiece { piece, share, .. }) = belongs else { continue };
                let way = Vector::<D>::from_fn(|a, _| slope(k, a));
                sums[*piece] -= (way - normal * normal.dot(&way)) * (cube.area * share);
            }
        }
    }

    /// Subtracts for each piece the capillary force on the liquid near it, in the same units.
    pub fn subtract_capillary_force<const D: usize>(
        &self,
        grid: &Grid<D>,
        interface_faces: &[InterfaceFace],
        sums: &mut [Vector<D>],
    ) {
        let lattice = grid.lattice();
        for face in interface_faces {
            let push = -face.sign * face.open_fraction * face.kappa;
            let mut beyond = lattice.coordinates(face.cell);
            beyond[face.axis] = beyond[face.axis].saturating_add_signed(face.sign as isize);
            let beyond =
                if beyond[face.axis] < lattice.extent[face.axis] { lattice.index(beyond) } else { face.cell };
            for (cell, share) in [(face.cell, 1.0 - face.theta), (beyond, face.theta)] {
                if let Some(NearestPiece { piece, share: part, .. }) = self.0.get(&cell) {
                    sums[*piece][face.axis] -= push * part * share;
                }
            }
        }
    }
}

/// Closest point of the interface to a cell's centre, in cells from the first cell's lower corner.
fn closest_on_interface_cells<const D: usize>(grid: &Grid<D>, phi: &[f64], at: [usize; D]) -> Vector<D> {
    let lattice = grid.lattice();
    let value = |a: usize, up: usize| {
        let mut to = at;
        to[a] = (at[a] + up).saturating_sub(1).min(lattice.extent[a] - 1);
        phi[lattice.index(to)]
    };
    let slope = Vector::<D>::from_fn(|a, _| 0.5 * (value(a, 2) - value(a, 0)) / grid.dx);
    let way = phi[lattice.index(at)] / grid.dx / slope.norm_squared().max(0.25);
    Vector::from_fn(|a, _| at[a] as f64 + 0.5) - slope * way
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_surface::energy::DualGrid;
    use meniscus_numerics::grid::{Band, Tiles};

    /// A flat surface that ends at a contact line: the rest pulls its end along the surface, with the tension.
    fn check<const D: usize>(place: Vector<D>, pieces: usize) {
        let grid = Grid::<D>::new([24; D], 1.0);
        let lattice = grid.lattice();
        let normal = Vector::<D>::from_fn(|a, _| {
            if a == 0 {
                -0.6
            } else if a == 1 {
                0.8
            } else {
                0.0
            }
        });
        let phi: Vec<f64> =
            (0..lattice.len()).map(|i| (grid.center(lattice.coordinates(i)) - place).dot(&normal)).collect();
        let mut band = Band::new(grid);
        band.rebuild(&phi, &Tiles::all(grid).negative_runs(&phi).label(&grid), 3);
        let mut cubes = DualGrid::new(grid, Vector::zeros()).interface_cells(&phi, &band);
        let beside =
            |c: &DualCell| grid.center(lattice.coordinates(c.corners[0] as usize))[0] + 0.5 - place[0];
        cubes.retain(|c| beside(c) > 0.0);
        // In 3D the line is as long as the grid is wide: one piece in each cell.
        let at = |k: usize| Vector::from_fn(|a, _| if a == 2 { k as f64 + 0.5 } else { place[a] });
        let places: Vec<Vector<D>> = (0..pieces).map(at).collect();
        let mut sums = vec![Vector::zeros(); pieces];
        LineNeighbourhood::new(&grid, &phi, &places).add_tension(&phi, &cubes, &mut sums);
        let expected = Vector::<D>::from_fn(|a, _| {
            if a == 0 {
                0.8
            } else if a == 1 {
                0.6
            } else {
                0.0
            }
        });
        let middle = sums[pieces / 2];
        assert!((middle - expected).norm() < 0.02, "{middle:?}");
    }

    /// A film between two lines that lie closer than their reach: each gets the tension at its own end.
    #[test]
    fn two_lines_share_the_surface_between_them() {
        let grid = Grid::<2>::new([24; 2], 1.0);
        let lattice = grid.lattice();
        let phi: Vec<f64> =
            (0..lattice.len()).map(|i| grid.center(lattice.coordinates(i))[1] - 12.2).collect();
        let mut band = Band::new(grid);
        band.rebuild(&phi, &Tiles::all(grid).negative_runs(&phi).label(&grid), 3);
        let mut cubes = DualGrid::new(grid, Vector::zeros()).interface_cells(&phi, &band);
        let ends = [Vector::<2>::new(10.0, 12.2), Vector::<2>::new(15.0, 12.2)];
        let at = |c: &DualCell| grid.center(lattice.coordinates(c.corners[0] as usize))[0] + 0.5;
        cubes.retain(|c| (ends[0][0]..ends[1][0]).contains(&at(c)));
        let mut sums = vec![Vector::zeros(); 2];
        LineNeighbourhood::new(&grid, &phi, &ends).add_tension(&phi, &cubes, &mut sums);
        for (sum, way) in sums.iter().zip([1.0, -1.0]) {
            assert!((sum - Vector::<2>::new(way, 0.0)).norm() < 0.02, "{sums:?}");
        }
    }

    #[test]
    fn a_surface_pulls_its_end_along_itself() {
        check::<2>(Vector::<2>::new(12.0, 12.0), 1);
        check::<3>(Vector::<3>::new(12.0, 12.0, 12.0), 24);
    }
}
