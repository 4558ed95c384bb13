//! `[tension]`: tensions of the liquid and of the solids, and patterns of the contact angle.

use super::contact_line::{ContactLine, Hysteresis};
use super::domain::Domain;
use super::solid::Solid;
use crate::error::SceneError;
use crate::file::shape::{Bounds, ShapeSpec};
use crate::file::text::{Angle, Length, Si, Tension};
use crate::file::validator::Validator;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;
use std::fmt;
use std::path::PathBuf;

/// Name of the closed sides of the domain where a solid's name is expected.
pub const WALLS: &str = "walls";

/// `[tension]`: `liquid_air` and one key per solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Tensions {
    /// Surface tension of the liquid, N/m.
    pub liquid_air: f64,
    /// Wetting of the solids, in alphabetical order of the names.
    pub solids: Vec<(String, Wetting)>,
}

impl<'de> Deserialize<'de> for Tensions {
    fn deserialize<De: Deserializer<'de>>(d: De) -> Result<Self, De::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = Tensions;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table with `liquid_air` and one key per solid")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Tensions, M::Error> {
                let mut liquid_air = None;
                let mut solids = Vec::new();
                while let Some(key) = map.next_key::<String>()? {
                    if key == "liquid_air" {
                        liquid_air = Some(map.next_value::<Tension>()?.0);
                    } else {
                        solids.push((key, map.next_value()?));
                    }
                }
                let liquid_air = liquid_air.ok_or_else(|| M::Error::missing_field("liquid_air"))?;
                Ok(Tensions { liquid_air, solids })
            }
        }
        d.deserialize_map(V)
    }
}

impl Serialize for Tensions {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeMap as _;
        let mut map = s.serialize_map(Some(1 + self.solids.len()))?;
        map.serialize_entry("liquid_air", &Tension(self.liquid_air))?;
        for (name, value) in &self.solids {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

impl JsonSchema for Tensions {
    fn schema_name() -> Cow<'static, str> {
        "Tensions".into()
    }

    fn json_schema(g: &mut SchemaGenerator) -> Schema {
        let mut liquid_air = g.subschema_for::<Tension>();
        liquid_air.insert("description".into(), "Surface tension of the liquid, above 0.".into());
        let mut solid = g.subschema_for::<Wetting>();
        solid.insert("description".into(), "Wetting of a solid; contact angle 90 degrees by default.".into());
        json_schema!({
            "description": "`[tension]`: surface tension of the liquid, and wetting of the solids.",
            "type": "object",
            "properties": { "liquid_air": liquid_air },
            "required": ["liquid_air"],
            "additionalProperties": solid,
        })
    }
}

/// Wetting of a solid, by one of these: both tensions, the contact angle, or a gradient of it. An image
/// overrides them, and patches override both.
#[derive(Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wetting {
    /// Tension of the liquid–solid interface, 0 or more; requires `solid_air`.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Tension>>")]
    liquid_solid: Option<f64>,
    /// Tension of the solid–air interface, 0 or more; requires `liquid_solid`.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Tension>>")]
    solid_air: Option<f64>,
    /// Contact angle, through the liquid: 0 to 180 degrees.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Angle>>")]
    contact_angle: Option<f64>,
    /// Contact angle that varies between two points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradient: Option<Gradient>,
    /// Image of the contact angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<WettingImage>,
    /// Parts of the surface with a contact angle of their own. Where patches overlap, the last one counts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub patches: Vec<Patch>,
}

identity_text!(Wetting, w => tension: w.tension(), image: w.image, patches: w.patches);

/// `gradient`: the cosine of the contact angle is linear along the line through two points, and constant beyond
/// them. The points are given for the position of the solid at the start; the pattern moves with the solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gradient {
    /// Start of the gradient.
    pub from: AngleAt,
    /// End of the gradient.
    pub to: AngleAt,
}

/// A contact angle at a point.
#[derive(Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AngleAt {
    /// The point, where the solid is at the start.
    #[serde(with = "Si::<Vec<Length>>")]
    pub point: Vec<f64>,
    /// Contact angle there, 0 to 180 degrees.
    #[serde(with = "Si::<Angle>")]
    pub contact_angle: f64,
}

/// The text that enters the identity of a scene.
impl fmt::Debug for AngleAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&(&self.point, self.contact_angle), f)
    }
}

/// `image`: the grey value of a pixel gives the contact angle. The image is projected along the vertical axis;
/// in 2D its middle row lies along x. Cosines are interpolated between the centres of the pixels. Where pixels
/// are transparent, the angle without the image applies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WettingImage {
    /// Path of a `.png` file, relative to the scene file.
    #[serde(rename = "file")]
    pub path: PathBuf,
    /// Position of the lower left corner, seen from above, where the solid is at the start: x and y (2D: x).
    #[serde(with = "Si::<Vec<Length>>")]
    pub lower: Vec<f64>,
    /// Position of the upper right corner; each entry is larger than that of `lower`.
    #[serde(with = "Si::<Vec<Length>>")]
    pub upper: Vec<f64>,
    /// Contact angle of black pixels, 0 to 180 degrees.
    #[serde(with = "Si::<Angle>")]
    pub black: f64,
    /// Contact angle of white pixels, 0 to 180 degrees.
    #[serde(with = "Si::<Angle>")]
    pub white: f64,
}

/// The part of a solid's surface within a shape, with a contact angle of its own.
#[derive(Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Patch {
    /// The shape, where the solid is at the start. It may extend beyond the solid.
    pub shape: ShapeSpec,
    /// Contact angle there, 0 to 180 degrees.
    #[serde(with = "Si::<Angle>")]
    pub contact_angle: f64,
}

/// The text that enters the identity of a scene.
impl fmt::Debug for Patch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&(&self.shape, self.contact_angle), f)
    }
}

/// Tensions of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SolidTension<'a> {
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
        /// The start.
        from: &'a AngleAt,
        /// The end.
        to: &'a AngleAt,
    },
}

impl Wetting {
    /// The tensions; the contact angle of a valid scene is 90 degrees where none is given.
    pub fn tension(&self) -> SolidTension<'_> {
        match (self.liquid_solid, self.solid_air, &self.gradient) {
            (Some(liquid_solid), Some(solid_air), _) => SolidTension::Energies { liquid_solid, solid_air },
            (_, _, Some(Gradient { from, to })) => SolidTension::Gradient { from, to },
            _ => SolidTension::Angle(self.contact_angle.unwrap_or(FRAC_PI_2)),
        }
    }

    /// Makes the contact angle, rad, the same everywhere but in images and patches.
    pub fn set_contact_angle(&mut self, angle: f64) {
        let (image, patches) = (self.image.take(), std::mem::take(&mut self.patches));
        *self = Self { contact_angle: Some(angle), image, patches, ..Self::default() };
    }

    /// Whether the angle is the same everywhere.
    pub fn is_uniform(&self) -> bool {
        self.gradient.is_none() && self.image.is_none() && self.patches.is_empty()
    }

    /// Cosine of Young's angle, for a gradient at its start. Beyond ±1 there is no such angle (total wetting or dewetting).
    pub fn young_cosine(&self, liquid_air: f64) -> f64 {
        match self.tension() {
            SolidTension::Energies { liquid_solid, solid_air } => (solid_air - liquid_solid) / liquid_air,
            SolidTension::Angle(angle) => angle.cos(),
            SolidTension::Gradient { from, .. } => from.contact_angle.cos(),
        }
    }

    /// Young's angle, rad: 0 for total wetting, π for total dewetting, for a gradient that at its start.
    pub fn young_angle(&self, liquid_air: f64) -> f64 {
        self.young_cosine(liquid_air).clamp(-1.0, 1.0).acos()
    }

    /// Smallest and largest cosine of Young's angle. Beyond ±1 there is no such angle (total wetting or dewetting).
    pub fn cosines(&self, liquid_air: f64) -> [f64; 2] {
        let end = self.gradient.iter().map(|gradient| gradient.to.contact_angle.cos());
        let image = self.image.iter().flat_map(|i| [i.black.cos(), i.white.cos()]);
        let patches = self.patches.iter().map(|patch| patch.contact_angle.cos());
        let all = std::iter::once(self.young_cosine(liquid_air)).chain(end).chain(image).chain(patches);
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], c| [c.min(low), c.max(high)])
    }
}

impl Tensions {
    /// Checks the section of a scene; `solids` are those of the scene.
    ///
    /// # Errors
    /// [`SceneError`] at the value.
    pub(in crate::file) fn validate(
        &mut self,
        solids: &[Solid],
        v: &mut Validator,
    ) -> Result<(), SceneError> {
        v.positive("tension.liquid_air", "the surface tension", self.liquid_air)?;
        let names: Vec<&str> = solids.iter().map(|s| s.name.as_str()).collect();
        for (name, wetting) in &mut self.solids {
            let path = format!("tension.{name}");
            v.known_solid(&path, true, name, &names)?;
            let bounds = solids.iter().find(|s| s.name == *name).and_then(|s| s.shape.bounds(v.dim));
            wetting.check_tension(&path, v)?;
            if let Some(image) = &mut wetting.image {
                image.validate(&format!("{path}.image"), bounds.as_ref(), v)?;
            }
            for (i, patch) in wetting.patches.iter_mut().enumerate() {
                patch.validate(&format!("{path}.patches.{i}"), bounds.as_ref(), v)?;
            }
            let cosine = wetting.young_cosine(self.liquid_air);
            if cosine.abs() > 1.0 {
                let state =
                    if cosine > 0.0 { "wets the solid totally" } else { "does not wet the solid at all" };
                let message =
                    format!("there is no Young angle (its cosine would be {cosine:.3}): the liquid {state}");
                v.warn(&path, message);
            }
        }
        self.solids.sort_by(|a, b| a.0.cmp(&b.0));
        Ok(())
    }

    /// Checks that Young's angle is uniform and lies between the receding and the advancing angle where both are given.
    ///
    /// # Errors
    /// [`SceneError`] at the hysteresis.
    pub(in crate::file) fn check_hysteresis(
        &self,
        line: &ContactLine,
        domain: &Domain,
        v: &Validator,
    ) -> Result<(), SceneError> {
        let Some(Hysteresis::Between { advancing, receding }) = line.hysteresis else { return Ok(()) };
        let refuse = |message: String, help| Err(v.error("contact_line.hysteresis", message, help));
        let mut all =
            Vec::from_iter(domain.walls_are_wetting().then_some((WALLS, domain.wall_contact_angle)));
        for (name, solid) in &self.solids {
            if !solid.is_uniform() {
                let message = format!(
                    "the contact angle of `{name}` varies, but the advancing and receding angles do not"
                );
                let help = "give them relative to Young's angle: { above = \"10 deg\", below = \"10 deg\" }";
                return refuse(message, help);
            }
            all.push((name, solid.young_angle(self.liquid_air)));
        }
        let fits = |angle: f64| (receding - 1e-9..=advancing + 1e-9).contains(&angle);
        let Some((name, angle)) = all.into_iter().find(|(_, angle)| !fits(*angle)) else { return Ok(()) };
        let [young, advancing, receding] = [angle, advancing, receding].map(f64::to_degrees);
        let message = format!(
            "the contact angle of `{name}`, {young:.1} deg, is not between the receding angle, {receding:.1} deg, \
             and the advancing angle, {advancing:.1} deg"
        );
        refuse(
            message,
            "change `contact_line.hysteresis`, the solid's tensions or `domain.wall_contact_angle`",
        )
    }
}

impl Wetting {
    fn check_tension(&self, path: &str, v: &Validator) -> Result<(), SceneError> {
        let at = |key: &str| format!("{path}.{key}");
        match (self.liquid_solid, self.solid_air, self.contact_angle, &self.gradient) {
            (Some(liquid_solid), Some(solid_air), None, None) => {
                v.not_negative(&at("liquid_solid"), "the tension", liquid_solid)?;
                v.not_negative(&at("solid_air"), "the tension", solid_air)
            }
            (None, None, Some(angle), None) => v.angle(&at("contact_angle"), angle),
            (None, None, None, Some(Gradient { from, to })) => {
                for (end, key) in [(from, "gradient.from"), (to, "gradient.to")] {
                    v.dimension(&at(&format!("{key}.point")), &end.point)?;
                    v.angle(&at(&format!("{key}.contact_angle")), end.contact_angle)?;
                }
                if from.point != to.point {
                    return Ok(());
                }
                let message = "the two points of the gradient are the same";
                Err(v.error(&at("gradient.to.point"), message, "give two different points"))
            }
            _ => Err(self.tension_error(path, v)),
        }
    }

    /// The error for missing or conflicting tensions.
    fn tension_error(&self, path: &str, v: &Validator) -> SceneError {
        let keys = [
            ("liquid_solid", self.liquid_solid.is_some()),
            ("solid_air", self.solid_air.is_some()),
            ("contact_angle", self.contact_angle.is_some()),
            ("gradient", self.gradient.is_some()),
        ];
        let given: Vec<&str> = keys.iter().filter(|key| key.1).map(|key| key.0).collect();
        let one_of = "give `liquid_solid` and `solid_air`, or `contact_angle`, or `gradient`";
        let energies = given.iter().filter(|key| ["liquid_solid", "solid_air"].contains(key)).count();
        if given.is_empty() {
            return v.error(path, "no tension is given for this solid", one_of);
        }
        if given.len() == energies {
            let missing = if given == ["liquid_solid"] { "solid_air" } else { "liquid_solid" };
            return v.error(path, format!("the tension `{missing}` is missing"), one_of);
        }
        let message = format!("{} exclude each other", given.join(" and "));
        let help = format!(
            "keep one; on the command line set the whole table: --set '{path}={{contact_angle=\"60 deg\"}}'"
        );
        v.error(path, message, help)
    }
}

impl Patch {
    /// `solid`: bounds of the solid.
    fn validate(&mut self, path: &str, solid: Option<&Bounds>, v: &Validator) -> Result<(), SceneError> {
        let shape = format!("{path}.shape");
        self.shape.validate(&shape, v)?;
        let own = self.shape.bounds(v.dim);
        if solid.zip(own.as_ref()).is_some_and(|(solid, own)| are_apart(solid, own, v.dx)) {
            let help = "place the patch on the solid as it is at the start";
            return Err(v.error(&v.source.first_inside(&shape), "the patch does not reach the solid", help));
        }
        v.angle(&format!("{path}.contact_angle"), self.contact_angle)
    }
}

impl WettingImage {
    /// `solid`: bounds of the solid.
    fn validate(&mut self, path: &str, solid: Option<&Bounds>, v: &Validator) -> Result<(), SceneError> {
        let at = |key: &str| format!("{path}.{key}");
        self.find_file(&at("file"), v)?;
        for (key, corner) in [("lower", &self.lower), ("upper", &self.upper)] {
            let wanted = v.dim - 1;
            if corner.len() != wanted {
                let message = format!("found {} entries in this corner of the image", corner.len());
                let help = format!("give {wanted}: the image is projected along the vertical axis");
                return Err(v.error(&at(key), message, help));
            }
        }
        for (a, (low, high)) in self.lower.iter().zip(&self.upper).enumerate() {
            if low >= high {
                let message = format!("`upper` ({high} m) is not above `lower` ({low} m)");
                let help = "every entry of `upper` must be larger than that of `lower`";
                return Err(v.error(&at(&format!("upper.{a}")), message, help));
            }
        }
        let own = Bounds { lower: self.lower.clone(), upper: self.upper.clone() };
        if solid.is_some_and(|solid| are_apart(solid, &own, v.dx)) {
            let help = "place the image on the solid as it is at the start";
            return Err(v.error(&at("lower"), "the image does not reach the solid", help));
        }
        v.angle(&at("black"), self.black)?;
        v.angle(&at("white"), self.white)
    }

    fn find_file(&mut self, path: &str, v: &Validator) -> Result<(), SceneError> {
        let name = self.path.to_string_lossy().into_owned();
        if !self.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            let message = format!("`{}` is not a supported image file", name.escape_debug());
            return Err(v.error(path, message, "accepted: .png"));
        }
        self.path = v.existing_file(&self.path).ok_or_else(|| {
            let message = format!("there is no image `{}`", name.escape_debug());
            v.error(path, message, "the path is relative to the folder of the scene file")
        })?;
        Ok(())
    }
}

/// Whether two boxes are disjoint along any axis that both have.
fn are_apart(one: &Bounds, other: &Bounds, dx: f64) -> bool {
    let slack = 1e-6 * dx;
    let along = |(low, high): (&f64, &f64)| low > &(high + slack);
    one.lower.iter().zip(&other.upper).any(along) || other.lower.iter().zip(&one.upper).any(along)
}
