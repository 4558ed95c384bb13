//! Pressure projection: one solve that makes the velocity divergence-free.
//!
//! The unknown is the pressure impulse `λ = p h / ρ` (m²/s) in the liquid cells. At the interface, a fraction θ of a cell from the
//! centre of the liquid cell, `λ_I = γ κ h/ρ` (ghost fluid: Gibou et al. 2002; Enright et al. 2003). For a liquid cell `i`
//! `Σ (λ_i − λ_j) + Σ (λ_i − λ_I)/θ = −Δ Σ ± u*`, which is symmetric and positive definite wherever a component has a free surface.
//! Viscosity acts on the resulting velocity. A second solve of a few iterations removes the divergence that viscosity leaves, and with
//! the corrections from the first solution ([`second_order_corrections`]) makes the velocity at the interface as accurate as inside.

use super::viscosity::Diffusion;
use crate::collision::solid_response::SolidResponse;
use crate::contact_line::friction::DraggedFace;
use crate::coupling::impulses::CouplingImpulses;
use crate::coupling::pressure::{PressureCoupling, WettedSurface, wetted_surfaces};
use crate::free_surface::interface_faces::InterfaceFace;
use crate::model::Model;
use crate::model::time_step::PhaseEnd;
use crate::solid::{SolidState, Solids};
use crate::state::State;
use meniscus_numerics::grid::{
    Band, CellField, CutCells, FaceField, Runs, Segment, gather_segments, swap_segments,
};
use meniscus_numerics::linalg::{
    CoupledBodies, MultigridBackend, PoissonInput, PreparedPressureSystem, PressureBackend, PressureSystem,
    SolveError, SolveLimits, SolveReport,
};
use meniscus_numerics::{Vector, par};
use std::collections::{BTreeMap, BTreeSet};
use std::iter::zip;

/// Dense memory of the solve, kept from step to step.
pub struct PressureFields<const D: usize> {
    assembled: AssembledFields<D>,
    /// λ in the liquid after the first solve of the last Newton iteration, from which that of the next one starts. During
    /// a projection with a warm start it holds the initial guess of the second solve until that begins.
    first_solution: Vec<f64>,
    /// The solver, with its memory.
    backend: Box<dyn PressureBackend<D>>,
}

/// Coefficients of the pressure system by cell, as the projection assembles them.
struct AssembledFields<const D: usize> {
    /// Sum of the coefficients toward known values.
    dirichlet: CellField<D>,
    /// Right-hand side, m²/s.
    rhs: CellField<D>,
}

/// The fields of a state that a projection needs.
pub struct Projection<'a, const D: usize> {
    /// Velocity, m/s.
    pub velocity: &'a mut FaceField<D>,
    /// λ, m²/s: initial guess and solution.
    pub pressure_impulse: &'a mut CellField<D>,
    /// Signed distance, m.
    pub phi: &'a CellField<D>,
    /// The cells of the narrow band.
    pub band: &'a Band<D>,
    /// The liquid cells.
    pub liquid: &'a Runs,
    /// Their faces.
    pub liquid_faces: &'a [Vec<Segment>; D],
    /// Those of them at the interface.
    pub interface_faces: &'a [InterfaceFace],
    /// Those of them that contact lines drag.
    pub dragged_faces: &'a mut [DraggedFace],
    /// Open fractions beside solids.
    pub cut_cells: &'a mut CutCells<D>,
    /// The solids.
    pub solids: &'a [SolidState<D>],
    /// Surfaces of the solids in liquid cells.
    pub wetted_surfaces: &'a [WettedSurface<D>],
    /// Component of a liquid cell.
    pub label: &'a (dyn Fn(usize) -> Option<u32> + Sync),
    /// Tension impulse `γ h / (ρ Δ)`, m²/s: times a curvature in 1/cells it is λ at the interface.
    pub tension_impulse: f64,
    /// Time for which viscosity acts, s.
    pub impulse_time: f64,
}

/// Options of a projection.
#[derive(Clone, Copy, Debug)]
pub struct ProjectionOptions {
    /// Whether the previous Newton iteration has left its pressures as initial guesses.
    pub warm_start: bool,
    /// Relative residual of the solves.
    pub tolerance: f64,
}

/// The linear solves for the velocity of the liquid in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlowSolves {
    /// The pressure solves: one for the forces, and a short one for viscosity and the second-order correction at the interface.
    pub pressure: [SolveReport; 2],
    /// The solve of the implicit viscous step.
    pub viscosity: SolveReport,
}

/// Results of a projection other than the velocity.
pub struct ProjectionResult<const D: usize> {
    /// All solves.
    pub solves: FlowSolves,
    /// Impulses of the pressure on the solids.
    pub pressure_impulses: CouplingImpulses<D>,
    /// Velocity changes of the solids' nodes, m/s; empty without a response.
    pub node_velocity_change: Vec<Vector<D>>,
}

impl<const D: usize> PressureFields<D> {
    /// Memory for a grid. The solver is chosen here.
    pub fn new(model: &Model<D>) -> Self {
        let zero = || CellField::new(model.grid, 0.0);
        let assembled = AssembledFields { dirichlet: zero(), rhs: zero() };
        Self { assembled, first_solution: Vec::new(), backend: Box::new(MultigridBackend::default()) }
    }

    /// Makes the velocity divergence-free in the liquid, coupled to solids with a `response`. The gradient of the first solution gives
    /// viscosity, [`second_order_corrections`] and the off-centre pressure on the solids. (With the gradient of the previous Newton
    /// iteration instead of a first solve, Newton's method does not converge where liquid fills slits.)
    ///
    /// # Errors
    /// Those of the solver.
    pub fn project(
        &mut self,
        model: &Model<D>,
        p: &mut Projection<'_, D>,
        response: Option<&SolidResponse<D>>,
        ProjectionOptions { warm_start, tolerance }: ProjectionOptions,
        phase_end: PhaseEnd<'_>,
    ) -> Result<ProjectionResult<D>, SolveError> {
        apply_line_drag(p);
        let coupling = PressureCoupling::new(model, p.wetted_surfaces, p.solids, response);
        let compliance = coupling.compliance();
        let mut nodes = NodeMotion::default();
        nodes.respond(response, impulses_without_pressure(model, p, response, &[], None));
        let Self { assembled, first_solution, backend } = self;
        assembled.assemble(model, p, &coupling, &nodes.velocity_change);
        let mut system = assembled.prepare(backend.as_mut(), model, p, compliance.as_ref())?;
        let limits = SolveLimits { tolerance, max_iterations: model.numerics.max_iterations };
        let mut solves = FlowSolves::default();
        let (row, cells) = (model.grid.cells[0], p.liquid.segments());
        if warm_start {
            swap_segments(&mut p.pressure_impulse.data, row, &cells, first_solution);
        }
        solves.pressure[0] = system.solve(&assembled.rhs, p.pressure_impulse, limits)?;
        solves.pressure[1].residual = solves.pressure[0].residual;
        let corrections = second_order_corrections(model, p);
        let off_center_impulses =
            coupling.off_center_impulses(|cell| pressure_gradient(model, p, cell), p.label);
        let viscous = model.kinematic_viscosity > 0.0;
        if viscous {
            phase_end("pressure");
            solves.viscosity = apply_viscosity(model, p, &corrections)?;
            phase_end("viscosity");
        }
        if viscous || !off_center_impulses.is_empty() || corrections.iter().any(|b| *b != 0.0) {
            let more = Some(&off_center_impulses);
            nodes.respond(response, impulses_without_pressure(model, p, response, &corrections, more));
            assembled.assemble(model, p, &coupling, &nodes.velocity_change);
            zip(p.interface_faces, &corrections).for_each(|(face, bend)| {
                assembled.rhs.data[face.cell] += face.open_fraction * face.mobility * bend
            });
            match (warm_start, response) {
                (true, _) => swap_segments(&mut p.pressure_impulse.data, row, &cells, first_solution),
                (false, Some(_)) => *first_solution = gather_segments(&p.pressure_impulse.data, row, &cells),
                (false, None) => {}
            }
            solves.pressure[1] = system.solve(&assembled.rhs, p.pressure_impulse, limits)?;
        }
        let mut pressure_impulses = coupling.impulses(&p.pressure_impulse.data, p.label);
        pressure_impulses.extend(&off_center_impulses);
        apply_pressure_gradient(model, p, &corrections, 1.0);
        if let Some(response) = response {
            let mut node_impulses = coupling.node_impulses(&p.pressure_impulse.data);
            response.solve(&mut node_impulses);
            zip(&mut nodes.velocity_change, &node_impulses).for_each(|(c, by)| *c += by);
            let velocity = &mut *p.velocity;
            response.update_tied_faces(p.dragged_faces, &nodes.velocity_change, |f, by| {
                velocity.axes[f.axis][f.face] += by
            });
        }
        Ok(ProjectionResult { solves, pressure_impulses, node_velocity_change: nodes.velocity_change })
    }
}

impl<const D: usize> AssembledFields<D> {
    /// Prepares the system. Dragged faces have a smaller coefficient. The lumped compliance of the solids is added to the Dirichlet
    /// coefficients; the system subtracts it again.
    fn prepare<'a>(
        &mut self,
        backend: &'a mut dyn PressureBackend<D>,
        model: &Model<D>,
        p: &mut Projection<'_, D>,
        bodies: Option<&'a CoupledBodies<'a>>,
    ) -> Result<Box<dyn PreparedPressureSystem<D> + 'a>, SolveError> {
        for (flow, porous) in bodies.iter().flat_map(|body| zip(&body.flux_rows, &body.lumped_compliance)) {
            self.dirichlet.data[flow.0 as usize] += porous;
        }
        let open = &mut p.cut_cells.open_fraction.axes;
        let whole: Vec<f64> = p.dragged_faces.iter().map(|f| open[f.axis][f.face]).collect();
        p.dragged_faces.iter().for_each(|f| open[f.axis][f.face] *= f.mobility());
        let matrix = PoissonInput {
            grid: model.grid,
            unknowns: p.liquid,
            coefficients: &p.cut_cells.open_fraction,
            dirichlet: &self.dirichlet,
        };
        let system = backend.prepare(&PressureSystem { matrix, bodies });
        let open = &mut p.cut_cells.open_fraction.axes;
        zip(p.dragged_faces.iter(), whole).for_each(|(f, whole)| open[f.axis][f.face] = whole);
        system
    }

    /// Assembles the system for the velocities of the solids, with those of the nodes changed by `change`.
    fn assemble(
        &mut self,
        model: &Model<D>,
        p: &Projection<'_, D>,
        coupling: &PressureCoupling<'_, D>,
        change: &[Vector<D>],
    ) {
        let lattice = model.grid.lattice();
        let segments = p.liquid.segments();
        let row = lattice.extent[0];
        let solids = !p.cut_cells.cells.is_empty();
        par::for_each_segment(&mut self.dirichlet.data, row, &segments, |_, part| part.fill(0.0));
        par::for_each_segment(&mut self.rhs.data, row, &segments, |s, part| {
            let base = lattice.coordinates(s.row * row + s.start);
            part.fill(0.0);
            for a in 0..D {
                let faces = model.grid.face_lattice(a);
                let lower = faces.index(base);
                let values = &p.velocity.axes[a];
                let open = solids.then_some(&p.cut_cells.open_fraction.axes[a]);
                let flux = |f: usize| open.map_or(values[f], |open| open[f] * values[f]);
                for (i, out) in part.iter_mut().enumerate() {
                    *out -= model.grid.dx * (flux(lower + i + faces.stride[a]) - flux(lower + i));
                }
            }
        });
        for face in p.interface_faces {
            let weight = face.open_fraction * face.mobility / face.theta;
            self.dirichlet.data[face.cell] += weight;
            self.rhs.data[face.cell] += weight * p.tension_impulse * face.kappa;
        }
        coupling.for_each_flux(|cell, flux| self.rhs.data[cell] -= model.grid.dx * flux);
        coupling.for_each_node_flux(change, |cell, flux| self.rhs.data[cell] -= model.grid.dx * flux);
    }
}

/// Lets viscosity act on the velocity after the forces, and adds its change to the velocity before them.
///
/// Before the forces it would not damp their effect: motions that viscosity damps in a few steps would respond `1 + ν k² h` times too
/// fast, and ripples of five cells would grow on drops at rest (u_rms 0.04).
fn apply_viscosity<const D: usize>(
    model: &Model<D>,
    p: &mut Projection<'_, D>,
    corrections: &[f64],
) -> Result<SolveReport, SolveError> {
    apply_pressure_gradient(model, p, corrections, 1.0);
    let before: Vec<f64> = p.dragged_faces.iter().map(|f| p.velocity.axes[f.axis][f.face]).collect();
    let mut diffusion = Diffusion {
        velocity: p.velocity,
        phi: p.phi,
        band: p.band,
        liquid: p.liquid,
        liquid_faces: p.liquid_faces,
        cut_cells: p.cut_cells,
    };
    let report = diffusion.advance(model, p.impulse_time)?;
    scale_by_mobility(p, before);
    apply_pressure_gradient(model, p, corrections, -1.0);
    Ok(report)
}

/// Scales the change of velocity on dragged faces since `before` by their mobility.
fn scale_by_mobility<const D: usize>(p: &mut Projection<'_, D>, before: Vec<f64>) {
    for (f, before) in zip(p.dragged_faces.iter(), before) {
        let u = &mut p.velocity.axes[f.axis][f.face];
        *u = before + f.mobility() * (*u - before);
    }
}

/// Motion of the solids' nodes without the pressure of the cells; empty without a response.
#[derive(Default)]
struct NodeMotion<const D: usize> {
    /// Impulses on the nodes, N s.
    impulses: Vec<Vector<D>>,
    /// Velocity changes due to them, m/s.
    velocity_change: Vec<Vector<D>>,
}

impl<const D: usize> NodeMotion<D> {
    /// Sets the impulses, and solves for the velocity changes if they differ from the last ones.
    fn respond(&mut self, response: Option<&SolidResponse<D>>, impulses: Vec<Vector<D>>) {
        if let Some(response) = response.filter(|_| impulses != self.impulses) {
            self.velocity_change = response.velocity_change(impulses.clone());
            self.impulses = impulses;
        }
    }
}

/// Impulses on the nodes without the pressure of the cells, N s; `more` are further impulses on the solids.
fn impulses_without_pressure<const D: usize>(
    model: &Model<D>,
    p: &Projection<'_, D>,
    response: Option<&SolidResponse<D>>,
    corrections: &[f64],
    more: Option<&CouplingImpulses<D>>,
) -> Vec<Vector<D>> {
    let Some(response) = response else { return Vec::new() };
    let more = more.map(|more| response.node_impulses(model, p.solids, more));
    let velocity = |f: &DraggedFace| p.velocity.axes[f.axis][f.face];
    response.impulses_without_pressure(
        model,
        p.dragged_faces,
        velocity,
        tension_velocity_change(model, p, corrections),
        more,
    )
}

/// Velocity, m/s, that surface tension and `corrections` take from dragged interface faces, times their volumes in cells, by axis and face.
fn tension_velocity_change<const D: usize>(
    model: &Model<D>,
    p: &Projection<'_, D>,
    corrections: &[f64],
) -> BTreeMap<(usize, usize), f64> {
    let push = |(k, c): (usize, &InterfaceFace)| {
        let bend = corrections.get(k).copied().unwrap_or(0.0);
        (
            (c.axis, c.face),
            c.open_fraction * c.sign * (p.tension_impulse * c.kappa + c.theta * bend) / model.grid.dx,
        )
    };
    let dragged: BTreeSet<_> = p.dragged_faces.iter().map(|f| (f.axis, f.face)).collect();
    let is_dragged = |(_, c): &(usize, &InterfaceFace)| dragged.contains(&(c.axis, c.face));
    p.interface_faces.iter().enumerate().filter(is_dragged).map(push).collect()
}

/// Applies the drag of the contact lines to the velocity, before the pressure acts.
fn apply_line_drag<const D: usize>(p: &mut Projection<'_, D>) {
    for f in p.dragged_faces.iter() {
        let u = &mut p.velocity.axes[f.axis][f.face];
        *u = f.dragged_velocity(*u);
    }
}

/// Gradient of λ per cell in a liquid cell: along each axis the mean over the open faces to other liquid cells.
fn pressure_gradient<const D: usize>(model: &Model<D>, p: &Projection<'_, D>, cell: usize) -> Vector<D> {
    let lattice = model.grid.lattice();
    let at = lattice.coordinates(cell);
    Vector::from_fn(|a, _| {
        let face = model.grid.face_lattice(a).index(at);
        let open = |up: usize| {
            p.cut_cells.open_fraction.axes[a][face + up * model.grid.face_lattice(a).stride[a]] > 0.0
        };
        let (mut sum, mut count) = (0.0, 0.0);
        if at[a] > 0 && open(0) && p.phi.data[cell - lattice.stride[a]] < 0.0 {
            (sum, count) =
                (p.pressure_impulse.data[cell] - p.pressure_impulse.data[cell - lattice.stride[a]], 1.0);
        }
        if at[a] + 1 < lattice.extent[a] && open(1) && p.phi.data[cell + lattice.stride[a]] < 0.0 {
            sum += p.pressure_impulse.data[cell + lattice.stride[a]] - p.pressure_impulse.data[cell];
            count += 1.0;
        }
        if count > 0.0 { sum / count } else { 0.0 }
    })
}

/// Correction of the ghost-fluid gradient of λ on each interface face, times Δ. That gradient is centred `θ/2`
/// from the centre of the liquid cell, but the face lies at 1/2. Without the correction waves are slower by
/// `θ (1 − θ) (kΔ)²/4`: by `(kΔ)²/16` at most and `(kΔ)²/24` in the mean over θ.
fn second_order_corrections<const D: usize>(model: &Model<D>, p: &Projection<'_, D>) -> Vec<f64> {
    let lattice = model.grid.lattice();
    let bend = |f: &InterfaceFace| {
        let at = lattice.coordinates(f.cell)[f.axis];
        let room = if f.sign > 0.0 { at } else { lattice.extent[f.axis] - 1 - at };
        if room < 2 {
            return 0.0;
        }
        let inward = |n: usize| {
            let step = n * lattice.stride[f.axis];
            if f.sign > 0.0 { f.cell - step } else { f.cell + step }
        };
        let faces = model.grid.face_lattice(f.axis).stride[f.axis];
        let behind = |n: usize| if f.sign > 0.0 { f.face - n * faces } else { f.face + n * faces };
        let liquid =
            |n: usize| p.phi.data[inward(n)] < 0.0 && p.cut_cells.open_fraction.axes[f.axis][behind(n)] > 0.0;
        if !liquid(1) || !liquid(2) {
            return 0.0;
        }
        let lambda = |n: usize| p.pressure_impulse.data[inward(n)];
        0.5 * (1.0 - f.theta) * (lambda(0) - 2.0 * lambda(1) + lambda(2))
    };
    par::map_slice(p.interface_faces, 256, bend)
}

/// Adds `sign` times the velocity change by the pressure, `−∇λ`, on the liquid's faces.
fn apply_pressure_gradient<const D: usize>(
    model: &Model<D>,
    p: &mut Projection<'_, D>,
    corrections: &[f64],
    sign: f64,
) {
    let cells = model.grid.lattice();
    let before: Vec<f64> = p.dragged_faces.iter().map(|f| p.velocity.axes[f.axis][f.face]).collect();
    let (lambda, phi) = (&p.pressure_impulse.data, &p.phi.data);
    for a in 0..D {
        let lattice = model.grid.face_lattice(a);
        let open = (!p.cut_cells.cells.is_empty()).then_some(&p.cut_cells.open_fraction.axes[a]);
        par::for_each_segment(&mut p.velocity.axes[a], lattice.extent[0], &p.liquid_faces[a], |s, part| {
            let mut at = lattice.coordinates(s.row * lattice.extent[0]);
            for (i, u) in part.iter_mut().enumerate() {
                at[0] = s.start + i;
                let shut = open.is_some_and(|open| open[lattice.index(at)] == 0.0);
                if at[a] == 0 || at[a] == cells.extent[a] || shut {
                    continue;
                }
                let upper = cells.index(at);
                let lower = upper - cells.stride[a];
                if phi[upper] < 0.0 && phi[lower] < 0.0 {
                    *u -= sign * (lambda[upper] - lambda[lower]) / model.grid.dx;
                }
            }
        });
    }
    for (face, bend) in zip(p.interface_faces, corrections) {
        let slope =
            ((p.tension_impulse * face.kappa - lambda[face.cell]) / face.theta + bend) / model.grid.dx;
        p.velocity.axes[face.axis][face.face] -= sign * face.sign * slope;
    }
    scale_by_mobility(p, before);
}

/// Largest divergence in a liquid cell, 1/s, with the fluxes through open faces and into moving solids.
pub fn divergence_max<const D: usize>(
    solids: Solids<'_, D>,
    state: &State<D>,
    liquid: &Runs,
    cut_cells: &CutCells<D>,
) -> f64 {
    let model = solids.model;
    let lattice = model.grid.lattice();
    let mut fluxes = BTreeMap::new();
    let wet = wetted_surfaces(solids, cut_cells, &state.phi.data);
    PressureCoupling::new(model, &wet, &state.solids, None).for_each_flux(|cell, flux| {
        fluxes.insert(cell, flux);
    });
    let worst = |s: &Segment| {
        let base = lattice.coordinates(s.row * lattice.extent[0] + s.start);
        let mut sum = vec![0.0; s.end - s.start];
        for a in 0..D {
            let faces = model.grid.face_lattice(a);
            let lower = faces.index(base);
            let (values, open) = (&state.velocity.axes[a], &cut_cells.open_fraction.axes[a]);
            let flux = |f: usize| if fluxes.is_empty() { values[f] } else { open[f] * values[f] };
            for (i, out) in sum.iter_mut().enumerate() {
                *out += flux(lower + i + faces.stride[a]) - flux(lower + i);
            }
        }
        let first = lattice.index(base);
        fluxes.range(first..first + sum.len()).for_each(|(cell, flux)| sum[cell - first] += flux);
        sum.iter().fold(0.0f64, |m, v| m.max(v.abs()))
    };
    let segments = liquid.segments();
    par::reduce(segments.len(), 1, 0.0, |i| worst(&segments[i]), f64::max) / model.grid.dx
}

#[cfg(test)]
#[path = "pressure_tests.rs"]
mod tests;
