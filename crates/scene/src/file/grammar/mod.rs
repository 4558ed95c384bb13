//! The grammar of a scene file, exactly as written: `format = 1`.

mod expect;
mod quantity;
mod repairs;
mod scene_file;
mod shape;
mod solid;

pub use expect::*;
pub(crate) use quantity::short;
pub use quantity::*;
pub use repairs::RepairsFile;
pub use scene_file::*;
pub use shape::*;
pub use solid::*;
