//! Converts points, rotations and outlines of a scene to types of `meniscus_numerics`.

use super::extrusion_form::{Outline as OutlineSpec, OutlineName};
use super::rotation::Rotation;
use crate::error::SceneError;
use meniscus_numerics::mesh::volume::Outline;
use meniscus_numerics::{Matrix, Vector};

/// A point, or a size along each axis.
pub(crate) fn vector<const D: usize>(values: &[f64]) -> Vector<D> {
    Vector::from_fn(|a, _| values.get(a).copied().unwrap_or(0.0))
}

/// A rotation as a matrix.
pub(crate) fn rotation<const D: usize>(rotation: &Rotation) -> Matrix<D> {
    let rows = rotation.matrix();
    Matrix::from_fn(|i, j| rows[i][j])
}

/// An outline in the plane.
pub(crate) fn outline(spec: &OutlineSpec) -> Result<Outline, SceneError> {
    Ok(match spec {
        OutlineSpec::Named(OutlineName::Square, size) => Outline::square(*size),
        OutlineSpec::Named(OutlineName::Triangle, size) => Outline::triangle(*size),
        OutlineSpec::Named(OutlineName::Petals4, size) => Outline::petals(4, *size),
        OutlineSpec::Named(OutlineName::Petals6, size) => Outline::petals(6, *size),
        OutlineSpec::Named(OutlineName::Cross, size) => Outline::cross(*size),
        OutlineSpec::Named(OutlineName::Leaf, size) => Outline::leaf(*size),
        OutlineSpec::Points(points) => {
            let points: Vec<[f64; 2]> = points.iter().map(|p| vector::<2>(p).into()).collect();
            Outline::polygon(&points).map_err(|e| SceneError::new(e.to_string()))?
        }
    })
}
