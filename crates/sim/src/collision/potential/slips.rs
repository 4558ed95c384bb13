//! Elastic slips of friction, which are carried from step to step, and the friction contacts of a step.

use crate::collision::points::{BARRIER_REACH_CELLS, PointOwner};
use crate::model::Model;
use meniscus_contact::{Friction, FrictionPair};
use meniscus_numerics::Vector;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Elastic slip at which sliding starts, in activation distances of the barrier. It is a few times `CONVERGENCE_TOLERANCE` of
/// [`crate::collision::newton`], because Newton's method oscillates across a kink that it does not resolve. Bouncing solids slip by this
/// amount in each contact; at 1e-2 a soft block that bounced down a slope slid 2 % too far.
const MAX_ELASTIC_SLIP_REACHES: f64 = 3e-3;

/// Identifies the contact of a slip. A point or an edge has one contact with all facets and edges of another solid, so its slip persists
/// when it slides from one to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ContactKey {
    /// Points of the first edge; twice the same for a point.
    pub points: [u32; 2],
    /// Number of the other solid; for a side of the domain the number of solids plus the side's.
    pub other: u32,
}

/// Elastic slip of a contact. Limit: it does not rotate with a common rotation of both solids about the normal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slip<const D: usize> {
    /// Current slip of the first feature along the other, m.
    pub displacement: Vector<D>,
    /// Rate of the slip in the coming step, m/s.
    pub rate: Vector<D>,
    /// Friction coefficient times normal force, N (2D: N/m).
    pub friction_limit: f64,
}

/// Slips of all contacts.
pub type Slips<const D: usize> = BTreeMap<ContactKey, Slip<D>>;

/// Friction law of a model.
pub fn friction_law<const D: usize>(model: &Model<D>) -> Friction {
    Friction { max_elastic_slip: MAX_ELASTIC_SLIP_REACHES * BARRIER_REACH_CELLS * model.grid.dx }
}

/// Advances all slips by the time `dt` (s), limited by the elastic slip at which sliding starts.
pub fn advance_slips<const D: usize>(model: &Model<D>, slips: &mut Slips<D>, dt: f64) {
    let friction = friction_law(model);
    slips
        .values_mut()
        .for_each(|slip| slip.displacement = friction.return_mapped(slip.displacement + slip.rate * dt));
}

/// Friction between two features, with the owners of their points.
pub struct FrictionContact<const D: usize> {
    pub(super) key: ContactKey,
    /// Owners of the points.
    pub owners: [PointOwner<D>; 4],
    /// Positions of the points at the start of the coming step.
    pub start_positions: [Vector<D>; 4],
    /// Weights, normal, friction limit and slip.
    pub rubbing: FrictionPair<D>,
}
