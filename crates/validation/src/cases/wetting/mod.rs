//! Contact lines: angles, menisci, friction, hysteresis, patterns, sheets wrapped around drops.

pub mod domain_walls;
pub mod hysteresis;
pub mod line_friction;
pub mod meniscus;
pub mod ridge;
pub mod sessile;
pub mod sessile_gravity;
pub mod sliding;
pub mod wettability_step;
pub mod wrapping;
