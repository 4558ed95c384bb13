//! The list of the built-in scenes.

use super::entry::Builtin;

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
            text: include_str!(concat!("../../../../scenes/", $name, ".toml")),
        }
    };
}

/// Every built-in scene, cheap ones first.
pub const BUILTINS: [Builtin; 74] = [
    scene!("oscillating-drop-2d", 2, "A disc of water of 1 mm radius oscillates in mode 2", "a few seconds"),
    scene!("capillary-wave-2d", 2, "A standing capillary wave of 1 cm on water", "a few seconds"),
    scene!("dam-break-2d", 2, "A column of water collapses in a tank (Martin and Moyce)", "a few seconds"),
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
        "fig12-contact-angle-180-2d",
        2,
        Some("Fig. 12"),
        "A disc of liquid settles on a plate that it does not wet",
        "ten seconds"
    ),
    scene!(
        "fig13-escaping-sphere",
        2,
        Some("Fig. 13"),
        "A hydrophobic sphere breaks through the surface of a drop and is expelled",
        "under half a minute"
    ),
    scene!(
        "fig13-hydrophilic-twin",
        2,
        Some("Fig. 13"),
        "A hydrophilic sphere at the surface of a drop stays there",
        "under half a minute"
    ),
    scene!(
        "fig17a-kinematic-sphere",
        2,
        Some("Fig. 17 (a)"),
        "A hydrophilic sphere dips into a pool and lifts liquid as it is drawn out",
        "half a minute"
    ),
    scene!(
        "fig17a-kinematic-sphere-hydrophobic",
        2,
        Some("Fig. 17 (a)"),
        "A hydrophobic sphere dips into a pool and comes out dry",
        "half a minute"
    ),
    scene!(
        "fig17a-kinematic-sphere-no-line",
        2,
        Some("Fig. 17 (a)"),
        "A sphere dips into a pool without a contact line: the liquid does not climb it",
        "half a minute"
    ),
    scene!(
        "fig17a-kinematic-sphere-hydrophobic-no-line",
        2,
        Some("Fig. 17 (a)"),
        "A hydrophobic sphere without a contact line dips into a pool and comes out with a meniscus",
        "half a minute"
    ),
    scene!(
        "fig17c-sink",
        2,
        Some("Fig. 17 (c)"),
        "A hydrophilic sphere twice as dense as the liquid sinks",
        "half a minute"
    ),
    scene!(
        "fig17c-sink-heavy",
        2,
        Some("Fig. 17 (c)"),
        "A hydrophobic sphere 3.5 times as dense as the liquid sinks",
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
        "A water drop of 1 mm radius at rest: any velocity is an error",
        "about half a minute"
    ),
    scene!(
        "oscillating-drop",
        3,
        "A water drop of 1 mm radius oscillates in mode 2 with Rayleigh's period",
        "one to two minutes"
    ),
    scene!(
        "drop-on-incline",
        3,
        "A drop slides down a plane without hysteresis and contact-line friction",
        "one to two minutes"
    ),
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
        "A drop spreads on a ball to a contact angle of 60 degrees",
        "a few minutes"
    ),
    scene!(
        "capillary-bridge",
        3,
        None,
        "A drop between two plates becomes a capillary bridge",
        "a few minutes"
    ),
    scene!(
        "drop-on-incline-pinned",
        3,
        "Hysteresis of the contact angle holds a drop on a slope",
        "a few minutes"
    ),
    scene!("bouncing-drop", 3, None, "A drop bounces off a hydrophobic plate", "a few minutes"),
    scene!(
        "raindrop-on-window",
        3,
        "Of two drops on a window pane the small one stays, the large one runs down",
        "a few minutes"
    ),
    scene!(
        "textured-wettability",
        3,
        "A drop lands on a hydrophobic plate and takes the shape of a hydrophilic cross",
        "a few minutes"
    ),
    scene!(
        "drop-on-soft-plate-2d",
        2,
        "A drop falls on a soft plate, which oscillates and bends around it",
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
        "A drop on a hydrophobic beam clamped at one end rolls down and falls off its free end",
        "half a minute"
    ),
    scene!(
        "fig17b-wrapping",
        2,
        Some("Fig. 17 (b)"),
        "A soft hydrophilic strip wraps a drop",
        "four minutes"
    ),
    scene!(
        "fig17b-open",
        2,
        Some("Fig. 17 (b)"),
        "A soft hydrophobic strip bends under a drop and stays open",
        "a minute"
    ),
    scene!(
        "fig17b-no-line",
        2,
        Some("Fig. 17 (b)"),
        "A drop on a soft strip without a contact line: the strip does not bend",
        "a minute"
    ),
    scene!(
        "fig14-soft-plate",
        2,
        Some("Fig. 14"),
        "A drop falls on a soft hydrophobic plate and bends it",
        "ten minutes"
    ),
    scene!(
        "drop-on-soft-plate",
        3,
        "A drop falls on a soft plate, which oscillates and bends around it",
        "a few minutes"
    ),
    scene!(
        "drop-on-leaf",
        3,
        Some("Fig. 11"),
        "A raindrop bends a soft leaf down and runs off, and the leaf swings back",
        "ten minutes; --quality draft: three"
    ),
    scene!(
        "drop-on-leaf-paper-constants",
        3,
        Some("Fig. 11"),
        "A raindrop hits a leaf with the paper's stiffness and density, which hardly bends",
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
        "A drop hits the end of a beam, which oscillates with the drop on it",
        "five minutes"
    ),
    scene!("capillary-rise", 3, "Liquid rises in a tube to Jurin's height", "ten minutes"),
    scene!(
        "floating-sphere",
        3,
        Some("Fig. 17"),
        "A ball twice as dense as the liquid floats on its surface",
        "ten minutes"
    ),
    scene!("cheerios", 3, "Two floating discs attract each other and meet", "ten minutes"),
    scene!(
        "fig20-beam-neutral",
        3,
        Some("Fig. 20"),
        "A drop falls on a neutral cantilever and rests there at Young's angle (78.5 degrees)",
        "a quarter of an hour; --quality draft: five minutes"
    ),
    scene!(
        "fig20-beam-no-line",
        3,
        Some("Fig. 20"),
        "A drop on a cantilever without a contact line: it rests at 90 degrees whatever the tensions",
        "half an hour; --quality draft: ten minutes"
    ),
    scene!(
        "colliding-drops",
        3,
        "Two water drops meet slowly (We = 10), merge and oscillate",
        "a few minutes"
    ),
    scene!("filament-breakup", 3, "A thread of water bulges, necks and breaks into drops", "a few minutes"),
    scene!(
        "colliding-drops-fast",
        3,
        "Two water drops meet fast and off centre (We = 61), merge and separate again",
        "two to ten minutes"
    ),
    scene!(
        "fig21-tank-float",
        3,
        Some("Fig. 21"),
        "A soft plate five times as dense as the liquid floats by surface tension",
        "an hour; --quality draft: half an hour"
    ),
    scene!(
        "fig21-tank-sink",
        3,
        Some("Fig. 21"),
        "A soft plate five times as dense as the liquid sinks at a low surface tension",
        "half an hour; --quality draft: four minutes"
    ),
    scene!(
        "fig10-four-petal",
        3,
        Some("Fig. 10"),
        "A drop folds a sheet with four petals around itself",
        "half an hour; --quality draft: four minutes"
    ),
    scene!(
        "fig10-six-petal",
        3,
        Some("Fig. 10"),
        "A drop folds a sheet with six petals around itself",
        "half an hour; --quality draft: four minutes"
    ),
    scene!(
        "fig10-triangle",
        3,
        Some("Fig. 10"),
        "A drop folds a triangular sheet around itself",
        "half an hour; --quality draft: four minutes"
    ),
    scene!(
        "fig18-self-assembly",
        3,
        Some("Fig. 18"),
        "A drop folds six panels that are joined by bridges to a box",
        "half an hour; --quality draft: six minutes"
    ),
    scene!(
        "fig11-leaf-hydrophobic",
        3,
        Some("Fig. 11"),
        "A drop splashes on a hydrophobic leaf, and its pieces fly to a glass wall",
        "half an hour; --quality draft: four minutes"
    ),
    scene!(
        "fig11-leaf-hydrophilic",
        3,
        Some("Fig. 11"),
        "A drop runs over a hydrophilic leaf, which stays wet up to its apex",
        "half an hour; --quality draft: four minutes"
    ),
    scene!(
        "soft-pillars",
        3,
        "Soft hairs are drawn out of a bath, and surface tension pulls them together",
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
        "fig16-radius-2",
        3,
        Some("Fig. 16"),
        "A drop folds a square sheet, with the line's force spread over 2 cells",
        "forty minutes"
    ),
    scene!(
        "fig16-radius-3",
        3,
        Some("Fig. 16"),
        "A drop folds a square sheet, with the line's force spread over 3 cells",
        "forty minutes"
    ),
    scene!(
        "fig16-radius-4",
        3,
        Some("Fig. 16"),
        "A drop folds a square sheet, with the line's force spread over 4 cells",
        "forty minutes"
    ),
    scene!(
        "fig15-origami-square-paper-constants",
        3,
        Some("Fig. 15"),
        "A drop on a square sheet with the paper's springs, which is too stiff to fold",
        "an hour"
    ),
    scene!(
        "fig19-beam-hydrophobic",
        3,
        Some("Fig. 19"),
        "A fast drop hits a hydrophobic cantilever, breaks up and leaves it",
        "an hour; --quality draft: ten minutes"
    ),
    scene!(
        "fig19-beam-neutral",
        3,
        Some("Fig. 19"),
        "A fast drop hits a neutral cantilever and breaks up; some of it stays",
        "an hour; --quality draft: ten minutes"
    ),
    scene!(
        "fig19-beam-hydrophilic",
        3,
        Some("Fig. 19"),
        "A fast drop hits a hydrophilic cantilever and covers it with a film",
        "an hour; --quality draft: ten minutes"
    ),
    scene!(
        "fig22-plate-90",
        3,
        Some("Fig. 22"),
        "A drop rests on a soft plate at a contact angle of 90 degrees",
        "half an hour; --quality draft: a quarter"
    ),
    scene!(
        "fig22-plate-90-paper-constants",
        3,
        Some("Fig. 22"),
        "A drop rests on a plate with the paper's springs, which is stiff (90 degrees)",
        "half an hour; --quality draft: a quarter"
    ),
    scene!(
        "fig22-plate-180",
        3,
        Some("Fig. 22"),
        "A drop rests on a soft plate at a contact angle of 97.7 degrees",
        "half an hour; --quality draft: a quarter"
    ),
    scene!(
        "fig22-plate-180-paper-constants",
        3,
        Some("Fig. 22"),
        "A drop rests on a plate with the paper's springs, which is stiff (97.7 degrees)",
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
        "A drop with the paper's tensions runs off a stiff plate in a film",
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
