//! Meshing of shapes.

use crate::mesh::volume::VolumeMesh;
use crate::mesh::volume::quadratic::ElementOrder;
use crate::mesh::volume::stuffing::{StuffingError, stuff_with_order};
use crate::shape::Shape;

impl<const D: usize> VolumeMesh<D> {
    /// A mesh of a shape with vertices about `edge` (m) apart: a box as a lattice, other shapes by [`super::stuff`]. Outlines keep their
    /// corners only with [`of_outline`](Self::of_outline).
    ///
    /// # Errors
    /// As [`super::stuff`].
    pub fn of_shape(shape: &Shape<D>, edge: f64, order: ElementOrder) -> Result<Self, StuffingError> {
        if let Shape::Box { center, half_size, rotation } = shape {
            return Ok(Self::of_box(center, half_size, rotation, edge, order)?);
        }
        let (lower, upper) = shape.bounds();
        stuff_with_order(order, &|x| shape.signed_distance(x), &lower, &upper, edge)
    }
}
