//! `[liquid]`: properties of the liquid, gravity, and the bodies of liquid at the start.

use super::is_false;
use crate::error::SceneError;
use crate::file::shape::{Bounds, ShapeSpec};
use crate::file::text::{Acceleration, Density, DynamicViscosity, KinematicViscosity, Si, Speed, short};
use crate::file::validator::Validator;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[liquid]`: properties of the liquid, gravity, and the bodies of liquid at the start.
#[derive(Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Liquid {
    /// Density, above 0.
    #[serde(with = "Si::<Density>")]
    pub density: f64,
    /// Kinematic viscosity, 0 or more. Either this key or `dynamic_viscosity` is required.
    #[serde(default, with = "Si::<KinematicViscosity>")]
    pub kinematic_viscosity: f64,
    /// Dynamic viscosity, 0 or more; given instead of `kinematic_viscosity`.
    #[serde(default, skip_serializing, with = "Si::<Option<DynamicViscosity>>")]
    dynamic_viscosity: Option<f64>,
    /// Gravitational acceleration along each axis; 0 by default.
    #[serde(default, with = "Si::<Vec<Acceleration>>")]
    pub gravity: Vec<f64>,
    /// Bodies of liquid at the start, at least one. Where bodies overlap, the first one counts.
    #[serde(default, rename = "body")]
    pub bodies: Vec<Body>,
}

identity_text!(Liquid, l => density: l.density, kinematic_viscosity: l.kinematic_viscosity, gravity: l.gravity,
    bodies: l.bodies);

/// `[[liquid.body]]`: a region of liquid at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Shape of the region. Solids and the sides of the domain cut off the part that they overlap.
    pub shape: ShapeSpec,
    /// Velocity at the start; 0 by default.
    #[serde(default, with = "Si::<Vec<Speed>>")]
    pub velocity: Vec<f64>,
    /// Whether solids cut off a part of the body on purpose, as where half a ball of liquid is placed on a
    /// plate; `false` by default. With `false`, `check` and `run` warn if a solid cuts a ball, an ellipsoid or
    /// a perturbed ball by more than a cell.
    #[serde(default, skip_serializing_if = "is_false")]
    pub displaced: bool,
}

impl Liquid {
    /// Checks the section of a scene, and makes its defaults explicit.
    ///
    /// # Errors
    /// [`SceneError`] at the value.
    pub(in crate::file) fn validate(&mut self, v: &mut Validator) -> Result<(), SceneError> {
        v.positive("liquid.density", "the density", self.density)?;
        let (kinematic, dynamic) = ("liquid.kinematic_viscosity", "liquid.dynamic_viscosity");
        match (v.source.has(kinematic), self.dynamic_viscosity.take()) {
            (true, None) => v.not_negative(kinematic, "the viscosity", self.kinematic_viscosity)?,
            (false, Some(viscosity)) => {
                v.not_negative(dynamic, "the viscosity", viscosity)?;
                self.kinematic_viscosity = viscosity / self.density;
            }
            (true, Some(_)) => {
                let message = "both `kinematic_viscosity` and `dynamic_viscosity` are given";
                return Err(v.error(dynamic, message, "remove one of them"));
            }
            (false, None) => {
                let help = "add `kinematic_viscosity = \"1 mm^2/s\"` (0 for an inviscid liquid)";
                return Err(v.error("liquid", "the viscosity is missing", help));
            }
        }
        v.vector_or_zero("liquid.gravity", &mut self.gravity)?;
        if self.bodies.is_empty() {
            let help = "add a [[liquid.body]] with a shape";
            return Err(v.error("liquid", "the scene has no liquid body", help));
        }
        for (i, body) in self.bodies.iter_mut().enumerate() {
            let path = format!("liquid.body.{i}");
            v.vector_or_zero(&format!("{path}.velocity"), &mut body.velocity)?;
            body.shape.validate(&format!("{path}.shape"), v)?;
            check_inside(&format!("{path}.shape"), &body.shape, v)?;
        }
        Ok(())
    }
}

/// Refuses a body outside the domain. Walls may cut a body; a cut round shape gets a warning, since boxes, cylinders and the
/// like are often extended beyond walls on purpose.
fn check_inside(path: &str, shape: &ShapeSpec, v: &mut Validator) -> Result<(), SceneError> {
    let Some(Bounds { lower, upper }) = shape.bounds(v.dim) else { return Ok(()) };
    let mut cut = false;
    for i in 0..v.dim {
        if upper[i] <= 0.0 || lower[i] >= v.size[i] {
            let (axis, end) = (["x", "y", "z"][i], v.size[i]);
            let message = format!(
                "the liquid is outside the domain: it reaches from {axis} = {} m to {} m",
                short(lower[i]),
                short(upper[i])
            );
            let help = format!("the domain reaches from {axis} = 0 m to {} m", short(end));
            return Err(v.error(&v.source.first_inside(path), message, help));
        }
        let slack = 1e-6 * v.dx;
        cut |= (lower[i].is_finite() && lower[i] < -slack)
            || (upper[i].is_finite() && upper[i] > v.size[i] + slack);
    }
    let round = matches!(
        shape,
        ShapeSpec::Ball { .. } | ShapeSpec::PerturbedBall { .. } | ShapeSpec::Ellipsoid { .. }
    );
    if cut && round {
        v.warn(path, "the liquid body extends outside the domain; the part outside is removed");
    }
    Ok(())
}
