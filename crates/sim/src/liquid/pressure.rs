//! Pressure: the one solve that makes the velocity free of divergence.
//!
//! Unknown: `λ = p h / ρ` (m²/s) in the liquid cells. At the surface, a fraction θ of a cell from the liquid's centre,
//! `p = γ κ` (ghost fluid: Gibou et al. 2002; Enright et al. 2003). For a liquid cell
//! `Σ (λ_i − λ_j) + Σ (λ_i − λ_I)/θ = −Δ Σ ± u*`, which is symmetric and positive definite wherever a component has
//! a free surface. A second solve with what the first one's bend adds to the slopes at the surface ([`bends`]) makes the
//! velocity there as accurate as it is inside; it takes a few iterations.

use super::curvature::Curvature;
use crate::coupling::Coupling;
use crate::line::Exchange;
use crate::model::Model;
use crate::solid::SolidState;
use crate::state::State;
use meniscus_numerics::grid::{Band, CellField, CutCells, FaceField, Runs, Sampler, Segment};
use meniscus_numerics::linalg::{PoissonInput, PressureSolver, SolveError, SolveReport};
use meniscus_numerics::par;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::iter::zip;

/// The surface is kept this share of a cell away from the liquid's centre at least.
const NEAREST: f64 = 0.02;

/// A face between a liquid cell and air, or an open side.
#[derive(Clone, Copy, Debug)]
pub struct CutFace {
    /// Normal axis.
    pub axis: usize,
    /// Position in the face lattice.
    pub face: usize,
    /// The liquid cell.
    pub cell: usize,
    /// +1 where the air is above, −1 where it is below.
    pub sign: f64,
    /// Share of the way from the liquid's centre to the surface.
    pub theta: f64,
    /// Curvature there, 1/cells.
    pub kappa: f64,
    /// Share of the face that no solid closes.
    pub open: f64,
}

/// Finds the faces between liquid and air, with the surface's place (cubic root) and curvature.
pub fn cut_faces<const D: usize>(
    model: &Model<D>,
    phi: &CellField<D>,
    band: &Band<D>,
    liquid: &Runs,
    curvature: &Curvature,
    solids: &CutCells<D>,
) -> Vec<CutFace> {
    let lattice = model.grid.lattice();
    let sampler = Sampler::cells(&model.grid, &phi.data, model.scalar_edges());
    let value = |slot: Option<usize>| {
        slot.filter(|s| curvature.known.get(*s) == Some(&true)).map(|s| curvature.kappa[s])
    };
    let mut faces: Vec<CutFace> = band.cells[band.first_layers(1)]
        .par_iter()
        .filter(|&&c| phi.data[c as usize] < 0.0)
        .flat_map_iter(|&c| {
            let cell = c as usize;
            let at = lattice.coordinates(cell);
            let sampler = &sampler;
            (0..2 * D).filter_map(move |n| {
                let (axis, up) = (n / 2, n % 2);
                let edge = if up == 1 { at[axis] + 1 == lattice.extent[axis] } else { at[axis] == 0 };
                let other = if up == 1 {
                    cell + lattice.stride[axis]
                } else {
                    cell.wrapping_sub(lattice.stride[axis])
                };
                if edge || phi.data[other] < 0.0 {
                    return None;
                }
                let step = if up == 1 { 1 } else { -1 };
                let theta = crossing(sampler, at, axis, step).clamp(NEAREST, 1.0);
                let here = value(band.slot(cell));
                let there = value(band.slot(other));
                let kappa = match (here, there) {
                    (Some(i), Some(a)) => (1.0 - theta) * i + theta * a,
                    (one, other) => one.or(other).unwrap_or(0.0),
                };
                let mut face = at;
                face[axis] += up;
                let face = model.grid.faces(axis).index(face);
                let open = solids.open.axes[axis][face];
                (open > 0.0).then_some(CutFace { axis, face, cell, sign: step as f64, theta, kappa, open })
            })
        })
        .collect();
    open_sides(model, liquid, solids, &mut faces);
    faces
}

/// Liquid cells at open sides: pressure zero on the side itself, half a cell away.
fn open_sides<const D: usize>(
    model: &Model<D>,
    liquid: &Runs,
    solids: &CutCells<D>,
    faces: &mut Vec<CutFace>,
) {
    let lattice = model.grid.lattice();
    for axis in 0..D {
        for side in 0..2 {
            if model.walls[axis][side] == crate::Wall::Slip {
                continue;
            }
            let edge = if side == 0 { 0 } else { lattice.extent[axis] - 1 };
            for run in &liquid.runs {
                let row = run.row as usize * lattice.extent[0];
                let cells = row + run.start as usize..row + run.end as usize;
                for cell in cells {
                    let mut at = lattice.coordinates(cell);
                    if at[axis] != edge {
                        if axis == 0 { continue } else { break }
                    }
                    at[axis] += side;
                    let face = model.grid.faces(axis).index(at);
                    faces.push(CutFace {
                        axis,
                        face,
                        cell,
                        sign: 2.0 * side as f64 - 1.0,
                        theta: 0.5,
                        kappa: 0.0,
                        open: solids.open.axes[axis][face],
                    });
                }
            }
        }
    }
}

/// Share of the way from the centre of liquid cell `at` to its neighbour where the cubic through four values is zero.
fn crossing<const D: usize>(sampler: &Sampler<'_, D>, at: [usize; D], axis: usize, step: isize) -> f64 {
    let value = |n: isize| {
        let mut cell = at.map(|i| i as isize);
        cell[axis] += n * step;
        sampler.value(cell)
    };
    let f = [value(-1), value(0), value(1), value(2)];
    let linear = f[1] / (f[1] - f[2]);
    let cubic = |t: f64| {
        let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
        -t * b * c / 6.0 * f[0] + a * b * c / 2.0 * f[1] - a * t * c / 2.0 * f[2] + a * t * b / 6.0 * f[3]
    };
    // The cubic takes the signs of its ends: regula falsi (Illinois) cannot leave the edge.
    let (mut low, mut high, mut at_low, mut at_high) = (0.0, 1.0, f[1], f[2]);
    let mut t = linear;
    for _ in 0..30 {
        let v = cubic(t);
        if v.abs() <= 1e-13 * (f[2] - f[1]) {
            break;
        }
        if v < 0.0 {
            (low, at_low, at_high) = (t, v, 0.5 * at_high);
        } else {
            (high, at_high, at_low) = (t, v, 0.5 * at_low);
        }
        t = (low * at_high - high * at_low) / (at_high - at_low);
    }
    t
}

/// Dense memory of the solve, kept from step to step.
pub struct PressureFields<const D: usize> {
    dirichlet: CellField<D>,
    rhs: CellField<D>,
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
    /// The liquid cells.
    pub liquid: &'a Runs,
    /// Their faces.
    pub faces: &'a [Vec<Segment>; D],
    /// Those at the surface.
    pub cut: &'a [CutFace],
    /// What the solids leave open.
    pub cut_cells: &'a CutCells<D>,
    /// The solids.
    pub solids: &'a [SolidState<D>],
    /// Component of a liquid cell.
    pub label: &'a (dyn Fn(usize) -> Option<u32> + Sync),
    /// The tension term `γ h / (ρ Δ)` (m²/s): times a curvature in 1/cells it is λ at the surface.
    pub jump: f64,
}

impl<const D: usize> PressureFields<D> {
    /// Memory for a grid.
    pub fn new(model: &Model<D>) -> Self {
        let grid = model.grid;
        let zero = || CellField::new(grid, 0.0);
        Self { dirichlet: zero(), rhs: zero(), solver: None }
    }

    /// Makes the velocity free of divergence in the liquid. Gives back what the pressure gives to the solids, too.
    ///
    /// # Errors
    /// What the solver says.
    pub fn project(
        &mut self,
        model: &Model<D>,
        p: &mut Projection<'_, D>,
    ) -> Result<(SolveReport, Exchange<D>), SolveError> {
        self.assemble(model, p);
        let input = PoissonInput {
            grid: model.grid,
            unknowns: p.liquid,
            coefficients: &p.cut_cells.open,
            dirichlet: &self.dirichlet,
        };
        let n = &model.numerics;
        let solver = PressureSolver::in_memory_of(self.solver.take(), &input);
        let coupling = Coupling::new(model, p.cut_cells, p.solids, &p.phi.data);
        coupling.fluxes(|cell, flux| self.rhs.data[cell] -= model.grid.dx * flux);
        let (columns, limits) = (coupling.columns(), (n.tolerance, n.max_iterations));
        let mut report = solver.solve_coupled(&columns, &self.rhs, p.lambda, limits)?;
        let bends = bends(model, p);
        if bends.iter().any(|b| *b != 0.0) {
            zip(p.cut, &bends).for_each(|(face, bend)| self.rhs.data[face.cell] += face.open * bend);
            let first = report.iterations;
            report = solver.solve_coupled(&columns, &self.rhs, p.lambda, limits)?;
            report.iterations += first;
        }
        let exchange = coupling.impulses(&p.lambda.data, p.label);
        self.solver = Some(solver);
        subtract_gradient(model, p, &bends);
        Ok((report, exchange))
    }

    fn assemble(&mut self, model: &Model<D>, p: &Projection<'_, D>) {
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
            self.dirichlet.data[face.cell] += face.open / face.theta;
            self.rhs.data[face.cell] += face.open * p.jump * face.kappa / face.theta;
        }
    }
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

/// Subtracts the pressure's gradient on the liquid's faces.
fn subtract_gradient<const D: usize>(model: &Model<D>, p: &mut Projection<'_, D>, bends: &[f64]) {
    let cells = model.grid.lattice();
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
                    *u -= (lambda[upper] - lambda[lower]) / model.grid.dx;
                }
            }
        });
    }
    for (face, bend) in zip(p.cut, bends) {
        let slope = ((p.jump * face.kappa - lambda[face.cell]) / face.theta + bend) / model.grid.dx;
        p.velocity.axes[face.axis][face.face] -= face.sign * slope;
    }
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
    Coupling::new(model, cut, &state.solids, &state.phi.data).fluxes(|cell, flux| {
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
    use crate::model::{Numerics, Wall};
    use crate::workspace::{BAND, Workspace};
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
        let known =
            Curvature { kappa: vec![0.0; work.band.cells.len()], known: vec![true; work.band.cells.len()] };
        let mut cut = cut_faces(&model, &state.phi, &work.band, &work.liquid, &known, &work.cut);
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
            liquid: &work.liquid,
            faces: work.known.liquid(),
            cut: &cut,
            cut_cells: &work.cut,
            solids: &[],
            jump: 1.0,
            label: &|_| Some(0),
        };
        work.pressure.project(&model, &mut projection).unwrap();
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
