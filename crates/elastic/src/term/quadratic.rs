//! Points of quadratic simplices.
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::Parent;
use meniscus_numerics::mesh::volume::refined::edges;
use meniscus_numerics::{Matrix, Vector};
use super::density::{cofactor, determinant};

type Points<const D: usize> = (Vec<Vector<D>>, Vec<f64>);

/// Barycentric coordinates of the points: `near` towards one corner, else `far`.
fn coordinates<const D: usize>(point: usize) -> Vec<f64> {
    let far = if D == 2 { 1.0 / 6.0 } else { (5.0 - 5f64.sqrt()) / 20.0 };
    let near = 1.0 - D as f64 * far;
    (0..=D).map(|i| if i == point { near } else { far }).collect()
}

/// Slopes of the shape functions along barycentric coordinates 1 to D, with coordinate 0 what remains.
fn slopes<const D: usize>(b: &[f64]) -> Vec<Vector<D>> {
    let along = |i: usize| Vector::<D>::from_fn(|r, _| if i == 0 { -1.0 } else { f64::from(r + 1 == i) });
    let corner = |i: usize| along(i) * (4.0 * b[i] - 1.0);
    let middle = |(i, j): (usize, usize)| (along(i) * b[j] + along(j) * b[i]) * 4.0;
    (0..=D).map(corner).chain(edges::<D>().map(middle)).collect()
}

/// Gradients of nodes, and volumes, of all points.
pub fn points<const D: usize>(mesh: &VolumeMesh<D>) -> Vec<(Parent<D>, Points<D>)> {
    let Some(parents) = mesh.parents() else { return Vec::new() };
    let reference: Vec<Vec<Vector<D>>> = (0..=D).map(|p| slopes(&coordinates::<D>(p))).collect();
    let share = if D == 2 { 1.0 / 6.0 } else { 1.0 / 24.0 };
    let of = |parent: Parent<D>| {
        let (mut gradients, mut volumes) = (Vec::new(), Vec::new());
        for slopes in &reference {
            let at = parent.nodes().iter().map(|v| mesh.positions[*v as usize]);
            let jacobian = at.zip(slopes).fold(Matrix::<D>::zeros(), |j, (x, s)| j + x * s.transpose());
            let determinant = determinant(&jacobian);
            let across = cofactor(&jacobian) / determinant;
            gradients.extend(slopes.iter().map(|s| across * s));
            volumes.push(share * determinant);
        }
        (parent, (gradients, volumes))
    };
    parents.into_iter().map(of).collect()
}
