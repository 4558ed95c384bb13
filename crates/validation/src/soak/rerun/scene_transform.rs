//! Mirror images of scenes, and scenes shifted along the first axis.

use meniscus_scene::file::{Material, Rotation, Scene, ShapeSpec, Solid};

/// A transformation along the first axis: a reflection at the middle of the domain, then a shift.
pub struct SceneTransform {
    /// Whether to reflect.
    pub mirrored: bool,
    /// Size of the domain along the first axis, m.
    pub size: f64,
    /// The shift, m.
    pub shift: f64,
}

impl SceneTransform {
    /// The image of a scene; none if it has none: a shift of an object that ends at a side, or a reflection of a shape or an element mesh
    /// that is not built symmetrically.
    pub fn scene(&self, scene: &Scene) -> Option<Scene> {
        let mut scene = scene.clone();
        if self.mirrored {
            // Element meshes and files have no exact mirror images.
            if scene.solids.iter().any(|s| s.material.deforms()) {
                return None;
            }
            scene.domain.walls[0].reverse();
            scene.liquid.gravity = self.direction(&scene.liquid.gravity);
        } else if scene.liquid.bodies.iter().any(|b| !self.is_inside(&b.shape, scene.domain.dimension)) {
            return None;
        }
        for body in &mut scene.liquid.bodies {
            body.shape = self.shape(&body.shape)?;
            body.velocity = self.direction(&body.velocity);
        }
        for solid in &mut scene.solids {
            self.solid(solid)?;
        }
        for (_, wetting) in &mut scene.tension.solids {
            if wetting.image.is_some() {
                return None;
            }
            for patch in &mut wetting.patches {
                patch.shape = self.shape(&patch.shape)?;
            }
            for end in wetting.gradient.iter_mut().flat_map(|gradient| [&mut gradient.from, &mut gradient.to])
            {
                end.point = self.point(&end.point);
            }
        }
        Some(scene)
    }

    /// Whether a shape ends before the sides of the shift.
    fn is_inside(&self, shape: &ShapeSpec, dimension: usize) -> bool {
        shape.bounds(dimension).is_some_and(|b| b.lower[0] > 0.0 && b.upper[0] < self.size - self.shift)
    }

    fn solid(&self, solid: &mut Solid) -> Option<()> {
        solid.shape = self.shape(&solid.shape)?;
        solid.velocity = self.direction(&solid.velocity);
        if let Material::Kinematic { velocity, angular_velocity, keyframes } = &mut solid.material {
            *velocity = self.direction(velocity);
            keyframes.iter_mut().for_each(|k| k.translate = self.direction(&k.translate));
            *angular_velocity = self.angular_velocity(angular_velocity);
        }
        for part in &mut solid.fixed {
            *part = self.shape(part)?;
        }
        for part in &mut solid.moved {
            part.shape = self.shape(&part.shape)?;
            part.velocity = self.direction(&part.velocity);
            part.keyframes.iter_mut().for_each(|k| k.translate = self.direction(&k.translate));
        }
        Some(())
    }

    /// The image of a point, m.
    pub fn point(&self, x: &[f64]) -> Vec<f64> {
        let mut x = x.to_vec();
        x[0] = if self.mirrored { self.size - x[0] } else { x[0] } + self.shift;
        x
    }

    fn direction(&self, v: &[f64]) -> Vec<f64> {
        let mut v = v.to_vec();
        v[0] = if self.mirrored { -v[0] } else { v[0] };
        v
    }

    /// The image of an angular velocity: a reflection reverses the components in its plane.
    fn angular_velocity(&self, w: &[f64]) -> Vec<f64> {
        if !self.mirrored {
            return w.to_vec();
        }
        match w {
            [x, rest @ ..] if !rest.is_empty() => {
                std::iter::once(*x).chain(rest.iter().map(|w| -w)).collect()
            }
            _ => w.iter().map(|w| -w).collect(),
        }
    }

    fn rotation(&self, r: &Rotation) -> Rotation {
        if !self.mirrored || r.angle == 0.0 {
            return r.clone();
        }
        // In 2D the angle is reversed; in 3D the axis is an angular velocity.
        match r.axis.as_slice() {
            [x, y, z] => Rotation { axis: vec![*x, -y, -z], angle: r.angle },
            _ => Rotation { angle: -r.angle, ..r.clone() },
        }
    }

    fn shape(&self, shape: &ShapeSpec) -> Option<ShapeSpec> {
        let all = |list: &[ShapeSpec]| list.iter().map(|s| self.shape(s)).collect::<Option<Vec<_>>>();
        Some(match shape {
            ShapeSpec::Ball { center, radius } => {
                ShapeSpec::Ball { center: self.point(center), radius: *radius }
            }
            ShapeSpec::Box { center, half_size, rotation } => ShapeSpec::Box {
                center: self.point(center),
                half_size: half_size.clone(),
                rotation: self.rotation(rotation),
            },
            ShapeSpec::HalfSpace { point, normal } => {
                if !self.mirrored && normal[0] != 0.0 {
                    return None;
                }
                ShapeSpec::HalfSpace { point: self.point(point), normal: self.direction(normal) }
            }
            ShapeSpec::Cylinder { center, axis, radius, height } => ShapeSpec::Cylinder {
                center: self.point(center),
                axis: self.direction(axis),
                radius: *radius,
                height: *height,
            },
            ShapeSpec::Capsule { a, b, radius } => {
                ShapeSpec::Capsule { a: self.point(a), b: self.point(b), radius: *radius }
            }
            ShapeSpec::Ellipsoid { center, radii, rotation } => ShapeSpec::Ellipsoid {
                center: self.point(center),
                radii: radii.clone(),
                rotation: self.rotation(rotation),
            },
            // In 2D odd modes point along the first axis.
            ShapeSpec::PerturbedBall { mode, center, .. }
                if self.mirrored && center.len() == 2 && mode % 2 == 1 =>
            {
                return None;
            }
            ShapeSpec::PerturbedBall { center, radius, mode, amplitude } => ShapeSpec::PerturbedBall {
                center: self.point(center),
                radius: *radius,
                mode: *mode,
                amplitude: *amplitude,
            },
            ShapeSpec::Union(parts) => ShapeSpec::Union(all(parts)?),
            ShapeSpec::SmoothUnion { parts, width } => {
                ShapeSpec::SmoothUnion { parts: all(parts)?, width: *width }
            }
            ShapeSpec::Difference { of, minus } => {
                ShapeSpec::Difference { of: Box::new(self.shape(of)?), minus: Box::new(self.shape(minus)?) }
            }
            // Waves fill the domain; the other shapes have a direction.
            ShapeSpec::Wave { .. }
            | ShapeSpec::Extrusion { .. }
            | ShapeSpec::Cow { .. }
            | ShapeSpec::Mesh { .. } => return None,
        })
    }
}
