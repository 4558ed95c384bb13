//! File input and output of surface meshes.

pub mod import;
pub mod ply;
