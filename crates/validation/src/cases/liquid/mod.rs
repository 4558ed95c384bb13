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
