//! Fits by least squares: linear systems, circles and spheres, ellipses and spheroids.

mod dense;
mod ellipsoid;
mod sphere;

pub use dense::{cholesky, least_squares, solve};
pub use ellipsoid::Ellipsoid;
pub use sphere::Sphere;
