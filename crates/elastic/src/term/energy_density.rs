//! Energy densities of isotropic solids as functions of the deformation gradient, and their tangents.

use super::TangentWeights;
use crate::linalg::{Svd, axis_pairs, svd, symmetric_eigen};
use meniscus_numerics::{Matrix, Vector};
use std::fmt::Debug;

/// Lamé's parameters, Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lame {
    /// First parameter `λ`.
    pub lambda: f64,
    /// Shear modulus `μ`.
    pub mu: f64,
}

impl Lame {
    /// Converts Young's modulus, Pa, and Poisson's ratio, between -1 and 0.5.
    pub fn new(young: f64, poisson: f64) -> Self {
        let mu = 0.5 * young / (1.0 + poisson);
        Self { lambda: 2.0 * mu * poisson / (1.0 - 2.0 * poisson), mu }
    }
}

/// Second derivatives of an energy density in the principal frame of the deformation.
#[derive(Clone, Copy, Debug)]
pub struct PrincipalHessian<const D: usize> {
    /// With respect to the principal stretches, Pa.
    pub stretch: Matrix<D>,
    /// For each pair of axes `i < j`, in the order (0,1), (0,2), (1,2), in the direction `(e_i e_jᵀ + e_j e_iᵀ)/√2`:
    /// `(Ψ_i − Ψ_j)/(σ_i − σ_j)`, Pa.
    pub shear: [f64; 3],
    /// In the direction `(e_i e_jᵀ − e_j e_iᵀ)/√2`: `(Ψ_i + Ψ_j)/(σ_i + σ_j)`, Pa.
    pub twist: [f64; 3],
}

/// An isotropic energy density `Ψ(F) + U(θ)`. Without strain its second derivatives are those of Hooke's law. Elements evaluate the
/// volumetric part `U`, which would lock them near incompressibility, for a projection `θ` of the changes of volume `j(F)`.
pub trait EnergyDensity<const D: usize>: Debug + Send + Sync {
    /// Whether there is a volumetric part `U`.
    const HAS_VOLUMETRIC: bool = false;

    /// `Ψ`, Pa.
    fn energy(&self, lame: Lame, f: &Matrix<D>) -> f64;

    /// First Piola–Kirchhoff stress `∂Ψ/∂F`, Pa.
    fn stress(&self, lame: Lame, f: &Matrix<D>) -> Matrix<D>;

    /// Second derivatives of `Ψ + p j` at the stretches `σ`; the last stretch is negative in inverted elements; `p` in Pa.
    fn principal_hessian(&self, lame: Lame, stretches: &Vector<D>, pressure: f64) -> PrincipalHessian<D>;

    /// Change of volume `j`, zero at rest.
    fn volume_change(&self, _: &Matrix<D>) -> f64 {
        0.0
    }

    /// `∂j/∂F`.
    fn volume_change_gradient(&self, _: &Matrix<D>) -> Matrix<D> {
        Matrix::zeros()
    }

    /// `U` and its first and second derivatives, Pa.
    fn volumetric_energy(&self, _: Lame, _: f64) -> [f64; 3] {
        [0.0; 3]
    }

    /// Whether energy, stress and their derivatives all vanish at `F`.
    fn is_inactive(&self, _: &Matrix<D>) -> bool {
        false
    }
}

/// Quadratic form on changes of `F`: the sum of `wₘ (Eₘ : δF)²` over modes `Eₘ`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tangent<const D: usize> {
    /// `Σ wₘ (Eₘ)_ij (Eₘ)_kl`: for each pair of columns `j` and `l` the matrix with the indices `i` and `k`.
    columns: [[Matrix<D>; D]; D],
}

impl<const D: usize> Tangent<D> {
    /// Tangent at `F`: the Hessian of `Ψ + p j` with the pressure `p`, or its positive part, and Hooke's law without `λ` for rates of
    /// the Green strain.
    ///
    /// The eigenvectors of an isotropic density's Hessian are known except those of the stretches (Smith et al. 2019, "Analytic
    /// eigensystems for isotropic distortion energies").
    pub fn new(
        density: &impl EnergyDensity<D>,
        lame: Lame,
        f: &Matrix<D>,
        pressure: f64,
        weights: TangentWeights,
    ) -> Self {
        let mut tangent = Self { columns: [[Matrix::zeros(); D]; D] };
        if weights.stiffness != 0.0 {
            let frame = svd(f);
            let principal = density.principal_hessian(lame, &frame.values, pressure);
            tangent.add_stiffness(&frame, &principal, weights);
        }
        if weights.viscosity != 0.0 {
            tangent.add_viscosity(lame, f, weights.viscosity);
        }
        tangent.symmetrise();
        tangent
    }

    /// For changes `δF = u gᵀ`: the matrices that map `u` to each column of the change of stress.
    pub fn along(&self, g: &Vector<D>) -> [Matrix<D>; D] {
        self.columns.map(|row| row.iter().zip(g.iter()).map(|(block, g)| block * *g).sum())
    }

    /// Adds a mode to the columns `j ≤ l`.
    fn add_mode(&mut self, weight: f64, direction: Matrix<D>) {
        for j in 0..D {
            let column = direction.column(j) * weight;
            for l in j..D {
                self.columns[j][l] += column * direction.column(l).transpose();
            }
        }
    }

    fn symmetrise(&mut self) {
        for (j, l) in axis_pairs::<D>() {
            self.columns[l][j] = self.columns[j][l].transpose();
        }
    }

    fn add_stiffness(&mut self, frame: &Svd<D>, principal: &PrincipalHessian<D>, weights: TangentWeights) {
        let TangentWeights { stiffness: weight, project_psd, .. } = weights;
        let counts = |value: f64| value > 0.0 || value != 0.0 && !project_psd;
        let (values, vectors) = symmetric_eigen(&principal.stretch);
        for k in 0..D {
            if counts(values[k]) {
                let along = Matrix::from_diagonal(&vectors.column(k).into_owned());
                self.add_mode(weight * values[k], frame.u * along * frame.v.transpose());
            }
        }
        for (k, (i, j)) in axis_pairs::<D>().enumerate() {
            let ij = frame.u.column(i) * frame.v.column(j).transpose();
            let ji = frame.u.column(j) * frame.v.column(i).transpose();
            for (value, direction) in [(principal.shear[k], ij + ji), (principal.twist[k], ij - ji)] {
                if counts(value) {
                    self.add_mode(0.5 * weight * value, direction);
                }
            }
        }
    }

    fn add_viscosity(&mut self, lame: Lame, f: &Matrix<D>, weight: f64) {
        for a in 0..D {
            let column = Vector::<D>::from_fn(|r, _| f64::from(r == a));
            self.add_mode(2.0 * weight * lame.mu, f.column(a) * column.transpose());
        }
        for (i, j) in axis_pairs::<D>() {
            let mut direction = Matrix::<D>::zeros();
            direction.set_column(i, &f.column(j));
            direction.set_column(j, &f.column(i));
            self.add_mode(weight * lame.mu, direction);
        }
    }
}

/// `det F − 1`, without loss of small strains to rounding.
pub(crate) fn dilation<const D: usize>(f: &Matrix<D>) -> f64 {
    let g = f - Matrix::identity();
    g.trace() + nonlinear_dilation(&g)
}

/// `det (1 + G) − 1 − tr G`.
pub(crate) fn nonlinear_dilation<const D: usize>(g: &Matrix<D>) -> f64 {
    let trace = g.trace();
    let second = 0.5 * (trace * trace - (g * g).trace());
    if D == 2 { second } else { second + determinant(g) }
}

/// The determinant.
pub(crate) fn determinant<const D: usize>(f: &Matrix<D>) -> f64 {
    f.component_mul(&cofactor(f)).column(0).sum()
}

/// Cofactor matrix, the derivative of the determinant.
pub(crate) fn cofactor<const D: usize>(f: &Matrix<D>) -> Matrix<D> {
    if D == 2 {
        return Matrix::from_fn(|r, c| if r == c { f[(1 - r, 1 - c)] } else { -f[(1 - r, 1 - c)] });
    }
    Matrix::from_fn(|r, c| {
        let [(a, b), (p, q)] = [r, c].map(|k| ((k + 1) % D, (k + 2) % D));
        f[(a, p)] * f[(b, q)] - f[(a, q)] * f[(b, p)]
    })
}
