//! The defects that the validation suite must notice (`crates/validation/examples/sabotage`) fit the source, and every case has one.

#[path = "../../../validation/examples/sabotage/defects.rs"]
mod defects;

use defects::DEFECTS;
use meniscus_validation::cases;
use std::path::Path;

#[test]
fn every_case_has_a_defect_that_fits_the_source() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for defect in DEFECTS {
        let text = std::fs::read_to_string(root.join(defect.file)).unwrap();
        assert_eq!(
            text.matches(defect.right).count(),
            1,
            "{}, {}: {}",
            defect.name,
            defect.about,
            defect.right
        );
        assert_ne!(defect.right, defect.wrong, "{}", defect.name);
        for name in defect.cases {
            assert!(cases().iter().any(|case| case.name == *name), "{}: no case `{name}`", defect.name);
        }
    }
    for case in cases() {
        let count = DEFECTS.iter().filter(|defect| defect.cases.contains(&case.name)).count();
        assert_eq!(count, 1, "defects of the case `{}`", case.name);
    }
}
