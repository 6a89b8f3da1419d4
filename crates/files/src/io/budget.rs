//! The memory that the content of a file may take.

use super::{Format, IoError, Location};

/// What is left of the memory that the content of a file may take.
pub(super) struct Budget {
    /// The format, for messages.
    pub(super) format: Format,
    /// What takes the memory, such as a scene, and what to do where it takes too much.
    holder: (&'static str, &'static str),
    left: usize,
    is_exhausted: bool,
}

impl Budget {
    /// A limit of `least` bytes plus `times` the size of a file.
    pub(super) fn new(
        format: Format,
        holder: (&'static str, &'static str),
        least: usize,
        [times, size]: [usize; 2],
    ) -> Self {
        Self {
            format,
            holder,
            left: size.saturating_mul(times).saturating_add(least),
            is_exhausted: false,
        }
    }

    /// Charges memory before it is allocated.
    pub(super) fn spend(&mut self, bytes: usize) -> Result<(), IoError> {
        if let Some(left) = self.left.checked_sub(bytes) {
            self.left = left;
            return Ok(());
        }
        self.is_exhausted = true;
        let ((holder, advice), left) = (self.holder, self.left);
        let what = format!(
            "the {holder} needs {bytes} more bytes of memory, but only {left} are left of the limit for a file of this size"
        );
        Err(IoError::malformed(self.format, Location::File, what).advise(advice))
    }

    /// Raises the limit by a multiple of a size.
    pub(super) fn allow(&mut self, times: usize, size: usize) {
        self.left = size.saturating_mul(times).saturating_add(self.left);
    }

    /// Bytes of memory that may still be taken.
    pub(super) fn left(&self) -> usize {
        self.left
    }

    /// Whether more memory was asked for than may be taken.
    pub(super) fn is_exhausted(&self) -> bool {
        self.is_exhausted
    }
}
