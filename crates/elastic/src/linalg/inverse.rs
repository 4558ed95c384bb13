//! Choice of the linear solver: Cholesky factors, or conjugate gradients where factors would be too large.

use super::subtrees::Subtrees;
use super::{BlockMatrix, CholeskyFactor, CoarseLattice, IterativeInverse, SparsityPattern, SymbolicFactor};
use meniscus_numerics::Vector;
use std::sync::Arc;

/// Relative tolerance of iterative solves.
pub const ITERATIVE_TOLERANCE: f64 = 1e-9;
/// Largest number of entries of a factor: 2 GB.
const MAX_FACTOR_ENTRIES: usize = 250_000_000;

/// Linear solver, shared by all matrices of one pattern.
#[derive(Clone, Debug)]
pub enum LinearSolver {
    /// Cholesky factors.
    Direct(Arc<SymbolicFactor>),
    /// Conjugate gradients, and the number of entries that an iteration reads.
    Iterative(Arc<CoarseLattice>, usize),
}

/// The inverse of a matrix, as an operator.
#[derive(Clone, Debug)]
pub enum Inverse<const D: usize> {
    /// Cholesky factors.
    Factor(CholeskyFactor),
    /// Conjugate gradients.
    Iterative(IterativeInverse<D>),
}

impl LinearSolver {
    /// Solver for matrices of this pattern without `anchored` vertices. `None` where there is not enough memory.
    pub fn new<const D: usize>(
        positions: &[Vector<D>],
        pattern: &SparsityPattern,
        anchored: &[bool],
    ) -> Option<Self> {
        let symbolic = SymbolicFactor::new(positions, pattern, anchored)?;
        if symbolic.entries() <= MAX_FACTOR_ENTRIES {
            return Some(Self::Direct(Arc::new(symbolic)));
        }
        let lattice = CoarseLattice::new(positions, pattern, anchored)?;
        Some(Self::Iterative(Arc::new(lattice), 2 * D * D * pattern.rows.len()))
    }

    /// Number of entries of the factor, or of those that an iteration reads.
    pub fn entries(&self) -> usize {
        match self {
            Self::Direct(symbolic) => symbolic.entries(),
            Self::Iterative(_, entries) => *entries,
        }
    }

    /// The inverse of a matrix; iterative solves end at the relative `tolerance`. `None` where the matrix is found not to be
    /// positive definite.
    pub fn invert<const D: usize>(
        &self,
        matrix: &BlockMatrix<D>,
        anchored: &[bool],
        tolerance: f64,
    ) -> Option<Inverse<D>> {
        match self {
            Self::Direct(symbolic) => {
                CholeskyFactor::new(symbolic.clone(), matrix, anchored).map(Inverse::Factor)
            }
            Self::Iterative(lattice, _) => {
                IterativeInverse::new(matrix, anchored, lattice, tolerance).map(Inverse::Iterative)
            }
        }
    }
}

/// Part of the factors that the solution at some vertices needs if right-hand sides are zero at all others
/// ([`crate::AssemblyInverse::reach`]).
#[derive(Clone, Debug)]
pub struct Reach(Option<Subtrees>);

impl<const D: usize> Inverse<D> {
    /// The part of the factors for right-hand sides and solutions at some vertices.
    pub fn reach(&self, vertices: impl Iterator<Item = u32>) -> Reach {
        match self {
            Self::Factor(factor) => Reach(factor.reach::<D>(vertices)),
            Self::Iterative(_) => Reach(None),
        }
    }

    /// `b ← A⁻¹ b` for `count` consecutive right-hand sides of the components of all vertices. Entries of anchored vertices become
    /// zero. With a `reach` the solution is valid at its vertices, if right-hand sides are zero at all others.
    pub fn solve(&self, reach: Option<&Reach>, b: &mut [f64], count: usize) {
        match self {
            Self::Factor(factor) => factor.solve::<D>(reach.and_then(|r| r.0.as_ref()), b, count),
            Self::Iterative(iterated) => iterated.solve(b),
        }
    }
}
