//! Printing: results go to standard output, everything else (messages, warnings, notes, log) to standard error.

use std::io::{IsTerminal, Write};

use anstyle::{AnsiColor, Style};
use anyhow::Context;
use isomend::report::Standing;
use log::{Level, LevelFilter, Log, Metadata, Record};

/// Message if standard output fails.
pub const NO_OUTPUT: &str = "cannot write to standard output";
/// Style of headings.
const HEADING: Style = Style::new().bold();
/// Style of errors.
const BAD: Style = AnsiColor::Red.on_default().bold();
/// Style of warnings.
const WARNING: Style = AnsiColor::Yellow.on_default().bold();
/// Style of verdicts that are a yes.
const GOOD: Style = AnsiColor::Green.on_default().bold();
/// Style of notes.
const NOTE: Style = AnsiColor::Cyan.on_default();
/// Style of log levels below a warning.
const DIM: Style = Style::new().dimmed();

/// Standard error, with the verbosity of `-q` and `-v`.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    quiet: bool,
    verbose: bool,
}

impl Console {
    /// A console; if it is verbose, it also prints the library's log.
    pub fn new(quiet: bool, verbose: bool) -> Self {
        if verbose && log::set_logger(&STDERR_LOG).is_ok() {
            log::set_max_level(LevelFilter::Debug);
        }
        Self { quiet, verbose }
    }

    /// Prints a warning; `-q` does not silence it.
    pub fn warn(self, line: &str) {
        say(&format!("{WARNING}isomend:{WARNING:#} {line}"));
    }

    /// Prints the error of one of several files.
    pub fn failed(self, line: &str) {
        fail(line);
    }

    /// Prints a line that `-q` silences.
    pub fn say(self, line: &str) {
        if !self.quiet {
            say(line);
        }
    }

    /// Prints a note, which `-q` silences.
    pub fn note(self, line: &str) {
        self.say(&noted(line));
    }

    /// Prints a line only with `-v`.
    pub fn detail(self, line: &str) {
        if self.verbose {
            self.say(line);
        }
    }

    /// Whether `-v` is set.
    pub fn is_verbose(self) -> bool {
        self.verbose
    }

    /// Whether to draw a progress bar: on a terminal that can draw it, with a thread for it, and not with `-v`, whose lines it would
    /// disturb.
    pub fn wants_progress(self) -> bool {
        let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        let has_threads = !cfg!(target_family = "wasm");
        has_threads && !self.quiet && !self.verbose && !dumb && std::io::stderr().is_terminal()
    }
}

/// Prints the error that ends the program.
pub fn fail(line: &str) {
    say(&format!("{BAD}isomend:{BAD:#} {line}"));
}

/// A heading in bold; the style is removed if output is not coloured.
pub fn heading(line: &str) -> String {
    format!("{HEADING}{line}{HEADING:#}")
}

/// A line that begins with `note:`.
pub fn noted(line: &str) -> String {
    format!("{NOTE}note:{NOTE:#} {line}")
}

/// A verdict in the colour of its answer: green, yellow or red; the style is removed if output is not coloured.
pub fn verdict(answer: Standing, text: &str) -> String {
    let style = match answer {
        Standing::Yes => GOOD,
        Standing::InPart => WARNING,
        Standing::No => BAD,
    };
    format!("{style}{text}{style:#}")
}

/// Prints a line to standard error, in colour on a terminal unless `NO_COLOR`, `CLICOLOR`, `CLICOLOR_FORCE` or `TERM=dumb` say otherwise.
/// Lines wider than the terminal are wrapped.
fn say(line: &str) {
    // A closed standard error must not make the program fail.
    let _ = writeln!(anstream::stderr(), "{}", fitted(line, error_width()));
}

/// Writes text to standard output, coloured and wrapped by the same rules as standard error.
pub fn print(text: &str) -> std::io::Result<()> {
    let text = fitted(text, width());
    written(anstream::stdout().lock(), text.as_bytes())
}

/// Wraps each line of a text at a width; further lines are indented by two blanks more than the line.
fn fitted(text: &str, width: Option<usize>) -> String {
    let fitted = |line: &str| {
        let indent = line.len() - line.trim_start_matches(' ').len();
        wrapped(line, width, indent + 2)
    };
    text.split('\n').map(fitted).collect::<Vec<_>>().join("\n")
}

/// As [`print`], with a message in the error.
pub fn print_out(text: &str) -> anyhow::Result<()> {
    print(text).context(NO_OUTPUT)
}

/// As [`write_file`], with a message in the error.
pub fn write_file_out(bytes: &[u8]) -> anyhow::Result<()> {
    write_file(bytes).context(NO_OUTPUT)
}

/// Least width for which tables are laid out, in characters.
const NARROWEST: usize = 60;

/// The width of the terminal that standard output is, in characters; none if it is another file. `COLUMNS` sets it for any.
pub fn width() -> Option<usize> {
    columns().or_else(|| terminal_width(&std::io::stdout()))
}

/// As [`width`], of standard error.
pub fn error_width() -> Option<usize> {
    columns().or_else(|| terminal_width(&std::io::stderr()))
}

fn columns() -> Option<usize> {
    let columns = std::env::var("COLUMNS").ok()?.trim().parse::<usize>();
    columns.ok().filter(|n| *n > 0).map(|n| n.max(NARROWEST))
}

#[cfg(unix)]
fn terminal_width(stream: &impl rustix::fd::AsFd) -> Option<usize> {
    let size = rustix::termios::tcgetwinsize(stream).ok()?;
    let columns = usize::from(size.ws_col);
    (columns > 0).then(|| columns.max(NARROWEST))
}

#[cfg(not(unix))]
fn terminal_width<S>(_: &S) -> Option<usize> {
    None
}

/// Wraps a line at `width` characters, of which styles have none: further lines begin with `indent` blanks. Only blanks become breaks,
/// so a longer word exceeds the width.
pub fn wrapped(line: &str, width: Option<usize>, indent: usize) -> String {
    let Some(width) = width.filter(|width| characters(line) > *width) else {
        return line.to_owned();
    };
    let (mut out, mut column) = (String::new(), 0);
    for (number, word) in line.split(' ').enumerate() {
        let length = characters(word);
        if number > 0 && column + 1 + length > width && column > indent {
            out.truncate(out.trim_end_matches(' ').len());
            out += "\n";
            out += &" ".repeat(indent);
            column = indent;
        } else if number > 0 {
            out.push(' ');
            column += 1;
        }
        out += word;
        column += length;
    }
    out
}

/// The number of characters of a text without its styles, which are escape sequences that end with `m`.
pub fn characters(text: &str) -> usize {
    let mut parts = text.split('\u{1b}');
    let first = parts.next().map_or(0, |part| part.chars().count());
    let styled = parts.map(|part| {
        part.split_once('m')
            .map_or(0, |(_, rest)| rest.chars().count())
    });
    first + styled.sum::<usize>()
}

/// Writes text to standard output without changing colours.
pub fn write(text: &[u8]) -> std::io::Result<()> {
    written(std::io::stdout().lock(), text)
}

/// Writes a file to standard output. In contrast to text, a reader that closes the stream early is an error, of which only the exit code
/// tells.
pub fn write_file(bytes: &[u8]) -> std::io::Result<()> {
    if is_closed() {
        return Err(std::io::Error::other("it is closed; name a file"));
    }
    let mut out = std::io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush())
}

/// Whether the program was started with standard output closed. Rust's runtime replaces a closed stream by the null device, open for
/// reading and writing, whereas `> /dev/null` opens it for writing only.
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

/// Writes text. A reader that closes the stream early, such as `head`, is not an error.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_wrapped_at_the_width_without_their_styles() {
        let line = format!("{NOTE}note:{NOTE:#} five words and more");
        assert_eq!(characters(&line), 25);
        assert_eq!(wrapped(&line, Some(26), 2), line);
        let narrow = wrapped(&line, Some(12), 2);
        let lines: Vec<&str> = narrow.lines().collect();
        assert!(lines[0].ends_with(" five"), "{narrow:?}");
        assert_eq!(lines[1..], ["  words and", "  more"]);
        assert_eq!(
            fitted("  a b c d\ne\n", Some(6)),
            "  a b\n    c\n    d\ne\n"
        );
        assert_eq!(fitted("any line", None), "any line");
    }
}
