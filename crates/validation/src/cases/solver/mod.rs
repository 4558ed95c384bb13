//! Solvers and geometry: pressure system, iteration counts, geodesic distances.

pub mod pressure_iterations;
pub mod pressure_iterations_soft;
pub mod pressure_matrix;
pub mod surface_distance;
