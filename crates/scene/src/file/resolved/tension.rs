//! Surface tensions, wetting patterns and contact-line parameters, resolved to SI.

use super::shape::ShapeSpec;
use std::path::PathBuf;

/// Tensions.
#[derive(Clone, Debug, PartialEq)]
pub struct Tensions {
    /// Liquid–air, N/m.
    pub liquid_air: f64,
    /// Per solid, in alphabetical order of the names.
    pub solids: Vec<(String, Wetting)>,
}

/// Wetting of a solid: its tensions and the patterns of the angle over them.
#[derive(Clone, Debug, PartialEq)]
pub struct Wetting {
    /// Its tensions.
    pub tension: SolidTension,
    /// An image of the contact angle that overrides the tensions.
    pub image: Option<WettingImage>,
    /// Shapes with the contact angle, rad, of the surface inside them. They override both; the last one wins.
    pub patches: Vec<(ShapeSpec, f64)>,
}

/// An image of the contact angle.
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

    /// Smallest and largest cosine of Young's angle. Beyond ±1 there is no such angle (total wetting or dewetting).
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
    /// The cosine of the angle is linear between two points and constant beyond them.
    Gradient {
        /// Start point, m, and the angle there, rad.
        from: (Vec<f64>, f64),
        /// End point, m, and the angle there, rad.
        to: (Vec<f64>, f64),
    },
}

impl SolidTension {
    /// Cosine of Young's angle, for a gradient at its start. Beyond ±1 there is no such angle (total wetting or dewetting).
    pub fn young_cosine(&self, liquid_air: f64) -> f64 {
        match self {
            Self::Energies { liquid_solid, solid_air } => (solid_air - liquid_solid) / liquid_air,
            Self::Angle(angle) | Self::Gradient { from: (_, angle), .. } => angle.cos(),
        }
    }

    /// [`Self::young_cosine`] at both ends of a gradient.
    fn cosines(&self, liquid_air: f64) -> [f64; 2] {
        let first = self.young_cosine(liquid_air);
        if let Self::Gradient { to: (_, angle), .. } = self { [first, angle.cos()] } else { [first; 2] }
    }
}

/// The contact line.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactLine {
    /// Contact-line forces on; off: traditional two-way coupling.
    pub enabled: bool,
    /// Radius R of the paper, m, over which the line force on deformable solids is spread. `None`: the force acts at the line.
    pub radius: Option<f64>,
    /// Deformable solids are subject to the tension of their own surface.
    pub neumann: bool,
    /// Contact-line friction of every unnamed solid, Pa s.
    pub friction: f64,
    /// Contact-line friction per solid, Pa s, in alphabetical order.
    pub friction_of: Vec<(String, f64)>,
    /// Hysteresis of the contact angle.
    pub hysteresis: Option<Hysteresis>,
}

/// Contact angles between which the line does not move, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hysteresis {
    /// The same everywhere.
    Between {
        /// The advancing angle.
        advancing: f64,
        /// The receding angle.
        receding: f64,
    },
    /// Relative to Young's angle at each point.
    Around {
        /// Advancing angle minus Young's angle.
        above: f64,
        /// Young's angle minus the receding angle.
        below: f64,
    },
}
