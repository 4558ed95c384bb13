//! Solvers and geometry: the pressure system, iterations, distances along surfaces.

pub mod pressure_iterations;
pub mod pressure_iterations_soft;
pub mod pressure_matrix;
pub mod surface_distance;
