//! The cases that the scheme of the paper can run: without friction and hysteresis of lines, sides that wet, open sides that liquid leaves,
//! and contacts of solids.
//!
//! Limit: a case of this list is not checked for what the scheme ignores.

/// Names of the cases, in the order in which they run.
pub const NAMES: [&str; 28] = [
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
    "soft-sheet",
    "bounce",
    "moving-plate",
    "floating",
    "floating-force",
    "buoyancy",
    "soft-kink",
    "soft-strip",
    "soft-stiff",
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
