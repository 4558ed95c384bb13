//! Velocity of the liquid: advection, pressure, viscosity, and open sides.

pub mod advection;
pub mod outflow;
pub mod paths;
pub mod prescribed;
pub mod pressure;
pub mod viscosity;
