//! The energy law of a step: in a scene on which nothing does work the energy never rises.
//!
//! A step moves positions with velocities that are a time `l` ahead of them, `x' = x + h v`, and then finds the coming velocities. Where
//! steps are of one length, `l = h/2`, and what a step keeps that dissipates nothing is the energy half-way through it
//! (`meniscus_elastic::Elastic::energy`). At the time of the velocities, with `w = l/h`, at most 1,
//!
//! ```text
//! E = T(v) + Ψ(x + w (x' − x)) + B(x') + S + w (S' − S) + P + w (P' − P):
//! ```
//!
//! kinetic, elastic, that of the barriers, that of the surface, and that of gravity. For linear solids and gravity it is exact; the
//! barriers' forces are those at the end of a step, where their energy is taken. The surface's is between two times, with an error
//! of second order in the step. Liquid and rigid solids have no energy but `T`, `S` and `P`.

use super::EnergyLaw;
use super::invariants::ENERGY_STEP;
use meniscus_numerics::Vector;
use meniscus_sim::{Barriers, Ledger, Model, Simulation};

/// Kinds of energy, in the order of [`EnergyLaw::terms`].
pub const TERMS: [&str; 5] = ["kinetic", "elastic", "barrier", "surface", "potential"];

/// The books of the energy from step to step.
pub struct EnergySteps<const D: usize> {
    barriers: Barriers<D>,
    scale: f64,
    /// What was true at the start of the step that goes on.
    start: Option<Start<D>>,
    /// The energies of the step before, J.
    before: Option<[f64; 5]>,
    law: EnergyLaw,
}

/// The positions of a time, and velocities of the step from there.
struct Start<const D: usize> {
    time: f64,
    /// How far the velocities are ahead, s.
    lead: f64,
    kinetic: f64,
    surface: f64,
    potential: f64,
    positions: Vec<Vec<Vector<D>>>,
}

impl<const D: usize> EnergySteps<D> {
    /// The books of a model; `scale` is the energy, J, that rises are compared with.
    pub fn open(model: &Model<D>, scale: f64) -> Self {
        Self { barriers: Barriers::of(model), scale, start: None, before: None, law: EnergyLaw::default() }
    }

    /// Takes a step to the books.
    pub fn note(&mut self, simulation: &Simulation<D>, ledger: &Ledger<D>) {
        let (model, state) = (&simulation.model, &simulation.state);
        let now = Start {
            time: state.time,
            lead: state.lead,
            kinetic: ledger.kinetic_energy,
            surface: ledger.surface_energy,
            potential: ledger.potential_energy,
            positions: positions(simulation),
        };
        let Some(start) = self.start.replace(now) else { return };
        // Where a step is so much shorter than the last that the velocities' time is beyond it, its end counts.
        let part = (start.lead / (state.time - start.time)).min(1.0);
        let energies = [
            start.kinetic,
            elastic(simulation, &start.positions, part),
            self.barriers.energy(model, &state.solids),
            start.surface + part * (ledger.surface_energy - start.surface),
            start.potential + part * (ledger.potential_energy - start.potential),
        ];
        let Some(before) = self.before.replace(energies) else { return };
        let terms: [f64; 5] = std::array::from_fn(|k| (energies[k] - before[k]) / self.scale);
        let rise: f64 = terms.iter().sum();
        self.law.steps += 1;
        if rise > ENERGY_STEP {
            self.law.rises += 1;
            self.law.sum += rise;
        }
        if rise > self.law.largest {
            (self.law.largest, self.law.terms) = (rise, terms);
            // The energy is that within the step that ended here.
            (self.law.step, self.law.time) = (state.step, state.time);
        }
    }

    /// Begins anew with the next step: what goes on until then is not compared.
    pub fn forget(&mut self) {
        (self.start, self.before) = (None, None);
    }

    /// What was found.
    pub fn law(&self) -> &EnergyLaw {
        &self.law
    }
}

/// Where the vertices of all solids are that deform, m.
fn positions<const D: usize>(simulation: &Simulation<D>) -> Vec<Vec<Vector<D>>> {
    let of = |now: &meniscus_sim::SolidState<D>| {
        now.soft.as_ref().map_or(Vec::new(), |soft| soft.body.positions.clone())
    };
    simulation.state.solids.iter().map(of).collect()
}

/// The elastic energy on a part of the way from earlier positions to those now, J.
fn elastic<const D: usize>(simulation: &Simulation<D>, from: &[Vec<Vector<D>>], part: f64) -> f64 {
    let mut sum = 0.0;
    for ((solid, now), from) in simulation.model.solids.iter().zip(&simulation.state.solids).zip(from) {
        let Some((elastic, soft)) = solid.elastic().zip(now.soft.as_ref()) else { continue };
        let middle: Vec<Vector<D>> =
            from.iter().zip(&soft.body.positions).map(|(a, b)| a + (b - a) * part).collect();
        sum += elastic.elastic_energy(&middle);
    }
    sum
}
