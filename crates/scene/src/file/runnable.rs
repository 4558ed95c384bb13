//! What this version can run; the rest is refused, never ignored.

use super::{Format, Scene, Scheme, ShapeSpec};
use crate::error::SceneError;
use std::f64::consts::FRAC_PI_2;

/// Whether this version can run the scene.
///
/// # Errors
/// [`SceneError`] of kind `Invalid` (exit status 3) that points at what cannot run.
pub fn runnable(scene: &Scene) -> Result<(), SceneError> {
    let refuse = |path: &str, what: &str, help: &str| {
        let error = SceneError::new(format!("this version cannot run {what} yet")).with_help(help);
        Err(scene.source.at_value(error, path))
    };
    if let Some(solid) = scene.solids.first() {
        let what = format!("scenes with solids (found `{}`)", solid.name);
        return refuse(
            "solid.0.name",
            &what,
            "remove the [[solid]]; `meniscus check` reads such scenes in full",
        );
    }
    if !scene.tension.solids.is_empty() {
        let path = format!("tension.{}", scene.tension.solids[0].0);
        return refuse(&path, "tensions of solids", "remove it");
    }
    if scene.numerics.scheme == Scheme::Paper {
        return refuse("numerics.scheme", "the scheme `paper`", "use scheme = \"meniscus\"");
    }
    if (scene.domain.wall_contact_angle - FRAC_PI_2).abs() > 1e-9 {
        let help = "use wall_contact_angle = \"90 deg\"";
        return refuse("domain.wall_contact_angle", "wall contact angles other than 90 deg", help);
    }
    if let Some(i) = scene.output.formats.iter().position(|f| !matches!(f, Format::Ply | Format::Page)) {
        let name = format!("{:?}", scene.output.formats[i]).to_lowercase();
        let what = format!("output in the format `{name}`");
        return refuse("output.formats", &what, "accepted: \"ply\", \"page\"");
    }
    contact_line(scene)?;
    for (i, body) in scene.liquid.bodies.iter().enumerate() {
        if has_extrusion(&body.shape) {
            let help = "use ball, box, half_space, cylinder, capsule, ellipsoid, perturbed_ball, wave, union, \
                        difference or mesh";
            return refuse(&format!("liquid.body.{i}.shape"), "liquid in the shape of an extrusion", help);
        }
    }
    Ok(())
}

/// Everything about the contact line that would have no effect without solids.
fn contact_line(scene: &Scene) -> Result<(), SceneError> {
    let c = &scene.contact_line;
    let key = if !c.enabled {
        "enabled"
    } else if c.friction != 0.0 || !c.friction_of.is_empty() {
        "friction"
    } else if c.hysteresis.is_some() {
        "hysteresis"
    } else if (c.radius - 3.0 * scene.domain.dx).abs() > 1e-9 * scene.domain.dx {
        "radius"
    } else {
        return Ok(());
    };
    let error =
        SceneError::new(format!("this version has no contact line on solids yet: `{key}` has no effect"));
    let error = error.with_help(format!("remove `contact_line.{key}`"));
    Err(scene.source.at_value(error, &format!("contact_line.{key}")))
}

fn has_extrusion(shape: &ShapeSpec) -> bool {
    match shape {
        ShapeSpec::Extrusion { .. } => true,
        ShapeSpec::Union(list) => list.iter().any(has_extrusion),
        ShapeSpec::Difference { of, minus } => has_extrusion(of) || has_extrusion(minus),
        _ => false,
    }
}
