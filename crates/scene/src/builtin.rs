//! The built-in scenes.

use crate::error::{ErrorKind, SceneError, nearest};
use crate::file::{LoadOptions, Scene};
use serde::Serialize;
use std::path::Path;

/// A built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Builtin {
    /// Name.
    pub name: &'static str,
    /// 2 or 3.
    pub dimension: u32,
    /// The figure of the paper that it follows, if any.
    pub figure: Option<&'static str>,
    /// One-line summary of the scene.
    pub line: &'static str,
    /// Approximate cost of a run on two cores.
    pub cost: &'static str,
    /// The scene file.
    #[serde(skip)]
    pub text: &'static str,
}

macro_rules! scene {
    ($name:literal, $dimension:literal, $line:literal, $cost:literal) => {
        scene!($name, $dimension, None, $line, $cost)
    };
    ($name:literal, $dimension:literal, $figure:expr, $line:literal, $cost:literal) => {
        Builtin {
            name: $name,
            dimension: $dimension,
            figure: $figure,
            line: $line,
            cost: $cost,
            text: include_str!(concat!("../../../scenes/", $name, ".toml")),
        }
    };
}

/// Every built-in scene, cheap ones first.
pub const BUILTINS: [Builtin; 58] = [
    scene!("oscillating-drop-2d", 2, "A disc of water of 1 mm swings in its second mode", "a few seconds"),
    scene!("capillary-wave-2d", 2, "A standing capillary wave of 1 cm on water", "a few seconds"),
    scene!("dam-break-2d", 2, "Martin and Moyce's collapsing column of water", "a few seconds"),
    scene!(
        "fig12-contact-angle-90-2d",
        2,
        Some("Fig. 12"),
        "A disc of liquid settles on a plate at Young's angle",
        "ten seconds"
    ),
    scene!(
        "fig12-contact-angle-45-2d",
        2,
        Some("Fig. 12"),
        "A disc of liquid settles on a plate at Young's angle",
        "ten seconds"
    ),
    scene!(
        "fig12-contact-angle-135-2d",
        2,
        Some("Fig. 12"),
        "A disc of liquid settles on a plate at Young's angle",
        "ten seconds"
    ),
    scene!(
        "fig13-escaping-sphere",
        2,
        Some("Fig. 13"),
        "A hydrophobic sphere in a drop breaks through its surface and is pushed out",
        "under half a minute"
    ),
    scene!(
        "fig13-hydrophilic-twin",
        2,
        Some("Fig. 13"),
        "The same sphere, hydrophilic, stays in the drop",
        "under half a minute"
    ),
    scene!(
        "fig17a-kinematic-sphere",
        2,
        Some("Fig. 17 (a)"),
        "A hydrophilic sphere dips into a pool and takes the liquid up with it",
        "half a minute"
    ),
    scene!(
        "fig17a-kinematic-sphere-hydrophobic",
        2,
        Some("Fig. 17 (a)"),
        "The same sphere, hydrophobic, leaves the pool dry",
        "half a minute"
    ),
    scene!(
        "fig17a-kinematic-sphere-no-line",
        2,
        Some("Fig. 17 (a)"),
        "The same without a contact line: the liquid does not climb the sphere",
        "half a minute"
    ),
    scene!("fig17c-sink", 2, Some("Fig. 17 (c)"), "The same sphere, hydrophilic, sinks", "half a minute"),
    scene!(
        "fig17c-sink-heavy",
        2,
        Some("Fig. 17 (c)"),
        "A hydrophobic sphere that is too heavy sinks",
        "half a minute"
    ),
    scene!(
        "fig17c-float",
        2,
        Some("Fig. 17 (c)"),
        "A hydrophobic sphere twice as dense as the liquid floats on it",
        "one to two minutes"
    ),
    scene!(
        "static-drop",
        3,
        "A water drop of 1 mm radius at rest; whatever moves is an error",
        "about half a minute"
    ),
    scene!(
        "oscillating-drop",
        3,
        "A water drop of 1 mm swings in its second mode with Rayleigh's period",
        "one to two minutes"
    ),
    scene!("drop-on-incline", 3, "A drop slides down a slope that nothing holds it on", "one to two minutes"),
    scene!(
        "fig12-contact-angle-180",
        3,
        Some("Fig. 12"),
        "A drop settles on a plate that it does not wet",
        "a few minutes"
    ),
    scene!(
        "fig12-contact-angle-135",
        3,
        Some("Fig. 12"),
        "A drop settles on a plate at Young's angle",
        "a few minutes"
    ),
    scene!(
        "fig12-contact-angle-90",
        3,
        Some("Fig. 12"),
        "A drop settles on a plate at Young's angle",
        "a few minutes"
    ),
    scene!(
        "fig12-contact-angle-45",
        3,
        Some("Fig. 12"),
        "A drop settles on a plate at Young's angle",
        "a few minutes"
    ),
    scene!(
        "drop-on-sphere",
        3,
        None,
        "A drop spreads on a ball until it meets it at 60 degrees",
        "a few minutes"
    ),
    scene!(
        "capillary-bridge",
        3,
        None,
        "A drop between two plates becomes a bridge that pulls them together",
        "a few minutes"
    ),
    scene!(
        "drop-on-incline-pinned",
        3,
        "Hysteresis of the contact angle holds a drop on a slope",
        "a few minutes"
    ),
    scene!("bouncing-drop", 3, None, "A drop bounces off a plate that repels it", "a few minutes"),
    scene!(
        "raindrop-on-window",
        3,
        "Of two drops on a window pane the small one stays, the large one runs down",
        "a few minutes"
    ),
    scene!(
        "textured-wettability",
        3,
        "A drop lands on a plate that repels it but for a cross, and takes its shape",
        "a few minutes"
    ),
    scene!(
        "drop-on-soft-plate-2d",
        2,
        "A drop falls on a soft plate, which gives way, swings and bends around it",
        "under half a minute"
    ),
    scene!(
        "drop-on-beam-2d",
        2,
        "A drop on a beam clamped at one end spreads to its free end and bends it down",
        "half a minute"
    ),
    scene!(
        "drop-on-beam-2d-160",
        2,
        "The same beam, which repels the drop: it rolls down and falls off the end",
        "half a minute"
    ),
    scene!(
        "fig17b-wrapping",
        2,
        Some("Fig. 17 (b)"),
        "A drop that wets a soft strip well is wrapped up in it",
        "four minutes"
    ),
    scene!(
        "fig17b-open",
        2,
        Some("Fig. 17 (b)"),
        "The same drop and strip, hydrophobic: the strip bends, and stays open",
        "a minute"
    ),
    scene!(
        "fig17b-no-line",
        2,
        Some("Fig. 17 (b)"),
        "The same drop and strip without a contact line: nothing bends the strip",
        "a minute"
    ),
    scene!(
        "fig14-soft-plate",
        2,
        Some("Fig. 14"),
        "A drop falls on a soft plate that repels it and bends",
        "ten minutes"
    ),
    scene!(
        "drop-on-soft-plate",
        3,
        "A drop falls on a soft plate, which gives way, swings and bends around it",
        "a few minutes"
    ),
    scene!(
        "drop-on-leaf",
        3,
        Some("Fig. 11"),
        "A raindrop bends a soft leaf down, runs off and lets it swing back",
        "ten minutes; --quality draft: three"
    ),
    scene!(
        "drop-on-leaf-paper-constants",
        3,
        Some("Fig. 11"),
        "The same with the stiffness and density that the paper has: the leaf hardly bends",
        "ten minutes; --quality draft: three"
    ),
    scene!(
        "soft-duck",
        3,
        "A soft duck, read from an .obj file, falls into a bath, tips over and floats on its side",
        "half an hour; --quality draft: ten minutes"
    ),
    scene!(
        "drop-on-cantilever",
        3,
        Some("Fig. 19"),
        "A drop hits the end of a beam, which swings with it",
        "five minutes"
    ),
    scene!("capillary-rise", 3, "Liquid climbs in a tube and stops at Jurin's height", "ten minutes"),
    scene!(
        "floating-sphere",
        3,
        Some("Fig. 17"),
        "A ball twice as dense as the liquid floats on its surface",
        "ten minutes"
    ),
    scene!("cheerios", 3, "Two floating discs attract each other and meet", "ten minutes"),
    scene!("colliding-drops", 3, "Two water drops meet slowly (We = 10), merge and wobble", "a few minutes"),
    scene!("filament-breakup", 3, "A thread of water bulges, necks and breaks into drops", "a few minutes"),
    scene!(
        "colliding-drops-fast",
        3,
        "Two water drops meet fast and off centre (We = 61), merge and tear apart again",
        "two to ten minutes"
    ),
    scene!(
        "fig21-tank-float",
        3,
        Some("Fig. 21"),
        "A soft plate five times as dense as the liquid floats on its strong surface",
        "an hour; --quality draft: half an hour"
    ),
    scene!(
        "fig21-tank-sink",
        3,
        Some("Fig. 21"),
        "A soft plate five times as dense as the liquid sinks through a weak surface",
        "half an hour; --quality draft: four minutes"
    ),
    scene!(
        "soft-pillars",
        3,
        "Soft hairs are drawn out of a bath, and the liquid that drains draws them together",
        "an hour; --quality draft: twenty minutes"
    ),
    scene!(
        "fig15-origami-square",
        3,
        Some("Fig. 15"),
        "A drop folds a square sheet around itself",
        "forty minutes"
    ),
    scene!(
        "fig15-origami-square-paper-constants",
        3,
        Some("Fig. 15"),
        "The same with the springs that the paper prints: the sheet is too stiff to fold",
        "an hour"
    ),
    scene!(
        "fig22-plate-90",
        3,
        Some("Fig. 22"),
        "A drop rests on a soft plate at 90 degrees",
        "half an hour; --quality draft: a quarter"
    ),
    scene!(
        "fig22-plate-90-paper-constants",
        3,
        Some("Fig. 22"),
        "The same with the springs that the paper prints: the plate is stiff",
        "half an hour; --quality draft: a quarter"
    ),
    scene!(
        "fig22-plate-180",
        3,
        Some("Fig. 22"),
        "A drop rests on a soft plate that it hardly wets (97.7 degrees)",
        "half an hour; --quality draft: a quarter"
    ),
    scene!(
        "fig22-plate-180-paper-constants",
        3,
        Some("Fig. 22"),
        "The same with the springs that the paper prints: the plate is stiff",
        "half an hour; --quality draft: a quarter"
    ),
    scene!(
        "fig22-plate-0",
        3,
        Some("Fig. 22"),
        "A drop spreads over a soft plate that it wets completely",
        "half an hour; --quality draft: a quarter"
    ),
    scene!(
        "fig22-plate-0-paper-constants",
        3,
        Some("Fig. 22"),
        "The same with the springs and tensions that the paper prints: it runs off a stiff plate in a film",
        "half an hour; --quality draft: a quarter"
    ),
    scene!(
        "fig02-soft-cow",
        3,
        Some("Fig. 2"),
        "A soft cow sinks in a tank; the contact line emerges, sweeps over it and vanishes",
        "an hour; --quality draft: six minutes"
    ),
    scene!(
        "crown-splash",
        3,
        "A drop falls into a deep tank and throws up a crown (We = 1100)",
        "half an hour; --quality draft: a few minutes"
    ),
];

/// Finds the built-in scene of this name.
pub fn find(name: &str) -> Option<&'static Builtin> {
    BUILTINS.iter().find(|b| b.name == name)
}

/// Opens a scene: the path of a `.toml` file, or the name of a built-in scene.
///
/// # Errors
/// [`SceneError`] if there is no such scene (with the nearest name) or if the scene is invalid.
pub fn open(scene: &str, options: &LoadOptions) -> Result<Scene, SceneError> {
    if let Some(b) = find(scene) {
        return Scene::from_text(&format!("{}.toml", b.name), b.text, Path::new(""), options);
    }
    let path = Path::new(scene);
    if path.extension().is_some() || path.exists() || path.components().count() > 1 {
        return Scene::load(path, options);
    }
    let near = nearest(scene, BUILTINS.iter().map(|b| b.name));
    let near = near.map_or_else(String::new, |n| format!("did you mean `{n}`? "));
    let help = format!("{near}`meniscus scenes` lists the built-in scenes; a file ends in .toml");
    let error = SceneError::new(format!("there is no built-in scene `{}`", scene.escape_debug()));
    Err(SceneError { kind: ErrorKind::Io, ..error.with_help(help) })
}
