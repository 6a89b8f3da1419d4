//! The library's log, passed on to Python's `logging` by the thread that waits for the work.

use std::sync::{Mutex, PoisonError};

use log::{Level, LevelFilter, Log, Metadata, Record};
use pyo3::prelude::*;

/// Most records that are kept until they are passed on; later ones are left out.
const MOST: usize = 10_000;

struct Queue(Mutex<Vec<(Level, String)>>);

static QUEUE: Queue = Queue(Mutex::new(Vec::new()));

impl Log for Queue {
    fn enabled(&self, metadata: &Metadata) -> bool {
        metadata.target().starts_with("isomend")
    }

    fn log(&self, record: &Record) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let mut queue = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if queue.len() < MOST {
            queue.push((record.level(), record.args().to_string()));
        }
    }

    fn flush(&self) {}
}

/// Python's number of a level.
fn number(level: Level) -> u8 {
    match level {
        Level::Error => 40,
        Level::Warn => 30,
        Level::Info => 20,
        Level::Debug => 10,
        Level::Trace => 5,
    }
}

/// Keeps what Python's logger named `isomend` wants to hear.
pub fn listen(py: Python<'_>) -> PyResult<()> {
    // Another logger is there already where the command line is run in this process.
    let _ = log::set_logger(&QUEUE);
    let logger = py
        .import("logging")?
        .call_method1("getLogger", ("isomend",))?;
    let level: u32 = logger.call_method0("getEffectiveLevel")?.extract()?;
    log::set_max_level(match level {
        0..=5 => LevelFilter::Trace,
        6..=10 => LevelFilter::Debug,
        11..=20 => LevelFilter::Info,
        21..=30 => LevelFilter::Warn,
        _ => LevelFilter::Error,
    });
    Ok(())
}

/// Passes on what was kept.
pub fn pass_on(py: Python<'_>) -> PyResult<()> {
    let records = {
        let mut queue = QUEUE.0.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut *queue)
    };
    if records.is_empty() {
        return Ok(());
    }
    let logger = py
        .import("logging")?
        .call_method1("getLogger", ("isomend",))?;
    for (level, message) in records {
        logger.call_method1("log", (number(level), "%s", message))?;
    }
    Ok(())
}
