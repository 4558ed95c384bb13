//! Pressure between liquid and rigid solids.
//!
//! In a liquid cell that a solid cuts, the flow through the open faces and into the moving surface balance:
//! `Σ ± α u + ∫ v·n dS = 0`, with `v` the surface's velocity and `n` pointing into the solid. A free solid takes up
//! `∫ p n dS` and its moment in the same solve: with `J` the cells' surfaces by the solid's degrees of freedom and `M`
//! its mass matrix, the system for `λ = p h/ρ` gains `ρ Jᵀ M⁻¹ J`, which is symmetric and positive, so that light
//! solids are as stable as heavy ones (C. Batty, F. Bertails, R. Bridson, "A fast variational framework for accurate
//! solid-fluid coupling", SIGGRAPH 2007; design, numerics §1).
//!
//! In that system a surface feels the pressure at the centre of its cell, up to half a cell off: a floor on the faces of
//! the lattice would bear half a cell of liquid too little, a box half a cell too much at its top and at its bottom. What
//! the slope of a first solution says that the surface has more ([`Coupling::beyond_centers`]) is given to the solids
//! before a second one.

use crate::descent::{Response, turning};
use crate::exchange::{Exchange, Impulse};
use crate::model::Model;
use crate::skin::Grip;
use crate::solid::{Motion, SolidState};
use crate::tied::{Six, Ties};
use meniscus_numerics::grid::{CutCells, WetCell};
use meniscus_numerics::linalg::{Bodies, Column, Compliance, Solve};
use meniscus_numerics::{Matrix, Vector};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The wetted surfaces of the solids, and how they move.
pub struct Coupling<'a, const D: usize> {
    model: &'a Model<D>,
    solids: &'a [SolidState<D>],
    /// How solids answer together, where some deform.
    response: Option<&'a Response<D>>,
    /// With the place where the pressure takes hold of a solid that deforms.
    wet: Vec<(WetCell<D>, Option<Grip<D>>)>,
    /// The faces that contact lines tie to the free rigid ones.
    ties: Option<&'a Ties>,
}

impl<'a, const D: usize> Coupling<'a, D> {
    /// The surfaces in liquid cells (`phi` negative).
    pub fn new(
        model: &'a Model<D>,
        cut: &CutCells<D>,
        (solids, response): (&'a [SolidState<D>], Option<&'a Response<D>>),
        phi: &[f64],
    ) -> Self {
        let wet = cut.wet.par_iter().with_min_len(64).filter(|w| phi[w.cell as usize] < 0.0);
        let gripped =
            |w: &WetCell<D>| (*w, solids[w.solid as usize].grip(&(middle(model, w) * model.grid.dx)));
        Self { model, solids, response, wet: wet.map(gripped).collect(), ties: None }
    }

    /// The same with the faces that lines tie to the solids.
    pub fn tied(self, ties: &'a Ties) -> Self {
        Self { ties: Some(ties), ..self }
    }

    /// Calls `f(cell, flux)` with the flow into the surface of every cell, `∫ v·n dS` in areas of a face, m/s.
    pub fn fluxes(&self, f: impl FnMut(usize, f64)) {
        self.fluxes_of(self.solids, f);
    }

    /// The same with what impulses add to the velocities of free solids.
    pub fn fluxes_of_push(&self, push: &Exchange<D>, f: impl FnMut(usize, f64)) {
        let mut still = self.solids.to_vec();
        still.iter_mut().for_each(SolidState::stop);
        push_solids(self.model, &mut still, push);
        let tied = |n: &usize| self.lightness(*n).is_some();
        (0..still.len()).filter(tied).for_each(|n| still[n].stop());
        self.fluxes_of(&still, f);
    }

    /// The change that impulses, and those of the tied faces, make to the velocities of the solids that faces are tied to.
    pub fn yielding(&self, push: &Exchange<D>, mut faces: BTreeMap<usize, Six>) -> BTreeMap<usize, Six> {
        let sums = push.by_solid(self.solids.len());
        for (number, six) in &mut faces {
            *six += six_of(&sums[*number].linear, &sums[*number].about(&self.solids[*number].center));
            *six = self.lightness(*number).map_or(Six::zeros(), |l| l * *six);
        }
        faces
    }

    /// Calls `f(cell, flux)` with the flow that such velocities add.
    pub fn fluxes_of_tied(&self, velocities: &BTreeMap<usize, Six>, mut f: impl FnMut(usize, f64)) {
        for (number, velocity) in velocities {
            self.flows(*number, |cell, flow| f(cell, flow.dot(velocity)));
        }
    }

    /// Adds the pressure's part to the velocities of the solids that faces are tied to.
    pub fn pressed(&self, lambda: &[f64], velocities: &mut BTreeMap<usize, Six>) {
        let scale = self.model.density * self.model.grid.face_area();
        for (number, velocity) in velocities {
            let mut sum = Six::zeros();
            self.flows(*number, |cell, flow| sum += flow * (scale * lambda[cell]));
            *velocity += self.lightness(*number).map_or(Six::zeros(), |l| l * sum);
        }
    }

    fn lightness(&self, solid: usize) -> Option<&Matrix<6>> {
        self.ties.and_then(|ties| ties.lightness(solid))
    }

    /// Calls `f(cell, flow)` with the flow into a solid and through the faces tied to it, by its six velocities.
    fn flows(&self, solid: usize, mut f: impl FnMut(usize, Six)) {
        let own = self.wet.iter().filter(|(w, _)| w.solid as usize == solid);
        own.for_each(|(w, _)| f(w.cell as usize, six_of(&w.area, &self.moment(w))));
        self.ties.iter().for_each(|ties| ties.flows(solid, &mut f));
    }

    fn fluxes_of(&self, solids: &[SolidState<D>], mut f: impl FnMut(usize, f64)) {
        for (w, grip) in &self.wet {
            let solid = &solids[w.solid as usize];
            let flux = match (grip, &solid.soft) {
                (Some(grip), Some(soft)) => grip.mean(|k| soft.body.velocities[k]).dot(&w.area),
                _ => solid.velocity.dot(&w.area) + Vector::<3>::from(solid.spin).dot(&self.moment(w)),
            };
            f(w.cell as usize, flux);
        }
    }

    /// What the solids that give way add to the pressure system.
    pub fn bodies(&self) -> Bodies<'_> {
        Bodies { columns: self.columns(), soft: self.compliances() }
    }

    /// What the free rigid solids add: a column for each degree of freedom.
    fn columns(&self) -> Vec<Column> {
        let weight = self.model.density * self.model.grid.cell_volume();
        let mut columns = Vec::new();
        if self.response.is_some() {
            return columns;
        }
        for (number, solid) in self.free() {
            if let Some(root) = self.lightness(number).and_then(|l| l.cholesky()) {
                columns.extend(self.tied_columns(number, &(root.l() * weight.sqrt())));
                continue;
            }
            let body = &self.model.solids[number].body;
            let scale = (weight / body.mass).sqrt();
            for a in 0..D {
                columns.push(self.column(number, |w| scale * w.area[a]));
            }
            let inverse = self.model.solids[number].inverse_inertia(solid);
            let root = inverse.cholesky().map_or_else(Matrix::zeros, |c| c.l()) * weight.sqrt();
            for k in if D == 2 { 2..3 } else { 0..3 } {
                columns.push(self.column(number, |w| root.column(k).dot(&self.moment(w))));
            }
        }
        columns
    }

    /// The columns of a solid that faces are tied to; `root` is of its inverse mass.
    fn tied_columns(&self, solid: usize, root: &Matrix<6>) -> Vec<Column> {
        let mut flows: BTreeMap<u32, Six> = BTreeMap::new();
        self.flows(solid, |cell, flow| *flows.entry(cell as u32).or_insert_with(Six::zeros) += flow);
        let column = |k: usize| flows.iter().map(|(cell, flow)| (*cell, root.column(k).dot(flow))).collect();
        let moves = |k: &usize| if D == 2 { *k < 2 || *k == 5 } else { true };
        (0..6).filter(moves).map(column).collect()
    }

    fn column(&self, solid: usize, value: impl Fn(&WetCell<D>) -> f64) -> Column {
        let own = self.wet.iter().filter(|(w, _)| w.solid as usize == solid);
        own.map(|(w, _)| (w.cell, value(w))).collect()
    }

    /// What the solids that deform add.
    fn compliances(&self) -> Vec<Compliance<'_>> {
        let Some(response) = self.response else { return Vec::new() };
        let scale = (self.model.density * self.model.grid.cell_volume()).sqrt();
        let scaled = |(cell, flow): (u32, Vec<(u32, f64)>)| {
            (cell, flow.into_iter().map(|(k, v)| (k, v * scale)).collect::<Vec<_>>())
        };
        let flows: Vec<_> = self.node_flows(response).into_iter().map(scaled).collect();
        if flows.is_empty() {
            return Vec::new();
        }
        let lattice = self.model.grid.lattice();
        let reach = response.reach(&flows);
        let porous = response.porous(&flows, &reach, |cell| lattice.coordinates(cell as usize));
        let solve: Box<Solve<'_>> = Box::new(move |x| response.solve_within(&reach, x));
        vec![Compliance { freedoms: response.freedoms(), flows, porous, solve }]
    }

    /// For each piece of surface, and each face that lines tie to a solid, the cell, and the flow out of it by the components of the
    /// nodes' velocities, in areas of a face.
    fn node_flows(&self, response: &Response<D>) -> Vec<(u32, Vec<(u32, f64)>)> {
        let mut flows: Vec<(u32, Vec<(u32, f64)>)> = Vec::new();
        for (w, grip) in &self.wet {
            let solid = w.solid as usize;
            let first = (response.first(solid) * D) as u32;
            if let Some(grip) = grip {
                let entry = |n: usize| {
                    let (k, a) = (n / D, n % D);
                    (first + grip.vertices[k] * D as u32 + a as u32, grip.weights[k] * w.area[a])
                };
                flows.push((w.cell, (0..D * D).map(entry).collect()));
            } else if self.model.solids[solid].motion == Motion::Free {
                let turn: Vector<D> = turning(&self.moment(w).into());
                let entry = |n: usize| (first + n as u32, if n < D { w.area[n] } else { turn[n - D] });
                flows.push((w.cell, (0..2 * D).map(entry).collect()));
            }
        }
        flows.extend(response.tied_flows());
        flows
    }

    /// Calls `f(cell, flux)` with the flow that velocities of the nodes add.
    pub fn fluxes_of_nodes(&self, velocities: &[Vector<D>], mut f: impl FnMut(usize, f64)) {
        let Some(response) = self.response else { return };
        for (cell, flow) in self.node_flows(response) {
            f(
                cell as usize,
                flow.iter().map(|(k, v)| v * velocities[*k as usize / D][*k as usize % D]).sum(),
            );
        }
    }

    /// What the pressure gives to the nodes, through tied faces too, N s; `lambda` is `p h/ρ`.
    pub fn pushed_nodes(&self, lambda: &[f64]) -> Vec<Vector<D>> {
        let Some(response) = self.response else { return Vec::new() };
        let scale = self.model.density * self.model.grid.face_area();
        let mut all = vec![Vector::zeros(); response.freedoms() / D];
        for (cell, flow) in self.node_flows(response) {
            let push = scale * lambda[cell as usize];
            flow.iter().for_each(|(k, v)| all[*k as usize / D][*k as usize % D] += v * push);
        }
        all
    }

    /// What the liquid's pressure gives to the solids; `lambda` is `p h/ρ`, `label` the component of a liquid cell.
    pub fn impulses(&self, lambda: &[f64], label: impl Fn(usize) -> Option<u32>) -> Exchange<D> {
        self.exchange(label, |w| {
            let push = lambda[w.cell as usize];
            (w.area * push, Vector::<3>::from(w.moment) * push)
        })
    }

    /// What they get besides because the pressure on their surfaces is not that at the cells' centres; `slope` is that of
    /// `lambda` in a liquid cell, a cell.
    pub fn beyond_centers(
        &self,
        slope: impl Fn(usize) -> Vector<D>,
        label: impl Fn(usize) -> Option<u32>,
    ) -> Exchange<D> {
        self.exchange(label, |w| {
            let push = w.spread * slope(w.cell as usize);
            (push, three(&middle(self.model, w)).cross(&three(&push)))
        })
    }

    /// Impulses from what every surface gets, divided by density and area of a face: itself, and its moment in cells.
    fn exchange(
        &self,
        label: impl Fn(usize) -> Option<u32>,
        push: impl Fn(&WetCell<D>) -> (Vector<D>, Vector<3>),
    ) -> Exchange<D> {
        let scale = self.model.density * self.model.grid.face_area();
        let mut exchange = Exchange::new();
        for (w, grip) in &self.wet {
            let Some(component) = label(w.cell as usize) else { continue };
            let (linear, turning) = push(w);
            match grip {
                Some(grip) => exchange.grip((component, w.solid), grip, linear * scale),
                None => {
                    let turning = turning * (scale * self.model.grid.dx);
                    exchange.add((component, w.solid), &Impulse { linear: linear * scale, turning }, 1.0);
                }
            }
        }
        exchange
    }

    fn free(&self) -> impl Iterator<Item = (usize, &SolidState<D>)> {
        self.solids.iter().enumerate().filter(|(i, _)| self.model.solids[*i].motion == Motion::Free)
    }

    /// `∫ r × n dS` about the solid's centre, in areas of a face times m.
    fn moment(&self, w: &WetCell<D>) -> Vector<3> {
        let center = &self.solids[w.solid as usize].center;
        Vector::<3>::from(w.moment) * self.model.grid.dx - three(center).cross(&three(&w.area))
    }
}

/// Middle of the solid's surface in a cell, in cells.
fn middle<const D: usize>(model: &Model<D>, w: &WetCell<D>) -> Vector<D> {
    let center = model.grid.center(model.grid.lattice().coordinates(w.cell as usize)) / model.grid.dx;
    center + w.spread.tr_mul(&w.area) / w.area.norm_squared().max(f64::MIN_POSITIVE)
}

/// The six components: of a solid's centre, then about it.
fn six_of<const D: usize>(linear: &Vector<D>, turning: &Vector<3>) -> Six {
    let linear = three(linear);
    Six::from_fn(|i, _| if i < 3 { linear[i] } else { turning[i - 3] })
}

/// A vector in space.
fn three<const D: usize>(v: &Vector<D>) -> Vector<3> {
    Vector::from_fn(|a, _| if a < D { v[a] } else { 0.0 })
}

/// Gives impulses to the free rigid solids.
pub fn push_solids<const D: usize>(model: &Model<D>, solids: &mut [SolidState<D>], exchange: &Exchange<D>) {
    let sums = exchange.by_solid(solids.len());
    for ((now, solid), sum) in solids.iter_mut().zip(&model.solids).zip(sums) {
        if solid.motion == Motion::Free {
            now.velocity += sum.linear / solid.body.mass;
            let spin = Vector::<3>::from(now.spin) + solid.inverse_inertia(now) * sum.about(&now.center);
            now.spin = spin.into();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::liquid::curvature::Curvature;
    use crate::liquid::cut_faces::cut_faces;
    use crate::liquid::pressure::Projection;
    use crate::model::{Numerics, Wall};
    use crate::solid::Solid;
    use crate::state::State;
    use crate::workspace::{BAND, Workspace};
    use meniscus_numerics::grid::Grid;
    use meniscus_numerics::linalg::SolveReport;
    use meniscus_numerics::shape::Shape;
    use std::f64::consts::PI;

    struct Projected<const D: usize> {
        state: State<D>,
        impulses: Vec<Impulse<D>>,
        solves: [SolveReport; 2],
        fastest: f64,
    }

    /// One pressure solve in a unit box that is filled up to a height, with a velocity on all open faces.
    fn project<const D: usize>(
        cells: usize,
        solids: Vec<Solid<D>>,
        height: f64,
        velocity: Vector<D>,
    ) -> Projected<D> {
        let model = Model {
            grid: Grid::new([cells; D], 1.0 / cells as f64),
            walls: [[Wall::Slip; 2]; D],
            density: 1.0,
            kinematic_viscosity: 0.0,
            surface_tension: 0.0,
            gravity: Vector::zeros(),
            solids,
            numerics: Numerics { tolerance: 1e-10, ..Numerics::default() },
        };
        let grid = model.grid;
        let mut state = State::empty(grid);
        state.solids = model.solids.iter().map(Solid::start).collect();
        let limit = BAND * grid.dx;
        for i in 0..grid.lattice().len() {
            let x = grid.center(grid.lattice().coordinates(i));
            state.phi.data[i] = (x[D - 1] - height).clamp(-limit, limit);
        }
        let mut work = Workspace::new(&model, &mut state);
        let flat = Curvature::unknown();
        let cut = cut_faces(&model, &state.phi, &work.band, &flat, &work.cut);
        let faces = work.known.liquid().clone();
        let open = work.cut.open.clone();
        let walk = |mut f: Box<dyn FnMut(usize, usize) + '_>| {
            for a in 0..D {
                let lattice = grid.faces(a);
                for s in &faces[a] {
                    for face in s.row * lattice.extent[0] + s.start..s.row * lattice.extent[0] + s.end {
                        let shut = model.closed(a, lattice.coordinates(face)[a]) || open.axes[a][face] == 0.0;
                        if !shut {
                            f(a, face);
                        }
                    }
                }
            }
        };
        let mut start = state.velocity.clone();
        walk(Box::new(|a, face| start.axes[a][face] = velocity[a]));
        state.velocity = start;
        let mut projection = Projection {
            velocity: &mut state.velocity,
            lambda: &mut state.lambda,
            phi: &state.phi,
            band: &work.band,
            liquid: &work.liquid,
            faces: &faces,
            cut: &cut,
            dragged: &mut [],
            cut_cells: &mut work.cut,
            solids: &state.solids,
            jump: 0.0,
            label: &|_| Some(0),
            time: 1.0,
        };
        let (solves, exchange) = work.pressure.project(&model, &mut projection, &mut |_| ()).unwrap();
        let impulses = exchange.by_solid(model.solids.len());
        push_solids(&model, &mut state.solids, &exchange);
        let mut fastest = 0.0f64;
        walk(Box::new(|a, face| fastest = fastest.max(state.velocity.axes[a][face].abs())));
        Projected { state, impulses, solves, fastest }
    }

    fn ball<const D: usize>(radius: f64) -> Shape<D> {
        Shape::Ball { center: Vector::from_fn(|a, _| 0.49 + 0.017 * a as f64), radius }
    }

    fn volume<const D: usize>(radius: f64) -> f64 {
        if D == 2 { PI * radius * radius } else { 4.0 / 3.0 * PI * radius.powi(3) }
    }

    fn liquid_at_rest_lifts<const D: usize>() {
        // A ball under water, and a slanting bottom.
        let slope = Vector::<D>::from_fn(|a, _| if a + 1 == D { 1.0 } else { 0.3 });
        let bottom = Shape::HalfSpace { point: Vector::from_fn(|_, _| 0.11), normal: slope };
        let solids = vec![Solid::new(ball(0.22), Motion::Fixed, 1.0), Solid::new(bottom, Motion::Fixed, 1.0)];
        let fall = Vector::from_fn(|a, _| if a + 1 == D { -1.0 } else { 0.0 });
        let p = project::<D>(if D == 2 { 64 } else { 40 }, solids, 0.873, fall);
        // What is left is the solve's tolerance, 1e-10; the volume is the cut cells', right to second order.
        assert!(p.fastest < 1e-9, "{D}D: {}", p.fastest);
        let (volume, bar) = (volume::<D>(0.22), if D == 2 { 0.002 } else { 0.008 });
        let lift = p.impulses[0].linear;
        assert!((lift[D - 1] / volume - 1.0).abs() < bar, "{D}D: {}", lift[D - 1] / volume);
        // Slivers without a neighbour above or below see no slope.
        assert!((0..D - 1).all(|a| lift[a].abs() < 1e-6 * volume), "{D}D: {lift}");
        let turning = p.impulses[0].about(&p.state.solids[0].center);
        assert!(turning.norm() < 1e-4 * volume * 0.22, "{D}D: {:e}", turning.norm() / volume / 0.22);
    }

    #[test]
    fn liquid_at_rest_stays_and_lifts_a_body() {
        liquid_at_rest_lifts::<2>();
        liquid_at_rest_lifts::<3>();
    }

    /// Speed that a ball keeps of its start velocity within a shell full of liquid, and iterations.
    fn kept_speed<const D: usize>(cells: usize, density: f64) -> (f64, usize) {
        let all = Shape::Box {
            center: Vector::repeat(0.5),
            half_size: Vector::repeat(1.0),
            rotation: Matrix::identity(),
        };
        let shell = Shape::Difference { of: Box::new(all), minus: Box::new(ball(0.45)) };
        let mut inner = Solid::new(ball(0.2), Motion::Free, density);
        inner.velocity[0] = 1.0;
        let p = project::<D>(cells, vec![inner, Solid::new(shell, Motion::Fixed, 1.0)], 9.0, Vector::zeros());
        (p.state.solids[0].velocity[0], p.solves.iter().map(|s| s.iterations).sum())
    }

    fn added_mass_is_right<const D: usize>(cells: usize, bar: f64) {
        // Potential flow between concentric balls (Lamb, Hydrodynamics, §93): the liquid adds (bᴰ + (D−1) aᴰ)/((D−1)(bᴰ − aᴰ))
        // times the mass that the ball displaces.
        let (a, b) = (0.2f64.powi(D as i32), 0.45f64.powi(D as i32));
        let d = D as f64 - 1.0;
        let added = (b + d * a) / (d * (b - a));
        for density in [0.01, 0.1, 1.0, 10.0, 100.0] {
            let (speed, iterations) = kept_speed::<D>(cells, density);
            let found = density / speed - density;
            assert!((found / added - 1.0).abs() < bar, "{D}D, density {density}: {found} for {added}");
            assert!(iterations < 20, "{D}D, density {density}: {iterations} iterations");
        }
    }

    #[test]
    fn a_ball_in_a_shell_feels_the_added_mass() {
        added_mass_is_right::<2>(80, 0.003);
        added_mass_is_right::<3>(48, 0.01);
    }
}
