//! Scenes of Meniscus: what is simulated, how it is run, and what is written.

pub mod build;
pub mod builtin;
pub mod check;
mod check_text;
pub mod checkpoint;
pub mod displaced;
pub mod error;
pub mod expect;
pub mod file;
mod gaps;
mod held;
pub mod memory;
mod meshes;
pub mod output;
pub mod parameters;
pub mod run;
pub mod schema;
mod soft;
pub mod soft_report;
mod stiff;
mod thin;
pub mod thin_liquid;
pub mod units;
mod wetting;
