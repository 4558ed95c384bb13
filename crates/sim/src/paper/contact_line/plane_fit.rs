//! Fit of a plane to points (Algorithm 2): orthogonal distance regression by a singular value decomposition.
//!
//! ```text
//! c = Σ p_i/n,    A = [p_0 − c, …, p_{n−1} − c] = U S Vᵀ
//! ```
//!
//! The columns of `U` are the directions of decreasing spread: the last one is the normal, the first one in 2D the tangent.

use meniscus_numerics::Vector;
use nalgebra::DMatrix;

/// Number of points below which no plane is fitted (Section 5.2).
pub const MIN_SAMPLES: usize = 3;
/// Singular value over the largest one below which points do not spread in its direction.
const MIN_SPREAD: f64 = 1e-6;

/// A plane (2D: a line) through points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedPlane<const D: usize> {
    /// Mean of the points, m.
    pub center: Vector<D>,
    /// Directions of decreasing spread: the columns of `U`. Their signs have no meaning.
    pub directions: [Vector<D>; D],
}

impl<const D: usize> FittedPlane<D> {
    /// The plane through points, m; `None` where there are fewer than three, or where they do not span a plane (2D: where they coincide).
    pub fn new(points: &[Vector<D>]) -> Option<Self> {
        if points.len() < MIN_SAMPLES {
            return None;
        }
        let center = points.iter().sum::<Vector<D>>() / points.len() as f64;
        let matrix = DMatrix::from_fn(D, points.len(), |a, i| points[i][a] - center[a]);
        let decomposition = matrix.svd(true, false);
        let (values, u) = (decomposition.singular_values, decomposition.u?);
        let spans = values[D - 2] > MIN_SPREAD * values[0];
        let directions = std::array::from_fn(|k| Vector::from_fn(|a, _| u[(a, k)]));
        (spans && values[0] > 0.0).then_some(Self { center, directions })
    }

    /// Unit normal of the plane.
    pub fn normal(&self) -> Vector<D> {
        self.directions[D - 1]
    }

    /// Unit tangent of the plane across a line with the unit tangent `along`, towards the points as seen from `from` (m); in 2D `along`
    /// does not count. `None` where the plane is normal to the line, or where the points lie to neither side.
    pub fn tangent(&self, from: &Vector<D>, along: &Vector<D>) -> Option<Vector<D>> {
        let tangent = if D == 2 { self.directions[0] } else { cross(&self.normal(), along) };
        let tangent = tangent.try_normalize(MIN_SPREAD)?;
        let side = tangent.dot(&(self.center - from));
        (side != 0.0).then(|| tangent * side.signum())
    }
}

/// The cross product in 3D.
fn cross<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> Vector<D> {
    Vector::from_fn(|k, _| {
        let (i, j) = ((k + 1) % D, (k + 2) % D);
        a[i] * b[j] - a[j] * b[i]
    })
}
