//! `[expect]`: what is checked at the end of a run.

mod repairs;
mod series;

pub use series::{SeriesBound, SeriesValue};

use crate::error::SceneError;
use crate::file::text::{Angle, Either, Frequency, Length, Si, Speed, Time, one_or_many};
use crate::file::validator::Validator;
use repairs::RepairBounds;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[expect]`: expected results. Every key that is given is checked at the end of the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// Largest volume error of the run: differences between measured and target volumes, summed over the
    /// components, over the volume of the liquid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume_drift: Option<UpperBound>,
    /// Largest momentum error of the run: momentum that does not come from gravity, over that of all the liquid
    /// at its largest root mean square speed. It is not defined, and the check fails, where solids are fixed,
    /// kinematic or anchored.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub momentum_error: Option<UpperBound>,
    /// Largest growth of the total energy since the start, over the largest of the kinetic, surface, elastic
    /// and potential energy at the start. Energy that left through open sides is included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_growth: Option<UpperBound>,
    /// Largest accepted repairs of the run.
    #[serde(default, skip_serializing_if = "RepairBounds::is_empty")]
    pub repairs: RepairBounds,
    /// Largest velocity component of the liquid at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed: Option<SpeedBound>,
    /// Period of an oscillation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period: Option<ExpectedPeriod>,
    /// Frequency of an oscillation; given instead of `period`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency: Option<ExpectedFrequency>,
    /// Mean contact angle on solids at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "Either<ContactAngle, Vec<ContactAngle>>")]
    pub contact_angle: Vec<ContactAngle>,
    /// Number of drops, that is connected components of the liquid, at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drops: Option<Drops>,
    /// Extent of the liquid towards sides of the domain at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "Either<Reach, Vec<Reach>>")]
    pub reach: Vec<Reach>,
    /// Solids that float at the end: partly wetted, by less than 98 % of their surface, and carried by the
    /// liquid alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub floats: Vec<String>,
    /// Solids that are submerged at the end: at least 98 % of their surface is wetted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sinks: Vec<String>,
    /// Wetted fraction of solids at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "Either<Wetted, Vec<Wetted>>")]
    pub wetted: Vec<Wetted>,
    /// Position of solids at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "Either<Position, Vec<Position>>")]
    pub position: Vec<Position>,
    /// Deflection of deformable solids at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "Either<Deflection, Vec<Deflection>>")]
    pub deflection: Vec<Deflection>,
    /// Values of columns of the time series.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "Either<SeriesBound, Vec<SeriesBound>>")]
    pub series: Vec<SeriesBound>,
}

/// An upper bound, 0 or more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpperBound {
    /// The bound.
    pub max: f64,
}

/// An upper bound of a speed, 0 or more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedBound {
    /// The bound.
    #[serde(with = "Si::<Speed>")]
    pub max: f64,
}

/// A period, measured from the maxima of the kinetic energy, of which each period has two.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectedPeriod {
    /// Mode number, for information only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<u32>,
    /// Expected period, above 0.
    #[serde(with = "Si::<Time>")]
    pub value: f64,
    /// Accepted relative deviation, above 0.
    pub tolerance: f64,
}

/// A frequency, measured as the inverse of a period.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectedFrequency {
    /// Mode number, for information only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<u32>,
    /// Deformable solid whose tip swings up and down with this frequency; by default it is that of the maxima of
    /// the kinetic energy.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solid: Option<String>,
    /// Expected frequency, above 0.
    #[serde(with = "Si::<Frequency>")]
    pub value: f64,
    /// Accepted relative deviation, above 0.
    pub tolerance: f64,
}

/// An expected contact angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactAngle {
    /// Name of the solid, or `walls` for the closed sides of the domain if no solid has this name.
    pub solid: String,
    /// Expected angle, 0 to 180 degrees; Young's angle by default. Required where the angle varies over the
    /// solid.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Angle>>")]
    pub value: Option<f64>,
    /// Accepted deviation, above 0.
    #[serde(with = "Si::<Angle>")]
    pub tolerance: f64,
}

/// An expected number of drops: `count`, or `min`, `max` or both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Drops {
    /// Exact number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<u32>,
    /// Smallest accepted number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<u32>,
    /// Largest accepted number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<u32>,
}

/// An expected extent of the liquid towards a side of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reach {
    /// Side of the domain.
    pub side: Side,
    /// Expected coordinate of the liquid's outermost point towards this side, along the axis of the side.
    #[serde(with = "Si::<Length>")]
    pub value: f64,
    /// Accepted deviation, above 0.
    #[serde(with = "Si::<Length>")]
    pub tolerance: f64,
}

/// An expected wetted fraction of a solid's surface, 0 to 1: `min`, `max` or both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wetted {
    /// Name of the solid.
    pub solid: String,
    /// Smallest accepted fraction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Largest accepted fraction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}

/// An expected deflection of a deformable solid: `min`, `max` or both. The deflection is the largest
/// displacement of a point of the solid from its place at the start, less the rigid motion of the anchored
/// parts, or of the whole solid if it has none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Deflection {
    /// Name of the solid.
    pub solid: String,
    /// Smallest accepted deflection, 0 or more.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Length>>")]
    pub min: Option<f64>,
    /// Largest accepted deflection, 0 or more.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Length>>")]
    pub max: Option<f64>,
}

/// An expected centre of mass of a solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Position {
    /// Name of the solid.
    pub solid: String,
    /// Expected centre of mass.
    #[serde(with = "Si::<Vec<Length>>")]
    pub value: Vec<f64>,
    /// Accepted distance from it, above 0.
    #[serde(with = "Si::<Length>")]
    pub tolerance: f64,
    /// Direction along which alone the distance is measured, for a solid that is free to move in others: pure
    /// numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along: Option<Vec<f64>>,
}

/// A side of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Lower end of x.
    Left,
    /// Upper end of x.
    Right,
    /// Lower end of y (3D only).
    Front,
    /// Upper end of y (3D only).
    Back,
    /// Lower end of the last axis.
    Bottom,
    /// Upper end of the last axis.
    Top,
}

/// The path of an entry of a key that has one table or a list of them.
pub(crate) fn entry(key: &str, count: usize, i: usize) -> String {
    if count > 1 { format!("expect.{key}.{i}") } else { format!("expect.{key}") }
}

/// Checks that a solid exists and deforms.
fn deforms(path: &str, solid: &str, named: &Names<'_>, v: &Validator) -> Result<(), SceneError> {
    v.known_solid(path, false, solid, &named.solids)?;
    if named.soft.contains(&solid) {
        return Ok(());
    }
    let message = format!("the solid `{solid}` does not deform");
    let help = "use material.neo_hookean, corotated or springs, or expect its `position`";
    Err(v.error(path, message, help))
}

/// What `[expect]` may name.
pub(in crate::file) struct Names<'a> {
    /// All solids.
    pub solids: Vec<&'a str>,
    /// Deformable solids.
    pub soft: Vec<&'a str>,
    /// Solids and walls with a contact angle, with Young's angle, rad; `None` where it varies.
    pub angles: Vec<(&'a str, Option<f64>)>,
}

impl Expect {
    /// Whether nothing is expected.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Checks the section of a scene, and makes its defaults explicit.
    ///
    /// # Errors
    /// [`SceneError`] at the value.
    pub(in crate::file) fn validate(&mut self, named: &Names<'_>, v: &Validator) -> Result<(), SceneError> {
        let bounds = [
            ("volume_drift", self.volume_drift.map(|b| b.max)),
            ("momentum_error", self.momentum_error.map(|b| b.max)),
            ("energy_growth", self.energy_growth.map(|b| b.max)),
            ("max_speed", self.max_speed.map(|b| b.max)),
        ];
        for (key, bound) in bounds {
            bound.map_or(Ok(()), |max| v.not_negative(&format!("expect.{key}.max"), "a bound", max))?;
        }
        let rates = [
            ("period", self.period.map(|p| [p.value, p.tolerance])),
            ("frequency", self.frequency.as_ref().map(|f| [f.value, f.tolerance])),
        ];
        for (key, rate) in rates {
            let Some([value, tolerance]) = rate else { continue };
            v.positive(&format!("expect.{key}.value"), &format!("the {key}"), value)?;
            v.positive(&format!("expect.{key}.tolerance"), "the tolerance", tolerance)?;
        }
        for (name, max) in self.repairs.bounds() {
            v.not_negative(&format!("expect.repairs.{name}"), "a bound", max)?;
        }
        self.drops.as_mut().map_or(Ok(()), |drops| drops.validate(v))?;
        self.validate_reach(v)?;
        self.validate_angles(named, v)?;
        self.validate_solids(named, v)?;
        self.validate_deflection(named, v)?;
        for (i, bound) in self.series.iter().enumerate() {
            bound.validate(&entry("series", self.series.len(), i), v)?;
        }
        let swinging = self.frequency.as_ref().and_then(|f| f.solid.as_deref());
        swinging.map_or(Ok(()), |solid| deforms("expect.frequency.solid", solid, named, v))
    }

    fn validate_reach(&self, v: &Validator) -> Result<(), SceneError> {
        for (i, reach) in self.reach.iter().enumerate() {
            let path = entry("reach", self.reach.len(), i);
            if v.dim == 2 && matches!(reach.side, Side::Front | Side::Back) {
                let message = "a scene of 2 dimensions has no such side";
                return Err(v.error(&format!("{path}.side"), message, "accepted: left, right, bottom, top"));
            }
            v.positive(&format!("{path}.tolerance"), "the tolerance", reach.tolerance)?;
        }
        Ok(())
    }

    fn validate_angles(&mut self, named: &Names<'_>, v: &Validator) -> Result<(), SceneError> {
        let names: Vec<&str> = named.angles.iter().map(|a| a.0).collect();
        let count = self.contact_angle.len();
        for (i, expected) in self.contact_angle.iter_mut().enumerate() {
            let path = entry("contact_angle", count, i);
            v.known_solid(&format!("{path}.solid"), false, &expected.solid, &names)?;
            let young = named.angles.iter().find(|a| a.0 == expected.solid).and_then(|a| a.1);
            expected.value = expected.value.or(young);
            let Some(value) = expected.value else {
                let solid = &expected.solid;
                let message =
                    format!("Young's angle varies over `{solid}`: the expected angle must be given");
                return Err(v.error(&path, message, "add `value = \"90 deg\"`"));
            };
            v.angle(&format!("{path}.value"), value)?;
            v.positive(&format!("{path}.tolerance"), "the tolerance", expected.tolerance)?;
        }
        Ok(())
    }

    fn validate_solids(&mut self, named: &Names<'_>, v: &Validator) -> Result<(), SceneError> {
        let known = |path: String, name: &str| v.known_solid(&path, false, name, &named.solids);
        for (i, name) in self.floats.iter().enumerate() {
            known(format!("expect.floats.{i}"), name)?;
        }
        for (i, name) in self.sinks.iter().enumerate() {
            let path = format!("expect.sinks.{i}");
            known(path.clone(), name)?;
            if self.floats.contains(name) {
                let message = format!("`{name}` cannot float and sink");
                return Err(v.error(&path, message, "remove it from `floats` or from `sinks`"));
            }
        }
        let count = self.wetted.len();
        for (i, wetted) in self.wetted.iter_mut().enumerate() {
            let path = entry("wetted", count, i);
            known(format!("{path}.solid"), &wetted.solid)?;
            if wetted.min.is_none() && wetted.max.is_none() {
                return Err(v.error(&path, "the wetted share is not bounded", "give `min`, `max` or both"));
            }
            let [min, max] = [*wetted.min.get_or_insert(0.0), *wetted.max.get_or_insert(1.0)];
            v.within(&format!("{path}.min"), "the share", min, [0.0, 1.0])?;
            v.within(&format!("{path}.max"), "the share", max, [min, 1.0])?;
        }
        let count = self.position.len();
        for (i, position) in self.position.iter_mut().enumerate() {
            let path = entry("position", count, i);
            known(format!("{path}.solid"), &position.solid)?;
            v.dimension(&format!("{path}.value"), &position.value)?;
            v.positive(&format!("{path}.tolerance"), "the tolerance", position.tolerance)?;
            let along = position.along.as_mut();
            along.map_or(Ok(()), |along| v.direction(&format!("{path}.along"), along, v.dim))?;
        }
        Ok(())
    }

    fn validate_deflection(&mut self, named: &Names<'_>, v: &Validator) -> Result<(), SceneError> {
        let count = self.deflection.len();
        for (i, deflection) in self.deflection.iter_mut().enumerate() {
            let path = entry("deflection", count, i);
            let solid = &deflection.solid;
            deforms(&format!("{path}.solid"), solid, named, v)?;
            if deflection.min.is_none() && deflection.max.is_none() {
                return Err(v.error(&path, "the deflection is not bounded", "give `min`, `max` or both"));
            }
            let min = *deflection.min.get_or_insert(0.0);
            v.not_negative(&format!("{path}.min"), "a deflection", min)?;
            let Some(max) = deflection.max else { continue };
            v.not_negative(&format!("{path}.max"), "a deflection", max)?;
            if min > max {
                let message = format!("`max` ({max} m) is below `min` ({min} m)");
                return Err(v.error(&format!("{path}.max"), message, "swap them"));
            }
        }
        Ok(())
    }
}

impl Drops {
    /// Smallest and largest accepted number.
    pub fn range(&self) -> [u32; 2] {
        [self.count.or(self.min).unwrap_or(0), self.count.or(self.max).unwrap_or(u32::MAX)]
    }

    fn validate(&mut self, v: &Validator) -> Result<(), SceneError> {
        if self.count.is_some() == (self.min.is_some() || self.max.is_some()) {
            let help = "give `count`, or `min` and/or `max`";
            return Err(v.error("expect.drops", "the expected number of drops is not given", help));
        }
        let [min, max] = self.range();
        if min > max {
            let message = format!("`max` ({max}) is below `min` ({min})");
            return Err(v.error("expect.drops.max", message, "swap them"));
        }
        *self = Self { count: None, min: Some(min), max: Some(max).filter(|max| *max < u32::MAX) };
        Ok(())
    }
}
