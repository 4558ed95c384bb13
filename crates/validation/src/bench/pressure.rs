//! The benchmark problem of pressure solvers: a voxelised free-surface Poisson problem.
//!
//! `drop`: a ball of radius 0.3 N in the middle of a box of N³ cells. `tank`: the cells with `j < N/2`. The pressure is zero in every
//! other cell, walls have zero flux, all coefficients are 1. The right-hand side is minus the divergence of a smooth velocity plus 10 %
//! noise hashed from the face, as in the drivers of other solvers.

use meniscus_numerics::grid::{CellField, FaceField, Grid, Run, Runs};
use meniscus_numerics::linalg::{Jacobi, PoissonInput, PressureSolver, SolveError, SolveLimits};
use serde::Serialize;
use std::f64::consts::PI;
use std::time::Instant;

/// Liquid region of the benchmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PressureProblem {
    /// A ball.
    Drop,
    /// The lower half of the box.
    Tank,
}

/// Result of the benchmark.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PressureBench {
    /// Liquid region.
    pub problem: PressureProblem,
    /// Cells along each axis of the box.
    pub n: usize,
    /// Relative tolerance of the residual.
    pub tolerance: f64,
    /// Threads used.
    pub threads: usize,
    /// Number of unknown pressures.
    pub unknowns: usize,
    /// Time to build the multigrid hierarchy, s.
    pub setup_s: f64,
    /// Time to solve from zero, s.
    pub solve_s: f64,
    /// Number of iterations.
    pub iterations: usize,
    /// `‖b − A x‖₂ / ‖b‖₂` at the end.
    pub true_residual: f64,
    /// Time of the same solve with the Jacobi preconditioner, s; none if it was skipped.
    pub jacobi_s: Option<f64>,
    /// Its iterations.
    pub jacobi_iterations: Option<usize>,
    /// Peak memory of the process so far, MB; none where the system does not report it.
    pub peak_memory_mb: Option<f64>,
}

/// The problem in the form of the solver.
#[derive(Clone, Debug)]
pub struct PressureCase {
    /// The grid, of cells of size 1.
    pub grid: Grid<3>,
    /// The liquid cells.
    pub unknowns: Runs,
    /// Coefficients, 1 everywhere.
    pub coefficients: FaceField<3>,
    /// Number of neighbours at zero pressure.
    pub dirichlet: CellField<3>,
    /// Right-hand side.
    pub rhs: CellField<3>,
}

/// Times the solver on a problem of `n` cells along each axis, and with `jacobi` also Jacobi-CG.
///
/// # Errors
/// [`SolveError`] if a solver does not converge.
pub fn run(
    problem: PressureProblem,
    n: usize,
    tolerance: f64,
    jacobi: bool,
) -> Result<PressureBench, SolveError> {
    let case = PressureCase::new(problem, n);
    let start = Instant::now();
    let solver = PressureSolver::new(&case.input());
    let setup_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut x = CellField::new(case.grid, 0.0);
    let report = solver.solve(&case.rhs, &mut x, SolveLimits { tolerance, max_iterations: 100 })?;
    let solve_s = start.elapsed().as_secs_f64();
    let peak_memory_mb = peak_memory_mb();
    let (mut jacobi_s, mut jacobi_iterations) = (None, None);
    if jacobi {
        let start = Instant::now();
        let mut x = CellField::new(case.grid, 0.0);
        let preconditioner = Jacobi::new(&solver.diagonal());
        let limits = SolveLimits { tolerance, max_iterations: 20 * n };
        let report = solver.solve_with(&preconditioner, &case.rhs, &mut x, limits)?;
        (jacobi_s, jacobi_iterations) = (Some(start.elapsed().as_secs_f64()), Some(report.iterations));
    }
    Ok(PressureBench {
        problem,
        n,
        tolerance,
        threads: meniscus_numerics::par::threads(),
        unknowns: case.unknowns.cell_count(),
        setup_s,
        solve_s,
        iterations: report.iterations,
        true_residual: case.residual(&x),
        jacobi_s,
        jacobi_iterations,
        peak_memory_mb,
    })
}

impl PressureCase {
    /// The problem on a box of `n` cells along each axis.
    pub fn new(problem: PressureProblem, n: usize) -> Self {
        let grid = Grid::new([n; 3], 1.0);
        let runs = rows(n).filter_map(|[j, k]| {
            let mut liquid = (0..n).filter(|i| is_liquid(problem, n, [*i, j, k]));
            let start = liquid.next()?;
            let end = liquid.next_back().unwrap_or(start) + 1;
            Some(Run { row: (j + n * k) as u32, start: start as u32, end: end as u32, component: 0 })
        });
        let unknowns = Runs { runs: runs.collect(), components: 1 };
        let mut coefficients = FaceField::zeros(grid);
        coefficients.axes.iter_mut().for_each(|axis| axis.fill(1.0));
        let (mut dirichlet, mut rhs) = (CellField::new(grid, 0.0), CellField::new(grid, 0.0));
        for run in &unknowns.runs {
            for i in run.start as usize..run.end as usize {
                let at = [i, run.row as usize % n, run.row as usize / n];
                let cell = grid.lattice().index(at);
                rhs.data[cell] = right_hand_side(n, at);
                let air = neighbours(n, at).filter(|at| !is_liquid(problem, n, *at)).count();
                dirichlet.data[cell] = air as f64;
            }
        }
        Self { grid, unknowns, coefficients, dirichlet, rhs }
    }

    /// The input of the solver.
    pub fn input(&self) -> PoissonInput<'_, 3> {
        PoissonInput {
            grid: self.grid,
            unknowns: &self.unknowns,
            coefficients: &self.coefficients,
            dirichlet: &self.dirichlet,
        }
    }

    /// `‖b − A x‖₂ / ‖b‖₂`, computed from the definition of the problem.
    pub fn residual(&self, x: &CellField<3>) -> f64 {
        let n = self.grid.cells[0];
        let mut liquid = vec![false; n * n * n];
        for run in &self.unknowns.runs {
            let row = run.row as usize * n;
            liquid[row + run.start as usize..row + run.end as usize].fill(true);
        }
        let (mut norm, mut square) = (0.0, 0.0);
        for cell in (0..n * n * n).filter(|cell| liquid[*cell]) {
            let at = self.grid.lattice().coordinates(cell);
            let flux = neighbours(n, at).map(|at| {
                let other = self.grid.lattice().index(at);
                x.data[cell] - if liquid[other] { x.data[other] } else { 0.0 }
            });
            square += (self.rhs.data[cell] - flux.sum::<f64>()).powi(2);
            norm += self.rhs.data[cell].powi(2);
        }
        (square / norm).sqrt()
    }
}

/// The coordinates of every row.
fn rows(n: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..n).flat_map(move |k| (0..n).map(move |j| [j, k]))
}

fn is_liquid(problem: PressureProblem, n: usize, at: [usize; 3]) -> bool {
    match problem {
        PressureProblem::Tank => at[1] < n / 2,
        PressureProblem::Drop => {
            let square = at.map(|c| (c as f64 + 0.5 - n as f64 * 0.5).powi(2));
            let radius = 0.3 * n as f64;
            square[0] + square[1] + square[2] < radius * radius
        }
    }
}

/// The face neighbours within the box.
fn neighbours(n: usize, at: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..6).filter_map(move |side| {
        let mut other = at;
        let axis = side / 2;
        other[axis] = if side % 2 == 0 { at[axis].checked_sub(1)? } else { at[axis] + 1 };
        (other[axis] < n).then_some(other)
    })
}

/// A hash of an integer, in [0, 1).
fn hash_to_unit(mut a: u32) -> f64 {
    a ^= a >> 16;
    a = a.wrapping_mul(0x7feb_352d);
    a ^= a >> 15;
    a = a.wrapping_mul(0x846c_a68b);
    a ^= a >> 16;
    f64::from(a) * (1.0 / 4_294_967_296.0)
}

/// Velocity through the lower face of a cell.
fn velocity(n: usize, axis: usize, at: [usize; 3]) -> f64 {
    if at[axis] == 0 || at[axis] == n {
        return 0.0;
    }
    let place: [f64; 3] =
        std::array::from_fn(|a| (at[a] as f64 + if a == axis { 0.0 } else { 0.5 }) / n as f64);
    let [x, y, z] = place.map(|c| 2.0 * PI * c);
    let smooth = match axis {
        0 => x.sin() * y.cos(),
        1 => y.sin() * z.cos() - 1.0,
        _ => z.sin() * x.cos(),
    };
    let number = (at[2] * (n + 1) + at[1]) * (n + 1) + at[0];
    let seed = (number as u32).wrapping_mul(3).wrapping_add(axis as u32);
    smooth + 0.1 * (2.0 * hash_to_unit(seed) - 1.0)
}

fn right_hand_side(n: usize, at: [usize; 3]) -> f64 {
    let divergence = (0..3).map(|axis| {
        let mut upper = at;
        upper[axis] += 1;
        velocity(n, axis, upper) - velocity(n, axis, at)
    });
    -divergence.sum::<f64>()
}

/// Largest resident memory of this process, MB.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().trim_end_matches("kB").trim().parse::<f64>().ok().map(|kb| kb / 1024.0)
}
