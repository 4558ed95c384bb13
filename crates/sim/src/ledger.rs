//! The books: volume, momentum and energy of a state.

use meniscus_numerics::Vector;

/// Sums over the whole liquid. In 2D everything is per metre of depth.
#[derive(Clone, Debug, PartialEq)]
pub struct Ledger<const D: usize> {
    /// Volume, m³.
    pub volume: f64,
    /// Volume there should be, m³.
    pub target_volume: f64,
    /// Volume too much or too little, summed over the components (an excess of one does not make up for what another
    /// lacks), over all the volume; its sign is that of the sum.
    pub volume_error: f64,
    /// Centre of mass, m.
    pub centroid: Vector<D>,
    /// Momentum, kg m/s.
    pub momentum: Vector<D>,
    /// Angular momentum about the origin, kg m²/s; in 2D only the last entry.
    pub angular_momentum: [f64; 3],
    /// Kinetic energy, J.
    pub kinetic_energy: f64,
    /// Tension times the area of the surface, J.
    pub surface_energy: f64,
    /// −mass × gravity · centre of mass, J.
    pub potential_energy: f64,
    /// Largest speed, m/s.
    pub max_speed: f64,
    /// Largest divergence in a liquid cell, 1/s.
    pub divergence_max: f64,
}

/// What a step did.
#[derive(Clone, Debug, PartialEq)]
pub struct StepReport<const D: usize> {
    /// Length of the step taken, s.
    pub dt: f64,
    /// Cells that the fastest liquid moved.
    pub cfl: f64,
    /// Pressure solve iterations.
    pub iterations: usize,
    /// Its relative residual.
    pub residual: f64,
    /// Times the step was halved and done again.
    pub redone: u32,
    /// The books after the step.
    pub ledger: Ledger<D>,
}
