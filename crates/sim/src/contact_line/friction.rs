//! Friction of contact lines.
//!
//! A contact line that moves along a solid at the speed `U` is resisted by the force `ζ U` per length, so that its angle
//! differs from Young's: `γ (cos θ_Y − cos θ) = ζ U` (linear molecular-kinetic theory: T. D. Blake, J. M. Haynes, "Kinetics
//! of liquid/liquid displacement", 1969). The force is a drag on the liquid faces around the line, towards the solid's
//! velocity; a moving line exerts none along itself. It depends on the velocity at the end of the step, so it does not
//! limit the time step, however light the liquid at the line. In the pressure solve it reduces the mobility of these faces,
//! as a larger mass would.
//!
//! The grid does not resolve the speed of the line, since the surface rolls over the liquid around it. The mean of the
//! liquid's mean speed and the surface's speed is used: a thin drop (ν = 0.02 √(γR/ρ), 16 cells a radius) then spreads
//! within 0.6 degrees of the law. The former alone is 2 degrees ahead, the latter 3 to 11 degrees behind. This is a
//! compromise, not a derivation: sliding drops roll more, and are too fast by a factor of 1.3 (ν = 1) to 1.7 (ν = 0.03, 12
//! cells a radius) in 2D and up to 2.6 in 3D.

use crate::coupling::impulses::{ComponentSolid, CouplingImpulses};
use crate::free_surface::dual_cell::DualCell;
use crate::free_surface::interface_faces::InterfaceFace;
use crate::model::Model;
use crate::solid::Solids;
use crate::state::State;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{CutCells, FaceField, lattice_points};
use std::collections::BTreeMap;

/// Layers of dual cells around that of the line whose faces are dragged; the line's capillary force acts on the liquid over
/// as many. With 0 the liquid rolls over the few dragged faces, and a drop spreads in half the time.
const DRAG_REACH_CELLS: usize = 1;

/// `ζ h / (ρ Δ²)`, with the impulse time `h`, of a pinned line: a force moves it by a thousandth of the undragged motion.
const PINNED_DRAG: f64 = 1e3;

/// Drag of the contact line on one solid at a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineDrag {
    /// Index of the solid.
    pub solid: u32,
    /// Drag coefficient times the impulse time, over the mass of the face.
    pub drag: f64,
    /// Lagged part of the drag, m/s: `drag` times the velocity relative to the solid towards which it drags.
    pub lagged_impulse: f64,
    /// Velocity of the solid along the face's axis, m/s.
    pub solid_velocity: f64,
}

impl LineDrag {
    /// Impulse of the face on the solid at the face's velocity `u`, over the mass of the face, m/s.
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
    /// A liquid cell beside it.
    cell: usize,
    /// Volume of liquid that moves with it, in cells.
    pub volume_cells: f64,
    /// Whether the free surface crosses it.
    is_interface: bool,
    /// Drag of the lines on each solid; lines on several solids may drag the same face.
    pub drags: Vec<LineDrag>,
}

impl DraggedFace {
    /// Fraction of an impulse that remains after the drag, 0 to 1.
    pub fn mobility(&self) -> f64 {
        1.0 / (1.0 + self.drags.iter().map(|h| h.drag).sum::<f64>())
    }

    /// Velocity after the drag alone, from the velocity `u` before it.
    pub fn dragged_velocity(&self, u: f64) -> f64 {
        (u + self.drags.iter().map(|h| h.lagged_impulse + h.drag * h.solid_velocity).sum::<f64>())
            * self.mobility()
    }

    /// The drag of a solid's lines; added if there is none yet.
    fn drag_on(&mut self, solid: u32) -> &mut LineDrag {
        let place = self.drags.iter().position(|h| h.solid == solid).unwrap_or_else(|| {
            self.drags.push(LineDrag { solid, drag: 0.0, lagged_impulse: 0.0, solid_velocity: 0.0 });
            self.drags.len() - 1
        });
        &mut self.drags[place]
    }
}

/// Contact lines that drag the liquid towards the solids.
///
/// The lines drag towards the velocities that the solids had in the last step, or towards the prescribed ones. The velocities in `state`
/// are provisional and contain only some of the forces; with them drops on soft plates were stirred, and had angles too small by up to 6
/// degrees (`verify soft-sag`). On a solid that accelerates by `a` the velocities in `solids_before` lag by `a h` behind the step's end.
pub struct LineFriction<'a, const D: usize> {
    /// The state, with a provisional velocity.
    pub state: &'a State<D>,
    /// The solids before the forces of this step.
    pub solids_before: Solids<'a, D>,
    /// The dual cells with interface or wetted solid.
    pub dual_cells: &'a [DualCell],
    /// Cells and faces that the solids cut.
    pub cut_cells: &'a CutCells<D>,
    /// Impulse time, s.
    pub impulse_time: f64,
}

/// Dragged faces by axis and position in the face lattice.
type FacesByPosition = BTreeMap<(usize, usize), DraggedFace>;

impl<const D: usize> LineFriction<'_, D> {
    /// Computes the faces that the lines drag, and sets the mobility of the interface faces.
    pub fn dragged_faces(&self, interface_faces: &mut [InterfaceFace]) -> Vec<DraggedFace> {
        let model = self.solids_before.model;
        let unit = self.impulse_time / (model.density * model.grid.dx * model.grid.dx);
        let strength = |cube: &DualCell| {
            let friction = model.solids.get(cube.solid as usize).map_or(0.0, |s| s.line_friction);
            if cube.pinned { PINNED_DRAG } else { unit * friction }
        };
        let line_cells: Vec<&DualCell> =
            self.dual_cells.iter().filter(|c| c.line_length() > 0.0 && strength(c) > 0.0).collect();
        let mut faces: FacesByPosition = BTreeMap::new();
        for cube in &line_cells {
            for (axis, face, sides) in faces_around(model, cube) {
                let Some(cell) = sides.into_iter().find(|c| self.state.phi.data[*c] < 0.0) else { continue };
                let inner = sides.iter().all(|c| self.state.phi.data[*c] < 0.0);
                let volume_cells = if inner { self.cut_cells.open_fraction.axes[axis][face] } else { 0.0 };
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
            self.add_drag(cube, strength(cube), &mut faces);
        }
        for f in interface_faces {
            f.mobility = faces.get(&(f.axis, f.face)).map_or(1.0, DraggedFace::mobility);
        }
        faces.into_values().filter(|f| !f.drags.is_empty()).collect()
    }

    /// Adds the drag of the line in a dual cell to the faces around it; `strength` is `ζ h / (ρ Δ²)`.
    fn add_drag(&self, cube: &DualCell, strength: f64, faces: &mut FacesByPosition) {
        let model = self.solids_before.model;
        let (mut mass, mut crossed) = ([0.0; D], [0.0; D]);
        let (mut velocity, mut surface) = (Vector::<D>::zeros(), Vector::<D>::zeros());
        for (a, face, _) in faces_around(model, cube) {
            let Some(f) = faces.get(&(a, face)) else { continue };
            let u = self.state.velocity.axes[a][face];
            mass[a] += f.volume_cells;
            velocity[a] += f.volume_cells * u;
            crossed[a] += f64::from(f.is_interface);
            surface[a] += if f.is_interface { u } else { 0.0 };
        }
        (0..D).for_each(|a| velocity[a] /= mass[a].max(1e-300));
        let over = |a: usize| if crossed[a] > 0.0 { surface[a] / crossed[a] - velocity[a] } else { 0.0 };
        let outward = -Vector::<D>::from_fn(|a, _| cube.wetting_direction[a]) / cube.line_length();
        let rolling = if cube.pinned { 0.0 } else { 0.5 * (0..D).map(|a| outward[a] * over(a)).sum::<f64>() };
        let before = self.solids_before.get(cube.solid as usize);
        let along = cube.line_direction();
        for (a, face, _) in faces_around(model, cube) {
            let Some(f) = faces.get_mut(&(a, face)).filter(|f| f.volume_cells > 0.0) else { continue };
            let x = model.grid.face_center(a, model.grid.face_lattice(a).coordinates(face));
            let solid = before.velocity_at(&x);
            // A pinned line also drags along itself: where it bends, liquid that slides along one part would cross the next.
            let slides = if cube.pinned { 0.0 } else { 1.0 };
            let along: [f64; D] = std::array::from_fn(|b| slides * along[b]);
            // No drag along the line: the tensor is `1 − t tᵀ`, whose diagonal is implicit.
            let others = (0..D).filter(|b| *b != a);
            let sliding: f64 = others.map(|b| along[b] * (velocity[b] - solid[b])).sum();
            let whole = strength * cube.line_length() / mass[a];
            let hold = f.drag_on(cube.solid);
            hold.drag += whole * (1.0 - along[a] * along[a]);
            hold.lagged_impulse += whole * (along[a] * sliding - outward[a] * rolling);
            hold.solid_velocity = solid[a];
        }
    }
}

/// Inner faces of a dual cell and its neighbours, with their axes and the cells beside them.
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

/// Impulses of the drag on the solids, at the velocity after the step.
pub fn line_friction_impulses<const D: usize>(
    solids: Solids<'_, D>,
    velocity: &FaceField<D>,
    faces: &[DraggedFace],
    label: impl Fn(usize) -> Option<u32>,
) -> CouplingImpulses<D> {
    let model = solids.model;
    let mut exchange = CouplingImpulses::new();
    for f in faces {
        let Some(component) = label(f.cell) else { continue };
        let x = model.grid.face_center(f.axis, model.grid.face_lattice(f.axis).coordinates(f.face));
        let u = velocity.axes[f.axis][f.face];
        for hold in &f.drags {
            let mut impulse = Vector::<D>::zeros();
            impulse[f.axis] =
                model.density * model.grid.cell_volume() * f.volume_cells * hold.impulse_on_solid(u);
            let pair = ComponentSolid { component, solid: hold.solid };
            exchange.add_at(pair, &solids.get(hold.solid as usize), &x, impulse);
        }
    }
    exchange
}
