//! How the liquid meets its solids, resolved to SI.

use crate::file::ShapeSpec;
use std::path::PathBuf;

/// Tensions.
#[derive(Clone, Debug, PartialEq)]
pub struct Tensions {
    /// Liquid–air, N/m.
    pub liquid_air: f64,
    /// Per solid, in alphabetical order of the names.
    pub solids: Vec<(String, Wetting)>,
}

/// How a solid is wetted: its tensions, and what lies over them where the angle varies.
#[derive(Clone, Debug, PartialEq)]
pub struct Wetting {
    /// Its tensions.
    pub tension: SolidTension,
    /// A picture of the angle over that.
    pub image: Option<WettingImage>,
    /// Shapes and the contact angles, rad, of what they have of the surface, over both; the last on top.
    pub patches: Vec<(ShapeSpec, f64)>,
}

/// A picture of the contact angle.
#[derive(Clone, Debug, PartialEq)]
pub struct WettingImage {
    /// Absolute path of an existing file.
    pub path: PathBuf,
    /// Lower left corner, m: x and y (2D: x).
    pub lower: Vec<f64>,
    /// Upper right corner, m.
    pub upper: Vec<f64>,
    /// Contact angle of black, rad.
    pub black: f64,
    /// Contact angle of white, rad.
    pub white: f64,
}

impl Wetting {
    /// Whether the angle is the same everywhere.
    pub fn is_uniform(&self) -> bool {
        let even = !matches!(self.tension, SolidTension::Gradient { .. });
        even && self.image.is_none() && self.patches.is_empty()
    }

    /// Smallest and largest cosine of Young's angle that it has; beyond ±1 there is none (wetted or dry).
    pub fn cosines(&self, liquid_air: f64) -> [f64; 2] {
        let image = self.image.iter().flat_map(|i| [i.black.cos(), i.white.cos()]);
        let patches = self.patches.iter().map(|(_, angle)| angle.cos());
        let all = self.tension.cosines(liquid_air).into_iter().chain(image).chain(patches);
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], c| [c.min(low), c.max(high)])
    }
}

/// Tensions of a solid.
#[derive(Clone, Debug, PartialEq)]
pub enum SolidTension {
    /// Both interface energies.
    Energies {
        /// Liquid–solid, N/m.
        liquid_solid: f64,
        /// Solid–air, N/m.
        solid_air: f64,
    },
    /// The contact angle, rad.
    Angle(f64),
    /// The cosine of the angle is linear between two places, constant before and beyond.
    Gradient {
        /// Where it starts, m, and the angle there, rad.
        from: (Vec<f64>, f64),
        /// Where it ends, m, and the angle there, rad.
        to: (Vec<f64>, f64),
    },
}

impl SolidTension {
    /// Cosine of Young's angle, of a gradient where it starts; beyond ±1 there is none (the solid is wetted or dry).
    pub fn young_cosine(&self, liquid_air: f64) -> f64 {
        match self {
            Self::Energies { liquid_solid, solid_air } => (solid_air - liquid_solid) / liquid_air,
            Self::Angle(angle) | Self::Gradient { from: (_, angle), .. } => angle.cos(),
        }
    }

    /// The same, of a gradient at both ends.
    fn cosines(&self, liquid_air: f64) -> [f64; 2] {
        let first = self.young_cosine(liquid_air);
        if let Self::Gradient { to: (_, angle), .. } = self { [first, angle.cos()] } else { [first; 2] }
    }
}

/// The contact line.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactLine {
    /// Off: traditional two-way coupling.
    pub enabled: bool,
    /// The paper's R, m, over which the line's pull is spread on solids that deform; without it the line pulls where it is.
    pub radius: Option<f64>,
    /// Solids that deform feel the tensions of their own surface.
    pub neumann: bool,
    /// Friction of every solid that is not named, Pa s.
    pub friction: f64,
    /// Friction per solid, Pa s, in alphabetical order.
    pub friction_of: Vec<(String, f64)>,
    /// The angles between which a line rests.
    pub hysteresis: Option<Hysteresis>,
}

/// The angles between which a contact line rests, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hysteresis {
    /// The same everywhere.
    Between {
        /// The advancing angle.
        advancing: f64,
        /// The receding angle.
        receding: f64,
    },
    /// Around Young's angle of each place.
    Around {
        /// By how much the advancing angle is larger.
        above: f64,
        /// By how much the receding angle is smaller.
        below: f64,
    },
}
