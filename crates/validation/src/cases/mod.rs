//! The cases, one file per family.

mod capillary_wave;
mod hydrostatic;
mod momentum;
mod rayleigh;
mod static_drop;

use crate::Case;

/// All cases, in the order of the table.
pub fn all() -> &'static [Case] {
    &ALL
}

const ALL: [Case; 9] = [
    static_drop::PLANE,
    static_drop::SPACE,
    rayleigh::PLANE,
    rayleigh::SPACE,
    rayleigh::STEPS,
    rayleigh::LAMB,
    capillary_wave::CASE,
    hydrostatic::CASE,
    momentum::CASE,
];
