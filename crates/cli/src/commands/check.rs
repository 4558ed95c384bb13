//! `meniscus check`.

use super::print;
use crate::args::CheckArgs;
use crate::failure::{Failure, Result, SCENE};
use crate::scenes;
use meniscus_scene::estimate::check::check as report;
use meniscus_scene::estimate::memory;

/// Checks a scene without running it, and prints the report.
pub fn check(args: &CheckArgs) -> Result {
    let scene = scenes::load(&args.scene, &[])?.scene;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let report = report(&scene, threads);
    if args.json {
        print(&format!("{:#}\n", serde_json::json!(report)))?;
    } else {
        print(&report.render())?;
    }
    if let Some(error) = report.error {
        return Err(error.into());
    }
    memory::check_liquid_memory(&scene, memory::machine_memory())?;
    if args.strict {
        if let Some(reason) = &report.cannot_run {
            return Err(Failure::new(SCENE, reason.clone()));
        }
        if !report.warnings.is_empty() {
            let count = report.warnings.len();
            return Err(Failure::new(
                SCENE,
                format!("the scene has {count} warnings, which --strict treats as errors"),
            ));
        }
    }
    Ok(0)
}
