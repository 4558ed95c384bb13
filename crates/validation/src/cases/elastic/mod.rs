//! Deformable solids without liquid: beams, contact, energy.

pub mod beam;
pub mod extreme_deformation;
pub mod hertz;
pub mod soft_energy;
pub mod soft_slope;
pub mod soft_stack;
pub mod turek_hron;
pub mod unstructured;

use crate::{Case, Group};

/// The group.
pub const GROUP: Group = Group { title: "Deformable solids without liquid", cases: CASES };

/// Its cases, in the order in which they run.
const CASES: &[Case] = &[
    beam::BEAM,
    unstructured::CASE,
    turek_hron::FLAG,
    soft_stack::CASE,
    soft_slope::CASE,
    soft_energy::CASE,
    hertz::CASE,
    extreme_deformation::CASE,
];
