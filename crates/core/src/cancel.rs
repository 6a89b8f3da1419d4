//! A cancellation token that threads share.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Stops the runs that were given it; clones share one token.
///
/// Reading it costs one relaxed load, so inner loops may read it every few microseconds. A computation that finds it set returns
/// early with values of the right shape but without meaning; its run then ends with an error.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<Token>);

#[derive(Debug, Default)]
struct Token {
    is_set: AtomicBool,
    /// Reads until the token counts as set; none for no limit.
    #[cfg(test)]
    reads_left: Option<std::sync::atomic::AtomicUsize>,
}

impl Cancel {
    /// A token that is not set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Stops the runs that were given this token. A token cannot be reset.
    pub fn cancel(&self) {
        self.0.is_set.store(true, Ordering::Relaxed);
    }

    /// Whether [`Cancel::cancel`] was called.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        #[cfg(test)]
        if let Some(left) = &self.0.reads_left {
            let less = |n: usize| n.checked_sub(1);
            return left
                .fetch_update(Ordering::Relaxed, Ordering::Relaxed, less)
                .is_err();
        }
        self.0.is_set.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
impl Cancel {
    /// A token that counts as set after this number of reads.
    pub(crate) fn after(reads: usize) -> Self {
        Self(Arc::new(Token {
            is_set: AtomicBool::new(false),
            reads_left: Some(reads.into()),
        }))
    }

    /// Reads left until it counts as set.
    pub(crate) fn reads_left(&self) -> usize {
        let left = self.0.reads_left.as_ref();
        left.map_or(0, |left| left.load(Ordering::Relaxed))
    }
}
