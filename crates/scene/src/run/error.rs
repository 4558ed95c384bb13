//! Errors of a run.

use super::checkpoint::CheckpointError;
use crate::output::{FileError, FolderError};
use meniscus_numerics::linalg::SolveError;
use meniscus_sim::StepError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a run could not begin or continue.
#[derive(Debug, Error)]
pub enum RunError {
    /// The output folder cannot be used.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// No checkpoint of the folder can be used.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The folder holds a run of another scene.
    #[error("the folder `{}` contains a run of another scene", .0.display())]
    OtherScene(PathBuf),
    /// The output failed during the run.
    #[error("{error}")]
    Output {
        /// What failed.
        error: FileError,
        /// Last good checkpoint.
        checkpoint: Option<PathBuf>,
    },
    /// The solver failed.
    #[error("the solver cannot continue: {error}")]
    Step {
        /// What failed.
        error: StepError,
        /// Last good checkpoint.
        checkpoint: Option<PathBuf>,
    },
    /// The matrix of the solids could not be factorised.
    #[error(
        "the solver cannot continue: at time {time:.6e} s the matrix of the solids is not positive definite for a time step of \
         {step:.3e} s: a solid is too stiff for double precision, elements are crushed, or solids are jammed{narrowest}"
    )]
    Solids {
        /// Time of the last good state, s.
        time: f64,
        /// Length of the step, s.
        step: f64,
        /// Description of the narrowest gap between solids; empty if none is narrow.
        narrowest: String,
        /// Last good checkpoint.
        checkpoint: Option<PathBuf>,
    },
    /// A number was not finite.
    #[error("the solver cannot continue: the {what} is not finite at time {time:.6e} s")]
    NotFinite {
        /// Name of the quantity.
        what: &'static str,
        /// Time, s.
        time: f64,
        /// Last good checkpoint.
        checkpoint: Option<PathBuf>,
    },
}

impl RunError {
    /// The error of a failed step, with a description of the narrowest gap between solids.
    pub(super) fn of_step(error: StepError, narrowest: impl Fn() -> String) -> Self {
        let checkpoint = None;
        match &error {
            StepError::SolveFailed { time, source: SolveError::NotPositiveDefinite { step }, .. } => {
                Self::Solids { time: *time, step: *step, narrowest: narrowest(), checkpoint }
            }
            _ => Self::Step { error, checkpoint },
        }
    }

    /// Exit status of a program that ends with this error.
    pub fn exit_status(&self) -> u8 {
        if self.is_solver_failure() { 5 } else { 4 }
    }

    /// Whether the solver failed, not input or output.
    pub fn is_solver_failure(&self) -> bool {
        matches!(self, Self::Step { .. } | Self::Solids { .. } | Self::NotFinite { .. })
    }

    /// The last good checkpoint, if there is one.
    pub fn checkpoint(&self) -> Option<&PathBuf> {
        match self {
            Self::Output { checkpoint, .. }
            | Self::Step { checkpoint, .. }
            | Self::Solids { checkpoint, .. }
            | Self::NotFinite { checkpoint, .. } => checkpoint.as_ref(),
            _ => None,
        }
    }

    /// Advice for the user.
    pub fn advice(&self) -> String {
        match self {
            Self::Folder(FolderError::Taken(_)) => {
                "continue it with --resume, replace it with --force, or choose another folder with --out DIR"
                    .into()
            }
            Self::Folder(FolderError::Busy(_)) => "wait for it to end, or choose another folder with --out DIR".into(),
            Self::Folder(FolderError::File(error)) | Self::Checkpoint(CheckpointError::File(error)) => {
                error.advice().into()
            }
            Self::Checkpoint(CheckpointError::Damaged { .. }) => {
                "no checkpoint of this run can be used: start the run again with --force".into()
            }
            Self::Checkpoint(CheckpointError::Foreign { .. }) | Self::OtherScene(_) => {
                "resume with the unchanged scene (scene.toml in the folder), or start a new run with --force or another --out DIR"
                    .into()
            }
            Self::Output { error, .. } => error.advice().into(),
            Self::Solids { .. } => {
                "look at the last frame: if elements are crushed, use a finer mesh, a larger damping_ratio or a smaller \
                 numerics.max_step; if a moved solid presses against others, give them more room; otherwise use a softer \
                 material or material.rigid"
                    .into()
            }
            Self::Step {
                error: StepError::SolveFailed { source: SolveError::OutOfMemory { .. }, .. }, ..
            } => "use a coarser mesh for the solids that deform, or a machine with more memory".into(),
            Self::Step { .. } | Self::NotFinite { .. } => {
                "try a finer resolution or a smaller numerics.max_step; `meniscus check` shows how well the scene is resolved"
                    .into()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_without_factors_says_what_to_do() {
        let source = SolveError::NotPositiveDefinite { step: 0.002 };
        let error = StepError::SolveFailed { time: 0.5, dt: 0.002, source };
        let error = RunError::of_step(error, || ", the narrowest gap".into());
        assert!(error.to_string().ends_with("the narrowest gap"), "{error}");
        assert!(error.to_string().contains("the matrix of the solids is not positive definite"), "{error}");
        assert!(error.exit_status() == 5 && error.advice().contains("max_step"));
        let source = SolveError::OutOfMemory { unknowns: 3000 };
        let memory = RunError::of_step(StepError::SolveFailed { time: 0.5, dt: 0.002, source }, String::new);
        assert!(memory.to_string().contains("3000 unknowns") && memory.advice().contains("coarser mesh"));
        let other = StepError::NotFinite { time: 0.0, what: "velocity" };
        assert!(matches!(RunError::of_step(other, String::new), RunError::Step { .. }));
    }
}
