//! Who watches an experiment, and the fields that can be kept of it.

use thiserror::Error;

use crate::grid::Volume;

/// Why an experiment did not come to its end.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The caller ended it.
    #[error("the experiment was stopped")]
    Stopped,
    /// φ is no longer finite.
    #[error("the flow blew up in step {step}; take a smaller time step")]
    BlewUp {
        /// The step.
        step: usize,
    },
    /// There is no zero line to measure or redistance.
    #[error("there is no zero line after step {step}; take a finer grid or a shorter run")]
    NoZeroLine {
        /// The step.
        step: usize,
    },
    /// A field could not be kept.
    #[error("cannot keep the field of step {step}: {reason}")]
    Frame {
        /// The step.
        step: usize,
        /// Why not.
        reason: String,
    },
}

/// A watcher. All methods may be called from several threads.
pub trait Observer: Sync {
    /// Hears how far the experiment is.
    fn progress(&self, line: &str) {
        let _ = line;
    }

    /// Keeps a field.
    fn frame(&self, frame: &Frame) -> Result<(), StudyError> {
        let _ = frame;
        Ok(())
    }

    /// False ends the experiment.
    fn keep_going(&self) -> bool {
        true
    }
}

/// A watcher that keeps nothing.
pub struct Silent;

impl Observer for Silent {}

/// A field at one time.
pub struct Frame<'a> {
    /// Name of the run it belongs to.
    pub series: &'a str,
    /// Step.
    pub step: usize,
    /// Time, in units of length⁴.
    pub time: f64,
    /// φ; of one layer of nodes where the experiment is in the plane.
    pub volume: &'a Volume,
}
