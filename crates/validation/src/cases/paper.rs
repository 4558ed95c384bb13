//! The cases that the scheme of the paper can run: liquid with at most one solid, without friction, hysteresis, sides that wet, open
//! sides that liquid leaves, and contacts of solids. The row of `momentum-with-solid` with friction runs without it.

/// Names of the cases, in the order in which they run.
pub const NAMES: [&str; 32] = [
    "static-2d",
    "static-3d",
    "rayleigh-2d",
    "rayleigh-3d",
    "lamb-decay",
    "stokes-relaxation",
    "capillary-wave",
    "moving-drop",
    "hydrostatic",
    "volume",
    "momentum",
    "sessile-2d",
    "sessile-3d",
    "sessile-curved",
    "sessile-thin",
    "sessile-gravity-2d",
    "sessile-gravity-3d",
    "meniscus-2d",
    "tube",
    "soft-sheet",
    "bounce",
    "moving-plate",
    "floating",
    "floating-force",
    "buoyancy",
    "momentum-with-solid",
    "floating-plate",
    "soft-kink",
    "soft-strip",
    "soft-stiff",
    "soft-sag",
    "elastica-drop",
];

#[cfg(test)]
mod tests {
    #[test]
    fn every_name_is_that_of_a_case() {
        let numbers = super::NAMES.map(|name| crate::cases().iter().position(|case| case.name == name));
        assert!(numbers.iter().all(Option::is_some) && numbers.is_sorted());
    }
}
