//! Pools of threads. WebAssembly has one thread, on which all work runs.

use rayon::ThreadPoolBuildError;

/// A pool of threads for parallel work.
pub(crate) struct Threads {
    #[cfg(not(target_family = "wasm"))]
    pool: rayon::ThreadPool,
}

#[cfg(not(target_family = "wasm"))]
impl Threads {
    /// A pool of `count` threads; 0 for one per core.
    ///
    /// # Errors
    /// When the system cannot start them.
    pub fn new(count: usize) -> Result<Self, ThreadPoolBuildError> {
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
