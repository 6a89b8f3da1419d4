//! What is printed. Standard output carries only what was asked for; all else goes to standard error.

use std::io::{IsTerminal, Write};

use anstyle::{AnsiColor, Style};
use anyhow::Context;
use log::{Level, LevelFilter, Log, Metadata, Record};

/// What is said where standard output fails.
pub const NO_OUTPUT: &str = "cannot write to standard output";
/// Of headings.
const HEADING: Style = Style::new().bold();
/// Of what failed.
const BAD: Style = AnsiColor::Red.on_default().bold();
/// Of what needs attention.
const WARNING: Style = AnsiColor::Yellow.on_default().bold();
/// Of remarks.
const NOTE: Style = AnsiColor::Cyan.on_default();
/// Of what only matters when something is looked for.
const DIM: Style = Style::new().dimmed();

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
        say(&format!("{WARNING}isomend:{WARNING:#} {line}"));
    }

    /// A file that failed, where others go on.
    pub fn failed(self, line: &str) {
        fail(line);
    }

    /// A line that `-q` silences.
    pub fn say(self, line: &str) {
        if !self.quiet {
            say(line);
        }
    }

    /// A remark on a file, which `-q` silences.
    pub fn note(self, line: &str) {
        self.say(&format!("{NOTE}note:{NOTE:#} {line}"));
    }

    /// A line that only `-v` shows.
    pub fn detail(self, line: &str) {
        if self.verbose {
            self.say(line);
        }
    }

    /// Whether all details are asked for.
    pub fn is_verbose(self) -> bool {
        self.verbose
    }

    /// Whether a progress bar may be drawn: on a terminal that can, and not between the lines of a log.
    pub fn wants_progress(self) -> bool {
        let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        !self.quiet && !self.verbose && !dumb && std::io::stderr().is_terminal()
    }
}

/// Says what made the program fail.
pub fn fail(line: &str) {
    say(&format!("{BAD}isomend:{BAD:#} {line}"));
}

/// A heading in bold, where it is printed in colour at all.
pub fn heading(line: &str) -> String {
    format!("{HEADING}{line}{HEADING:#}")
}

/// A line on standard error, in colour where that is a terminal and the environment does not say otherwise: `NO_COLOR`,
/// `CLICOLOR`, `CLICOLOR_FORCE`, `TERM=dumb`.
fn say(line: &str) {
    // A closed standard error is no reason to fail.
    let _ = writeln!(anstream::stderr(), "{line}");
}

/// Writes text to standard output, in colour as on standard error.
pub fn print(text: &str) -> std::io::Result<()> {
    written(anstream::stdout().lock(), text.as_bytes())
}

/// As [`print`], with a message.
pub fn print_out(text: &str) -> anyhow::Result<()> {
    print(text).context(NO_OUTPUT)
}

/// As [`write_file`], with a message.
pub fn write_file_out(bytes: &[u8]) -> anyhow::Result<()> {
    write_file(bytes).context(NO_OUTPUT)
}

/// Writes text to standard output as it is.
pub fn write(text: &[u8]) -> std::io::Result<()> {
    written(std::io::stdout().lock(), text)
}

/// Writes a file to standard output, all of which must arrive.
pub fn write_file(bytes: &[u8]) -> std::io::Result<()> {
    if is_closed() {
        return Err(std::io::Error::other("it is closed; name a file"));
    }
    let mut out = std::io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush())
}

/// Whether the program was started without a standard output. Rust's runtime puts the null device, open for reading too, in
/// the place of a stream that is closed; `> /dev/null` opens it for writing only.
#[cfg(unix)]
fn is_closed() -> bool {
    use rustix::fs::{OFlags, fcntl_getfl, fstat, stat};
    let out = rustix::stdio::stdout();
    let (Ok(flags), Ok(about), Ok(null)) = (fcntl_getfl(out), fstat(out), stat("/dev/null")) else {
        return true;
    };
    about.st_rdev == null.st_rdev && about.st_mode == null.st_mode && flags.contains(OFlags::RDWR)
}

#[cfg(not(unix))]
fn is_closed() -> bool {
    false
}

/// A reader of text that has closed its end, such as `head`, is no error.
fn written(mut out: impl Write, bytes: &[u8]) -> std::io::Result<()> {
    match out.write_all(bytes).and_then(|()| out.flush()) {
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
            let style = match record.level() {
                Level::Error => BAD,
                Level::Warn => WARNING,
                _ => DIM,
            };
            say(&format!("{style}{level}:{style:#} {}", record.args()));
        }
    }

    fn flush(&self) {}
}
