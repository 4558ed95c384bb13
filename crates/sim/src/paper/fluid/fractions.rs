//! Volume fractions from level sets: the liquid mass in a dual cell (the `M` of Eq. 9, "approximated by the liquid level set") and
//! the virtual density of Eq. 3.
//!
//! In each cube the level set is taken for linear, with its central differences. The liquid's level set is closed: it is negative in
//! no solid ([`closed_along_solids`]).

use super::cells::{CellTypes, Face};
use meniscus_numerics::grid::{Grid, Sampler};
use meniscus_numerics::shape::plane_box_fraction;
use meniscus_numerics::{Vector, par};

/// Ends the liquid at the solids: the larger of `phi` and minus the signed distance to the solids, m. Where both are distances, the
/// result is one near the surface. The part of its zero set that lies on solids is the liquid–solid interface of Fig. 5.
pub fn closed_along_solids<const D: usize>(
    grid: &Grid<D>,
    phi: &[f64],
    solid_distance: &(dyn Fn(&Vector<D>) -> f64 + Sync),
) -> Vec<f64> {
    let lattice = grid.lattice();
    par::map(phi.len(), 256, |c| phi[c].max(-solid_distance(&grid.center(lattice.coordinates(c)))))
}

/// The level set at the centre of a face, m, and its differences per cell.
pub fn phi_at_face<const D: usize>(phi: &Sampler<'_, D>, grid: &Grid<D>, face: Face) -> (f64, [f64; D]) {
    let at = grid.face_lattice(face.axis).coordinates(face.index);
    let upper = at.map(|i| i as isize);
    let mut lower = upper;
    lower[face.axis] -= 1;
    (0.5 * (phi.value(lower) + phi.value(upper)), phi.face_differences(face.axis, at))
}

/// Mass of the liquid in the dual cell of a face, kg (2D: kg/m): an entry of `M`.
pub fn liquid_mass<const D: usize>(
    phi: &Sampler<'_, D>,
    types: &CellTypes<D>,
    density: f64,
    face: Face,
) -> f64 {
    let grid = types.grid();
    let (value, differences) = phi_at_face(phi, grid, face);
    density * grid.cell_volume() * plane_box_fraction(value, differences)
}

/// The part of a cell in which a level set is negative.
pub fn cell_fraction<const D: usize>(phi: &Sampler<'_, D>, grid: &Grid<D>, at: [usize; D]) -> f64 {
    let slope = phi.gradient(at) * grid.dx;
    plane_box_fraction::<D>(phi.value(at.map(|i| i as isize)), std::array::from_fn(|a| slope[a]))
}

/// The virtual density `ρ_c` of Eq. 3 in every cell, kg/m³: the density of the liquid times its fraction, and the same of solids. Air
/// has none.
pub fn virtual_density<const D: usize>(
    grid: &Grid<D>,
    phi: &Sampler<'_, D>,
    solid_distance: &Sampler<'_, D>,
    [liquid, solid]: [f64; 2],
) -> Vec<f64> {
    let lattice = grid.lattice();
    let of = |cell: usize| {
        let at = lattice.coordinates(cell);
        liquid * cell_fraction(phi, grid, at) + solid * cell_fraction(solid_distance, grid, at)
    };
    par::map(lattice.len(), 256, of)
}
