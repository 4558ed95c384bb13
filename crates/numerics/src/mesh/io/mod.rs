//! Files of surface meshes.

pub mod import;
pub mod ply;
