//! Forwards the library's log records to Python's `logging`, from the thread that waits for the work.

use std::sync::{Mutex, PoisonError};

use log::{Level, LevelFilter, Log, Metadata, Record};
use pyo3::prelude::*;

/// Maximum number of records in the queue; later ones are dropped until the queue is emptied.
const MAX_RECORDS: usize = 10_000;

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
        if queue.len() < MAX_RECORDS {
            queue.push((record.level(), record.args().to_string()));
        }
    }

    fn flush(&self) {}
}

/// The number of a level in Python's `logging`.
fn number(level: Level) -> u8 {
    match level {
        Level::Error => 40,
        Level::Warn => 30,
        Level::Info => 20,
        Level::Debug => 10,
        Level::Trace => 5,
    }
}

/// Starts to queue records, from the level of Python's logger `isomend` upwards.
pub fn listen(py: Python<'_>) -> PyResult<()> {
    // Fails if the command line runs in this process and has set its own logger.
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

/// Hands the queued records to Python's logger `isomend`.
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
