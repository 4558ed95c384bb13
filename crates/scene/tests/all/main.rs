//! The tests of this crate's public face, in one program: every program of its own compiles the whole simulation anew.

mod any_simulation;
mod free_solids;
mod golden;
mod patterns;
mod resume;
mod scene_errors;
mod scene_round_trip;
mod soft;
mod soft_runs;
mod state_hash;
mod walls;
