//! Pictures in three dimensions by ray tracing.

pub mod bvh;
pub mod environment;
pub mod geometry;
pub mod light;
pub mod optics;
pub mod sampling;
pub mod scene;
pub mod trace;
