//! `[contact_line]`: properties of the contact line.

use super::is_false;
use crate::error::SceneError;
use crate::file::text::{Angle, DynamicViscosity, Either, HELP_MARK, Length, Named, Si, read_as};
use crate::file::validator::Validator;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use std::f64::consts::PI;

/// `[contact_line]`: properties of the contact line.
#[derive(Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ContactLine {
    /// Whether contact lines exert forces; `true` by default. With `false` liquid and solids are coupled by
    /// pressure alone, as in traditional two-way coupling, and all contact angles are 90 degrees; for
    /// comparison.
    pub enabled: bool,
    /// Line radius, the paper's R, above 0: distance from the line over which its force is spread along a
    /// deformable solid. By default the force acts at the line.
    #[serde(skip_serializing_if = "Option::is_none", with = "Si::<Option<Length>>")]
    pub radius: Option<f64>,
    /// Whether deformable solids are subject to the tensions of their own surface, `liquid_solid` where it is
    /// wetted and `solid_air` where it is dry, so that three tensions balance at the line (Neumann). Both
    /// tensions must be given. `false` by default: only the balance along the solid holds (Young), and the
    /// tensions are the least that give the contact angle and are not negative.
    #[serde(skip_serializing_if = "is_false")]
    pub neumann: bool,
    /// Contact-line friction, a force per length and speed, 0 or more: one value, or a table by solid; 0 by
    /// default.
    pub friction: Either<DynamicViscosity, Named<DynamicViscosity>>,
    /// Range of contact angles at which the line rests; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<HysteresisKeys>")]
    pub hysteresis: Option<Hysteresis>,
}

identity_text!(ContactLine, l => enabled: l.enabled, radius: l.radius, neumann: l.neumann, friction: l.uniform_friction(),
    friction_of: l.named_friction(), hysteresis: l.hysteresis);

impl Default for ContactLine {
    fn default() -> Self {
        let friction = Either::Text(DynamicViscosity(0.0));
        Self { enabled: true, radius: None, neumann: false, friction, hysteresis: None }
    }
}

/// Contact angles between which the line does not move, rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(into = "HysteresisKeys")]
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

/// Range of contact angles at which the contact line rests: `advancing` and `receding`, or `above` and `below`,
/// which are relative to Young's angle at each point. Where the contact angle varies over a solid, `above` and
/// `below` are required.
#[derive(Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "Hysteresis")]
struct HysteresisKeys {
    /// Advancing angle, above which the line advances; 0 to 180 degrees.
    #[serde(skip_serializing_if = "Option::is_none", with = "Si::<Option<Angle>>")]
    advancing: Option<f64>,
    /// Receding angle, below which the line recedes; 0 degrees to the advancing angle.
    #[serde(skip_serializing_if = "Option::is_none", with = "Si::<Option<Angle>>")]
    receding: Option<f64>,
    /// Advancing angle minus Young's angle, 0 to 180 degrees.
    #[serde(skip_serializing_if = "Option::is_none", with = "Si::<Option<Angle>>")]
    above: Option<f64>,
    /// Young's angle minus the receding angle, 0 to 180 degrees.
    #[serde(skip_serializing_if = "Option::is_none", with = "Si::<Option<Angle>>")]
    below: Option<f64>,
}

impl<'de> Deserialize<'de> for Hysteresis {
    fn deserialize<De: Deserializer<'de>>(d: De) -> Result<Self, De::Error> {
        read_as(d, |keys: HysteresisKeys| match (keys.advancing, keys.receding, keys.above, keys.below) {
            (Some(advancing), Some(receding), None, None) => Ok(Self::Between { advancing, receding }),
            (None, None, Some(above), Some(below)) => Ok(Self::Around { above, below }),
            _ => Err(format!(
                "these keys do not define the hysteresis{HELP_MARK}give `advancing` and `receding`, or `above` and \
                 `below` (relative to Young's angle)"
            )),
        })
    }
}

impl From<Hysteresis> for HysteresisKeys {
    fn from(of: Hysteresis) -> Self {
        let none = Self::default();
        match of {
            Hysteresis::Between { advancing, receding } => {
                Self { advancing: Some(advancing), receding: Some(receding), ..none }
            }
            Hysteresis::Around { above, below } => Self { above: Some(above), below: Some(below), ..none },
        }
    }
}

impl ContactLine {
    /// Contact-line friction of all solids, Pa s; 0 if it is given by solid.
    pub fn uniform_friction(&self) -> f64 {
        match self.friction {
            Either::Text(friction) => friction.0,
            Either::Rich(_) => 0.0,
        }
    }

    /// Contact-line friction of a solid, Pa s.
    pub fn friction_on(&self, solid: &str) -> f64 {
        let own = self.named_friction().iter().find(|(name, _)| name == solid);
        own.map_or(self.uniform_friction(), |(_, friction)| friction.0)
    }

    fn named_friction(&self) -> &[(String, DynamicViscosity)] {
        match &self.friction {
            Either::Text(_) => &[],
            Either::Rich(table) => &table.0,
        }
    }

    /// Checks the section of a scene with solids of these names.
    ///
    /// # Errors
    /// [`SceneError`] at the value.
    pub(in crate::file) fn validate(&mut self, names: &[&str], v: &Validator) -> Result<(), SceneError> {
        let path = "contact_line.friction";
        self.radius.map_or(Ok(()), |radius| v.positive("contact_line.radius", "the radius", radius))?;
        v.not_negative(path, "the friction", self.uniform_friction())?;
        for (name, friction) in self.named_friction() {
            let path = format!("{path}.{name}");
            v.known_solid(&path, true, name, names)?;
            v.not_negative(&path, "the friction", friction.0)?;
        }
        if let Either::Rich(table) = &mut self.friction {
            table.0.sort_by(|a, b| a.0.cmp(&b.0));
            if table.0.is_empty() {
                self.friction = Either::Text(DynamicViscosity(0.0));
            }
        }
        self.hysteresis.as_ref().map_or(Ok(()), |hysteresis| hysteresis.validate(v))?;
        let has_friction = self.uniform_friction() > 0.0 || self.named_friction().iter().any(|f| f.1.0 > 0.0);
        let given = [
            ("friction", has_friction),
            ("hysteresis", self.hysteresis.is_some()),
            ("radius", self.radius.is_some()),
            ("neumann", self.neumann),
        ];
        let Some((key, _)) = given.iter().find(|(_, given)| *given && !self.enabled) else { return Ok(()) };
        let message = format!("`{key}` has no effect: the contact line is switched off");
        let help = format!("remove `{key}`, or `enabled = false`");
        Err(v.error(&format!("contact_line.{key}"), message, help))
    }
}

impl Hysteresis {
    fn validate(&self, v: &Validator) -> Result<(), SceneError> {
        let within = |key: &str, what: &str, value: f64, high: f64| {
            v.within(&format!("contact_line.hysteresis.{key}"), what, value, [0.0, high])
        };
        match *self {
            Self::Between { advancing, receding } => {
                within("advancing", "the advancing angle (rad)", advancing, PI)?;
                within("receding", "the receding angle (rad)", receding, advancing)
            }
            Self::Around { above, below } => {
                within("above", "the angle (rad)", above, PI)?;
                within("below", "the angle (rad)", below, PI)
            }
        }
    }
}
