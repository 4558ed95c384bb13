//! Where a deformable solid is and how it moves.

use meniscus_numerics::Vector;

/// Positions and velocities of a solid's vertices. Plain data.
#[derive(Clone, Debug, PartialEq)]
pub struct ElasticState<const D: usize> {
    /// Positions, m.
    pub positions: Vec<Vector<D>>,
    /// Velocities, m/s: those with which the vertices go on in the next step.
    pub velocities: Vec<Vector<D>>,
    /// Time, s, of the positions; what held vertices follow.
    pub time: f64,
}
