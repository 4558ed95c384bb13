//! The backend of this crate: conjugate gradients with multigrid, and with bodies the exact inverse on their cells where that is too slow.
//!
//! A rigid body separates as many eigenvalues as it has degrees of freedom, and costs about as many iterations (D. Aanjaneya, "An
//! efficient solver for two-way coupling rigid bodies with incompressible flow", CGF 2018). For a deformable body the multigrid uses the
//! compliance of each cell by itself, as if the wall were porous: the caller adds this lumped compliance to the Dirichlet coefficients,
//! and the operator subtracts it.

use super::backend::{PreparedPressureSystem, PressureBackend};
use super::coupled::CoupledOperator;
use super::schwarz::{Schwarz, SubdomainInverse};
use super::solver::{PressureSolver, RelatedSystem, UnconvergedIterate};
use super::system::{CoupledBodies, PressureSystem};
use crate::grid::CellField;
use crate::linalg::operator::{LinearOperator, SolveError, SolveLimits, SolveReport};
use std::sync::{Mutex, OnceLock};

/// Number of batched body solves that take as long as a single one: an estimate for supernodal factors, which affects the cost only.
const BATCH_SPEEDUP: usize = 4;

/// Conjugate gradients with multigrid.
#[derive(Debug, Default)]
pub struct MultigridBackend<const D: usize> {
    /// The last solver, kept for its memory.
    solver: Option<PressureSolver<D>>,
}

impl<const D: usize> PressureBackend<D> for MultigridBackend<D> {
    fn prepare<'a>(
        &'a mut self,
        system: &PressureSystem<'_, 'a, D>,
    ) -> Result<Box<dyn PreparedPressureSystem<D> + 'a>, SolveError> {
        let solver = PressureSolver::reusing_memory(self.solver.take(), &system.matrix);
        let solver = &*self.solver.insert(solver);
        Ok(match system.bodies {
            Some(bodies) => Box::new(WithBodies::new(solver, bodies)),
            None => Box::new(Alone(solver)),
        })
    }
}

/// A system without bodies.
struct Alone<'a, const D: usize>(&'a PressureSolver<D>);

impl<const D: usize> PreparedPressureSystem<D> for Alone<'_, D> {
    fn solve(
        &mut self,
        rhs: &CellField<D>,
        x: &mut CellField<D>,
        limits: SolveLimits,
    ) -> Result<SolveReport, SolveError> {
        self.0.solve(rhs, x, limits)
    }
}

/// A system with bodies.
struct WithBodies<'a, const D: usize> {
    solver: &'a PressureSolver<D>,
    operator: CoupledOperator<'a, D>,
    /// The floating components of the solver on which a constant pressure acts on no body.
    floats: Vec<usize>,
    /// The exact inverse on the bodies' cells, built once a solve without it was too slow; contains `None` where it does not exist.
    subdomain_inverse: OnceLock<Option<SubdomainInverse>>,
}

impl<'a, const D: usize> WithBodies<'a, D> {
    fn new(solver: &'a PressureSolver<D>, bodies: &'a CoupledBodies<'a>) -> Self {
        let floats = solver.floating_with_columns(&bodies.mean_pressure_probes);
        let operator = CoupledOperator::new(solver, bodies);
        Self { solver, operator, floats, subdomain_inverse: OnceLock::new() }
    }
}

impl<const D: usize> PreparedPressureSystem<D> for WithBodies<'_, D> {
    /// Multigrid alone may take as long as building the exact inverse on the bodies' cells would: the total is at most twice the time of
    /// the faster of both (ski rental).
    fn solve(
        &mut self,
        rhs: &CellField<D>,
        x: &mut CellField<D>,
        limits: SolveLimits,
    ) -> Result<SolveReport, SolveError> {
        let Self { solver, operator, floats, subdomain_inverse } = self;
        let multigrid = RelatedSystem { operator, preconditioner: solver.preconditioner(), floats };
        let SolveLimits { tolerance, max_iterations: most } = limits;
        let mut done = 0;
        if subdomain_inverse.get().is_none() {
            let first = most.min(operator.cell_count().div_ceil(BATCH_SPEEDUP));
            let limits = SolveLimits { tolerance, max_iterations: first };
            let report = solver.solve_system(&multigrid, rhs, x, limits, UnconvergedIterate::Keep);
            let slow =
                matches!(report, Err(SolveError::NotConverged { iterations, .. }) if iterations == first);
            if !slow || first == most {
                return report;
            }
            done = first;
        }
        let limits = SolveLimits { tolerance, max_iterations: most - done };
        let report = match subdomain_inverse.get_or_init(|| operator.subdomain_inverse()) {
            Some(subdomain) => {
                let work = Mutex::new([(); 2].map(|()| vec![0.0; solver.size()]));
                let schwarz =
                    Schwarz { system: *solver, multigrid: solver.preconditioner(), subdomain, work };
                let schwarz = RelatedSystem { operator, preconditioner: &schwarz, floats };
                solver.solve_system(&schwarz, rhs, x, limits, UnconvergedIterate::Discard)
            }
            None => solver.solve_system(&multigrid, rhs, x, limits, UnconvergedIterate::Discard),
        };
        report.map(|report| SolveReport { iterations: report.iterations + done, ..report })
    }
}
