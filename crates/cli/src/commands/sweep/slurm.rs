//! The script of a Slurm array: one task for each case.
//!
//! Slurm sends SIGUSR1 to a task 120 s before its time is over; the case ends with a checkpoint and exit status 75, and the script puts it
//! back into the queue, where it goes on from the checkpoint.

use super::plan::SweepFolder;
use crate::failure::{Failure, Result, STOPPED};

/// Seconds before the end of a task's time at which it is asked to stop.
const NOTICE_SECONDS: u32 = 120;

/// The script of a sweep of so many cases.
///
/// # Errors
/// A failure if the folder's absolute path cannot be found.
pub fn script(folder: &SweepFolder, name: &str, cases: usize, threads: Option<u16>) -> Result<String> {
    let root = std::fs::canonicalize(folder.root()).map_err(Failure::file("find", folder.root()))?;
    let root = root.display().to_string().replace('\'', r"'\''");
    let last = cases.saturating_sub(1);
    let cpus = threads.unwrap_or(1);
    Ok(format!(
        "#!/bin/bash
# Runs the cases of a sweep: sbatch this script. Add what your site asks for, such as --account and --partition.
# Then, with what has run so far: meniscus sweep FOLDER --collect
#SBATCH --job-name={name}
#SBATCH --array=0-{last}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task={cpus}
#SBATCH --time=01:00:00
#SBATCH --signal=USR1@{NOTICE_SECONDS}
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=slurm_%A_%a.log

folder='{root}'
srun \"${{MENISCUS:-meniscus}}\" sweep \"$folder\" --case \"$SLURM_ARRAY_TASK_ID\" --threads \"${{SLURM_CPUS_PER_TASK:-{cpus}}}\" --quiet
status=$?
# Stopped with a checkpoint: again, from there.
if [ \"$status\" -eq {STOPPED} ]; then
    scontrol requeue \"$SLURM_JOB_ID\" && exit 0
fi
exit \"$status\"
"
    ))
}
