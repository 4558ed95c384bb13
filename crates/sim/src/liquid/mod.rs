//! The liquid: its surface, its motion, its pressure.

pub mod surface;
