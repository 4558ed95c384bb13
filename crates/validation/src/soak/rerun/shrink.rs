//! Shrinks a scene as long as it violates an invariant.

use super::accepted::round_tripped;
use super::evidence;
use crate::soak::Outcome;
use crate::soak::launcher::Launcher;
use meniscus_scene::file::{Bounds, ContactLine, Either, Scene, ShapeSpec, Wall};
use std::f64::consts::FRAC_PI_2;
use std::path::PathBuf;

/// Most runs of modified scenes.
const MAX_TRIES: usize = 60;
/// Duration of a shrunk scene over the time of the violation.
const DURATION_FACTOR: f64 = 1.05;

/// A scene that still violates the invariant.
pub struct Shrunk {
    /// Path of its file.
    pub path: PathBuf,
    /// Removed parts, in order.
    pub dropped: Vec<String>,
    /// Its outcome.
    pub outcome: Outcome,
}

/// Removes from a scene that violates `kind` what is not needed: solids, liquid bodies, then features. `each` receives every attempt.
///
/// # Errors
/// A message if nothing can be written or started.
pub fn shrink(
    launch: &Launcher,
    scene: Scene,
    first: Outcome,
    kind: &str,
    each: &mut dyn FnMut(&str),
) -> Result<Shrunk, String> {
    let name = format!("{}-small", scene.name);
    let mut scene = Scene { name: name.clone(), ..scene };
    let path = launch.out.join(format!("{name}.toml"));
    let (mut outcome, mut dropped, mut tries) = (first, Vec::new(), 0);
    // A part that could not be removed is not tried again.
    let mut needed: Vec<String> = Vec::new();
    let broke = |outcome: &Outcome| outcome.violations.iter().any(|v| v.kind == kind);
    loop {
        let mut smaller = false;
        for (what, candidate) in candidates(&scene, &outcome, kind) {
            if needed.contains(&what) || tries >= MAX_TRIES {
                continue;
            }
            let Some((candidate, _)) = round_tripped(&candidate) else { continue };
            tries += 1;
            let text = candidate.to_toml().map_err(|e| e.to_string())?;
            evidence::write_scene(&launch.out, &name, &text).map_err(|e| e.to_string())?;
            let its = launch.file(&path)?;
            if broke(&its) {
                each(&format!("without {what}: still violated"));
                (scene, outcome, smaller) = (candidate, its, true);
                dropped.push(what);
                break;
            }
            each(&format!("without {what}: no longer violated"));
            needed.push(what);
        }
        if !smaller {
            break;
        }
    }
    let text = scene.to_toml().map_err(|e| e.to_string())?;
    evidence::write_scene(&launch.out, &name, &text).map_err(|e| e.to_string())?;
    Ok(Shrunk { path, dropped, outcome })
}

/// Scenes with one part less, largest parts first.
fn candidates(scene: &Scene, outcome: &Outcome, kind: &str) -> Vec<(String, Scene)> {
    let mut all = Vec::new();
    for i in 0..scene.solids.len() {
        let mut less = scene.clone();
        let solid = less.solids.remove(i);
        less.tension.solids.retain(|(name, _)| *name != solid.name);
        if let Either::Rich(table) = &mut less.contact_line.friction {
            table.0.retain(|(name, _)| *name != solid.name);
        }
        all.push((format!("the solid {}", solid.name), less));
    }
    for i in (0..scene.liquid.bodies.len()).filter(|_| scene.liquid.bodies.len() > 1) {
        let mut less = scene.clone();
        less.liquid.bodies.remove(i);
        all.push((format!("liquid body {i}"), less));
    }
    let failed = outcome.violations.iter().find(|v| v.kind == kind && v.time > 0.0);
    if let Some(end) =
        failed.map(|v| DURATION_FACTOR * v.time).filter(|end| *end < 0.9 * scene.output.duration)
    {
        let mut less = scene.clone();
        less.output.duration = end;
        all.push(("the time after the violation".into(), less));
    }
    all.extend(features(scene));
    all
}

/// Scenes with one feature less.
fn features(scene: &Scene) -> Vec<(String, Scene)> {
    let mut all = Vec::new();
    let mut less = |what: &str, change: &dyn Fn(&mut Scene)| {
        let mut changed = scene.clone();
        change(&mut changed);
        if changed != *scene {
            all.push((what.to_owned(), changed));
        }
    };
    less("open walls", &|s| s.domain.walls.iter_mut().flatten().for_each(|w| *w = Wall::Slip));
    less("wetting walls", &|s| s.domain.wall_contact_angle = FRAC_PI_2);
    less("hysteresis", &|s| s.contact_line.hysteresis = None);
    less("the contact-line friction", &|s| s.contact_line.friction = ContactLine::default().friction);
    less("the contact-line radius", &|s| s.contact_line.radius = None);
    less("the Neumann balance", &|s| s.contact_line.neumann = false);
    less("patches", &|s| s.tension.solids.iter_mut().for_each(|(_, w)| w.patches.clear()));
    less("gradients of the contact angle", &|s| {
        for (_, wetting) in &mut s.tension.solids {
            if let Some(gradient) = wetting.gradient.take() {
                wetting.set_contact_angle(gradient.from.contact_angle);
            }
        }
    });
    less("gravity", &|s| s.liquid.gravity.fill(0.0));
    less("viscosity", &|s| s.liquid.kinematic_viscosity = 0.0);
    less("the liquid's velocity", &|s| s.liquid.bodies.iter_mut().for_each(|b| b.velocity.fill(0.0)));
    less("the solids' velocity", &|s| s.solids.iter_mut().for_each(|b| b.velocity.fill(0.0)));
    less("long or short steps", &|s| s.numerics.capillary_step = 5.0);
    less("Newton iterations", &|s| s.numerics.newton_iterations = 0);
    less("contact angles other than 90 degrees", &|s| {
        s.tension.solids.iter_mut().for_each(|(_, w)| w.set_contact_angle(FRAC_PI_2));
    });
    less("shapes of liquid other than balls", &|s| {
        let dimension = s.domain.dimension;
        for body in &mut s.liquid.bodies {
            let Some(Bounds { lower: low, upper: high }) = body.shape.bounds(dimension) else { continue };
            let center: Vec<f64> = low.iter().zip(&high).map(|(l, h)| 0.5 * (l + h)).collect();
            let radius = low.iter().zip(&high).map(|(l, h)| 0.5 * (h - l)).fold(f64::INFINITY, f64::min);
            if radius.is_finite() && !matches!(body.shape, ShapeSpec::Ball { .. }) {
                body.shape = ShapeSpec::Ball { center, radius };
            }
        }
    });
    all
}
