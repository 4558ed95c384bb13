//! Force and moment of the liquid on solids, and their means over time.

use meniscus_numerics::Vector;
use meniscus_sim::Simulation;

/// A force in the plane, N/m, and its moment about a point, N.
#[derive(Clone, Copy, Debug)]
pub struct Wrench {
    /// The force, N/m.
    pub force: Vector<2>,
    /// The moment, N; counterclockwise is positive.
    pub moment: f64,
}

/// The mean and the spread of a quantity over time.
#[derive(Clone, Copy, Debug, Default)]
pub struct TimeMean {
    time: f64,
    sum: f64,
    squares: f64,
}

impl TimeMean {
    /// Adds a value that holds for a duration, s.
    pub fn add(&mut self, value: f64, time: f64) {
        self.time += time;
        self.sum += value * time;
        self.squares += value * value * time;
    }

    /// The mean; NaN if nothing was added.
    pub fn mean(&self) -> f64 {
        self.sum / self.time
    }

    /// The standard deviation.
    pub fn deviation(&self) -> f64 {
        let mean = self.mean();
        (self.squares / self.time - mean * mean).max(0.0).sqrt()
    }
}

/// Momentum, angular momentum about the origin and mass of a solid.
#[derive(Clone, Copy, Debug)]
pub struct SolidMotion<const D: usize> {
    /// The momentum.
    pub momentum: Vector<D>,
    /// The angular momentum.
    pub angular_momentum: Vector<3>,
    /// The mass.
    pub mass: f64,
}

/// The motion of a deformable solid; zero for a rigid one.
pub fn soft_motion<const D: usize>(sim: &Simulation<D>, solid: usize) -> SolidMotion<D> {
    let (momentum, angular_momentum) = (Vector::zeros(), Vector::<3>::zeros());
    let body = sim.model.solids[solid].elastic().zip(sim.state.solids[solid].as_deformable());
    body.map_or(SolidMotion { momentum, angular_momentum, mass: 0.0 }, |(elastic, body)| SolidMotion {
        momentum: elastic.momentum(&body.vertices),
        angular_momentum: Vector::from(elastic.angular_momentum(&body.vertices)),
        mass: elastic.masses().iter().sum(),
    })
}

/// The force of the liquid's pressure and contact lines on a solid in the last step, N/m.
pub fn liquid_force(sim: &Simulation<2>, solid: usize) -> Vector<2> {
    let now = &sim.state.solids[solid];
    now.pressure_force + now.contact_line_force
}

/// The external load without gravity on an anchored solid, from its elastic forces; the moment is about `point`.
///
/// The elastic forces of a whole solid have no resultant force and moment. On its free vertices they balance liquid and gravity, so those
/// on the anchored vertices, minus the weight of the free ones, equal the load of the liquid. This holds at rest, and for means over
/// time. None for a rigid solid.
pub fn external_load(sim: &Simulation<2>, solid: usize, point: &Vector<2>) -> Option<Wrench> {
    let elastic = sim.model.solids[solid].elastic()?;
    let positions = &sim.state.solids[solid].as_deformable()?.vertices.positions;
    let mut all = Wrench { force: Vector::zeros(), moment: 0.0 };
    let vertices =
        elastic.forces(positions).into_iter().zip(positions).zip(elastic.anchored()).zip(elastic.masses());
    for (((elastic_force, x), held), mass) in vertices {
        let force = if *held { elastic_force } else { -*mass * sim.model.gravity };
        let arm = x - point;
        all.force += force;
        all.moment += arm[0] * force[1] - arm[1] * force[0];
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_weighted_by_time() {
        let mut mean = TimeMean::default();
        mean.add(1.0, 3.0);
        mean.add(5.0, 1.0);
        assert!((mean.mean() - 2.0).abs() < 1e-15 && (mean.deviation() - 3.0_f64.sqrt()).abs() < 1e-15);
    }
}
