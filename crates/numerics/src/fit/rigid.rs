//! Least-squares rigid motion between two sets of points.

use crate::{Matrix, Vector};

/// A rotation about one point and a translation that map points to others with the least sum of squares (W. Kabsch, "A
/// solution for the best rotation to relate two sets of vectors", Acta Cryst. A 32 (1976) 922).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidTransform {
    /// The rotation.
    pub rotation: Matrix<3>,
    /// Mean of the initial points, m.
    pub initial_centroid: Vector<3>,
    /// Mean of the final points, m.
    pub final_centroid: Vector<3>,
}

impl RigidTransform {
    /// Fits the motion of points from `from` to `to` (m), in the same order. Points in a plane `z` stay in it.
    pub fn fit(from: &[Vector<3>], to: &[Vector<3>]) -> Self {
        let count = from.len().min(to.len()).max(1) as f64;
        let mean = |all: &[Vector<3>]| all.iter().sum::<Vector<3>>() / count;
        let (start, end) = (mean(from), mean(to));
        let mut sum = Matrix::<3>::zeros();
        from.iter().zip(to).for_each(|(a, b)| sum += (b - end) * (a - start).transpose());
        let svd = sum.svd(true, true);
        let rotation = match (svd.u, svd.v_t) {
            (Some(u), Some(v)) => {
                let mut turn = Matrix::<3>::identity();
                turn[(2, 2)] = (u * v).determinant().signum();
                u * turn * v
            }
            _ => Matrix::identity(),
        };
        Self { rotation, initial_centroid: start, final_centroid: end }
    }

    /// The point that the motion maps to `x`, m.
    pub fn inverse_transformed(&self, x: &Vector<3>) -> Vector<3> {
        self.initial_centroid + self.rotation.tr_mul(&(x - self.final_centroid))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_come_back() {
        let turn = nalgebra::Rotation3::new(Vector::<3>::new(0.3, -2.0, 0.7)).into_inner();
        let flat = nalgebra::Rotation3::new(Vector::<3>::new(0.0, 0.0, 2.5)).into_inner();
        for (rotation, depth) in [(turn, 1.0), (flat, 0.0)] {
            let point = |k: usize| {
                Vector::<3>::new((k * 7 % 11) as f64, (k * 5 % 13) as f64, depth * (k * 3 % 7) as f64)
            };
            let from: Vec<_> = (0..40).map(point).collect();
            let way = Vector::<3>::new(4.0, -1.0, depth);
            let to: Vec<_> = from.iter().map(|x| rotation * x + way).collect();
            let motion = RigidTransform::fit(&from, &to);
            assert!((motion.rotation - rotation).norm() < 1e-12, "{}", motion.rotation);
            let off = from
                .iter()
                .zip(&to)
                .map(|(a, b)| (motion.inverse_transformed(b) - a).norm())
                .fold(0.0, f64::max);
            assert!(off < 1e-12, "{off}");
        }
    }
}
