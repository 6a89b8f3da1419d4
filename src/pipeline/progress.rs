//! What a run tells of its progress while it lasts.

use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::report::RegionReport;

/// Told of each [`Step`], often and from several threads; returns false to stop the run.
pub type Progress<'a> = dyn Fn(&Step) -> bool + Sync + 'a;

/// How far a run is.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Step<'a> {
    /// Regions that are done.
    pub done: usize,
    /// All regions.
    pub all: usize,
    /// The part of the work that is done, from 0 to 1, as far as it can be foretold from the sizes of the grids.
    pub part: f64,
    /// What has just happened.
    pub event: Event<'a>,
}

/// What has just happened in a run.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Event<'a> {
    /// Nothing that need be told; the run asks whether it is to go on.
    Working,
    /// A region was begun: the numbers of its holes.
    Begun(&'a [usize]),
    /// A region is done.
    Ended(&'a RegionReport),
}

/// Counts the regions of a run, and asks whether it is to go on.
pub(super) struct Watch<'a> {
    progress: &'a Progress<'a>,
    /// The work that each region is expected to be.
    work: Vec<f64>,
    /// The sum of it.
    all: f64,
    /// Regions done, and their work.
    done: Mutex<(usize, f64)>,
    stop: AtomicBool,
}

impl<'a> Watch<'a> {
    pub(super) fn new(progress: &'a Progress<'a>, work: Vec<f64>) -> Self {
        Self {
            progress,
            all: work.iter().sum(),
            work,
            done: Mutex::new((0, 0.0)),
            stop: AtomicBool::new(false),
        }
    }

    /// Whether the run is to go on.
    pub(super) fn keep_going(&self) -> bool {
        self.tell(Event::Working)
    }

    /// A region is begun.
    pub(super) fn begin(&self, holes: &[usize]) -> bool {
        self.tell(Event::Begun(holes))
    }

    /// A region is done.
    pub(super) fn end(&self, region: usize, report: &RegionReport) {
        {
            let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
            *done = (done.0 + 1, done.1 + self.work[region]);
        }
        self.tell(Event::Ended(report));
    }

    /// Whether the caller asked to stop.
    pub(super) fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn tell(&self, event: Event) -> bool {
        let (done, work) = *self.done.lock().unwrap_or_else(PoisonError::into_inner);
        let step = Step {
            done,
            all: self.work.len(),
            part: if self.all > 0.0 {
                (work / self.all).min(1.0)
            } else {
                1.0
            },
            event,
        };
        if !(self.progress)(&step) {
            self.stop.store(true, Ordering::Relaxed);
        }
        !self.stopped()
    }
}
