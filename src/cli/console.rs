//! What is printed. Standard output carries only what was asked for; all else goes to standard error.

use std::io::Write;

use log::{LevelFilter, Log, Metadata, Record};

/// Standard error, as loud as asked for.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    quiet: bool,
    verbose: bool,
}

impl Console {
    /// A console, with the library's log when it is verbose.
    pub fn new(quiet: bool, verbose: bool) -> Self {
        if verbose && log::set_logger(&STDERR_LOG).is_ok() {
            log::set_max_level(LevelFilter::Debug);
        }
        Self { quiet, verbose }
    }

    /// A line that `-q` does not silence.
    pub fn warn(self, line: &str) {
        // A closed standard error is no reason to fail.
        let _ = writeln!(std::io::stderr(), "isomend: {line}");
    }

    /// A line that `-q` silences.
    pub fn say(self, line: &str) {
        if !self.quiet {
            let _ = writeln!(std::io::stderr(), "{line}");
        }
    }

    /// A remark on a file, which `-q` silences.
    pub fn note(self, line: &str) {
        self.say(&format!("note: {line}"));
    }

    /// A line that only `-v` shows.
    pub fn detail(self, line: &str) {
        if self.verbose {
            self.say(line);
        }
    }

    /// Whether a progress bar may be drawn: not between the lines of a log.
    pub fn wants_progress(self) -> bool {
        !self.quiet && !self.verbose
    }
}

/// Writes to standard output. A reader that has closed its end, such as `head`, is no error.
pub fn print(text: &str) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

struct StderrLog;

static STDERR_LOG: StderrLog = StderrLog;

impl Log for StderrLog {
    fn enabled(&self, metadata: &Metadata) -> bool {
        metadata.target().starts_with("isomend")
    }

    fn log(&self, record: &Record) {
        if self.enabled(record.metadata()) {
            let level = record.level().as_str().to_ascii_lowercase();
            let _ = writeln!(std::io::stderr(), "{level}: {}", record.args());
        }
    }

    fn flush(&self) {}
}
