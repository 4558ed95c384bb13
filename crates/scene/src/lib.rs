//! Meniscus scene.

pub mod checkpoint;
pub mod output;
pub mod run;
