//! Extension of the free surface into solids at the contact angle.
//!
//! Stencils at a solid's surface reach into it, and a moving solid uncovers cells that were within. In a solid φ tends to the
//! continuation of the surface at the contact angle `θ`: from a point at depth `d` the direction `w = n sin θ − t cos θ`, with
//! the solid's normal `n` and the direction `t` of φ's gradient along the solid, leads to a point above the solid with the same
//! value. The continuation is an arc: it turns as the surface does between the solid, where it has the contact angle, and that
//! point. If it is straight, the kink in φ makes redistancing pull the line back in every step, the more often the shorter the
//! steps (a base radius 0.6 % short where the surface turns within four cells).
//!
//! A plate of a few cells is thinner than the stencils of its two sides. Where the nearest side is clear of any surface, its
//! closed cells take the continuation of the opposite side, within bounds that keep the sign change inside the plate; cells
//! beside them on the nearest side ignore that sign change (`raise_clear_cells`).
//!
//! A line with friction `ζ` that moves at the speed `U` has the angle `cos θ = cos θ_Y − ζ U/γ`: with Young's angle the
//! continuation would carry the line past the liquid that friction holds back. A pinned line keeps its angle.

use crate::model::Model;
use crate::model::resolution::{BAND_WIDTH_CELLS, GRADIENT_NORM_TOLERANCE};
use crate::model::time_step::MAX_DT_GROWTH;
use crate::solid::{SolidKind, SolidSurfaces, Solids};
use crate::state::State;
use meniscus_numerics::grid::{Band, CutCells, Sampler, VelocitySampler, lattice_points};
use meniscus_numerics::{Vector, par};
use std::f64::consts::PI;

/// Fraction of the difference to the continuation that φ takes in a step: 1 lifts drops off, 0 keeps stale values.
const RELAXATION: f64 = 0.1;
/// Depth, in cells, within which a moving solid may uncover a cell in a step or two.
const MAX_EXPOSED_DEPTH_CELLS: f64 = 3.0;
/// Height above a solid, in cells, at which the surface is sampled. If it is farther away, no surface meets the solid below, and
/// stale liquid within is removed at once. Else a dry side that moves faster than stale values fade would look wetted.
const SAMPLE_HEIGHT_CELLS: f64 = 1.0;
/// Depth, in cells, under a side up to which its continuation counts: stencils reach no farther.
const MAX_OPPOSITE_DEPTH_CELLS: f64 = 2.5;
/// Bound `b` of |φ| over the depth, in cells that take the opposite continuation. Between there and a clear
/// cell at the height `s` (cells) on the nearest side, where |φ| is at least [`SAMPLE_HEIGHT_CELLS`] plus `s`,
/// the sign changes within the solid if `b ≤ 1 + 1/s`. In 3D `s` is below `√3` less
/// [`MIN_COVERED_DEPTH_CELLS`], so that up to 1.67 would do.
const MAX_PHI_DEPTH_RATIO: f64 = 1.5;
/// The same beside cells that are not clear: the sign changes half-way between two distances.
const UNCLEAR_PHI_DEPTH_RATIO: f64 = 0.5;
/// Depth, in cells, up to which a surface steeper than 45 degrees that reaches a cell passes between its open neighbours.
const SHALLOW_DEPTH_CELLS: f64 = 0.6;
/// Depth, in cells, in excess of what a solid uncovers in a step, above which a cell may take the opposite continuation. A cell that
/// becomes shallower by more than this in a step takes the sign of its side at once.
const MIN_COVERED_DEPTH_CELLS: f64 = 0.25;
/// Smallest sine of the angle of the continuation.
const MIN_CONTINUATION_SINE: f64 = 0.25;
/// Bound of the continuation's turning per cell of depth, rad: that of a surface with a radius of two cells.
const MAX_TURN_PER_CELL: f64 = 0.5;

/// A cell with its centre in a solid, and where the surface's continuation through it leaves the solid.
#[derive(Clone, Copy, Debug)]
pub struct GhostCell<const D: usize> {
    /// Slot in the band.
    pub slot: u32,
    /// A point of the continuation outside the solid, m.
    pub exit_point: Vector<D>,
    /// Ratio of φ here to φ at the exit point with which φ is a distance along the solid.
    phi_scale: f64,
    /// Whether none of its faces is open.
    is_closed: bool,
    /// Whether the solid uncovers it before stale values have faded.
    is_exposed: bool,
    /// Whether it may also hold a value of the opposite side: it is exposed and shallow, and its solid is thin.
    thin: bool,
    /// Normal of the nearest side where the continuation is that of the opposite side of a thin solid.
    nearest_normal: Option<Vector<D>>,
}

/// Finds the cells of the band within solids.
pub fn ghost_cells<const D: usize>(
    solids: Solids<'_, D>,
    state: &State<D>,
    band: &Band<D>,
    cut: &CutCells<D>,
) -> Vec<GhostCell<D>> {
    let model = solids.model;
    let surface = InterfaceSampler {
        solids,
        phi: Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary()),
        velocity: model.velocity_sampler(&state.velocity),
        max_next_dt: state.last_dt * MAX_DT_GROWTH,
    };
    let within = |c: &u32| cut.distance_cells(*c as usize) < 0.0;
    let slots: Vec<u32> = (0..band.cells.len() as u32).filter(|s| within(&band.cells[*s as usize])).collect();
    let ghost = |slot: u32| {
        let cell = band.cells[slot as usize] as usize;
        let at = model.grid.lattice().coordinates(cell);
        surface.ghost_cell(
            slot,
            &model.grid.center(at),
            -cut.distance_cells(cell) * model.grid.dx,
            cut.is_closed(at),
        )
    };
    par::filter_map(slots.len(), 64, |i| ghost(slots[i]))
}

/// The free surface, the solids and their motion.
struct InterfaceSampler<'a, const D: usize> {
    solids: Solids<'a, D>,
    phi: Sampler<'a, D>,
    velocity: VelocitySampler<'a, D>,
    /// Bound of the next step's length, s.
    max_next_dt: f64,
}

/// A side of a solid that a point lies under.
struct SolidSide<const D: usize> {
    /// Index of the solid.
    solid: usize,
    /// Its normal.
    normal: Vector<D>,
    /// Depth of the point, m.
    depth: f64,
}

impl<const D: usize> InterfaceSampler<'_, D> {
    /// The continuation through a point at a depth (m): that of the nearest side or, in closed cells of thin solids, of the
    /// opposite side.
    fn ghost_cell(&self, slot: u32, x: &Vector<D>, depth: f64, is_closed: bool) -> Option<GhostCell<D>> {
        let dx = self.solids.model.grid.dx;
        let solid = self.solids.nearest(x)?;
        let [normal, velocity] = self.solids.get(solid).normal_and_velocity(x, 0.01 * dx);
        // Half-way between two sides of a solid there is no normal.
        let normal = normal.try_normalize(0.5)?;
        let near = SolidSide { solid, normal, depth };
        let (exit_point, phi_scale) = self.exit_point(x, &near);
        let way = velocity.norm() * self.max_next_dt;
        let is_exposed = way > RELAXATION * MIN_COVERED_DEPTH_CELLS * dx;
        let thin = is_exposed && depth < SHALLOW_DEPTH_CELLS * dx && self.opposite_side(x, &near).is_some();
        let own =
            GhostCell { slot, exit_point, phi_scale, is_closed, is_exposed, thin, nearest_normal: None };
        let seen = |at: &Vector<D>| self.phi.distance_with_gradient(at).0 / dx;
        let here = seen(&exit_point);
        let covered = depth > MIN_COVERED_DEPTH_CELLS * dx + way;
        if !is_closed || !covered || here.abs() < SAMPLE_HEIGHT_CELLS {
            return Some(own);
        }
        let Some(far) = self.opposite_side(x, &near) else { return Some(own) };
        let (exit_point, phi_scale) = self.exit_point(x, &far);
        let there = seen(&exit_point);
        // A surface nearer to the exit point than this is real: the sign change within the solid is farther away.
        let takes_opposite = there.abs() < SAMPLE_HEIGHT_CELLS || (here > 0.0 && there < 0.0);
        Some(if takes_opposite {
            GhostCell { exit_point, phi_scale, nearest_normal: Some(normal), ..own }
        } else {
            own
        })
    }

    /// The opposite side of a thin solid; `None` if the solid is thick.
    fn opposite_side(&self, x: &Vector<D>, near: &SolidSide<D>) -> Option<SolidSide<D>> {
        let dx = self.solids.model.grid.dx;
        let solid = self.solids.get(near.solid);
        let beyond = x - near.normal * (MAX_OPPOSITE_DEPTH_CELLS * dx);
        let height = solid.liquid_distance(&beyond);
        let normal = if height > 0.0 { solid.normal(&beyond, 0.01 * dx).try_normalize(0.5) } else { None }?;
        (normal.dot(&near.normal) < 0.0).then_some(SolidSide {
            depth: MAX_OPPOSITE_DEPTH_CELLS * dx - height,
            normal,
            ..*near
        })
    }

    /// Direction along a solid in which φ rises. It has unit length, or less where φ rises by less than the error of its gradient
    /// ([`GRADIENT_NORM_TOLERANCE`]), as beside a film without a line. The gradient is a difference over two cells: at a point of
    /// a film it changes sign with ripples of a hundredth of a cell.
    fn tangential_gradient(&self, x: &Vector<D>, normal: &Vector<D>) -> Vector<D> {
        let dx = self.solids.model.grid.dx;
        let slope: Vector<D> = Vector::from_fn(|a, _| {
            let step: Vector<D> = Vector::from_fn(|b, _| if a == b { dx } else { 0.0 });
            (self.phi.linear(&(x + step)) - self.phi.linear(&(x - step))) / (2.0 * dx)
        });
        let along = slope - normal * slope.dot(normal);
        along / along.norm().max(GRADIENT_NORM_TOLERANCE)
    }

    /// Exit point of the continuation through a point under a side, and the `phi_scale` within.
    fn exit_point(&self, x: &Vector<D>, side: &SolidSide<D>) -> (Vector<D>, f64) {
        let (dx, normal, depth) = (self.solids.model.grid.dx, side.normal, side.depth);
        let solid = self.solids.get(side.solid);
        let way = depth + SAMPLE_HEIGHT_CELLS * dx;
        let slope = self.phi.distance_with_gradient(&(x + normal * way)).1;
        let along = self.tangential_gradient(&(x + normal * way), &normal);
        let outside = |angle: f64| x + (normal - along * (angle.cos() / angle.sin())) * way;
        let angle = |slope: &Vector<D>| (slope.dot(&normal) / slope.norm().max(0.5)).clamp(-1.0, 1.0).acos();
        let steepest = MIN_CONTINUATION_SINE.asin();
        let bound = |angle: f64| angle.clamp(steepest, PI - steepest);
        let (mut cosine, rests) =
            solid.hysteretic_cosine(solid.young_cosine_near(x, dx), angle(&slope).cos());
        if solid.line_friction > 0.0 && !rests {
            let at = outside(bound(cosine.clamp(-1.0, 1.0).acos()));
            let speed = (self.velocity.linear(&at) - solid.velocity_at(&at)).dot(&along);
            cosine -= solid.line_friction * speed / self.solids.model.surface_tension;
        }
        let foot = bound(cosine.clamp(-1.0, 1.0).acos());
        let above = bound(angle(&self.phi.distance_with_gradient(&outside(foot)).1));
        // The chord of an arc whose angle is linear in height.
        let turn = ((above - foot) / SAMPLE_HEIGHT_CELLS).clamp(-MAX_TURN_PER_CELL, MAX_TURN_PER_CELL);
        let chord = bound(foot + 0.5 * turn * (SAMPLE_HEIGHT_CELLS - depth / dx));
        (outside(chord), foot.sin() / above.sin())
    }
}

/// Result of [`extend_into_solids`], apart from φ in the band.
pub struct ExtensionResult {
    /// Cells whose φ is no distance, sorted: those that keep the sides of thin solids apart.
    pub non_distance_cells: Vec<u32>,
    /// Cells outside the band that were overwritten, with their old φ.
    pub overwritten_phi: Vec<(u32, f64)>,
}

/// Relaxes φ in the band's cells within solids to the surface's continuation. `before` are the solids before they moved, `surfaces` the
/// surfaces of the solids now.
pub fn extend_into_solids<const D: usize>(
    state: &mut State<D>,
    band: &Band<D>,
    cut: &CutCells<D>,
    before: Solids<'_, D>,
    surfaces: &SolidSurfaces<D>,
) -> ExtensionResult {
    let model = before.model;
    let now = Solids { model, states: &state.solids, surfaces };
    let ghosts = ghost_cells(now, state, band, cut);
    let sampler = Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary());
    let seen = |g: &GhostCell<D>| sampler.distance_with_gradient(&g.exit_point).0;
    let all = par::map_slice(&ghosts, 64, seen);
    let high = SAMPLE_HEIGHT_CELLS * model.grid.dx;
    let mut across = Vec::new();
    for (ghost, seen) in ghosts.iter().zip(all) {
        let cell = band.cells[ghost.slot as usize] as usize;
        let value = state.phi.data[cell];
        let stale = value * seen < 0.0
            && (ghost.nearest_normal.is_some()
                || seen > high
                || ((ghost.is_closed || ghost.is_exposed) && seen < -high)
                || (ghost.thin && is_isolated(model, &state.phi.data, cut, cell))
                || has_moved_away([before, now], cell));
        let value = value + if stale { seen - value } else { RELAXATION * (ghost.phi_scale * seen - value) };
        state.phi.data[cell] = value;
        if let Some(normal) = ghost.nearest_normal {
            let beside = open_neighbours(model, cut, cell).filter(|(_, way)| way.dot(&normal) > 0.0);
            across.push((cell as u32, beside.map(|(c, _)| c as u32).collect::<Vec<_>>()));
        }
    }
    let non_distance_cells = separate_sides(model, &mut state.phi.data, cut, across);
    let moving = model.solids.iter().any(|s| !matches!(s.kind, SolidKind::Fixed));
    ExtensionResult {
        non_distance_cells,
        overwritten_phi: if moving { extend_signs_beyond_band(model, state, band, cut) } else { Vec::new() },
    }
}

/// Bounds φ in the cells with the opposite continuation, given with the open cells beside them, and raises φ in those that are
/// clear. Returns all cells whose φ is then no distance, sorted.
fn separate_sides<const D: usize>(
    model: &Model<D>,
    phi: &mut [f64],
    cut: &CutCells<D>,
    across: Vec<(u32, Vec<u32>)>,
) -> Vec<u32> {
    let clear = raise_clear_cells(model, phi, cut, across.iter().flat_map(|a| &a.1).copied().collect());
    for (cell, beside) in &across {
        let all = beside.iter().all(|c| clear.binary_search(c).is_ok());
        let bound = -cut.distance_cells(*cell as usize)
            * model.grid.dx
            * if all { MAX_PHI_DEPTH_RATIO } else { UNCLEAR_PHI_DEPTH_RATIO };
        let value = &mut phi[*cell as usize];
        *value = value.clamp(-bound, bound);
    }
    let mut apart: Vec<u32> = across.into_iter().map(|a| a.0).chain(clear).collect();
    apart.sort_unstable();
    apart
}

/// The cells around a cell that no solid covers, and the offsets to them, in cells.
fn open_neighbours<const D: usize>(
    model: &Model<D>,
    cut: &CutCells<D>,
    cell: usize,
) -> impl Iterator<Item = (usize, Vector<D>)> {
    let lattice = model.grid.lattice();
    let at = lattice.coordinates(cell);
    let low = at.map(|i| i.saturating_sub(1));
    let high = std::array::from_fn(|a| (at[a] + 2).min(lattice.extent[a]));
    let way = move |to: [usize; D]| Vector::from_fn(|a, _| to[a] as f64 - at[a] as f64);
    let all = lattice_points([low, high]).map(move |to| (lattice.index(to), way(to)));
    all.filter(|(c, _)| cut.distance_cells(*c) > 0.0)
}

/// Whether φ of a cell near a solid's surface has the opposite sign of all open cells around it.
fn is_isolated<const D: usize>(model: &Model<D>, phi: &[f64], cut: &CutCells<D>, cell: usize) -> bool {
    open_neighbours(model, cut, cell).all(|(c, _)| phi[c] * phi[cell] < 0.0)
}

/// Of the `open` cells finds those without a neighbour that indicates a surface nearer than [`SAMPLE_HEIGHT_CELLS`] above their
/// solid, and raises their |φ| to at least that distance: the sign change within the solid is no surface.
fn raise_clear_cells<const D: usize>(
    model: &Model<D>,
    phi: &mut [f64],
    cut: &CutCells<D>,
    mut open: Vec<u32>,
) -> Vec<u32> {
    open.sort_unstable();
    open.dedup();
    let dx = model.grid.dx;
    let least = |cell: usize| (SAMPLE_HEIGHT_CELLS + cut.distance_cells(cell)) * dx;
    let is_clear = |cell: usize| {
        let tells = |(c, way): (usize, Vector<D>)| {
            phi[c] * phi[cell] < 0.0 || phi[c].abs() + way.norm() * dx < least(cell)
        };
        !open_neighbours(model, cut, cell).filter(|(c, _)| *c != cell).any(tells)
    };
    let clear = par::filter_map(open.len(), 64, |i| is_clear(open[i] as usize).then_some(open[i]));
    for cell in clear.iter().map(|c| *c as usize) {
        phi[cell] = phi[cell].abs().max(least(cell)).copysign(phi[cell]);
    }
    clear
}

/// Whether a solid has moved so far in a step that a cell's φ may belong to another side: that side has become the nearest, or
/// the cell's centre lies much less deep.
fn has_moved_away<const D: usize>([before, now]: [Solids<'_, D>; 2], cell: usize) -> bool {
    let grid = now.model.grid;
    let x = grid.center(grid.lattice().coordinates(cell));
    let Some(number) = now.nearest(&x) else { return false };
    let [before, now] = [before, now].map(|solids| solids.get(number));
    let [normal_before, normal] = [before, now].map(|solid| solid.normal(&x, 0.01 * grid.dx));
    normal_before.dot(&normal) < 0.0
        || now.distance(&x) - before.distance(&x) > MIN_COVERED_DEPTH_CELLS * grid.dx
}

/// Gives cells within solids beyond the band the sign of φ outside, next to them: when a moving solid uncovers them, their old
/// values would be a surface there. Returns the old φ.
fn extend_signs_beyond_band<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    band: &Band<D>,
    cut: &CutCells<D>,
) -> Vec<(u32, f64)> {
    let (lattice, limit) = (model.grid.lattice(), BAND_WIDTH_CELLS * model.grid.dx);
    let phi = &state.phi.data;
    let side = |cell: usize| {
        let depth = -cut.distance_cells(cell);
        if depth <= 0.0 || depth > MAX_EXPOSED_DEPTH_CELLS || band.slot(cell).is_some() {
            return None;
        }
        let mut at = cell;
        for _ in 0..2 * MAX_EXPOSED_DEPTH_CELLS as usize {
            at = lattice
                .neighbours(at)
                .max_by(|i, j| cut.distance_cells(*i).total_cmp(&cut.distance_cells(*j)))?;
            if cut.distance_cells(at) >= 0.0 {
                return Some((cell, limit.copysign(phi[at])));
            }
        }
        None
    };
    let of = |[low, high]: &[[usize; D]; 2]| {
        let (low, extent): (_, [usize; D]) = (*low, std::array::from_fn(|a| high[a] - low[a]));
        let cell = move |mut k: usize| {
            let place = |a: usize| {
                let along = k % extent[a];
                k /= extent[a];
                low[a] + along
            };
            lattice.index(std::array::from_fn(place))
        };
        par::filter_map(extent.iter().product(), 1024, |k| side(cell(k)))
    };
    let sides: Vec<(usize, f64)> = cut.solid_boxes().iter().flat_map(of).collect();
    let put =
        |(cell, value): (usize, f64)| (cell as u32, std::mem::replace(&mut state.phi.data[cell], value));
    sides.into_iter().map(put).collect()
}
