//! Handling of Ctrl-C and SIGTERM: the program ends at once, and unfinished files are removed.

use std::sync::OnceLock;

use anyhow::Context;

use super::{console, progress};

/// Lets Ctrl-C and, on Unix, SIGTERM end the program at once.
///
/// Unfinished files are removed; the exit code is 128 plus the number of the signal. A second signal ends the program even if the
/// clean-up of the first one hangs.
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

#[cfg(target_family = "wasm")]
fn wait_for_signals() -> std::io::Result<()> {
    Ok(())
}

#[cfg(not(any(unix, target_family = "wasm")))]
fn wait_for_signals() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| stop(130))
}

/// Called when a signal ends a command for which that is the normal end, such as `view`.
static AT_END: OnceLock<Box<dyn Fn() + Send + Sync>> = OnceLock::new();

/// Makes a signal the normal end of the program: `say` is called, and the exit code is 0.
pub fn is_normal_end(say: impl Fn() + Send + Sync + 'static) {
    // Set only once, since a program runs one command.
    let _ = AT_END.set(Box::new(say));
}

/// Ends the program after a signal.
fn stop(code: i32) -> ! {
    // The guard lives until the end, so that no file is finished or started any more.
    let _abandoned = isomend::io::abandon_unfinished();
    if let Some(say) = AT_END.get() {
        say();
        std::process::exit(0)
    }
    progress::clear();
    console::fail("stopped; unfinished files were not written");
    std::process::exit(code)
}
