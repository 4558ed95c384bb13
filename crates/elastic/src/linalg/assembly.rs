//! The matrices of several solids as one, with what couples them.

use super::{BlockMatrix, Cliques, Inverse, Pattern, Reach, Solver, TOLERANCE};
use crate::Elastic;
use meniscus_numerics::Vector;
use std::sync::Arc;

/// The block structure of a matrix of several solids, with the matrix of each on its diagonal. While nothing couples the solids the
/// pattern stays the same, and the order of elimination is found once.
#[derive(Clone, Debug)]
pub struct Assembly {
    firsts: Vec<usize>,
    held: Vec<bool>,
    pattern: Arc<Pattern>,
    solver: Solver,
}

impl Assembly {
    /// Of `held.len()` nodes: the vertices of solids, each with the number of its first node, and nodes that belong to none. Held ones
    /// are left out. Nothing where memory does not suffice.
    pub fn new<const D: usize>(solids: &[(usize, &Elastic<D>)], held: Vec<bool>) -> Option<Self> {
        let mut rest = vec![Vector::<D>::zeros(); held.len()];
        for (first, elastic) in solids {
            let at = &elastic.mesh().positions;
            rest[*first..first + at.len()].copy_from_slice(at);
        }
        let parts: Vec<(usize, &Pattern)> =
            solids.iter().map(|(first, e)| (*first, e.pattern.as_ref())).collect();
        let pattern = Pattern::of_parts(held.len(), &parts);
        let solver = Solver::new(&rest, &pattern, &held)?;
        Some(Self { firsts: solids.iter().map(|s| s.0).collect(), held, pattern: Arc::new(pattern), solver })
    }

    /// The solids' matrices on the diagonal, and zero blocks between all nodes of each group.
    pub fn matrix<const D: usize>(&self, parts: &[BlockMatrix<D>], groups: &Cliques) -> BlockMatrix<D> {
        let pattern =
            if self.pattern.has(groups) { self.pattern.clone() } else { Arc::new(self.pattern.with(groups)) };
        let mut whole = BlockMatrix::new(pattern);
        for (first, part) in self.firsts.iter().zip(parts) {
            for j in 0..part.pattern.starts.len() - 1 {
                for slot in part.pattern.starts[j]..part.pattern.starts[j + 1] {
                    let row = part.pattern.rows[slot] + *first as u32;
                    if let Some(to) = whole.pattern.slot(row, (first + j) as u32) {
                        whole.blocks[to] = part.blocks[slot];
                    }
                }
            }
        }
        whole
    }

    /// A matrix's inverse, applied; `positions` are where nodes are, which tells in what order coupled ones are best eliminated.
    /// Nothing where the matrix is not positive definite, to rounding.
    pub fn invert<const D: usize>(
        &self,
        matrix: &BlockMatrix<D>,
        positions: &[Vector<D>],
    ) -> Option<Solution<D>> {
        let held = &self.held;
        let inverse = if Arc::ptr_eq(&matrix.pattern, &self.pattern) {
            self.solver.invert(matrix, held, TOLERANCE)
        } else {
            Solver::new(positions, &matrix.pattern, held)?.invert(matrix, held, TOLERANCE)
        };
        inverse.map(Solution)
    }
}

/// The inverse of a matrix, applied.
#[derive(Clone, Debug)]
pub struct Solution<const D: usize>(Inverse<D>);

impl<const D: usize> Solution<D> {
    /// `b ← A⁻¹ b`; what belongs to held vertices becomes 0.
    pub fn solve(&self, b: &mut [Vector<D>]) {
        let mut flat: Vec<f64> = b.iter().flat_map(|v| v.iter().copied()).collect();
        self.0.solve(None, &mut flat, 1);
        b.iter_mut().zip(flat.chunks_exact(D)).for_each(|(b, x)| b.copy_from_slice(x));
    }

    /// The part of the factors that is needed to solve for some vertices, where right-hand sides are zero at all others.
    pub fn reach(&self, vertices: impl Iterator<Item = u32>) -> Reach {
        self.0.reach(vertices)
    }

    /// `b ← A⁻¹ b` at the vertices of a reach, for `count` right-hand sides one after another that are 0 at all others.
    pub fn solve_within(&self, reach: &Reach, b: &mut [f64], count: usize) {
        self.0.solve(Some(reach), b, count);
    }
}
