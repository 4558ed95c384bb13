//! The surface inside solids: it goes on at the contact angle.
//!
//! Stencils at a solid's surface reach into it, and a solid that moves leaves what was in it. There φ tends to the
//! surface's continuation under the contact angle `θ`: from a point at depth `d` the direction `w = n sin θ − t cos θ`, with
//! `n` the solid's normal and `t` that of φ's slope along the solid, leads out to a point above the solid that has the same
//! value (design, experiments part 2). The continuation is an arc: it turns on as the surface does between the solid, where
//! it has the contact angle, and that point. Where it is straight, the kink in φ makes redistancing pull the line back in
//! every step (a base radius 0.6 % short where the surface turns within four cells), which short steps do more often.
//!
//! A plate of a few cells is thinner than two sides' stencils. Where the nearest side is clear of any surface, its closed
//! cells take the continuation from the side across, within bounds that keep what then separates the sides in the plate; and
//! what lies beside them on the nearest side does not see that ([`clear`]).
//!
//! A line with friction `ζ` has the angle `cos θ = cos θ_Y − ζ U/γ` while it moves with the speed `U`: with Young's the
//! continuation would carry the line past the liquid that the friction holds. A line that rests keeps the angle it has.

use crate::flow::advection::VelocitySampler;
use crate::model::Model;
use crate::model::resolution::{BAND_WIDTH_CELLS, GRADIENT_NORM_TOLERANCE};
use crate::model::time_step::MAX_DT_GROWTH;
use crate::solid::{Motion, SolidState};
use crate::state::State;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{Band, CutCells, Sampler, lattice_points};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Part of the way to the continuation that φ goes in a step: at once it lifts drops off, never it keeps what is stale.
const RELAXATION: f64 = 0.1;
/// Depth, in cells, within which a cell in a solid that moves may be left by it in a step or two.
const MAX_EXPOSED_DEPTH_CELLS: f64 = 3.0;
/// Height above a solid, in cells, at which the surface is looked for. If that is farther away than this no surface meets the
/// solid below: liquid within is stale and goes at once. Else a dry side that moves away from what lies behind it would look
/// wetted: it goes faster than what is left behind fades.
const SAMPLE_HEIGHT_CELLS: f64 = 1.0;
/// Depth, in cells, under a side up to which its continuation counts: farther no stencil reaches.
const MAX_OPPOSITE_DEPTH_CELLS: f64 = 2.5;
/// Most that φ may be in cells that take that, over their depth: between there and a clear cell on the nearest side, where φ is
/// at least [`SAMPLE_HEIGHT_CELLS`] and its height, the sign changes within the solid up to twice that.
const MAX_PHI_DEPTH_RATIO: f64 = 1.5;
/// The same beside cells that are not clear: the sign changes half-way between two distances.
const UNCLEAR_PHI_DEPTH_RATIO: f64 = 0.5;
/// Depth, in cells, up to which a surface steeper than 45 degrees that reaches a cell passes between its open neighbours.
const SHALLOW_DEPTH_CELLS: f64 = 0.6;
/// Depth, in cells, below what a solid uncovers in a step from which on one side may yield to the other. What comes nearer to a
/// side by more than that in a step has that side's sign at once.
const MIN_COVERED_DEPTH_CELLS: f64 = 0.25;
/// Least sine of the angle at which it is continued.
const MIN_CONTINUATION_SINE: f64 = 0.25;
/// Most that it turns in a cell of depth, rad: a surface with a radius of two cells.
const MAX_TURN_PER_CELL: f64 = 0.5;

/// A cell with its centre in a solid, and where the surface's continuation through it comes out.
#[derive(Clone, Copy, Debug)]
pub struct GhostCell<const D: usize> {
    /// Its place in the band.
    pub slot: u32,
    /// A point of the continuation outside the solid, m.
    pub exit_point: Vector<D>,
    /// φ here over φ there: as many times as dense as there lie its values along the solid if it is to be a distance.
    phi_scale: f64,
    /// Whether none of its faces is open.
    is_closed: bool,
    /// Whether its solid leaves it before what is stale has faded.
    is_exposed: bool,
    /// Whether it then may hold what is on the side across: it is shallow, and its solid is thin.
    thin: bool,
    /// Where the surface goes on from the farther side of a thin solid: the normal of the nearest.
    nearest_normal: Option<Vector<D>>,
}

/// The cells of the band within solids.
pub fn ghost_cells<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    band: &Band<D>,
    cut: &CutCells<D>,
) -> Vec<GhostCell<D>> {
    let surface = InterfaceSampler {
        model,
        solids: &state.solids,
        phi: Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary()),
        velocity: VelocitySampler::new(model, &state.velocity),
        max_next_dt: state.last_dt * MAX_DT_GROWTH,
    };
    let within = |c: &u32| cut.distance_cells(*c as usize) < 0.0;
    let slots: Vec<u32> = (0..band.cells.len() as u32).filter(|s| within(&band.cells[*s as usize])).collect();
    let ghost = |&slot: &u32| {
        let cell = band.cells[slot as usize] as usize;
        let at = model.grid.lattice().coordinates(cell);
        surface.ghost_cell(
            slot,
            &model.grid.center(at),
            -cut.distance_cells(cell) * model.grid.dx,
            cut.is_closed(at),
        )
    };
    slots.par_iter().with_min_len(64).filter_map(ghost).collect()
}

/// The surface and how it moves.
struct InterfaceSampler<'a, const D: usize> {
    model: &'a Model<D>,
    solids: &'a [SolidState<D>],
    phi: Sampler<'a, D>,
    velocity: VelocitySampler<'a, D>,
    /// Longest that the coming step may be, s.
    max_next_dt: f64,
}

/// A side of a solid that a point lies under.
struct SolidSide<const D: usize> {
    /// Number of the solid.
    solid: usize,
    /// Its normal.
    normal: Vector<D>,
    /// Depth of the point, m.
    depth: f64,
}

impl<const D: usize> InterfaceSampler<'_, D> {
    /// The continuation through a point at a depth (m): that from the nearest side or, in closed cells of thin solids, from
    /// the one across.
    fn ghost_cell(&self, slot: u32, x: &Vector<D>, depth: f64, is_closed: bool) -> Option<GhostCell<D>> {
        let dx = self.model.grid.dx;
        let solid = self.model.nearest_solid(self.solids, x)?;
        let now = &self.solids[solid];
        let [normal, velocity] = self.model.solids[solid].normal_and_velocity(now, x, 0.01 * dx);
        // Half-way between two sides of a solid there is none.
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
        // What separates the sides within the solid is farther away from there than this.
        let takes_opposite = there.abs() < SAMPLE_HEIGHT_CELLS || (here > 0.0 && there < 0.0);
        Some(if takes_opposite {
            GhostCell { exit_point, phi_scale, nearest_normal: Some(normal), ..own }
        } else {
            own
        })
    }

    /// The side across of a thin solid.
    fn opposite_side(&self, x: &Vector<D>, near: &SolidSide<D>) -> Option<SolidSide<D>> {
        let dx = self.model.grid.dx;
        let (solid, now) = (&self.model.solids[near.solid], &self.solids[near.solid]);
        let beyond = x - near.normal * (MAX_OPPOSITE_DEPTH_CELLS * dx);
        let height = solid.liquid_distance(now, &beyond);
        let normal =
            if height > 0.0 { solid.normal(now, &beyond, 0.01 * dx).try_normalize(0.5) } else { None }?;
        (normal.dot(&near.normal) < 0.0).then_some(SolidSide {
            depth: MAX_OPPOSITE_DEPTH_CELLS * dx - height,
            normal,
            ..*near
        })
    }

    /// Direction along a solid in which φ rises. It has unit length; less where φ rises by less than its slope's error
    /// ([`GRADIENT_NORM_TOLERANCE`]), as beside a film, which has no line. The slope is a difference over two cells: that at a point of a film
    /// changes its sign with ripples of a hundredth of a cell.
    fn tangential_gradient(&self, x: &Vector<D>, normal: &Vector<D>) -> Vector<D> {
        let dx = self.model.grid.dx;
        let slope: Vector<D> = Vector::from_fn(|a, _| {
            let step: Vector<D> = Vector::from_fn(|b, _| if a == b { dx } else { 0.0 });
            (self.phi.linear(&(x + step)) - self.phi.linear(&(x - step))) / (2.0 * dx)
        });
        let along = slope - normal * slope.dot(normal);
        along / along.norm().max(GRADIENT_NORM_TOLERANCE)
    }

    /// Where the continuation through a point under a side comes out of the solid, and how dense it is within.
    fn exit_point(&self, x: &Vector<D>, side: &SolidSide<D>) -> (Vector<D>, f64) {
        let (dx, normal, depth) = (self.model.grid.dx, side.normal, side.depth);
        let (solid, now) = (&self.model.solids[side.solid], &self.solids[side.solid]);
        let way = depth + SAMPLE_HEIGHT_CELLS * dx;
        let slope = self.phi.distance_with_gradient(&(x + normal * way)).1;
        let along = self.tangential_gradient(&(x + normal * way), &normal);
        let outside = |angle: f64| x + (normal - along * (angle.cos() / angle.sin())) * way;
        let angle = |slope: &Vector<D>| (slope.dot(&normal) / slope.norm().max(0.5)).clamp(-1.0, 1.0).acos();
        let steepest = MIN_CONTINUATION_SINE.asin();
        let bound = |angle: f64| angle.clamp(steepest, PI - steepest);
        let (mut cosine, rests) =
            solid.hysteretic_cosine(solid.young_cosine_near(now, x, dx), angle(&slope).cos());
        if solid.line_friction > 0.0 && !rests {
            let at = outside(bound(cosine.clamp(-1.0, 1.0).acos()));
            let speed = (self.velocity.linear(&at) - now.velocity_at(&at)).dot(&along);
            cosine -= solid.line_friction * speed / self.model.surface_tension;
        }
        let foot = bound(cosine.clamp(-1.0, 1.0).acos());
        let above = bound(angle(&self.phi.distance_with_gradient(&outside(foot)).1));
        // The chord of an arc that turns evenly with the height.
        let turn = ((above - foot) / SAMPLE_HEIGHT_CELLS).clamp(-MAX_TURN_PER_CELL, MAX_TURN_PER_CELL);
        let chord = bound(foot + 0.5 * turn * (SAMPLE_HEIGHT_CELLS - depth / dx));
        (outside(chord), foot.sin() / above.sin())
    }
}

/// What [`extend_into_solids`] changed, beside φ in the band.
pub struct ExtensionResult {
    /// The cells whose φ is no distance, in order: those that thin solids keep their sides apart with.
    pub non_distance_cells: Vec<u32>,
    /// Cells outside the band with the φ that they had before.
    pub overwritten_phi: Vec<(u32, f64)>,
}

/// Brings φ in the band's cells within solids nearer to the surface's continuation; `before` is where the solids were.
pub fn extend_into_solids<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    band: &Band<D>,
    cut: &CutCells<D>,
    before: &[SolidState<D>],
) -> ExtensionResult {
    let ghosts = ghost_cells(model, state, band, cut);
    let sampler = Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary());
    let seen = |g: &GhostCell<D>| sampler.distance_with_gradient(&g.exit_point).0;
    let all: Vec<f64> = ghosts.par_iter().with_min_len(64).map(seen).collect();
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
                || has_moved_away(model, [before, &state.solids], cell));
        let value = value + if stale { seen - value } else { RELAXATION * (ghost.phi_scale * seen - value) };
        state.phi.data[cell] = value;
        if let Some(normal) = ghost.nearest_normal {
            let beside = open_neighbours(model, cut, cell).filter(|(_, way)| way.dot(&normal) > 0.0);
            across.push((cell as u32, beside.map(|(c, _)| c as u32).collect::<Vec<_>>()));
        }
    }
    let non_distance_cells = separate_sides(model, &mut state.phi.data, cut, across);
    let moving = model.solids.iter().any(|s| s.motion != Motion::Fixed);
    ExtensionResult {
        non_distance_cells,
        overwritten_phi: if moving { extend_signs_beyond_band(model, state, band, cut) } else { Vec::new() },
    }
}

/// Bounds φ in cells that go on from the side across, given with the open cells beside them, and clears those. Gives back all
/// whose φ is then no distance, in order.
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

/// The cells around a cell that no solid covers, and the ways there.
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

/// Whether a cell in a solid, near its surface, has another sign than all that is open around it.
fn is_isolated<const D: usize>(model: &Model<D>, phi: &[f64], cut: &CutCells<D>, cell: usize) -> bool {
    open_neighbours(model, cut, cell).all(|(c, _)| phi[c] * phi[cell] < 0.0)
}

/// Of open cells beside those in a thin solid that go on from the side across: those that no neighbour tells of a surface
/// nearer than [`SAMPLE_HEIGHT_CELLS`] over their solid's. What separates the sides within the solid is none: their φ is at least that.
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
    let is_clear = |cell: &u32| {
        let cell = *cell as usize;
        let tells = |(c, way): (usize, Vector<D>)| {
            phi[c] * phi[cell] < 0.0 || phi[c].abs() + way.norm() * dx < least(cell)
        };
        !open_neighbours(model, cut, cell).filter(|(c, _)| *c != cell).any(tells)
    };
    let clear: Vec<u32> = open.into_par_iter().with_min_len(64).filter(is_clear).collect();
    for cell in clear.iter().map(|c| *c as usize) {
        phi[cell] = phi[cell].abs().max(least(cell)).copysign(phi[cell]);
    }
    clear
}

/// Whether a solid has moved so far in a step that what a cell holds may be another side's: that has become the nearest, or
/// the cell's centre lies much less deep.
fn has_moved_away<const D: usize>(model: &Model<D>, solids: [&[SolidState<D>]; 2], cell: usize) -> bool {
    let x = model.grid.center(model.grid.lattice().coordinates(cell));
    let Some(number) = model.nearest_solid(solids[1], &x) else { return false };
    let (solid, [before, now]) = (&model.solids[number], solids.map(|solids| &solids[number]));
    let normal = |at| solid.normal(at, &x, 0.01 * model.grid.dx);
    normal(before).dot(&normal(now)) < 0.0
        || solid.distance(now, &x) - solid.distance(before, &x) > MIN_COVERED_DEPTH_CELLS * model.grid.dx
}

/// Gives cells within solids that the band does not reach the sign that φ has outside, next to them: a solid that moves leaves
/// them to the air or to the liquid, and what they were at the start would be a surface there. Gives back what φ was before.
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
        let all = (0..extent.iter().product()).into_par_iter().with_min_len(1024);
        all.filter_map(|k| side(cell(k))).collect::<Vec<_>>()
    };
    let sides: Vec<(usize, f64)> = cut.solid_boxes().iter().flat_map(of).collect();
    let put =
        |(cell, value): (usize, f64)| (cell as u32, std::mem::replace(&mut state.phi.data[cell], value));
    sides.into_iter().map(put).collect()
}
