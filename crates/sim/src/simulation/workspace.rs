//! Workspace of a step: data derived from the state (liquid cells, narrow band, cut cells), and scratch memory.

use super::repairs::Repairs;
use crate::collision::points::CollisionPoints;
use crate::components::volume::VolumeCorrection;
use crate::flow::pressure::PressureFields;
use crate::free_surface::energy::DualGrid;
use crate::model::Model;
use crate::model::resolution::{BAND_LAYERS, BAND_WIDTH_CELLS};
use crate::paper::time::scheme::PaperScheme;
use crate::solid::{SolidKind, SolidState, SolidSurfaces, Solids};
use crate::state::State;
use meniscus_numerics::grid::{
    Band, CellField, CutCells, FaceField, Grid, Run, Runs, Sampler, Segment, Tiles, VelocityExtension,
    lattice_points,
};
use meniscus_numerics::{Matrix, Vector, par};
use std::sync::Arc;

/// Excess of the depth midway between two cells over their mean depth, in cells, above which they are on either side of a thin solid. On
/// one side the depth is linear; through a plate of 2.5 cells the excess is at least 0.38 if both cells have open faces.
const THIN_SOLID_DEPTH_EXCESS_CELLS: f64 = 0.25;

/// Contacts of a component of the liquid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComponentContacts {
    /// A side of the domain.
    pub domain_side: bool,
    /// A fixed solid, one of prescribed motion, or a deformable one with anchored vertices.
    pub constrained_solid: bool,
    /// An unconstrained solid.
    pub free_solid: bool,
}

/// Spurious components of the liquid.
pub struct SpuriousComponents {
    /// Their cells.
    pub cells: Vec<usize>,
    /// Their numbers, in order.
    pub components: Vec<u32>,
    /// Those of them that have leaked through a solid.
    pub leaked: Vec<u32>,
}

/// Data derived from the state, kept from step to step, and scratch memory.
pub struct Workspace<const D: usize> {
    /// Tiles with liquid or band cells.
    pub tiles: Tiles<D>,
    /// The narrow band around the interface.
    pub band: Band<D>,
    /// The liquid cells.
    pub liquid: Runs,
    /// Surfaces of the solids.
    pub surfaces: SolidSurfaces<D>,
    /// Open fractions beside solids.
    pub cut_cells: CutCells<D>,
    /// Faces with a known velocity.
    pub known_faces: VelocityExtension<D>,
    /// Velocities, m/s, that move the interface on faces that solids close in part ([`VelocityExtension::cut_face_velocities`]).
    cut_face_velocities: [Vec<(u32, f64)>; D],
    /// The dual grid, which measures the interface.
    pub dual_grid: DualGrid<D>,
    /// Dense memory of the pressure solve.
    pub pressure: PressureFields<D>,
    /// Surfaces of the solids for contact detection.
    pub collision_points: Arc<CollisionPoints<D>>,
    /// Cells in and beside thin solids where φ is no distance, sorted.
    pub non_distance_cells: Vec<u32>,
    /// Cells within solids beyond the band that the current step has changed, with their φ before.
    pub overwritten_phi: Vec<(u32, f64)>,
    /// φ before the step, m, in the tiles around the liquid of that time.
    pub phi_before: CellField<D>,
    /// Surface area of each solid at the start, m² (2D: m).
    pub initial_solid_areas: Vec<f64>,
    /// Repairs of the current step so far.
    pub repairs: Repairs,
    /// What is fixed in the scheme of the paper, if that is the model's.
    pub paper: Option<Arc<PaperScheme<D>>>,
}

impl<const D: usize> Workspace<D> {
    /// Finds the liquid of a state and extends its velocity.
    pub fn new(model: &Model<D>, state: &mut State<D>) -> Self {
        let (grid, start) = (model.grid, model.initial_solids());
        let mut workspace = Self {
            tiles: Tiles::all(grid),
            band: Band::new(grid),
            liquid: Runs::default(),
            surfaces: SolidSurfaces::new(&model.solids, &start),
            cut_cells: CutCells::unopened(grid),
            known_faces: VelocityExtension::new(grid),
            cut_face_velocities: std::array::from_fn(|_| Vec::new()),
            dual_grid: DualGrid::new(grid, model.cell_bond_vector()),
            pressure: PressureFields::new(model),
            collision_points: Arc::new(CollisionPoints::of(model)),
            non_distance_cells: Vec::new(),
            overwritten_phi: Vec::new(),
            phi_before: CellField::new(grid, 0.0),
            initial_solid_areas: Vec::new(),
            repairs: Repairs::default(),
            paper: PaperScheme::chosen_by(model),
        };
        workspace.place_solids(model, &start);
        workspace.initial_solid_areas = workspace.measure_surfaces(model);
        if start != state.solids {
            workspace.place_solids(model, &state.solids);
        }
        workspace.find_liquid(model, state);
        workspace.rebuild_velocity_extension(model, state);
        workspace
    }

    /// Places the solids: their surfaces, and the cells near the liquid that they cut.
    fn place_solids(&mut self, model: &Model<D>, states: &[SolidState<D>]) {
        self.surfaces.update(states);
        let solids = Solids { model, states, surfaces: &self.surfaces };
        let distances: Vec<_> =
            solids.iter().map(|solid| move |x: &Vector<D>| solid.liquid_distance(x)).collect();
        let cuts = solids.iter().zip(&distances).map(|(solid, d)| solid.embedded_boundary(d));
        // Liquid and band move less than a tile in a step, at the default Courant number.
        self.cut_cells.rebuild(&cuts.collect::<Vec<_>>(), &self.tiles.dilated());
        let nearest = |x: &Vector<D>| {
            let number = solids.nearest(x).unwrap_or(0);
            (number as u32, solids.get(number).young_cosine_near(x, model.grid.dx))
        };
        self.dual_grid.update_solids(&self.cut_cells, nearest);
    }

    /// Places the solids where they are now, if any of them moves.
    pub fn update_solids(&mut self, model: &Model<D>, state: &State<D>) {
        if model.solids.iter().any(|s| !matches!(s.kind, SolidKind::Fixed)) {
            self.place_solids(model, &state.solids);
        }
    }

    /// Surface area of each solid within the domain, m² (2D: m).
    fn measure_surfaces(&self, model: &Model<D>) -> Vec<f64> {
        let mut sums = vec![0.0; model.solids.len()];
        let wet = self.cut_cells.cells.iter();
        wet.for_each(|w| sums[w.solid as usize] += w.area_vector.norm() * model.grid.face_area());
        sums
    }

    /// Finds tiles, liquid cells and band from the signs of φ. They stay valid when φ is redistanced or shifted, and a resumed
    /// run finds the same.
    pub fn find_liquid(&mut self, model: &Model<D>, state: &State<D>) {
        self.tiles = self.tiles.around_negative(&state.phi.data);
        self.cut_cells.open_tiles(&self.tiles.dilated());
        let negative = self.tiles.negative_runs(&state.phi.data);
        let open = |cell: usize| !self.cut_cells.is_closed(model.grid.lattice().coordinates(cell));
        let liquid =
            if self.cut_cells.cells.is_empty() { negative } else { negative.filtered(&model.grid, open) };
        self.liquid = liquid.label(&model.grid);
        let tips = self.wedge_tips(model, state);
        self.liquid.merge_components(&tips);
        self.band.rebuild(&state.phi.data, &self.liquid, BAND_LAYERS);
    }

    /// Keeps φ around the liquid as that before the step.
    pub fn keep_phi(&mut self, phi: &CellField<D>) {
        let row = phi.grid.cells[0];
        for s in self.tiles.segments() {
            let cells = s.row * row + s.start..s.row * row + s.end;
            self.phi_before.data[cells.clone()].copy_from_slice(&phi.data[cells]);
        }
    }

    /// Finds spurious components: those entirely within solids, as a receding contact line leaves them, and those that no
    /// liquid can have reached. `before` is the liquid before the interface moved; none came from farther than `reach` cells.
    pub fn find_spurious_components(
        &self,
        model: &Model<D>,
        before: &Runs,
        reach: usize,
    ) -> SpuriousComponents {
        let (within, through) =
            (self.components_inside_solids(), self.leaked_components(model, before, reach));
        let stray = |c: u32| [&within, &through].iter().any(|s| s.get(c as usize) == Some(&true));
        let strays = self.liquid.runs.iter().filter(|r| stray(r.component));
        let leaked = |c: u32| !within[c as usize] && through[c as usize];
        let mut components: Vec<u32> = strays.clone().map(|r| r.component).collect();
        components.sort_unstable();
        components.dedup();
        SpuriousComponents {
            cells: strays.flat_map(|r| cells_of(&model.grid, r)).collect(),
            leaked: components.iter().copied().filter(|c| leaked(*c)).collect(),
            components,
        }
    }

    /// Flags components that have leaked through a solid: open faces connect none of their cells to liquid that was within reach. In a thin
    /// solid φ is extended from the nearer side, and where liquid on one side ends, that on the other may claim a cell of it.
    fn leaked_components(&self, model: &Model<D>, before: &Runs, reach: usize) -> Vec<bool> {
        if self.cut_cells.cells.is_empty() {
            return Vec::new();
        }
        let mut through = vec![true; self.liquid.components as usize];
        before.overlaps(&self.liquid).iter().for_each(|(_, new, _)| through[*new as usize] = false);
        if !through.contains(&true) {
            return through;
        }
        let (was, lattice) = (before.component_lookup(&model.grid), model.grid.lattice());
        let unreached = |cell: usize| {
            let at = lattice.coordinates(cell);
            let low = at.map(|i| i.saturating_sub(reach));
            let high = std::array::from_fn(|a| (at[a] + reach + 1).min(lattice.extent[a]));
            let side = self.cut_cells.connected_cells(at, [low, high]);
            side.into_iter().all(|p| was(lattice.index(p)).is_none())
        };
        for run in &self.liquid.runs {
            let through = &mut through[run.component as usize];
            *through = *through && cells_of(&model.grid, run).all(unreached);
        }
        through
    }

    /// Flags components that lie entirely within solids; empty without solids.
    fn components_inside_solids(&self) -> Vec<bool> {
        if self.cut_cells.cells.is_empty() {
            return Vec::new();
        }
        let mut within = vec![true; self.liquid.components as usize];
        for run in &self.liquid.runs {
            let within = &mut within[run.component as usize];
            *within = *within
                && cells_of(&self.cut_cells.open_fraction.grid, run)
                    .all(|c| self.cut_cells.distance_cells(c) < 0.0);
        }
        within
    }

    /// Pairs of a component at the tip of a wedge and the one that it belongs to: at an oblique solid a cell at the tip may
    /// share no face with the rest. A component on the other side of a thin solid is not paired.
    fn wedge_tips(&self, model: &Model<D>, state: &State<D>) -> Vec<(u32, u32)> {
        let (within, grid) = (self.components_inside_solids(), model.grid);
        let lattice = grid.lattice();
        let solids = Solids { model, states: &state.solids, surfaces: &self.surfaces };
        let depth = |x: &Vector<D>| -solids.liquid_distance(x);
        let across = |from: [usize; D], to: [usize; D]| {
            let (from, to) = (grid.center(from), grid.center(to));
            depth(&((from + to) * 0.5))
                > 0.5 * (depth(&from) + depth(&to)) + THIN_SOLID_DEPTH_EXCESS_CELLS * grid.dx
        };
        let component = self.liquid.component_lookup(&grid);
        let mut pairs = Vec::new();
        for run in self.liquid.runs.iter().filter(|r| within.get(r.component as usize) == Some(&true)) {
            for cell in cells_of(&grid, run).filter(|c| self.cut_cells.has_air_neighbour(*c, &state.phi.data))
            {
                let at = lattice.coordinates(cell);
                let low = at.map(|i| i.saturating_sub(1));
                let high = std::array::from_fn(|a| (at[a] + 2).min(lattice.extent[a]));
                let whole = |to: [usize; D]| component(lattice.index(to)).filter(|c| !within[*c as usize]);
                let around =
                    lattice_points([low, high]).filter_map(|to| whole(to).filter(|_| !across(at, to)));
                pairs.extend(around.min().map(|whole| (run.component, whole)));
            }
        }
        pairs
    }

    /// Resets the known faces to those of the liquid and extends the velocity from them.
    pub fn rebuild_velocity_extension(&mut self, model: &Model<D>, state: &mut State<D>) {
        self.reset_known_faces(model);
        self.extend_velocity(model, state);
    }

    /// Resets the known faces to those of the liquid.
    pub fn reset_known_faces(&mut self, model: &Model<D>) {
        let faces: [Vec<Segment>; D] = std::array::from_fn(|a| self.liquid.faces(&model.grid, a));
        self.known_faces.clear_marks();
        self.known_faces.set_liquid_faces(faces);
        self.known_faces.unmark_closed_faces(&self.cut_cells.closed_faces);
    }

    /// Extends the velocity from the liquid over the band. Returns the number of faces within solids that found no solid to slip along.
    pub fn extend_velocity(&mut self, model: &Model<D>, state: &mut State<D>) -> u64 {
        let distance = Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary());
        let closed = |a: usize, side: usize| model.walls[a][side] == crate::Wall::Slip;
        self.cut_face_velocities = self.known_faces.cut_face_velocities(&state.velocity, &self.cut_cells);
        self.swap_cut_face_velocities(&mut state.velocity);
        let (velocity, phi) = (&mut state.velocity, &state.phi.data);
        self.known_faces.extrapolate(velocity, &self.band, phi, &distance, closed);
        let mut unknown = 0;
        if !self.cut_cells.cells.is_empty() {
            let shut =
                self.known_faces.extend_into_closed_faces(&mut state.velocity, &self.cut_cells.closed_faces);
            unknown = impose_slip_velocity(model, state, &self.surfaces, &shut);
        }
        self.swap_cut_face_velocities(&mut state.velocity);
        unknown
    }

    /// Exchanges the velocities of faces that solids close in part with those that move the interface there.
    pub fn swap_cut_face_velocities(&mut self, velocity: &mut FaceField<D>) {
        for (values, u) in self.cut_face_velocities.iter_mut().zip(&mut velocity.axes) {
            values.iter_mut().for_each(|(face, value)| std::mem::swap(value, &mut u[*face as usize]));
        }
    }

    /// Contacts of each component. It touches a side if one of its cell centres lies within 0.75 cells of it.
    pub fn component_contacts(&self, model: &Model<D>) -> Vec<ComponentContacts> {
        let (near, [first, last]) = (0.75 * model.grid.dx, model.grid.bounds());
        let at_side = |(low, high): &(Vector<D>, Vector<D>)| {
            (0..D).any(|a| low[a] < first[a] + near || high[a] > last[a] - near)
        };
        let boxes = component_bounds(model, &self.liquid);
        let mut touching: Vec<ComponentContacts> = boxes
            .iter()
            .map(|b| ComponentContacts {
                domain_side: at_side(b),
                constrained_solid: false,
                free_solid: false,
            })
            .collect();
        let label = self.liquid.component_lookup(&model.grid);
        for w in &self.cut_cells.cells {
            if let Some(c) = label(w.cell as usize) {
                let free = model.solids[w.solid as usize].is_unconstrained();
                let touching = &mut touching[c as usize];
                if free { touching.free_solid = true } else { touching.constrained_solid = true }
            }
        }
        touching
    }

    /// For each component the fraction of the solid surface it wets that faces the directions of its projector in `parts`.
    pub fn facing_wetted_fraction(&self, parts: &[Matrix<D>]) -> Vec<f64> {
        let label = self.liquid.component_lookup(&self.cut_cells.open_fraction.grid);
        let mut sums = vec![(0.0, 0.0); parts.len()];
        for w in &self.cut_cells.cells {
            if let Some(c) = label(w.cell as usize).filter(|c| (*c as usize) < parts.len()) {
                let (faced, all) = &mut sums[c as usize];
                *faced += (parts[c as usize] * w.area_vector).norm();
                *all += w.area_vector.norm();
            }
        }
        sums.into_iter().map(|(faced, all)| faced / f64::max(all, f64::MIN_POSITIVE)).collect()
    }

    /// The volume correction of this liquid.
    pub fn volume_correction<'a>(
        &'a self,
        model: &'a Model<D>,
        labels: &'a [u32],
    ) -> VolumeCorrection<'a, D> {
        VolumeCorrection { model, dual_grid: &self.dual_grid, band: &self.band, cells: &self.liquid, labels }
    }
}

/// The cells of a run.
fn cells_of<const D: usize>(grid: &Grid<D>, run: &Run) -> std::ops::Range<usize> {
    let row = run.row as usize * grid.cells[0];
    row + run.start as usize..row + run.end as usize
}

/// Replaces the normal velocity on faces closed by solids by that of the nearest solid (slip condition). Faces without a solid
/// get zero velocity; returns their number.
fn impose_slip_velocity<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    surfaces: &SolidSurfaces<D>,
    shut: &[Vec<u32>; D],
) -> u64 {
    let flow = model.velocity_sampler(&state.velocity);
    let solids = Solids { model, states: &state.solids, surfaces };
    let new: [Vec<Option<f64>>; D] = std::array::from_fn(|a| {
        let lattice = model.grid.face_lattice(a);
        let slipping = |&f: &u32| {
            let x = model.grid.face_center(a, lattice.coordinates(f as usize));
            let solid = solids.get(solids.nearest(&x)?);
            let mut u = flow.linear(&x);
            u[a] = state.velocity.axes[a][f as usize];
            let [normal, velocity] = solid.normal_and_velocity(&x, 0.01 * model.grid.dx);
            Some(u[a] - normal[a] * (u - velocity).dot(&normal))
        };
        par::map_slice(&shut[a], 64, slipping)
    });
    for a in 0..D {
        let faces = shut[a].iter().zip(&new[a]);
        faces.for_each(|(f, u)| state.velocity.axes[a][*f as usize] = u.unwrap_or(0.0));
    }
    new.iter().flatten().filter(|u| u.is_none()).count() as u64
}

/// Bounding box of the cell centres of every component.
pub fn component_bounds<const D: usize>(model: &Model<D>, liquid: &Runs) -> Vec<(Vector<D>, Vector<D>)> {
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

/// Copy of the state before a step, from which [`Snapshot::restore`] rebuilds it after a failed one: φ in the band, the liquid's velocity,
/// and all but the dense fields. Everything else follows from these, except φ in the cells of [`Workspace::overwritten_phi`].
pub struct Snapshot<const D: usize> {
    tiles: Tiles<D>,
    liquid: Runs,
    band_cells: Vec<u32>,
    phi: Vec<f64>,
    velocity: FaceValues<D>,
    /// The state with empty fields.
    rest: State<D>,
    /// The whole state with the scheme of the paper, which changes φ beyond the band.
    whole: Option<State<D>>,
}

type FaceValues<const D: usize> = [Vec<(usize, Vec<f64>)>; D];

impl<const D: usize> Snapshot<D> {
    /// Copies the data that the coming step may overwrite.
    pub fn take(model: &Model<D>, state: &mut State<D>, workspace: &mut Workspace<D>) -> Self {
        workspace.overwritten_phi.clear();
        let band_cells = workspace.band.cells.clone();
        let phi = par::map_slice(&band_cells, 256, |&c| state.phi.data[c as usize]);
        let velocity = std::array::from_fn(|a| {
            let row = model.grid.face_lattice(a).extent[0];
            let values = |s: &Segment| {
                let at = s.row * row + s.start;
                (at, state.velocity.axes[a][at..at + s.end - s.start].to_vec())
            };
            par::map_slice(&workspace.known_faces.liquid_faces()[a], 64, values)
        });
        let whole = workspace.paper.is_some().then(|| state.clone());
        let fields = state.take_fields();
        let rest = state.clone();
        state.put_fields(fields);
        let (tiles, liquid) = (workspace.tiles.clone(), workspace.liquid.clone());
        Self { tiles, liquid, band_cells, phi, velocity, rest, whole }
    }

    /// Restores the state and the workspace.
    pub fn restore(self, model: &Model<D>, state: &mut State<D>, workspace: &mut Workspace<D>) {
        if let Some(whole) = self.whole {
            *state = whole;
            workspace.tiles = self.tiles;
            workspace.update_solids(model, state);
            workspace.find_liquid(model, state);
            return workspace.rebuild_velocity_extension(model, state);
        }
        let limit = BAND_WIDTH_CELLS * model.grid.dx;
        for &cell in &workspace.band.cells {
            let value = &mut state.phi.data[cell as usize];
            *value = limit.copysign(*value);
        }
        self.band_cells.iter().zip(&self.phi).for_each(|(&c, v)| state.phi.data[c as usize] = *v);
        workspace.known_faces.clear_with_velocity(&mut state.velocity);
        for (a, stretches) in self.velocity.into_iter().enumerate() {
            for (at, values) in stretches {
                state.velocity.axes[a][at..at + values.len()].copy_from_slice(&values);
            }
        }
        let fields = state.take_fields();
        *state = self.rest;
        state.put_fields(fields);
        // The pressure of a failed solve is no initial guess.
        state.pressure_impulse = CellField::new(model.grid, 0.0);
        // The tiles of the failed step need not cover the liquid and its cut cells.
        workspace.tiles = self.tiles.clone();
        workspace.update_solids(model, state);
        workspace.find_liquid(model, state);
        // Known defect: outside the band φ within solids keeps the signs of the failed step, unless the number of components is then
        // wrong. If all are restored, `verify leak` finds stale liquid in moving thin walls.
        if workspace.liquid.components as usize != state.components.len() {
            // Boxes of solids overlap, so a cell may be listed twice: its first entry is the φ before the step.
            workspace
                .overwritten_phi
                .iter()
                .rev()
                .for_each(|(cell, value)| state.phi.data[*cell as usize] = *value);
            self.band_cells.iter().zip(&self.phi).for_each(|(&c, v)| state.phi.data[c as usize] = *v);
            workspace.tiles = self.tiles;
            workspace.find_liquid(model, state);
        }
        // A wrong number of components would make the next step panic: if φ does not give that of the state,
        // the liquid cells from before the step are used.
        if workspace.liquid.components as usize != state.components.len() {
            workspace.liquid = self.liquid;
            workspace.band.rebuild(&state.phi.data, &workspace.liquid, BAND_LAYERS);
        }
        workspace.rebuild_velocity_extension(model, state);
    }
}

#[cfg(test)]
#[path = "workspace_tests.rs"]
mod tests;
