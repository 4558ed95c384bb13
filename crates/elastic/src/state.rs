//! State of a deformable solid.

use meniscus_numerics::Vector;
use serde::{Deserialize, Serialize};

/// Positions and velocities of the vertices of a solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ElasticState<const D: usize> {
    /// Positions, m.
    pub positions: Vec<Vector<D>>,
    /// Velocities, m/s, with which positions advance in the next step.
    pub velocities: Vec<Vector<D>>,
    /// Time of the positions, s.
    pub time: f64,
}
