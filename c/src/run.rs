//! Runs: threads, progress, and cancellation of the work of a call.

use std::ffi::c_void;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use isomend_core::cancel::Cancel;
use isomend_core::mend::{Control, FillError, Step};
use isomend_core::threads::Threads;
use isomend_files::job::JobError;

use crate::pointers::optional;
use crate::status::{Failure, Status};

/// Time between two looks of the calling thread at the work. It bounds how often the progress function is called, and how late a
/// cancellation is seen.
const PAUSE: Duration = Duration::from_millis(5);
/// Time that the work has to end by itself after a cancellation, before the call returns without it. Together with
/// [`PAUSE`] this is far less than the 50 ms in which a cancelled call returns, since a busy system adds its own delays: with four
/// threads for each core the sum of 40 ms became 78.
const GRACE: Duration = Duration::from_millis(10);

/// What stops calls, from any thread.
pub struct CancelHandle(Cancel);

/// The caller's function for the progress of a call: the part done from 0 to 1, regions done, all regions, the caller's pointer. Another
/// answer than 0 stops the call.
pub type ProgressFunction =
    Option<unsafe extern "C" fn(part: f64, done: usize, all: usize, user: *mut c_void) -> i32>;

/// How a call runs.
#[repr(C)]
pub struct RunOptions {
    /// Number of threads; 0 for one per core. The result does not depend on it.
    threads: u32,
    /// The function for the progress, which the calling thread calls; may be null.
    progress: ProgressFunction,
    /// Passed to `progress`.
    user: *mut c_void,
    /// What stops the call; may be null.
    cancel: *const CancelHandle,
}

/// A new token. Calls that are given it in their options stop once it is set.
#[unsafe(no_mangle)]
pub extern "C" fn isomend_cancel_new() -> *mut CancelHandle {
    Box::into_raw(Box::new(CancelHandle(Cancel::new())))
}

/// Sets a token, from any thread: the calls that were given it return within 50 ms. A token cannot be reset.
///
/// # Safety
/// The pointer is null, or a token that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_cancel_set(cancel: *const CancelHandle) {
    // SAFETY: as the caller promises.
    if let Some(cancel) = unsafe { cancel.as_ref() } {
        cancel.0.cancel();
    }
}

/// Frees a token. A null pointer is left alone.
///
/// # Safety
/// The pointer is null, or a token that has not been freed and that no call uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_cancel_free(cancel: *mut CancelHandle) {
    if !cancel.is_null() {
        // SAFETY: `isomend_cancel_new` made it from a box.
        drop(unsafe { Box::from_raw(cancel) });
    }
}

/// Progress of the work: the part done, from 0 to 1, regions done, all regions.
type Progress = Arc<Mutex<Option<(f64, usize, usize)>>>;

/// Does work in a thread of its own, while the calling thread reports progress and looks for a cancellation. The work owns its data: a
/// call that was stopped need not wait for the thread, which ends by itself when it next checks its token; a check or an inspection does
/// so between its stages only.
///
/// # Safety
/// The pointer is null, or points to options whose token has not been freed.
pub unsafe fn run<T: Send + 'static>(
    options: *const RunOptions,
    work: impl FnOnce(&Control) -> Result<T, JobError> + Send + 'static,
) -> Result<T, Failure> {
    // SAFETY: as the caller promises.
    let options = unsafe { optional(options, "options") }?;
    let stop = match options {
        // SAFETY: as the caller promises.
        Some(options) => unsafe { optional(options.cancel, "options.cancel") }?,
        None => None,
    };
    let threads = options.map_or(0, |o| o.threads as usize);
    Control::new()
        .threads(threads)
        .check()
        .map_err(JobError::from)?;
    let is_stopped = || stop.is_some_and(|stop| stop.0.is_cancelled());
    let cancelled = || Failure::from(JobError::Fill(FillError::Cancelled));
    // Short work could end before the token is looked at.
    if is_stopped() {
        return Err(cancelled());
    }
    let own = Cancel::new();
    let state = Progress::default();
    let receive = begin(threads, state.clone(), own.clone(), work)?;
    let mut before = None;
    loop {
        match receive.recv_timeout(PAUSE) {
            Ok(done) => return Ok(done?),
            Err(RecvTimeoutError::Disconnected) => return Err(Failure::internal()),
            Err(RecvTimeoutError::Timeout) => {}
        }
        // A worker that holds the lock may be preempted; the call does not wait for it.
        let now = state.try_lock().map_or(before, |state| *state);
        let mut stops = is_stopped();
        if let (Some(options), Some((part, done, all)), false) = (options, now, stops)
            && let Some(progress) = options.progress
            && now != before
        {
            before = now;
            // SAFETY: the caller gave the function for this call, and the pointer for it.
            stops = unsafe { progress(part, done, all, options.user) } != 0;
        }
        if stops {
            own.cancel();
            let _ = receive.recv_timeout(GRACE);
            return Err(cancelled());
        }
    }
}

/// Starts work in a thread with a pool of its own. The result is sent to the receiver.
fn begin<T: Send + 'static>(
    threads: usize,
    state: Progress,
    cancel: Cancel,
    work: impl FnOnce(&Control) -> Result<T, JobError> + Send + 'static,
) -> Result<Receiver<Result<T, JobError>>, Failure> {
    let no_threads = |_| {
        let what = "the threads could not be started; use fewer threads";
        Failure::new(Status::Parameter, what)
    };
    let (send, receive) = channel();
    let pool = Threads::new(threads).map_err(|_| no_threads(()))?;
    let all = move || {
        let report = |step: &Step| {
            let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
            *state = Some((step.part, step.done, step.all));
        };
        let control = Control::new().cancel(&cancel).progress(&report);
        // Sending fails if the call was stopped: the receiver is gone.
        let _ = send.send(pool.install(|| work(&control)));
    };
    let thread = std::thread::Builder::new().name("isomend".to_owned());
    thread.spawn(all).map_err(|_| no_threads(()))?;
    Ok(receive)
}
