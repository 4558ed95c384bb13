//! Masses of line particles (Eq. 3 and Section 4.3.1, "Mass lumping").
//!
//! ```text
//! m_c = m_c⁰ + Σ ρ_i V_ci   over the cells within R,    m_c⁰ = 10⁻² ρ Δx² ℓ_c
//! ```
//!
//! A cell that the ball of radius `R` cuts counts with the part within, as if the phases were mixed in it. The printed `m_c⁰` is a mass
//! per length (E10); in 3D it is multiplied by the particle's length `ℓ_c`.
//!
//! Limit: in 3D the balls of neighbouring particles overlap, so that the sum of their masses is many times the mass around the line.

use meniscus_numerics::Vector;
use meniscus_numerics::grid::{Grid, lattice_points};
use meniscus_numerics::shape::plane_box_fraction;

/// Intrinsic mass over `ρ Δx² ℓ_c`.
pub const INTRINSIC_MASS: f64 = 1e-2;

/// Intrinsic mass `m_c⁰` of a particle, kg (2D: kg/m), with the liquid's density, kg/m³, the size of a cell, m, and the length of the
/// particle, m (2D: 1).
pub fn intrinsic_mass(density: f64, dx: f64, length: f64) -> f64 {
    INTRINSIC_MASS * density * dx * dx * length
}

/// Mass in the ball of a radius (m) around a point (m), kg (2D: kg/m), from the virtual density `ρ_c` of each cell, kg/m³.
pub fn control_volume_mass<const D: usize>(
    grid: &Grid<D>,
    virtual_density: &[f64],
    center: &Vector<D>,
    radius: f64,
) -> f64 {
    let lattice = grid.lattice();
    let reach = Vector::repeat(radius + grid.dx);
    let [low, high] = [center - reach, center + reach].map(|x| grid.cell_at(&x));
    let part = |at: [usize; D]| {
        let away = grid.center(at) - center;
        let slope = away.try_normalize(0.0).unwrap_or(Vector::zeros()) * grid.dx;
        plane_box_fraction::<D>(away.norm() - radius, std::array::from_fn(|a| slope[a]))
    };
    let cells = lattice_points([low, high.map(|i| i + 1)]);
    cells.map(|at| virtual_density[lattice.index(at)] * part(at)).sum::<f64>() * grid.cell_volume()
}
