//! Kinds of the solids of a scene: what each material makes of a solid.

mod constraints;
mod deformable;

use crate::error::SceneError;
use crate::file::{Material, Scene, Solid, vector};
use meniscus_sim::{PrescribedMotion, SolidKind};
use std::sync::Arc;

/// The kind of a solid.
///
/// # Errors
/// [`SceneError`] for a shape that cannot be meshed and for an invalid material.
pub fn kind<const D: usize>(scene: &Scene, spec: &Solid) -> Result<SolidKind<D>, SceneError> {
    Ok(match &spec.material {
        Material::Kinematic { velocity, angular_velocity, keyframes } => {
            let mut angular_velocity_3d = [0.0; 3];
            let first = 3 - angular_velocity.len().min(3);
            angular_velocity_3d[first..].copy_from_slice(&angular_velocity[..3 - first]);
            let keyframes = keyframes.iter().map(|k| (k.time, vector(&k.translate))).collect();
            SolidKind::Prescribed(PrescribedMotion {
                velocity: vector(velocity),
                angular_velocity: angular_velocity_3d,
                keyframes,
            })
        }
        Material::Rigid { fixed: false } => SolidKind::Rigid,
        _ => match deformable::elastic(scene, spec)? {
            Some(elastic) => SolidKind::Deformable(Arc::new(elastic)),
            None => SolidKind::Fixed,
        },
    })
}
