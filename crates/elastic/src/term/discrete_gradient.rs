//! Forces between two configurations whose work is the change of the energy: discrete gradients.
//!
//! The forces `f(x₀, x₁)` of a term with the energy `Ψ` fulfil
//!
//! ```text
//! f · (x₁ − x₀) = Ψ(x₀) − Ψ(x₁),        Σ_v f_v = 0,        Σ_v ½ (x₀ + x₁)_v × f_v = 0,
//! ```
//!
//! so that with `x₁ − x₀ = h ½ (v₀ + v₁)` and `M (v₁ − v₀) = h f` a step keeps energy and both momenta, however long it is (J. Simo & N.
//! Tarnow 1992; O. Gonzalez 2000). With the mean `F̄` of the deformation gradients at both ends `F₁ᵀF₁ − F₀ᵀF₀ = F̄ᵀΔF + ΔFᵀF̄ = ΔC`: a stress
//! `F̄ S` with a symmetric `S` does the work `F̄S : ΔF = ½ S : ΔC`, and has no torque. What is asked of `S` is `½ S : ΔC = ΔΨ`; the
//! formulas here have no quotient that vanishes with the change, so that rounding does no harm. They differ from the force at the mean
//! by terms of second order in the change.

use super::energy_density::{EnergyDensity, Lame, cofactor, determinant, dilation};
use crate::linalg::svd;
use meniscus_numerics::Matrix;

/// A density with a discrete gradient between deformation gradients `[F₀, F₁]`, both of positive volume.
pub trait DiscreteGradientDensity<const D: usize>: EnergyDensity<D> {
    /// A symmetric `S`, Pa, with `½ S : ΔC` the change of `Ψ`.
    fn stress_between(&self, lame: Lame, ends: [&Matrix<D>; 2]) -> Matrix<D>;

    /// A symmetric `G` with `½ G : ΔC` the change of `j`.
    fn volume_discrete_gradient(&self, ends: [&Matrix<D>; 2]) -> Matrix<D>;

    /// The change of `U` over that of `θ`, Pa.
    fn pressure_between(&self, lame: Lame, thetas: [f64; 2]) -> f64;
}

/// `G` of the determinant: `det C₁ − det C₀` is the mean of the cofactors of `C₀`, `C₁` and, four times, of their mean, times `ΔC`
/// (Simpson's rule, exact for cubic functions).
pub fn determinant_discrete_gradient<const D: usize>(ends: [&Matrix<D>; 2]) -> Matrix<D> {
    let [first, last] = ends.map(|f| f.tr_mul(f));
    let mean = (first + last) * 0.5;
    let volumes: f64 = ends.iter().map(|f| determinant(f)).sum();
    (cofactor(&first) + cofactor(&last) + cofactor(&mean) * 4.0) / (3.0 * volumes)
}

/// `G` of the sum of the principal stretches, the trace of `U`: with `Ū` the mean of both, `Ū ΔU + ΔU Ū = ΔC`, so that the trace
/// changes by `½ Ū⁻¹ : ΔC`.
pub fn stretch_discrete_gradient<const D: usize>(ends: [&Matrix<D>; 2]) -> Matrix<D> {
    let [first, last] = ends.map(|f| {
        let frame = svd(f);
        frame.v * Matrix::from_diagonal(&frame.values) * frame.v.transpose()
    });
    let mean = (first + last) * 0.5;
    // Symmetric, so that the cofactors need not be transposed.
    cofactor(&mean) / determinant(&mean)
}

/// The volumes `[J₀, J₁]`, with the small changes in full.
pub fn volume_ratios<const D: usize>(ends: [&Matrix<D>; 2]) -> [f64; 2] {
    ends.map(|f| 1.0 + dilation(f))
}
