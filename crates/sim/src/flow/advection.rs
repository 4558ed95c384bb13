//! Semi-Lagrangian advection of φ and `u`: their new values at `x` are those at the departure point of the path to `x` ([`super::paths`]).

use super::paths::{Beside, CellPaths, departure_point, pack};
use crate::model::Model;
use meniscus_numerics::grid::{
    Band, CellField, CutCells, FaceField, Grid, Runs, Sampler, Segment, VelocitySampler,
};
use meniscus_numerics::lanes::{
    ALL_LANES, Instructions, LANES, LaneWork, Lanes, VectorLanes, run_with_widest,
};
use meniscus_numerics::{Vector, par};

/// Distance from the interface, in cells, within which paths use cubic interpolation of the velocity.
const CUBIC_INTERPOLATION_DISTANCE_CELLS: f64 = 2.5;

/// |∇φ| below which an air cell lies between two fronts. At the ridge it is the cosine of half the angle between their normals, so 0.5
/// means a wedge of 60 degrees. With 0.9 (130 degrees) the groove around a new contact filled with liquid (3 % of the volume in eight
/// steps).
const RIDGE_GRADIENT_NORM: f64 = 0.5;

/// Distance from a cell, in cells, that the stencil at its departure point reaches along an axis: two cells, and a path of at most a cell
/// at the default Courant number. Its corners, `√D` times as far, are not looked at.
const STENCIL_REACH_CELLS: f64 = 3.0;

/// Advected values of φ in the segments of the band, one behind the other.
///
/// φ within a solid continues the surface of one side. If the values that open faces connect to a cell near a solid have one sign, the
/// cell reads only these: else the surface of one side would appear on the other (experiment E36).
///
/// In a gap of one cell between two fronts the extended velocity is their mean, close to zero, so that the air cushion would never
/// close. There each front moves with the velocity of the adjacent liquid cell, and the nearer front counts.
pub fn advect_interface<const D: usize>(
    model: &Model<D>,
    phi: &CellField<D>,
    band: &Band<D>,
    velocity: &FaceField<D>,
    cut: &CutCells<D>,
    dt: f64,
) -> Vec<f64> {
    let (grid, flow) = (&model.grid, model.velocity_sampler(velocity));
    let distance = Sampler::cells(grid, &phi.data, model.scalar_boundary());
    let (lattice, first_layer) = (grid.lattice(), band.first_layers(1).end);
    let packed = pack(&band.segments);
    let mut values = vec![0.0; packed.last().map_or(0, |s| s.end)];
    let inputs = InterfaceInputs { grid, flow: &flow, distance: &distance, phi, band, first_layer, cut, dt };
    par::for_each_segment(&mut values, 0, &packed, |s, part| {
        let from = &band.segments[s.row];
        let mut at = lattice.coordinates(from.row * lattice.extent[0]);
        at[0] = from.start;
        run_with_widest(InterfaceSegment { inputs: &inputs, at, part });
    });
    values
}

/// The fields and the step length from which the interface is advected.
struct InterfaceInputs<'a, const D: usize> {
    grid: &'a Grid<D>,
    flow: &'a VelocitySampler<'a, D>,
    distance: &'a Sampler<'a, D>,
    phi: &'a CellField<D>,
    band: &'a Band<D>,
    /// Number of cells in the first layer of the band.
    first_layer: usize,
    cut: &'a CutCells<D>,
    dt: f64,
}

/// Values of φ in consecutive cells of the band, from `at` on.
struct InterfaceSegment<'a, const D: usize> {
    inputs: &'a InterfaceInputs<'a, D>,
    at: [usize; D],
    part: &'a mut [f64],
}

impl<const D: usize> LaneWork for InterfaceSegment<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self, with: I) {
        let Self { inputs, mut at, part } = self;
        let InterfaceInputs { grid, flow, distance, phi, dt, .. } = *inputs;
        let (lattice, start) = (grid.lattice(), at[0]);
        for i in (0..part.len()).step_by(LANES) {
            at[0] = start + i;
            let cell = lattice.index(at);
            let departure = departure_points(flow, grid, at, Lanes::load(with, &phi.data, cell), dt);
            distance.distance_lanes(&departure).store(part, i);
            for (l, (value, departure)) in part[i..].iter_mut().zip(departure.to_array()).enumerate() {
                let mut at = at;
                at[0] += l;
                inputs.correct(value, cell + l, at, &departure);
            }
        }
    }
}

impl<const D: usize> InterfaceInputs<'_, D> {
    /// Replaces the advected value between two fronts, and where the stencil may see the surface of the other side of a solid.
    fn correct(&self, value: &mut f64, cell: usize, at: [usize; D], departure: &Vector<D>) {
        let is_at_interface = self.band.slot(cell).is_some_and(|slot| slot < self.first_layer);
        if is_at_interface
            && self.phi.data[cell] >= 0.0
            && self.distance.gradient(at).norm() < RIDGE_GRADIENT_NORM
        {
            *value = nearer_front(self.flow, self.distance, self.grid, self.phi, at, self.dt);
        } else if (0.0..STENCIL_REACH_CELLS).contains(&self.cut.distance_cells(cell)) {
            *value = self.distance.distance_on_side(departure, |first| own_side(self.cut, at, first));
        }
    }
}

/// Departure points of the paths that arrive at consecutive cells of a row, from `at` on, where φ has the values `phi`.
#[inline(always)]
fn departure_points<I: Instructions, const D: usize>(
    flow: &VelocitySampler<'_, D>,
    grid: &Grid<D>,
    at: [usize; D],
    phi: Lanes<I>,
    dt: f64,
) -> VectorLanes<I, D> {
    let with = phi.instructions();
    let x = grid.centers(with, at);
    let is_near = phi.abs().less_than(Lanes::splat(with, CUBIC_INTERPOLATION_DISTANCE_CELLS * grid.dx));
    let bits = is_near.bits();
    let mut departure = x;
    if bits != 0 {
        departure = departure_point(x, flow.cubic_at_cells(with, at), dt, |x| flow.cubic_lanes(x));
    }
    if bits != ALL_LANES {
        let far = departure_point(x, flow.at_cells(with, at), dt, |x| flow.linear_lanes(x));
        departure = VectorLanes::select(is_near, departure, far);
    }
    departure
}

/// Advected value of φ in an air cell between two fronts: that of the nearer front, which moves with its liquid cell.
fn nearer_front<const D: usize>(
    flow: &VelocitySampler<'_, D>,
    distance: &Sampler<'_, D>,
    grid: &Grid<D>,
    phi: &CellField<D>,
    at: [usize; D],
    dt: f64,
) -> f64 {
    let (lattice, x) = (grid.lattice(), grid.center(at));
    let liquid = lattice.neighbours(lattice.index(at)).filter(|n| phi.data[*n] < 0.0);
    let fronts = liquid.map(|n| {
        let liquid = lattice.coordinates(n);
        let (beside, arrival) = (grid.center(liquid), flow.cubic_at_cell(liquid));
        let departure = departure_point(beside, arrival, dt, |x| flow.cubic(x));
        distance.distance(&(x + departure - beside))
    });
    fronts.fold(f64::INFINITY, f64::min)
}

/// The points of a stencil (4 along each axis from `first` on, a bit each) outside solids that open faces connect to the cell `at`; none if
/// the stencil does not contain it.
fn own_side<const D: usize>(cut: &CutCells<D>, at: [usize; D], first: [isize; D]) -> u64 {
    let lattice = cut.open_fraction.grid.lattice();
    let low: [usize; D] = std::array::from_fn(|a| first[a].max(0) as usize);
    let high: [usize; D] = std::array::from_fn(|a| lattice.extent[a].min((first[a] + 4).max(0) as usize));
    if (0..D).any(|a| !(low[a]..high[a]).contains(&at[a])) {
        return 0;
    }
    let outside = |p: &&[usize; D]| cut.distance_cells(lattice.index(**p)) >= 0.0;
    let bit = |p: &[usize; D]| (0..D).rev().fold(0, |bit, a| 4 * bit + (p[a] as isize - first[a]));
    cut.connected_cells(at, [low, high]).iter().filter(outside).map(|p| 1 << bit(p)).sum()
}

/// Depth, in cells, up to which the interpolation of the velocity along an axis reads extrapolated values: it reads faces up to two cells
/// away, and faces are known to half a cell beyond the interface. Limit: the departure points of deeper liquid are not corrected.
const EXTRAPOLATION_REACH_CELLS: f64 = 1.5;

/// The signed distance before a step and after it.
struct Depths<'a, const D: usize> {
    cells_before: &'a CellField<D>,
    before: Sampler<'a, D>,
    after: Sampler<'a, D>,
    cut: &'a CutCells<D>,
}

impl<const D: usize> Depths<'_, D> {
    /// The departure points of the liquid that arrives at `count` consecutive faces normal to `axis`, from `face` on, moved back into the
    /// liquid to the depth that it has after the step.
    ///
    /// Near the interface liquid keeps its depth where the interface moves with the flow. Where the contact angle, hysteresis or the volume
    /// correction hold the interface against an inflow, the path would begin beyond it, in the extrapolated velocity. With the slope `s`
    /// behind the surface and the Courant number `c`, the velocity would grow by `c s` in each step, without a bound (experiment E7).
    #[inline(always)]
    fn corrected<I: Instructions>(
        &self,
        departure: VectorLanes<I, D>,
        axis: usize,
        face: [usize; D],
        count: usize,
    ) -> VectorLanes<I, D> {
        let with = departure.instructions();
        let is_deep = self.are_deep(&departure, face);
        if is_deep & ((1 << count) - 1) == (1 << count) - 1 {
            return departure;
        }
        let (departure, first) = (departure.to_array(), face[0]);
        VectorLanes::from_fn(with, |l| {
            if l >= count || is_deep >> l & 1 == 1 {
                return departure[l];
            }
            let mut face = face;
            face[0] = first + l;
            self.corrected_at_interface(departure[l], axis, face)
        })
    }

    /// The bits of the lanes whose departure points are certainly too deep for a correction. Away from solids φ is a distance, which
    /// changes by no more than the way, and of which linear interpolation is off by less than a cell.
    #[inline(always)]
    fn are_deep<I: Instructions>(&self, departure: &VectorLanes<I, D>, face: [usize; D]) -> u32 {
        let with = departure.instructions();
        let grid = &self.cut.open_fraction.grid;
        let deep = Lanes::splat(with, -(EXTRAPOLATION_REACH_CELLS + 1.0) * grid.dx);
        let mut at: [usize; D] = std::array::from_fn(|a| face[a].min(grid.cells[a] - 1));
        at[0] = 0;
        let (row, last) = (grid.lattice().index(at), grid.cells[0] - 1);
        at[0] = face[0];
        let mut is_deep = 0;
        if face[0] + LANES <= last {
            let depth = Lanes::load(with, &self.cells_before.data, row + face[0]);
            is_deep = (depth + (*departure - grid.centers(with, at)).norms()).less_than(deep).bits();
        }
        if is_deep != ALL_LANES {
            is_deep |= self.before.linear_lanes(departure).less_than(deep).bits();
        }
        let is_far = |l: &usize| self.cut.distance_cells(row + (face[0] + l).min(last)) > STENCIL_REACH_CELLS;
        is_deep & (0..LANES).filter(is_far).map(|l| 1 << l).sum::<u32>()
    }

    /// The departure point of the liquid that arrives at a face, moved back to the depth that it has after the step.
    fn corrected_at_interface(&self, departure: Vector<D>, axis: usize, face: [usize; D]) -> Vector<D> {
        let grid = &self.cut.open_fraction.grid;
        let before = self.before.distance(&departure);
        if before < -EXTRAPOLATION_REACH_CELLS * grid.dx {
            return departure;
        }
        let excess = before - self.after.distance_at_face(grid, axis, face);
        if excess <= 0.0 {
            return departure;
        }
        let gradient = self.before.distance_with_gradient(&departure).1;
        gradient.try_normalize(0.0).map_or(departure, |normal| departure - normal * excess)
    }
}

/// The cells of the liquid and their faces.
#[derive(Clone, Copy)]
pub struct LiquidFaces<'a, const D: usize> {
    /// The cells.
    pub cells: &'a Runs,
    /// Their faces normal to each axis.
    pub faces: &'a [Vec<Segment>; D],
}

/// Advected velocity on the faces of the `liquid`: one list of values per axis, segment after segment. `phi` is the signed distance before
/// the step and after it, `cut` are the cells beside solids.
///
/// The bend of the path that arrives at a face is the mean of those at the two cells beside it. The difference from a path of its own is of
/// second order in the cell size and in the step.
pub fn advect_velocity<const D: usize>(
    model: &Model<D>,
    phi: [&CellField<D>; 2],
    velocity: &FaceField<D>,
    liquid: LiquidFaces<'_, D>,
    cut: &CutCells<D>,
    dt: f64,
) -> [Vec<f64>; D] {
    let (grid, flow) = (&model.grid, model.velocity_sampler(velocity));
    let [before, after] = phi.map(|phi| Sampler::cells(grid, &phi.data, model.scalar_boundary()));
    let depths = Depths { cells_before: phi[0], before, after, cut };
    let LiquidFaces { cells: liquid, faces } = liquid;
    let paths = CellPaths::new(grid, &flow, liquid, dt);
    std::array::from_fn(|axis| {
        let (lattice, cells) = (grid.face_lattice(axis), grid.lattice());
        let packed = pack(&faces[axis]);
        let mut values = vec![0.0; packed.last().map_or(0, |s| s.end)];
        par::for_each_segment(&mut values, 0, &packed, |s, part| {
            let from = &faces[axis][s.row];
            let mut at = lattice.coordinates(from.row * lattice.extent[0]);
            at[0] = from.start;
            let beside = Beside::new(&paths, &cells, axis, at);
            run_with_widest(VelocitySegment {
                grid,
                flow: &flow,
                depths: &depths,
                beside,
                axis,
                dt,
                at,
                part,
            });
        });
        values
    })
}

/// Advected velocity on consecutive faces normal to `axis`, from `at` on.
struct VelocitySegment<'a, const D: usize> {
    grid: &'a Grid<D>,
    flow: &'a VelocitySampler<'a, D>,
    depths: &'a Depths<'a, D>,
    beside: Beside<'a, D>,
    axis: usize,
    dt: f64,
    at: [usize; D],
    part: &'a mut [f64],
}

impl<const D: usize> LaneWork for VelocitySegment<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self, with: I) {
        let Self { grid, flow, depths, beside, axis, dt, mut at, part } = self;
        let start = at[0];
        for i in (0..part.len()).step_by(LANES) {
            at[0] = start + i;
            let straight = grid.face_centers(with, axis, at) - flow.at_faces(with, axis, at) * dt;
            let departure = straight - beside.mean_bends(with, i);
            let count = LANES.min(part.len() - i);
            let departure = depths.corrected(departure, axis, at, count);
            flow.component(axis).cubic_lanes(&departure).store(part, i);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::workspace::Workspace;
    use crate::state::State;
    use meniscus_numerics::grid::{Grid, scatter_segments};

    /// Largest speed after `steps` steps of transport in a layer whose top face row flows in at the speed 1, the others at 0.1. The
    /// interface is `held` where it is, or moves with the flow.
    fn speed_after(steps: usize, held: bool) -> f64 {
        let model = Model::of_test(Grid::<2>::new([16, 32], 1.0), Vec::new());
        let (mut state, lattice) = (State::empty(model.grid), model.grid.lattice());
        for i in 0..lattice.len() {
            state.phi.data[i] = (lattice.coordinates(i)[1] as f64 - 15.5).clamp(-5.0, 5.0);
        }
        let mut work = Workspace::new(&model, &mut state);
        let faces = model.grid.face_lattice(1);
        for f in 0..faces.len() {
            state.velocity.axes[1][f] = match faces.coordinates(f)[1] {
                16 => -1.0,
                y if y > 0 && y < 16 => -0.1,
                _ => 0.0,
            };
        }
        for _ in 0..steps {
            work.rebuild_velocity_extension(&model, &mut state);
            let values =
                advect_interface(&model, &state.phi, &work.band, &state.velocity, &work.cut_cells, 0.1);
            let mut phi = state.phi.clone();
            if !held {
                scatter_segments(&mut phi.data, model.grid.cells[0], &work.band.segments, &values);
            }
            let segments = work.known_faces.liquid_faces().clone();
            let phis = [&state.phi, &phi];
            let liquid = LiquidFaces { cells: &work.liquid, faces: &segments };
            let moved = advect_velocity(&model, phis, &state.velocity, liquid, &work.cut_cells, 0.1);
            for (a, axis) in moved.iter().enumerate() {
                let row = model.grid.face_lattice(a).extent[0];
                let own = segments[a].iter().flat_map(|s| s.row * row + s.start..s.row * row + s.end);
                own.zip(axis).for_each(|(f, v)| state.velocity.axes[a][f] = *v);
            }
            if !held {
                state.phi = phi;
                work.find_liquid(&model, &state);
            }
        }
        let row = faces.extent[0];
        let liquid = work.known_faces.liquid_faces()[1].iter();
        let speeds = liquid.flat_map(|s| &state.velocity.axes[1][s.row * row + s.start..s.row * row + s.end]);
        speeds.fold(0.0, |most, v| most.max(v.abs()))
    }

    /// Without the correction the speed is about `1.1^30 = 17`: it grows by the Courant number in each step.
    #[test]
    fn inflow_through_a_held_interface_does_not_grow() {
        let most = speed_after(30, true);
        assert!(most < 1.05, "{most}");
    }

    /// No value is larger than that extrapolated in the first step, `2 · 1 − 0.1`.
    #[test]
    fn a_jet_that_moves_with_its_interface_does_not_exceed_the_extrapolated_speed() {
        let most = speed_after(10, false);
        assert!(most < 1.9, "{most}");
    }
}
