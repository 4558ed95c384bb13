//! Prescribed motion of a rigid solid.

use meniscus_numerics::Vector;

/// A prescribed motion.
#[derive(Clone, Debug, PartialEq)]
pub struct PrescribedMotion<const D: usize> {
    /// Velocity, m/s, where there are no keyframes.
    pub velocity: Vector<D>,
    /// Angular velocity, rad/s (2D: the last entry).
    pub angular_velocity: [f64; 3],
    /// Time, s, and displacement from the start, m; linear in between, constant before and after. Times increase.
    pub keyframes: Vec<(f64, Vector<D>)>,
}

impl<const D: usize> PrescribedMotion<D> {
    /// Mean velocity over `dt` from `time`, m/s.
    pub fn mean_velocity(&self, time: f64, dt: f64) -> Vector<D> {
        (self.displacement(time + dt) - self.displacement(time)) / dt
    }

    /// Displacement from the start at a time, m.
    pub fn displacement(&self, time: f64) -> Vector<D> {
        let frames = &self.keyframes;
        let Some(first) = frames.first() else { return self.velocity * time };
        let k = frames.partition_point(|f| f.0 <= time);
        if k == 0 {
            return first.1;
        }
        let (from, Some(to)) = (&frames[k - 1], frames.get(k)) else { return frames[k - 1].1 };
        from.1 + (to.1 - from.1) * ((time - from.0) / (to.0 - from.0))
    }
}
