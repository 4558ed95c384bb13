//! Checks of shapes.

use super::rotation::Rotation;
use super::spec::{ShapeSpec, VOLUME_EXTENSIONS};
use crate::error::SceneError;
use crate::file::scene_files::{builtin_name, unknown_mesh_message};
use crate::file::text::short;
use crate::file::validator::{Validator, under};
use std::path::{Path, PathBuf};

impl ShapeSpec {
    /// Checks the shape, makes directions vectors of unit length, and finds files.
    ///
    /// # Errors
    /// [`SceneError`] at the value; `path` is that of the shape.
    pub(in crate::file) fn validate(&mut self, path: &str, v: &Validator) -> Result<(), SceneError> {
        let ball = |at: &dyn Fn(&str) -> String, center: &[f64], radius: f64| {
            v.dimension(&at("center"), center)?;
            v.positive(&at("radius"), "the radius", radius)
        };
        match self {
            Self::Ball { center, radius } => ball(&under(path, "ball"), center, *radius),
            Self::Box { center, half_size, rotation } => {
                validate_box(&format!("{path}.box"), [center, half_size], rotation, v)
            }
            Self::HalfSpace { point, normal } => {
                let at = under(path, "half_space");
                v.dimension(&at("point"), point)?;
                v.direction(&at("normal"), normal, v.dim)
            }
            Self::Cylinder { center, axis, radius, height } => {
                let at = under(path, "cylinder");
                only_3d(&format!("{path}.cylinder"), "cylinder", "capsule, box, ball", v)?;
                v.dimension(&at("center"), center)?;
                v.direction(&at("axis"), axis, 3)?;
                v.positive(&at("radius"), "the radius", *radius)?;
                v.positive(&at("height"), "the height", *height)
            }
            Self::Capsule { a, b, radius } => {
                let at = under(path, "capsule");
                v.dimension(&at("a"), a)?;
                v.dimension(&at("b"), b)?;
                v.positive(&at("radius"), "the radius", *radius)
            }
            Self::Ellipsoid { center, radii, rotation } => {
                let at = under(path, "ellipsoid");
                v.dimension(&at("center"), center)?;
                v.sizes(&at("radii"), "a radius", radii)?;
                rotation.validate(&at("rotation"), v)
            }
            Self::PerturbedBall { center, radius, mode, amplitude } => {
                let at = under(path, "perturbed_ball");
                check_mode(&at("mode"), *mode, v)?;
                ball(&at, center, *radius)?;
                v.within(&at("amplitude"), "the amplitude over the radius", *amplitude, [-0.9, 0.9])
            }
            Self::Wave { amplitude, wavelength, .. } => {
                let at = under(path, "wave");
                v.positive(&at("wavelength"), "the wavelength", *wavelength)?;
                v.not_negative(&at("amplitude"), "the amplitude", *amplitude)
            }
            Self::Cow { at: feet, length, rotation } => {
                let at = under(path, "cow");
                v.dimension(&at("at"), feet)?;
                v.positive(&at("length"), "the length", *length)?;
                rotation.validate(&at("rotation"), v)
            }
            Self::Union(_)
            | Self::SmoothUnion { .. }
            | Self::Difference { .. }
            | Self::Extrusion { .. }
            | Self::Mesh { .. } => self.validate_composed(path, v),
        }
    }

    /// Checks shapes made of parts, of an outline or of a file.
    fn validate_composed(&mut self, path: &str, v: &Validator) -> Result<(), SceneError> {
        match self {
            Self::Union(parts) => validate_parts(&format!("{path}.union"), parts, v),
            Self::Difference { of, minus } => {
                let at = under(path, "difference");
                of.validate(&at("of"), v)?;
                minus.validate(&at("minus"), v)
            }
            Self::SmoothUnion { parts, width } => {
                let at = under(path, "smooth_union");
                v.positive(&at("width"), "the width of the fillets", *width)?;
                validate_parts(&at("parts"), parts, v)?;
                let endless = |s: &Self| s.bounds(v.dim).is_some_and(|bounds| !bounds.is_finite());
                let Some(i) = parts.iter().position(endless) else { return Ok(()) };
                let help = "use ball, box, capsule, ellipsoid, cylinder, extrusion, cow or mesh, or `union` in place of `smooth_union`";
                let message = "this part of the smooth union is unbounded";
                Err(v.error(&format!("{path}.smooth_union.parts.{i}"), message, help))
            }
            Self::Extrusion { outline, thickness, center, rotation } => {
                let at = under(path, "extrusion");
                only_3d(&format!("{path}.extrusion"), "extrusion", "box, union, difference", v)?;
                outline.validate(&at, v)?;
                v.positive(&at("thickness"), "the thickness", *thickness)?;
                v.dimension(&at("center"), center)?;
                rotation.validate(&at("rotation"), v)
            }
            Self::Mesh { path: file, scale, translate, rotation } => {
                let at = under(path, "mesh");
                *file = mesh_file(&at("file"), file, v)?;
                v.vector_or_zero(&at("translate"), translate)?;
                v.positive(&at("scale"), "the scale", *scale)?;
                rotation.validate(&at("rotation"), v)
            }
            _ => Ok(()),
        }
    }
}

fn check_mode(path: &str, mode: u32, v: &Validator) -> Result<(), SceneError> {
    if (2..=64).contains(&mode) {
        return Ok(());
    }
    let help = "accepted: 2 to 64 (mode 0 changes the volume, mode 1 moves the ball)";
    Err(v.error(path, format!("mode {mode} is not an oscillation mode of a drop"), help))
}

fn validate_parts(path: &str, parts: &mut [ShapeSpec], v: &Validator) -> Result<(), SceneError> {
    if parts.is_empty() {
        return Err(v.error(path, "the union contains no shape", "list at least one shape"));
    }
    parts.iter_mut().enumerate().try_for_each(|(i, part)| part.validate(&format!("{path}.{i}"), v))
}

fn validate_box(
    path: &str,
    [center, half_size]: [&Vec<f64>; 2],
    rotation: &mut Rotation,
    v: &Validator,
) -> Result<(), SceneError> {
    let at = |key: &str| format!("{path}.{key}");
    if !v.source.has(&at("lower")) {
        let size: Vec<f64> = half_size.iter().map(|h| 2.0 * h).collect();
        v.sizes(&at("size"), "an edge of the box", &size)?;
        v.dimension(&at("center"), center)?;
        return rotation.validate(&at("rotation"), v);
    }
    if v.source.has(&at("rotation")) {
        let help = "give `center` and `size` instead of `lower` and `upper`";
        return Err(v.error(&at("rotation"), "a box given by its corners cannot be rotated", help));
    }
    v.entries(&at("lower"))?;
    v.entries(&at("upper"))?;
    let Some(i) = half_size.iter().position(|half| *half <= 0.0) else { return Ok(()) };
    let [lower, upper] = [center[i] - half_size[i], center[i] + half_size[i]].map(short);
    let message = format!("`upper` ({upper} m) is not above `lower` ({lower} m)");
    let help = "every entry of `upper` must be larger than that of `lower`";
    Err(v.error(&at(&format!("upper.{i}")), message, help))
}

fn only_3d(path: &str, kind: &str, instead: &str, v: &Validator) -> Result<(), SceneError> {
    if v.dim == 3 {
        return Ok(());
    }
    let help = format!("in 2 dimensions use one of: {instead}");
    let error = SceneError::new(format!("`{kind}` needs 3 dimensions")).with_help(help);
    Err(v.source.at_key(error, path))
}

/// Absolute path of a mesh file; the name itself for a built-in one.
fn mesh_file(path: &str, file: &Path, v: &Validator) -> Result<PathBuf, SceneError> {
    let name = file.to_string_lossy();
    let known = file.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).unwrap_or_default();
    let surfaces = if v.dim == 2 { &["obj", "ply"][..] } else { &["obj", "ply", "stl"] };
    if !surfaces.iter().chain(&VOLUME_EXTENSIONS).any(|e| *e == known) {
        let message = format!("`{}` is not a supported mesh file", name.escape_debug());
        let names = |list: &[&str]| list.iter().map(|e| format!(".{e}")).collect::<Vec<_>>().join(", ");
        let (surfaces, volumes) = (names(surfaces), names(&VOLUME_EXTENSIONS));
        return Err(v.error(
            path,
            message,
            format!("accepted: surface meshes {surfaces}, volume meshes {volumes}"),
        ));
    }
    if let Some(of) = builtin_name(&name) {
        return match unknown_mesh_message(of) {
            None => Ok(file.to_owned()),
            Some((message, help)) => Err(v.error(path, message, help)),
        };
    }
    v.existing_file(file).ok_or_else(|| {
        let message = format!("there is no mesh file `{}`", name.escape_debug());
        v.error(path, message, "the path is relative to the folder of the scene file")
    })
}
