use super::{conjugate_gradient, conjugate_gradient_in_single_precision, minres, minres_with_workspace};
use crate::linalg::{Jacobi, LinearOperator, Preconditioner, SolveError, SolveLimits};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// A dense symmetric matrix.
struct Dense(DMatrix<f64>);

impl LinearOperator for Dense {
    fn size(&self) -> usize {
        self.0.nrows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        y.copy_from_slice((&self.0 * DVector::from_column_slice(x)).as_slice());
    }
}

/// The exact inverse of a dense positive definite matrix.
struct Inverse(Cholesky<f64, Dyn>);

impl Inverse {
    fn of(matrix: DMatrix<f64>) -> Self {
        Self(matrix.cholesky().expect("positive definite"))
    }
}

impl Preconditioner for Inverse {
    fn apply(&self, r: &[f64], z: &mut [f64]) -> f64 {
        let r = DVector::from_column_slice(r);
        z.copy_from_slice(self.0.solve(&r).as_slice());
        r.dot(&DVector::from_column_slice(z))
    }
}

/// The operator of five points on `n × n` cells.
struct Laplacian {
    n: usize,
    /// Whether values beyond the sides are zero; else the sides let no flux through.
    dirichlet: bool,
    /// Multiple of the identity that is subtracted.
    shift: f64,
}

impl Laplacian {
    fn dense(&self) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.size(), self.size());
        let (mut unit, mut column) = (vec![0.0; self.size()], vec![0.0; self.size()]);
        for j in 0..self.size() {
            unit[j] = 1.0;
            self.apply(&unit, &mut column);
            matrix.set_column(j, &DVector::from_column_slice(&column));
            unit[j] = 0.0;
        }
        matrix
    }
}

impl LinearOperator for Laplacian {
    fn size(&self) -> usize {
        self.n * self.n
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let n = self.n;
        for (k, y) in y.iter_mut().enumerate() {
            let (i, j) = (k % n, k / n);
            let neighbours = [(i > 0, k.wrapping_sub(1)), (i + 1 < n, k + 1), (j > 0, k.wrapping_sub(n))];
            let all = neighbours.into_iter().chain([(j + 1 < n, k + n)]);
            let flux = |(inside, other): (bool, usize)| match inside {
                true => x[k] - x[other],
                false => f64::from(u8::from(self.dirichlet)) * x[k],
            };
            *y = all.map(flux).sum::<f64>() - self.shift * x[k];
        }
    }
}

fn numbers(n: usize) -> Vec<f64> {
    (0..n).map(|k| (k as f64 * 1.7).sin() + 0.3 * (k as f64 * 0.2).cos()).collect()
}

fn none(n: usize) -> Jacobi {
    Jacobi::new(&vec![1.0; n])
}

const LIMITS: SolveLimits = SolveLimits { tolerance: 1e-11, max_iterations: 2000 };

/// Norm of `b − A x` relative to `b`.
fn residual(operator: &impl LinearOperator, b: &[f64], x: &[f64]) -> f64 {
    let mut image = vec![0.0; b.len()];
    operator.apply(x, &mut image);
    let b = DVector::from_column_slice(b);
    (&b - DVector::from_vec(image)).norm() / b.norm()
}

/// Solves and compares with elimination; returns the number of iterations.
fn minres_solution_matches(matrix: &DMatrix<f64>, preconditioner: &impl Preconditioner) -> usize {
    let (operator, b) = (Dense(matrix.clone()), numbers(matrix.nrows()));
    let mut x = numbers(b.len() + 7)[7..].to_vec();
    let report = minres(&operator, preconditioner, &b, &mut x, LIMITS).unwrap();
    assert!(report.residual <= LIMITS.tolerance);
    assert!((residual(&operator, &b, &x) - report.residual).abs() < 1e-13);
    let exact = matrix.clone().lu().solve(&DVector::from_vec(b)).unwrap();
    let error = (&exact - DVector::from_vec(x)).norm() / exact.norm();
    assert!(error < 1e-8, "{error}");
    report.iterations
}

#[test]
fn definite_systems_agree_with_conjugate_gradients() {
    let operator = Laplacian { n: 20, dirichlet: true, shift: 0.0 };
    let b = numbers(400);
    let (mut x, mut y) = (vec![0.0; 400], vec![0.0; 400]);
    let diagonal: Vec<f64> = (0..400).map(|k| 1.0 + (k % 5) as f64).collect();
    for preconditioner in [none(400), Jacobi::new(&diagonal)] {
        let one = conjugate_gradient(&operator, &preconditioner, &b, &mut x, LIMITS).unwrap();
        let other = minres(&operator, &preconditioner, &b, &mut y, LIMITS).unwrap();
        let off = x.iter().zip(&y).fold(0.0f64, |m, (x, y)| m.max((x - y).abs()));
        assert!(off < 1e-8, "{off}");
        assert!(other.iterations <= one.iterations + 3, "{} {}", other.iterations, one.iterations);
        (x, y) = (vec![0.0; 400], vec![0.0; 400]);
    }
}

#[test]
fn an_indefinite_shifted_laplacian_is_solved() {
    let shifted = Laplacian { n: 16, dirichlet: true, shift: 0.7 };
    let matrix = shifted.dense();
    let values = matrix.clone().symmetric_eigen().eigenvalues;
    assert!(values.min() < -0.5 && values.max() > 7.0 && values.iter().all(|v| v.abs() > 1e-3));
    let alone = minres_solution_matches(&matrix, &none(matrix.nrows()));
    let definite = Laplacian { shift: 0.0, ..shifted }.dense();
    let with = minres_solution_matches(&matrix, &Inverse::of(definite));
    assert!(with < alone / 2, "{with} {alone}");
}

#[test]
fn a_saddle_point_system_is_solved() {
    // [H Bᵀ; B 0] with the preconditioner diag(H, B H⁻¹ Bᵀ)⁻¹ has the eigenvalues 1 and (1 ± √5)/2 alone (M. Murphy, G. Golub,
    // A. Wathen, "A note on preconditioning for indefinite linear systems", 2000).
    let (n, m) = (40, 15);
    let h = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => 3.0 + (i % 7) as f64,
        1 => -1.0,
        _ => 0.0,
    });
    let b = DMatrix::from_fn(m, n, |i, j| ((3 * i + 5 * j + i * j) as f64).sin());
    let schur = &b * h.clone().cholesky().unwrap().solve(&b.transpose());
    let (mut matrix, mut blocks) = (DMatrix::zeros(n + m, n + m), DMatrix::zeros(n + m, n + m));
    for whole in [&mut matrix, &mut blocks] {
        whole.view_mut((0, 0), (n, n)).copy_from(&h);
    }
    matrix.view_mut((n, 0), (m, n)).copy_from(&b);
    matrix.view_mut((0, n), (n, m)).copy_from(&b.transpose());
    blocks.view_mut((n, n), (m, m)).copy_from(&schur);
    let alone = minres_solution_matches(&matrix, &none(n + m));
    let with = minres_solution_matches(&matrix, &Inverse::of(blocks));
    assert!(with <= 5 && alone > 20, "{with} {alone}");
}

#[test]
fn a_singular_system_is_solved_where_it_has_a_solution() {
    let operator = Laplacian { n: 20, dirichlet: false, shift: 0.0 };
    let mut b = numbers(400);
    let diagonal: Vec<f64> = (0..400).map(|k| 1.0 + (k % 5) as f64).collect();
    let inconsistent = minres(&operator, &none(400), &b, &mut vec![0.0; 400], LIMITS).unwrap_err();
    assert!(matches!(inconsistent, SolveError::NotConverged { residual, .. } if residual > 1e-3));
    let mean = b.iter().sum::<f64>() / 400.0;
    b.iter_mut().for_each(|b| *b -= mean);
    for preconditioner in [none(400), Jacobi::new(&diagonal)] {
        let mut x = vec![0.0; 400];
        let report = minres(&operator, &preconditioner, &b, &mut x, LIMITS).unwrap();
        assert!(residual(&operator, &b, &x) <= 1.1 * LIMITS.tolerance && report.iterations < 200);
    }
}

#[test]
fn a_solved_system_takes_no_iteration() {
    let operator = Laplacian { n: 9, dirichlet: true, shift: 0.7 };
    let x = numbers(81);
    let (mut b, mut y) = (vec![0.0; 81], x.clone());
    operator.apply(&x, &mut b);
    assert_eq!(minres(&operator, &none(81), &b, &mut y, LIMITS).unwrap().iterations, 0);
    assert_eq!(x, y);
    assert_eq!(minres(&operator, &none(81), &[0.0; 81], &mut y, LIMITS).unwrap().iterations, 0);
    assert!(y.iter().all(|y| *y == 0.0));
}

#[test]
fn numbers_that_are_not_finite_are_an_error() {
    let operator = Laplacian { n: 9, dirichlet: true, shift: 0.7 };
    for bad in [f64::NAN, f64::INFINITY] {
        let mut b = numbers(81);
        let mut matrix = operator.dense();
        matrix[(40, 40)] = bad;
        let failure = minres(&Dense(matrix), &none(81), &b, &mut vec![0.0; 81], LIMITS).unwrap_err();
        assert!(matches!(failure, SolveError::NotFinite { .. }));
        b[40] = bad;
        let failure = minres(&operator, &none(81), &b, &mut vec![0.0; 81], LIMITS).unwrap_err();
        assert_eq!(failure, SolveError::NotFinite { iteration: 0 });
    }
}

#[test]
fn a_preconditioner_that_is_not_positive_is_an_error() {
    struct Negative;
    impl Preconditioner for Negative {
        fn apply(&self, r: &[f64], z: &mut [f64]) -> f64 {
            z.iter_mut().zip(r).for_each(|(z, r)| *z = -r);
            -r.iter().map(|r| r * r).sum::<f64>()
        }
    }
    let operator = Laplacian { n: 9, dirichlet: true, shift: 0.7 };
    let mut x = numbers(81);
    let failure = minres(&operator, &Negative, &numbers(81), &mut x, LIMITS).unwrap_err();
    assert!(matches!(failure, SolveError::NotConverged { iterations: 0, .. }));
}

#[test]
fn the_limit_of_iterations_leaves_the_last_iterate() {
    let operator = Laplacian { n: 16, dirichlet: true, shift: 0.7 };
    let b = numbers(256);
    let mut last = 1.0;
    for max_iterations in 0..40 {
        let (mut x, limits) = (vec![0.0; 256], SolveLimits { max_iterations, ..LIMITS });
        let failure = minres(&operator, &none(256), &b, &mut x, limits).unwrap_err();
        let SolveError::NotConverged { iterations, residual: reported, tolerance } = failure else {
            panic!("{failure}")
        };
        assert_eq!((iterations, tolerance), (max_iterations, LIMITS.tolerance));
        // The residual of the recursion is the true one, and without a preconditioner it never grows.
        assert!((residual(&operator, &b, &x) - reported).abs() < 1e-12);
        assert!(reported <= last * (1.0 + 1e-12), "{reported} {last}");
        last = reported;
    }
    assert!(last < 0.5, "{last}");
}

#[test]
fn the_result_depends_on_neither_threads_nor_the_workspace() {
    let n = 150;
    let operator = Laplacian { n, dirichlet: true, shift: 0.02 };
    let (b, limits) = (numbers(n * n), SolveLimits { tolerance: 1e-12, max_iterations: 30 });
    let diagonal: Vec<f64> = (0..n * n).map(|k| 1.0 + (k % 5) as f64).collect();
    let solve = |threads, content: f64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (mut x, mut work) = (vec![0.0; n * n], [(); 8].map(|()| vec![content; n * n]));
        let jacobi = Jacobi::new(&diagonal);
        let report =
            pool.install(|| minres_with_workspace(&operator, &jacobi, &b, &mut x, limits, &mut work));
        assert!(matches!(report, Err(SolveError::NotConverged { iterations: 30, .. })));
        x
    };
    let (one, three) = (solve(1, 0.0), solve(3, f64::NAN));
    assert!(one.iter().zip(&three).all(|(a, b)| a.to_bits() == b.to_bits()));
}

/// An operator whose images of vectors in single precision are rounded.
struct Rounded(Laplacian);

impl LinearOperator for Rounded {
    fn size(&self) -> usize {
        self.0.size()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.0.apply(x, y);
    }
}

impl LinearOperator<f32> for Rounded {
    fn size(&self) -> usize {
        self.0.size()
    }

    fn apply(&self, x: &[f32], y: &mut [f32]) {
        let x: Vec<f64> = x.iter().map(|x| f64::from(*x)).collect();
        let mut image = vec![0.0; x.len()];
        self.0.apply(&x, &mut image);
        y.iter_mut().zip(image).for_each(|(y, value)| *y = value as f32);
    }
}

/// Rounding of the correction would stop at 1e-7 without restarts from the true residual.
#[test]
fn single_precision_reaches_the_tolerance_of_double_precision() {
    let operator = Rounded(Laplacian { n: 20, dirichlet: true, shift: 0.0 });
    let b = numbers(400);
    let jacobi = Jacobi::new(&vec![4.0; 400]);
    let (mut x, mut reference) = (vec![0.0; 400], vec![0.0; 400]);
    let report = conjugate_gradient_in_single_precision(&operator, &jacobi, &b, &mut x, LIMITS).unwrap();
    let double = conjugate_gradient(&operator.0, &none(400), &b, &mut reference, LIMITS).unwrap();
    assert!(residual(&operator.0, &b, &x) <= LIMITS.tolerance, "{report:?}");
    // The condition number is 178.
    let error = x.iter().zip(&reference).map(|(x, exact)| (x - exact).abs()).fold(0.0, f64::max);
    let size = reference.iter().fold(0.0, |most, x| f64::max(most, x.abs()));
    assert!(error < 2.0 * 178.0 * LIMITS.tolerance * size, "{error:e}");
    assert!(report.iterations < 3 * double.iterations, "{report:?} {double:?}");
}
