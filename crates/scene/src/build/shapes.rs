//! Signed distance functions of the shapes of a scene, and meshes from files.

use super::SignedDistanceFn;
use crate::error::SceneError;
use crate::file::{SceneFiles, ShapeSpec, outline, rotation, vector};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::shape::{MeshShape, Shape, SmoothUnion};
use std::sync::Arc;

/// The signed distance of a shape; `files` has its mesh files.
///
/// # Errors
/// [`SceneError`] for a shape that cannot be made.
pub fn signed_distance_fn<const D: usize>(
    spec: &ShapeSpec,
    files: &SceneFiles,
) -> Result<SignedDistanceFn<D>, SceneError> {
    match spec {
        ShapeSpec::Union(parts) => {
            let parts: Vec<SignedDistanceFn<D>> =
                parts.iter().map(|part| signed_distance_fn(part, files)).collect::<Result<_, _>>()?;
            Ok(Arc::new(move |x| parts.iter().map(|part| part(x)).fold(f64::INFINITY, f64::min)))
        }
        ShapeSpec::Difference { of, minus } => {
            let (of, minus) = (signed_distance_fn::<D>(of, files)?, signed_distance_fn::<D>(minus, files)?);
            Ok(Arc::new(move |x| of(x).max(-minus(x))))
        }
        ShapeSpec::Wave { level, amplitude, wavelength, phase } => {
            let wave = Wave {
                level: *level,
                amplitude: *amplitude,
                wavenumber: 2.0 * std::f64::consts::PI / wavelength,
                phase: *phase,
            };
            Ok(Arc::new(move |x: &Vector<D>| wave.signed_distance(x[0], x[D - 1])))
        }
        other => {
            let shape = shape::<D>(other, files)?;
            Ok(Arc::new(move |x| shape.signed_distance(x)))
        }
    }
}

/// A shape of any kind except a wave; `files` has its mesh files.
pub(crate) fn shape<const D: usize>(spec: &ShapeSpec, files: &SceneFiles) -> Result<Shape<D>, SceneError> {
    let all = |parts: &[ShapeSpec]| parts.iter().map(|part| shape(part, files)).collect::<Result<_, _>>();
    Ok(match spec {
        ShapeSpec::Ball { center, radius } => Shape::Ball { center: vector(center), radius: *radius },
        ShapeSpec::Box { center, half_size, rotation: turned } => {
            Shape::Box { center: vector(center), half_size: vector(half_size), rotation: rotation(turned) }
        }
        ShapeSpec::HalfSpace { point, normal } => {
            Shape::HalfSpace { point: vector(point), normal: vector(normal) }
        }
        ShapeSpec::Cylinder { center, axis, radius, height } => {
            Shape::Cylinder { center: vector(center), axis: vector(axis), radius: *radius, height: *height }
        }
        ShapeSpec::Capsule { a, b, radius } => Shape::Capsule { a: vector(a), b: vector(b), radius: *radius },
        ShapeSpec::Ellipsoid { center, radii, rotation: turned } => {
            Shape::Ellipsoid { center: vector(center), radii: vector(radii), rotation: rotation(turned) }
        }
        ShapeSpec::PerturbedBall { center, radius, mode, amplitude } => Shape::PerturbedBall {
            center: vector(center),
            radius: *radius,
            mode: *mode,
            amplitude: *amplitude,
        },
        ShapeSpec::Union(parts) => Shape::Union(all(parts)?),
        ShapeSpec::Difference { of, minus } => {
            Shape::Difference { of: Box::new(shape(of, files)?), minus: Box::new(shape(minus, files)?) }
        }
        ShapeSpec::SmoothUnion { parts, width } => {
            Shape::SmoothUnion(SmoothUnion { parts: all(parts)?, fillet_width: *width })
        }
        ShapeSpec::Cow { at, length, rotation: turned } => {
            Shape::SmoothUnion(SmoothUnion::cow(*length, &vector(at), &rotation(turned)))
        }
        ShapeSpec::Mesh { .. } if spec.volume_file().is_some() => {
            let (surface, _) = file_volume_mesh::<D>(spec, files).map_err(SceneError::new)?.surface();
            Shape::Mesh(Arc::new(MeshShape::new(surface)))
        }
        ShapeSpec::Mesh { path, scale, translate, rotation: turned } => {
            let read = files.surface(path).map_err(SceneError::new)?;
            let surface = read.surface().clone().transformed(*scale, &rotation(turned), &vector(translate));
            Shape::Mesh(Arc::new(MeshShape::new(surface)))
        }
        ShapeSpec::Extrusion { outline: flat, thickness, center, rotation: turned } => {
            Shape::extrusion(&outline(flat)?, &vector(center), *thickness, &rotation(turned))
        }
        ShapeSpec::Wave { .. } => {
            let help = "use ball, box, half_space, cylinder, capsule, ellipsoid, perturbed_ball, extrusion, \
                        union, smooth_union, difference, cow or mesh";
            let message = "this version supports the shape `wave` only for liquid bodies and their unions and differences";
            return Err(SceneError::new(message).with_help(help));
        }
    })
}

/// The elements of a volume mesh file, in scene coordinates; the error is a message.
pub(crate) fn file_volume_mesh<const D: usize>(
    spec: &ShapeSpec,
    files: &SceneFiles,
) -> Result<VolumeMesh<D>, String> {
    let ShapeSpec::Mesh { path, scale, translate, rotation: turned } = spec else {
        return Err("this shape is not read from a volume mesh file".to_owned());
    };
    let mut mesh = files.volume::<D>(path)?;
    mesh.positions.iter_mut().for_each(|x| *x *= *scale);
    Ok(mesh.transformed(&rotation(turned), &vector(translate)))
}

/// The curve `level + amplitude cos(wavenumber x + phase)`.
struct Wave {
    level: f64,
    amplitude: f64,
    wavenumber: f64,
    phase: f64,
}

impl Wave {
    /// Signed distance, negative below the curve. Newton's method finds the closest point, starting from the same `x`.
    fn signed_distance(&self, x: f64, y: f64) -> f64 {
        let height = |s: f64| {
            let (sin, cos) = (self.wavenumber * s + self.phase).sin_cos();
            let a = self.amplitude;
            (self.level + a * cos, -a * self.wavenumber * sin, -a * self.wavenumber * self.wavenumber * cos)
        };
        let mut s = x;
        for _ in 0..20 {
            let (h, h1, h2) = height(s);
            let slope = (s - x) + (h - y) * h1;
            let curvature = (1.0 + h1 * h1 + (h - y) * h2).max(0.2);
            s -= slope / curvature;
        }
        (s - x).hypot(height(s).0 - y).copysign(y - height(x).0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_to_a_wave() {
        let spec = ShapeSpec::Wave { level: 1.0, amplitude: 0.05, wavelength: 1.0, phase: 0.3 };
        let region = signed_distance_fn::<2>(&spec, &SceneFiles::default()).unwrap();
        let curve = |s: f64| 1.0 + 0.05 * (2.0 * std::f64::consts::PI * s + 0.3).cos();
        for (x, y) in [(0.2, 1.3), (0.7, 0.8), (0.5, 1.0), (0.0, 0.5)] {
            let nearest = (-2000..3000).map(|i| f64::from(i) * 1e-3).map(|s| (s - x).hypot(curve(s) - y));
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            let distance = region(&Vector::from([x, y]));
            assert!((distance.abs() - nearest).abs() < 1e-5, "{x} {y}: {distance} {nearest}");
            assert_eq!(distance > 0.0, y > curve(x));
        }
    }
}
