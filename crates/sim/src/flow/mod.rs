//! The velocity of the liquid: advection, pressure, viscosity, open sides.

pub mod advection;
pub mod outflow;
pub mod prescribed;
pub mod pressure;
pub mod viscosity;
