//! Friction of contact lines.
//!
//! A line that moves along a solid with the speed `U` is held back with the force `ζ U` on its length, so that the angle it
//! moves with differs from Young's: `γ (mode_cosine θ_Y − mode_cosine θ) = ζ U` (molecular-kinetic theory, linear: T. D. Blake, J. M. Haynes,
//! "Kinetics of liquid/liquid displacement", 1969; design, numerics §3). The liquid's faces around the line feel it as a drag
//! towards the solid's velocity, but not along a line that moves, with the velocity of the step's end: no step is too long
//! for it, however light the liquid at the line. In the pressure solve such faces give way less, as if they were heavier.
//!
//! What the line's speed is, the grid does not tell: around it the surface rolls over the liquid. With the liquid's mean speed
//! a thin drop (ν = 0.02 √(γR/ρ), 16 cells a radius) spreads too fast, 2 degrees ahead of the law; with that of the surface
//! too slowly, 3 to 11 degrees behind. Half-way between the two it is within 0.6 degrees. That is a compromise, not a
//! derivation: drops that slide roll more, and are still 1.3 (ν = 1) to 1.7 times (ν = 0.03, 12 cells a radius, 2D), in space
//! up to 2.6 times as fast as they should be.

use crate::coupling::impulses::CouplingImpulses;
use crate::free_surface::dual_cell::DualCell;
use crate::free_surface::interface_faces::InterfaceFace;
use crate::model::Model;
use crate::solid::SolidState;
use crate::state::State;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{CutCells, lattice_points};
use std::collections::BTreeMap;

/// Cubes around the line's own whose faces it drags: the surface pulls at the liquid over as many. Without them the liquid
/// rolls over the few faces that are held (a drop then spreads in half the time).
const DRAG_REACH_CELLS: usize = 1;

/// `ζ h / (ρ Δ²)` of a line that rests: what pushes it moves it by a thousandth of what it would.
const PINNED_DRAG: f64 = 1e3;

/// Drag of the contact line on one solid at a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineDrag {
    /// Number of the solid.
    pub solid: u32,
    /// Drag in the step, over the face's mass.
    pub drag: f64,
    /// Drag times the velocity relative to the solid's that it drags towards, m/s: the part that lags.
    pub lagged_impulse: f64,
    /// Velocity of the solid along the face's axis, m/s.
    pub solid_velocity: f64,
}

impl LineDrag {
    /// The impulse of the face on the solid at the face's velocity `u`, over the face's mass, m/s.
    pub fn impulse_on_solid(&self, u: f64) -> f64 {
        self.drag * (u - self.solid_velocity) - self.lagged_impulse
    }
}

/// A face near a contact line.
#[derive(Clone, Debug, PartialEq)]
pub struct DraggedFace {
    /// Normal axis.
    pub axis: usize,
    /// Position in the face lattice.
    pub face: usize,
    /// A liquid cell at it.
    cell: usize,
    /// Liquid that moves with it, in cells.
    pub volume_cells: f64,
    /// Whether the surface crosses it.
    is_interface: bool,
    /// What the lines on each solid do; several solids' lines may drag the same face.
    pub drags: Vec<LineDrag>,
}

impl DraggedFace {
    /// What the drag leaves of a push, 0 to 1.
    pub fn mobility(&self) -> f64 {
        1.0 / (1.0 + self.drags.iter().map(|h| h.drag).sum::<f64>())
    }

    /// The velocity `u` after the drag, when nothing else pushes.
    pub fn dragged_velocity(&self, u: f64) -> f64 {
        (u + self.drags.iter().map(|h| h.lagged_impulse + h.drag * h.solid_velocity).sum::<f64>())
            * self.mobility()
    }

    /// The hold of a solid.
    fn drag_on(&mut self, solid: u32) -> &mut LineDrag {
        let place = self.drags.iter().position(|h| h.solid == solid).unwrap_or_else(|| {
            self.drags.push(LineDrag { solid, drag: 0.0, lagged_impulse: 0.0, solid_velocity: 0.0 });
            self.drags.len() - 1
        });
        &mut self.drags[place]
    }
}

/// The faces that the lines drag in the time `impulse_time` (s). Those at the surface are told what that leaves of a push.
///
/// `bodies` are the solids with the velocities that the step before left, or that they are told: towards those the lines drag.
/// What `state` has is on its way, with what some of the forces give to a solid at rest, before the others take it away: drops
/// on soft plates stirred with it, and had angles too small by up to 6 degrees (`verify clamped_radiance-sag`). Where a solid
/// accelerates by `a` they lag by `a h`, of what the step's end will have.
pub fn dragged_faces<const D: usize>(
    model: &Model<D>,
    (state, bodies): (&State<D>, &[SolidState<D>]),
    dual_cells: &[DualCell],
    (interface_faces, solids): (&mut [InterfaceFace], &CutCells<D>),
    impulse_time: f64,
) -> Vec<DraggedFace> {
    let unit = impulse_time / (model.density * model.grid.dx * model.grid.dx);
    let strength = |cube: &DualCell| {
        let friction = model.solids.get(cube.solid as usize).map_or(0.0, |s| s.line_friction);
        if cube.pinned { PINNED_DRAG } else { unit * friction }
    };
    let line_cells: Vec<&DualCell> =
        dual_cells.iter().filter(|c| c.line_length() > 0.0 && strength(c) > 0.0).collect();
    let mut faces: BTreeMap<(usize, usize), DraggedFace> = BTreeMap::new();
    for cube in &line_cells {
        for (axis, face, sides) in faces_around(model, cube) {
            let Some(cell) = sides.into_iter().find(|c| state.phi.data[*c] < 0.0) else { continue };
            let inner = sides.iter().all(|c| state.phi.data[*c] < 0.0);
            let volume_cells = if inner { solids.open_fraction.axes[axis][face] } else { 0.0 };
            faces.entry((axis, face)).or_insert(DraggedFace {
                axis,
                face,
                cell,
                volume_cells,
                is_interface: false,
                drags: Vec::new(),
            });
        }
    }
    if faces.is_empty() {
        return Vec::new();
    }
    for f in interface_faces.iter() {
        if let Some(dragged) = faces.get_mut(&(f.axis, f.face)) {
            dragged.volume_cells = f.theta * f.open_fraction;
            dragged.is_interface = f.open_fraction > 0.0;
        }
    }
    for cube in line_cells {
        add_drag(model, (state, bodies), cube, strength(cube), &mut faces);
    }
    for f in interface_faces {
        f.mobility = faces.get(&(f.axis, f.face)).map_or(1.0, DraggedFace::mobility);
    }
    faces.into_values().filter(|f| !f.drags.is_empty()).collect()
}

/// Adds the drag of the line in a cube to its faces; `strength` is `ζ h / (ρ Δ²)`.
fn add_drag<const D: usize>(
    model: &Model<D>,
    (state, bodies): (&State<D>, &[SolidState<D>]),
    cube: &DualCell,
    strength: f64,
    faces: &mut BTreeMap<(usize, usize), DraggedFace>,
) {
    let (mut mass, mut crossed) = ([0.0; D], [0.0; D]);
    let (mut velocity, mut surface) = (Vector::<D>::zeros(), Vector::<D>::zeros());
    for (a, face, _) in faces_around(model, cube) {
        let Some(f) = faces.get(&(a, face)) else { continue };
        let u = state.velocity.axes[a][face];
        mass[a] += f.volume_cells;
        velocity[a] += f.volume_cells * u;
        crossed[a] += f64::from(f.is_interface);
        surface[a] += if f.is_interface { u } else { 0.0 };
    }
    (0..D).for_each(|a| velocity[a] /= mass[a].max(1e-300));
    let over = |a: usize| if crossed[a] > 0.0 { surface[a] / crossed[a] - velocity[a] } else { 0.0 };
    let outward = -Vector::<D>::from_fn(|a, _| cube.wetting_direction[a]) / cube.line_length();
    let rolling = if cube.pinned { 0.0 } else { 0.5 * (0..D).map(|a| outward[a] * over(a)).sum::<f64>() };
    let now = &bodies[cube.solid as usize];
    let along = cube.line_direction();
    for (a, face, _) in faces_around(model, cube) {
        let Some(f) = faces.get_mut(&(a, face)).filter(|f| f.volume_cells > 0.0) else { continue };
        let x = model.grid.face_center(a, model.grid.face_lattice(a).coordinates(face));
        let solid = now.velocity_at(&x);
        // A line that rests lets nothing slide by: where it bends, what slides along one part of it would cross the next.
        let slides = if cube.pinned { 0.0 } else { 1.0 };
        let along: [f64; D] = std::array::from_fn(|b| slides * along[b]);
        // Along the line nothing drags: `(1 − t tᵀ)` of the drag, whose diagonal is implicit.
        let others = (0..D).filter(|b| *b != a);
        let sliding: f64 = others.map(|b| along[b] * (velocity[b] - solid[b])).sum();
        let whole = strength * cube.line_length() / mass[a];
        let hold = f.drag_on(cube.solid);
        hold.drag += whole * (1.0 - along[a] * along[a]);
        hold.lagged_impulse += whole * (along[a] * sliding - outward[a] * rolling);
        hold.solid_velocity = solid[a];
    }
}

/// The inner faces of a cube and of the cubes around it, with their axes and the cells beside them.
fn faces_around<const D: usize>(model: &Model<D>, cube: &DualCell) -> Vec<(usize, usize, [usize; 2])> {
    let cells = model.grid.lattice();
    let (first, last) =
        (cells.coordinates(cube.corners[0] as usize), cells.coordinates(cube.corners[(1 << D) - 1] as usize));
    let low: [usize; D] = std::array::from_fn(|a| first[a].saturating_sub(DRAG_REACH_CELLS));
    let high: [usize; D] = std::array::from_fn(|a| (last[a] + DRAG_REACH_CELLS + 1).min(cells.extent[a]));
    let mut faces = Vec::new();
    for a in 0..D {
        let mut from = low;
        from[a] += 1;
        let face = |at: [usize; D]| {
            let upper = cells.index(at);
            (a, model.grid.face_lattice(a).index(at), [upper - cells.stride[a], upper])
        };
        faces.extend(lattice_points([from, high]).map(face));
    }
    faces
}

/// What the drag gave to the solids, with the velocity after the step.
pub fn line_friction_impulses<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    faces: &[DraggedFace],
    label: impl Fn(usize) -> Option<u32>,
) -> CouplingImpulses<D> {
    let mut exchange = CouplingImpulses::new();
    for f in faces {
        let Some(component) = label(f.cell) else { continue };
        let x = model.grid.face_center(f.axis, model.grid.face_lattice(f.axis).coordinates(f.face));
        let u = state.velocity.axes[f.axis][f.face];
        for hold in &f.drags {
            let mut impulse = Vector::<D>::zeros();
            impulse[f.axis] =
                model.density * model.grid.cell_volume() * f.volume_cells * hold.impulse_on_solid(u);
            exchange.add_at((component, hold.solid), &state.solids[hold.solid as usize], &x, impulse);
        }
    }
    exchange
}
