//! Block matrices on the mesh's vertices, and their factorisation.

mod blocks;
mod cliques;
mod dissection;
mod factor;
mod small;

pub use blocks::BlockMatrix;
pub(crate) use blocks::Pattern;
pub use cliques::Cliques;
pub(crate) use factor::{Factor, Symbolic};
pub(crate) use small::{eigen, pairs, svd};
