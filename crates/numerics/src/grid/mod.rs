//! The staggered (MAC) grid: cubic cells, values at cell centres and on faces.

mod band;
mod boxes;
mod components;
mod cut_cells;
mod field;
mod interpolate;
mod runs;
mod serialise;
mod tiles;
mod velocity_extension;

pub use band::Band;
pub use boxes::{box_rows, lattice_points, segment_points};
pub use cut_cells::{CutCell, CutCells, EmbeddedBoundary};
pub use field::{CellField, FaceField, gather_segments, scatter_segments, swap_segments};
pub use interpolate::{BoundaryExtension, Sampler, VelocitySampler};
pub use runs::{Run, Runs, Segment};
pub use tiles::{TILE_CELLS, Tiles};
pub use velocity_extension::VelocityExtension;

use crate::Vector;
use crate::each_lanes;
use crate::lanes::{Instructions, Lanes, VectorLanes};

/// A box of cubic cells that contains the domain; the domain's lower corner is the origin.
///
/// Cells are numbered with the first axis varying fastest: `index = i + nx (j + ny k)`. The faces normal to axis `a` form
/// a lattice of their own with one more entry along `a`; face `i` along `a` is the *lower* face of cell `i`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid<const D: usize> {
    /// Number of cells along each axis, including those outside the domain.
    pub cells: [usize; D],
    /// Cell size, m.
    pub dx: f64,
    /// Cells outside the domain at its lower and upper side along each axis; usually none.
    pub margin_cells: [[usize; 2]; D],
}

/// The shape of a dense array over a lattice: extents and strides, the first axis varying fastest.
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
    #[inline]
    pub fn index(&self, at: [usize; D]) -> usize {
        let mut index = 0;
        for a in 0..D {
            index += at[a] * self.stride[a];
        }
        index
    }

    /// The point at a position in memory.
    #[inline]
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
    /// A grid of `cells` cells of size `dx` (m), none of them outside the domain.
    pub fn new(cells: [usize; D], dx: f64) -> Self {
        const { assert!(D == 2 || D == 3, "Meniscus works in two or three dimensions") };
        Self { cells, dx, margin_cells: [[0; 2]; D] }
    }

    /// The same domain with `margin_cells` cells beyond its sides.
    pub fn with_margin(&self, margin_cells: [[usize; 2]; D]) -> Self {
        let inner = self.domain_cells();
        Self {
            cells: std::array::from_fn(|a| inner[a] + margin_cells[a][0] + margin_cells[a][1]),
            margin_cells,
            ..*self
        }
    }

    /// Number of cells of the domain along each axis.
    pub fn domain_cells(&self) -> [usize; D] {
        std::array::from_fn(|a| self.cells[a] - self.margin_cells[a][0] - self.margin_cells[a][1])
    }

    /// Coordinate along an axis, in cells from the origin, of a point `i` cells from the grid's lower side.
    pub fn domain_coordinate_cells(&self, axis: usize, i: f64) -> f64 {
        i - self.margin_cells[axis][0] as f64
    }

    /// The lattice of cell centres.
    pub fn lattice(&self) -> Lattice<D> {
        Lattice::new(self.cells)
    }

    /// The lattice of the faces normal to `axis`.
    pub fn face_lattice(&self, axis: usize) -> Lattice<D> {
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

    /// Upper corner of the domain, m.
    pub fn domain_upper(&self) -> Vector<D> {
        Vector::from_fn(|a, _| self.domain_cells()[a] as f64 * self.dx)
    }

    /// Lower and upper corner of the grid including its margins, m.
    pub fn bounds(&self) -> [Vector<D>; 2] {
        [self.lower_corner([0; D]), self.lower_corner(self.cells)]
    }

    /// Lower corner of a cell, m.
    pub fn lower_corner(&self, at: [usize; D]) -> Vector<D> {
        Vector::from_fn(|a, _| self.domain_coordinate_cells(a, at[a] as f64) * self.dx)
    }

    /// The cell that contains a point, or the nearest one.
    pub fn cell_at(&self, x: &Vector<D>) -> [usize; D] {
        std::array::from_fn(|a| {
            let place = x[a] / self.dx + self.margin_cells[a][0] as f64;
            (place.max(0.0) as usize).min(self.cells[a] - 1)
        })
    }

    /// Centre of a cell, m.
    pub fn center(&self, at: [usize; D]) -> Vector<D> {
        Vector::from_fn(|a, _| self.domain_coordinate_cells(a, at[a] as f64 + 0.5) * self.dx)
    }

    /// Centre of a face normal to `axis`, m.
    pub fn face_center(&self, axis: usize, at: [usize; D]) -> Vector<D> {
        let shift = |a: usize| if a == axis { 0.0 } else { 0.5 };
        Vector::from_fn(|a, _| self.domain_coordinate_cells(a, at[a] as f64 + shift(a)) * self.dx)
    }

    /// Centres of consecutive cells of a row, m, from `at` on.
    #[inline(always)]
    pub fn centers<I: Instructions>(&self, with: I, at: [usize; D]) -> VectorLanes<I, D> {
        self.points_of_row(with, at, [0.5; D])
    }

    /// Centres of consecutive faces normal to `axis` of a row, m, from `at` on.
    #[inline(always)]
    pub fn face_centers<I: Instructions>(&self, with: I, axis: usize, at: [usize; D]) -> VectorLanes<I, D> {
        self.points_of_row(with, at, std::array::from_fn(|a| if a == axis { 0.0 } else { 0.5 }))
    }

    #[inline(always)]
    fn points_of_row<I: Instructions>(&self, with: I, at: [usize; D], shift: [f64; D]) -> VectorLanes<I, D> {
        VectorLanes(each_lanes!(with, |a| {
            let first = Lanes::splat(with, at[a] as f64 + shift[a]);
            let place = if a == 0 { first + Lanes::from_fn(with, |l| l as f64) } else { first };
            (place - Lanes::splat(with, self.margin_cells[a][0] as f64)) * self.dx
        }))
    }
}
