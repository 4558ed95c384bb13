//! `[[solid]]`: the solids.

use super::is_zero;
use super::keyframe::Keyframe;
use super::material::Material;
use crate::error::SceneError;
use crate::file::shape::{Bounds, ShapeSpec};
use crate::file::text::{Density, Si, Speed};
use crate::file::validator::{Validator, under};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[[solid]]`: a solid.
#[derive(Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Solid {
    /// Name, used in `[tension]`, `[expect]` and file names. It has the characters of a scene's name, and is
    /// not `liquid_air`.
    pub name: String,
    /// Density, above 0; required unless the solid is fixed or kinematic.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Density>>")]
    pub density: Option<f64>,
    /// Shape at the start.
    pub shape: ShapeSpec,
    /// Mesh of the solid.
    // In memory this is the length of its edges, m, and 0 where it is not given.
    #[serde(default, rename = "mesh", skip_serializing_if = "is_zero", with = "mesh_form")]
    #[schemars(with = "mesh_form::SolidMesh")]
    pub mesh_edge: f64,
    /// Material, which also determines whether the solid moves and deforms.
    pub material: Material,
    /// Velocity at the start of a solid that moves freely or deforms; 0 by default.
    #[serde(default, with = "Si::<Vec<Speed>>")]
    pub velocity: Vec<f64>,
    /// Collisions with other solids and with the closed sides of the domain.
    #[serde(default)]
    pub collision: Collision,
    /// Shapes within which the vertices of a deformable solid are fixed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fixed: Vec<ShapeSpec>,
    /// Parts of a deformable solid with prescribed motion.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub moved: Vec<Moved>,
}

identity_text!(Solid, s => name: s.name, density: s.density, shape: s.shape, mesh_edge: s.mesh_edge, material: s.material,
    velocity: s.velocity, restitution: s.collision.restitution, friction: s.collision.friction, fixed: s.fixed, moved: s.moved);

/// A part of a deformable solid with prescribed motion: a velocity, or keyframes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Moved {
    /// Shape that contains the vertices of the part at the start.
    pub shape: ShapeSpec,
    /// Constant velocity.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "Si::<Vec<Speed>>")]
    pub velocity: Vec<f64>,
    /// Displacements at given times: linear in between, constant before and after, 0 at time 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keyframes: Vec<Keyframe>,
}

/// Coefficients of collisions. For two solids the geometric mean of their coefficients applies, at a side of
/// the domain that of the solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Collision {
    /// Restitution of a rigid solid: speed after an impact over that before it; 0 to 1, 0.3 by default.
    pub restitution: f64,
    /// Coefficient of Coulomb friction, 0 or more; 0.3 by default.
    pub friction: f64,
}

impl Default for Collision {
    fn default() -> Self {
        Self { restitution: meniscus_sim::DEFAULT_RESTITUTION, friction: meniscus_sim::DEFAULT_FRICTION }
    }
}

/// The table of a solid's mesh.
mod mesh_form {
    use crate::file::text::{Length, Si};
    use schemars::JsonSchema;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// Mesh of a solid.
    #[derive(Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct SolidMesh {
        /// Length of the edges of the mesh, above 0; `dx / 1.5` by default. Not allowed with a volume mesh from a
        /// file.
        #[serde(default, with = "Si::<Length>")]
        edge: f64,
    }

    #[allow(clippy::trivially_copy_pass_by_ref)]
    pub fn serialize<S: Serializer>(edge: &f64, s: S) -> Result<S::Ok, S::Error> {
        SolidMesh { edge: *edge }.serialize(s)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
        SolidMesh::deserialize(d).map(|mesh| mesh.edge)
    }
}

impl Solid {
    /// Checks all solids, and makes their defaults explicit.
    ///
    /// # Errors
    /// [`SceneError`] at the value.
    pub(in crate::file) fn validate_all(solids: &mut [Self], v: &mut Validator) -> Result<(), SceneError> {
        for i in 0..solids.len() {
            let (before, rest) = solids.split_at_mut(i);
            let Some(solid) = rest.first_mut() else { break };
            solid.check_name(&format!("solid.{i}.name"), before, v)?;
            solid.validate(&format!("solid.{i}"), v)?;
        }
        Ok(())
    }

    fn validate(&mut self, path: &str, v: &mut Validator) -> Result<(), SceneError> {
        let at = |key: &str| format!("{path}.{key}");
        self.shape.validate(&at("shape"), v)?;
        self.check_inside(&at("shape"), v)?;
        self.material.validate(&at("material"), v)?;
        self.check_density(path, v)?;
        self.validate_mesh_edge(&at("mesh.edge"), v)?;
        if self.material.deforms() {
            self.check_meshable(path, v)?;
        }
        for (j, fixed) in self.fixed.iter_mut().enumerate() {
            fixed.validate(&format!("{path}.fixed.{j}"), v)?;
        }
        for (j, moved) in self.moved.iter_mut().enumerate() {
            moved.validate(&format!("{path}.moved.{j}"), v)?;
        }
        v.vector_or_zero(&at("velocity"), &mut self.velocity)?;
        let at = under(path, "collision");
        v.within(&at("restitution"), "the restitution", self.collision.restitution, [0.0, 1.0])?;
        v.not_negative(&at("friction"), "the friction", self.collision.friction)
    }

    /// Leaves out what is not written: zero velocities of what moves by keyframes, and the edge length where elements come from a file.
    pub(in crate::file) fn omit_unused(&mut self) {
        if self.shape.volume_file().is_some() {
            self.mesh_edge = 0.0;
        }
        self.material.omit_unused();
        self.moved
            .iter_mut()
            .filter(|part| !part.keyframes.is_empty())
            .for_each(|part| part.velocity.clear());
    }

    /// Refuses a name that is not safe as a file name, has a meaning of its own, or is that of one of the solids `before`.
    fn check_name(&self, path: &str, before: &[Self], v: &Validator) -> Result<(), SceneError> {
        let name = &self.name;
        v.check_file_name(path, name)?;
        if name == "liquid_air" {
            let help = "choose another name: `tension.liquid_air` is the tension of the liquid's surface";
            return Err(v.error(path, "a solid cannot be called `liquid_air`", help));
        }
        if let Some(first) = before.iter().position(|other| other.name == *name) {
            let help = format!("solid {first} (counted from 0) already has this name: rename one of them");
            return Err(v.error(path, format!("two solids are called `{name}`"), help));
        }
        Ok(())
    }

    /// Only a solid that forces do not move may have no density.
    fn check_density(&self, path: &str, v: &Validator) -> Result<(), SceneError> {
        let is_prescribed =
            matches!(self.material, Material::Rigid { fixed: true } | Material::Kinematic { .. });
        match self.density {
            Some(density) => v.positive(&format!("{path}.density"), "the density", density),
            None if is_prescribed => Ok(()),
            None => {
                let message = format!("the density of `{}` is missing", self.name);
                Err(v.error(path, message, "add `density = \"2.5 g/cm^3\"`"))
            }
        }
    }

    fn validate_mesh_edge(&mut self, path: &str, v: &Validator) -> Result<(), SceneError> {
        match self.mesh_edge != 0.0 || v.source.has(path) {
            true if self.shape.volume_file().is_some() => {
                let help =
                    "remove `mesh`, or give a closed surface (.obj, .ply, .stl) to be filled with elements";
                let message = "the elements of this solid come from its mesh file: `edge` has no effect";
                Err(v.error(path, message, help))
            }
            true => v.positive(path, "the edge length", self.mesh_edge),
            false => {
                self.mesh_edge = v.dx / 1.5;
                Ok(())
            }
        }
    }

    fn check_inside(&self, path: &str, v: &Validator) -> Result<(), SceneError> {
        let Some(bounds) = self.shape.bounds(v.dim) else { return Ok(()) };
        match bounds.describe_outside(&v.size, 1e-6 * v.dx) {
            Some((reach, help)) => {
                let message = format!("the solid `{}` extends outside the domain: it {reach}", self.name);
                Err(v.error(&v.source.first_inside(path), message, help))
            }
            None => Ok(()),
        }
    }

    /// Refuses an unbounded deformable solid. Warns if the requested edge length exceeds the thickness of a box.
    fn check_meshable(&self, path: &str, v: &mut Validator) -> Result<(), SceneError> {
        let Some(Bounds { lower, upper }) = self.shape.bounds(v.dim) else { return Ok(()) };
        let name = &self.name;
        if lower.iter().zip(&upper).any(|(l, u)| !(u - l).is_finite()) {
            let message = format!("the deformable solid `{name}` is unbounded: it cannot be meshed");
            let help = "use a bounded shape, such as a box in place of a half_space";
            return Err(v.error(&v.source.first_inside(&format!("{path}.shape")), message, help));
        }
        let ShapeSpec::Box { half_size, .. } = &self.shape else { return Ok(()) };
        let thinnest = 2.0 * half_size.iter().copied().fold(f64::INFINITY, f64::min);
        let (at, edge) = (format!("{path}.mesh.edge"), self.mesh_edge);
        if v.source.has(&at) && edge > thinnest * (1.0 + 1e-9) {
            let message = format!(
                "a mesh edge of {edge:.3e} m exceeds the thickness of `{name}` ({thinnest:.3e} m): shorter edges are used"
            );
            v.warn(&at, message);
        }
        Ok(())
    }
}

impl Moved {
    fn validate(&mut self, path: &str, v: &Validator) -> Result<(), SceneError> {
        self.shape.validate(&format!("{path}.shape"), v)?;
        Keyframe::validate(path, &self.keyframes, v)?;
        let velocity = format!("{path}.velocity");
        match (v.source.has(&velocity), self.keyframes.is_empty()) {
            (true, false) => {
                return Err(v.error(path, "both a velocity and keyframes are given", "remove one of them"));
            }
            (false, true) => {
                let help = "give `velocity` or `keyframes`; list parts that do not move under `fixed`";
                return Err(v.error(path, "the motion of this part is not given", help));
            }
            _ => {}
        }
        if self.starts_displaced() {
            let help = "make the displacement 0 at time 0; before the first keyframe it is that of the first keyframe";
            let message =
                "the keyframes displace this part at time 0: the solid would be strained at the start";
            return Err(v.error(&format!("{path}.keyframes.0"), message, help));
        }
        v.vector_or_zero(&velocity, &mut self.velocity)?;
        v.prescribed_speed(&velocity, self.velocity.iter().map(|v| v * v).sum::<f64>().sqrt())
    }

    /// Whether the displacement at time 0 is not zero. It is linear between keyframes and constant before the first.
    fn starts_displaced(&self) -> bool {
        let keyframes = &self.keyframes;
        let next = keyframes.partition_point(|k| k.time <= 0.0);
        let start: Vec<f64> = match &keyframes[next.saturating_sub(1)..(next + 1).min(keyframes.len())] {
            [before, after] if before.time < 0.0 => {
                let ahead = -before.time / (after.time - before.time);
                let ends = before.translate.iter().zip(&after.translate);
                ends.map(|(x, y)| x + (y - x) * ahead).collect()
            }
            [at, ..] => at.translate.clone(),
            [] => Vec::new(),
        };
        start.iter().any(|x| *x != 0.0)
    }
}
