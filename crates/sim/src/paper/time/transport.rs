//! Transport of surface and velocity, and the velocity beyond the liquid (Section 4.1, and steps 4 and 5 of Section 6).
//!
//! Semi-Lagrangian, as in the paper, along the third-order paths and with the interpolation of the rest of Meniscus. What the paper leaves
//! open is as there too: `φ` is made a distance again in the band ([`redistance`]), and the velocity is extrapolated over the band.

use crate::flow::paths::departure_point;
use crate::model::resolution::{BAND_LAYERS, BAND_WIDTH_CELLS};
use crate::model::{Model, Wall};
use crate::paper::fluid::cells::{CellType, CellTypes, Face, FaceType};
use meniscus_numerics::grid::{Band, CellField, FaceField, Runs, Sampler, Tiles, VelocityExtension};
use meniscus_numerics::level_set::redistance;
use meniscus_numerics::{Vector, par};

/// The liquid's cells, and the band around its surface.
fn liquid_and_band<const D: usize>(model: &Model<D>, phi: &CellField<D>) -> (Runs, Band<D>) {
    let liquid = Tiles::all(model.grid).negative_runs(&phi.data);
    let mut band = Band::new(model.grid);
    band.rebuild(&phi.data, &liquid, BAND_LAYERS);
    (liquid, band)
}

/// The level set as a distance, m, in the band, and at its bound elsewhere.
pub fn redistanced<const D: usize>(model: &Model<D>, mut phi: CellField<D>) -> CellField<D> {
    let (_, band) = liquid_and_band(model, &phi);
    let limit = BAND_WIDTH_CELLS * model.grid.dx;
    let sampler = Sampler::cells(&model.grid, &phi.data, model.scalar_boundary());
    let values = redistance(&model.grid, &band, BAND_LAYERS, &phi.data, &sampler, limit);
    phi.data.iter_mut().for_each(|value| *value = limit.copysign(*value));
    band.cells.iter().zip(values).for_each(|(cell, value)| phi.data[*cell as usize] = value);
    phi
}

/// The solid nearest to a point (m): its normal, and its velocity there, m/s.
pub type SolidMotion<'a, const D: usize> = &'a (dyn Fn(&Vector<D>) -> [Vector<D>; 2] + Sync);

/// Extrapolates a velocity from the faces of the liquid's cells over the band; beyond it is zero. With the motion of the solids the liquid
/// slips along them ([`Errata::slip`](crate::paper::Errata::slip)): faces beside solids are extrapolated as well, and of them and of those
/// within solids the normal part is the solid's.
pub fn extend_velocity<const D: usize>(
    model: &Model<D>,
    types: &CellTypes<D>,
    phi: &CellField<D>,
    solids: Option<SolidMotion<'_, D>>,
    velocity: &mut FaceField<D>,
) {
    let (liquid, band) = liquid_and_band(model, phi);
    let faces: [_; D] = std::array::from_fn(|axis| liquid.faces(&model.grid, axis));
    let mut known = FaceField::zeros(model.grid);
    for axis in 0..D {
        let row = model.grid.face_lattice(axis).extent[0];
        for s in &faces[axis] {
            let range = s.row * row + s.start..s.row * row + s.end;
            known.axes[axis][range.clone()].copy_from_slice(&velocity.axes[axis][range]);
        }
    }
    let mut extension = VelocityExtension::new(model.grid);
    extension.set_liquid_faces(faces);
    let beside = types.faces_of(FaceType::LiquidSolid);
    if solids.is_some() {
        let of = |axis: usize| beside.iter().filter(|f| f.axis == axis).map(|f| f.index as u32).collect();
        extension.unmark_closed_faces(&std::array::from_fn(of));
    }
    let distance = Sampler::cells(&model.grid, &phi.data, model.scalar_boundary());
    let closed = |axis: usize, side: usize| model.walls[axis][side] == Wall::Slip;
    extension.extrapolate(&mut known, &band, &phi.data, &distance, closed);
    if let Some(solids) = solids {
        slip_along_solids(model, types, &band, solids, &mut known);
    }
    *velocity = known;
}

/// Sets the normal part of a velocity `u`, m/s, on the faces of a band's solid cells to that of the solids, `u + n n · (v_s − u)` (E28).
fn slip_along_solids<const D: usize>(
    model: &Model<D>,
    types: &CellTypes<D>,
    band: &Band<D>,
    solids: SolidMotion<'_, D>,
    velocity: &mut FaceField<D>,
) {
    let is_solid = |c: usize| types.cell(c) == CellType::Solid;
    let cells: Vec<usize> = band.cells.iter().map(|c| *c as usize).filter(|c| is_solid(*c)).collect();
    let before = velocity.clone();
    let flow = model.velocity_sampler(&before);
    for axis in 0..D {
        let mut faces: Vec<Face> = cells.iter().flat_map(|c| types.faces(*c, axis)).collect();
        faces.sort_unstable();
        faces.dedup();
        faces.retain(|face| types.face(*face) != FaceType::ClosedSide);
        let value = |face: &Face| {
            let x = types.center(*face);
            let (u, [normal, of_solid]) = (flow.linear(&x), solids(&x));
            u[axis] + normal[axis] * normal.dot(&(of_solid - u))
        };
        let values = par::map_slice(&faces, 64, value);
        faces.iter().zip(values).for_each(|(face, value)| velocity.axes[axis][face.index] = value);
    }
}

/// The level set after a step of `dt` (s) with a velocity that is known in the band (Eq. 19), m; not a distance.
pub fn advect_level_set<const D: usize>(
    model: &Model<D>,
    phi: &CellField<D>,
    velocity: &FaceField<D>,
    dt: f64,
) -> CellField<D> {
    let (_, band) = liquid_and_band(model, phi);
    let (grid, flow) = (&model.grid, model.velocity_sampler(velocity));
    let sampler = Sampler::cells(grid, &phi.data, model.scalar_boundary());
    let of = |cell: &u32| {
        let x = grid.center(grid.lattice().coordinates(*cell as usize));
        sampler.distance(&departure_point(x, flow.linear(&x), dt, |x| flow.linear(x)))
    };
    let values = par::map_slice(&band.cells, 64, of);
    let mut after = phi.clone();
    band.cells.iter().zip(values).for_each(|(cell, value)| after.data[*cell as usize] = value);
    after
}

/// A velocity carried for `dt` (s) along another one, where both are known.
pub fn advect_velocity<const D: usize>(
    model: &Model<D>,
    carried: &FaceField<D>,
    along: &FaceField<D>,
    dt: f64,
) -> FaceField<D> {
    let (flow, values) = (model.velocity_sampler(along), model.velocity_sampler(carried));
    let mut after = FaceField::zeros(model.grid);
    for axis in 0..D {
        let lattice = model.grid.face_lattice(axis);
        par::for_each_mut(&mut after.axes[axis], 64, |index, value| {
            let at = lattice.coordinates(index);
            if model.on_closed_side(axis, at[axis]) {
                return;
            }
            let x: Vector<D> = model.grid.face_center(axis, at);
            let departure = departure_point(x, flow.linear(&x), dt, |x| flow.linear(x));
            *value = values.component(axis).cubic(&departure);
        });
    }
    after
}

/// Adds `dt (ν ∇²u + g)` to a velocity, m/s: explicit viscosity, with sides of the domain as mirrors, and gravity (Eq. 16 and 20).
pub fn add_viscosity_and_gravity<const D: usize>(model: &Model<D>, velocity: &mut FaceField<D>, dt: f64) {
    let diffusion = model.kinematic_viscosity * dt / (model.grid.dx * model.grid.dx);
    for axis in 0..D {
        let (lattice, old) = (model.grid.face_lattice(axis), velocity.axes[axis].clone());
        par::for_each_mut(&mut velocity.axes[axis], 256, |index, value| {
            if model.on_closed_side(axis, lattice.coordinates(index)[axis]) {
                return;
            }
            let around: f64 = match diffusion > 0.0 {
                true => lattice.neighbours(index).map(|n| old[n] - old[index]).sum(),
                false => 0.0,
            };
            *value += diffusion * around + model.gravity[axis] * dt;
        });
    }
}
