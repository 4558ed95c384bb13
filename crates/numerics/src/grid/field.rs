//! Dense fields on the grid.

use super::Grid;

/// One value per cell.
#[derive(Clone, Debug, PartialEq)]
pub struct CellField<const D: usize> {
    /// Its grid.
    pub grid: Grid<D>,
    /// Values in the order of [`Grid::lattice`].
    pub data: Vec<f64>,
}

/// One value per face, one array per axis (the staggered velocity).
#[derive(Clone, Debug, PartialEq)]
pub struct FaceField<const D: usize> {
    /// Its grid.
    pub grid: Grid<D>,
    /// For each axis the values on the faces normal to it, in the order of [`Grid::face_lattice`].
    pub axes: [Vec<f64>; D],
}

impl<const D: usize> CellField<D> {
    /// A field of one value. Memory of a zero field is not touched before it is written.
    pub fn new(grid: Grid<D>, value: f64) -> Self {
        Self { grid, data: vec![value; grid.lattice().len()] }
    }
}

impl<const D: usize> FaceField<D> {
    /// A field of zeros. Its memory is not touched before it is written.
    pub fn zeros(grid: Grid<D>) -> Self {
        Self { grid, axes: std::array::from_fn(|a| vec![0.0; grid.face_lattice(a).len()]) }
    }
}
