//! Hysteresis: contact lines that rest.
//!
//! A rough or dirty solid holds a line as long as its angle is between the receding and the advancing one; beyond them the
//! line moves as if the one that it has passed were Young's. So the energy's angle at each place of the line is what the line
//! has, within those bounds, which pushes it nowhere, and while it rests what else pushes the liquid there finds it held
//! (`liquid/friction.rs`; design, numerics §3).

use super::angle::{Foot, contact_angle};
use crate::model::Model;
use crate::simulation::workspace::Workspace;
use crate::state::State;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Sampler;

/// Finds the angle of every line, and which of them rest.
pub fn pin_contact_lines<const D: usize>(model: &Model<D>, state: &State<D>, work: &mut Workspace<D>) {
    if model.solids.iter().all(|s| s.hysteresis.is_none()) {
        return;
    }
    let dx = model.grid.dx;
    let phi = Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary());
    work.dual_grid.pin_contact_lines(&state.phi.data, |place: &Vector<D>, number| {
        let (solid, now) = (&model.solids[number as usize], &state.solids[number as usize]);
        let normal = solid.normal(now, place, 0.01 * dx);
        let height =
            |x: &Vector<D>| model.height_above_solid(&state.solids, number as usize, (place, &normal), x);
        let foot = Foot { at: *place, normal, dx, bond_vector: model.cell_bond_vector(), height: &height };
        let angle = contact_angle(&phi, &foot);
        let young = solid.young_cosine_near(now, place, dx);
        angle.map_or((young, false), |angle| solid.hysteretic_cosine(young, angle.cos()))
    });
}
