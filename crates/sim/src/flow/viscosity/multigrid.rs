//! Preconditioners of the viscous step where it is stiff: Chebyshev polynomials and multigrid.
//!
//! Within liquid the eigenvalues of the operator divided by its diagonal lie between `1/(1 + 8 ν h/Δ²)` and 4. Up to
//! [`COARSEST_STIFFNESS`](super::coarse::COARSEST_STIFFNESS) a Chebyshev polynomial for this range, whose degree keeps the iterations of
//! conjugate gradients at about ten, costs no more than the diagonal alone. Beyond, a W-cycle over systems of the same form on grids of
//! twice the spacing ([`super::coarse`]) costs less. Polynomials smooth before and after the correction, so that the cycle is a symmetric
//! function of the residual. The correction of a face is linear in the values of the coarse faces around it, and the residual of a coarse
//! face is its transpose. Coarse faces without a value drop out of the mean, but for those on closed sides, which are zero.
//!
//! The iterations hardly depend on `ν h/Δ²` and on the size of the liquid (experiment E42).
//!
//! Limit: liquid that nothing holds turns freely on the finest grid, but not on coarse ones, where its boundary is stepped. Where `ν h/Δ²`
//! exceeds the square of its radius in cells, these motions take iterations of their own.

use super::cells::tensor_product;
use super::coarse::ViscousSystem;
use super::operator::CELLS_PER_TASK;
use meniscus_numerics::grid::Segment;
use meniscus_numerics::linalg::{Chebyshev, ChebyshevWork, Jacobi, Preconditioner, dot};
use meniscus_numerics::par;
use std::sync::{Mutex, PoisonError};

/// Largest eigenvalue of the operator divided by its diagonal: a term of `Φ` has at most four faces, all of the same coefficient.
const LARGEST_EIGENVALUE: f64 = 4.0;
/// Lowest eigenvalue within liquid of waves that the next grid does not hold: those of two cells along one axis and constant along the
/// others, `4/(4 + 2 (D − 1))`, in 3D.
const LOWEST_SMOOTHED_EIGENVALUE: f64 = 0.5;
/// Degree of the smoother. Degree 3 takes as long, with a seventh more iterations.
const SMOOTHING_DEGREE: usize = 4;
/// Degree where one grid is enough, over the square root of `1 + 8 ν h/Δ²`: about ten iterations (experiment E42).
const RELATIVE_DEGREE: f64 = 1.4;
/// The same on the coarsest of several grids, for a tenth of the error: degree `d` leaves `1/cosh(2 d/√κ)` with `κ = 4 (1 + 8 ν h/Δ²)`.
const COARSEST_RELATIVE_DEGREE: f64 = 3.0;
/// Coarse faces at the rim of the liquid whose diagonal is below this share of that within liquid take no part in the correction. It would
/// divide a residual by almost zero, and change finer faces whose own diagonal is not small. Values from 0.02 to 0.1 give the same number
/// of iterations; zero gives several times as many (experiment E42).
const MIN_COVERAGE: f64 = 0.05;

/// Weights, in the correction of a face, of the two coarse faces around it along its axis, for even and odd faces.
const NORMAL: [&[f32]; 2] = [&[0.0, 1.0], &[0.5, 0.5]];
/// The same across the axis, for even and odd cells.
const ACROSS: [&[f32]; 2] = [&[0.25, 0.75], &[0.75, 0.25]];
/// The transposes: weights of the four faces from one below the coarse face on.
const NORMAL_TRANSPOSE: &[f32] = &[0.5, 1.0, 0.5, 0.0];
const ACROSS_TRANSPOSE: &[f32] = &[0.25, 0.75, 0.75, 0.25];

/// The smoother of all grids but the coarsest.
const SMOOTHER: Chebyshev =
    Chebyshev { degree: SMOOTHING_DEGREE, lowest: LOWEST_SMOOTHED_EIGENVALUE, largest: LARGEST_EIGENVALUE };

/// A polynomial for all eigenvalues of a system; `relative_degree` is that over the square root of `1 + 8 ν h/Δ²`.
fn polynomial(stiffness: f64, relative_degree: f64) -> Chebyshev {
    let ratio = 1.0 + 2.0 * LARGEST_EIGENVALUE * stiffness;
    let degree = (relative_degree * ratio.sqrt()) as usize;
    Chebyshev { degree, lowest: 1.0 / ratio, largest: LARGEST_EIGENVALUE }
}

/// Whether the diagonal alone is enough: the polynomial would be of degree one.
pub fn is_mild(stiffness: f64) -> bool {
    polynomial(stiffness, RELATIVE_DEGREE).degree == 1
}

/// The W-cycle over the systems of all grids.
pub struct Multigrid<'a, const D: usize> {
    levels: Vec<Level<'a, D>>,
}

/// The vector from which a cycle starts.
#[derive(Clone, Copy)]
enum Iterate {
    /// From zero, whatever the vector holds.
    Zero,
    /// From the vector.
    Given,
}

/// A system of the cycle with its smoother and memory.
struct Level<'a, const D: usize> {
    system: &'a ViscousSystem<D>,
    smoother: Chebyshev,
    jacobi: Jacobi<f32>,
    /// Whether the unknowns take part in the correction of the finer level.
    corrects: Vec<bool>,
    /// The inverse of the sum of the weights of the coarse values that an unknown reads; 0: none. Empty on the coarsest level.
    scales: Vec<f32>,
    /// Right-hand side and iterate.
    vectors: Mutex<[Vec<f32>; 2]>,
    work: Mutex<ChebyshevWork<f32>>,
}

impl<'a, const D: usize> Multigrid<'a, D> {
    /// The cycle over these systems, from the finest to the coarsest.
    pub fn new(systems: &'a [ViscousSystem<D>]) -> Self {
        let smoother = |depth: usize, stiffness: f64| match systems.len() {
            1 => polynomial(stiffness, RELATIVE_DEGREE),
            levels if depth + 1 == levels => polynomial(stiffness, COARSEST_RELATIVE_DEGREE),
            _ => SMOOTHER,
        };
        let levels = systems.iter().enumerate().map(|(k, s)| Level::new(s, smoother(k, s.stiffness)));
        let mut levels: Vec<_> = levels.collect();
        for fine in 1..levels.len() {
            levels[fine - 1].scales = levels[fine - 1].inverse_weights(&levels[fine]);
        }
        Self { levels }
    }

    /// Improves an iterate, or zero, by one cycle.
    fn cycle(&self, depth: usize, from: Iterate, b: &[f32], x: &mut [f32]) {
        let Level { system: ViscousSystem { operator, .. }, smoother, jacobi, work, .. } =
            &self.levels[depth];
        let work = &mut *work.lock().unwrap_or_else(PoisonError::into_inner);
        match from {
            Iterate::Zero => smoother.from_zero(operator, jacobi, b, x, work),
            Iterate::Given => smoother.improve(operator, jacobi, b, x, work),
        }
        let Some(coarse) = self.levels.get(depth + 1) else { return };
        let residual = Chebyshev::residual(operator, work);
        let [coarse_b, coarse_x] = &mut *coarse.vectors.lock().unwrap_or_else(PoisonError::into_inner);
        self.levels[depth].restrict(coarse, residual, coarse_b);
        self.cycle(depth + 1, Iterate::Zero, coarse_b, coarse_x);
        if depth + 2 < self.levels.len() {
            self.cycle(depth + 1, Iterate::Given, coarse_b, coarse_x);
        }
        self.levels[depth].correct(coarse, coarse_x, x);
        smoother.improve(operator, jacobi, b, x, work);
    }
}

impl<const D: usize> Preconditioner<f32> for Multigrid<'_, D> {
    fn apply(&self, r: &[f32], z: &mut [f32]) -> f64 {
        self.cycle(0, Iterate::Zero, r, z);
        dot(r, z)
    }
}

impl<'a, const D: usize> Level<'a, D> {
    fn new(system: &'a ViscousSystem<D>, smoother: Chebyshev) -> Self {
        let diagonal = system.operator.diagonal();
        let full = 1.0 + system.stiffness * (4.0 + 2.0 * (D as f64 - 1.0));
        let corrects = diagonal.iter().map(|d| *d > MIN_COVERAGE * full).collect();
        let vector = || vec![0.0; diagonal.len()];
        Self {
            system,
            smoother,
            jacobi: system.operator.jacobi(),
            corrects,
            scales: Vec::new(),
            vectors: Mutex::new([vector(), vector()]),
            work: Mutex::new([vector(), vector(), vector()]),
        }
    }

    /// The inverse sums of the weights of the coarse values that each unknown reads.
    fn inverse_weights(&self, coarse: &Self) -> Vec<f32> {
        let (cells, weights) = (&self.system.cells, correction_weights::<D>());
        let scale = |i: usize| -> [f32; D] {
            let (at, mut sums) = (cells.coordinates(i), [0.0; D]);
            let (first, parity) = coarse_corner(at);
            for (a, sum) in sums.iter_mut().enumerate() {
                // Values on closed sides are zero.
                let zero = |k: &usize| {
                    let at = first[a] + *k as isize;
                    at >= 0 && coarse.system.cells.is_on_closed_side(a, at as usize)
                };
                *sum = (0..2).filter(zero).map(|k| NORMAL[at[a] % 2][k]).sum();
            }
            coarse.system.cells.for_each_slot(first, 2, |k, slot| {
                for (a, sum) in sums.iter_mut().enumerate() {
                    let corrects = coarse.component(&coarse.corrects, a)[slot];
                    *sum += if corrects { weights[parity][a][k] } else { 0.0 };
                }
            });
            let is_unknown = self.system.operator.cell(i).is_unknown;
            std::array::from_fn(|a| if is_unknown[a] && sums[a] > 0.0 { 1.0 / sums[a] } else { 0.0 })
        };
        let mut scales = vec![0.0; cells.count() * D];
        map_cells(&mut scales, cells.count(), |i, _| if i > 0 { scale(i) } else { [0.0; D] });
        scales
    }

    /// The right-hand side of the coarse system for a residual, which is changed.
    fn restrict(&self, coarse: &Self, residual: &mut [f32], b: &mut [f32]) {
        par::map_chunks_mut([&mut *residual], CELLS_PER_TASK, |range, [residual]| {
            residual.iter_mut().zip(&self.scales[range]).for_each(|(r, s)| *r *= s);
        });
        let fine: [&[f32]; D] = std::array::from_fn(|a| self.component(residual, a));
        let weights: [Vec<f32>; D] = std::array::from_fn(|axis| {
            let along = |a: usize| if a == axis { NORMAL_TRANSPOSE } else { ACROSS_TRANSPOSE };
            tensor_product(std::array::from_fn::<_, D, _>(along))
        });
        // A coarse cell has the volume of so many fine ones.
        let scale = 1.0 / (1 << D) as f32;
        map_cells::<D>(b, coarse.system.cells.count(), |i, _| {
            let mut sums = [0.0; D];
            if i > 0 {
                let first = coarse.system.cells.coordinates(i).map(|x| 2 * x as isize - 1);
                self.system.cells.for_each_slot(first, 4, |k, slot| {
                    (0..D).for_each(|a| sums[a] += weights[a][k] * fine[a][slot]);
                });
            }
            let corrects = |a: usize| coarse.component(&coarse.corrects, a)[i];
            std::array::from_fn(|a| if corrects(a) { scale * sums[a] } else { 0.0 })
        });
    }

    /// Adds the correction of the coarse system, of which the values that take no part are cleared.
    fn correct(&self, coarse: &Self, correction: &mut [f32], x: &mut [f32]) {
        par::map_chunks_mut([&mut *correction], CELLS_PER_TASK, |range, [correction]| {
            let corrects = correction.iter_mut().zip(&coarse.corrects[range]);
            corrects.filter(|(_, corrects)| !**corrects).for_each(|(value, _)| *value = 0.0);
        });
        let values: [&[f32]; D] = std::array::from_fn(|a| coarse.component(correction, a));
        let scales: [&[f32]; D] = std::array::from_fn(|a| self.component(&self.scales, a));
        let (cells, weights) = (&self.system.cells, correction_weights::<D>());
        map_cells::<D>(x, cells.count(), |i, x| {
            let mut sums = [0.0; D];
            let (first, parity) = coarse_corner(cells.coordinates(i));
            coarse.system.cells.for_each_slot(first, 2, |k, slot| {
                (0..D).for_each(|a| sums[a] += weights[parity][a][k] * values[a][slot]);
            });
            std::array::from_fn(|a| x[a] + scales[a][i] * sums[a])
        });
    }

    /// The part of a vector that belongs to a component.
    fn component<'v, T>(&self, vector: &'v [T], a: usize) -> &'v [T] {
        let count = self.system.cells.count();
        &vector[a * count..][..count]
    }
}

/// Replaces the entries of each cell by a function of its number and of the old ones.
fn map_cells<const D: usize>(
    vector: &mut [f32],
    count: usize,
    f: impl Fn(usize, [f32; D]) -> [f32; D] + Sync,
) {
    let task = |start| Segment { row: 0, start, end: (start + CELLS_PER_TASK).min(count) };
    let tasks: Vec<Segment> = (0..count).step_by(CELLS_PER_TASK).map(task).collect();
    par::map_component_segments(vector, count, &tasks, |_, s, mut parts: [&mut [f32]; D]| {
        for k in 0..s.end - s.start {
            let new = f(s.start + k, std::array::from_fn(|a| parts[a][k]));
            (0..D).for_each(|a| parts[a][k] = new[a]);
        }
    });
}

/// The lower coarse cell of those that a cell reads, and the number of its place among them.
fn coarse_corner<const D: usize>(at: [usize; D]) -> ([isize; D], usize) {
    let first = at.map(|x| (x / 2) as isize + (x % 2) as isize - 1);
    (first, (0..D).map(|a| (at[a] % 2) << a).sum())
}

/// For each such number and component the weights of the coarse values.
fn correction_weights<const D: usize>() -> Vec<[Vec<f32>; D]> {
    let of = |parity: usize, axis: usize| {
        let along = |a: usize| if a == axis { NORMAL[parity >> a & 1] } else { ACROSS[parity >> a & 1] };
        tensor_product(std::array::from_fn::<_, D, _>(along))
    };
    (0..1 << D).map(|parity| std::array::from_fn(|axis| of(parity, axis))).collect()
}
