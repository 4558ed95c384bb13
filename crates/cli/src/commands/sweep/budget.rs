//! `--budget`: the resolution with which a sweep takes a given time.
//!
//! The time of a case is the estimate of `meniscus check`, which is rough: it does not foresee steps that are shortened by
//! an impact, for example, which can triple the time. It grows about as N^(D + 3/2)
//! for N cells along the longest side: N^D cells, and steps by the capillary limit. By this law N is corrected until the estimate of the
//! first and the last case agrees with the budget. A folder that holds a sweep keeps its resolution.

use super::plan::SweepFolder;
use super::runner::Runner;
use crate::args::SceneArgs;
use crate::failure::{Failure, Result, USAGE};
use crate::progress::format_wall_time;
use crate::scenes;
use meniscus_scene::estimate::check::check;
use meniscus_scene::file::Scene;

/// Largest number of corrections of the resolution; chosen without experiment.
const CORRECTIONS: usize = 4;
/// Fewest and most cells along the longest side that are chosen; without experiment.
const CELLS: [f64; 2] = [16.0, 1024.0];
/// Least distance from the budget, relative, that is worth a correction: the estimate itself is rougher.
const CLOSE: f64 = 0.1;

/// A time for a number of cases.
pub struct Budget {
    /// The time, s.
    pub seconds: f64,
    /// Number of cases.
    pub cases: usize,
    /// Cases at the same time.
    pub jobs: usize,
}

impl Budget {
    /// Cells along the longest side for the budget; `ends` are the settings of the first and the last case.
    ///
    /// # Errors
    /// The error of a scene that cannot be loaded; a failure of status 2 if all grids that were tried are too slow.
    pub fn cells(&self, args: &SceneArgs, folder: &SweepFolder, ends: &[Vec<String>; 2]) -> Result<u32> {
        if folder.holds_a_plan() {
            return Ok(cells_of(&folder.load_scene(0)?));
        }
        let stated = scenes::load(args, &ends[0])?.scene;
        let power = stated.domain.dimension as f64 + 1.5;
        let mut cells = f64::from(cells_of(&stated));
        let mut best: Option<(f64, f64)> = None;
        for _ in 0..=CORRECTIONS {
            let seconds = self.estimate(args, ends, cells)?;
            if seconds <= self.seconds && best.is_none_or(|(most, _)| cells > most) {
                best = Some((cells, seconds));
            }
            let left = self.seconds / seconds;
            let next =
                (cells * (left * (1.0 - 0.5 * CLOSE)).powf(1.0 / power)).floor().clamp(CELLS[0], CELLS[1]);
            if next == cells || (1.0..1.0 + CLOSE).contains(&left) {
                break;
            }
            cells = next;
        }
        let (cells, seconds) = best.ok_or_else(|| {
            let failure = Failure::new(
                USAGE,
                format!("{} cases take longer than the budget with {cells} cells", self.cases),
            );
            failure.help("give more time, fewer cases, or a shorter output.duration")
        })?;
        let time = format_wall_time(seconds);
        eprintln!("budget: {cells} cells along the longest side; {} cases take roughly {time}", self.cases);
        Ok(cells as u32)
    }

    /// Estimated time of all cases, s.
    fn estimate(&self, args: &SceneArgs, ends: &[Vec<String>; 2], cells: f64) -> Result<f64> {
        let args = SceneArgs { cells: Some(cells as u32), ..args.clone() };
        let threads = Runner::threads_of_each(self.jobs);
        let mut sum = 0.0;
        for sets in ends {
            let report = check(&scenes::load(&args, sets)?.scene, threads);
            if let Some(error) = report.error {
                return Err(error.into());
            }
            sum += report.run_seconds;
        }
        let rounds = self.cases.div_ceil(self.jobs);
        Ok(0.5 * sum * rounds as f64)
    }
}

fn cells_of(scene: &Scene) -> u32 {
    scene.domain.cells.iter().max().map_or(0, |n| *n as u32)
}
