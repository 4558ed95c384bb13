//! The balance of the free surface around a contact line on a solid that deforms.
//!
//! The surface has no mass: what its rest pulls the part near a piece of the line with, that part gives to the solid at the
//! line and to the liquid that it encloses. A line that moves freely pulls along the solid as at rest, and the liquid gets the
//! difference; one that an edge of the solid holds does not move the liquid, and the solid gets all that the surface pulls
//! with, whatever its angle (Gibbs). Which of both, what the liquid is in truth pushed with tells.

use crate::liquid::cube::CutCube;
use crate::liquid::cut_faces::CutFace;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use std::collections::HashMap;

/// Distance from the line, in cells, up to which the surface belongs to it, and from which on it does not.
const NEAR: f64 = 1.5;
const FAR: f64 = 3.0;

/// Cells near places on contact lines: the number of the nearest place, the distance to it in cells, and how much of the cell
/// belongs to it.
pub struct Surroundings(HashMap<usize, (f64, usize, f64)>);

impl Surroundings {
    /// Of these places (m).
    pub fn new<const D: usize>(grid: &Grid<D>, places: &[Vector<D>]) -> Self {
        let (lattice, reach) = (grid.lattice(), FAR.ceil() as isize);
        let width = 2 * reach as usize + 1;
        let mut near: HashMap<usize, (f64, usize, f64)> = HashMap::new();
        for (number, place) in places.iter().enumerate() {
            let from = (place - grid.corner([0; D])) / grid.dx;
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
                let distance = Vector::<D>::from_fn(|a, _| at[a] as f64 + 0.5 - from[a]).norm();
                let part = ((FAR - distance) / (FAR - NEAR)).clamp(0.0, 1.0);
                let cell = lattice.index(at.map(|i| i as usize));
                let old = near.entry(cell).or_insert((f64::INFINITY, 0, 0.0));
                if part > 0.0 && distance < old.0 {
                    *old = (distance, number, part);
                }
            }
        }
        Self(near)
    }

    /// Adds for every place what the rest of the surface pulls the part near it with, over the tension, times the cell size to
    /// the power `D − 2`.
    pub fn add_tension<const D: usize>(&self, phi: &[f64], cubes: &[CutCube], sums: &mut [Vector<D>]) {
        let slope = |k: usize, a: usize| (if k >> a & 1 == 1 { 1.0 } else { -1.0 }) / (1 << (D - 1)) as f64;
        for cube in cubes.iter().filter(|c| c.area > 0.0) {
            let corners = &cube.corners[..1 << D];
            let belong = || corners.iter().map(|c| self.0.get(&(*c as usize)).filter(|b| b.2 > 0.0));
            if belong().all(|b| b.is_none()) {
                continue;
            }
            let value = |k: usize| phi[corners[k] as usize];
            let normal = Vector::<D>::from_fn(|a, _| (0..1 << D).map(|k| slope(k, a) * value(k)).sum());
            let Some(normal) = normal.try_normalize(0.0) else { continue };
            for (k, belongs) in belong().enumerate() {
                let Some((_, place, part)) = belongs else { continue };
                let way = Vector::<D>::from_fn(|a, _| slope(k, a));
                sums[*place] -= (way - normal * normal.dot(&way)) * (cube.area * part);
            }
        }
    }

    /// Takes away for every place what the surface pushes the liquid near it with, in the same units.
    pub fn take_pushes<const D: usize>(&self, grid: &Grid<D>, cut: &[CutFace], sums: &mut [Vector<D>]) {
        let lattice = grid.lattice();
        for face in cut {
            let push = -face.sign * face.open * face.kappa;
            let mut beyond = lattice.coordinates(face.cell);
            beyond[face.axis] = beyond[face.axis].saturating_add_signed(face.sign as isize);
            let beyond =
                if beyond[face.axis] < lattice.extent[face.axis] { lattice.index(beyond) } else { face.cell };
            for (cell, share) in [(face.cell, 1.0 - face.theta), (beyond, face.theta)] {
                if let Some((_, place, part)) = self.0.get(&cell) {
                    sums[*place][face.axis] -= push * part * share;
                }
            }
        }
    }
}
