//! Errata of the paper that are more than a misprint, as switches. Their numbers are those of `book/paper/deviations.md`, section 2,
//! and of `book/paper/scheme.md`.

/// How the mass of the liquid that moves with a solid or a line enters their equations (Eq. 9 and 13).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LiquidMass {
    /// `diag(Wᵀ M 1)`: the nearest to the printed `Wᵀ M`, which is not square. Relative motion weighs too much.
    Lumped,
    /// `Wᵀ M W`: the mass of the kinetic energy `½ vᵀ Wᵀ M W v` of the faces that move with `W v`.
    Consistent,
}

/// How the force of a line particle is divided between liquid and solid (Eq. 12 to 15).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineImpulse {
    /// As printed: one matrix interpolates velocities and distributes impulses, and the impulse counts for liquid and solid.
    ForBoth,
    /// E7 and E8: each component is divided evenly between the incident faces of its axis, so that all of it arrives once.
    ByFaces,
    /// E22 too: the part along the solid goes to the liquid, the part normal to it to the solid, however the solid lies in the grid.
    ByDirections,
}

/// Which errata of the paper are corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Errata {
    /// E3: the delta function of Eq. 6 is doubled in the liquid and zero in the air, so that a drop has all of Laplace's pressure.
    /// As printed it has half: the other half acts where no liquid is.
    pub one_sided_delta: bool,
    /// E6: the mass of the liquid in Eq. 9 and 13.
    pub liquid_mass: LiquidMass,
    /// E7, E8 and E22: the impulse of a line.
    pub line_impulse: LineImpulse,
    /// E9: the force of a line accelerates the mass that Eq. 13 to 15 multiply its velocity with. As printed, Eq. 21 divides by the
    /// lumped mass of Section 4.3.1, and a small part of the impulse arrives.
    pub intrinsic_mass_in_eq_21: bool,
    /// E23: the liquid's surface goes on through solids, and ends nowhere. As printed it is closed along them: its corner at the line is
    /// rounded in every step, and Eq. 6 has the corner's force, which Eq. 4 has as well.
    pub open_surface: bool,
    /// E24: `δ n` is a difference of Heaviside functions, so that the sum over the band is one, and `κ` is that of the surface. As
    /// printed the delta function is sampled, with the curvature of the level set through each face.
    pub balanced_force: bool,
    /// E14: the line is the zero set of `φ` on the solid, without enlarging and shrinking; asks for an open surface.
    pub exact_line: bool,
    /// E25: the tangent of the liquid–air interface is that at the line. As printed it is that in the middle of the samples.
    pub tangent_at_line: bool,
    /// E26: the line's force acts on the liquid–air faces around it, which move with the pressure's gradient as all others do. As printed
    /// all of them move with the particle.
    pub free_faces: bool,
    /// E12: solids carry the tensions of their surfaces themselves, wetted and dry. As printed wetted surfaces press through Eq. 6, and
    /// dry ones have no tension but at the line.
    pub solid_tensions: bool,
    /// E27: elastic forces are those at `x^n + Δt v^{n+½}` in Eq. 16 and at `x^{n+1} + ½ Δt v^{n+1}` in Eq. 20, to first order in `Δt`.
    /// As printed they are explicit, and unstable in steps of the length that the paper has with its stiffnesses.
    pub implicit_elasticity: bool,
    /// E28: the liquid slips along solids: beside them and within, its velocity is extrapolated from that of the liquid, with the normal part
    /// of the solid's. As printed faces between liquid and solid have the solid's velocity, both components where the solid lies across
    /// the grid: the line is held there, and its force bends the surface above it.
    pub slip: bool,
}

impl Errata {
    /// Everything corrected.
    pub const CORRECTED: Self = Self {
        one_sided_delta: true,
        liquid_mass: LiquidMass::Consistent,
        line_impulse: LineImpulse::ByDirections,
        intrinsic_mass_in_eq_21: true,
        open_surface: true,
        balanced_force: true,
        exact_line: true,
        tangent_at_line: true,
        free_faces: true,
        solid_tensions: true,
        implicit_elasticity: true,
        slip: true,
    };
    /// The paper as printed, misprints aside.
    pub const AS_PRINTED: Self = Self {
        one_sided_delta: false,
        liquid_mass: LiquidMass::Lumped,
        line_impulse: LineImpulse::ForBoth,
        intrinsic_mass_in_eq_21: false,
        open_surface: false,
        balanced_force: false,
        exact_line: false,
        tangent_at_line: false,
        free_faces: false,
        solid_tensions: false,
        implicit_elasticity: false,
        slip: false,
    };
    /// The state of the first implementation: E3 and E6 to E9 corrected, and nothing else.
    #[cfg(test)]
    pub(crate) const FIRST: Self = Self {
        one_sided_delta: true,
        liquid_mass: LiquidMass::Consistent,
        line_impulse: LineImpulse::ByFaces,
        intrinsic_mass_in_eq_21: true,
        ..Self::AS_PRINTED
    };
}

impl Default for Errata {
    fn default() -> Self {
        Self::CORRECTED
    }
}
