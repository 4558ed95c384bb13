//! Boxes as lattices of cells cut into simplices.
//!
//! In 3D a cell is cut into five tetrahedra, one in the middle on the corners of one parity and one at each of the other
//! corners (paper, 7: its plates are such lattices). Corners are even or odd by their place in the whole lattice, so that
//! neighbouring cells are each other's mirror images, diagonals of sides agree, and no direction is preferred. Where the
//! number of cells is even along every axis, the mesh has all mirror symmetries of the box.
//!
//! In 2D a cell is cut into four triangles by both its diagonals. Unlike one diagonal per cell (whether it alternates or
//! not) that has the symmetries of the box for any number of cells, and nearly incompressible material can deform:
//! one of a cell's four constraints follows from the others (J. Nagtegaal, D. Parks and J. Rice, Comput. Methods Appl. Mech.
//! Eng. 4 (1974) 153).

use super::{Simplex, VolumeMesh};
use crate::{Matrix, Vector};
use thiserror::Error;

/// Most vertices of a block.
const MOST: f64 = 2e8;
/// Fewest cells along an axis.
const FEWEST: usize = 2;

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

/// Numbers of cells of a block of the given size (m) with edges about `edge` long (m): at least two along every axis, in 3D
/// even ones.
pub fn cells<const D: usize>(size: &Vector<D>, edge: f64) -> [usize; D] {
    std::array::from_fn(|a| count(size[a], edge, if D == 3 { 2 } else { 1 }))
}

/// Number of cells along a side: a multiple of `step`, at least two.
pub(super) fn count(side: f64, edge: f64, step: usize) -> usize {
    let wanted = (side / edge).max(0.0);
    // The next lower and higher number; the nearer one by the ratio of edges.
    let lower = ((wanted / step as f64) as usize * step).max(FEWEST);
    let higher = lower + step;
    if wanted * wanted > lower as f64 * higher as f64 { higher } else { lower }
}

/// A block about the origin, of the given size (m), with given numbers of cells along the axes.
pub fn block<const D: usize>(cells: [usize; D], size: &Vector<D>) -> VolumeMesh<D> {
    let mut stride = [1usize; D];
    (1..D).for_each(|a| stride[a] = stride[a - 1] * (cells[a - 1] + 1));
    let corners: usize = cells.iter().map(|n| n + 1).product();
    let at = |index: usize, shift: f64| -> Vector<D> {
        Vector::from_fn(|a, _| {
            let i = index / stride[a] % (cells[a] + 1);
            ((i as f64 + shift) / cells[a] as f64 - 0.5) * size[a]
        })
    };
    let mut positions: Vec<Vector<D>> = (0..corners).map(|i| at(i, 0.0)).collect();
    let mut simplices = Vec::with_capacity(cells.iter().product::<usize>() * 5);
    for index in 0..corners {
        let place: [usize; D] = std::array::from_fn(|a| index / stride[a] % (cells[a] + 1));
        if (0..D).any(|a| place[a] == cells[a]) {
            continue;
        }
        let corner = |o: usize| (index + (0..D).map(|a| (o >> a & 1) * stride[a]).sum::<usize>()) as u32;
        if D == 2 {
            let middle = positions.len() as u32;
            positions.push(at(index, 0.5));
            for [a, b] in [[0, 1], [1, 3], [3, 2], [2, 0]] {
                simplices.push([middle, corner(a), corner(b), 0]);
            }
        } else {
            let odd = place.iter().sum::<usize>() & 1;
            let [even, others] = if odd == 0 { [0, 7] } else { [7, 0] };
            simplices.push([even, even ^ 3, even ^ 5, even ^ 6].map(corner));
            for o in [others, others ^ 3, others ^ 5, others ^ 6] {
                simplices.push([o, o ^ 1, o ^ 2, o ^ 4].map(corner));
            }
        }
    }
    let simplex =
        |v: [u32; 4]| Simplex { root: v[0], rest: std::array::from_fn(|k| v[k + 1]) }.upright(&positions);
    let simplices = simplices.into_iter().map(simplex).collect();
    VolumeMesh { positions, simplices }
}

impl<const D: usize> VolumeMesh<D> {
    /// A box with edges about `edge` long (m): centre and half sizes in m, and a rotation whose columns are the box's own
    /// axes, as in [`Shape::Box`](crate::shape::Shape::Box). There are at least two cells along every axis; an axis shorter
    /// than two edges has cells as flat as that takes.
    ///
    /// # Errors
    /// Lengths that are none, edges too short for memory.
    pub fn of_box(
        center: &Vector<D>,
        half_size: &Vector<D>,
        rotation: &Matrix<D>,
        edge: f64,
    ) -> Result<Self, BlockError> {
        let size = half_size * 2.0;
        if !size.iter().chain([&edge]).all(|s| *s > 0.0 && s.is_finite()) {
            return Err(BlockError::Size { size: size.as_slice().to_vec(), edge });
        }
        let vertices = size.iter().map(|s| s / edge + 2.0).product::<f64>();
        if vertices > MOST {
            return Err(BlockError::TooFine { edge, vertices });
        }
        Ok(block(cells(&size, edge), &size).moved(rotation, center))
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
        let mesh = VolumeMesh::<D>::of_box(&center, &half, &rotation, 0.05).unwrap();
        let refused =
            |half: &Vector<D>, edge| VolumeMesh::<D>::of_box(&center, half, &rotation, edge).unwrap_err();
        assert!(matches!(refused(&half, 1e-12), BlockError::TooFine { .. }));
        assert!(matches!(refused(&half, f64::NAN), BlockError::Size { .. }));
        assert!(matches!(refused(&(half * 0.0), 0.1), BlockError::Size { .. }));
        assert_eq!(mesh.check(), Ok(()));
        let quality = mesh.quality();
        println!("{D}D box: {quality}");
        assert!((quality.volume / (2.0 * half).product() - 1.0).abs() < 1e-13);
        let least = if D == 2 { 44.9 } else { 40.0 };
        assert!(quality.smallest_angle.0.to_degrees() > least);
        let middle = mesh.positions.iter().sum::<Vector<D>>() / mesh.positions.len() as f64;
        assert!((middle - center).norm() < 1e-12);
    }

    /// Every mirror image of a block is the block.
    fn symmetric<const D: usize>() {
        let size = Vector::repeat(1.0);
        let mesh = block::<D>([4; D], &size);
        let centers = |flip: usize| {
            let center = |s: &Simplex<D>| {
                let c = s.center(&mesh.positions);
                let mut key: Vec<i64> = c.iter().map(|x| (x * 1e9).round() as i64).collect();
                key[flip % D] *= if flip < D { 1 } else { -1 };
                key
            };
            let mut all: Vec<Vec<i64>> = mesh.simplices.iter().map(center).collect();
            all.sort_unstable();
            all
        };
        (0..D).for_each(|a| assert_eq!(centers(a), centers(a + D)));
    }

    #[test]
    fn boxes_are_lattices() {
        boxes::<2>();
        boxes::<3>();
        symmetric::<2>();
        symmetric::<3>();
        assert_eq!(cells(&Vector::from([1.0, 0.29, 0.01]), 0.1), [10, 4, 2]);
        assert_eq!(cells(&Vector::from([1.04, 0.01]), 0.1), [10, 2]);
        // The plate of Fig. 15.
        let plate = block::<3>([96, 96, 2], &Vector::from([3.33, 3.33, 0.0693]));
        assert_eq!((plate.positions.len(), plate.simplices.len()), (28_227, 92_160));
    }
}
