use super::PoissonInput;
use crate::grid::{CellField, FaceField, Grid, Run, Runs};
use crate::linalg::{
    Jacobi, LinearOperator, Preconditioner, PressureSolver, SolveError, SolveLimits, conjugate_gradient,
};
use nalgebra::{DMatrix, DVector};

/// A pressure system and the fields of its input.
pub struct System<const D: usize> {
    pub grid: Grid<D>,
    pub unknowns: Runs,
    pub coefficients: FaceField<D>,
    pub dirichlet: CellField<D>,
}

/// Limits of a solve.
pub fn limits(tolerance: f64, max_iterations: usize) -> SolveLimits {
    SolveLimits { tolerance, max_iterations }
}

/// A reproducible sequence of numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

impl<const D: usize> System<D> {
    /// A system on the cells where `liquid` holds; other faces and cells hold NaN.
    pub fn new(
        cells: [usize; D],
        liquid: impl Fn([usize; D]) -> bool,
        mut coefficient: impl FnMut() -> f64,
        mut dirichlet: impl FnMut([usize; D]) -> f64,
    ) -> Self {
        let grid = Grid::new(cells, 1.0);
        let lattice = grid.lattice();
        let is = |cell: usize| liquid(lattice.coordinates(cell));
        let mut component = vec![u32::MAX; lattice.len()];
        let mut components = 0;
        for seed in (0..lattice.len()).filter(|c| is(*c)) {
            if component[seed] != u32::MAX {
                continue;
            }
            let mut stack = vec![seed];
            while let Some(cell) = stack.pop() {
                component[cell] = components;
                let next = neighbours(&grid, cell).into_iter().map(|n| n.0);
                stack.extend(next.filter(|n| is(*n) && component[*n] == u32::MAX));
            }
            components += 1;
        }
        let mut runs: Vec<Run> = Vec::new();
        for cell in (0..lattice.len()).filter(|c| is(*c)) {
            let (row, i) = ((cell / cells[0]) as u32, (cell % cells[0]) as u32);
            match runs.last_mut() {
                Some(last) if last.row == row && last.end == i => last.end += 1,
                _ => runs.push(Run { row, start: i, end: i + 1, component: component[cell] }),
            }
        }
        let mut coefficients = FaceField::zeros(grid);
        coefficients.axes.iter_mut().for_each(|axis| axis.fill(f64::NAN));
        let mut held = CellField::new(grid, f64::NAN);
        for cell in (0..lattice.len()).filter(|c| is(*c)) {
            held.data[cell] = dirichlet(lattice.coordinates(cell));
            for (other, axis, face, upper) in neighbours(&grid, cell) {
                if upper && is(other) {
                    coefficients.axes[axis][face] = coefficient();
                }
            }
        }
        Self { grid, unknowns: Runs { runs, components }, coefficients, dirichlet: held }
    }

    /// Random cells, coefficients over four orders of magnitude, some of them zero.
    pub fn random(cells: [usize; D], density: f64, seed: u64) -> Self {
        let mut random = Random(seed);
        let lattice = Grid::new(cells, 1.0).lattice();
        let liquid: Vec<bool> = (0..lattice.len()).map(|_| random.next() < density).collect();
        let mut other = Random(seed + 99);
        let coefficient =
            move || if random.next() < 0.02 { 0.0 } else { 10_f64.powf(4.0 * random.next() - 4.0) };
        let dirichlet = move |_| if other.next() < 0.7 { 0.0 } else { 50.0 * other.next() };
        Self::new(cells, |at| liquid[lattice.index(at)], coefficient, dirichlet)
    }

    pub fn input(&self) -> PoissonInput<'_, D> {
        PoissonInput {
            grid: self.grid,
            unknowns: &self.unknowns,
            coefficients: &self.coefficients,
            dirichlet: &self.dirichlet,
        }
    }

    /// The unknown cells.
    pub fn cells(&self) -> Vec<usize> {
        let row = self.grid.cells[0];
        let runs = self.unknowns.runs.iter();
        runs.flat_map(|r| (r.start..r.end).map(move |i| r.row as usize * row + i as usize)).collect()
    }

    /// The assembled matrix, in the order of [`Self::cells`].
    pub fn dense(&self) -> DMatrix<f64> {
        let cells = self.cells();
        let mut matrix = DMatrix::zeros(cells.len(), cells.len());
        for (i, cell) in cells.iter().enumerate() {
            matrix[(i, i)] += self.dirichlet.data[*cell];
            for (other, axis, face, _) in neighbours(&self.grid, *cell) {
                if let Ok(j) = cells.binary_search(&other) {
                    let c = self.coefficients.axes[axis][face];
                    matrix[(i, i)] += c;
                    matrix[(i, j)] -= c;
                }
            }
        }
        matrix
    }

    pub fn random_field(&self, seed: u64) -> CellField<D> {
        let mut random = Random(seed);
        let mut field = CellField::new(self.grid, f64::NAN);
        self.cells().iter().for_each(|cell| field.data[*cell] = random.next() - 0.5);
        field
    }

    pub fn values(&self, field: &CellField<D>) -> DVector<f64> {
        DVector::from_iterator(self.unknowns.cell_count(), self.cells().iter().map(|c| field.data[*c]))
    }
}

/// Neighbour, axis, face and whether it is the upper one.
fn neighbours<const D: usize>(grid: &Grid<D>, cell: usize) -> Vec<(usize, usize, usize, bool)> {
    let at = grid.lattice().coordinates(cell);
    let mut found = Vec::new();
    for a in 0..D {
        let face = grid.face_lattice(a).index(at);
        let stride = grid.lattice().stride[a];
        if at[a] > 0 {
            found.push((cell - stride, a, face, false));
        }
        if at[a] + 1 < grid.cells[a] {
            found.push((cell + stride, a, face + grid.face_lattice(a).stride[a], true));
        }
    }
    found
}

/// Two long slabs of cells with equal coefficients inside, so that there are uniform spans.
pub fn slab<const D: usize>() -> System<D> {
    let mut cells = [6; D];
    cells[0] = 53;
    System::new(cells, |at| at[1] < 5 || at[0] > 36, || 2.5, |at| if at[1] == 4 { 3.0 } else { 0.0 })
}

fn operator_matches<const D: usize>(system: &System<D>) {
    let solver = PressureSolver::new(&system.input());
    let dense = system.dense();
    let x = system.random_field(5);
    let gathered = solver.gather(&x.data);
    let mut y = vec![0.0; solver.size()];
    let dot = solver.apply_dot(&gathered, &mut y);
    let mut result = CellField::new(system.grid, f64::NAN);
    solver.scatter(&y, &mut result.data);
    let isolated = |i: usize| dense[(i, i)] == 0.0;
    let expected = &dense * system.values(&x);
    let got = system.values(&result);
    for i in (0..expected.len()).filter(|i| !isolated(*i)) {
        assert!(
            (got[i] - expected[i]).abs() <= 1e-12 * (1.0 + dense[(i, i)]),
            "{i}: {} {}",
            got[i],
            expected[i]
        );
    }
    let plain: f64 = gathered.iter().zip(&y).map(|(a, b)| a * b).sum();
    assert!((dot - plain).abs() <= 1e-12 * plain.abs());
    for (number, cell) in system.cells().into_iter().enumerate() {
        let entry = solver.entry(system.grid.lattice().coordinates(cell)).unwrap();
        assert_eq!(gathered[entry], x.data[cell]);
        assert!(isolated(number) || (solver.diagonal()[entry] / dense[(number, number)] - 1.0).abs() < 1e-14);
    }
}

#[test]
fn operator_equals_the_assembled_matrix() {
    for seed in 0..4 {
        operator_matches(&System::random([8; 2], 0.7, seed));
        operator_matches(&System::random([8; 3], 0.7, seed));
        operator_matches(&System::random([37, 7], 0.9, seed));
    }
    operator_matches(&slab::<2>());
    operator_matches(&slab::<3>());
}

/// Projects a right-hand side onto the range of the system, as the solver documents it.
fn consistent<const D: usize>(system: &System<D>, rhs: &CellField<D>) -> CellField<D> {
    let mut rhs = rhs.clone();
    PressureSolver::new(&system.input()).tap_project(&mut rhs);
    rhs
}

impl<const D: usize> PressureSolver<D> {
    fn tap_project(&self, field: &mut CellField<D>) {
        let mut vector = self.gather(&field.data);
        self.project(&mut vector);
        self.scatter(&vector, &mut field.data);
    }
}

fn solution_matches<const D: usize>(system: &System<D>) {
    let solver = PressureSolver::new(&system.input());
    let rhs = consistent(system, &system.random_field(3));
    let mut x = system.random_field(4);
    let report = solver.solve(&rhs, &mut x, limits(1e-12, 400)).unwrap();
    let dense = system.dense();
    let residual = &dense * system.values(&x) - system.values(&rhs);
    assert!(residual.norm() <= 2e-12 * system.values(&rhs).norm());
    assert!((residual.norm() / system.values(&rhs).norm() - report.residual).abs() < 1e-14);
    // Reference: dense solution of the matrix with the constants of floating components lifted.
    let mut lifted = dense.clone();
    for i in 0..lifted.nrows() {
        lifted[(i, i)] += f64::from(u8::from(lifted[(i, i)] == 0.0));
    }
    let cells = system.cells();
    for (runs, _) in &solver.floating {
        let row = system.grid.cells[0];
        let of = |r: &Run| (r.start..r.end).map(|i| r.row as usize * row + i as usize).collect::<Vec<_>>();
        let members: Vec<usize> =
            runs.iter().flat_map(of).map(|c| cells.binary_search(&c).unwrap()).collect();
        for i in members.iter().filter(|i| dense[(**i, **i)] > 0.0) {
            for j in members.iter().filter(|j| dense[(**j, **j)] > 0.0) {
                lifted[(*i, *j)] += 1.0 / members.len() as f64;
            }
        }
    }
    let exact = lifted.cholesky().expect("positive definite").solve(&system.values(&rhs));
    let error = (&exact - system.values(&x)).norm() / exact.norm();
    assert!(error < 1e-10, "{error}");
    assert!(report.iterations < 200, "{}", report.iterations);
}

#[test]
fn solution_equals_that_of_a_dense_solver() {
    solution_matches(&slab::<2>());
    solution_matches(&slab::<3>());
    for seed in 0..4 {
        let coefficients = |seed| {
            let mut random = Random(seed);
            move || 10_f64.powf(random.next() - 0.5)
        };
        let held = |at: [usize; 2]| f64::from(u8::from(at[0] == 3));
        let mask = |at: [usize; 2]| (at[0] * 7 + at[1] * 13 + at[0] * at[1]) % 11 > 3;
        solution_matches(&System::new([24, 23], mask, coefficients(seed), held));
        let held = |at: [usize; 3]| 50.0 * f64::from(u8::from(at[2] == 3));
        let mask = |at: [usize; 3]| (at[0] * 7 + at[1] * 13 + at[0] * at[1] + at[2] * 3) % 11 > 2;
        solution_matches(&System::new([9, 8, 7], mask, coefficients(seed), held));
    }
}

#[test]
fn floating_component_beside_a_held_one_and_lone_cells() {
    // Two boxes, the upper one without Dirichlet values, a chessboard corner of single cells, some isolated.
    let liquid = |at: [usize; 3]| {
        (at[2] != 4 && at[0] < 18) || (at[0] > 19 && (at[0] + at[1] + at[2]).is_multiple_of(2))
    };
    let held = |at: [usize; 3]| f64::from(u8::from((at[2] == 0 && at[0] < 18) || (at[0] > 19 && at[1] == 1)));
    let system = System::new([24, 6, 9], liquid, || 1.0, held);
    assert!(system.unknowns.components > 20);
    solution_matches(&system);
    let solver = PressureSolver::new(&system.input());
    let mut x = CellField::new(system.grid, 7.0);
    solver.solve(&system.random_field(1), &mut x, limits(1e-10, 100)).unwrap();
    let upper = |c: usize| {
        let at = system.grid.lattice().coordinates(c);
        at[2] > 4 && at[0] < 18
    };
    let mean: f64 = system.cells().iter().filter(|c| upper(**c)).map(|c| x.data[*c]).sum();
    assert!(mean.abs() < 1e-8);
    assert_eq!(x.data[system.grid.lattice().index([20, 0, 0])], 0.0);
    assert_eq!(x.data[system.grid.lattice().index([0, 0, 4])], 7.0);
}

#[test]
fn pocket_behind_faces_without_flux() {
    // One box of cells, cut in two by faces without flux; only one side has Dirichlet values.
    for axis in 0..3 {
        let held = |at: [usize; 3]| f64::from(u8::from(at[axis] == 0));
        let mut system = System::new([20, 9, 7], |_| true, || 1.0, held);
        let faces = system.grid.face_lattice(axis);
        let cut = |face: usize| faces.coordinates(face)[axis] == 4;
        let zeros = (0..faces.len()).filter(|face| cut(*face));
        zeros.for_each(|face| system.coefficients.axes[axis][face] = 0.0);
        assert_eq!(system.unknowns.components, 1);
        solution_matches(&system);
    }
    for seed in 0..6 {
        solution_matches(&System::<3>::random([19, 8, 5], 0.9, seed));
        solution_matches(&System::<2>::random([33, 20], 0.7, seed));
    }
}

fn cycle_is_symmetric<const D: usize>(system: &System<D>) {
    let solver = PressureSolver::new(&system.input());
    let apply = |r: &[f64]| {
        let mut z = vec![0.0; r.len()];
        solver.preconditioner().apply(r, &mut z);
        z
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut fields = [system.random_field(1), system.random_field(2)].map(|f| solver.gather(&f.data));
    fields.iter_mut().for_each(|f| solver.project(f));
    let [x, y] = fields;
    let (mx, my) = (apply(&x), apply(&y));
    let size = (dot(&x, &mx) * dot(&y, &my)).sqrt();
    assert!((dot(&mx, &y) - dot(&x, &my)).abs() < 2e-6 * size, "{} {}", dot(&mx, &y), dot(&x, &my));
    assert!(dot(&x, &mx) > 0.0 && dot(&y, &my) > 0.0);
    assert!((solver.preconditioner().apply(&x, &mut vec![0.0; x.len()]) / dot(&x, &mx) - 1.0).abs() < 1e-12);
}

#[test]
fn cycle_is_symmetric_and_positive() {
    let held = |n| move |at: [usize; 3]| f64::from(u8::from(at[1] + 1 == n));
    cycle_is_symmetric(&System::new([40, 20, 23], |_| true, || 1.0, held(20)));
    cycle_is_symmetric(&System::<3>::random([33, 19, 12], 0.95, 7));
    cycle_is_symmetric(&System::<2>::random([60, 47], 0.9, 3));
}

/// A drop in a box of `n` cells along each axis.
fn drop<const D: usize>(n: usize) -> System<D> {
    let inside = move |at: [usize; D]| {
        let square: f64 = at.iter().map(|c| (*c as f64 + 0.5 - n as f64 / 2.0).powi(2)).sum();
        square < (0.3 * n as f64).powi(2)
    };
    let air = move |at: [usize; D]| {
        let count = |a: usize, up: bool| {
            let mut other = at;
            other[a] = if up { at[a] + 1 } else { at[a] - 1 };
            usize::from(!inside(other))
        };
        (0..D).map(|a| count(a, true) + count(a, false)).sum::<usize>() as f64 * 3.0
    };
    System::new([n; D], inside, || 1.0, air)
}

fn iterations<const D: usize>(n: usize) -> usize {
    let system = drop::<D>(n);
    let mut x = CellField::new(system.grid, 0.0);
    let solver = PressureSolver::new(&system.input());
    solver.solve(&system.random_field(1), &mut x, limits(1e-8, 100)).unwrap().iterations
}

#[test]
fn iterations_do_not_grow_with_the_grid() {
    let (coarse, fine) = (iterations::<2>(64), iterations::<2>(256));
    assert!(fine <= 16 && fine <= coarse + 4, "{coarse} {fine}");
    let (coarse, fine) = (iterations::<3>(32), iterations::<3>(64));
    assert!(fine <= 14 && fine <= coarse + 3, "{coarse} {fine}");
}

#[test]
fn result_does_not_depend_on_the_number_of_threads() {
    let system = drop::<3>(80);
    let rhs = system.random_field(1);
    let solve = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut x = CellField::new(system.grid, 0.0);
            PressureSolver::new(&system.input()).solve(&rhs, &mut x, limits(1e-9, 50)).unwrap();
            x.data
        })
    };
    let (one, two) = (solve(1), solve(2));
    assert!(one.iter().zip(&two).all(|(a, b)| a.to_bits() == b.to_bits()));
}

#[test]
fn used_memory_leaves_no_trace() {
    let (large, small) = (drop::<3>(40), System::<3>::random([33, 19, 12], 0.95, 7));
    for (first, second) in [(&large, &small), (&small, &large)] {
        let rhs = consistent(second, &second.random_field(1));
        let solve = |solver: &PressureSolver<3>| {
            let mut x = CellField::new(second.grid, 0.0);
            solver.solve(&rhs, &mut x, limits(1e-8, 400)).map(|_| x.data)
        };
        let used = PressureSolver::new(&first.input());
        let mut x = CellField::new(first.grid, 0.0);
        used.solve(&first.random_field(2), &mut x, limits(1e-3, 50)).ok();
        let fresh = solve(&PressureSolver::new(&second.input()));
        assert!(fresh.is_ok());
        assert_eq!(fresh, solve(&PressureSolver::reusing_memory(Some(used), &second.input())));
    }
}

#[test]
fn failures_are_errors_and_leave_the_field_alone() {
    let system = drop::<3>(24);
    let solver = PressureSolver::new(&system.input());
    let mut rhs = system.random_field(1);
    let mut x = CellField::new(system.grid, 0.25);
    let failure = solver.solve(&rhs, &mut x, limits(1e-10, 2)).unwrap_err();
    assert!(matches!(failure, SolveError::NotConverged { iterations: 2, .. }));
    let cell = system.cells()[40];
    for bad in [f64::NAN, f64::INFINITY] {
        rhs.data[cell] = bad;
        let failure = solver.solve(&rhs, &mut x, limits(1e-10, 50)).unwrap_err();
        assert!(matches!(failure, SolveError::NotFinite { .. }));
    }
    assert!(x.data.iter().all(|v| *v == 0.25));
}

#[test]
fn zero_right_hand_side_and_no_unknowns() {
    let system = drop::<2>(24);
    let solver = PressureSolver::new(&system.input());
    let mut x = CellField::new(system.grid, 1.0);
    let report = solver.solve(&CellField::new(system.grid, 0.0), &mut x, limits(1e-10, 50)).unwrap();
    assert_eq!((report.iterations, x.data[system.cells()[0]]), (0, 0.0));
    let empty = System::<2>::new([12, 12], |_| false, || 1.0, |_| 0.0);
    let mut x = CellField::new(empty.grid, 1.0);
    let report =
        PressureSolver::new(&empty.input()).solve(&CellField::new(empty.grid, 1.0), &mut x, limits(1e-10, 5));
    assert_eq!(report.unwrap().iterations, 0);
}

#[test]
fn jacobi_and_multigrid_agree() {
    let system = drop::<2>(48);
    let solver = PressureSolver::new(&system.input());
    let b = solver.gather(&system.random_field(1).data);
    let (mut x, mut y) = (vec![0.0; b.len()], vec![0.0; b.len()]);
    let jacobi = Jacobi::new(&solver.diagonal());
    conjugate_gradient(&solver, &jacobi, &b, &mut x, limits(1e-12, 1000)).unwrap();
    conjugate_gradient(&solver, solver.preconditioner(), &b, &mut y, limits(1e-12, 100)).unwrap();
    let largest = x.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    assert!(x.iter().zip(&y).all(|(x, y)| (x - y).abs() < 1e-9 * largest));
}
