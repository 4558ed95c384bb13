//! Where the strain of a body is evaluated: points in its elements, each with a deformation gradient `F = Σ x_v g_vᵀ` of its own.
//!
//! **Quadratic simplices** (`meniscus_numerics::mesh::volume::quadratic`) have the points of the rule of degree 2 that is as symmetric
//! as they are (P. Hammer, O. Marlowe & A. Stroud, "Numerical integration over simplexes and cones", 1956): `D + 1`, one towards each
//! corner, at the barycentric coordinates
//!
//! ```text
//! 2D: (2/3, 1/6, 1/6),        3D: ((5 + 3 √5)/20, (5 − √5)/20, (5 − √5)/20, (5 − √5)/20),        weights 1/(D + 1)
//! ```
//!
//! Strains are linear in a simplex with straight edges, and their squares integrated exactly: the stiffness has full rank, and no
//! motion but a rigid one is without energy. Displacements of bending at constant curvature are quadratic, whatever Poisson's ratio is,
//! so that any mesh holds them, of one layer of elements too. Limit: where curvature changes along a beam of one layer that can
//! hardly change its volume (ν = 0.49), its deflection is 9 % too small in 2D, with two layers 3 % (`tests/elements.rs`).
//!
//! **Linear simplices** have one strain each. They bend by shearing only: a plate of two layers is 1.9 times too stiff at ν = 0.3.
//! They are for comparisons, and for what has no bending.

use super::density::{Lame, cofactor, determinant};
use crate::ElasticError;
use crate::linalg::Cliques;
use meniscus_numerics::mesh::volume::quadratic::slopes;
use meniscus_numerics::mesh::volume::{Order, Parent};
use meniscus_numerics::mesh::{Simplex, VolumeMesh};
use meniscus_numerics::{Matrix, Vector};

/// Points in the elements of a body.
#[derive(Clone, Debug)]
pub(crate) struct Points<const D: usize> {
    /// The vertices of each element.
    pub elements: Cliques,
    /// Points in each element.
    pub per: usize,
    /// The gradients `g_v` at each point, 1/m: for each element those of its first point, in the order of its vertices, and so on.
    gradients: Vec<Vector<D>>,
    /// Volume that a point stands for, m³ (2D: m²).
    pub volumes: Vec<f64>,
    /// Elasticity of each element.
    pub lame: Vec<Lame>,
}

impl<const D: usize> Points<D> {
    /// Of a body of one elasticity.
    ///
    /// # Errors
    /// [`ElasticError::NotDivided`] and [`ElasticError::Folded`].
    pub fn new(mesh: &VolumeMesh<D>, lame: Lame, order: Order) -> Result<Self, ElasticError> {
        match order {
            Order::Linear => Ok(Self::linear(mesh, vec![lame; mesh.simplices.len()])),
            Order::Quadratic => Self::quadratic(mesh, lame),
        }
    }

    /// Of linear simplices, each with an elasticity.
    pub fn linear(mesh: &VolumeMesh<D>, lame: Vec<Lame>) -> Self {
        let mut points =
            Self { elements: Cliques::default(), per: 1, gradients: Vec::new(), volumes: Vec::new(), lame };
        for simplex in &mesh.simplices {
            let across = inverse_transposed(&simplex.edges(&mesh.positions));
            let sum: Vector<D> = across.column_iter().map(|c| c.into_owned()).sum();
            points.elements.push(simplex.vertices());
            points.gradients.push(-sum);
            points.gradients.extend(across.column_iter().map(|c| c.into_owned()));
            points.volumes.push(simplex.volume(&mesh.positions));
        }
        points
    }

    fn quadratic(mesh: &VolumeMesh<D>, lame: Lame) -> Result<Self, ElasticError> {
        let parents = mesh.parents().ok_or(ElasticError::NotDivided)?;
        let mut points = Self {
            elements: Cliques::default(),
            per: D + 1,
            gradients: Vec::new(),
            volumes: Vec::new(),
            lame: vec![lame; parents.len()],
        };
        let reference: Vec<Vec<Vector<D>>> = (0..=D).map(|k| slopes(&place::<D>(k))).collect();
        for (number, parent) in parents.iter().enumerate() {
            points.elements.push(parent.nodes().iter().copied());
            for slopes in &reference {
                points.add(parent, slopes, mesh).ok_or(ElasticError::Folded { element: number })?;
            }
        }
        Ok(points)
    }

    /// Adds a point of a quadratic simplex; nothing where it has no volume.
    fn add(&mut self, parent: &Parent<D>, slopes: &[Vector<D>], mesh: &VolumeMesh<D>) -> Option<()> {
        let jacobian = parent.jacobian(slopes, &mesh.positions);
        // Of the unit simplex, shared among the points.
        let simplex = if D == 2 { 2.0 } else { 6.0 };
        let volume = determinant(&jacobian) / (simplex * (D + 1) as f64);
        if volume.is_nan() || volume <= 0.0 {
            return None;
        }
        let across = inverse_transposed(&jacobian);
        self.gradients.extend(slopes.iter().map(|s| across * s));
        self.volumes.push(volume);
        Some(())
    }

    /// The number of points.
    pub fn len(&self) -> usize {
        self.volumes.len()
    }

    /// Vertices and gradients of a point.
    pub fn part(&self, k: usize) -> (&[u32], &[Vector<D>]) {
        let (element, point) = (k / self.per, k % self.per);
        let range = self.elements.range(element);
        let start = range.start * self.per + point * range.len();
        (self.elements.get(element), &self.gradients[start..start + range.len()])
    }

    /// `F = Σ x_v g_vᵀ`; differences of positions, so that it is the same wherever the body is.
    pub fn gradient(&self, k: usize, x: &[Vector<D>]) -> Matrix<D> {
        let (vertices, gradients) = self.part(k);
        let first = x[vertices[0] as usize];
        let ahead = vertices.iter().zip(gradients).skip(1);
        ahead.fold(Matrix::zeros(), |f, (v, g)| f + (x[*v as usize] - first) * g.transpose())
    }

    /// Elasticity at a point.
    pub fn lame(&self, k: usize) -> Lame {
        self.lame[k / self.per]
    }
}

/// Barycentric coordinates of the point towards a corner.
fn place<const D: usize>(corner: usize) -> Vec<f64> {
    let far = if D == 2 { 1.0 / 6.0 } else { (5.0 - 5f64.sqrt()) / 20.0 };
    (0..=D).map(|i| if i == corner { 1.0 - D as f64 * far } else { far }).collect()
}

fn inverse_transposed<const D: usize>(m: &Matrix<D>) -> Matrix<D> {
    cofactor(m) / determinant(m)
}

/// The mean square of an element's edges, m².
pub(crate) fn mean_square_edge<const D: usize>(mesh: &VolumeMesh<D>, simplex: &Simplex<D>) -> f64 {
    let at: Vec<Vector<D>> = simplex.vertices().map(|v| mesh.positions[v as usize]).collect();
    let all: f64 = at.iter().flat_map(|a| at.iter().map(move |b| (a - b).norm_squared())).sum();
    all / (D * (D + 1)) as f64
}
