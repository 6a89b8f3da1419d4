//! Handling of Ctrl-C, SIGTERM and SIGHUP: the program ends at once, and unfinished files are removed.

use std::sync::OnceLock;

use anyhow::Context;

use super::{console, progress};

/// Lets Ctrl-C and, on Unix, SIGTERM and SIGHUP (a terminal that is closed) end the program at once.
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

    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let seen = Arc::new(AtomicBool::new(false));
    // A program that `nohup` starts ignores SIGHUP, and goes on when the terminal is closed.
    let all = [SIGINT, SIGTERM, SIGHUP];
    let all = &all[..if ignores_hangup() { 2 } else { 3 }];
    for &signal in all {
        signal_hook::flag::register_conditional_shutdown(signal, 128 + signal, seen.clone())?;
        signal_hook::flag::register(signal, seen.clone())?;
    }
    let mut signals = Signals::new(all)?;
    std::thread::Builder::new()
        .name("signals".to_owned())
        .spawn(move || {
            if let Some(signal) = signals.forever().next() {
                stop(128 + signal);
            }
        })?;
    Ok(())
}

/// Whether the program was started with SIGHUP ignored. Only Linux lists the ignored signals of a process.
#[cfg(unix)]
fn ignores_hangup() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal_hook::consts::SIGHUP - 1) & 1 == 1)
}

#[cfg(not(unix))]
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
    // Said before files are abandoned: a thread that saves may hold what is asked for, and would wait for ever.
    let ends = AT_END.get().inspect(|say| say());
    // The guard lives until the end, so that no file is finished or started any more.
    let abandoned = isomend::io::abandon_unfinished();
    if ends.is_some() {
        std::process::exit(0)
    }
    progress::clear();
    let said = match super::written_before(abandoned.written()) {
        none if none.is_empty() => "; unfinished files were not written".to_owned(),
        some => some,
    };
    console::fail(&format!("stopped{said}"));
    std::process::exit(code)
}
