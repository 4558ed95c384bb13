//! What a simulation starts from.

use meniscus_numerics::Vector;
use meniscus_sim::{Body, Model, Simulation};
use std::sync::Arc;

/// What a simulation starts from: its model and the bodies of liquid.
#[derive(Clone)]
pub struct Setup<const D: usize> {
    /// The model.
    pub model: Model<D>,
    /// Bodies of liquid with their start velocity, m/s.
    pub bodies: Vec<(Region<D>, Vector<D>)>,
}

/// Signed distance to a region of space, m, negative inside.
pub type Region<const D: usize> = Arc<dyn Fn(&Vector<D>) -> f64 + Send + Sync>;

impl<const D: usize> Setup<D> {
    /// The simulation at its start.
    pub fn simulation(&self) -> Simulation<D> {
        let bodies: Vec<Body<'_, D>> = self
            .bodies
            .iter()
            .map(|(region, velocity)| Body { distance: &**region, velocity: *velocity })
            .collect();
        Simulation::new(self.model.clone(), &bodies)
    }
}
