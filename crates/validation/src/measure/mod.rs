//! Measuring: points of the surface, modes of drops, oscillations, small dense systems.

mod cap;
mod dense;
mod outcome;
mod signal;
mod surface;

pub use cap::Cap;
pub use dense::{cholesky, least_squares, solve};
pub use outcome::{at_least, at_most, settle};
pub use signal::{Oscillation, convergence_order, fit_growth, fit_oscillation};
pub use surface::{Roundness, SurfacePoint, fit_mode, mode_shape, surface_points, volume_and_centroid};
