//! Resolution limits of the grid, and the extent of the narrow band of φ.

/// Smallest resolved drop radius, in cells. Below it volume errors do not reject a step, contact-line forces do not accelerate the
/// drop, and angular momentum is not restored (a drop of seven cells merged from two was flung apart at 1000 m/s). Contact lines of a
/// smaller radius exert no moment on deformable solids.
pub const MIN_RESOLVED_RADIUS_CELLS: f64 = 2.0;
/// Largest |φ| stored, in cells: the half width of the narrow band.
pub const BAND_WIDTH_CELLS: f64 = 5.0;
/// Layers of the band. They reach 5.7 cells in 2D, more than [`BAND_WIDTH_CELLS`], where the interface is
/// normal to a diagonal of the grid; in 3D, normal to (1, 1, 1), only 4.6.
pub const BAND_LAYERS: usize = 8;
/// Error of |∇φ| at the interface above which φ is redistanced: the accuracy of the gradient.
pub const GRADIENT_NORM_TOLERANCE: f64 = 0.1;
