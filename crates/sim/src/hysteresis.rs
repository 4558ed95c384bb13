//! Hysteresis: contact lines that rest.
//!
//! A rough or dirty solid holds a line as long as its angle is between the receding and the advancing one; beyond them the
//! line moves as if the one that it has passed were Young's. So the energy's angle at each place of the line is what the line
//! has, within those bounds, which pushes it nowhere, and while it rests what else pushes the liquid there finds it held
//! (`liquid/friction.rs`; design, numerics §3). On a sharp edge the range is larger by the turn of the solid's normal
//! (`edge.rs`).

use crate::model::Model;
use crate::profile::{Foot, contact_angle};
use crate::state::State;
use crate::workspace::Workspace;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Sampler;

/// How a piece of a contact line is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Cosine of the angle that the energy has there.
    pub cosine: f64,
    /// Whether the line rests.
    pub rests: bool,
    /// By how much that cosine falls over a cell that the line goes on: [`crate::edge`].
    pub stiffness: f64,
}

/// Finds the angle of every line, which of them rest, and which are on edges.
pub fn hold_lines<const D: usize>(model: &Model<D>, state: &State<D>, work: &mut Workspace<D>) {
    if model.solids.is_empty() || !model.numerics.contact_line {
        return;
    }
    let dx = model.grid.dx;
    let phi = Sampler::cells(&model.grid, &state.phi.data, model.scalar_edges());
    work.lattice.hold_lines(&state.phi.data, |place: &Vector<D>, number| {
        let (solid, now) = (&model.solids[number as usize], &state.solids[number as usize]);
        let young = solid.cosine_near(now, place, dx);
        let normal = solid.normal(now, place, 0.01 * dx);
        let slope = phi.distance(place).1;
        let dry = (slope - normal * slope.dot(&normal)).try_normalize(0.0);
        // The sides of the domain have no convex edges.
        let edged = model.wetting_walls() != Some(number as usize);
        let edge = dry.filter(|_| edged).and_then(|dry| solid.edge(now, place, &dry, dx));
        let stiffness = edge.map_or(0.0, |edge| edge.stiffness(young));
        if solid.hysteresis.is_none() {
            let cosine = edge.map_or(young, |edge| edge.cosine(young));
            return Hold { cosine, rests: false, stiffness };
        }
        let height = |x: &Vector<D>| model.height(&state.solids, number as usize, (place, &normal), x);
        let foot = Foot { at: *place, normal, dx, weight: model.weight(), height: &height };
        let angle = contact_angle(&phi, &foot);
        let held = angle.map(|angle| solid.wetting(young, edge.as_ref(), angle.cos()));
        let (cosine, rests) = held.unwrap_or((young, false));
        Hold { cosine, rests, stiffness }
    });
}
