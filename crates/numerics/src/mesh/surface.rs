//! Surface meshes: segments in 2D, triangles in 3D.

use crate::{Matrix, Vector};

/// Surface mesh whose facets are oriented by the order of their vertices.
///
/// In 3D the vertices of a facet run counter-clockwise as seen from outside. In 2D the inside lies to the left of
/// the edge from the first vertex to the second, so the outward normal is `(dy, -dx)`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMesh<const D: usize> {
    /// Vertices, m.
    pub positions: Vec<Vector<D>>,
    /// Vertex numbers of each facet.
    pub facets: Vec<[u32; D]>,
}

impl<const D: usize> SurfaceMesh<D> {
    /// The vertices of a facet, m.
    pub fn corners(&self, facet: usize) -> [Vector<D>; D] {
        self.facets[facet].map(|v| self.positions[v as usize])
    }

    /// Outward area vector of a facet, m² (2D: m). Its length is the area.
    pub fn area_vector(&self, facet: usize) -> Vector<D> {
        area_vector(&self.corners(facet))
    }

    /// Area of the surface, m² (2D: length, m).
    pub fn area(&self) -> f64 {
        crate::par::sum(self.facets.len(), |f| self.area_vector(f).norm())
    }

    /// Enclosed volume by the divergence theorem, $\frac1D \oint x \cdot n\, dA$, m³ (2D: m²). Positive for a closed outward
    /// surface. Positions are relative to the first vertex to reduce cancellation.
    pub fn volume(&self) -> f64 {
        let Some(&origin) = self.positions.first() else { return 0.0 };
        let facet = |f: usize| {
            let c = self.corners(f);
            (c[0] - origin).dot(&area_vector(&c))
        };
        crate::par::sum(self.facets.len(), facet) / D as f64
    }

    /// Whether the surface is closed and consistently oriented: each ridge (2D: vertex, 3D: edge) is traversed equally
    /// often in both directions. True for an empty surface.
    pub fn is_watertight(&self) -> bool {
        self.open_ridges() == 0
    }

    /// Number of ridges (2D: vertices, 3D: edges) at which the surface is open or inconsistently oriented.
    pub fn open_ridges(&self) -> usize {
        self.ridges().chunk_by(|a, b| a.0 == b.0).filter(|c| c.iter().map(|r| r.1).sum::<i32>() != 0).count()
    }

    /// The ridges (2D: vertices, 3D: edges) of all facets with their direction of traversal, sorted.
    pub(super) fn ridges(&self) -> Vec<([u32; 2], i32)> {
        let mut ridges = Vec::with_capacity(self.facets.len() * D);
        for facet in &self.facets {
            for k in 0..D {
                ridges.push(if D == 2 {
                    ([facet[k], 0], 1 - 2 * k as i32)
                } else {
                    let (a, b) = (facet[k], facet[(k + 1) % D]);
                    ([a.min(b), a.max(b)], if a < b { 1 } else { -1 })
                });
            }
        }
        ridges.sort_unstable();
        ridges
    }

    /// The surface scaled, then rotated, then translated by `translate` (m). After a reflection the facets are
    /// flipped so that they stay outward.
    pub fn transformed(mut self, scale: f64, rotation: &Matrix<D>, translate: &Vector<D>) -> Self {
        let map = rotation * scale;
        let before = self.volume();
        self.positions.iter_mut().for_each(|p| *p = map * *p + translate);
        if before * self.volume() < 0.0 {
            self.flip();
        }
        self
    }

    /// Lower and upper corner of the bounding box, m. Inverted and infinite for an empty surface.
    pub fn bounds(&self) -> (Vector<D>, Vector<D>) {
        let start = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
        self.positions.iter().fold(start, |(l, u), p| (l.inf(p), u.sup(p)))
    }

    /// Reverses the orientation of every facet.
    pub fn flip(&mut self) {
        self.facets.iter_mut().for_each(|f| f.swap(0, 1));
    }
}

/// Outward area vector of a facet with the given corners, m² (2D: m).
pub fn area_vector<const D: usize>(corners: &[Vector<D>; D]) -> Vector<D> {
    let e = corners[1] - corners[0];
    let mut out = Vector::<D>::zeros();
    if D == 2 {
        out[0] = e[1];
        out[1] = -e[0];
    } else {
        let f = corners[D - 1] - corners[0];
        for a in 0..D {
            let (b, c) = ((a + 1) % D, (a + 2) % D);
            out[a] = 0.5 * (e[b] * f[c] - e[c] * f[b]);
        }
    }
    out
}

/// Gradients of a facet's area (2D: length) with respect to its corners, m (2D: unit vectors). Zero for a degenerate facet.
pub fn area_gradients<const D: usize>(corners: &[Vector<D>; D]) -> [Vector<D>; D] {
    let unit = |v: Vector<D>| v.try_normalize(0.0).unwrap_or(Vector::zeros());
    if D == 2 {
        let along = unit(corners[1] - corners[0]);
        return std::array::from_fn(|k| if k == 0 { -along } else { along });
    }
    let normal = unit(area_vector(corners));
    std::array::from_fn(|k| {
        // Half the opposite edge, rotated outward by 90 degrees in the facet's plane.
        let edge = corners[(k + 2) % D] - corners[(k + 1) % D];
        Vector::from_fn(|a, _| {
            let (b, c) = ((a + 1) % D, (a + 2) % D);
            0.5 * (normal[b] * edge[c] - normal[c] * edge[b])
        })
    })
}

/// Positive semidefinite part of the Hessian of a facet's area (2D: length) with respect to its corners, dimensionless
/// (2D: 1/m): `n nᵀ (∇A_i · ∇A_j) / A`. It follows from the area growth `½ ∫ |∇u|²` of a flat facet at heights `u`.
/// The remaining, mostly negative, terms are omitted. Zero for a degenerate facet.
pub fn area_hessian_psd<const D: usize>(corners: &[Vector<D>; D]) -> [[Matrix<D>; D]; D] {
    let (area, slopes) = (area_vector(corners), area_gradients(corners));
    let size = area.norm();
    let outer = if size > 0.0 { area * area.transpose() / size.powi(3) } else { Matrix::zeros() };
    std::array::from_fn(|i| std::array::from_fn(|j| outer * slopes[i].dot(&slopes[j])))
}

/// Full Hessian of a facet's area (2D: length) with respect to its corners, dimensionless (2D: 1/m). Zero for a degenerate
/// facet.
pub fn area_hessian<const D: usize>(corners: &[Vector<D>; D]) -> [[Matrix<D>; D]; D] {
    if D == 2 {
        // The Hessian of a length is nonzero only across its direction.
        return area_hessian_psd(corners);
    }
    let area = area_vector(corners);
    let size = area.norm();
    if size == 0.0 {
        return [[Matrix::zeros(); D]; D];
    }
    let normal = area / size;
    // With the opposite edges `e_i`: `2 ∂A/∂x_i = n × e_i`, and `2 ∂a/∂x_j = e_j ×` for the area vector `a = A n`.
    let edges: [Matrix<D>; D] =
        std::array::from_fn(|i| cross_matrix(&(corners[(i + 2) % D] - corners[(i + 1) % D])));
    let (turn, flat) = (cross_matrix(&normal) * 0.5, Matrix::identity() - normal * normal.transpose());
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let sign = [0.0, -1.0, 1.0][(j + D - i) % D];
            turn * sign - edges[i] * flat * edges[j] * (0.25 / size)
        })
    })
}

/// Matrix of the cross product `v ×` in 3D.
fn cross_matrix<const D: usize>(v: &Vector<D>) -> Matrix<D> {
    Matrix::from_fn(|r, c| match (c + D - r) % D {
        1 => -v[(r + 2) % D],
        2 => v[(r + 1) % D],
        _ => 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mesh_surface_of_a_square() {
        let positions = [[1.0, 1.0], [3.0, 1.0], [3.0, 2.0], [1.0, 2.0]].map(Vector::from).to_vec();
        let mut square = SurfaceMesh { positions, facets: vec![[0, 1], [1, 2], [2, 3], [3, 0]] };
        assert_eq!((square.volume(), square.area()), (2.0, 6.0));
        assert!(square.is_watertight());
        assert_eq!(square.area_vector(0), Vector::from([0.0, -2.0]));
        square.flip();
        assert_eq!(square.volume(), -2.0);
        square.facets.pop();
        assert_eq!(square.open_ridges(), 2);
    }

    #[test]
    fn mesh_surface_of_a_tetrahedron() {
        let positions =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector::from).to_vec();
        let facets = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mut tetrahedron = SurfaceMesh { positions, facets };
        assert!((tetrahedron.volume() - 1.0 / 6.0).abs() < 1e-16);
        assert!(tetrahedron.is_watertight());
        tetrahedron.facets[0].swap(0, 1);
        assert_eq!(tetrahedron.open_ridges(), 3);
    }

    #[test]
    fn areas_grow_with_heights_over_them_as_their_stiffness_says() {
        bent(&[[0.1, 0.2, 0.3], [1.1, 0.4, 0.2], [0.3, 1.2, -0.4]].map(Vector::<3>::from), &[0.3, -0.7, 0.5]);
        bent(&[[0.1, 0.2], [1.1, 0.4]].map(Vector::<2>::from), &[0.3, -0.7]);
    }

    fn bent<const D: usize>(corners: &[Vector<D>; D], heights: &[f64; D]) {
        let normal = area_vector(corners).normalize();
        let area =
            |by: f64| area_vector(&std::array::from_fn(|k| corners[k] + normal * (by * heights[k]))).norm();
        let stiffness = area_hessian_psd(corners);
        let pairs = (0..D).flat_map(|i| (0..D).map(move |j| (i, j)));
        let work: f64 =
            pairs.map(|(i, j)| heights[i] * heights[j] * normal.dot(&(stiffness[i][j] * normal))).sum();
        let exact = (area(1e-4) - 2.0 * area(0.0) + area(-1e-4)) / 1e-8;
        assert!((work - exact).abs() < 1e-6 * exact, "{work} {exact}");
    }

    #[test]
    fn areas_change_as_their_slopes_say() {
        slopes(&[[0.1, 0.2, 0.3], [1.1, 0.4, 0.2], [0.3, 1.2, -0.4]].map(Vector::<3>::from));
        slopes(&[[0.1, 0.2], [1.1, 0.4]].map(Vector::<2>::from));
    }

    fn slopes<const D: usize>(corners: &[Vector<D>; D]) {
        for (v, slope) in area_gradients(corners).iter().enumerate() {
            for a in 0..D {
                let area = |by: f64| {
                    let mut moved = *corners;
                    moved[v][a] += by;
                    area_vector(&moved).norm()
                };
                assert!((slope[a] - (area(1e-6) - area(-1e-6)) / 2e-6).abs() < 1e-9, "{v} {a}");
            }
        }
    }
}
