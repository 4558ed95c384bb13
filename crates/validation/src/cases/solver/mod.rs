//! Solvers and geometry: the pressure system, iterations, distances along surfaces.

pub mod iterations;
pub mod iterations_soft;
pub mod pressure_matrix;
pub mod surface_distance;
