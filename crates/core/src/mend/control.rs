//! Control of a run: threads, progress and cancellation.

use std::sync::{Mutex, PoisonError};

use super::FillError;
use super::error::MOST_THREADS;
use crate::cancel::Cancel;
use crate::fill::RegionReport;
use crate::mesh::HoleId;
use crate::threads::Threads;

/// A callback that receives each [`Step`], often and from several threads.
pub type Progress<'a> = dyn Fn(&Step) + Sync + 'a;

/// Threads, progress and cancellation of a run. The result does not depend on them.
///
/// ```
/// use isomend::{Cancel, Control};
///
/// let cancel = Cancel::new();
/// let progress = |step: &isomend::Step| println!("{} of {}", step.done, step.all);
/// let control = Control::new().threads(2).progress(&progress).cancel(&cancel);
/// # let _ = control;
/// ```
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    threads: Option<usize>,
    progress: Option<&'a Progress<'a>>,
    cancel: Option<&'a Cancel>,
}

impl<'a> Control<'a> {
    /// Runs on the caller's threads, without progress and cancellation.
    pub fn new() -> Self {
        Self::default()
    }

    /// The largest number of threads. More threads than cores cost memory and gain nothing.
    pub const MOST_THREADS: usize = MOST_THREADS;

    /// Runs on a separate pool of `threads` threads, at most [`Control::MOST_THREADS`]; 0 is one per core.
    #[must_use]
    pub fn threads(self, threads: usize) -> Self {
        let threads = Some(threads);
        Self { threads, ..self }
    }

    /// Reports progress to this callback.
    #[must_use]
    pub fn progress(self, progress: &'a Progress<'a>) -> Self {
        let progress = Some(progress);
        Self { progress, ..self }
    }

    /// Stops once the token is set, with [`FillError::Cancelled`].
    #[must_use]
    pub fn cancel(self, cancel: &'a Cancel) -> Self {
        let cancel = Some(cancel);
        Self { cancel, ..self }
    }

    /// Whether the run has to stop.
    pub(super) fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(Cancel::is_cancelled)
    }

    /// Reports progress, if it is wanted.
    pub fn report(&self, step: &Step) {
        if let Some(progress) = self.progress {
            progress(step);
        }
    }

    /// The token that stops the run; one that is never set where none was given.
    pub fn token(&self) -> Cancel {
        self.cancel.cloned().unwrap_or_default()
    }

    /// Whether its parameters are within their bounds. Every run checks that first.
    ///
    /// # Errors
    /// [`FillError::Threads`] for more than [`Control::MOST_THREADS`] threads.
    pub fn check(&self) -> Result<(), FillError> {
        match self.threads {
            Some(threads) if threads > Self::MOST_THREADS => Err(FillError::Threads { threads }),
            _ => Ok(()),
        }
    }

    /// Runs a closure on the requested threads.
    pub(crate) fn install<R: Send, E: From<FillError> + Send>(
        &self,
        run: impl FnOnce() -> Result<R, E> + Send,
    ) -> Result<R, E> {
        let Some(threads) = self.threads else {
            return run();
        };
        self.check()?;
        let pool = Threads::new(threads).map_err(|_| FillError::Threads { threads })?;
        pool.install(run)
    }
}

/// Progress of a run.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Step<'a> {
    /// Number of completed regions.
    pub done: usize,
    /// Number of all regions.
    pub all: usize,
    /// Fraction of the work that is done, from 0 to 1, estimated from the sizes of the grids.
    pub part: f64,
    /// The latest event.
    pub event: Event<'a>,
}

impl<'a> Step<'a> {
    /// The same step as part of a larger run, which is at `part` of its work (0 to 1), with its own event.
    pub fn within(&self, part: f64, event: Event<'a>) -> Self {
        Self {
            part,
            event,
            ..*self
        }
    }
}

/// An event of a run.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// Work continues; nothing else happened.
    Working,
    /// A region was started: the numbers of its holes.
    Begun(&'a [HoleId]),
    /// A region was completed.
    Ended(&'a RegionReport),
}

/// Counts the completed regions of a run, reports progress, and checks for cancellation.
pub(crate) struct Watch<'a> {
    control: Control<'a>,
    /// The caller's token, or one that is never set.
    cancel: Cancel,
    /// Expected work of each region.
    work: Vec<f64>,
    /// Sum of the expected work.
    all: f64,
    /// Number of completed regions, and their work.
    done: Mutex<(usize, f64)>,
}

impl<'a> Watch<'a> {
    pub(crate) fn new(control: Control<'a>, work: Vec<f64>) -> Self {
        Self {
            control,
            cancel: control.cancel.cloned().unwrap_or_default(),
            all: work.iter().sum(),
            work,
            done: Mutex::new((0, 0.0)),
        }
    }

    /// Whether the run continues; also reports progress. Loops call this once in many milliseconds, and check [`Watch::token`]
    /// more often.
    pub(crate) fn keep_going(&self) -> bool {
        self.tell(Event::Working);
        !self.cancel.is_cancelled()
    }

    /// The token that stops the run.
    pub(crate) fn token(&self) -> &Cancel {
        &self.cancel
    }

    /// Reports that a region was started.
    pub(crate) fn begin(&self, holes: &[HoleId]) {
        self.tell(Event::Begun(holes));
    }

    /// Reports that a region was completed.
    pub(crate) fn end(&self, region: usize, report: &RegionReport) {
        {
            let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
            *done = (done.0 + 1, done.1 + self.work[region]);
        }
        self.tell(Event::Ended(report));
    }

    /// Returns an error if the run was cancelled.
    pub(crate) fn finish(&self) -> Result<(), FillError> {
        match self.keep_going() {
            true => Ok(()),
            false => Err(FillError::Cancelled),
        }
    }

    fn tell(&self, event: Event) {
        let Some(progress) = self.control.progress else {
            return;
        };
        let (done, work) = *self.done.lock().unwrap_or_else(PoisonError::into_inner);
        progress(&Step {
            done,
            all: self.work.len(),
            part: if self.all > 0.0 {
                (work / self.all).min(1.0)
            } else {
                1.0
            },
            event,
        });
    }
}
