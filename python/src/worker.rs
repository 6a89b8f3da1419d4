//! Runs work in a separate thread, while the calling thread handles signals, progress and log records.

use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use isomend::job::PANICKED;
use isomend::{Cancel, Control, Step};
use isomend_core::threads::Threads;
use pyo3::prelude::*;

use crate::errors::Failure;
use crate::logging;

/// Time between two looks of the calling thread at the work: a progress function is called at most 20 times a second.
const PAUSE: Duration = Duration::from_millis(50);

/// Progress of the work: the part done, from 0 to 1, regions done, all regions.
type State = Option<(f64, usize, usize)>;

/// Runs work in a separate thread with its own pool of `threads` threads (one per core if none), and waits for it without holding
/// Python's global interpreter lock.
///
/// A signal, or an exception in the progress function, stops the work and is raised at once; the thread ends by itself when it next
/// checks for cancellation. The work owns its data, so the caller need not wait for the thread to end.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let asked = Control::new().threads(threads.unwrap_or(0));
    asked.check().map_err(Failure::from)?;
    logging::listen(py)?;
    let cancel = Cancel::new();
    let state = Arc::new(Mutex::new(State::None));
    let reported = progress.is_some().then(|| state.clone());
    let receive = begin(threads, reported, cancel.clone(), work)?;
    let receive = Mutex::new(receive);
    let mut before = State::None;
    loop {
        let done = py.detach(|| {
            let receive = receive.lock().unwrap_or_else(PoisonError::into_inner);
            receive.recv_timeout(PAUSE)
        });
        let mut looked = || -> PyResult<bool> {
            logging::pass_on(py)?;
            py.check_signals()?;
            let now = *locked(&state);
            match (progress, now) {
                (Some(progress), Some((part, finished, all))) if now != before => {
                    before = now;
                    let answer = progress.call1((part, finished, all))?;
                    Ok(answer.is_none() || !is_false(&answer))
                }
                _ => Ok(true),
            }
        };
        match (looked(), done) {
            (Err(error), _) => {
                cancel.cancel();
                return Err(error);
            }
            (_, Ok(done)) => return Ok(done?),
            (Ok(true), Err(RecvTimeoutError::Timeout)) => {}
            (Ok(false), Err(RecvTimeoutError::Timeout)) => {
                cancel.cancel();
                return Err(Failure::new("Cancelled", "stopped by the progress function").into());
            }
            (_, Err(RecvTimeoutError::Disconnected)) => {
                return Err(Failure::new("IsomendError", PANICKED).into());
            }
        }
    }
}

/// Starts work in a thread. The thread writes its progress to `reported` if there is one, and sends the result to the receiver.
fn begin<T: Send + 'static>(
    threads: Option<usize>,
    reported: Option<Arc<Mutex<State>>>,
    cancel: Cancel,
    work: impl FnOnce(&Control) -> Result<T, Failure> + Send + 'static,
) -> std::io::Result<Receiver<Result<T, Failure>>> {
    let (send, receive) = channel();
    let all = move || {
        let report = |step: &Step| {
            if let Some(reported) = &reported {
                *locked(reported) = Some((step.part, step.done, step.all));
            }
        };
        let mut control = Control::new().cancel(&cancel);
        if reported.is_some() {
            control = control.progress(&report);
        }
        // A new pool for each call: the threads of a shared pool would be missing in a forked process.
        let done = match Threads::new(threads.unwrap_or(0)) {
            Ok(pool) => pool.install(|| work(&control)),
            Err(_) => Err(Failure::parameter(
                "the threads could not be started; use fewer threads",
            )),
        };
        // Sending fails if a signal has ended the call: the receiver is gone.
        let _ = send.send(done);
    };
    std::thread::Builder::new()
        .name("isomend".to_owned())
        .spawn(all)?;
    Ok(receive)
}

/// Whether a progress function returned `False` itself, not `None` or 0.
fn is_false(answer: &Bound<'_, PyAny>) -> bool {
    answer.extract::<bool>().is_ok_and(|go_on| !go_on)
}

fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
