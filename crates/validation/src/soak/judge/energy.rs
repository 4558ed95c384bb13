//! The energy law of a step: without external work the energy never rises.
//!
//! A step moves positions with velocities that lead them by a time `l`, `x' = x + h v`, and then computes the next velocities. The
//! conserved energy of a step without dissipation is that at the time of the velocities, where solids are at `q = x + l v`
//! (`meniscus_elastic::IncrementalPotential`):
//!
//! ```text
//! E = T(v) + Ψ(q) + B(q) + S + l/h (S' − S) + P + l/h (P' − P):
//! ```
//!
//! The terms are kinetic, elastic (with the barrier against inversion), contact barriers with elastic slips of friction, surface, and
//! gravity. For solids the law is exact. Surface and gravity are interpolated between two times, with a second-order error for liquid.
//! Liquid and rigid solids have only `T`, `B`, `S` and `P`.

use super::invariants::MAX_ENERGY_RISE_PER_STEP;
use crate::soak::EnergyLaw;
use meniscus_elastic::{Elastic, ElasticState};
use meniscus_sim::{Barriers, Diagnostics, Model, Simulation, SolidState, State, advanced_solids};

/// Kinds of energy, in the order of [`EnergyLaw::terms`].
pub const ENERGY_TERMS: [&str; 5] = ["kinetic", "elastic", "barrier", "surface", "potential"];

/// Monitors the energy from step to step.
pub struct EnergyMonitor<const D: usize> {
    barriers: Barriers<D>,
    scale: f64,
    /// Quantities at the start of the current step.
    start: Option<StepStart<D>>,
    /// The energies of the previous step, J.
    previous: Option<[f64; 5]>,
    law: EnergyLaw,
}

/// Quantities at the start of a step, with the velocities of that step.
struct StepStart<const D: usize> {
    time: f64,
    /// Time by which the velocities lead, s.
    velocity_lead: f64,
    kinetic: f64,
    surface: f64,
    potential: f64,
    elastic: f64,
    barrier: f64,
}

impl<const D: usize> EnergyMonitor<D> {
    /// A monitor for a model; `scale` is the energy, J, that scales rises.
    pub fn new(model: &Model<D>, scale: f64) -> Self {
        Self { barriers: Barriers::of(model), scale, start: None, previous: None, law: EnergyLaw::default() }
    }

    /// Records a step. Returns the energy within the step, J, from the second step on.
    pub fn record(&mut self, simulation: &Simulation<D>, ledger: &Diagnostics<D>) -> Option<f64> {
        let (model, state) = (&simulation.model, &simulation.state);
        // The energy of liquid that left through open sides is part of the sum.
        let potential = ledger.potential_energy + state.outflow_stored_energy;
        let (solids, slips) = advanced_solids(model, state, state.velocity_lead);
        let now = StepStart {
            time: state.time,
            velocity_lead: state.velocity_lead,
            kinetic: ledger.kinetic_energy + state.outflow_kinetic_energy,
            surface: ledger.surface_energy,
            potential,
            elastic: elastic(model, &solids),
            barrier: self.barriers.energy(model, &solids, &slips),
        };
        let start = self.start.replace(now)?;
        let part = start.velocity_lead / (state.time - start.time);
        let energies = [
            start.kinetic,
            start.elastic,
            start.barrier,
            // If the step is shorter than the lead, the surface energy beyond its end is unknown.
            start.surface + part.min(1.0) * (ledger.surface_energy - start.surface),
            start.potential + part * (potential - start.potential),
        ];
        let total: f64 = energies.iter().sum();
        if !total.is_finite() {
            // If the step is shorter than the lead, solids may overlap or be inverted beyond its end.
            self.previous = None;
            return None;
        }
        let Some(before) = self.previous.replace(energies) else { return Some(total) };
        let terms: [f64; 5] = std::array::from_fn(|k| (energies[k] - before[k]) / self.scale);
        let rise: f64 = terms.iter().sum();
        self.law.steps += 1;
        if rise > MAX_ENERGY_RISE_PER_STEP {
            self.law.rises += 1;
            self.law.sum += rise;
        }
        if rise > self.law.largest {
            (self.law.largest, self.law.terms) = (rise, terms);
            // The energy is that within the step that ends here.
            (self.law.step, self.law.time) = (state.step, state.time);
        }
        Some(total)
    }

    /// The energy of barriers and of elastic slips of friction at the solids' positions, J.
    pub fn barrier_energy(&self, model: &Model<D>, state: &State<D>) -> f64 {
        self.barriers.energy(model, &state.solids, &state.elastic_slips)
    }

    /// Restarts with the next step, which is not compared with earlier ones.
    pub fn reset(&mut self) {
        (self.start, self.previous) = (None, None);
    }

    /// The recorded law.
    pub fn law(&self) -> &EnergyLaw {
        &self.law
    }
}

/// The elastic energy of solids, J.
fn elastic<const D: usize>(model: &Model<D>, solids: &[SolidState<D>]) -> f64 {
    let energy = |(elastic, now): (&Elastic<D>, &ElasticState<D>)| {
        elastic.elastic_energy(&now.positions) + elastic.inversion_barrier_energy(&now.positions)
    };
    model.deformable_solids(solids).map(energy).sum()
}
