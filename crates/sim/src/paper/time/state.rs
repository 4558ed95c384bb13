//! What evolves.

use crate::solid::SolidState;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{CellField, FaceField};

/// The state of the scheme at a time: positions and velocities are of the same time.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperState<const D: usize> {
    /// Time, s.
    pub time: f64,
    /// Level set of the liquid, m, continued into solids or closed along them, a distance in the band.
    pub phi: CellField<D>,
    /// Velocity, m/s, known in the liquid and in the band.
    pub velocity: FaceField<D>,
    /// The solids.
    pub solids: Vec<SolidState<D>>,
    /// Positions, m, and velocities, m/s, of the line's particles.
    pub line: Vec<[Vector<D>; 2]>,
    /// Pressure of the last step times its length, over the density, m²/s; zero outside the liquid.
    pub pressure_impulse: CellField<D>,
    /// The liquid's volume at the start, m³ (2D: m²).
    pub target_volume: f64,
}
