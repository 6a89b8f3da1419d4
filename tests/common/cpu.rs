//! CPU time, which other programs on the machine do not lengthen.

use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the calling thread under `/proc`.
pub fn this_thread() -> PathBuf {
    Path::new("/proc").join(fs::read_link("/proc/thread-self").unwrap())
}

/// CPU time of a thread, in seconds.
pub fn cpu(thread: &Path) -> f64 {
    let statistics = fs::read_to_string(thread.join("schedstat")).unwrap();
    let nanoseconds: f64 = statistics
        .split_whitespace()
        .next()
        .unwrap()
        .parse()
        .unwrap();
    1e-9 * nanoseconds
}
