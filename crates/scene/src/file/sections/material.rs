//! Materials of solids.

use super::keyframe::Keyframe;
use crate::error::SceneError;
use crate::file::text::{AngularVelocity, Length, Pressure, Si, Speed, Tension};
use crate::file::validator::{Validator, under};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Material of a solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Material {
    /// Rigid: moves freely, or is fixed.
    Rigid {
        /// Whether the solid is fixed; `false` by default.
        #[serde(default)]
        fixed: bool,
    },
    /// Rigid, with prescribed motion by velocities or by keyframes.
    Kinematic {
        /// Constant velocity; 0 by default.
        #[serde(default, skip_serializing_if = "Vec::is_empty", with = "Si::<Vec<Speed>>")]
        velocity: Vec<f64>,
        /// Constant angular velocity, one entry in 2D and three in 3D; 0 by default.
        #[serde(default, skip_serializing_if = "Vec::is_empty", with = "Si::<Vec<AngularVelocity>>")]
        angular_velocity: Vec<f64>,
        /// Displacements at given times: linear in between, constant before and after.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        keyframes: Vec<Keyframe>,
    },
    /// Deformable: masses and springs, as in the paper.
    Springs {
        /// Stiffness of each spring, above 0.
        #[serde(with = "Si::<Tension>")]
        stiffness: f64,
        /// Damping ratio of the lowest elastic mode: damping over critical damping; 0 to 100, 0 by default.
        #[serde(default)]
        damping_ratio: f64,
    },
    /// Deformable: compressible neo-Hookean solid.
    NeoHookean(Elastic),
    /// Deformable: corotated linear elasticity.
    Corotated(Elastic),
    /// A thin sheet. This version does not run it.
    #[schemars(skip)]
    Shell {
        /// Young's modulus, above 0.
        #[serde(with = "Si::<Pressure>")]
        young_modulus: f64,
        /// Poisson's ratio, -0.99 to 0.499.
        poisson_ratio: f64,
        /// Thickness.
        #[serde(with = "Si::<Length>")]
        thickness: f64,
        /// Damping ratio of the lowest elastic mode: damping over critical damping; 0 to 100, 0 by default.
        #[serde(default)]
        damping_ratio: f64,
    },
    /// A thin thread. This version does not run it.
    #[schemars(skip)]
    Rod {
        /// Young's modulus, above 0.
        #[serde(with = "Si::<Pressure>")]
        young_modulus: f64,
        /// Radius of the cross-section.
        #[serde(with = "Si::<Length>")]
        radius: f64,
        /// Damping ratio of the lowest elastic mode: damping over critical damping; 0 to 100, 0 by default.
        #[serde(default)]
        damping_ratio: f64,
    },
}

/// `neo_hookean`, `corotated`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Elastic {
    /// Young's modulus, above 0.
    #[serde(with = "Si::<Pressure>")]
    pub young_modulus: f64,
    /// Poisson's ratio, -0.99 to 0.499.
    pub poisson_ratio: f64,
    /// Damping ratio of the lowest elastic mode: damping over critical damping; 0 to 100, 0 by default.
    #[serde(default)]
    pub damping_ratio: f64,
}

impl Material {
    /// Whether forces move the solid.
    pub fn is_moved_by_forces(&self) -> bool {
        !matches!(self, Self::Rigid { fixed: true } | Self::Kinematic { .. })
    }

    /// Whether a solid of this material deforms.
    pub fn deforms(&self) -> bool {
        matches!(self, Self::Springs { .. } | Self::NeoHookean(_) | Self::Corotated(_))
    }

    /// Whether this version runs solids of this material.
    pub fn is_supported(&self) -> bool {
        !matches!(self, Self::Shell { .. } | Self::Rod { .. })
    }

    /// Leaves out velocities where keyframes are given.
    pub(super) fn omit_unused(&mut self) {
        if let Self::Kinematic { velocity, angular_velocity, keyframes } = self
            && !keyframes.is_empty()
        {
            (*velocity, *angular_velocity) = (Vec::new(), Vec::new());
        }
    }

    /// Checks the material, and makes its defaults explicit.
    ///
    /// # Errors
    /// [`SceneError`] at the value; `path` is that of the material.
    pub(super) fn validate(&mut self, path: &str, v: &Validator) -> Result<(), SceneError> {
        let young = |path: &str, value: f64| v.positive(path, "the Young modulus", value);
        let damping = |path: &str, value: f64| v.within(path, "the damping ratio", value, [0.0, 100.0]);
        let elastic = |at: &dyn Fn(&str) -> String, e: &Elastic| {
            young(&at("young_modulus"), e.young_modulus)?;
            poisson(&at("poisson_ratio"), e.poisson_ratio, v)?;
            damping(&at("damping_ratio"), e.damping_ratio)
        };
        match self {
            Self::Rigid { .. } => Ok(()),
            Self::Kinematic { velocity, angular_velocity, keyframes } => Keyframe::validate_or_velocities(
                &format!("{path}.kinematic"),
                keyframes,
                [velocity, angular_velocity],
                v,
            ),
            Self::Springs { stiffness, damping_ratio } => {
                let at = under(path, "springs");
                v.positive(&at("stiffness"), "the stiffness", *stiffness)?;
                damping(&at("damping_ratio"), *damping_ratio)
            }
            Self::NeoHookean(constants) => elastic(&under(path, "neo_hookean"), constants),
            Self::Corotated(constants) => elastic(&under(path, "corotated"), constants),
            Self::Shell { young_modulus, poisson_ratio, thickness, damping_ratio } => {
                let at = under(path, "shell");
                young(&at("young_modulus"), *young_modulus)?;
                poisson(&at("poisson_ratio"), *poisson_ratio, v)?;
                damping(&at("damping_ratio"), *damping_ratio)?;
                v.positive(&at("thickness"), "the thickness", *thickness)
            }
            Self::Rod { young_modulus, radius, damping_ratio } => {
                let at = under(path, "rod");
                young(&at("young_modulus"), *young_modulus)?;
                v.positive(&at("radius"), "the radius", *radius)?;
                damping(&at("damping_ratio"), *damping_ratio)
            }
        }
    }
}

fn poisson(path: &str, ratio: f64, v: &Validator) -> Result<(), SceneError> {
    if ratio >= 0.5 {
        let message =
            format!("the Poisson ratio is {ratio}, but must be below 0.5, the limit of incompressibility");
        let help = "accepted: -0.99 to 0.499; rubber and gels have 0.45 to 0.49";
        return Err(v.error(path, message, help));
    }
    v.within(path, "the Poisson ratio", ratio, [-0.99, 0.499])
}
