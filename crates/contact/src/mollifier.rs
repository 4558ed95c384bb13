//! The factor by which the barrier of two nearly parallel edges is reduced (IPC, §5.2): where edges are parallel their closest points
//! jump, and the gradient of the distance with them. Points and facets keep the surfaces apart there.
//!
//! `m = c/ε (2 − c/ε)` for `c = |e × f|² < ε`, with `ε` a part of the product of both squared lengths at rest.

use meniscus_numerics::{Matrix, Vector};

/// `ε` over the product of the squared lengths at rest (IPC, §5.2): the factor acts on edges at less than 1.8 degrees, `sin² = 1e-3`.
const PARALLEL_THRESHOLD: f64 = 1e-3;

/// The share of the barrier that is left, and its derivatives.
pub struct Mollifier<const D: usize> {
    /// From 0 to 1.
    pub value: f64,
    /// By each point, 1/m.
    pub gradient: [Vector<D>; 4],
    /// By each two, 1/m².
    pub hessian: [[Matrix<D>; 4]; 4],
}

impl<const D: usize> Mollifier<D> {
    /// Of two edges; nothing where all is left.
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
        // By the edges first: c = |e|² |f|² − (e·f)².
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
