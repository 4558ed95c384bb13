//! Section 4.1: the liquid on the staggered grid.

pub mod cells;
pub mod continuation;
pub mod curvature;
pub mod fractions;
pub mod interfaces;
pub mod surface_shape;
pub mod surface_tension;

#[cfg(test)]
mod tests;
