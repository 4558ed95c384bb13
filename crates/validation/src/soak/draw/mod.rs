//! Random scenes.

pub mod context;
pub mod drop_test;
pub mod random;
pub mod scene;
pub mod shapes;
pub mod solids;
