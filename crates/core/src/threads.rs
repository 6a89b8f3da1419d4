//! Pools of threads. WebAssembly has one thread, on which all work runs.

use rayon::ThreadPoolBuildError;

/// A pool of threads for parallel work.
pub struct Threads {
    #[cfg(not(target_family = "wasm"))]
    pool: rayon::ThreadPool,
}

/// Number of threads from which on further ones take time and do nothing: the number of cores, or [`FEW`] if it is smaller. A run of 0.3
/// CPU seconds took 46 with 1024 threads on two cores.
#[cfg(not(target_family = "wasm"))]
fn most_useful() -> usize {
    std::thread::available_parallelism().map_or(FEW, |cores| cores.get().max(FEW))
}

/// Number of threads that are started on request on any machine.
#[cfg(not(target_family = "wasm"))]
const FEW: usize = 16;

#[cfg(not(target_family = "wasm"))]
impl Threads {
    /// A pool of `count` threads, but not of more than are of use; 0 for one per core.
    ///
    /// # Errors
    /// When the system cannot start them.
    pub fn new(count: usize) -> Result<Self, ThreadPoolBuildError> {
        let count = count.min(most_useful());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build()?;
        Ok(Self { pool })
    }

    /// Runs a closure, with its parallel loops, on the pool.
    pub fn install<R: Send>(&self, run: impl FnOnce() -> R + Send) -> R {
        self.pool.install(run)
    }
}

#[cfg(target_family = "wasm")]
impl Threads {
    /// The calling thread, whatever `count` is.
    ///
    /// # Errors
    /// None.
    pub fn new(_: usize) -> Result<Self, ThreadPoolBuildError> {
        Ok(Self {})
    }

    /// Runs a closure.
    pub fn install<R: Send>(&self, run: impl FnOnce() -> R + Send) -> R {
        run()
    }
}
