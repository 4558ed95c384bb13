//! Resolves solids and the contact line to SI units.

use super::resolver::Resolver;
use crate::error::{SceneError, nearest};
use crate::file::grammar::{
    CollisionFile, ContactLineFile, Either, KeyframeFile, MovedFile, SolidFile, short,
};
use crate::file::material::Material;
use crate::file::resolved::{Bounds, ContactLine, Moved, ShapeSpec, Solid};

/// Speed of sound in air, m/s.
const SPEED_OF_SOUND: f64 = 343.0;

impl Resolver {
    pub fn solids(&mut self, files: &[SolidFile]) -> Result<Vec<Solid>, SceneError> {
        let mut out: Vec<Solid> = Vec::new();
        for (i, s) in files.iter().enumerate() {
            let path = format!("solid.{i}");
            let at = |key: &str| format!("{path}.{key}");
            self.check_solid_name(&at("name"), &s.name, &out)?;
            let shape = self.shape(&at("shape"), &s.shape)?;
            self.check_solid_inside(&at("shape"), &shape, &s.name)?;
            let material = self.material(&at("material"), &s.material)?;
            let density = self.density(&path, s, &material)?;
            let mesh_edge = self.mesh_edge(&at("mesh.edge"), s, &shape)?;
            if material.deforms() {
                self.check_meshable(&path, &shape, mesh_edge, &s.name)?;
            }
            let mut fixed = Vec::new();
            for (j, f) in s.fixed.iter().enumerate() {
                fixed.push(self.shape(&format!("{path}.fixed.{j}"), f)?);
            }
            let moved = self.prescribed_parts(&at("moved"), &s.moved)?;
            let velocity = self.velocity(&at("velocity"), s.velocity.as_ref())?;
            let (restitution, friction) = self.collision(&at("collision"), s.collision.as_ref())?;
            out.push(Solid {
                name: s.name.clone(),
                density,
                shape,
                mesh_edge,
                material,
                velocity,
                restitution,
                friction,
                fixed,
                moved,
            });
        }
        Ok(out)
    }

    /// Refuses a name that is not safe as a file name, has a meaning of its own, or is that of one of the solids `before`.
    fn check_solid_name(&self, path: &str, name: &str, before: &[Solid]) -> Result<(), SceneError> {
        self.check_file_name(path, name)?;
        if name == "liquid_air" {
            let help = "choose another name: `tension.liquid_air` is the tension of the liquid's surface";
            return Err(self.error(path, "a solid cannot be called `liquid_air`", help));
        }
        if let Some(first) = before.iter().position(|o| o.name == name) {
            let message = format!("two solids are called `{name}`");
            let help = format!("solid {first} (counted from 0) already has this name: rename one of them");
            return Err(self.error(path, message, help));
        }
        Ok(())
    }

    /// The density, kg/m³. Only a solid that forces do not move may have none.
    fn density(&self, path: &str, s: &SolidFile, material: &Material) -> Result<Option<f64>, SceneError> {
        let is_prescribed = matches!(material, Material::Rigid { fixed: true } | Material::Kinematic { .. });
        match s.density {
            Some(d) => self.positive(&format!("{path}.density"), "the density", d.0).map(Some),
            None if is_prescribed => Ok(None),
            None => {
                let message = format!("the density of `{}` is missing", s.name);
                Err(self.error(path, message, "add `density = \"2.5 g/cm^3\"`"))
            }
        }
    }

    /// The edge length of the mesh, m.
    fn mesh_edge(&self, path: &str, s: &SolidFile, shape: &ShapeSpec) -> Result<f64, SceneError> {
        match s.mesh.as_ref().and_then(|m| m.edge) {
            Some(_) if shape.volume_file().is_some() => {
                let help =
                    "remove `mesh`, or give a closed surface (.obj, .ply, .stl) to be filled with elements";
                let message = "the elements of this solid come from its mesh file: `edge` has no effect";
                Err(self.error(path, message, help))
            }
            Some(e) => self.positive_length(path, "the edge length", e),
            None => Ok(self.dx / 1.5),
        }
    }

    /// Restitution and friction coefficients.
    fn collision(&self, path: &str, c: Option<&CollisionFile>) -> Result<(f64, f64), SceneError> {
        let restitution = c.and_then(|c| c.restitution).unwrap_or(meniscus_sim::DEFAULT_RESTITUTION);
        let friction = c.and_then(|c| c.friction).unwrap_or(meniscus_sim::DEFAULT_FRICTION);
        let restitution =
            self.within(&format!("{path}.restitution"), "the restitution", restitution, 0.0, 1.0)?;
        let friction = self.not_negative(&format!("{path}.friction"), "the friction", friction)?;
        Ok((restitution, friction))
    }

    fn check_solid_inside(&self, path: &str, shape: &ShapeSpec, name: &str) -> Result<(), SceneError> {
        let Some(bounds) = shape.bounds(self.dim) else { return Ok(()) };
        match bounds.describe_outside(&self.size, 1e-6 * self.dx) {
            Some((reach, help)) => {
                let message = format!("the solid `{name}` extends outside the domain: it {reach}");
                Err(self.error(&self.source.first_inside(path), message, help))
            }
            None => Ok(()),
        }
    }

    /// Refuses an unbounded deformable solid. Warns if the requested edge length exceeds the thickness of a box.
    fn check_meshable(
        &mut self,
        path: &str,
        shape: &ShapeSpec,
        edge: f64,
        name: &str,
    ) -> Result<(), SceneError> {
        let Some(Bounds { lower, upper }) = shape.bounds(self.dim) else { return Ok(()) };
        let sides: Vec<f64> = lower.iter().zip(&upper).map(|(l, u)| u - l).collect();
        if sides.iter().any(|side| !side.is_finite()) {
            let message = format!("the deformable solid `{name}` is unbounded: it cannot be meshed");
            let at = self.source.first_inside(&format!("{path}.shape"));
            return Err(self.error(
                &at,
                message,
                "use a bounded shape, such as a box in place of a half_space",
            ));
        }
        let ShapeSpec::Box { half_size, .. } = shape else { return Ok(()) };
        let thinnest = 2.0 * half_size.iter().copied().fold(f64::INFINITY, f64::min);
        let at = format!("{path}.mesh.edge");
        if self.source.has(&at) && edge > thinnest * (1.0 + 1e-9) {
            let message = format!(
                "a mesh edge of {edge:.3e} m exceeds the thickness of `{name}` ({thinnest:.3e} m): shorter edges are used"
            );
            self.warn(&at, message);
        }
        Ok(())
    }

    /// Parts with prescribed motion.
    fn prescribed_parts(&mut self, path: &str, files: &[MovedFile]) -> Result<Vec<Moved>, SceneError> {
        let mut out = Vec::new();
        for (j, m) in files.iter().enumerate() {
            let p = format!("{path}.{j}");
            let shape = self.shape(&format!("{p}.shape"), &m.shape)?;
            let keyframes = self.keyframes(&p, m.keyframes.as_deref())?;
            match (m.velocity.is_some(), keyframes.is_empty()) {
                (true, false) => {
                    return Err(self.error(
                        &p,
                        "both a velocity and keyframes are given",
                        "remove one of them",
                    ));
                }
                (false, true) => {
                    let help = "give `velocity` or `keyframes`; list parts that do not move under `fixed`";
                    return Err(self.error(&p, "the motion of this part is not given", help));
                }
                _ => {}
            }
            if starts_displaced(&keyframes) {
                let help = "make the displacement 0 at time 0; before the first keyframe it is that of the first keyframe";
                return Err(self.error(
                    &format!("{p}.keyframes.0"),
                    "the keyframes displace this part at time 0: the solid would be strained at the start",
                    help,
                ));
            }
            let velocity = self.velocity(&format!("{p}.velocity"), m.velocity.as_ref())?;
            let speed = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
            self.check_prescribed_speed(&format!("{p}.velocity"), speed)?;
            out.push(Moved { shape, velocity, keyframes });
        }
        Ok(out)
    }

    /// Keyframes as times, s, and displacements, m.
    pub fn keyframes(
        &self,
        path: &str,
        files: Option<&[KeyframeFile]>,
    ) -> Result<Vec<(f64, Vec<f64>)>, SceneError> {
        let mut keyframes: Vec<(f64, Vec<f64>)> = Vec::new();
        for (i, f) in files.iter().copied().flatten().enumerate() {
            let p = format!("{path}.keyframes.{i}");
            if keyframes.last().is_some_and(|l| l.0 >= f.time.0) {
                let message = "the time of this keyframe is not later than that of the previous one";
                return Err(self.error(&format!("{p}.time"), message, "sort the keyframes by time"));
            }
            let to = self.point(&format!("{p}.translate"), &f.translate)?;
            if let Some((before, from)) = keyframes.last() {
                let distance = to.iter().zip(from).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                self.check_prescribed_speed(&format!("{p}.translate"), distance / (f.time.0 - before))?;
            }
            keyframes.push((f.time.0, to));
        }
        Ok(keyframes)
    }

    /// Refuses a prescribed speed above the speed of sound in air (m/s): liquids are not incompressible there.
    pub fn check_prescribed_speed(&self, path: &str, speed: f64) -> Result<(), SceneError> {
        if speed <= SPEED_OF_SOUND {
            return Ok(());
        }
        let message =
            format!("the prescribed speed of {} m/s is above the speed of sound in air", short(speed));
        Err(self.error(
            &self.source.first_inside(path),
            message,
            "reduce the velocity, or give the displacement more time",
        ))
    }

    /// Returns an error if no solid has this name.
    pub fn check_known_solid(
        &self,
        path: &str,
        key: bool,
        name: &str,
        names: &[&str],
    ) -> Result<(), SceneError> {
        if names.contains(&name) {
            return Ok(());
        }
        let near = nearest(name, names.iter().copied().chain(key.then_some("liquid_air")));
        let near = near.map_or_else(String::new, |n| format!("did you mean `{n}`? "));
        let list = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        let error = SceneError::new(format!("there is no solid `{}`", name.escape_debug()))
            .with_help(format!("{near}solids of this scene: {list}"));
        Err(if key { self.source.at_key(error, path) } else { self.source.at_value(error, path) })
    }

    pub fn contact_line(&mut self, c: &ContactLineFile, names: &[&str]) -> Result<ContactLine, SceneError> {
        let path = "contact_line.friction";
        let of = |radius| self.positive_length("contact_line.radius", "the radius", radius);
        let radius = c.radius.map(of).transpose()?;
        let (mut friction, mut friction_of) = (0.0, Vec::new());
        match &c.friction {
            Some(Either::Text(f)) => friction = self.not_negative(path, "the friction", f.0)?,
            Some(Either::Rich(list)) => {
                for (name, f) in &list.0 {
                    let p = format!("{path}.{name}");
                    self.check_known_solid(&p, true, name, names)?;
                    friction_of.push((name.clone(), self.not_negative(&p, "the friction", f.0)?));
                }
                friction_of.sort_by(|a, b| a.0.cmp(&b.0));
            }
            None => {}
        }
        let hysteresis = c.hysteresis.as_ref().map(|h| self.hysteresis(h)).transpose()?;
        let enabled = c.enabled.unwrap_or(true);
        let has_friction = friction > 0.0 || friction_of.iter().any(|(_, f)| *f > 0.0);
        let neumann = c.neumann.unwrap_or(false);
        let given = [
            ("friction", has_friction),
            ("hysteresis", hysteresis.is_some()),
            ("radius", radius.is_some()),
            ("neumann", neumann),
        ];
        if let Some((key, _)) = given.iter().find(|(_, given)| *given && !enabled) {
            let error = SceneError::new(format!("`{key}` has no effect: the contact line is switched off"));
            let error = error.with_help(format!("remove `{key}`, or `enabled = false`"));
            return Err(self.source.at_value(error, &format!("contact_line.{key}")));
        }
        Ok(ContactLine { enabled, radius, neumann, friction, friction_of, hysteresis })
    }
}

/// Whether the displacement at time 0 is not zero. It is linear between keyframes and constant before the first.
fn starts_displaced(keyframes: &[(f64, Vec<f64>)]) -> bool {
    let next = keyframes.partition_point(|k| k.0 <= 0.0);
    let start: Vec<f64> = match &keyframes[next.saturating_sub(1)..(next + 1).min(keyframes.len())] {
        [(before, from), (after, to)] if *before < 0.0 => {
            let ahead = -before / (after - before);
            from.iter().zip(to).map(|(x, y)| x + (y - x) * ahead).collect()
        }
        [(_, at), ..] => at.clone(),
        [] => Vec::new(),
    };
    start.iter().any(|x| *x != 0.0)
}
