//! Errata of the paper that are more than a misprint, as switches. Their numbers are those of `book/paper/deviations.md`, section 2.

/// How the mass of the liquid that moves with a solid or a line enters their equations (Eq. 9 and 13).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LiquidMass {
    /// `diag(Wᵀ M 1)`: the nearest to the printed `Wᵀ M`, which is not square. Relative motion weighs too much.
    Lumped,
    /// `Wᵀ M W`: the mass of the kinetic energy `½ vᵀ Wᵀ M W v` of the faces that move with `W v`.
    Consistent,
}

/// Which errata of the paper are corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Errata {
    /// E3: the delta function of Eq. 6 is doubled in the liquid and zero in the air, so that a drop has all of Laplace's pressure.
    /// As printed it has half: the other half acts where no liquid is.
    pub one_sided_delta: bool,
    /// E6: the mass of the liquid in Eq. 9 and 13.
    pub liquid_mass: LiquidMass,
    /// E7 and E8: the impulse of a line is divided between the faces around it, so that all of it arrives once. As printed one matrix
    /// interpolates velocities and distributes impulses, and the impulse counts for liquid and solid.
    pub divided_line_impulse: bool,
    /// E9: the force of a line accelerates the mass that Eq. 13 to 15 multiply its velocity with. As printed, Eq. 21 divides by the
    /// lumped mass of Section 4.3.1, and a small part of the impulse arrives.
    pub intrinsic_mass_in_eq_21: bool,
}

impl Errata {
    /// Everything corrected.
    pub const CORRECTED: Self = Self {
        one_sided_delta: true,
        liquid_mass: LiquidMass::Consistent,
        divided_line_impulse: true,
        intrinsic_mass_in_eq_21: true,
    };
    /// The paper as printed, misprints aside.
    pub const AS_PRINTED: Self = Self {
        one_sided_delta: false,
        liquid_mass: LiquidMass::Lumped,
        divided_line_impulse: false,
        intrinsic_mass_in_eq_21: false,
    };
}

impl Default for Errata {
    fn default() -> Self {
        Self::CORRECTED
    }
}
