//! Pools of threads. WebAssembly has one thread, on which all work runs.

use rayon::ThreadPoolBuildError;
use rayon::prelude::*;

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

/// Collects a parallel iterator whose number of items is known.
pub(crate) trait CollectIndexed: IndexedParallelIterator {
    /// The items in their order. `collect` compiles the loop for an unknown number of items too, which doubles its code.
    fn collect_indexed(self) -> Vec<Self::Item> {
        let mut items = Vec::new();
        self.collect_into_vec(&mut items);
        items
    }
}

impl<I: IndexedParallelIterator> CollectIndexed for I {}

/// Collects a parallel iterator whose number of items is unknown, such as a filtered one.
pub(crate) trait CollectFiltered: ParallelIterator {
    /// The items in their order. `collect` compiles the loop for a known number of items too, which doubles its code.
    fn collect_filtered(self) -> Vec<Self::Item> {
        let lists = self.collect_vec_list();
        let mut items = Vec::with_capacity(lists.iter().map(Vec::len).sum());
        for mut list in lists {
            items.append(&mut list);
        }
        items
    }
}

impl<I: ParallelIterator> CollectFiltered for I {}

/// Runs over the chunks of `values` in parallel: `run(c, chunk)` gets the c-th chunk of `size` values. The parallel loop is compiled once
/// for each type of values.
pub(crate) fn for_each_chunk<T: Send>(
    values: &mut [T],
    size: usize,
    run: &(dyn Fn(usize, &mut [T]) + Sync),
) {
    let chunks = values.par_chunks_mut(size).enumerate();
    chunks.for_each(|(c, chunk)| run(c, chunk));
}
