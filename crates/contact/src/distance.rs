//! Distances between a point and a facet, and between two edges.
//!
//! For coordinates `λ` on both features the separation is linear in the positions `x_k`, `r = Σ_k w_k(λ) x_k`, and the squared distance
//! is `s = min_λ |r|²`. Its gradient is `∂s/∂x_k = 2 w_k r`, since `λ` is a minimum. Its Hessian is that of `|r|²` minus `C G⁻¹ Cᵀ`,
//! with the second derivatives `G` with respect to `λ` and `C` with respect to `x` and `λ`. The formula holds for all pairs of
//! vertices, edges and faces.

use meniscus_numerics::Vector;

/// Kinds of pairs of features.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum StencilKind {
    /// A point and a segment, a facet in 2D.
    PointSegment,
    /// A point and a triangle, a facet in 3D.
    PointTriangle,
    /// Two edges in 3D.
    EdgeEdge,
}

/// Two features, given by their points; the point comes before the facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Stencil {
    /// Kind of the pair.
    pub kind: StencilKind,
    /// Points; a point and a segment use the first three.
    pub points: [u32; 4],
}

impl Stencil {
    /// A point and a facet of 2 points in 2D and 3 in 3D.
    pub fn point_facet<const D: usize>(point: u32, facet: &[u32; D]) -> Self {
        let mut points = [point, 0, 0, 0];
        points[1..=D].copy_from_slice(facet);
        Self { kind: if D == 2 { StencilKind::PointSegment } else { StencilKind::PointTriangle }, points }
    }

    /// Two edges.
    pub fn edge_edge(first: [u32; 2], second: [u32; 2]) -> Self {
        Self { kind: StencilKind::EdgeEdge, points: [first[0], first[1], second[0], second[1]] }
    }

    /// Points of both features.
    pub fn points(&self) -> &[u32] {
        &self.points[..self.kind.point_count()]
    }

    /// Positions of the points in `x`, followed by zeros.
    pub fn positions<const D: usize>(&self, x: &[Vector<D>]) -> [Vector<D>; 4] {
        let mut at = [Vector::zeros(); 4];
        at.iter_mut().zip(self.points()).for_each(|(at, p)| *at = x[*p as usize]);
        at
    }
}

impl StencilKind {
    /// Number of points.
    pub fn point_count(self) -> usize {
        if self == Self::PointSegment { 3 } else { 4 }
    }

    /// Number of points of the first feature.
    pub fn first_count(self) -> usize {
        if self == Self::EdgeEdge { 2 } else { 1 }
    }

    /// Upper bound on the decrease of the distance, m, when the points move along `ways`.
    pub fn relative_motion<const D: usize>(self, ways: &[Vector<D>; 4]) -> f64 {
        let ways = &ways[..self.point_count()];
        let mean: Vector<D> = ways.iter().sum::<Vector<D>>() / ways.len() as f64;
        let longest = |part: &[Vector<D>]| part.iter().map(|w| (w - mean).norm()).fold(0.0, f64::max);
        longest(&ways[..self.first_count()]) + longest(&ways[self.first_count()..])
    }

    /// Distance between the bounding boxes of two features, m: a lower bound on their distance.
    pub fn least_distance<const D: usize>(self, x: &[Vector<D>; 4]) -> f64 {
        let (first, second) = x[..self.point_count()].split_at(self.first_count());
        let bounds = |part: &[Vector<D>]| {
            part[1..].iter().fold([part[0]; 2], |[low, high], x| [low.inf(x), high.sup(x)])
        };
        let ([low, high], [below, above]) = (bounds(first), bounds(second));
        (low - above).sup(&(below - high)).sup(&Vector::zeros()).norm()
    }
}

/// Weights of four points.
type Weights = [f64; 4];

/// Closest points of two features.
#[derive(Clone, Copy, Debug)]
pub struct ClosestPair<const D: usize> {
    /// Vector from the closest point on the second feature to that on the first, m: `Σ_k w_k x_k`.
    pub separation: Vector<D>,
    /// Weights `w_k`. Those of the first feature sum to 1, those of the second to -1.
    pub weights: Weights,
    /// Derivatives of the weights with respect to each free coordinate, and the number of free coordinates.
    free_directions: [Weights; 2],
    free_count: usize,
}

impl<const D: usize> ClosestPair<D> {
    /// Closest points of two features with their points at `x`.
    pub fn new(kind: StencilKind, x: &[Vector<D>; 4]) -> Self {
        let nearest = |pairs: &[(usize, [usize; 2])]| {
            let all = pairs.iter().map(|(p, edge)| Self::point_edge(x, *p, *edge));
            all.reduce(
                |best, next| if next.squared_distance() < best.squared_distance() { next } else { best },
            )
        };
        let (within, rim) = match kind {
            StencilKind::PointSegment => (None, None),
            StencilKind::PointTriangle => {
                (Self::within_triangle(x), nearest(&[(0, [1, 2]), (0, [2, 3]), (0, [3, 1])]))
            }
            StencilKind::EdgeEdge => {
                let ends = nearest(&[(0, [2, 3]), (1, [2, 3]), (2, [0, 1]), (3, [0, 1])]);
                (Self::within_edges(x), ends.map(Self::oriented_to_first))
            }
        };
        // The interior solution of flat triangles and parallel edges has large rounding errors; then it is not the nearest.
        let both = [within, rim].into_iter().flatten();
        let nearer = both.reduce(|a, b| if b.squared_distance() < a.squared_distance() { b } else { a });
        nearer.unwrap_or_else(|| Self::point_edge(x, 0, [1, 2]))
    }

    fn from_weights(x: &[Vector<D>; 4], weights: Weights, free: &[Weights]) -> Self {
        let separation = x.iter().zip(weights).map(|(x, w)| x * w).sum();
        let mut all = [[0.0; 4]; 2];
        all.iter_mut().zip(free).for_each(|(to, from)| *to = *from);
        Self { separation, weights, free_directions: all, free_count: free.len() }
    }

    /// Squared distance, m².
    pub fn squared_distance(&self) -> f64 {
        self.separation.norm_squared()
    }

    /// Distance, m.
    pub fn distance(&self) -> f64 {
        self.separation.norm()
    }

    fn point_edge(x: &[Vector<D>; 4], p: usize, [a, b]: [usize; 2]) -> Self {
        let edge = x[b] - x[a];
        let along = ((x[p] - x[a]).dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
        // An edge of zero length is its first point.
        let along = if along.is_nan() { 0.0 } else { along };
        let mut weights = [0.0; 4];
        (weights[p], weights[a], weights[b]) = (1.0, along - 1.0, -along);
        let mut free = [0.0; 4];
        (free[a], free[b]) = (1.0, -1.0);
        let inside = along > 0.0 && along < 1.0;
        Self::from_weights(x, weights, if inside { std::slice::from_ref(&free) } else { &[] })
    }

    /// Closest points if the projection of the point lies inside the triangle.
    fn within_triangle(x: &[Vector<D>; 4]) -> Option<Self> {
        let free = [[0.0, 1.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0]];
        let [s, t] = minimising_coordinates(x, [1.0, -1.0, 0.0, 0.0], &free)?;
        let inside = s > 0.0 && t > 0.0 && s + t < 1.0;
        inside.then(|| Self::from_weights(x, [1.0, s + t - 1.0, -s, -t], &free))
    }

    /// Closest points if both lie inside the edges.
    fn within_edges(x: &[Vector<D>; 4]) -> Option<Self> {
        let free = [[-1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]];
        let [s, t] = minimising_coordinates(x, [1.0, 0.0, -1.0, 0.0], &free)?;
        let inside = s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0;
        inside.then(|| Self::from_weights(x, [1.0 - s, s, t - 1.0, -t], &free))
    }

    /// The same with the first two points as the first feature.
    fn oriented_to_first(self) -> Self {
        if self.weights[0] + self.weights[1] > 0.0 {
            return self;
        }
        let turned = |w: Weights| w.map(|w| -w);
        Self {
            separation: -self.separation,
            weights: turned(self.weights),
            free_directions: self.free_directions.map(turned),
            ..self
        }
    }

    /// Second derivative of the squared distance with respect to the positions of points `k` and `l`.
    pub fn squared_distance_hessian(
        &self,
        x: &[Vector<D>; 4],
    ) -> impl Fn(usize, usize) -> meniscus_numerics::Matrix<D> + use<D> {
        use meniscus_numerics::Matrix;
        let along: [Vector<D>; 2] = self
            .free_directions
            .map(|free_directions| x.iter().zip(free_directions).map(|(x, q)| x * q).sum());
        let inverse = inverse_gram(&along, self.free_count);
        let Self { separation, weights, free_directions, free_count } = *self;
        // Half the mixed derivative with respect to a point and a coordinate, times a vector.
        let mixed = move |k: usize, i: usize, to: &Vector<D>| -> Matrix<D> {
            // (w_k E_i + q_ik r) toᵀ
            (along[i] * weights[k] + separation * free_directions[i][k]) * to.transpose()
        };
        move |k, l| {
            let mut block = Matrix::identity() * (2.0 * weights[k] * weights[l]);
            for i in 0..free_count {
                for j in 0..free_count {
                    let to = along[j] * weights[l] + separation * free_directions[j][l];
                    block -= mixed(k, i, &to) * (2.0 * inverse[i][j]);
                }
            }
            block
        }
    }
}

/// Inverse of the Gram matrix of the first `count` vectors.
fn inverse_gram<const D: usize>(along: &[Vector<D>; 2], count: usize) -> [[f64; 2]; 2] {
    let (a, b, c) = (along[0].norm_squared(), along[1].norm_squared(), along[0].dot(&along[1]));
    match count {
        0 => [[0.0; 2]; 2],
        1 => [[1.0 / a, 0.0], [0.0; 2]],
        _ => {
            let determinant = a * b - c * c;
            [[b / determinant, -c / determinant], [-c / determinant, a / determinant]]
        }
    }
}

/// Coordinates that minimise `|Σ_k (w_k + λ_1 q_1k + λ_2 q_2k) x_k|`; `None` where they are not finite.
fn minimising_coordinates<const D: usize>(
    x: &[Vector<D>; 4],
    weights: Weights,
    free: &[Weights; 2],
) -> Option<[f64; 2]> {
    let sum = |w: &Weights| -> Vector<D> { x.iter().zip(w).map(|(x, w)| x * *w).sum() };
    let (start, along) = (sum(&weights), free.each_ref().map(sum));
    let inverse = inverse_gram(&along, 2);
    let slopes = along.map(|e| -e.dot(&start));
    let at = [0, 1].map(|i| inverse[i][0] * slopes[0] + inverse[i][1] * slopes[1]);
    at.iter().all(|l| l.is_finite()).then_some(at)
}
