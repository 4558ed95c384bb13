//! Initial condition of a simulation.

use meniscus_numerics::Vector;
use meniscus_sim::{Compiled, LiquidRegion, Model, Simulation};
use std::sync::Arc;

/// Initial condition of a simulation: its model and the bodies of liquid.
#[derive(Clone)]
pub struct Setup<const D: usize> {
    /// The model.
    pub model: Model<D>,
    /// Bodies of liquid with their initial velocity, m/s.
    pub bodies: Vec<(SignedDistanceFn<D>, Vector<D>)>,
}

/// Signed distance to a region of space, m, negative inside.
pub type SignedDistanceFn<const D: usize> = Arc<dyn Fn(&Vector<D>) -> f64 + Send + Sync>;

impl<const D: usize> Setup<D> {
    /// The simulation in its initial state.
    pub fn simulation(&self) -> Simulation<D>
    where
        Simulation<D>: Compiled<D>,
    {
        let bodies: Vec<LiquidRegion<'_, D>> = self
            .bodies
            .iter()
            .map(|(region, velocity)| LiquidRegion { signed_distance: &**region, velocity: *velocity })
            .collect();
        Simulation::new(self.model.clone(), &bodies)
    }
}
