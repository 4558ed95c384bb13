//! Scenes of Meniscus: the scene file, its run, and the output.

pub mod build;
pub mod builtin;
pub mod error;
pub mod estimate;
pub mod expect;
pub mod file;
pub mod job;
pub mod output;
pub mod run;
pub mod schema;
pub mod units;
