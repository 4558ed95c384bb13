//! The three interfacial tensions (Section 3.3).

/// Tensions `Υ_ij` of the interfaces between liquid (l), solid (s) and air (a), N/m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tensions {
    /// `Υ_la`, N/m.
    pub liquid_air: f64,
    /// `Υ_ls`, N/m.
    pub liquid_solid: f64,
    /// `Υ_sa`, N/m.
    pub solid_air: f64,
}

impl Tensions {
    /// Tensions with the liquid's, N/m, and the cosine of a contact angle; the smaller one of the solid's is zero. On rigid solids only their
    /// difference counts.
    pub fn of_cosine(liquid_air: f64, cosine: f64) -> Self {
        let difference = liquid_air * cosine;
        Self { liquid_air, liquid_solid: (-difference).max(0.0), solid_air: difference.max(0.0) }
    }

    /// Cosine of the contact angle, `(Υ_sa − Υ_ls)/Υ_la` (Eq. 5); beyond ±1 there is no angle.
    pub fn young_cosine(&self) -> f64 {
        (self.solid_air - self.liquid_solid) / self.liquid_air
    }
}
