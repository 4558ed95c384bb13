//! The pressure matrix against a dense solve.

use crate::measure::{at_least, at_most, bars};
use crate::{Case, Check};
use meniscus_numerics::fit::{min_relative_pivot, solve};
use meniscus_numerics::grid::{CellField, FaceField, Grid, Lattice, Run, Runs};
use meniscus_numerics::linalg::{LinearOperator, PoissonInput, PressureSolver, SolveLimits};

/// The case.
pub const CASE: Case = Case {
    name: "pressure-matrix",
    title: "Pressure matrix and solver",
    theory: "The pressure system of a random free surface in 8³ cells (coefficients over four orders of magnitude, \
        random distances to the surface). The matrix-free operator, applied to the unit vectors, gives the dense \
        matrix; it is compared with the matrix assembled from its definition, is symmetric and positive definite \
        (Cholesky), and the multigrid solution agrees with Gaussian elimination.",
    quick: true,
    run: |_| run(),
};

/// Cells along each axis.
const CELLS: usize = 8;

/// A reproducible sequence of numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A system with a free surface.
struct System {
    grid: Grid<3>,
    unknowns: Runs,
    /// Cells of the unknowns, in order.
    cells: Vec<usize>,
    coefficients: FaceField<3>,
    dirichlet: CellField<3>,
}

impl System {
    /// Liquid in a bumpy ball that touches a wall; the pressure beyond its surface is given.
    fn new(random: &mut Random) -> Self {
        let grid = Grid::new([CELLS; 3], 1.0);
        let lattice = grid.lattice();
        let bumps: Vec<f64> = (0..lattice.len()).map(|_| random.next()).collect();
        let inside = |i: usize| {
            let x = grid.center(lattice.coordinates(i));
            (x - meniscus_numerics::Vector::<3>::new(4.0, 3.6, 2.9)).norm() < 2.6 + 1.2 * bumps[i]
        };
        let liquid: Vec<bool> = (0..lattice.len()).map(inside).collect();
        let runs = runs(&lattice, &liquid).label(&grid);
        let cells: Vec<usize> = (0..lattice.len()).filter(|i| liquid[*i]).collect();
        let mut coefficients = FaceField::zeros(grid);
        let mut dirichlet = CellField::new(grid, 0.0);
        for &i in &cells {
            let at = lattice.coordinates(i);
            for a in 0..3 {
                let upper = at[a] + 1 < CELLS;
                if upper && liquid[i + lattice.stride[a]] {
                    let face = grid.face_lattice(a).index(at) + grid.face_lattice(a).stride[a];
                    coefficients.axes[a][face] = 10_f64.powf(4.0 * random.next() - 4.0);
                }
                let air = [(at[a] > 0).then(|| i - lattice.stride[a]), upper.then(|| i + lattice.stride[a])];
                for n in air.into_iter().flatten().filter(|n| !liquid[*n]) {
                    dirichlet.data[i] += (0.2 + 0.8 * bumps[n]) / (0.01 + random.next());
                }
            }
        }
        Self { grid, unknowns: runs, cells, coefficients, dirichlet }
    }

    fn input(&self) -> PoissonInput<'_, 3> {
        let (coefficients, dirichlet) = (&self.coefficients, &self.dirichlet);
        PoissonInput { grid: self.grid, unknowns: &self.unknowns, coefficients, dirichlet }
    }

    /// The matrix by its definition.
    fn dense(&self) -> Vec<Vec<f64>> {
        let lattice = self.grid.lattice();
        let mut matrix = vec![vec![0.0; self.cells.len()]; self.cells.len()];
        for (i, &cell) in self.cells.iter().enumerate() {
            matrix[i][i] += self.dirichlet.data[cell];
            let at = lattice.coordinates(cell);
            for a in (0..3).filter(|a| at[*a] + 1 < CELLS) {
                if let Ok(j) = self.cells.binary_search(&(cell + lattice.stride[a])) {
                    let c = self.coefficients.axes[a]
                        [self.grid.face_lattice(a).index(at) + self.grid.face_lattice(a).stride[a]];
                    matrix[i][i] += c;
                    matrix[j][j] += c;
                    matrix[i][j] -= c;
                    matrix[j][i] -= c;
                }
            }
        }
        matrix
    }

    /// The matrix of the operator, column by column.
    fn applied(&self, solver: &PressureSolver<3>) -> Vec<Vec<f64>> {
        let column = |cell: &usize| {
            let mut unit = CellField::new(self.grid, 0.0);
            unit.data[*cell] = 1.0;
            let mut image = vec![0.0; solver.size()];
            solver.apply(&solver.gather(&unit.data), &mut image);
            solver.scatter(&image, &mut unit.data);
            self.cells.iter().map(|c| unit.data[*c]).collect()
        };
        self.cells.iter().map(column).collect()
    }
}

/// The runs of the cells where `holds` is true.
fn runs(lattice: &Lattice<3>, holds: &[bool]) -> Runs {
    let mut runs: Vec<Run> = Vec::new();
    for cell in (0..lattice.len()).filter(|c| holds[*c]) {
        let (row, i) = ((cell / lattice.extent[0]) as u32, (cell % lattice.extent[0]) as u32);
        match runs.last_mut() {
            Some(last) if last.row == row && last.end == i => last.end += 1,
            _ => runs.push(Run { row, start: i, end: i + 1, component: 0 }),
        }
    }
    Runs { runs, components: 1 }
}

fn run() -> Vec<Check> {
    let (mut matrix_error, mut asymmetry, mut solution_error): (f64, f64, f64) = (0.0, 0.0, 0.0);
    let mut pivot = f64::INFINITY;
    for seed in 1..=8 {
        let mut random = Random(seed);
        let system = System::new(&mut random);
        let solver = PressureSolver::new(&system.input());
        let (dense, applied) = (system.dense(), system.applied(&solver));
        let n = dense.len();
        let scale = (0..n).map(|i| dense[i][i]).fold(0.0, f64::max);
        for i in 0..n {
            for j in 0..n {
                matrix_error = matrix_error.max((dense[i][j] - applied[i][j]).abs() / scale);
                asymmetry = asymmetry.max((applied[j][i] - applied[i][j]).abs() / scale);
            }
        }
        pivot = pivot.min(min_relative_pivot(applied));
        let mut rhs = CellField::new(system.grid, 0.0);
        system.cells.iter().for_each(|c| rhs.data[*c] = random.next() - 0.5);
        let mut x = CellField::new(system.grid, 0.0);
        let limits = SolveLimits { tolerance: 1e-13, max_iterations: 500 };
        let solved = solver.solve(&rhs, &mut x, limits).is_ok();
        let exact = solve(dense, system.cells.iter().map(|c| rhs.data[*c]).collect()).unwrap_or_default();
        let size = exact.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let off = system.cells.iter().zip(&exact).map(|(c, v)| (x.data[*c] - v).abs()).fold(0.0, f64::max);
        solution_error = solution_error.max(if solved && size > 0.0 { off / size } else { f64::INFINITY });
    }
    let case = "pressure-matrix";
    vec![
        at_most(case, "operator against the assembled matrix", matrix_error, bars(1e-10, 1e-15)),
        at_most(case, "asymmetry", asymmetry, bars(1e-10, 1e-15)),
        at_most(case, "solution against elimination", solution_error, bars(1e-10, 1e-12)),
        at_least(case, "smallest Cholesky pivot / largest diagonal entry", pivot, 1e-12, 1e-9),
    ]
}
