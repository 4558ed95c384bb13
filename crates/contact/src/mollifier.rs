//! Mollifier of the barrier of two nearly parallel edges (IPC, §5.2): `m = c/ε (2 − c/ε)` for `c = |e × f|² < ε`, with `ε` a fraction
//! of the product of both squared rest lengths.
//!
//! The closest points of parallel edges, and with them the gradient of the distance, are discontinuous. Pairs of points and facets keep
//! the surfaces apart there.

use meniscus_numerics::{Matrix, Vector};

/// `ε` over the product of the squared rest lengths (IPC, §5.2): acts at angles below 1.8 degrees, `sin² = 1e-3`.
const PARALLEL_THRESHOLD: f64 = 1e-3;

/// Value and derivatives of the mollifier.
pub struct Mollifier<const D: usize> {
    /// Value from 0 to 1.
    pub value: f64,
    /// Gradient of each point, 1/m.
    pub gradient: [Vector<D>; 4],
    /// Hessian of each pair of points, 1/m².
    pub hessian: [[Matrix<D>; 4]; 4],
}

impl<const D: usize> Mollifier<D> {
    /// Mollifier of two edges; `None` where it is 1.
    pub fn new(x: &[Vector<D>; 4], squared_length_product: f64) -> Option<Self> {
        let least = PARALLEL_THRESHOLD * squared_length_product;
        let edges = [x[1] - x[0], x[3] - x[2]];
        let (squares, product) = (edges.map(|e| e.norm_squared()), edges[0].dot(&edges[1]));
        let cross = (squares[0] * squares[1] - product * product).max(0.0);
        if cross >= least {
            return None;
        }
        let part = cross / least;
        let (slope, bend) = (2.0 * (1.0 - part) / least, -2.0 / (least * least));
        // Derivatives with respect to the edges: c = |e|² |f|² − (e·f)².
        let other = |i: usize| edges[1 - i];
        let by_edge = [0, 1].map(|i| (edges[i] * squares[1 - i] - other(i) * product) * 2.0);
        let by_edges = |i: usize, j: usize| -> Matrix<D> {
            if i == j {
                return (Matrix::identity() * squares[1 - i] - other(i) * other(i).transpose()) * 2.0;
            }
            (edges[i] * other(i).transpose() * 2.0
                - Matrix::identity() * product
                - other(i) * edges[i].transpose())
                * 2.0
        };
        let sign = [-1.0, 1.0, -1.0, 1.0];
        let gradient = std::array::from_fn(|k| by_edge[k / 2] * (sign[k] * slope));
        let block = |k: usize, l: usize| {
            let (i, j) = (k / 2, l / 2);
            (by_edges(i, j) * slope + by_edge[i] * by_edge[j].transpose() * bend) * (sign[k] * sign[l])
        };
        let hessian = std::array::from_fn(|k| std::array::from_fn(|l| block(k, l)));
        Some(Self { value: part * (2.0 - part), gradient, hessian })
    }
}
