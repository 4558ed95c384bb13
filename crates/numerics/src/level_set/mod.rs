//! Signed distance to an interface: keeping it one, its curvature.

mod curvature;
mod redistance;

pub use curvature::curvature;
pub use redistance::{interface_gradient_norm, redistance};
