//! Work in a thread of its own, while the caller's looks after signals, progress and log.

use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use isomend::{Cancel, Control, Step};
use pyo3::prelude::*;

use crate::errors::Failure;
use crate::logging;

/// How often the caller's thread looks after the work: a progress function is called 20 times a second at most.
const PAUSE: Duration = Duration::from_millis(50);

/// How far the work is: its part from 0 to 1, regions done and all regions.
type State = Option<(f64, usize, usize)>;

/// Does work in a thread of its own, on so many threads, and waits for it without holding Python's lock.
///
/// A signal, or an exception in the progress function, stops the work and is raised at once: the thread ends by itself as soon as it
/// finds that it was stopped. What the work needs is its own, so that nothing has to wait for it.
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
    let told = progress.is_some().then(|| state.clone());
    let receive = begin(threads, told, cancel.clone(), work)?;
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
                let what =
                    "the work ended in a panic, which is a fault of isomend: please report it";
                return Err(Failure::new("IsomendError", what).into());
            }
        }
    }
}

/// Begins work in a thread that tells how far it is, if that is asked for; what it makes is received in the end.
fn begin<T: Send + 'static>(
    threads: Option<usize>,
    told: Option<Arc<Mutex<State>>>,
    cancel: Cancel,
    work: impl FnOnce(&Control) -> Result<T, Failure> + Send + 'static,
) -> std::io::Result<Receiver<Result<T, Failure>>> {
    let (send, receive) = channel();
    let all = move || {
        let tell = |step: &Step| {
            if let Some(told) = &told {
                *locked(told) = Some((step.part, step.done, step.all));
            }
        };
        let mut control = Control::new().cancel(&cancel);
        if told.is_some() {
            control = control.progress(&tell);
        }
        // Threads of its own: those of a common pool would be missing in a process that was forked.
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.unwrap_or(0))
            .build();
        let done = match pool {
            Ok(pool) => pool.install(|| work(&control)),
            Err(_) => Err(Failure::parameter(
                "the threads could not be started; take fewer",
            )),
        };
        // No receiver is left where a signal ended the call.
        let _ = send.send(done);
    };
    std::thread::Builder::new()
        .name("isomend".to_owned())
        .spawn(all)?;
    Ok(receive)
}

/// Whether a progress function returned `False` itself, not merely nothing or zero.
fn is_false(answer: &Bound<'_, PyAny>) -> bool {
    answer.extract::<bool>().is_ok_and(|go_on| !go_on)
}

fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
