//! Resolves shapes to SI units.

use super::resolver::Resolver;
use crate::error::SceneError;
use crate::file::grammar::{
    BoxFile, CylinderFile, Either, EllipsoidFile, ExtrusionFile, Length, MeshFile, PerturbedBallFile,
    RotationFile, ShapeFile, SmoothUnionFile, WaveFile,
};
use crate::file::resolved::{Outline, Rotation, ShapeSpec, VOLUME_EXTENSIONS};
use crate::file::scene_files::{builtin_name, unknown_mesh_message};
use std::path::{Path, PathBuf};

impl Resolver {
    pub fn shape(&mut self, path: &str, shape: &ShapeFile) -> Result<ShapeSpec, SceneError> {
        let at = |kind: &str| format!("{path}.{kind}");
        Ok(match shape {
            ShapeFile::Ball(b) => {
                let p = at("ball");
                ShapeSpec::Ball {
                    center: self.point(&format!("{p}.center"), &b.center)?,
                    radius: self.positive_length(&format!("{p}.radius"), "the radius", b.radius)?,
                }
            }
            ShapeFile::Box(b) => self.box_shape(&at("box"), b)?,
            ShapeFile::HalfSpace(h) => {
                let p = at("half_space");
                ShapeSpec::HalfSpace {
                    point: self.point(&format!("{p}.point"), &h.point)?,
                    normal: self.direction(&format!("{p}.normal"), &h.normal, self.dim)?,
                }
            }
            ShapeFile::Cylinder(c) => self.cylinder(&at("cylinder"), c)?,
            ShapeFile::Capsule(c) => {
                let p = at("capsule");
                ShapeSpec::Capsule {
                    a: self.point(&format!("{p}.a"), &c.a)?,
                    b: self.point(&format!("{p}.b"), &c.b)?,
                    radius: self.positive_length(&format!("{p}.radius"), "the radius", c.radius)?,
                }
            }
            ShapeFile::Ellipsoid(e) => self.ellipsoid(&at("ellipsoid"), e)?,
            ShapeFile::PerturbedBall(b) => self.perturbed_ball(&at("perturbed_ball"), b)?,
            ShapeFile::Wave(w) => self.wave(&at("wave"), w)?,
            ShapeFile::Extrusion(e) => self.extrusion(&at("extrusion"), e)?,
            ShapeFile::Union(list) => self.union(&at("union"), list)?,
            ShapeFile::Difference(d) => {
                let p = at("difference");
                ShapeSpec::Difference {
                    of: Box::new(self.shape(&format!("{p}.of"), &d.of)?),
                    minus: Box::new(self.shape(&format!("{p}.minus"), &d.minus)?),
                }
            }
            ShapeFile::SmoothUnion(u) => self.smooth_union(&at("smooth_union"), u)?,
            ShapeFile::Cow(c) => {
                let p = at("cow");
                ShapeSpec::Cow {
                    at: self.point(&format!("{p}.at"), &c.at)?,
                    length: self.positive_length(&format!("{p}.length"), "the length", c.length)?,
                    rotation: self.rotation(&format!("{p}.rotation"), c.rotation.as_ref())?,
                }
            }
            ShapeFile::Mesh(m) => self.mesh(&at("mesh"), m)?,
        })
    }

    fn cylinder(&self, path: &str, c: &CylinderFile) -> Result<ShapeSpec, SceneError> {
        self.only_3d(path, "cylinder", "capsule, box, ball")?;
        Ok(ShapeSpec::Cylinder {
            center: self.point(&format!("{path}.center"), &c.center)?,
            axis: self.direction(&format!("{path}.axis"), &c.axis, 3)?,
            radius: self.positive_length(&format!("{path}.radius"), "the radius", c.radius)?,
            height: self.positive_length(&format!("{path}.height"), "the height", c.height)?,
        })
    }

    fn ellipsoid(&self, path: &str, e: &EllipsoidFile) -> Result<ShapeSpec, SceneError> {
        Ok(ShapeSpec::Ellipsoid {
            center: self.point(&format!("{path}.center"), &e.center)?,
            radii: self.sizes(&format!("{path}.radii"), "a radius", &e.radii)?,
            rotation: self.rotation(&format!("{path}.rotation"), e.rotation.as_ref())?,
        })
    }

    fn smooth_union(&mut self, path: &str, u: &SmoothUnionFile) -> Result<ShapeSpec, SceneError> {
        let width = self.positive_length(&format!("{path}.width"), "the width of the fillets", u.width)?;
        let at = format!("{path}.parts");
        let ShapeSpec::Union(parts) = self.union(&at, &u.parts)? else {
            return Err(self.error(&at, "the union contains no shape", "list at least one shape"));
        };
        let endless = |s: &ShapeSpec| s.bounds(self.dim).is_some_and(|bounds| !bounds.is_finite());
        if let Some(i) = parts.iter().position(endless) {
            let help = "use ball, box, capsule, ellipsoid, cylinder, extrusion, cow or mesh, or `union` in place of `smooth_union`";
            return Err(self.error(&format!("{at}.{i}"), "this part of the smooth union is unbounded", help));
        }
        Ok(ShapeSpec::SmoothUnion { parts, width })
    }

    fn union(&mut self, path: &str, list: &[ShapeFile]) -> Result<ShapeSpec, SceneError> {
        if list.is_empty() {
            return Err(self.error(path, "the union contains no shape", "list at least one shape"));
        }
        let mut out = Vec::new();
        for (i, s) in list.iter().enumerate() {
            out.push(self.shape(&format!("{path}.{i}"), s)?);
        }
        Ok(ShapeSpec::Union(out))
    }

    fn only_3d(&self, path: &str, kind: &str, instead: &str) -> Result<(), SceneError> {
        if self.dim == 3 {
            return Ok(());
        }
        let help = format!("in 2 dimensions use one of: {instead}");
        let error = SceneError::new(format!("`{kind}` needs 3 dimensions")).with_help(help);
        Err(self.source.at_key(error, path))
    }

    fn sizes(&self, path: &str, what: &str, value: &[Length]) -> Result<Vec<f64>, SceneError> {
        self.check_dimension(path, value.len())?;
        value
            .iter()
            .enumerate()
            .map(|(i, l)| self.positive_length(&format!("{path}.{i}"), what, *l))
            .collect()
    }

    /// Normalises a vector. A vector of unit length is returned unchanged, bit for bit.
    pub fn direction(&self, path: &str, value: &[f64], entries: usize) -> Result<Vec<f64>, SceneError> {
        if value.len() != entries {
            let message = format!("found {} entries in this direction vector", value.len());
            return Err(self.error(path, message, format!("give {entries} entries")));
        }
        let largest = value.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        if !(largest > 0.0 && largest.is_finite()) || value.iter().any(|v| !v.is_finite()) {
            let help = "give finite numbers without units that are not all zero";
            return Err(self.error(path, "this vector does not define a direction", help));
        }
        let norm = value.iter().map(|v| (v / largest).powi(2)).sum::<f64>().sqrt() * largest;
        if (norm - 1.0).abs() < 1e-12 {
            return Ok(value.to_vec());
        }
        Ok(value.iter().map(|v| v / largest / (norm / largest)).collect())
    }

    fn rotation(&self, path: &str, value: Option<&RotationFile>) -> Result<Rotation, SceneError> {
        match (value, self.dim) {
            (None, _) => Ok(Rotation::NONE),
            (Some(Either::Text(a)), 2) => Ok(Rotation { angle: a.0, ..Rotation::NONE }),
            (Some(Either::Rich(r)), 3) => {
                let axis = self.direction(&format!("{path}.axis"), &r.axis, 3)?;
                Ok(Rotation { axis: [axis[0], axis[1], axis[2]], angle: r.angle.0 })
            }
            (Some(_), 2) => Err(self.error(
                path,
                "a rotation in 2 dimensions takes no axis",
                "give the angle only, such as \"30 deg\"",
            )),
            (Some(_), _) => {
                let help = "give an axis and an angle, such as { axis = [0, 0, 1], angle = \"30 deg\" }";
                Err(self.error(path, "a rotation in 3 dimensions needs an axis", help))
            }
        }
    }

    fn box_shape(&self, path: &str, b: &BoxFile) -> Result<ShapeSpec, SceneError> {
        match (&b.lower, &b.upper, &b.center, &b.size) {
            (Some(lower), Some(upper), None, None) => {
                if b.rotation.is_some() {
                    let help = "give `center` and `size` instead of `lower` and `upper`";
                    return Err(self.error(
                        &format!("{path}.rotation"),
                        "a box given by its corners cannot be rotated",
                        help,
                    ));
                }
                let low = self.point(&format!("{path}.lower"), lower)?;
                let up = self.point(&format!("{path}.upper"), upper)?;
                for i in 0..self.dim {
                    if low[i] >= up[i] {
                        let message = format!("`upper` ({} m) is not above `lower` ({} m)", up[i], low[i]);
                        let help = "every entry of `upper` must be larger than that of `lower`";
                        return Err(self.error(&format!("{path}.upper.{i}"), message, help));
                    }
                }
                Ok(ShapeSpec::Box {
                    center: low.iter().zip(&up).map(|(l, u)| 0.5 * (l + u)).collect(),
                    half_size: low.iter().zip(&up).map(|(l, u)| 0.5 * (u - l)).collect(),
                    rotation: Rotation::NONE,
                })
            }
            (None, None, Some(center), Some(size)) => {
                let size = self.sizes(&format!("{path}.size"), "an edge of the box", size)?;
                Ok(ShapeSpec::Box {
                    center: self.point(&format!("{path}.center"), center)?,
                    half_size: size.iter().map(|s| 0.5 * s).collect(),
                    rotation: self.rotation(&format!("{path}.rotation"), b.rotation.as_ref())?,
                })
            }
            _ => {
                let help = "give `lower` and `upper`, or `center` and `size` (optionally with `rotation`)";
                Err(self.error(path, "these keys do not define the box", help))
            }
        }
    }

    fn perturbed_ball(&self, path: &str, b: &PerturbedBallFile) -> Result<ShapeSpec, SceneError> {
        if !(2..=64).contains(&b.mode) {
            let help = "accepted: 2 to 64 (mode 0 changes the volume, mode 1 moves the ball)";
            let message = format!("mode {} is not an oscillation mode of a drop", b.mode);
            return Err(self.error(&format!("{path}.mode"), message, help));
        }
        Ok(ShapeSpec::PerturbedBall {
            center: self.point(&format!("{path}.center"), &b.center)?,
            radius: self.positive_length(&format!("{path}.radius"), "the radius", b.radius)?,
            mode: b.mode,
            amplitude: self.within(
                &format!("{path}.amplitude"),
                "the amplitude over the radius",
                b.amplitude,
                -0.9,
                0.9,
            )?,
        })
    }

    fn wave(&mut self, path: &str, w: &WaveFile) -> Result<ShapeSpec, SceneError> {
        let amplitude = w.amplitude.resolve(self.dx);
        let wavelength =
            self.positive_length(&format!("{path}.wavelength"), "the wavelength", w.wavelength)?;
        self.not_negative(&format!("{path}.amplitude"), "the amplitude", amplitude)?;
        let phase = w.phase.map_or(0.0, |p| p.0);
        Ok(ShapeSpec::Wave { level: w.level.resolve(self.dx), amplitude, wavelength, phase })
    }

    fn extrusion(&self, path: &str, e: &ExtrusionFile) -> Result<ShapeSpec, SceneError> {
        self.only_3d(path, "extrusion", "box, union, difference")?;
        let at = |key: &str| format!("{path}.{key}");
        let outline = match (&e.outline, e.size) {
            (Either::Text(name), Some(size)) => {
                Outline::Named(*name, self.positive_length(&at("size"), "the size", size)?)
            }
            (Either::Text(_), None) => {
                return Err(self.error(path, "a named outline needs a size", "add `size = \"1 cm\"`"));
            }
            (Either::Rich(_), Some(_)) => {
                return Err(self.error(
                    &at("size"),
                    "an outline given as a list of points takes no `size`",
                    "remove `size`",
                ));
            }
            (Either::Rich(points), None) => {
                let mut out = Vec::new();
                for (i, p) in points.iter().enumerate() {
                    let &[x, y] = p.as_slice() else {
                        let message = format!("found {} entries in this point of the outline", p.len());
                        return Err(self.error(&format!("{path}.outline.{i}"), message, "give 2 entries"));
                    };
                    out.push([x.resolve(self.dx), y.resolve(self.dx)]);
                }
                if out.len() < 3 {
                    let help = "give three points or more";
                    return Err(self.error(&at("outline"), "the outline has fewer than three points", help));
                }
                Outline::Points(out)
            }
        };
        Ok(ShapeSpec::Extrusion {
            outline,
            thickness: self.positive_length(&at("thickness"), "the thickness", e.thickness)?,
            center: self.point(&at("center"), &e.center)?,
            rotation: self.rotation(&at("rotation"), e.rotation.as_ref())?,
        })
    }

    fn mesh(&self, path: &str, m: &MeshFile) -> Result<ShapeSpec, SceneError> {
        let at = |key: &str| format!("{path}.{key}");
        let file = self.base.join(&m.file);
        let known =
            file.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).unwrap_or_default();
        let surfaces = if self.dim == 2 { &["obj", "ply"][..] } else { &["obj", "ply", "stl"] };
        if !surfaces.iter().chain(&VOLUME_EXTENSIONS).any(|e| *e == known) {
            let message = format!("`{}` is not a supported mesh file", m.file.escape_debug());
            let names = |list: &[&str]| list.iter().map(|e| format!(".{e}")).collect::<Vec<_>>().join(", ");
            let help = format!(
                "accepted: surface meshes {}, volume meshes {}",
                names(surfaces),
                names(&VOLUME_EXTENSIONS)
            );
            return Err(self.error(&at("file"), message, help));
        }
        let file = self.mesh_file(&at("file"), &m.file, &file)?;
        let translate = match &m.translate {
            Some(t) => self.point(&at("translate"), t)?,
            None => vec![0.0; self.dim],
        };
        Ok(ShapeSpec::Mesh {
            path: file,
            scale: self.positive(&at("scale"), "the scale", m.scale.map_or(1.0, |s| s.0))?,
            translate,
            rotation: self.rotation(&at("rotation"), m.rotation.as_ref())?,
        })
    }

    /// Absolute path of a mesh file; the name itself for a built-in one.
    fn mesh_file(&self, path: &str, name: &str, file: &Path) -> Result<PathBuf, SceneError> {
        if let Some(of) = builtin_name(name) {
            return match unknown_mesh_message(of) {
                None => Ok(PathBuf::from(name)),
                Some((message, help)) => Err(self.error(path, message, help)),
            };
        }
        match std::fs::canonicalize(file) {
            Ok(f) if f.is_file() => Ok(f),
            _ => {
                let message = format!("there is no mesh file `{}`", name.escape_debug());
                let help = "the path is relative to the folder of the scene file";
                Err(self.error(path, message, help))
            }
        }
    }
}
