//! Ctrl-C and the request to terminate: the program ends wherever it is, and what it has half written goes.

use std::sync::OnceLock;

use anyhow::Context;

use super::{console, progress};

/// From now on Ctrl-C and, where there are such signals, SIGTERM end the program at once.
///
/// Files that are only half saved are removed; the exit code is 128 and the signal's number. A second signal ends the
/// program even if the first one is stuck in its cleaning up.
pub fn listen() -> anyhow::Result<()> {
    wait_for_signals().context("cannot listen for Ctrl-C")
}

#[cfg(unix)]
fn wait_for_signals() -> std::io::Result<()> {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let seen = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register_conditional_shutdown(signal, 128 + signal, seen.clone())?;
        signal_hook::flag::register(signal, seen.clone())?;
    }
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    std::thread::Builder::new()
        .name("signals".to_owned())
        .spawn(move || {
            if let Some(signal) = signals.forever().next() {
                stop(128 + signal);
            }
        })?;
    Ok(())
}

#[cfg(not(unix))]
fn wait_for_signals() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| stop(130))
}

/// What a command says that is ended in no other way.
static LAST_WORDS: OnceLock<Box<dyn Fn() + Send + Sync>> = OnceLock::new();

/// From now on a signal is the usual end: `say` is called, and the exit code is 0.
pub fn is_the_end(say: impl Fn() + Send + Sync + 'static) {
    // A program has one command.
    let _ = LAST_WORDS.set(Box::new(say));
}

fn stop(code: i32) -> ! {
    // Kept until the end, so that nothing is finished or begun any more.
    let _abandoned = isomend::io::abandon_unfinished();
    if let Some(say) = LAST_WORDS.get() {
        say();
        std::process::exit(0)
    }
    progress::clear();
    console::fail("stopped; what was not finished was not written");
    std::process::exit(code)
}
