//! The staggered (MAC) grid: cubic cells, values at cell centres and on faces.

mod band;
mod components;
mod cut;
mod extrapolate;
mod field;
mod interpolate;
mod runs;
mod tiles;

pub use band::Band;
pub use cut::{CutBy, CutCells, WetCell, points};
pub use extrapolate::KnownFaces;
pub use field::{CellField, FaceField};
pub use interpolate::{Edge, Sampler};
pub use runs::{Run, Runs};
pub use tiles::{Segment, TILE, Tiles};

use crate::Vector;

/// A box of cubic cells with its lower corner at the origin.
///
/// Cells are numbered with the first axis running fastest: `index = i + nx (j + ny k)`. The faces normal to axis
/// `a` form a lattice of their own with one more entry along `a`; face `i` along `a` is the *lower* face of cell `i`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid<const D: usize> {
    /// Number of cells along each axis.
    pub cells: [usize; D],
    /// Cell size, m.
    pub dx: f64,
}

/// The shape of a dense array over a lattice: extents and strides, the first axis running fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice<const D: usize> {
    /// Number of points along each axis.
    pub extent: [usize; D],
    /// Distance in memory between neighbours along each axis.
    pub stride: [usize; D],
}

impl<const D: usize> Lattice<D> {
    /// A lattice of the given extents.
    pub fn new(extent: [usize; D]) -> Self {
        let mut stride = [1; D];
        for a in 1..D {
            stride[a] = stride[a - 1] * extent[a - 1];
        }
        Self { extent, stride }
    }

    /// Number of points.
    #[expect(clippy::len_without_is_empty, reason = "no lattice is empty")]
    pub fn len(&self) -> usize {
        self.extent.iter().product()
    }

    /// Number of rows along the first axis.
    pub fn rows(&self) -> usize {
        self.extent[1..].iter().product()
    }

    /// Position in memory of a point.
    pub fn index(&self, at: [usize; D]) -> usize {
        let mut index = 0;
        for a in 0..D {
            index += at[a] * self.stride[a];
        }
        index
    }

    /// The point at a position in memory.
    pub fn coordinates(&self, mut index: usize) -> [usize; D] {
        let mut at = [0; D];
        for a in 0..D {
            at[a] = index % self.extent[a];
            index /= self.extent[a];
        }
        at
    }
}

impl<const D: usize> Lattice<D> {
    /// Positions in memory of the points next to `index` along the axes: lower before upper, axis by axis.
    pub fn neighbours(self, index: usize) -> impl Iterator<Item = usize> {
        let at = self.coordinates(index);
        (0..2 * D).filter_map(move |n| {
            let a = n / 2;
            if n % 2 == 0 {
                (at[a] > 0).then(|| index - self.stride[a])
            } else {
                (at[a] + 1 < self.extent[a]).then(|| index + self.stride[a])
            }
        })
    }
}

impl<const D: usize> Grid<D> {
    /// A grid of `cells` cells of size `dx` (m).
    pub fn new(cells: [usize; D], dx: f64) -> Self {
        const { assert!(D == 2 || D == 3, "Meniscus works in two or three dimensions") };
        Self { cells, dx }
    }

    /// The lattice of cell centres.
    pub fn lattice(&self) -> Lattice<D> {
        Lattice::new(self.cells)
    }

    /// The lattice of the faces normal to `axis`.
    pub fn faces(&self, axis: usize) -> Lattice<D> {
        let mut extent = self.cells;
        extent[axis] += 1;
        Lattice::new(extent)
    }

    /// Volume of a cell, m³ (2D: m², that is m³ per metre of depth).
    pub fn cell_volume(&self) -> f64 {
        self.dx.powi(D as i32)
    }

    /// Area of a face, m² (2D: m).
    pub fn face_area(&self) -> f64 {
        self.dx.powi(D as i32 - 1)
    }

    /// Upper corner of the box, m.
    pub fn upper(&self) -> Vector<D> {
        Vector::from_fn(|a, _| self.cells[a] as f64 * self.dx)
    }

    /// Centre of a cell, m.
    pub fn center(&self, at: [usize; D]) -> Vector<D> {
        Vector::from_fn(|a, _| (at[a] as f64 + 0.5) * self.dx)
    }

    /// Centre of a face normal to `axis`, m.
    pub fn face_center(&self, axis: usize, at: [usize; D]) -> Vector<D> {
        Vector::from_fn(|a, _| (at[a] as f64 + if a == axis { 0.0 } else { 0.5 }) * self.dx)
    }
}
