//! Splits the text of a USD layer into words, strings, names of files and paths.

use super::super::super::{Format, IoError, Location, text};

/// The rest of a text.
pub(super) struct Tokens<'a> {
    bytes: &'a [u8],
    at: usize,
    format: Format,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(bytes: &'a [u8], format: Format) -> Self {
        Self {
            bytes,
            at: 0,
            format,
        }
    }

    pub(super) fn position(&self) -> usize {
        self.at
    }

    pub(super) fn go_to(&mut self, position: usize) {
        self.at = position;
    }

    /// The next byte that is neither blank nor part of a comment.
    pub(super) fn peek(&mut self) -> Option<u8> {
        loop {
            let byte = *self.bytes.get(self.at)?;
            match byte {
                b'#' => {
                    let rest = &self.bytes[self.at..];
                    self.at += memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
                }
                b if b.is_ascii_whitespace() => self.at += 1,
                _ => return Some(byte),
            }
        }
    }

    /// Takes a byte if it is the next one.
    pub(super) fn accept(&mut self, byte: u8) -> bool {
        let is_next = self.peek() == Some(byte);
        self.at += usize::from(is_next);
        is_next
    }

    pub(super) fn expect(&mut self, byte: u8) -> Result<(), IoError> {
        match self.accept(byte) {
            true => Ok(()),
            false => Err(self.unexpected(&format!("'{}'", char::from(byte)))),
        }
    }

    /// A word: a name with namespaces, a keyword or a number; empty if something else follows.
    pub(super) fn word(&mut self) -> &'a [u8] {
        if self.peek().is_none() {
            return b"";
        }
        let rest = &self.bytes[self.at..];
        let is_part = |b: &u8| b.is_ascii_alphanumeric() || *b >= 128 || b"_:.+-!|".contains(b);
        let mut length = rest.iter().take_while(|b| is_part(b)).count();
        // The colon after a time is not part of it.
        let is_number = rest
            .first()
            .is_some_and(|b| b.is_ascii_digit() || b"+-.".contains(b));
        if is_number && let Some(colon) = rest[..length].iter().position(|b| *b == b':') {
            length = colon;
        }
        self.at += length;
        &rest[..length]
    }

    pub(super) fn number(&mut self) -> Result<f64, IoError> {
        let start = self.at;
        text::number(self.word()).ok_or_else(|| {
            self.at = start;
            self.unexpected("a number")
        })
    }

    /// A string in single or double quotes, or three of them.
    pub(super) fn string(&mut self) -> Result<String, IoError> {
        let Some(quote @ (b'"' | b'\'')) = self.peek() else {
            return Err(self.unexpected("a string"));
        };
        let three = [quote; 3];
        let rest = &self.bytes[self.at..];
        let end: &[u8] = if rest.starts_with(&three) {
            &three
        } else {
            &three[..1]
        };
        let mut found = Vec::new();
        let mut at = end.len();
        loop {
            let Some(byte) = rest.get(at) else {
                return Err(self.fault("a string does not end".to_owned()));
            };
            if rest[at..].starts_with(end) {
                break;
            }
            match (byte, rest.get(at + 1)) {
                (b'\\', Some(next)) => {
                    found.push(match next {
                        b'n' => b'\n',
                        b't' => b'\t',
                        b'r' => b'\r',
                        other => *other,
                    });
                    at += 2;
                }
                _ => {
                    found.push(*byte);
                    at += 1;
                }
            }
        }
        self.at += at + end.len();
        Ok(String::from_utf8_lossy(&found).into_owned())
    }

    /// The name of a file between `@` or three of them.
    pub(super) fn asset(&mut self) -> Result<String, IoError> {
        self.peek();
        let rest = &self.bytes[self.at..];
        let end: &[u8] = if rest.starts_with(b"@@@") {
            b"@@@"
        } else {
            b"@"
        };
        self.between(end.len(), end, "the name of a file")
    }

    /// A path between `<` and `>`.
    pub(super) fn path(&mut self) -> Result<String, IoError> {
        self.peek();
        self.between(1, b">", "a path")
    }

    fn between(&mut self, start: usize, end: &[u8], what: &str) -> Result<String, IoError> {
        let rest = self.bytes.get(self.at + start..).unwrap_or_default();
        let Some(length) = text::find(rest, end) else {
            return Err(self.fault(format!("{what} does not end")));
        };
        self.at += start + length + end.len();
        Ok(String::from_utf8_lossy(&rest[..length]).into_owned())
    }

    /// The error for something else than what is wanted.
    pub(super) fn unexpected(&mut self, wanted: &str) -> IoError {
        let what = match self.peek() {
            None => format!("the file ends where {wanted} should be"),
            Some(_) => {
                let rest = &self.bytes[self.at..];
                let end = rest
                    .iter()
                    .position(u8::is_ascii_whitespace)
                    .unwrap_or(rest.len());
                let shown = text::shown(&rest[..end.clamp(1, 40)]);
                format!("{shown} where {wanted} should be")
            }
        };
        self.fault(what)
    }

    pub(super) fn fault(&self, what: String) -> IoError {
        let before = &self.bytes[..self.at.min(self.bytes.len())];
        let line = 1 + memchr::memchr_iter(b'\n', before).count();
        IoError::malformed(self.format, Location::Line(line), what)
    }
}
