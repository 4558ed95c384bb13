//! The cases, one file per family.

mod capillary_wave;
mod dam_break;
mod hydrostatic;
mod momentum;
mod moving_drop;
mod pressure_matrix;
mod rayleigh;
mod rayleigh_plateau;
mod sessile;
mod static_drop;
mod transport;
mod volume;

use crate::Case;

/// All cases, in the order of the table.
pub fn all() -> &'static [Case] {
    &ALL
}

const ALL: [Case; 19] = [
    static_drop::PLANE,
    static_drop::SPACE,
    rayleigh::PLANE,
    rayleigh::SPACE,
    rayleigh::STEPS,
    rayleigh::LAMB,
    capillary_wave::CASE,
    moving_drop::CASE,
    rayleigh_plateau::CASE,
    hydrostatic::CASE,
    transport::ZALESAK,
    transport::VORTEX,
    dam_break::CASE,
    sessile::PLANE,
    sessile::SPACE,
    sessile::CURVED,
    volume::CASE,
    momentum::CASE,
    pressure_matrix::CASE,
];
