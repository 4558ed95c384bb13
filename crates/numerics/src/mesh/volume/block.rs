//! Boxes as lattices of cells cut into simplices.
//!
//! Every cell is cut around the same diagonal, one simplex for each order of the axes: two triangles, six tetrahedra
//! (H. W. Kuhn, "Some combinatorial lemmas in topology", IBM J. Res. Dev. 4 (1960)). Cells are as nearly cubes as the box allows.
//! Of quadratic simplices there is one for every two cells along each axis.

use super::quadratic::ElementOrder;
use super::{Simplex, VolumeMesh};
use crate::{Matrix, Vector};
use thiserror::Error;

/// Most vertices of a block: a solid's matrices take some 8 kB of memory for each in 3D.
const MAX_VERTICES: f64 = 2e6;
/// The orders of the axes; the first two of the plane's.
const AXIS_ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 0, 2], [0, 2, 1], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
/// Fewest cells along an axis.
const MIN_CELLS: usize = 2;

/// Why a box cannot be a lattice.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BlockError {
    /// A side or an edge is not a positive length.
    #[error("a box of {size:?} m cannot have edges of {edge} m; give positive lengths")]
    Size {
        /// Sides, m.
        size: Vec<f64>,
        /// Edge asked for, m.
        edge: f64,
    },
    /// It would take too many vertices.
    #[error("edges of {edge} m would take about {vertices:e} vertices; give longer ones")]
    TooFine {
        /// Edge asked for, m.
        edge: f64,
        /// Vertices that it takes.
        vertices: f64,
    },
}

/// Numbers of cells of a block of the given size (m) with edges about `edge` long (m): at least two along the shortest side,
/// and along the others as many as make them cubes; multiples of `step`.
pub fn block_cells<const D: usize>(size: &Vector<D>, edge: f64, step: usize) -> [usize; D] {
    let shortest = size.min();
    let edge = shortest / cell_count(shortest, edge, step) as f64;
    std::array::from_fn(|a| cell_count(size[a], edge, step))
}

/// Number of cells along a side: a multiple of `step`, at least two.
pub(super) fn cell_count(side: f64, edge: f64, step: usize) -> usize {
    let wanted = (side / edge).max(0.0);
    // The next lower and higher number; the nearer one by the ratio of edges.
    let lower = ((wanted / step as f64) as usize * step).max(MIN_CELLS);
    let higher = lower + step;
    if wanted * wanted > lower as f64 * higher as f64 { higher } else { lower }
}

/// A block about the origin, of the given size (m), with given numbers of cells along the axes.
pub fn block<const D: usize>(cells: [usize; D], size: &Vector<D>) -> VolumeMesh<D> {
    let mut stride = [1usize; D];
    (1..D).for_each(|a| stride[a] = stride[a - 1] * (cells[a - 1] + 1));
    let place = |index: usize| -> [usize; D] { std::array::from_fn(|a| index / stride[a] % (cells[a] + 1)) };
    let at = |index: usize| {
        let place = place(index);
        Vector::from_fn(|a, _| (place[a] as f64 / cells[a] as f64 - 0.5) * size[a])
    };
    let corners: usize = cells.iter().map(|n| n + 1).product();
    let positions: Vec<Vector<D>> = (0..corners).map(at).collect();
    let orders: &[[usize; 3]] = if D == 2 { &AXIS_ORDERS[..2] } else { &AXIS_ORDERS };
    let mut simplices = Vec::with_capacity(cells.iter().product::<usize>() * orders.len());
    for index in (0..corners).filter(|i| place(*i).iter().zip(&cells).all(|(i, n)| i < n)) {
        for order in orders {
            let mut corner = index;
            let others = std::array::from_fn(|k| {
                corner += stride[order[k]];
                corner as u32
            });
            simplices.push(Simplex { root: index as u32, others }.oriented(&positions));
        }
    }
    VolumeMesh { positions, simplices }
}

impl<const D: usize> VolumeMesh<D> {
    /// A box with vertices about `edge` apart (m): centre and half sizes in m, and a rotation whose columns are the box's own
    /// axes, as in [`Shape::Box`](crate::shape::Shape::Box). There are at least two cells along every axis.
    ///
    /// # Errors
    /// Lengths that are none, edges too short for memory.
    pub fn of_box(
        center: &Vector<D>,
        half_size: &Vector<D>,
        rotation: &Matrix<D>,
        edge: f64,
        order: ElementOrder,
    ) -> Result<Self, BlockError> {
        let size = half_size * 2.0;
        if !size.iter().chain([&edge]).all(|s| *s > 0.0 && s.is_finite()) {
            return Err(BlockError::Size { size: size.as_slice().to_vec(), edge });
        }
        let vertices = size.iter().map(|s| s / edge + 2.0).product::<f64>();
        if vertices > MAX_VERTICES {
            return Err(BlockError::TooFine { edge, vertices });
        }
        let mesh = match order {
            ElementOrder::Linear => block(block_cells(&size, edge, 1), &size),
            ElementOrder::Quadratic => block(block_cells(&size, edge, 2).map(|n| n / 2), &size).subdivided(),
        };
        Ok(mesh.transformed(rotation, center))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxes<const D: usize>() {
        let mut rotation = Matrix::<D>::identity();
        let (s, c) = 0.4f64.sin_cos();
        (rotation[(0, 0)], rotation[(0, 1)], rotation[(1, 0)], rotation[(1, 1)]) = (c, -s, s, c);
        let half = Vector::from_fn(|a, _| [0.5, 0.2, 0.03][a]);
        let center = Vector::from_fn(|a, _| 0.1 + a as f64);
        let refused = |half: &Vector<D>, edge| {
            VolumeMesh::<D>::of_box(&center, half, &rotation, edge, ElementOrder::Linear).unwrap_err()
        };
        assert!(matches!(refused(&half, 1e-12), BlockError::TooFine { .. }));
        assert!(matches!(refused(&half, f64::NAN), BlockError::Size { .. }));
        assert!(matches!(refused(&(half * 0.0), 0.1), BlockError::Size { .. }));
        for order in [ElementOrder::Linear, ElementOrder::Quadratic] {
            let mesh = VolumeMesh::<D>::of_box(&center, &half, &rotation, 0.05, order).unwrap();
            assert_eq!(mesh.check(), Ok(()));
            assert_eq!(mesh.quadratic_simplices().is_some(), order == ElementOrder::Quadratic);
            let quality = mesh.quality();
            println!("{D}D box: {quality}");
            assert!((quality.volume / (2.0 * half).product() - 1.0).abs() < 1e-13);
            assert!(quality.smallest_angle.0.to_degrees() > 35.0);
            let middle = mesh.positions.iter().sum::<Vector<D>>() / mesh.positions.len() as f64;
            assert!((middle - center).norm() < 1e-12);
        }
    }

    #[test]
    fn boxes_are_lattices() {
        boxes::<2>();
        boxes::<3>();
        assert_eq!(block_cells(&Vector::from([1.0, 0.29, 0.2]), 0.1, 1), [10, 3, 2]);
        assert_eq!(block_cells(&Vector::from([1.0, 0.29, 0.2]), 0.1, 2), [10, 4, 2]);
        assert_eq!(block_cells(&Vector::from([1.04, 0.01]), 0.1, 1), [208, 2]);
        // The plate of Fig. 15.
        let plate = block::<3>([96, 96, 2], &Vector::from([3.33, 3.33, 0.0693]));
        assert_eq!((plate.positions.len(), plate.simplices.len()), (28_227, 110_592));
    }
}
