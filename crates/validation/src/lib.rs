//! The validation suite: each case runs the simulator and compares it with theory or experiments.
//!
//! A case is a [`Case`] in a file of its own under `cases`, listed in the `mod.rs` of its folder.

pub mod bench;
mod case;
pub mod cases;
pub mod elastica;
pub mod measure;
pub mod plate;
pub mod report;
pub mod setup;
pub mod soak;
pub mod soft;
pub mod solids_only;

pub use crate::case::{Bars, Case, Check, Group, Mode, Outcome};

/// All cases, group by group.
pub fn cases() -> &'static [Case] {
    cases::all()
}

/// The groups of cases, in the order in which they run.
pub fn groups() -> &'static [Group] {
    cases::groups()
}
