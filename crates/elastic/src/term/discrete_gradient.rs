//! Discrete gradients: forces between two configurations whose work is the decrease of the energy.
//!
//! The forces `f(x₀, x₁)` of a term with the energy `Ψ` fulfil
//!
//! ```text
//! f · (x₁ − x₀) = Ψ(x₀) − Ψ(x₁),        Σ_v f_v = 0,        Σ_v ½ (x₀ + x₁)_v × f_v = 0.
//! ```
//!
//! With `x₁ − x₀ = h ½ (v₀ + v₁)` and `M (v₁ − v₀) = h f` a step of any length conserves energy and both momenta (J. Simo & N. Tarnow
//! 1992; O. Gonzalez 2000). The mean `F̄` of the deformation gradients at both ends gives `F₁ᵀF₁ − F₀ᵀF₀ = F̄ᵀΔF + ΔFᵀF̄ = ΔC`. A
//! stress `F̄ S` with a symmetric `S` therefore does the work `F̄S : ΔF = ½ S : ΔC` and has no torque; `S` must fulfil `½ S : ΔC = ΔΨ`.
//! The formulas here contain no quotient that vanishes with the change, so they are robust to rounding. The forces differ from the
//! force at the mean by terms of second order in the change.

use super::energy_density::{EnergyDensity, Lame, cofactor, determinant, dilation};
use crate::linalg::svd;
use meniscus_numerics::Matrix;

/// An energy density with a discrete gradient between deformation gradients `[F₀, F₁]`, both of positive volume.
pub trait DiscreteGradientDensity<const D: usize>: EnergyDensity<D> {
    /// Symmetric `S`, Pa, with `½ S : ΔC = ΔΨ`.
    fn stress_between(&self, lame: Lame, ends: [&Matrix<D>; 2]) -> Matrix<D>;

    /// Symmetric `G` with `½ G : ΔC = Δj`.
    fn volume_discrete_gradient(&self, ends: [&Matrix<D>; 2]) -> Matrix<D>;

    /// Divided difference `ΔU/Δθ`, Pa.
    fn pressure_between(&self, lame: Lame, thetas: [f64; 2]) -> f64;
}

/// `G` of the determinant. With Simpson's rule, exact for cubic functions, `det C₁ − det C₀ = (cof C₀ + 4 cof C̄ + cof C₁)/6 : ΔC`.
pub fn determinant_discrete_gradient<const D: usize>(ends: [&Matrix<D>; 2]) -> Matrix<D> {
    let [first, last] = ends.map(|f| f.tr_mul(f));
    let mean = (first + last) * 0.5;
    let volumes: f64 = ends.iter().map(|f| determinant(f)).sum();
    (cofactor(&first) + cofactor(&last) + cofactor(&mean) * 4.0) / (3.0 * volumes)
}

/// `G` of the sum of the principal stretches, the trace of the stretch tensor `U`. With the mean `Ū`, `Ū ΔU + ΔU Ū = ΔC`, so the
/// trace changes by `½ Ū⁻¹ : ΔC`.
pub fn stretch_discrete_gradient<const D: usize>(ends: [&Matrix<D>; 2]) -> Matrix<D> {
    let [first, last] = ends.map(|f| {
        let frame = svd(f);
        frame.v * Matrix::from_diagonal(&frame.values) * frame.v.transpose()
    });
    let mean = (first + last) * 0.5;
    // `mean` is symmetric, so the cofactors need no transposition.
    cofactor(&mean) / determinant(&mean)
}

/// Volume ratios `[J₀, J₁]`, with small changes in full precision.
pub fn volume_ratios<const D: usize>(ends: [&Matrix<D>; 2]) -> [f64; 2] {
    ends.map(|f| 1.0 + dilation(f))
}
