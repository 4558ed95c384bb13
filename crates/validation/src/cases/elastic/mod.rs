//! Deformable solids without liquid: beams, contact, energy.

pub mod beam;
pub mod extreme_deformation;
pub mod hertz;
pub mod soft_energy;
pub mod soft_slope;
pub mod soft_stack;
pub mod turek_hron;
pub mod unstructured;
