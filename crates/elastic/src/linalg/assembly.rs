//! The matrices of several solids as one, with what couples them.

use super::{BlockMatrix, Cliques, ITERATIVE_TOLERANCE, Inverse, LinearSolver, Reach, SparsityPattern};
use crate::Elastic;
use meniscus_numerics::Vector;
use std::sync::Arc;

/// Which blocks a matrix of several solids has, and in what order these are eliminated.
#[derive(Clone, Debug)]
pub struct AssemblyStructure {
    pattern: Arc<SparsityPattern>,
    solver: LinearSolver,
}

/// The block structure of a matrix of several solids, with the matrix of each on its diagonal.
#[derive(Clone, Debug)]
pub struct Assembly {
    first_nodes: Vec<usize>,
    anchored: Vec<bool>,
    /// While nothing couples them.
    uncoupled: AssemblyStructure,
}

impl Assembly {
    /// Of `anchored.len()` nodes: the vertices of solids, each with the number of its first node, and nodes that belong to none. Held ones
    /// are left out. Nothing where memory does not suffice.
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

    /// A structure with blocks between all nodes of each group. That of solids which nothing couples and the `last` one serve as long
    /// as they have these blocks; else all of the last one's stay in the new one, so that few are analysed where groups come and go.
    /// `positions` are where nodes are, which tells in what order coupled ones are best eliminated. Nothing where memory does not
    /// suffice.
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

    /// The solids' matrices on the diagonal, and zero in all other blocks of a structure.
    pub fn matrix<const D: usize>(
        &self,
        parts: &[BlockMatrix<D>],
        structure: &AssemblyStructure,
    ) -> BlockMatrix<D> {
        let pattern = structure.pattern.clone();
        let mut whole = BlockMatrix::new(pattern);
        for (first, part) in self.first_nodes.iter().zip(parts) {
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

    /// The inverse, applied, of a matrix of this structure. Nothing where it is not positive definite, to rounding.
    pub fn invert<const D: usize>(
        &self,
        matrix: &BlockMatrix<D>,
        structure: &AssemblyStructure,
    ) -> Option<AssemblyInverse<D>> {
        structure.solver.invert(matrix, &self.anchored, ITERATIVE_TOLERANCE).map(AssemblyInverse)
    }
}

/// The inverse of a matrix, applied.
#[derive(Clone, Debug)]
pub struct AssemblyInverse<const D: usize>(Inverse<D>);

impl<const D: usize> AssemblyInverse<D> {
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
