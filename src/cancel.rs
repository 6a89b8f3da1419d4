//! A token that stops a computation.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Stops runs: a token that several threads may share.
///
/// Reading it costs one relaxed load, so inner loops may do so for every few microseconds of work. A computation that finds it set
/// returns early with values of the right shape but without meaning; the run that it belongs to ends with an error.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// A token that is not set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Stops the runs that were given this token, for good.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it was set.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
