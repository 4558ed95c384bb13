//! Dense fields on the grid.

use super::{Grid, Segment};

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

/// The values of the segments of an array whose rows have `row_length` values, one segment behind the other.
pub fn gather_segments(data: &[f64], row_length: usize, segments: &[Segment]) -> Vec<f64> {
    let mut values = Vec::with_capacity(segments.iter().map(|s| s.end - s.start).sum());
    segments.iter().for_each(|s| values.extend_from_slice(&data[s.row * row_length..][s.start..s.end]));
    values
}

/// Writes values that are one segment behind the other to the segments of such an array.
pub fn scatter_segments(data: &mut [f64], row_length: usize, segments: &[Segment], mut values: &[f64]) {
    for s in segments {
        let own;
        (own, values) = values.split_at(s.end - s.start);
        data[s.row * row_length..][s.start..s.end].copy_from_slice(own);
    }
}

/// Exchanges the values of the segments of such an array with others.
pub fn swap_segments(data: &mut [f64], row_length: usize, segments: &[Segment], mut values: &mut [f64]) {
    for s in segments {
        let own;
        (own, values) = values.split_at_mut(s.end - s.start);
        data[s.row * row_length..][s.start..s.end].swap_with_slice(own);
    }
}
