//! Contact angle hysteresis: pinned contact lines.
//!
//! A rough or dirty solid pins a contact line while its angle lies between the receding and the advancing angle. Beyond
//! them the line moves as if the exceeded bound were Young's angle. The contact angle of the energy is therefore the
//! present angle clamped to these bounds, so that the energy exerts no force on a pinned line. Other forces on the liquid
//! at a pinned line are resisted by drag ([`super::friction`]).

use super::angle::{Foot, contact_angle};
use crate::model::Model;
use crate::simulation::workspace::Workspace;
use crate::solid::Solids;
use crate::state::State;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Sampler;

/// Sets the contact angle of every contact line, and which lines are pinned.
pub fn pin_contact_lines<const D: usize>(model: &Model<D>, state: &State<D>, work: &mut Workspace<D>) {
    if model.solids.iter().all(|s| s.hysteresis.is_none()) {
        return;
    }
    let dx = model.grid.dx;
    let phi = Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary());
    work.dual_grid.pin_contact_lines(&state.phi.data, |place: &Vector<D>, number| {
        let (solids, number) =
            (Solids { model, states: &state.solids, surfaces: &work.surfaces }, number as usize);
        let solid = solids.get(number);
        let normal = solid.normal(place, 0.01 * dx);
        let height = |x: &Vector<D>| solids.height_above(number, place, &normal, x);
        let foot = Foot { at: *place, normal, dx, bond_vector: model.cell_bond_vector(), height: &height };
        let angle = contact_angle(&phi, &foot);
        let young = solid.young_cosine_near(place, dx);
        angle.map_or((young, false), |angle| solid.hysteretic_cosine(young, angle.cos()))
    });
}
