//! Viscosity: one implicit step with a traction-free free surface.
//!
//! Variational form (C. Batty and R. Bridson, "Accurate viscous free surfaces for buckling, coiling, and rotating liquids", SCA 2008):
//! the new velocity minimises `½ Σ m_f (u_f − u*_f)² + ½ h Φ(u)` with the dissipation
//! `Φ = ν ∫ 2 Σ_a (∂_a u_a)² + Σ_{a<b} (∂_b u_a + ∂_a u_b)² dV`. Each term is weighted by the liquid fraction of its control volume: a
//! cell for the diagonal terms, the box around an edge (2D: a node) for the shear. The traction at the free surface then vanishes by
//! itself, and rigid motions are unchanged.
//!
//! The mass `m_f` of a face is nearly that of the pressure solve (1 between liquid cells, otherwise the
//! fraction θ of the way to the interface, here by linear interpolation of φ, there by a cubic root), so that
//! this step and the projection are symmetric in nearly the same inner product. Faces outside the liquid that a
//! term needs are unknowns without mass, which follow the liquid.
//!
//! Sides and solids are frictionless: edges on sides or in solids carry no shear, and faces on closed sides keep their velocity. In cut
//! cells fractions and masses are those of the open part. Faces closed by solids have no mass and follow the liquid; as fixed values
//! they made drops glide.

mod cells;
mod coarse;
mod coefficients;
mod multigrid;
mod operator;
#[cfg(test)]
mod tests;

use crate::model::Model;
use cells::UnknownCells;
use coarse::{ViscousSystem, add_coarse_systems};
use coefficients::Builder;
use meniscus_numerics::grid::{Band, CellField, CutCells, FaceField, Lattice, Runs, Segment};
use meniscus_numerics::linalg::{
    SolveError, SolveLimits, SolveReport, conjugate_gradient_in_single_precision,
};
use meniscus_numerics::par;
use multigrid::{Multigrid, is_mild};
use operator::ViscousOperator;

/// Relative residual of the solve. 1e-8 takes twice the iterations and changes the decay of a drop by 0.03 %.
const TOLERANCE: f64 = 1e-6;
/// Largest number of iterations.
const MAX_ITERATIONS: usize = 2000;
/// Layers of the band whose air cells may hold a control volume that reaches into the liquid.
const AIR_LAYERS: usize = 3;
/// Distance from the interface, in cells, beyond which all control volumes of a cell are full or empty: 1.6 for an exact distance.
const FULL_CELL_DISTANCE_CELLS: f64 = 2.0;

/// The fields of a state that viscosity needs.
pub struct Diffusion<'a, const D: usize> {
    /// Velocity, m/s; changed on the liquid's faces.
    pub velocity: &'a mut FaceField<D>,
    /// Signed distance, m.
    pub phi: &'a CellField<D>,
    /// The cells of the narrow band.
    pub band: &'a Band<D>,
    /// The liquid cells.
    pub liquid: &'a Runs,
    /// Their faces.
    pub liquid_faces: &'a [Vec<Segment>; D],
    /// Open fractions beside solids.
    pub cut_cells: &'a CutCells<D>,
}

impl<const D: usize> Diffusion<'_, D> {
    /// Lets viscosity act for `dt` seconds.
    ///
    /// # Errors
    /// Those of the solver.
    pub fn advance(&mut self, model: &Model<D>, dt: f64) -> Result<SolveReport, SolveError> {
        self.advance_to(model, dt, TOLERANCE)
    }

    fn advance_to(&mut self, model: &Model<D>, dt: f64, tolerance: f64) -> Result<SolveReport, SolveError> {
        let stiffness = stiffness(model, dt);
        let places = UnknownCells::new(model, self);
        let builder = Builder::new(model, self, &places, stiffness);
        let operator = builder.operator(&builder.deep_cells());
        let mut x = gather(&operator, model, &places, self);
        let b = operator.times_face_mass(&x);
        let limits = SolveLimits { tolerance, max_iterations: MAX_ITERATIONS };
        let mut systems = vec![ViscousSystem { cells: places.cells, operator, stiffness }];
        let report = if is_mild(stiffness) {
            let jacobi = systems[0].operator.jacobi();
            conjugate_gradient_in_single_precision(&systems[0].operator, &jacobi, &b, &mut x, limits)?
        } else {
            add_coarse_systems(&mut systems);
            let multigrid = Multigrid::new(&systems);
            conjugate_gradient_in_single_precision(&systems[0].operator, &multigrid, &b, &mut x, limits)?
        };
        let cells = &systems[0].cells;
        for a in 0..D {
            let lattice = model.grid.face_lattice(a);
            let (row, x) = (lattice.extent[0], &x[a * cells.count()..][..cells.count()]);
            par::for_each_segment(&mut self.velocity.axes[a], row, &self.liquid_faces[a], |s, part| {
                let at = lattice.coordinates(s.row * row + s.start);
                let slots = &cells.slots[cells.lattice.index(at)..][..part.len()];
                for (u, slot) in part.iter_mut().zip(slots).filter(|(_, slot)| **slot != 0) {
                    *u = x[*slot as usize];
                }
            });
        }
        Ok(report)
    }
}

/// `ν h/Δ²`.
fn stiffness<const D: usize>(model: &Model<D>, dt: f64) -> f64 {
    model.kinematic_viscosity * dt / (model.grid.dx * model.grid.dx)
}

/// Initial values on the faces. Unknowns outside the liquid get the mean of their neighbours in it.
fn gather<const D: usize>(
    operator: &ViscousOperator<D>,
    model: &Model<D>,
    places: &UnknownCells<D>,
    diffusion: &Diffusion<'_, D>,
) -> Vec<f64> {
    let (count, faces) = (places.cells.count(), std::array::from_fn(|a| model.grid.face_lattice(a)));
    let (faces, velocity): (&[Lattice<D>; D], _) = (&faces, &diffusion.velocity.axes);
    let at = |i: usize| places.cells.coordinates(i);
    let mut x = vec![0.0; count * D];
    par::map_component_segments(&mut x, count, &places.runs, |_, s, parts: [&mut [f64]; D]| {
        let at = at(s.start);
        for (a, part) in parts.into_iter().enumerate() {
            part.copy_from_slice(&velocity[a][faces[a].index(at)..][..part.len()]);
        }
    });
    let value = |at: [usize; D], a: usize| {
        let exists = (0..D).all(|b| b == a || at[b] < model.grid.cells[b]);
        if exists { velocity[a][faces[a].index(at)] } else { 0.0 }
    };
    let (segments, cells) = operator.general_stretches();
    // Liquid cells have the first places.
    let liquid = 1..places.runs.last().map_or(1, |run| run.end);
    par::map_component_segments(&mut x, count, &segments, |number, s, mut parts: [&mut [f64]; D]| {
        for (k, cell) in cells[number].iter().enumerate().filter(|(k, _)| s.start + k > 0) {
            for (a, part) in parts.iter_mut().enumerate() {
                if !cell.is_unknown[a] || cell.face_mass[a] > 0.0 {
                    if !liquid.contains(&(s.start + k)) {
                        part[k] = value(at(s.start + k), a);
                    }
                    continue;
                }
                let near = cell.next.iter().flatten().map(|n| *n as usize);
                let known = near.filter(|n| operator.cell(*n).face_mass[a] > 0.0);
                let (sum, known) = known.fold((0.0, 0.0), |(s, c), n| (s + value(at(n), a), c + 1.0));
                part[k] = sum / f64::max(known, 1.0);
            }
        }
    });
    x
}
