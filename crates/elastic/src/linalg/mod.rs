//! Block matrices on the vertices of meshes, and their direct and iterative solvers.

mod assembly;
mod block_matrix;
mod cliques;
mod coarse;
mod conjugate_gradient;
mod dissection;
mod factor;
mod inverse;
mod jacobi_rotations;
mod multifrontal;
mod subtrees;

pub use assembly::{Assembly, AssemblyInverse, AssemblyStructure};
pub use block_matrix::BlockMatrix;
pub(crate) use block_matrix::{PlacedBlock, SparsityPattern};
pub use cliques::Cliques;
pub(crate) use coarse::{CoarseFactor, CoarseLattice};
pub(crate) use conjugate_gradient::IterativeInverse;
pub(crate) use factor::{CholeskyFactor, SymbolicFactor};
pub use inverse::Reach;
pub(crate) use inverse::{ITERATIVE_TOLERANCE, Inverse, LinearSolver};
pub(crate) use jacobi_rotations::{Svd, axis_pairs, svd, symmetric_eigen};
