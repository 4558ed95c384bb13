//! Scenes, drawn at random.

pub mod drops;
pub mod random;
pub mod scene;
pub mod shapes;
pub mod solids;
pub mod world;
