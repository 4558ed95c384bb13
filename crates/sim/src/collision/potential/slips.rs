//! Elastic slips of friction, which are carried from step to step, and the places that rub in a step.

use crate::collision::points::{BARRIER_REACH_CELLS, PointOwner};
use crate::model::Model;
use meniscus_contact::{Friction, FrictionPair};
use meniscus_numerics::Vector;
use std::collections::BTreeMap;

/// Elastic slip, in reaches of the barrier, from which on things slide: a few times what Newton's method resolves (`CONVERGENCE_TOLERANCE` in
/// [`crate::collision::newton`]), for
/// it goes to and fro over a kink that it does not resolve (with 1e-3 it takes half as many iterations again as with 1e-2). It is a
/// deflection that a contact has once; what bounces has it in each contact anew, and slides farther by it (with 1e-2 a soft block that
/// bounces down a slope came 2 % too far).
const MAX_ELASTIC_SLIP_REACHES: f64 = 3e-3;

/// Which contact a slip is of. All facets and edges of the other solid that a point or an edge touches are one contact: its slip
/// stays where it slides from one to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ContactKey {
    /// The points of the first edge; of a point both are the same.
    pub points: [u32; 2],
    /// Number of the other solid; of a side of the domain the number of solids and its own.
    pub other: u32,
}

/// Elastic slip of a contact. Limit: it does not turn with what both turn by about the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip<const D: usize> {
    /// The slip of the first along the other where solids are now, m.
    pub displacement: Vector<D>,
    /// How fast it grows in the coming step, m/s.
    pub rate: Vector<D>,
    /// Friction's coefficient times the normal force, N (2D: N/m).
    pub friction_limit: f64,
}

/// The slips of all contacts.
pub type Slips<const D: usize> = BTreeMap<ContactKey, Slip<D>>;

/// Friction of a model.
pub fn friction_law<const D: usize>(model: &Model<D>) -> Friction {
    Friction { max_elastic_slip: MAX_ELASTIC_SLIP_REACHES * BARRIER_REACH_CELLS * model.grid.dx }
}

/// Lets all slips grow as they do in a time `dt` (s), up to where things slide.
pub fn advance_slips<const D: usize>(model: &Model<D>, slips: &mut Slips<D>, dt: f64) {
    let friction = friction_law(model);
    slips
        .values_mut()
        .for_each(|slip| slip.displacement = friction.return_mapped(slip.displacement + slip.rate * dt));
}

/// Two places that rub each other, with the owners of the points.
pub struct FrictionContact<const D: usize> {
    pub(super) key: ContactKey,
    /// The owners.
    pub owners: [PointOwner<D>; 4],
    /// Where they are when the step ends.
    pub start_positions: [Vector<D>; 4],
    /// How they rub.
    pub rubbing: FrictionPair<D>,
}
