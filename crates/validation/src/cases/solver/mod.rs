//! Solvers and geometry: pressure system, iteration counts, geodesic distances.

pub mod pressure_iterations;
pub mod pressure_iterations_soft;
pub mod pressure_matrix;
pub mod surface_distance;

use crate::{Case, Group};

/// The group.
pub const GROUP: Group = Group { title: "Solvers and geometry", cases: CASES };

/// Its cases, in the order in which they run.
const CASES: &[Case] = &[
    surface_distance::DISTANCE,
    surface_distance::LENGTH,
    pressure_matrix::CASE,
    pressure_iterations::CASE,
    pressure_iterations_soft::CASE,
];
