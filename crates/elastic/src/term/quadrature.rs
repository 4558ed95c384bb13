//! Quadrature points of the elements, each with a deformation gradient `F = Σ x_v g_vᵀ`.
//!
//! **Quadratic simplices** (`meniscus_numerics::mesh::volume::quadratic`) have the symmetric rule of degree 2 (P. Hammer, O.
//! Marlowe & A. Stroud, "Numerical integration over simplexes and cones", 1956) with `D + 1` points, one towards each corner, at
//! the barycentric coordinates
//!
//! ```text
//! 2D: (2/3, 1/6, 1/6),        3D: ((5 + 3 √5)/20, (5 − √5)/20, (5 − √5)/20, (5 − √5)/20),        weights 1/(D + 1)
//! ```
//!
//! In a simplex with straight edges strains are linear and the rule integrates their squares exactly: the stiffness has full rank,
//! and only rigid motions have no energy. Displacements of bending at constant curvature are quadratic for any Poisson's ratio, so
//! any mesh represents them, even with a single layer of elements.
//!
//! **Changes of volume** lock where Poisson's ratio is close to ½, since there are as many constraints as unknowns. Simplices are
//! therefore paired with a neighbour ([`pair_simplices`]), and `λ` resists only the part of the change that is linear in the pair.
//! At the points `q` of an element it is
//!
//! ```text
//! θ_q = Σ_r W_qr j_r,        W_qr = b_q · (Σ_s v_s b_s b_sᵀ)⁻¹ b_r v_r,        b = (1, X)
//! ```
//!
//! with the changes `j_r` at its points and their volumes `v_r`. This is the projection onto linear functions of the rest position
//! `X`, which suffice for bending. The corresponding pressure is that of the Q2/P1 element with discontinuous pressure, which
//! neither locks nor oscillates (Boffi, Brezzi & Fortin, "Mixed Finite Element Methods", 2013, §8.6), with pairs of simplices in
//! place of squares. A simplex without a partner keeps all its changes, which are already linear.
//!
//! **Linear simplices** have one point each. They bend only by shearing: a plate of two layers is 1.9 times too stiff at ν = 0.3.
//! They serve for comparisons and for problems without bending.

use super::energy_density::{Lame, cofactor, determinant};
use crate::ElasticError;
use crate::linalg::Cliques;
use meniscus_numerics::mesh::surface::area_vector;
use meniscus_numerics::mesh::volume::quadratic::shape_function_gradients;
use meniscus_numerics::mesh::volume::{ElementOrder, QuadraticSimplex};
use meniscus_numerics::mesh::{Simplex, VolumeMesh};
use meniscus_numerics::{Matrix, Vector};
use nalgebra::DMatrix;
use std::ops::Range;

/// Resolution of facet sizes, over the largest: equal facets of lattices differ by rounding.
const FACET_SIZE_TOLERANCE: f64 = 1e-6;

/// Quadrature points in the elements of a solid.
#[derive(Clone, Debug, Default)]
pub(crate) struct QuadraturePoints<const D: usize> {
    /// Vertices of each element.
    pub elements: Cliques,
    /// End of the points of each element.
    point_ends: Vec<usize>,
    /// Element of each point, and the start of its gradients.
    point_elements: Vec<(u32, usize)>,
    /// Gradients `g_v`, 1/m, in the order of the vertices of the point's element.
    gradients: Vec<Vector<D>>,
    /// Volume of each point, m³ (2D: m²).
    pub volumes: Vec<f64>,
    /// Matrices `W` of the elements, one after another.
    projections: Vec<f64>,
    /// Start of the matrix of each element.
    projection_starts: Vec<usize>,
    /// Lamé parameters of each element.
    lame: Vec<Lame>,
}

/// A quadrature point: gradients of some vertices, 1/m, its volume, m³ (2D: m²), and its rest position, m.
struct QuadraturePoint<const D: usize> {
    gradients: Vec<(u32, Vector<D>)>,
    volume: f64,
    rest_position: Vector<D>,
}

impl<const D: usize> QuadraturePoints<D> {
    /// Points of a solid with uniform Lamé parameters.
    ///
    /// # Errors
    /// [`ElasticError::NotQuadratic`] and [`ElasticError::Folded`].
    pub fn new(mesh: &VolumeMesh<D>, lame: Lame, order: ElementOrder) -> Result<Self, ElasticError> {
        match order {
            ElementOrder::Linear => Ok(Self::linear(mesh, vec![lame; mesh.simplices.len()])),
            ElementOrder::Quadratic => Self::quadratic(mesh, lame),
        }
    }

    /// Points of linear simplices, each with its own Lamé parameters.
    pub fn linear(mesh: &VolumeMesh<D>, lame: Vec<Lame>) -> Self {
        let mut points = Self::default();
        for (simplex, lame) in mesh.simplices.iter().zip(lame) {
            let across = inverse_transposed(&simplex.edges(&mesh.positions));
            let sum: Vector<D> = across.column_iter().map(|c| c.into_owned()).sum();
            let mut gradients = vec![(simplex.root, -sum)];
            gradients.extend((0..D).map(|k| (simplex.others[k], across.column(k).into_owned())));
            let (volume, rest_position) = (simplex.volume(&mesh.positions), simplex.center(&mesh.positions));
            points.push(&[QuadraturePoint { gradients, volume, rest_position }], lame);
        }
        points
    }

    fn quadratic(mesh: &VolumeMesh<D>, lame: Lame) -> Result<Self, ElasticError> {
        let parents = mesh.quadratic_simplices().ok_or(ElasticError::NotQuadratic)?;
        let reference: Vec<(Vec<f64>, Vec<Vector<D>>)> = (0..=D)
            .map(|k| {
                (quadrature_coordinates::<D>(k), shape_function_gradients(&quadrature_coordinates::<D>(k)))
            })
            .collect();
        let mut points = Self::default();
        for element in pair_simplices(mesh, &parents) {
            let mut own = Vec::new();
            for number in element {
                for (at, slopes) in &reference {
                    let point = quadrature_point(&parents[number], at, slopes, mesh);
                    own.push(point.ok_or(ElasticError::Folded { element: number })?);
                }
            }
            points.push(&own, lame);
        }
        Ok(points)
    }

    /// Adds an element.
    fn push(&mut self, points: &[QuadraturePoint<D>], lame: Lame) {
        let mut vertices: Vec<u32> = points.iter().flat_map(|p| p.gradients.iter().map(|g| g.0)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        for point in points {
            self.point_elements.push((self.point_ends.len() as u32, self.gradients.len()));
            let gradient =
                |v: &u32| point.gradients.iter().find(|g| g.0 == *v).map_or_else(Vector::zeros, |g| g.1);
            self.gradients.extend(vertices.iter().map(gradient));
            self.volumes.push(point.volume);
        }
        self.elements.push(vertices);
        self.point_ends.push(self.volumes.len());
        self.projection_starts.push(self.projections.len());
        self.projections.extend(projection_matrix(points));
        self.lame.push(lame);
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.volumes.len()
    }

    /// Points of an element.
    pub fn points_of(&self, element: usize) -> Range<usize> {
        let start = if element == 0 { 0 } else { self.point_ends[element - 1] };
        start..self.point_ends[element]
    }

    /// The matrix `W` of an element, row by row.
    pub fn projection(&self, element: usize) -> &[f64] {
        let count = self.points_of(element).len();
        &self.projections[self.projection_starts[element]..self.projection_starts[element] + count * count]
    }

    /// Lamé parameters of an element.
    pub fn lame(&self, element: usize) -> Lame {
        self.lame[element]
    }

    /// Vertices and gradients of a point.
    pub fn shape_gradients(&self, k: usize) -> (&[u32], &[Vector<D>]) {
        let (element, start) = self.point_elements[k];
        let vertices = self.elements.get(element as usize);
        (vertices, &self.gradients[start..start + vertices.len()])
    }

    /// `F = Σ x_v g_vᵀ`, computed from differences of positions so that it does not depend on the position of the solid.
    pub fn deformation_gradient(&self, k: usize, x: &[Vector<D>]) -> Matrix<D> {
        let (vertices, gradients) = self.shape_gradients(k);
        let first = x[vertices[0] as usize];
        let ahead = vertices.iter().zip(gradients).skip(1);
        ahead.fold(Matrix::zeros(), |f, (v, g)| f + (x[*v as usize] - first) * g.transpose())
    }
}

/// Barycentric coordinates of the point towards a corner.
fn quadrature_coordinates<const D: usize>(corner: usize) -> Vec<f64> {
    let far = if D == 2 { 1.0 / 6.0 } else { (5.0 - 5f64.sqrt()) / 20.0 };
    (0..=D).map(|i| if i == corner { 1.0 - D as f64 * far } else { far }).collect()
}

/// Quadrature point of a quadratic simplex at barycentric coordinates; `None` where it has no positive volume.
fn quadrature_point<const D: usize>(
    parent: &QuadraticSimplex<D>,
    at: &[f64],
    slopes: &[Vector<D>],
    mesh: &VolumeMesh<D>,
) -> Option<QuadraturePoint<D>> {
    let jacobian = parent.jacobian(slopes, &mesh.positions);
    // Volume of the unit simplex, shared among the points.
    let unit = if D == 2 { 0.5 } else { 1.0 / 6.0 };
    let volume = determinant(&jacobian) * unit / (D + 1) as f64;
    if volume.is_nan() || volume <= 0.0 {
        return None;
    }
    let across = inverse_transposed(&jacobian);
    let gradients = parent.nodes().iter().zip(slopes).map(|(v, s)| (*v, across * s)).collect();
    // Interpolated between the corners: in a curved simplex the projection is onto functions linear without the curves.
    let corners = parent.nodes().iter().zip(at);
    Some(QuadraturePoint {
        gradients,
        volume,
        rest_position: corners.map(|(v, b)| mesh.positions[*v as usize] * *b).sum(),
    })
}

/// Pairs of quadratic simplices that share a facet, and the remaining simplices. Facets are visited in descending size; each pairs
/// its two simplices if neither has a partner.
fn pair_simplices<const D: usize>(mesh: &VolumeMesh<D>, parents: &[QuadraticSimplex<D>]) -> Vec<Vec<usize>> {
    let mut facets: Vec<([u32; D], usize)> = Vec::new();
    for (number, parent) in parents.iter().enumerate() {
        for left_out in 0..=D {
            let mut corners = (0..=D).filter(|k| *k != left_out).map(|k| parent.nodes()[k]);
            let mut facet: [u32; D] = std::array::from_fn(|_| corners.next().unwrap_or(0));
            facet.sort_unstable();
            facets.push((facet, number));
        }
    }
    facets.sort_unstable();
    let size = |facet: &[u32; D]| area_vector(&facet.map(|v| mesh.positions[v as usize])).norm();
    let largest = facets.iter().map(|f| size(&f.0)).fold(0.0, f64::max);
    let shared = facets.chunk_by(|a, b| a.0 == b.0).filter(|both| both.len() == 2);
    let sized = |both: &[([u32; D], usize)]| {
        ((size(&both[0].0) / largest / FACET_SIZE_TOLERANCE).round() as u64, both[0].1, both[1].1)
    };
    let mut shared: Vec<(u64, usize, usize)> = shared.map(sized).collect();
    shared.sort_unstable_by(|a, b| b.0.cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut partner: Vec<Option<usize>> = vec![None; parents.len()];
    for (_, a, b) in shared {
        if partner[a].is_none() && partner[b].is_none() {
            (partner[a], partner[b]) = (Some(b), Some(a));
        }
    }
    let element = |a: usize| match partner[a] {
        Some(b) if b < a => None,
        Some(b) => Some(vec![a, b]),
        None => Some(vec![a]),
    };
    (0..parents.len()).filter_map(element).collect()
}

/// Matrix `W` of an element, row by row; the identity where there are no more points than linear functions.
fn projection_matrix<const D: usize>(points: &[QuadraturePoint<D>]) -> Vec<f64> {
    let count = points.len();
    let unit = || DMatrix::<f64>::identity(count, count);
    let mean = points.iter().map(|p| p.rest_position).sum::<Vector<D>>() / count as f64;
    let size = points.iter().map(|p| (p.rest_position - mean).norm()).fold(0.0, f64::max);
    let basis = DMatrix::from_fn(count, D + 1, |q, a| {
        if a == 0 { 1.0 } else { (points[q].rest_position - mean)[a - 1] / size }
    });
    let volumes = DMatrix::from_fn(D + 1, count, |a, q| basis[(q, a)] * points[q].volume);
    let inverse = if count > D + 1 { (&volumes * &basis).try_inverse() } else { None };
    let matrix = inverse.map_or_else(unit, |inverse| &basis * inverse * &volumes);
    (0..count * count).map(|k| matrix[(k / count, k % count)]).collect()
}

fn inverse_transposed<const D: usize>(m: &Matrix<D>) -> Matrix<D> {
    cofactor(m) / determinant(m)
}

/// Mean square edge length of an element, m².
pub(crate) fn mean_square_edge<const D: usize>(mesh: &VolumeMesh<D>, simplex: &Simplex<D>) -> f64 {
    let at: Vec<Vector<D>> = simplex.vertices().map(|v| mesh.positions[v as usize]).collect();
    let all: f64 = at.iter().flat_map(|a| at.iter().map(move |b| (a - b).norm_squared())).sum();
    all / (D * (D + 1)) as f64
}
