//! Grids, meshes and linear algebra for Meniscus, without any physics.
//!
//! Everything is generic in the dimension `D` (2 or 3). Lengths are in metres. Arrays are dense, with the first axis varying fastest.

pub mod fit;
pub mod grid;
pub mod lanes;
pub mod level_set;
pub mod linalg;
pub mod mesh;
pub mod par;
pub mod shape;

/// A point or vector of `D` components.
pub type Vector<const D: usize> = nalgebra::SVector<f64, D>;
/// An axis-aligned box: its lower and upper corner, m.
pub type Aabb<const D: usize> = [Vector<D>; 2];
/// Coordinate planes of rotation: first axis, second axis, component of the moment vector (2D: the last one).
pub fn rotation_planes<const D: usize>() -> &'static [(usize, usize, usize)] {
    const ROTATION_PLANES: [(usize, usize, usize); 3] = [(0, 1, 2), (1, 2, 0), (2, 0, 1)];
    if D == 2 { &ROTATION_PLANES[..1] } else { &ROTATION_PLANES }
}

/// A `D × D` matrix.
pub type Matrix<const D: usize> = nalgebra::SMatrix<f64, D, D>;
