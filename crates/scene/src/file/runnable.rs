//! Refuses scenes that this version cannot run; nothing is ignored silently.

use crate::error::SceneError;
use crate::file::scene::Scene;
use crate::file::sections::{Material, Scheme};
use crate::file::shape::ShapeSpec;

/// Checks that this version can run the scene.
///
/// # Errors
/// [`SceneError`] of kind `Invalid` (exit status 3) that points at the unsupported value.
pub fn ensure_runnable(scene: &Scene) -> Result<(), SceneError> {
    let refuse = |path: &str, what: &str, help: &str| {
        let error = SceneError::new(format!("this version does not support {what} yet")).with_help(help);
        Err(scene.source.at_value(error, path))
    };
    let is_wave = |s: &ShapeSpec| matches!(s, ShapeSpec::Wave { .. });
    for (i, solid) in scene.solids.iter().enumerate() {
        let at = |key: &str| format!("solid.{i}.{key}");
        if !solid.material.is_supported() {
            let help =
                "use material.neo_hookean, corotated or springs; `meniscus check` still checks such scenes";
            let what = "thin sheets and threads (material.shell, material.rod)";
            return refuse(&at("material"), what, help);
        }
        let rigid = matches!(solid.material, Material::Rigid { .. } | Material::Kinematic { .. });
        if rigid && !solid.fixed.is_empty() {
            return refuse(&at("fixed.0"), "fixed parts of a solid that does not deform", "remove `fixed`");
        }
        if rigid && !solid.moved.is_empty() {
            let help = "use material.kinematic to move the whole solid, or a deformable material";
            return refuse(&at("moved.0"), "moved parts of a solid that does not deform", help);
        }
        if solid.shape.parts().into_iter().any(is_wave) {
            return refuse(&at("shape"), "solids of this shape", SUPPORTED_SHAPES);
        }
    }
    for (name, wetting) in &scene.tension.solids {
        if let Some(i) = wetting.patches.iter().position(|patch| patch.shape.parts().into_iter().any(is_wave))
        {
            return refuse(
                &format!("tension.{name}.patches.{i}.shape"),
                "patches of this shape",
                SUPPORTED_SHAPES,
            );
        }
    }
    if let Some((path, what)) = beyond_the_paper(scene) {
        let help = "use numerics.scheme = \"meniscus\"";
        return refuse(&path, &format!("{what} with numerics.scheme = \"paper\""), help);
    }
    if scene.contact_line.neumann && !scene.solids.iter().any(|s| s.material.deforms()) {
        let error = SceneError::new("`neumann` needs a deformable solid, but no solid deforms");
        return Err(scene.source.at_value(error.with_help("remove `neumann`"), "contact_line.neumann"));
    }
    Ok(())
}

/// What the scheme of the paper cannot do, if the scene has chosen it: the place, and its name.
fn beyond_the_paper(scene: &Scene) -> Option<(String, &'static str)> {
    if scene.numerics.scheme == Scheme::Meniscus {
        return None;
    }
    let is_free = |m: &Material| matches!(m, Material::Rigid { fixed: false, .. });
    for (i, solid) in scene.solids.iter().enumerate() {
        let at = format!("solid.{i}.material");
        if (is_free(&solid.material) || solid.material.deforms()) && scene.solids.len() > 1 {
            return Some((at, "contact between solids"));
        }
        if scene.contact_line.friction_on(&solid.name) > 0.0 {
            return Some(("contact_line.friction".to_string(), "friction of contact lines"));
        }
    }
    if scene.contact_line.hysteresis.is_some() {
        return Some(("contact_line.hysteresis".to_string(), "hysteresis"));
    }
    if scene.contact_line.neumann {
        return Some(("contact_line.neumann".to_string(), "Neumann's balance of tensions"));
    }
    scene.has_wetting_walls().then(|| ("domain.wall_contact_angle".to_string(), "sides that wet"))
}

/// Shapes supported for both liquid and solids.
const SUPPORTED_SHAPES: &str = "use ball, box, half_space, cylinder, capsule, ellipsoid, perturbed_ball, extrusion, union, smooth_union, \
                      difference, cow or mesh";
