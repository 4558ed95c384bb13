//! Signed distance to an interface: redistancing and curvature.

mod curvature;
mod redistance;

pub use curvature::{curvature, curvatures};
pub use redistance::{interface_gradient_norm, redistance};
