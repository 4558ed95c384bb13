//! What the grid resolves of the liquid, and how far around its surface φ is known.

/// Radius, in cells, from which on a drop's volume tells whether a step was too long, its line what pulls at it, and its faces
/// how it turns: with the angular momentum of two that met, one of seven cells' volume was flung apart at 1000 m/s. Contact lines
/// of a smaller radius turn no solid that deforms.
pub const MIN_RESOLVED_RADIUS_CELLS: f64 = 2.0;
/// Largest distance that φ tells, in cells.
pub const BAND_WIDTH_CELLS: f64 = 5.0;
/// Layers of the band: enough for [`BAND_WIDTH_CELLS`] where the surface lies slantwise to the axes.
pub const BAND_LAYERS: usize = 8;
/// Error of |∇φ| at the interface, from which on φ is made a distance again: slopes of φ are told no better than that.
pub const GRADIENT_NORM_TOLERANCE: f64 = 0.1;
