//! Block matrices on the mesh's vertices, and their factorisation.

mod assembly;
mod blocks;
mod cliques;
mod coarse;
mod dissection;
mod factor;
mod fronts;
mod inverse;
mod iterated;
mod small;
mod subtrees;

pub use assembly::{Assembly, AssemblyInverse, AssemblyStructure};
pub use blocks::BlockMatrix;
pub(crate) use blocks::SparsityPattern;
pub use cliques::Cliques;
pub(crate) use coarse::{CoarseFactor, CoarseLattice};
pub(crate) use factor::{CholeskyFactor, SymbolicFactor};
pub use inverse::Reach;
pub(crate) use inverse::{Inverse, LinearSolver, ITERATIVE_TOLERANCE};
pub(crate) use iterated::IterativeInverse;
pub(crate) use small::{Svd, symmetric_eigen, axis_pairs, svd};
