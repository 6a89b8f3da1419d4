//! The observer of an experiment: progress, stored fields, cancellation; and the errors of experiments.

use thiserror::Error;

use isomend_core::grid::Volume;

/// Why an experiment stopped early.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The observer stopped it.
    #[error("the experiment was stopped")]
    Stopped,
    /// φ is not finite any more.
    #[error("the flow blew up in step {step}; take a smaller time step")]
    BlewUp {
        /// The step.
        step: usize,
    },
    /// φ has no zero line, so it cannot be measured or redistanced.
    #[error("there is no zero line after step {step}; take a finer grid or a shorter run")]
    NoZeroLine {
        /// The step.
        step: usize,
    },
    /// A field could not be stored.
    #[error("cannot store the field of step {step}: {reason}")]
    Frame {
        /// The step.
        step: usize,
        /// The cause.
        reason: String,
    },
}

/// Follows an experiment. All methods may be called from several threads.
pub trait Observer: Sync {
    /// Receives a line of progress.
    fn progress(&self, line: &str) {
        let _ = line;
    }

    /// Stores a field.
    fn frame(&self, frame: &Frame) -> Result<(), StudyError> {
        let _ = frame;
        Ok(())
    }

    /// Whether to continue; false stops the experiment.
    fn keep_going(&self) -> bool {
        true
    }
}

/// An observer that ignores everything.
pub struct Silent;

impl Observer for Silent {}

/// A field at one time.
pub struct Frame<'a> {
    /// Name of the run that it belongs to.
    pub series: &'a str,
    /// Number of steps taken.
    pub step: usize,
    /// Time, in units of length⁴.
    pub time: f64,
    /// φ; one layer of nodes for experiments in the plane.
    pub volume: &'a Volume,
}
