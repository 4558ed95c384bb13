//! Boxes as lattices of cells cut into simplices.
//!
//! Every cell is cut around the same diagonal, with one simplex for each order of the axes: two triangles, six tetrahedra
//! (H. W. Kuhn, "Some combinatorial lemmas in topology", IBM J. Res. Dev. 4 (1960)). Cells have the requested
//! edges where the shortest side can be divided into such; in thinner boxes they are close to cubes. A mesh of quadratic simplices has
//! half as many cells along each axis and is then subdivided.

use super::quadratic::ElementOrder;
use super::{Simplex, VolumeMesh};
use crate::{Matrix, Vector};
use thiserror::Error;

/// Most vertices of a block. A solid's matrices need about 8 kB per vertex in 3D.
const MAX_VERTICES: f64 = 2e6;
/// Orders of the axes; the first two are those of the plane.
const AXIS_ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 0, 2], [0, 2, 1], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
/// Least number of cells along an axis.
const MIN_CELLS: usize = 2;

/// Why a box cannot be meshed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BlockError {
    /// A side or an edge is not a positive length.
    #[error(
        "a box with sides of {size:?} m cannot be filled with elements with edges of {edge} m; give positive lengths"
    )]
    Size {
        /// Sides, m.
        size: Vec<f64>,
        /// Edge requested, m.
        edge: f64,
    },
    /// The mesh would have too many vertices.
    #[error("a mesh with edges of {edge} m would have about {vertices:e} vertices; give longer edges")]
    TooFine {
        /// Edge requested, m.
        edge: f64,
        /// Number of vertices that it needs.
        vertices: f64,
    },
}

/// Numbers of cells of a block of the given size (m) with edges about `edge` (m) long, multiples of `step`. There are at least two
/// along the shortest side. Where rounding its number changes the edge by more than a factor of `√2`, as in thin boxes, the other sides
/// get the number that makes the cells nearly cubes.
pub fn block_cells<const D: usize>(size: &Vector<D>, edge: f64, step: usize) -> [usize; D] {
    let shortest = size.min();
    let across = shortest / cell_count(shortest, edge, step) as f64;
    let is_rounding = across * across <= 2.0 * edge * edge && edge * edge <= 2.0 * across * across;
    let along = if is_rounding { edge } else { across };
    std::array::from_fn(|a| cell_count(size[a], along, step))
}

/// Number of cells along a side: a multiple of `step`, at least two.
pub(super) fn cell_count(side: f64, edge: f64, step: usize) -> usize {
    let wanted = (side / edge).max(0.0);
    // The next lower and higher number; the nearer one in terms of the ratio of edges.
    let lower = ((wanted / step as f64) as usize * step).max(MIN_CELLS);
    let higher = lower + step;
    if wanted * wanted > lower as f64 * higher as f64 { higher } else { lower }
}

/// A block centred at the origin with the given size (m) and numbers of cells along the axes.
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
    /// A box with vertices about `edge` (m) apart: centre and half sizes in m, and a rotation whose columns are the box's
    /// axes, as in [`Shape::Box`](crate::shape::Shape::Box). There are at least two cells along every axis.
    ///
    /// # Errors
    /// A length is not positive and finite, or the mesh would have too many vertices.
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
        assert_eq!(block_cells(&Vector::from([8.0, 8.0, 0.5]), 0.17, 2), [48, 48, 4]);
        assert_eq!(block_cells(&Vector::from([8.0, 8.0, 0.5]), 0.3, 2), [26, 26, 2]);
        assert_eq!(block_cells(&Vector::from([8.0, 8.0, 0.5]), 0.4, 2), [32, 32, 2]);
        // The plate of Fig. 15 of Liu et al. (2022).
        let plate = block::<3>([96, 96, 2], &Vector::from([3.33, 3.33, 0.0693]));
        assert_eq!((plate.positions.len(), plate.simplices.len()), (28_227, 110_592));
    }
}
