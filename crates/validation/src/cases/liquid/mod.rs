//! Liquid without solids: drops, waves, jets, transport, volume and momentum.

pub mod capillary_wave;
pub mod dam_break;
pub mod hydrostatic;
pub mod momentum;
pub mod moving_drop;
pub mod open_side;
pub mod rayleigh;
pub mod rayleigh_plateau;
pub mod static_drop;
pub mod transport;
pub mod volume;

use crate::{Case, Group};

/// The group.
pub const GROUP: Group = Group { title: "Liquid without solids", cases: CASES };

/// Its cases, in the order in which they run.
const CASES: &[Case] = &[
    static_drop::CASE_2D,
    static_drop::CASE_3D,
    rayleigh::CASE_2D,
    rayleigh::CASE_3D,
    rayleigh::STEPS,
    rayleigh::LAMB,
    rayleigh::STOKES,
    capillary_wave::CASE,
    moving_drop::CASE,
    rayleigh_plateau::CASE,
    hydrostatic::CASE,
    open_side::CASE,
    transport::ZALESAK,
    transport::VORTEX,
    dam_break::CASE,
    volume::CASE,
    momentum::CASE,
];
