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

pub use assembly::{Assembly, Solution, Structure};
pub use blocks::BlockMatrix;
pub(crate) use blocks::Pattern;
pub use cliques::Cliques;
pub(crate) use coarse::{Coarse, Lattice};
pub(crate) use factor::{Factor, Symbolic};
pub use inverse::Reach;
pub(crate) use inverse::{Inverse, Solver, TOLERANCE};
pub(crate) use iterated::Iterated;
pub(crate) use small::{Svd, eigen, pairs, svd};
