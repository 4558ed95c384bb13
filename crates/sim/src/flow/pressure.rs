//! Pressure: the one solve that makes the velocity free of divergence.
//!
//! Unknown: `λ = p h / ρ` (m²/s) in the liquid cells. At the surface, a fraction θ of a cell from the liquid's centre,
//! `p = γ κ` (ghost fluid: Gibou et al. 2002; Enright et al. 2003). For a liquid cell
//! `Σ (λ_i − λ_j) + Σ (λ_i − λ_I)/θ = −Δ Σ ± u*`, which is symmetric and positive definite wherever a component has
//! a free surface. Viscosity acts on the velocity that this makes; a second solve takes out the divergence that it leaves,
//! and with what the first one's bend adds to the slopes at the surface ([`bends`]) makes the velocity there as accurate as
//! it is inside. It takes a few iterations.

use super::viscosity::Diffusion;
use crate::collision::compliance::Response;
use crate::contact_line::friction::DraggedFace;
use crate::coupling::impulses::Exchange;
use crate::coupling::pressure::{Coupling, Wet, wetted};
use crate::free_surface::interface_faces::CutFace;
use crate::model::Model;
use crate::model::time_step::PhaseEnd;
use crate::solid::SolidState;
use crate::state::State;
use meniscus_numerics::grid::{Band, CellField, CutCells, FaceField, Runs, Segment};
use meniscus_numerics::linalg::{PoissonInput, PressureSolver, SolveError, SolveReport};
use meniscus_numerics::{Vector, par};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::iter::zip;

/// Dense memory of the solve, kept from step to step.
pub struct PressureFields<const D: usize> {
    dirichlet: CellField<D>,
    rhs: CellField<D>,
    /// λ of the first solve of Newton's iteration before.
    first: CellField<D>,
    /// The last solver, for its memory.
    solver: Option<PressureSolver<D>>,
}

/// The part of a state that a projection works on.
pub struct Projection<'a, const D: usize> {
    /// Velocity, m/s.
    pub velocity: &'a mut FaceField<D>,
    /// λ, m²/s: in, a guess; out, the solution.
    pub lambda: &'a mut CellField<D>,
    /// Distance, m.
    pub phi: &'a CellField<D>,
    /// The cells around the surface.
    pub band: &'a Band<D>,
    /// The liquid cells.
    pub liquid: &'a Runs,
    /// Their faces.
    pub faces: &'a [Vec<Segment>; D],
    /// Those at the surface.
    pub cut: &'a [CutFace],
    /// Those that contact lines drag.
    pub dragged: &'a mut [DraggedFace],
    /// What the solids leave open.
    pub cut_cells: &'a mut CutCells<D>,
    /// The solids.
    pub solids: &'a [SolidState<D>],
    /// Their surfaces in liquid cells.
    pub wet: &'a [Wet<D>],
    /// Component of a liquid cell.
    pub label: &'a (dyn Fn(usize) -> Option<u32> + Sync),
    /// The tension term `γ h / (ρ Δ)` (m²/s): times a curvature in 1/cells it is λ at the surface.
    pub jump: f64,
    /// For how long viscosity acts, s.
    pub time: f64,
}

/// How a projection is done.
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    /// Whether Newton's iteration before has left its pressures as guesses.
    pub again: bool,
    /// Relative residual.
    pub tolerance: f64,
}

/// What a projection finds besides the velocity.
pub struct Projected<const D: usize> {
    /// Both solves.
    pub solves: [SolveReport; 2],
    /// What the pressure gives to the solids.
    pub exchange: Exchange<D>,
    /// How much the velocities of the solids' nodes change, m/s; empty without a response.
    pub change: Vec<Vector<D>>,
}

impl<const D: usize> PressureFields<D> {
    /// Memory for a grid.
    pub fn new(model: &Model<D>) -> Self {
        let grid = model.grid;
        let zero = || CellField::new(grid, 0.0);
        Self { dirichlet: zero(), rhs: zero(), first: zero(), solver: None }
    }

    /// Makes the velocity free of divergence in the liquid, as solids with a `response` give way. From the slopes of the first
    /// solve's pressure follow viscosity, [`bends`] and the pressure on the solids' surfaces. (Slopes of the pressure of Newton's
    /// iteration before, in place of a first solve, do not converge where liquid fills slits.)
    ///
    /// # Errors
    /// What the solver says.
    pub fn project(
        &mut self,
        model: &Model<D>,
        p: &mut Projection<'_, D>,
        response: Option<&Response<D>>,
        Pass { again, tolerance }: Pass,
        phase_end: PhaseEnd<'_>,
    ) -> Result<Projected<D>, SolveError> {
        slow(p);
        let coupling = Coupling::new(model, p.wet, (p.solids, response));
        let compliance = coupling.compliance();
        let start = yields(model, p, response, &[], None);
        self.assemble(model, p, &coupling, &start);
        for (flow, porous) in compliance.iter().flat_map(|body| zip(&body.flows, &body.porous)) {
            self.dirichlet.data[flow.0 as usize] += porous;
        }
        let solver = self.solver(model, p);
        let limits = (tolerance, model.numerics.max_iterations);
        let none = SolveReport { iterations: 0, residual: 0.0 };
        let mut solves = [none; 2];
        if again {
            std::mem::swap(p.lambda, &mut self.first);
        }
        solves[0] = solver.solve_coupled(compliance.as_ref(), &self.rhs, p.lambda, limits)?;
        solves[1].residual = solves[0].residual;
        let bends = bends(model, p);
        let beyond = coupling.beyond_centers(|cell| slope(model, p, cell), p.label);
        let viscous = model.kinematic_viscosity > 0.0;
        if viscous {
            phase_end("pressure");
            diffuse(model, p, &bends)?;
            phase_end("viscosity");
        }
        let mut change = start;
        if viscous || !beyond.is_empty() || bends.iter().any(|b| *b != 0.0) {
            change = yields(model, p, response, &bends, Some(&beyond));
            self.assemble(model, p, &coupling, &change);
            zip(p.cut, &bends)
                .for_each(|(face, bend)| self.rhs.data[face.cell] += face.open * face.mobility * bend);
            match (again, response) {
                (true, _) => std::mem::swap(p.lambda, &mut self.first),
                (false, Some(_)) => self.first.data.clone_from(&p.lambda.data),
                (false, None) => {}
            }
            solves[1] = solver.solve_coupled(compliance.as_ref(), &self.rhs, p.lambda, limits)?;
        }
        self.solver = Some(solver);
        let mut exchange = coupling.impulses(&p.lambda.data, p.label);
        exchange.extend(&beyond);
        accelerate(model, p, &bends, 1.0);
        if let Some(response) = response {
            let mut pressed = coupling.pushed_nodes(&p.lambda.data);
            response.solve(&mut pressed);
            change.iter_mut().zip(&pressed).for_each(|(c, by)| *c += by);
            let velocity = &mut *p.velocity;
            response.carry(p.dragged, &change, |f, by| velocity.axes[f.axis][f.face] += by);
        }
        Ok(Projected { solves, exchange, change })
    }

    /// The system made ready; faces that are dragged give way less.
    fn solver(&mut self, model: &Model<D>, p: &mut Projection<'_, D>) -> PressureSolver<D> {
        let open = &mut p.cut_cells.open.axes;
        let whole: Vec<f64> = p.dragged.iter().map(|f| open[f.axis][f.face]).collect();
        p.dragged.iter().for_each(|f| open[f.axis][f.face] *= f.mobility());
        let input = PoissonInput {
            grid: model.grid,
            unknowns: p.liquid,
            coefficients: &p.cut_cells.open,
            dirichlet: &self.dirichlet,
        };
        let solver = PressureSolver::in_memory_of(self.solver.take(), &input);
        let open = &mut p.cut_cells.open.axes;
        zip(p.dragged.iter(), whole).for_each(|(f, whole)| open[f.axis][f.face] = whole);
        solver
    }

    /// The system for the solids' velocities, changed by `change` of their nodes.
    fn assemble(
        &mut self,
        model: &Model<D>,
        p: &Projection<'_, D>,
        coupling: &Coupling<'_, D>,
        change: &[Vector<D>],
    ) {
        let lattice = model.grid.lattice();
        let segments = p.liquid.segments();
        let row = lattice.extent[0];
        let solids = !p.cut_cells.wet.is_empty();
        par::for_each_segment(&mut self.dirichlet.data, row, &segments, |_, part| part.fill(0.0));
        par::for_each_segment(&mut self.rhs.data, row, &segments, |s, part| {
            let base = lattice.coordinates(s.row * row + s.start);
            part.fill(0.0);
            for a in 0..D {
                let faces = model.grid.faces(a);
                let lower = faces.index(base);
                let values = &p.velocity.axes[a];
                let open = solids.then_some(&p.cut_cells.open.axes[a]);
                let flux = |f: usize| open.map_or(values[f], |open| open[f] * values[f]);
                for (i, out) in part.iter_mut().enumerate() {
                    *out -= model.grid.dx * (flux(lower + i + faces.stride[a]) - flux(lower + i));
                }
            }
        });
        for face in p.cut {
            let weight = face.open * face.mobility / face.theta;
            self.dirichlet.data[face.cell] += weight;
            self.rhs.data[face.cell] += weight * p.jump * face.kappa;
        }
        coupling.fluxes(|cell, flux| self.rhs.data[cell] -= model.grid.dx * flux);
        coupling.fluxes_of_nodes(change, |cell, flux| self.rhs.data[cell] -= model.grid.dx * flux);
    }
}

/// Lets viscosity act on the velocity that the forces have made, and adds what it changes to the velocity before them.
///
/// Before the forces it would leave them alone: what viscosity slows in a few steps would yield to them `1 + ν k² h` times
/// too fast, and of drops at rest ripples of five cells would grow (u_rms 0.04).
fn diffuse<const D: usize>(
    model: &Model<D>,
    p: &mut Projection<'_, D>,
    bends: &[f64],
) -> Result<(), SolveError> {
    accelerate(model, p, bends, 1.0);
    let before: Vec<f64> = p.dragged.iter().map(|f| p.velocity.axes[f.axis][f.face]).collect();
    let mut diffusion = Diffusion {
        velocity: p.velocity,
        phi: p.phi,
        band: p.band,
        liquid: p.liquid,
        faces: p.faces,
        solids: p.cut_cells,
    };
    diffusion.advance(model, p.time)?;
    give_way(p, before);
    accelerate(model, p, bends, -1.0);
    Ok(())
}

/// Of what has changed on dragged faces since `before` the drag leaves a part.
fn give_way<const D: usize>(p: &mut Projection<'_, D>, before: Vec<f64>) {
    for (f, before) in zip(p.dragged.iter(), before) {
        let u = &mut p.velocity.axes[f.axis][f.face];
        *u = before + f.mobility() * (*u - before);
    }
}

/// The change of the nodes' velocities without the pressure of the cells; `more` acts on the solids besides.
fn yields<const D: usize>(
    model: &Model<D>,
    p: &Projection<'_, D>,
    response: Option<&Response<D>>,
    bends: &[f64],
    more: Option<&Exchange<D>>,
) -> Vec<Vector<D>> {
    let Some(response) = response else { return Vec::new() };
    let more = more.map(|more| response.impulses(model, p.solids, more));
    let velocity = |f: &DraggedFace| p.velocity.axes[f.axis][f.face];
    response.yields(model, p.dragged, velocity, tension(model, p, bends), more)
}

/// What the surface's tension and `bends` push cut faces with, m/s, by axis and face.
fn tension<const D: usize>(
    model: &Model<D>,
    p: &Projection<'_, D>,
    bends: &[f64],
) -> BTreeMap<(usize, usize), f64> {
    let push = |(k, c): (usize, &CutFace)| {
        let bend = bends.get(k).copied().unwrap_or(0.0);
        ((c.axis, c.face), c.open * c.sign * (p.jump * c.kappa + c.theta * bend) / model.grid.dx)
    };
    p.cut.iter().enumerate().map(push).collect()
}

/// The velocity of dragged faces before the pressure pushes them.
fn slow<const D: usize>(p: &mut Projection<'_, D>) {
    for f in p.dragged.iter() {
        let u = &mut p.velocity.axes[f.axis][f.face];
        *u = f.slowed(*u);
    }
}

/// Slope of λ in a liquid cell, a cell: along each axis the mean over the open faces to other liquid cells.
fn slope<const D: usize>(model: &Model<D>, p: &Projection<'_, D>, cell: usize) -> Vector<D> {
    let lattice = model.grid.lattice();
    let at = lattice.coordinates(cell);
    Vector::from_fn(|a, _| {
        let face = model.grid.faces(a).index(at);
        let open = |up: usize| p.cut_cells.open.axes[a][face + up * model.grid.faces(a).stride[a]] > 0.0;
        let (mut sum, mut count) = (0.0, 0.0);
        if at[a] > 0 && open(0) && p.phi.data[cell - lattice.stride[a]] < 0.0 {
            (sum, count) = (p.lambda.data[cell] - p.lambda.data[cell - lattice.stride[a]], 1.0);
        }
        if at[a] + 1 < lattice.extent[a] && open(1) && p.phi.data[cell + lattice.stride[a]] < 0.0 {
            sum += p.lambda.data[cell + lattice.stride[a]] - p.lambda.data[cell];
            count += 1.0;
        }
        if count > 0.0 { sum / count } else { 0.0 }
    })
}

/// What the ghost fluid's slope of λ misses on each cut face, times Δ: it is the slope half-way to the surface, `θ/2` from
/// the liquid's centre, where the face lies at one half. Left out it makes waves slower by up to `(kΔ)²/24`.
fn bends<const D: usize>(model: &Model<D>, p: &Projection<'_, D>) -> Vec<f64> {
    let lattice = model.grid.lattice();
    let bend = |f: &CutFace| {
        let at = lattice.coordinates(f.cell)[f.axis];
        let room = if f.sign > 0.0 { at } else { lattice.extent[f.axis] - 1 - at };
        if room < 2 {
            return 0.0;
        }
        let inward = |n: usize| {
            let step = n * lattice.stride[f.axis];
            if f.sign > 0.0 { f.cell - step } else { f.cell + step }
        };
        let faces = model.grid.faces(f.axis).stride[f.axis];
        let behind = |n: usize| if f.sign > 0.0 { f.face - n * faces } else { f.face + n * faces };
        let liquid = |n: usize| p.phi.data[inward(n)] < 0.0 && p.cut_cells.open.axes[f.axis][behind(n)] > 0.0;
        if !liquid(1) || !liquid(2) {
            return 0.0;
        }
        let lambda = |n: usize| p.lambda.data[inward(n)];
        0.5 * (1.0 - f.theta) * (lambda(0) - 2.0 * lambda(1) + lambda(2))
    };
    p.cut.par_iter().map(bend).collect()
}

/// Adds `sign` times what the pressure does to the velocity: minus its gradient on the liquid's faces.
fn accelerate<const D: usize>(model: &Model<D>, p: &mut Projection<'_, D>, bends: &[f64], sign: f64) {
    let cells = model.grid.lattice();
    let before: Vec<f64> = p.dragged.iter().map(|f| p.velocity.axes[f.axis][f.face]).collect();
    let (lambda, phi) = (&p.lambda.data, &p.phi.data);
    for a in 0..D {
        let lattice = model.grid.faces(a);
        let open = (!p.cut_cells.wet.is_empty()).then_some(&p.cut_cells.open.axes[a]);
        par::for_each_segment(&mut p.velocity.axes[a], lattice.extent[0], &p.faces[a], |s, part| {
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
    for (face, bend) in zip(p.cut, bends) {
        let slope = ((p.jump * face.kappa - lambda[face.cell]) / face.theta + bend) / model.grid.dx;
        p.velocity.axes[face.axis][face.face] -= sign * face.sign * slope;
    }
    give_way(p, before);
}

/// Largest divergence in a liquid cell, 1/s: of what flows through open faces and into moving solids.
pub fn divergence_max<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    liquid: &Runs,
    cut: &CutCells<D>,
) -> f64 {
    let lattice = model.grid.lattice();
    let mut fluxes = BTreeMap::new();
    let wet = wetted(model, cut, &state.solids, &state.phi.data);
    Coupling::new(model, &wet, (&state.solids, None)).fluxes(|cell, flux| {
        fluxes.insert(cell, flux);
    });
    let worst = |s: &Segment| {
        let base = lattice.coordinates(s.row * lattice.extent[0] + s.start);
        let mut sum = vec![0.0; s.end - s.start];
        for a in 0..D {
            let faces = model.grid.faces(a);
            let lower = faces.index(base);
            let (values, open) = (&state.velocity.axes[a], &cut.open.axes[a]);
            let flux = |f: usize| if fluxes.is_empty() { values[f] } else { open[f] * values[f] };
            for (i, out) in sum.iter_mut().enumerate() {
                *out += flux(lower + i + faces.stride[a]) - flux(lower + i);
            }
        }
        let first = lattice.index(base);
        fluxes.range(first..first + sum.len()).for_each(|(cell, flux)| sum[cell - first] += flux);
        sum.iter().fold(0.0f64, |m, v| m.max(v.abs()))
    };
    liquid.segments().par_iter().map(worst).reduce(|| 0.0, f64::max) / model.grid.dx
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_surface::curvature::Curvature;
    use crate::free_surface::interface_faces::cut_faces;
    use crate::model::resolution::BAND;
    use crate::model::{Numerics, Wall};
    use crate::simulation::workspace::Workspace;
    use meniscus_numerics::Vector;
    use meniscus_numerics::grid::Grid;
    use std::f64::consts::PI;

    /// A potential without flow through the walls.
    fn potential<const D: usize>(x: &Vector<D>) -> f64 {
        (PI * x[0]).cos() * (PI * x[D - 1]).cosh()
    }

    /// Velocity (rms) that is left on the cut faces of a potential flow under a sloping surface, with that potential on it.
    fn left_over<const D: usize>(cells: usize) -> f64 {
        let model = Model {
            grid: Grid::<D>::new([cells; D], 1.0 / cells as f64),
            walls: [[Wall::Slip; 2]; D],
            density: 1.0,
            kinematic_viscosity: 0.0,
            surface_tension: 1.0,
            gravity: Vector::zeros(),
            solids: Vec::new(),
            numerics: Numerics { tolerance: 1e-11, ..Numerics::default() },
        };
        let grid = model.grid;
        let mut state = State::empty(grid);
        let limit = BAND * grid.dx;
        for i in 0..grid.lattice().len() {
            let x = grid.center(grid.lattice().coordinates(i));
            let height = x[D - 1] - 0.613 - 0.11 * x[0] - 0.05 * x[0] * x[0];
            state.phi.data[i] = height.clamp(-limit, limit);
        }
        let mut work = Workspace::new(&model, &mut state);
        let known = Curvature {
            kappa: vec![0.0; work.band.cells.len()],
            known: vec![true; work.band.cells.len()],
            ..Curvature::unknown()
        };
        let mut cut = cut_faces(&model, &state.phi, &work.band, &known, &work.cut);
        for f in &mut cut {
            let mut x = grid.center(grid.lattice().coordinates(f.cell));
            x[f.axis] += f.sign * f.theta * grid.dx;
            f.kappa = potential(&x);
        }
        for a in 0..D {
            let faces = grid.faces(a);
            for s in &work.known.liquid()[a] {
                for f in s.row * faces.extent[0] + s.start..s.row * faces.extent[0] + s.end {
                    let at = faces.coordinates(f);
                    let slope = |x: Vector<D>| {
                        let step = Vector::<D>::from_fn(|b, _| if b == a { 1e-6 } else { 0.0 });
                        (potential(&(x + step)) - potential(&(x - step))) / 2e-6
                    };
                    if !model.closed(a, at[a]) {
                        state.velocity.axes[a][f] = slope(grid.face_center(a, at));
                    }
                }
            }
        }
        let mut projection = Projection {
            velocity: &mut state.velocity,
            lambda: &mut state.lambda,
            phi: &state.phi,
            band: &work.band,
            liquid: &work.liquid,
            faces: work.known.liquid(),
            cut: &cut,
            dragged: &mut [],
            cut_cells: &mut work.cut,
            solids: &[],
            wet: &[],
            jump: 1.0,
            time: 1.0,
            label: &|_| Some(0),
        };
        work.pressure
            .project(&model, &mut projection, None, Pass { again: false, tolerance: 1e-11 }, &mut |_| ())
            .unwrap();
        let square = |f: &CutFace| state.velocity.axes[f.axis][f.face].powi(2);
        (cut.iter().map(square).sum::<f64>() / cut.len() as f64).sqrt()
    }

    #[test]
    fn the_velocity_is_second_order_up_to_the_surface() {
        let order = |coarse: f64, fine: f64, times: f64| (coarse / fine).log2() / times.log2();
        let plane = (left_over::<2>(24), left_over::<2>(96));
        let space = (left_over::<3>(12), left_over::<3>(48));
        assert!(order(plane.0, plane.1, 4.0) > 1.7, "{plane:?}");
        assert!(order(space.0, space.1, 4.0) > 1.7, "{space:?}");
    }
}
