//! Measurements: points of the surface, modes of drops, oscillations, forces.

mod checks;
mod reaction;
mod signal;
mod surface;

pub use checks::{at_least, at_most, bar, bars, checks_or_failure};
pub use reaction::{SolidMotion, TimeMean, Wrench, external_load, liquid_force, soft_motion};
pub use signal::{Oscillation, bisect, convergence_order, fit_growth, fit_oscillation};
pub use surface::{
    Roundness, SurfacePoint, fit_mode, line_tracker, mode_shape, surface_points, volume_and_centroid,
    volume_and_centroid_outside,
};
