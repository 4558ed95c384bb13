//! Grids, meshes and linear algebra for Meniscus. This crate knows no physics.
//!
//! Everything is generic in the dimension `D` (2 or 3); lengths are in metres, arrays are dense and run
//! fastest along the first axis.

pub mod fit;
pub mod grid;
pub mod level_set;
pub mod linalg;
pub mod mesh;
pub mod par;
pub mod shape;

/// A point or vector of `D` components.
pub type Vector<const D: usize> = nalgebra::SVector<f64, D>;
/// The planes in which things turn: first axis, second axis, place in a vector of moments (2D: the last entry).
pub fn rotation_planes<const D: usize>() -> &'static [(usize, usize, usize)] {
    const ROTATION_PLANES: [(usize, usize, usize); 3] = [(0, 1, 2), (1, 2, 0), (2, 0, 1)];
    if D == 2 { &ROTATION_PLANES[..1] } else { &ROTATION_PLANES }
}

/// A `D × D` matrix.
pub type Matrix<const D: usize> = nalgebra::SMatrix<f64, D, D>;
