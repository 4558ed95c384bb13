//! Statistics of a run beside the state: counters, worst values, wall times.

use crate::estimate::thin_liquid::{ThinLiquid, WARNING_SHARE};
use meniscus_numerics::Vector;
use meniscus_sim::{Diagnostics, Model, Repairs, Solids, StepReport, overlaps};
use serde::{Deserialize, Serialize};

/// Everything that a resumed run needs beside the state. Part of every checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunStatistics {
    /// Number of the frame to write next.
    pub next_frame: u64,
    /// Length of `timeseries.csv` so far, bytes.
    pub series_bytes: u64,
    /// Wall time of the run so far, s.
    pub wall_seconds: f64,
    /// Momentum at the start, kg m/s.
    pub start_momentum: [f64; 3],
    /// Mass at the start, kg (2D: kg/m).
    pub mass: f64,
    /// Largest kinetic energy so far, J; it scales the momentum error.
    pub largest_kinetic_energy: f64,
    /// Worst relative volume error so far, signed.
    pub volume_error: f64,
    /// Worst relative momentum error so far: momentum that does not come from gravity.
    pub momentum_error: f64,
    /// Largest divergence so far, 1/s.
    pub max_divergence: f64,
    /// Largest speed so far, m/s.
    pub max_speed: f64,
    /// Smallest volume of an element of a deformable solid so far, over its rest volume.
    pub least_element: Option<f64>,
    /// Deepest overlap of a deformable solid with anything in a frame so far, m.
    pub deepest_overlap: Option<f64>,
    /// Repairs so far.
    #[serde(with = "repairs")]
    pub repairs: Repairs,
    /// Number of pressure solves.
    pub solves: u64,
    /// Number of their iterations.
    pub iterations: u64,
    /// Most iterations of one solve.
    pub most_iterations: u64,
    /// Liquid thinner than two cells in the frames so far.
    pub thin: ThinLiquidStatistics,
    /// Seconds per named phase, in the order in which they first ended.
    pub phases: Vec<(String, f64)>,
}

/// Liquid thinner than two cells in the frames of a run (see [`crate::estimate::thin_liquid`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ThinLiquidStatistics {
    /// Largest share of the liquid's volume so far.
    pub worst: f64,
    /// Time of that share, s.
    pub worst_time: f64,
    /// Centre of its deepest cell at that time, m; three entries.
    pub worst_place: [f64; 3],
    /// Time at which the share first exceeded [`crate::estimate::thin_liquid::WARNING_SHARE`], s.
    pub first_time: Option<f64>,
}

impl RunStatistics {
    /// Statistics of a run at its start.
    pub fn at_start<const D: usize>(model: &Model<D>, ledger: &Diagnostics<D>) -> Self {
        Self {
            start_momentum: padded_to_3d(&ledger.momentum),
            mass: model.density * ledger.volume,
            largest_kinetic_energy: ledger.kinetic_energy,
            max_speed: ledger.max_speed,
            ..Self::default()
        }
    }

    /// Adds a step. Returns the relative momentum error after it.
    pub fn add_step<const D: usize>(&mut self, model: &Model<D>, time: f64, report: &StepReport<D>) -> f64 {
        let ledger = &report.diagnostics;
        self.largest_kinetic_energy = self.largest_kinetic_energy.max(ledger.kinetic_energy);
        if ledger.volume_error.abs() > self.volume_error.abs() {
            self.volume_error = ledger.volume_error;
        }
        let momentum_error = self.momentum_error(&model.gravity, time, &ledger.momentum);
        self.momentum_error = self.momentum_error.max(momentum_error);
        self.max_divergence = self.max_divergence.max(ledger.divergence_max);
        self.max_speed = self.max_speed.max(ledger.max_speed);
        self.least_element =
            [self.least_element, ledger.least_element].into_iter().flatten().reduce(f64::min);
        self.repairs.add(&report.repairs);
        for iterations in
            report.solves.pressure.iter().map(|solve| solve.iterations as u64).filter(|n| *n > 0)
        {
            self.solves += 1;
            self.iterations += iterations;
            self.most_iterations = self.most_iterations.max(iterations);
        }
        momentum_error
    }

    /// Adds the overlaps of the solids of a frame, if any of them deforms.
    pub fn add_overlaps<const D: usize>(&mut self, solids: Solids<'_, D>) {
        let deforms = |i: usize| solids.get(i).elastic().is_some();
        if (0..solids.states.len()).any(deforms) {
            let so_far = self.deepest_overlap.unwrap_or(0.0);
            let all = overlaps(solids).into_iter().filter(|o| deforms(o.0) || o.1.is_some_and(deforms));
            self.deepest_overlap = Some(all.map(|o| o.2).fold(so_far, f64::max));
        }
    }

    /// Adds the thin liquid of a frame. Returns whether it is the first of the run that exceeds the warning share.
    pub fn add_thin_liquid<const D: usize>(&mut self, time: f64, thin: &ThinLiquid<D>) -> bool {
        if let Some(place) = thin.place.filter(|_| thin.share > self.thin.worst) {
            let (worst, worst_place) = (thin.share, padded_to_3d(&place));
            self.thin = ThinLiquidStatistics { worst, worst_time: time, worst_place, ..self.thin };
        }
        let first = thin.share > WARNING_SHARE && self.thin.first_time.is_none();
        if first {
            self.thin.first_time = Some(time);
        }
        first
    }

    /// $|P - P_0 - M g t| / (M \sqrt{2 E_{max}/M})$: momentum that does not come from gravity, relative to that of all the liquid at its
    /// largest root mean square speed. Walls exert forces too, so it is meaningful for free drops only.
    fn momentum_error<const D: usize>(&self, gravity: &Vector<D>, time: f64, momentum: &Vector<D>) -> f64 {
        let start = Vector::<D>::from_fn(|a, _| self.start_momentum[a]);
        let difference = (momentum - start - gravity * (self.mass * time)).norm();
        let scale = self.momentum_scale();
        if scale > 0.0 { difference / scale } else { 0.0 }
    }

    /// Momentum of all the liquid at its largest root mean square speed so far, kg m/s (2D: kg/s).
    pub fn momentum_scale(&self) -> f64 {
        (2.0 * self.largest_kinetic_energy * self.mass).sqrt()
    }

    /// Adds seconds to a phase.
    pub fn add_phase(&mut self, name: &str, seconds: f64) {
        match self.phases.iter_mut().find(|(known, _)| known == name) {
            Some((_, sum)) => *sum += seconds,
            None => self.phases.push((name.to_string(), seconds)),
        }
    }
}

/// Serialises repairs as numbers in the order of their entries.
mod repairs {
    use meniscus_sim::Repairs;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(repairs: &Repairs, s: S) -> Result<S::Ok, S::Error> {
        repairs.values().serialize(s)
    }

    pub fn deserialize<'de, De: Deserializer<'de>>(d: De) -> Result<Repairs, De::Error> {
        let values = Vec::<f64>::deserialize(d)?;
        Repairs::from_values(&values)
            .ok_or_else(|| De::Error::custom("the number of repair counters differs"))
    }
}

/// A vector with three components; a missing one is 0.
pub(crate) fn padded_to_3d<const D: usize>(v: &Vector<D>) -> [f64; 3] {
    std::array::from_fn(|a| if a < D { v[a] } else { 0.0 })
}
