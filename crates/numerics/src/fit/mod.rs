//! Least-squares fits of linear systems, circles, spheres, ellipses, spheroids and rigid motions.

mod dense;
mod ellipsoid;
mod rigid;
mod sphere;

pub use dense::{least_squares, min_relative_pivot, solve};
pub use ellipsoid::Ellipsoid;
pub use rigid::RigidTransform;
pub use sphere::Sphere;
