//! Aggregation multigrid on compactly stored unknowns.

mod hierarchy;
mod layout;
mod level;
mod sweep;

pub use hierarchy::{Hierarchy, Level, coarsened};
pub use layout::{BLOCK_CELLS, LANES, Layout};
pub use level::{BlockCoefficients, BlockSite, Chunk, DIAGONAL, SpanCoefficients, build_chunks};
pub use sweep::{Operands, over_chunks_pair, sweep_span};
