//! Multigrid: the preconditioner of the viscous step where it is stiff.
//!
//! A W-cycle over systems of the same form on grids of twice the spacing ([`super::coarse`]). Chebyshev polynomials smooth before and after
//! the correction, so that the cycle is a symmetric function of the residual. The correction of a face is linear in the values of the coarse
//! faces around it, and the residual of a coarse face is its transpose. Coarse faces without a value drop out of the mean, but for those on
//! closed sides, which are zero.
//!
//! The iterations hardly depend on `ν h/Δ²` and on the size of the liquid: 7 to 12 for 10 to 1000, where the diagonal takes 85 to 700
//! (experiment E42).
//!
//! Limit: a liquid that nothing holds turns freely on the finest grid, but not on coarse ones, where its boundary is stepped. Where `ν h/Δ²`
//! exceeds the square of its radius in cells, these motions take iterations of their own.

use super::cells::Taps;
use super::coarse::{COARSEST_STIFFNESS, ViscousSystem};
use super::operator::CELLS_PER_TASK;
use meniscus_numerics::linalg::{Chebyshev, ChebyshevWork, Jacobi, Preconditioner, dot};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Largest eigenvalue of the operator divided by its diagonal: a term of `Φ` has at most four faces, all of the same coefficient.
const LARGEST_EIGENVALUE: f64 = 4.0;
/// Lowest eigenvalue within liquid of waves that the next grid does not hold: those of two cells along one axis and constant along the
/// others, `4/(4 + 2 (D − 1))`, in 3D.
const LOWEST_SMOOTHED_EIGENVALUE: f64 = 0.5;
/// Degree of the smoother. Degree 3 takes as long, with a seventh more iterations.
const SMOOTHING_DEGREE: usize = 4;
/// Degree on the coarsest level, for a tenth of the error.
const COARSEST_DEGREE: usize = 8;
/// Coarse faces whose diagonal is below this share of that within liquid take no part in the correction: they resist less than the faces
/// that they would move. From 0.02 to 0.1 the iterations stay the same.
const MIN_COVERAGE: f64 = 0.05;

/// Factors of the correction from the coarse faces along the axis of a face, for even and odd faces.
const NORMAL: [&[f32]; 2] = [&[1.0], &[0.5, 0.5]];
/// The same across the axis, for even and odd cells.
const ACROSS: [&[f32]; 2] = [&[0.25, 0.75], &[0.75, 0.25]];
/// Their transposes.
const NORMAL_TRANSPOSE: &[f32] = &[0.5, 1.0, 0.5];
const ACROSS_TRANSPOSE: &[f32] = &[0.25, 0.75, 0.75, 0.25];

const SMOOTHER: Chebyshev =
    Chebyshev { degree: SMOOTHING_DEGREE, lowest: LOWEST_SMOOTHED_EIGENVALUE, largest: LARGEST_EIGENVALUE };
/// There the mass keeps the eigenvalues from zero.
const COARSEST_SMOOTHER: Chebyshev = Chebyshev {
    degree: COARSEST_DEGREE,
    lowest: 1.0 / (1.0 + 2.0 * LARGEST_EIGENVALUE * COARSEST_STIFFNESS),
    largest: LARGEST_EIGENVALUE,
};

/// The cycle.
pub struct Multigrid<'a, const D: usize> {
    levels: Vec<Level<'a, D>>,
}

/// From where a cycle starts.
#[derive(Clone, Copy)]
enum Iterate {
    /// From zero, whatever the vector holds.
    Zero,
    /// From the vector.
    Given,
}

/// A level.
struct Level<'a, const D: usize> {
    system: &'a ViscousSystem<D>,
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
        let mut levels: Vec<_> = systems.iter().map(Level::new).collect();
        for fine in 1..levels.len() {
            levels[fine - 1].scales = levels[fine - 1].inverse_weights(&levels[fine]);
        }
        Self { levels }
    }

    /// Improves an iterate, or zero, by one cycle.
    fn cycle(&self, depth: usize, from: Iterate, b: &[f32], x: &mut [f32]) {
        let Level { system: ViscousSystem { operator, .. }, jacobi, work, .. } = &self.levels[depth];
        let work = &mut *work.lock().unwrap_or_else(PoisonError::into_inner);
        let coarse = self.levels.get(depth + 1);
        let smoother = if coarse.is_some() { SMOOTHER } else { COARSEST_SMOOTHER };
        match from {
            Iterate::Zero => smoother.from_zero(operator, jacobi, b, x, work),
            Iterate::Given => smoother.improve(operator, jacobi, b, x, work),
        }
        let Some(coarse) = coarse else { return };
        let residual = Chebyshev::residual(operator, work);
        let [coarse_b, coarse_x] = &mut *coarse.vectors.lock().unwrap_or_else(PoisonError::into_inner);
        self.levels[depth].restrict(coarse, residual, coarse_b);
        self.cycle(depth + 1, Iterate::Zero, coarse_b, coarse_x);
        self.cycle(depth + 1, Iterate::Given, coarse_b, coarse_x);
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
    fn new(system: &'a ViscousSystem<D>) -> Self {
        let diagonal = system.operator.diagonal();
        let full = 1.0 + system.stiffness * (4.0 + 2.0 * (D as f64 - 1.0));
        let corrects = diagonal.iter().map(|d| *d > MIN_COVERAGE * full).collect();
        let vector = || vec![0.0; diagonal.len()];
        Self {
            system,
            jacobi: Jacobi::new(&diagonal),
            corrects,
            scales: Vec::new(),
            vectors: Mutex::new([vector(), vector()]),
            work: Mutex::new([vector(), vector(), vector()]),
        }
    }

    /// The inverse sums of the weights of the coarse values that each unknown reads.
    fn inverse_weights(&self, coarse: &Self) -> Vec<f32> {
        let ViscousSystem { cells, operator, .. } = self.system;
        let of = |i: usize, a: usize| {
            if i == 0 || !operator.cell(i).is_unknown[a] {
                return 0.0;
            }
            let taps = coarse_taps(cells.coordinates(i), a);
            let along = taps[a].weights.iter().zip(taps[a].first as usize..);
            let zero = along.filter(|(_, at)| coarse.system.cells.is_on_closed_side(a, *at));
            let mut sum: f32 = zero.map(|(weight, _)| weight).sum();
            let corrects = coarse.component(&coarse.corrects, a);
            coarse.system.cells.for_each_tap(&taps, |slot, w| sum += if corrects[slot] { w } else { 0.0 });
            if sum > 0.0 { 1.0 / sum } else { 0.0 }
        };
        let mut scales = vec![0.0; cells.count() * D];
        map_components(&mut scales, cells.count(), |i, a, scale| *scale = of(i, a));
        scales
    }

    /// The right-hand side of the coarse system for a residual, which is changed.
    fn restrict(&self, coarse: &Self, residual: &mut [f32], b: &mut [f32]) {
        residual.par_iter_mut().zip(&self.scales).with_min_len(CELLS_PER_TASK).for_each(|(r, s)| *r *= s);
        // A coarse cell has the volume of so many fine ones.
        let scale = 1.0 / (1 << D) as f32;
        map_components(b, coarse.system.cells.count(), |i, a, b| {
            *b = 0.0;
            if i > 0 && coarse.component(&coarse.corrects, a)[i] {
                let fine = self.component(residual, a);
                let taps = fine_taps(coarse.system.cells.coordinates(i), a);
                self.system.cells.for_each_tap(&taps, |slot, w| *b += scale * w * fine[slot]);
            }
        });
    }

    /// Adds the correction of the coarse system.
    fn correct(&self, coarse: &Self, correction: &[f32], x: &mut [f32]) {
        map_components(x, self.system.cells.count(), |i, a, x| {
            let scale = self.component(&self.scales, a)[i];
            if scale > 0.0 {
                let (corrects, values) =
                    (coarse.component(&coarse.corrects, a), coarse.component(correction, a));
                let taps = coarse_taps(self.system.cells.coordinates(i), a);
                let mut sum = 0.0;
                coarse.system.cells.for_each_tap(&taps, |slot, w| {
                    sum += if corrects[slot] { w * values[slot] } else { 0.0 };
                });
                *x += scale * sum;
            }
        });
    }

    /// The part of a vector that belongs to a component.
    fn component<'v, T>(&self, vector: &'v [T], a: usize) -> &'v [T] {
        let count = self.system.cells.count();
        &vector[a * count..][..count]
    }
}

/// Calls `f` in parallel with the number of a cell, a component, and its entry in the vector.
fn map_components(vector: &mut [f32], count: usize, f: impl Fn(usize, usize, &mut f32) + Sync) {
    for (a, component) in vector.chunks_mut(count).enumerate() {
        component.par_iter_mut().enumerate().with_min_len(CELLS_PER_TASK).for_each(|(i, x)| f(i, a, x));
    }
}

/// The coarse faces that correct a face, and their weights.
fn coarse_taps<const D: usize>(at: [usize; D], axis: usize) -> [Taps; D] {
    std::array::from_fn(|a| {
        let (coarse, odd) = ((at[a] / 2) as isize, at[a] % 2);
        let across = a != axis;
        Taps {
            first: if across && odd == 0 { coarse - 1 } else { coarse },
            weights: if across { ACROSS[odd] } else { NORMAL[odd] },
        }
    })
}

/// The faces that a coarse face corrects, and their weights.
fn fine_taps<const D: usize>(at: [usize; D], axis: usize) -> [Taps; D] {
    std::array::from_fn(|a| Taps {
        first: 2 * at[a] as isize - 1,
        weights: if a == axis { NORMAL_TRANSPOSE } else { ACROSS_TRANSPOSE },
    })
}
