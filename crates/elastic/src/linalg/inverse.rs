//! How systems with a matrix are solved.

use super::subtrees::Subtrees;
use super::{BlockMatrix, CholeskyFactor, CoarseLattice, IterativeInverse, SparsityPattern, SymbolicFactor};
use meniscus_numerics::Vector;
use std::sync::Arc;

/// Relative error of a solve by iterations, where there are no factors.
pub const ITERATIVE_TOLERANCE: f64 = 1e-9;
/// Entries of a factor beyond which there is none: 2 GB.
const MAX_FACTOR_ENTRIES: usize = 250_000_000;

/// What all inverses of matrices with one pattern share.
#[derive(Clone, Debug)]
pub enum LinearSolver {
    /// They have factors of a bearable size.
    Direct(Arc<SymbolicFactor>),
    /// They have not: iterations, and entries that each goes through.
    Iterative(Arc<CoarseLattice>, usize),
}

/// The inverse of a matrix, applied.
#[derive(Clone, Debug)]
pub enum Inverse<const D: usize> {
    /// By Cholesky factors.
    Factor(CholeskyFactor),
    /// By iterations.
    Iterative(IterativeInverse<D>),
}

impl LinearSolver {
    /// For matrices of this pattern; `anchored` vertices are left out. Nothing where memory does not suffice.
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

    /// Entries that are kept of an inverse.
    pub fn entries(&self) -> usize {
        match self {
            Self::Direct(symbolic) => symbolic.entries(),
            Self::Iterative(_, entries) => *entries,
        }
    }

    /// The inverse of a matrix; iterations go on until the error is `tolerance` times as large. Nothing where the matrix is seen
    /// not to be positive definite.
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

/// The part of the factors that the solution at some vertices needs, where right-hand sides are zero at all others
/// ([`crate::AssemblyInverse::reach`]).
#[derive(Clone, Debug)]
pub struct Reach(Option<Subtrees>);

impl<const D: usize> Inverse<D> {
    /// What right-hand sides of some vertices need for the solution there.
    pub fn reach(&self, vertices: impl Iterator<Item = u32>) -> Reach {
        match self {
            Self::Factor(factor) => Reach(factor.reach::<D>(vertices)),
            Self::Iterative(_) => Reach(None),
        }
    }

    /// `b ← A⁻¹ b` for `count` right-hand sides of all vertices' components, one after another. What belongs to held
    /// vertices becomes 0. With a `reach` that is so for its vertices, if the right-hand sides are 0 for all others.
    pub fn solve(&self, reach: Option<&Reach>, b: &mut [f64], count: usize) {
        match self {
            Self::Factor(factor) => factor.solve::<D>(reach.and_then(|r| r.0.as_ref()), b, count),
            Self::Iterative(iterated) => iterated.solve(b),
        }
    }
}
