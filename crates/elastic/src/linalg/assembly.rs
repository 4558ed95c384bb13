//! Assembled matrix of several solids with the blocks that couple them.

use super::{BlockMatrix, Cliques, ITERATIVE_TOLERANCE, Inverse, LinearSolver, Reach, SparsityPattern};
use crate::Elastic;
use meniscus_numerics::Vector;
use std::sync::Arc;

/// Sparsity pattern of an assembled matrix and its elimination order.
#[derive(Clone, Debug)]
pub struct AssemblyStructure {
    pattern: Arc<SparsityPattern>,
    solver: LinearSolver,
}

/// Block structure of the matrix of several solids, with the matrix of each on the diagonal.
#[derive(Clone, Debug)]
pub struct Assembly {
    first_nodes: Vec<usize>,
    anchored: Vec<bool>,
    /// The structure without coupling blocks.
    uncoupled: AssemblyStructure,
}

impl Assembly {
    /// Assembly of `anchored.len()` nodes: the vertices of solids, each given with the number of its first node, and nodes of no
    /// solid. Anchored nodes are left out. `None` where there is not enough memory.
    pub fn new<const D: usize>(solids: &[(usize, &Elastic<D>)], anchored: Vec<bool>) -> Option<Self> {
        let mut rest = vec![Vector::<D>::zeros(); anchored.len()];
        for (first, elastic) in solids {
            let at = &elastic.rest_mesh().positions;
            rest[*first..first + at.len()].copy_from_slice(at);
        }
        let parts: Vec<(usize, &SparsityPattern)> =
            solids.iter().map(|(first, e)| (*first, e.pattern.as_ref())).collect();
        let pattern = SparsityPattern::block_diagonal(anchored.len(), &parts);
        let solver = LinearSolver::new(&rest, &pattern, &anchored)?;
        let uncoupled = AssemblyStructure { pattern: Arc::new(pattern), solver };
        Some(Self { first_nodes: solids.iter().map(|s| s.0).collect(), anchored, uncoupled })
    }

    /// Returns a structure with blocks between all nodes of each group. The uncoupled structure or the `last` one is reused if it
    /// has these blocks; else the new one also keeps all blocks of the last one, so that few are analysed where groups come and go.
    /// The current `positions` of the nodes determine the elimination order. `None` where there is not enough memory.
    pub fn structure<const D: usize>(
        &self,
        groups: &Cliques,
        positions: &[Vector<D>],
        last: Option<AssemblyStructure>,
    ) -> Option<AssemblyStructure> {
        let known = [Some(&self.uncoupled), last.as_ref()].into_iter().flatten();
        if let Some(fits) = known.into_iter().find(|s| s.pattern.contains(groups)) {
            return Some(fits.clone());
        }
        let pattern = Arc::new(last.as_ref().unwrap_or(&self.uncoupled).pattern.with(groups));
        let solver = LinearSolver::new(positions, &pattern, &self.anchored)?;
        Some(AssemblyStructure { pattern, solver })
    }

    /// The matrix with the solids' matrices on its diagonal and zero in all other blocks of a structure.
    pub fn matrix<const D: usize>(
        &self,
        parts: &[BlockMatrix<D>],
        structure: &AssemblyStructure,
    ) -> BlockMatrix<D> {
        let mut whole = BlockMatrix::new(structure.pattern.clone());
        let pattern = structure.pattern.as_ref();
        for (first, part) in self.first_nodes.iter().zip(parts) {
            for j in 0..part.pattern.starts.len() - 1 {
                // Both columns ascend, and that of the whole has all rows of the part.
                let mut to = pattern.starts[first + j];
                for (row, block) in part.pattern.column(j).iter().zip(part.column(j)) {
                    let row = row + *first as u32;
                    to += pattern.rows[to..].iter().take_while(|r| **r < row).count();
                    whole.blocks[to] = *block;
                }
            }
        }
        whole
    }

    /// The inverse of a matrix of this structure, as an operator. `None` where it is numerically not positive definite.
    pub fn invert<const D: usize>(
        &self,
        matrix: &BlockMatrix<D>,
        structure: &AssemblyStructure,
    ) -> Option<AssemblyInverse<D>> {
        structure.solver.invert(matrix, &self.anchored, ITERATIVE_TOLERANCE).map(AssemblyInverse)
    }
}

/// The inverse of a matrix, as an operator.
#[derive(Clone, Debug)]
pub struct AssemblyInverse<const D: usize>(Inverse<D>);

impl<const D: usize> AssemblyInverse<D> {
    /// `b ← A⁻¹ b`; entries of anchored vertices become 0.
    pub fn solve(&self, b: &mut [Vector<D>]) {
        if b.iter().all(|v| *v == Vector::<D>::zeros()) {
            return;
        }
        let mut flat: Vec<f64> = b.iter().flat_map(|v| v.iter().copied()).collect();
        self.0.solve(None, &mut flat, 1);
        b.iter_mut().zip(flat.chunks_exact(D)).for_each(|(b, x)| b.copy_from_slice(x));
    }

    /// The part of the factors that the solution at some vertices needs if right-hand sides are zero at all others.
    pub fn reach(&self, vertices: impl Iterator<Item = u32>) -> Reach {
        self.0.reach(vertices)
    }

    /// `b ← A⁻¹ b` at the vertices of a reach, for `count` consecutive right-hand sides that are zero at all others.
    pub fn solve_within(&self, reach: &Reach, b: &mut [f64], count: usize) {
        self.0.solve(Some(reach), b, count);
    }
}
