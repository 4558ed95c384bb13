//! Pictures in three dimensions, by tracing rays.

pub mod bvh;
pub mod geometry;
pub mod light;
pub mod optics;
pub mod sampling;
pub mod scene;
pub mod studio;
pub mod trace;
