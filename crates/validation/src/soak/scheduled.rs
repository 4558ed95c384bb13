//! A simulation with the step schedule of `meniscus run`.

use meniscus_scene::build::Setup;
use meniscus_scene::file::Scene;
use meniscus_scene::job::Schedule;
use meniscus_sim::{Compiled, Simulation, StepError, StepReport};

/// A simulation with the step schedule of `meniscus run`.
pub struct ScheduledSimulation<const D: usize> {
    /// The simulation.
    pub simulation: Simulation<D>,
    schedule: Schedule,
    /// The next frame.
    pub frame: u64,
}

impl<const D: usize> ScheduledSimulation<D> {
    /// Starts at time zero.
    pub fn start(setup: &Setup<D>, scene: &Scene) -> Self
    where
        Simulation<D>: Compiled<D>,
    {
        Self::from(setup.simulation(), scene, 1)
    }

    /// Continues from any state on the way to a frame.
    pub fn from(simulation: Simulation<D>, scene: &Scene, frame: u64) -> Self {
        let schedule = Schedule::new(scene.output.frame_interval(), scene.output.duration);
        Self { simulation, schedule, frame }
    }

    /// One step.
    pub fn step(&mut self) -> Result<StepReport<D>, StepError> {
        let now = self.simulation.state.time;
        let fixed = self.simulation.model.numerics.fixed_step.is_some();
        let longest = if fixed { f64::INFINITY } else { self.schedule.longest_step(now, self.frame) };
        let report = self.simulation.step(longest, &mut |_| ())?;
        if self.schedule.is_frame_time(self.simulation.state.time, self.frame) {
            self.simulation.state.time = self.schedule.time(self.frame);
        }
        if self.schedule.has_reached_frame(self.simulation.state.time, self.frame) {
            self.frame += 1;
        }
        Ok(report)
    }

    pub(super) fn is_over(&self) -> bool {
        self.frame > self.schedule.last_frame()
    }
}
