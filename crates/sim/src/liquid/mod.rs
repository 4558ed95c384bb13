//! The liquid: its surface, its motion, its pressure.

pub mod cube;
pub mod curvature;
pub mod cut_faces;
pub mod filter;
pub mod friction;
pub mod ghost;
pub mod momentum;
pub mod pressure;
pub mod surface;
pub mod transport;
pub mod viscosity;
pub mod volume;
