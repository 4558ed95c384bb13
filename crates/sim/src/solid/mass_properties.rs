//! Mass properties of rigid solids.

use meniscus_numerics::shape::{Shape, plane_box_fraction};
use meniscus_numerics::{Matrix, Vector};

/// Cells along the longest side of the bounding box for the quadrature of mass and inertia: enough for an accuracy of about 1e-4.
const QUADRATURE_CELLS: usize = 96;

/// Mass, centre of mass and inertia of a rigid solid.
#[derive(Clone, Debug, PartialEq)]
pub struct MassProperties<const D: usize> {
    /// Mass, kg (2D: kg per metre).
    pub mass: f64,
    /// Centre of mass at the start, m.
    pub center: Vector<D>,
    /// Inertia matrix about it at the start, kg m² (2D: kg m, in the last entry).
    pub inertia: Matrix<3>,
}

impl<const D: usize> MassProperties<D> {
    /// A homogeneous solid of a density (kg/m³) and shape, by quadrature over a lattice with planar cuts, accurate to about 1e-4. An
    /// unbounded shape gets infinite mass.
    pub fn homogeneous(shape: &Shape<D>, density: f64) -> Self {
        let (low, high) = shape.bounds();
        let size = high - low;
        if !size.iter().all(|s| s.is_finite()) {
            return Self { mass: f64::INFINITY, center: Vector::zeros(), inertia: Matrix::identity() };
        }
        let h = size.max() / QUADRATURE_CELLS as f64;
        let cells: [usize; D] = std::array::from_fn(|a| (size[a] / h).ceil().max(1.0) as usize);
        let (mut mass, mut first) = (0.0, Vector::<D>::zeros());
        let mut second = Matrix::<3>::zeros();
        for mut i in 0..cells.iter().product() {
            let at = Vector::from_fn(|a, _| {
                let k = i % cells[a];
                i /= cells[a];
                low[a] + (k as f64 + 0.5) * h
            });
            let m = density * h.powi(D as i32) * filled_fraction(shape, &at, h);
            if m > 0.0 {
                let arm = at - low;
                mass += m;
                first += arm * m;
                // The inertia of a cube about its own centre counts as well.
                let own = m * h * h / 12.0;
                for a in 0..D {
                    (0..D).for_each(|b| second[(a, b)] += m * arm[a] * arm[b]);
                    second[(a, a)] += own;
                }
            }
        }
        let arm = first / mass.max(f64::MIN_POSITIVE);
        for a in 0..D {
            (0..D).for_each(|b| second[(a, b)] -= mass * arm[a] * arm[b]);
        }
        let inertia = Matrix::<3>::identity() * second.trace() - second;
        Self { mass, center: low + arm, inertia }
    }
}

/// Fraction of a cube around `at` that a shape fills.
fn filled_fraction<const D: usize>(shape: &Shape<D>, at: &Vector<D>, h: f64) -> f64 {
    let value = shape.signed_distance(at);
    if value.abs() > h {
        return if value < 0.0 { 1.0 } else { 0.0 };
    }
    let slope: [f64; D] = std::array::from_fn(|a| {
        let step = Vector::<D>::from_fn(|b, _| if a == b { 0.05 * h } else { 0.0 });
        (shape.signed_distance(&(at + step)) - shape.signed_distance(&(at - step))) * 10.0
    });
    plane_box_fraction(value, slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn mass_and_inertia_of_a_ball_and_a_turned_box() {
        let ball = Shape::Ball { center: Vector::<3>::new(0.3, -0.2, 0.1), radius: 0.4 };
        let body = MassProperties::homogeneous(&ball, 2.0);
        let mass = 2.0 * 4.0 / 3.0 * PI * 0.4f64.powi(3);
        assert!((body.mass / mass - 1.0).abs() < 2e-4, "{}", body.mass / mass);
        assert!((body.center - Vector::<3>::new(0.3, -0.2, 0.1)).norm() < 1e-5);
        let exact = Matrix::<3>::identity() * (0.4 * mass * 0.16);
        assert!((body.inertia - exact).norm() < 1e-3 * exact.norm(), "{}", body.inertia);

        let (s, c) = 0.5f64.sin_cos();
        let rotation = Matrix::<2>::new(c, -s, s, c);
        let plate = Shape::Box {
            center: Vector::<2>::new(0.2, 0.7),
            half_size: Vector::<2>::new(0.5, 0.1),
            rotation,
        };
        let body = MassProperties::homogeneous(&plate, 3.0);
        assert!((body.mass / 0.6 - 1.0).abs() < 1e-3, "{}", body.mass);
        let exact = 0.6 * (1.0 + 0.04) / 12.0;
        assert!((body.inertia[(2, 2)] / exact - 1.0).abs() < 2e-3, "{}", body.inertia[(2, 2)] / exact);
    }
}
