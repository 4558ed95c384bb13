//! Materials of solids: as written in a scene file, in SI, and the way from one to the other and back. A key of a material is here alone.

use super::grammar::{AngularVelocity, KeyframeFile, Length, Pressure, Speed, Tension};
use super::resolve::Resolver;
use crate::error::SceneError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Material of a solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MaterialFile {
    /// Rigid: moves freely, or is fixed.
    Rigid(RigidFile),
    /// Rigid, with prescribed motion.
    Kinematic(KinematicFile),
    /// Deformable: masses and springs, as in the paper.
    Springs(SpringsFile),
    /// Deformable: compressible neo-Hookean solid.
    NeoHookean(ElasticFile),
    /// Deformable: corotated linear elasticity.
    Corotated(ElasticFile),
    /// A thin sheet. This version does not run it.
    #[schemars(skip)]
    Shell(ShellFile),
    /// A thin thread. This version does not run it.
    #[schemars(skip)]
    Rod(RodFile),
}

/// `rigid`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigidFile {
    /// Whether the solid is fixed; `false` by default.
    #[serde(default)]
    pub fixed: bool,
}

/// `kinematic`: prescribed motion by velocities or by keyframes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KinematicFile {
    /// Constant velocity; 0 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<Speed>>,
    /// Constant angular velocity, one entry in 2D and three in 3D; 0 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angular_velocity: Option<Vec<AngularVelocity>>,
    /// Displacements at given times: linear in between, constant before and after.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keyframes: Option<Vec<KeyframeFile>>,
}

/// `springs`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringsFile {
    /// Stiffness of each spring, above 0.
    pub stiffness: Tension,
    /// Damping ratio of the lowest elastic mode: damping over critical damping; 0 to 100, 0 by default.
    #[serde(default)]
    pub damping_ratio: f64,
}

/// `neo_hookean`, `corotated`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElasticFile {
    /// Young's modulus, above 0.
    pub young_modulus: Pressure,
    /// Poisson's ratio, -0.99 to 0.499.
    pub poisson_ratio: f64,
    /// Damping ratio of the lowest elastic mode: damping over critical damping; 0 to 100, 0 by default.
    #[serde(default)]
    pub damping_ratio: f64,
}

/// `shell`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShellFile {
    /// Young's modulus, above 0.
    pub young_modulus: Pressure,
    /// Poisson's ratio, -0.99 to 0.499.
    pub poisson_ratio: f64,
    /// Thickness.
    pub thickness: Length,
    /// Damping ratio of the lowest elastic mode: damping over critical damping; 0 to 100, 0 by default.
    #[serde(default)]
    pub damping_ratio: f64,
}

/// `rod`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RodFile {
    /// Young's modulus, above 0.
    pub young_modulus: Pressure,
    /// Radius of the cross-section.
    pub radius: Length,
    /// Damping ratio of the lowest elastic mode: damping over critical damping; 0 to 100, 0 by default.
    #[serde(default)]
    pub damping_ratio: f64,
}

/// Material of a solid.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Rigid.
    Rigid {
        /// Whether it is fixed in space.
        fixed: bool,
    },
    /// Prescribed motion.
    Kinematic {
        /// Constant velocity, m/s.
        velocity: Vec<f64>,
        /// Constant angular velocity, rad/s: one entry in 2D, three in 3D.
        angular_velocity: Vec<f64>,
        /// Time, s, and displacement, m; times increase.
        keyframes: Vec<(f64, Vec<f64>)>,
    },
    /// Mass-spring network.
    Springs {
        /// Stiffness, N/m.
        stiffness: f64,
        /// Fraction of critical damping.
        damping_ratio: f64,
    },
    /// Compressible neo-Hookean.
    NeoHookean(Elastic),
    /// Corotated linear elasticity.
    Corotated(Elastic),
    /// Thin shell.
    Shell {
        /// Constants.
        elastic: Elastic,
        /// Thickness, m.
        thickness: f64,
    },
    /// Thin rod.
    Rod {
        /// Young modulus, Pa.
        young_modulus: f64,
        /// Radius of the section, m.
        radius: f64,
        /// Fraction of critical damping.
        damping_ratio: f64,
    },
}

impl Material {
    /// The material in the grammar of a scene file.
    pub(super) fn to_file(&self) -> MaterialFile {
        match self {
            Self::Rigid { fixed } => MaterialFile::Rigid(RigidFile { fixed: *fixed }),
            Self::Kinematic { velocity, angular_velocity, keyframes } => {
                let has_velocity = keyframes.is_empty();
                MaterialFile::Kinematic(KinematicFile {
                    velocity: has_velocity.then(|| velocity.iter().map(|&v| Speed(v)).collect()),
                    angular_velocity: has_velocity
                        .then(|| angular_velocity.iter().map(|&w| AngularVelocity(w)).collect()),
                    keyframes: (!has_velocity).then(|| KeyframeFile::list(keyframes)),
                })
            }
            Self::Springs { stiffness, damping_ratio } => MaterialFile::Springs(SpringsFile {
                stiffness: Tension(*stiffness),
                damping_ratio: *damping_ratio,
            }),
            Self::NeoHookean(e) => MaterialFile::NeoHookean(e.to_file()),
            Self::Corotated(e) => MaterialFile::Corotated(e.to_file()),
            Self::Shell { elastic: e, thickness } => MaterialFile::Shell(ShellFile {
                young_modulus: Pressure(e.young_modulus),
                poisson_ratio: e.poisson_ratio,
                thickness: Length::metres(*thickness),
                damping_ratio: e.damping_ratio,
            }),
            Self::Rod { young_modulus, radius, damping_ratio } => MaterialFile::Rod(RodFile {
                young_modulus: Pressure(*young_modulus),
                radius: Length::metres(*radius),
                damping_ratio: *damping_ratio,
            }),
        }
    }

    /// Whether a solid of this material deforms.
    pub fn deforms(&self) -> bool {
        matches!(self, Self::Springs { .. } | Self::NeoHookean(_) | Self::Corotated(_))
    }
}

/// Elastic constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// Young modulus, Pa.
    pub young_modulus: f64,
    /// Poisson ratio.
    pub poisson_ratio: f64,
    /// Fraction of critical damping.
    pub damping_ratio: f64,
}

impl Elastic {
    fn to_file(self) -> ElasticFile {
        ElasticFile {
            young_modulus: Pressure(self.young_modulus),
            poisson_ratio: self.poisson_ratio,
            damping_ratio: self.damping_ratio,
        }
    }
}

impl Resolver {
    fn elastic(
        &self,
        path: &str,
        young: Pressure,
        poisson: f64,
        damping: f64,
    ) -> Result<Elastic, SceneError> {
        let at = |key: &str| format!("{path}.{key}");
        Ok(Elastic {
            young_modulus: self.positive(&at("young_modulus"), "the Young modulus", young.0)?,
            poisson_ratio: self.poisson(&at("poisson_ratio"), poisson)?,
            damping_ratio: self.within(&at("damping_ratio"), "the damping ratio", damping, 0.0, 100.0)?,
        })
    }

    fn poisson(&self, path: &str, ratio: f64) -> Result<f64, SceneError> {
        if ratio >= 0.5 {
            let message = format!(
                "the Poisson ratio is {ratio}, but must be below 0.5, the limit of incompressibility"
            );
            return Err(self.error(
                path,
                message,
                "accepted: -0.99 to 0.499; rubber and gels have 0.45 to 0.49",
            ));
        }
        self.within(path, "the Poisson ratio", ratio, -0.99, 0.499)
    }

    pub fn material(&self, path: &str, m: &MaterialFile) -> Result<Material, SceneError> {
        let at = |key: &str| format!("{path}.{key}");
        let damping = |p: String, v: f64| self.within(&p, "the damping ratio", v, 0.0, 100.0);
        Ok(match m {
            MaterialFile::Rigid(r) => Material::Rigid { fixed: r.fixed },
            MaterialFile::Kinematic(k) => self.kinematic(&at("kinematic"), k)?,
            MaterialFile::Springs(s) => Material::Springs {
                stiffness: self.positive(&at("springs.stiffness"), "the stiffness", s.stiffness.0)?,
                damping_ratio: damping(at("springs.damping_ratio"), s.damping_ratio)?,
            },
            MaterialFile::NeoHookean(e) => Material::NeoHookean(self.elastic(
                &at("neo_hookean"),
                e.young_modulus,
                e.poisson_ratio,
                e.damping_ratio,
            )?),
            MaterialFile::Corotated(e) => Material::Corotated(self.elastic(
                &at("corotated"),
                e.young_modulus,
                e.poisson_ratio,
                e.damping_ratio,
            )?),
            MaterialFile::Shell(s) => Material::Shell {
                elastic: self.elastic(&at("shell"), s.young_modulus, s.poisson_ratio, s.damping_ratio)?,
                thickness: self.positive_length(&at("shell.thickness"), "the thickness", s.thickness)?,
            },
            MaterialFile::Rod(s) => Material::Rod {
                young_modulus: self.positive(
                    &at("rod.young_modulus"),
                    "the Young modulus",
                    s.young_modulus.0,
                )?,
                radius: self.positive_length(&at("rod.radius"), "the radius", s.radius)?,
                damping_ratio: damping(at("rod.damping_ratio"), s.damping_ratio)?,
            },
        })
    }

    fn kinematic(&self, path: &str, k: &KinematicFile) -> Result<Material, SceneError> {
        let rotation_components = if self.dim == 2 { 1 } else { 3 };
        let angular: Vec<f64> = k
            .angular_velocity
            .as_ref()
            .map_or(vec![0.0; rotation_components], |w| w.iter().map(|x| x.0).collect());
        if angular.len() != rotation_components {
            let message = format!("found {} entries in the angular velocity", angular.len());
            return Err(self.error(
                &format!("{path}.angular_velocity"),
                message,
                format!("give {rotation_components} in a scene of {} dimensions", self.dim),
            ));
        }
        let keyframes = self.keyframes(path, k.keyframes.as_deref())?;
        if !keyframes.is_empty() && (k.velocity.is_some() || k.angular_velocity.is_some()) {
            return Err(self.error(path, "both a velocity and keyframes are given", "remove one of them"));
        }
        let velocity = self.velocity(&format!("{path}.velocity"), k.velocity.as_ref())?;
        self.check_prescribed_speed(
            &format!("{path}.velocity"),
            velocity.iter().map(|v| v * v).sum::<f64>().sqrt(),
        )?;
        Ok(Material::Kinematic { velocity, angular_velocity: angular, keyframes })
    }
}
