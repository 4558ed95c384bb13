//! Memory of a step, and what follows from the state: where the liquid is.

use crate::collision::points::Points;
use crate::components::volume::Liquid;
use crate::flow::advection::Flow;
use crate::flow::pressure::PressureFields;
use crate::free_surface::energy::SurfaceLattice;
use crate::model::Model;
use crate::model::resolution::{BAND, LAYERS};
use crate::repairs::Repairs;
use crate::solid::{Motion, Solid, SolidState};
use crate::state::State;
use meniscus_numerics::grid::{
    Band, CellField, CutCells, Grid, KnownFaces, Run, Runs, Sampler, Segment, Tiles, points,
};
use meniscus_numerics::{Matrix, Vector};
use rayon::prelude::*;
use std::sync::Arc;

/// How much deeper, in cells, it is half-way between two cells than in the mean if they are on either side of a thin solid. Under
/// one side the depth is linear; through one of 2.5 cells it is 0.38 and more where both cells have open faces.
const ACROSS: f64 = 0.25;

/// What a component of the liquid touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Touching {
    /// A side of the domain.
    pub side: bool,
    /// A solid that stays or goes as told.
    pub held: bool,
    /// A free solid.
    pub free: bool,
}

/// Components of the liquid that are none.
pub struct Strays {
    /// Their cells.
    pub cells: Vec<usize>,
    /// Their numbers, in order.
    pub components: Vec<u32>,
    /// Those of them that have come through a solid.
    pub leaked: Vec<u32>,
}

/// What follows from the state, kept from step to step, and scratch memory.
pub struct Workspace<const D: usize> {
    /// Tiles with liquid or band.
    pub tiles: Tiles<D>,
    /// The cells around the surface.
    pub band: Band<D>,
    /// The liquid cells.
    pub liquid: Runs,
    /// What the solids leave open.
    pub cut: CutCells<D>,
    /// The faces with a velocity.
    pub known: KnownFaces<D>,
    /// The lattice that measures the surface.
    pub lattice: SurfaceLattice<D>,
    /// Dense memory of the pressure solve.
    pub pressure: PressureFields<D>,
    /// The surfaces of solids as contacts see them.
    pub points: Arc<Points<D>>,
    /// Cells in and beside thin solids where φ is no distance, in order.
    pub apart: Vec<u32>,
    /// Cells within solids that the band does not reach and that the step under way has changed, with the φ that they had.
    pub beyond: Vec<(u32, f64)>,
    /// Surface of each solid at the start, m² (2D: m).
    pub surfaces: Vec<f64>,
    /// What the step under way has mended so far.
    pub repairs: Repairs,
}

impl<const D: usize> Workspace<D> {
    /// Finds the liquid of a state and extends its velocity.
    pub fn new(model: &Model<D>, state: &mut State<D>) -> Self {
        let grid = model.grid;
        let mut workspace = Self {
            tiles: Tiles::all(grid),
            band: Band::new(grid),
            liquid: Runs::default(),
            cut: CutCells::none(grid),
            known: KnownFaces::new(grid),
            lattice: SurfaceLattice::new(grid, model.weight()),
            pressure: PressureFields::new(model),
            points: Arc::new(Points::of(model)),
            apart: Vec::new(),
            beyond: Vec::new(),
            surfaces: Vec::new(),
            repairs: Repairs::default(),
        };
        let start: Vec<_> = model.solids.iter().map(Solid::start).collect();
        workspace.cut_cells(model, &start);
        workspace.surfaces = workspace.measure_surfaces(model);
        if start != state.solids {
            workspace.cut_cells(model, &state.solids);
        }
        workspace.find_liquid(model, state);
        workspace.extend_afresh(model, state);
        workspace
    }

    /// Finds what the solids cut where they are now, near the liquid.
    fn cut_cells(&mut self, model: &Model<D>, now: &[SolidState<D>]) {
        let solids: Vec<_> = model.solids.iter().zip(now).collect();
        let distances: Vec<_> =
            solids.iter().map(|(solid, now)| move |x: &Vector<D>| solid.liquid_distance(now, x)).collect();
        let cuts = solids.iter().zip(&distances).map(|((solid, now), d)| solid.cut_by(now, d));
        // The liquid and its band go less than a tile in a step.
        self.cut.rebuild(&cuts.collect::<Vec<_>>(), &self.tiles.grown());
        let nearest = |x: &Vector<D>| {
            let number = model.nearest_solid(now, x).unwrap_or(0);
            (number as u32, model.solids[number].cosine_near(&now[number], x, model.grid.dx))
        };
        self.lattice.follow(&self.cut, nearest);
    }

    /// Finds what they cut anew, if any solid moves.
    pub fn follow_solids(&mut self, model: &Model<D>, state: &State<D>) {
        if model.solids.iter().any(|s| s.motion != Motion::Fixed) {
            self.cut_cells(model, &state.solids);
        }
    }

    /// The surface of each solid in the domain, m² (2D: m).
    fn measure_surfaces(&self, model: &Model<D>) -> Vec<f64> {
        let mut sums = vec![0.0; model.solids.len()];
        let wet = self.cut.wet.iter();
        wet.for_each(|w| sums[w.solid as usize] += w.area.norm() * model.grid.face_area());
        sums
    }

    /// Finds tiles, liquid cells and band of the state's φ. Only its signs count: what is found stays right when φ is
    /// made a distance again or shifted, and a resumed run finds the same.
    pub fn find_liquid(&mut self, model: &Model<D>, state: &State<D>) {
        self.tiles = self.tiles.around_negative(&state.phi.data);
        let negative = self.tiles.negative_runs(&state.phi.data);
        let open = |cell: usize| !self.cut.closed(model.grid.lattice().coordinates(cell));
        let liquid = if self.cut.wet.is_empty() { negative } else { negative.filtered(&model.grid, open) };
        self.liquid = liquid.label(&model.grid);
        let tips = self.tips(model, state);
        self.liquid.unite(&tips);
        self.band.rebuild(&state.phi.data, &self.liquid, LAYERS);
    }

    /// The liquid cells of components that are none: those that lie within solids altogether, without a centre outside, as
    /// a line that recedes leaves them behind, and those that no liquid can have reached. `before` is the liquid before
    /// its surface moved, by `reach` cells at most.
    pub fn strays(&self, model: &Model<D>, before: &Runs, reach: usize) -> Strays {
        let (within, through) = (self.within(), self.through_solids(model, before, reach));
        let stray = |c: u32| [&within, &through].iter().any(|s| s.get(c as usize) == Some(&true));
        let strays = self.liquid.runs.iter().filter(|r| stray(r.component));
        let leaked = |c: u32| !within[c as usize] && through[c as usize];
        let mut components: Vec<u32> = strays.clone().map(|r| r.component).collect();
        components.sort_unstable();
        components.dedup();
        Strays {
            cells: strays.flat_map(|r| cells_of(&model.grid, r)).collect(),
            leaked: components.iter().copied().filter(|c| leaked(*c)).collect(),
            components,
        }
    }

    /// Which components have come through a solid: they lie where no liquid was within reach. Within a wall φ goes on from
    /// the nearer side, and where the liquid of one side ends the other may take a cell of it for its own.
    fn through_solids(&self, model: &Model<D>, before: &Runs, reach: usize) -> Vec<bool> {
        if self.cut.wet.is_empty() {
            return Vec::new();
        }
        let mut through = vec![true; self.liquid.components as usize];
        before.overlaps(&self.liquid).iter().for_each(|(_, new, _)| through[*new as usize] = false);
        if !through.contains(&true) {
            return through;
        }
        let (was, lattice) = (before.component(&model.grid), model.grid.lattice());
        let unreached = |cell: usize| {
            let at = lattice.coordinates(cell);
            let low = at.map(|i| i.saturating_sub(reach));
            let high = std::array::from_fn(|a| (at[a] + reach + 1).min(lattice.extent[a]));
            points([low, high]).all(|p| was(lattice.index(p)).is_none())
        };
        for run in &self.liquid.runs {
            let through = &mut through[run.component as usize];
            *through = *through && cells_of(&model.grid, run).all(unreached);
        }
        through
    }

    /// Which components lie within solids altogether; nothing where there are no solids.
    fn within(&self) -> Vec<bool> {
        if self.cut.wet.is_empty() {
            return Vec::new();
        }
        let mut within = vec![true; self.liquid.components as usize];
        for run in &self.liquid.runs {
            let within = &mut within[run.component as usize];
            *within = *within && cells_of(&self.cut.open.grid, run).all(|c| self.cut.distance(c) < 0.0);
        }
        within
    }

    /// Components that are but tips of wedges, and those that they are the tips of: at a slanting solid a cell at the tip
    /// may share no face with the rest. That of the other side of a thin solid is not.
    fn tips(&self, model: &Model<D>, state: &State<D>) -> Vec<(u32, u32)> {
        let (within, grid) = (self.within(), model.grid);
        let lattice = grid.lattice();
        let depth = |x: &Vector<D>| -model.solid_distance(&state.solids, x);
        let across = |from: [usize; D], to: [usize; D]| {
            let (from, to) = (grid.center(from), grid.center(to));
            depth(&((from + to) * 0.5)) > 0.5 * (depth(&from) + depth(&to)) + ACROSS * grid.dx
        };
        let component = self.liquid.component(&grid);
        let mut pairs = Vec::new();
        for run in self.liquid.runs.iter().filter(|r| within.get(r.component as usize) == Some(&true)) {
            for cell in cells_of(&grid, run).filter(|c| self.cut.airy(*c, &state.phi.data)) {
                let at = lattice.coordinates(cell);
                let low = at.map(|i| i.saturating_sub(1));
                let high = std::array::from_fn(|a| (at[a] + 2).min(lattice.extent[a]));
                let whole = |to: [usize; D]| component(lattice.index(to)).filter(|c| !within[*c as usize]);
                let around = points([low, high]).filter_map(|to| whole(to).filter(|_| !across(at, to)));
                pairs.extend(around.min().map(|whole| (run.component, whole)));
            }
        }
        pairs
    }

    /// Marks the liquid's faces anew and extends the velocity from them.
    pub fn extend_afresh(&mut self, model: &Model<D>, state: &mut State<D>) {
        self.mark_afresh(model);
        self.extend(model, state);
    }

    /// Marks the liquid's faces anew: no other is known.
    pub fn mark_afresh(&mut self, model: &Model<D>) {
        let faces: [Vec<Segment>; D] = std::array::from_fn(|a| self.liquid.faces(&model.grid, a));
        self.known.forget();
        self.known.set_liquid(faces);
        self.known.forget_shut(&self.cut.shut);
    }

    /// Extends the velocity from the liquid over the band. Gives back how many faces within solids found no solid to slip along.
    pub fn extend(&mut self, model: &Model<D>, state: &mut State<D>) -> u64 {
        let distance = Sampler::cells(&model.grid, &state.phi.data, model.scalar_edges());
        let closed = |a: usize, side: usize| model.walls[a][side] == crate::Wall::Slip;
        let solid = |x: &Vector<D>| self.cut.hides(x);
        let (velocity, phi) = (&mut state.velocity, &state.phi.data);
        self.known.extrapolate(velocity, &self.band, phi, &distance, solid, closed);
        if self.cut.wet.is_empty() {
            return 0;
        }
        let shut = self.known.extend_behind(&mut state.velocity, &self.cut.shut);
        slip_along(model, state, &shut)
    }

    /// What each component touches.
    pub fn touching(&self, model: &Model<D>) -> Vec<Touching> {
        let (near, [first, last]) = (0.75 * model.grid.dx, model.grid.bounds());
        let at_side = |(low, high): &(Vector<D>, Vector<D>)| {
            (0..D).any(|a| low[a] < first[a] + near || high[a] > last[a] - near)
        };
        let boxes = boxes(model, &self.liquid);
        let mut touching: Vec<Touching> =
            boxes.iter().map(|b| Touching { side: at_side(b), held: false, free: false }).collect();
        let label = self.liquid.component(&model.grid);
        for w in &self.cut.wet {
            if let Some(c) = label(w.cell as usize) {
                let free = model.solids[w.solid as usize].is_unheld();
                let touching = &mut touching[c as usize];
                if free { touching.free = true } else { touching.held = true }
            }
        }
        touching
    }

    /// The share of the solids' surface that each component wets which faces the directions of its part of vectors.
    pub fn faced(&self, parts: &[Matrix<D>]) -> Vec<f64> {
        let label = self.liquid.component(&self.cut.open.grid);
        let mut sums = vec![(0.0, 0.0); parts.len()];
        for w in &self.cut.wet {
            if let Some(c) = label(w.cell as usize).filter(|c| (*c as usize) < parts.len()) {
                let (faced, all) = &mut sums[c as usize];
                *faced += (parts[c as usize] * w.area).norm();
                *all += w.area.norm();
            }
        }
        sums.into_iter().map(|(faced, all)| faced / f64::max(all, f64::MIN_POSITIVE)).collect()
    }

    /// The liquid as the volume correction sees it.
    pub fn measured_liquid<'a>(&'a self, model: &'a Model<D>, labels: &'a [u32]) -> Liquid<'a, D> {
        Liquid { model, lattice: &self.lattice, band: &self.band, cells: &self.liquid, labels }
    }
}

/// The cells of a run.
fn cells_of<const D: usize>(grid: &Grid<D>, run: &Run) -> std::ops::Range<usize> {
    let row = run.row as usize * grid.cells[0];
    row + run.start as usize..row + run.end as usize
}

/// Gives the velocity on faces that solids close the normal part of the nearest solid's surface; it is zero where there is none.
/// Gives back on how many that is so.
fn slip_along<const D: usize>(model: &Model<D>, state: &mut State<D>, shut: &[Vec<u32>; D]) -> u64 {
    let flow = Flow::new(model, &state.velocity);
    let new: [Vec<Option<f64>>; D] = std::array::from_fn(|a| {
        let lattice = model.grid.faces(a);
        let slipping = |&f: &u32| {
            let x = model.grid.face_center(a, lattice.coordinates(f as usize));
            let number = model.nearest_solid(&state.solids, &x)?;
            let (solid, now) = (&model.solids[number], &state.solids[number]);
            let mut u = flow.linear(&x);
            u[a] = state.velocity.axes[a][f as usize];
            let [normal, velocity] = solid.normal_and_velocity(now, &x, 0.01 * model.grid.dx);
            Some(u[a] - normal[a] * (u - velocity).dot(&normal))
        };
        shut[a].par_iter().with_min_len(64).map(slipping).collect()
    });
    for a in 0..D {
        let faces = shut[a].iter().zip(&new[a]);
        faces.for_each(|(f, u)| state.velocity.axes[a][*f as usize] = u.unwrap_or(0.0));
    }
    new.iter().flatten().filter(|u| u.is_none()).count() as u64
}

/// Box of the cell centres of every component.
pub fn boxes<const D: usize>(model: &Model<D>, liquid: &Runs) -> Vec<(Vector<D>, Vector<D>)> {
    let lattice = model.grid.lattice();
    let far: Vector<D> = Vector::repeat(f64::INFINITY);
    let mut out = vec![(far, -far); liquid.components as usize];
    for run in &liquid.runs {
        let at = lattice.coordinates(run.row as usize * lattice.extent[0]);
        let end = |i: u32| {
            let mut cell = at;
            cell[0] = i as usize;
            model.grid.center(cell)
        };
        let (low, high) = &mut out[run.component as usize];
        *low = low.inf(&end(run.start));
        *high = high.sup(&end(run.end - 1));
    }
    out
}

/// A copy of φ in the band, of the liquid's velocity and of drops, solids and sums, from which [`Snapshot::restore`] makes the state
/// before a failed step; all else follows from these, but φ in the cells of [`Workspace::beyond`].
pub struct Snapshot<const D: usize> {
    tiles: Tiles<D>,
    liquid: Runs,
    cells: Vec<u32>,
    phi: Vec<f64>,
    velocity: FaceValues<D>,
    drops: Vec<crate::Drop<D>>,
    solids: Vec<crate::SolidState<D>>,
    slips: crate::Slips<D>,
    scalars: (f64, u64, [f64; 6], [f64; 3], [f64; 2]),
}

type FaceValues<const D: usize> = [Vec<(usize, Vec<f64>)>; D];

impl<const D: usize> Snapshot<D> {
    /// Copies what the coming step may overwrite.
    pub fn take(model: &Model<D>, state: &State<D>, workspace: &mut Workspace<D>) -> Self {
        workspace.beyond.clear();
        let cells = workspace.band.cells.clone();
        let phi = cells.iter().map(|&c| state.phi.data[c as usize]).collect();
        let velocity = std::array::from_fn(|a| {
            let row = model.grid.faces(a).extent[0];
            let values = |s: &Segment| {
                let at = s.row * row + s.start;
                (at, state.velocity.axes[a][at..at + s.end - s.start].to_vec())
            };
            workspace.known.liquid()[a].iter().map(values).collect()
        });
        let State { last_dt, lead, kick, clear, drift, lost_volume, .. } = *state;
        let State { outflow_volume, outflow_kinetic_energy, outflow_stored_energy, .. } = *state;
        let left = [outflow_volume, outflow_kinetic_energy, outflow_stored_energy];
        let start = [last_dt, lead, kick, clear, drift, lost_volume];
        let scalars = (state.time, state.step, start, left, [state.kinetic_energy, state.surface_area]);
        let (tiles, drops, solids) = (workspace.tiles.clone(), state.drops.clone(), state.solids.clone());
        let liquid = workspace.liquid.clone();
        Self { tiles, liquid, cells, phi, velocity, drops, solids, slips: state.slips.clone(), scalars }
    }

    /// Puts the state back as it was, and the workspace with it.
    pub fn restore(self, model: &Model<D>, state: &mut State<D>, workspace: &mut Workspace<D>) {
        let limit = BAND * model.grid.dx;
        for &cell in &workspace.band.cells {
            let value = &mut state.phi.data[cell as usize];
            *value = limit.copysign(*value);
        }
        self.cells.iter().zip(&self.phi).for_each(|(&c, v)| state.phi.data[c as usize] = *v);
        workspace.known.clear(&mut state.velocity);
        for (a, stretches) in self.velocity.into_iter().enumerate() {
            for (at, values) in stretches {
                state.velocity.axes[a][at..at + values.len()].copy_from_slice(&values);
            }
        }
        (state.time, state.step) = (self.scalars.0, self.scalars.1);
        [state.last_dt, state.lead, state.kick, state.clear, state.drift, state.lost_volume] = self.scalars.2;
        [state.outflow_volume, state.outflow_kinetic_energy, state.outflow_stored_energy] = self.scalars.3;
        [state.kinetic_energy, state.surface_area] = self.scalars.4;
        state.drops = self.drops;
        (state.solids, state.slips) = (self.solids, self.slips);
        // What a failed solve left behind is no guess.
        state.lambda = CellField::new(model.grid, 0.0);
        // The tiles of the liquid that failed need not hold the liquid, nor what solids cut of its cells.
        workspace.tiles = self.tiles.clone();
        workspace.follow_solids(model, state);
        workspace.find_liquid(model, state);
        // Known defect: outside the band φ within solids keeps the signs that the failed step gave it, unless liquid of no drop
        // appears so. With all of them put back, `verify leak` finds stale liquid in thin walls that move.
        if workspace.liquid.components as usize != state.drops.len() {
            // Boxes of solids overlap, so a cell may be listed twice: its first entry is the φ before the step.
            workspace.beyond.iter().rev().for_each(|(cell, value)| state.phi.data[*cell as usize] = *value);
            self.cells.iter().zip(&self.phi).for_each(|(&c, v)| state.phi.data[c as usize] = *v);
            workspace.tiles = self.tiles;
            workspace.find_liquid(model, state);
        }
        // With the wrong number of components the next step would end with a panic: where φ does not give those that the
        // drops are of, they are the ones from before the step.
        if workspace.liquid.components as usize != state.drops.len() {
            workspace.liquid = self.liquid;
            workspace.band.rebuild(&state.phi.data, &workspace.liquid, LAYERS);
        }
        workspace.extend_afresh(model, state);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::simulation::{Body, Simulation};
    use crate::solid::Solid;
    use meniscus_numerics::shape::Shape;

    #[test]
    fn liquid_beyond_a_wall_is_none() {
        let grid = Grid::<2>::new([16; 2], 1.0);
        let (center, half_size) = (Vector::<2>::new(7.3, 8.0), Vector::<2>::new(1.0, 20.0));
        let wall =
            Solid::new(Shape::Box { center, half_size, rotation: Matrix::identity() }, Motion::Fixed, 1.0);
        let model = Model::of_test(grid, vec![wall]);
        let left = |x: &Vector<2>| (x[0] - 7.3).max(x[1] - 9.2);
        let body = Body { distance: &left, velocity: Vector::zeros() };
        let Simulation { model, mut state, mut work } = Simulation::new(model, &[body]);
        let before = work.liquid.clone();
        let beyond = grid.lattice().index([8, 8]);
        state.phi.data[beyond] = -0.1;
        work.find_liquid(&model, &state);
        assert_eq!(work.liquid.components, 2);
        let strays = work.strays(&model, &before, 1);
        assert_eq!((strays.cells, &strays.leaked), (vec![beyond], &strays.components));
        // Liquid that could have got there, or was there, stays.
        assert!(work.strays(&model, &before, 3).cells.is_empty());
        assert!(work.strays(&model, &work.liquid.clone(), 1).cells.is_empty());
    }

    /// Two balls that touch are carried into a pool. Deep in them φ follows what is outside, where no band reaches.
    #[test]
    fn a_step_taken_back_leaves_the_drops_that_were() {
        let grid = Grid::<2>::new([40; 2], 1.0);
        let path = crate::Path { velocity: Vector::from([0.4, -1.0]), spin: [0.0; 3], keyframes: Vec::new() };
        let ball = |x: f64| {
            let shape = Shape::Ball { center: Vector::from([x, 24.0]), radius: 5.5 };
            Solid::new(shape, Motion::Given(path.clone()), 1.0)
        };
        let model = Model::of_test(grid, vec![ball(10.0), ball(21.0)]);
        let pool = |x: &Vector<2>| x[1] - 16.3;
        let body = Body { distance: &pool, velocity: Vector::zeros() };
        let Simulation { model, mut state, mut work } = Simulation::new(model, &[body]);
        let mut changed = 0;
        for _ in 0..40 {
            let before = state.drops.clone();
            let snapshot = Snapshot::take(&model, &state, &mut work);
            crate::simulation::step::step(&model, &mut state, &mut work, 0.5, &mut |_| ()).unwrap();
            changed += work.beyond.len();
            snapshot.restore(&model, &mut state, &mut work);
            assert_eq!((work.liquid.components as usize, &state.drops), (before.len(), &before));
            crate::simulation::step::step(&model, &mut state, &mut work, 0.5, &mut |_| ()).unwrap();
        }
        assert!(changed > 0);
    }
}
