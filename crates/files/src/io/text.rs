//! Helpers for text files: decoding, numbers, tokens, names without duplicates.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

/// Decodes UTF-16 and removes a byte order mark. Other text is returned unchanged.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, [u8]> {
    let big = match bytes {
        [0xff, 0xfe, ..] => Some(false),
        [0xfe, 0xff, ..] => Some(true),
        [a, 0, b, 0, ..] if *a != 0 && *b != 0 => Some(false),
        [0, a, 0, b, ..] if *a != 0 && *b != 0 => Some(true),
        _ => None,
    };
    match big {
        Some(big) => {
            let unit = |pair: &[u8]| {
                let pair = [pair[0], pair[1]];
                if big {
                    u16::from_be_bytes(pair)
                } else {
                    u16::from_le_bytes(pair)
                }
            };
            let text: String = char::decode_utf16(bytes.chunks_exact(2).map(unit))
                .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
                .collect();
            Cow::Owned(text.trim_start_matches('\u{feff}').as_bytes().to_vec())
        }
        None => Cow::Borrowed(strip_bom(bytes)),
    }
}

/// Removes a UTF-8 byte order mark.
pub(super) fn strip_bom(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Removes leading white space.
pub(super) fn skip_blank(bytes: &[u8]) -> &[u8] {
    bytes.trim_ascii_start()
}

/// The offset of the first occurrence of `needle`.
pub(super) fn find(haystack: &[u8], needle: &[u8]) -> Option<usize> {
    memchr::memmem::find(haystack, needle)
}

/// The line of a byte offset, counted from 1. Lines end with LF, CR LF or CR.
pub(super) fn line_at(bytes: &[u8], offset: usize) -> usize {
    let before = &bytes[..offset.min(bytes.len())];
    let ends = memchr::memchr2_iter(b'\n', b'\r', before);
    1 + ends.filter(|at| !bytes[*at..].starts_with(b"\r\n")).count()
}

/// A token as text for a message: non-printable characters are escaped and the length is limited.
pub(super) fn shown(token: &[u8]) -> String {
    // Bytes.
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(&token[..token.len().min(LONGEST)]);
    let dots = if token.len() > LONGEST { "…" } else { "" };
    format!("'{}{dots}'", text.escape_debug())
}

/// A decimal number; `None` if the token is not one. Infinity and NaN are accepted.
pub(super) fn number(token: &[u8]) -> Option<f64> {
    std::str::from_utf8(token).ok()?.parse().ok()
}

/// A decimal number in single precision.
pub(super) fn number_f32(token: &[u8]) -> Option<f32> {
    std::str::from_utf8(token).ok()?.parse().ok()
}

/// A decimal integer; `None` if the token is not one or does not fit.
pub(super) fn integer(token: &[u8]) -> Option<i64> {
    let (negative, digits) = match token {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, token),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0i64;
    for digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value
            .checked_mul(10)?
            .checked_add(i64::from(digit - b'0'))?;
    }
    Some(if negative { -value } else { value })
}

/// A set of names without duplicates.
#[derive(Default)]
pub(super) struct Distinct {
    taken: HashSet<String>,
    /// How often each name was requested.
    asked: HashMap<String, usize>,
}

impl Distinct {
    /// Reserves a name; returns whether it was free.
    pub(super) fn take(&mut self, name: &str) -> bool {
        self.taken.insert(name.to_owned())
    }

    /// Returns the name, or if it is taken the name with up to 8 underscores, or else with a number.
    pub(super) fn name(&mut self, name: String) -> String {
        // With more requests than this for a name, a number is appended, so that names stay short.
        const UNDERSCORES: usize = 8;
        let asked = self.asked.entry(name.clone()).or_default();
        loop {
            let candidate = match *asked {
                n if n <= UNDERSCORES => name.clone() + &"_".repeat(n),
                n => format!("{name}_{n}"),
            };
            *asked += 1;
            if self.taken.insert(candidate.clone()) {
                return candidate;
            }
        }
    }
}

/// Iterates over the white-space separated tokens of a byte slice.
#[derive(Clone)]
pub(super) struct Tokens<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self {
            bytes,
            at: at.min(bytes.len()),
        }
    }

    /// The offset after the last token returned.
    pub(super) fn offset(&self) -> usize {
        self.at
    }

    /// The line of the last token returned, counted from 1.
    pub(super) fn line(&self) -> usize {
        line_at(self.bytes, self.at)
    }

    /// The number of bytes left.
    pub(super) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Returns the rest of the line without its end, and moves to the next line. Lines end with LF, CR LF or CR.
    pub(super) fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
        let end = match rest[length..].starts_with(b"\r\n") {
            true => 2,
            false => 1,
        };
        self.at += (length + end).min(rest.len());
        rest[..length].trim_ascii()
    }
}

impl<'a> Iterator for Tokens<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let length = rest[start..]
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len() - start);
        self.at += start + length;
        Some(&rest[start..start + length])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_utf16_orders_are_decoded_with_and_without_a_mark() {
        let text = "v 0 é";
        let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        let marked = |mark: [u8; 2], body: &[u8]| [&mark[..], body].concat();
        for bytes in [
            &little,
            &big,
            &marked([0xff, 0xfe], &little),
            &marked([0xfe, 0xff], &big),
        ] {
            assert_eq!(&*decode(bytes), text.as_bytes());
        }
        assert_eq!(&*decode(b"\xef\xbb\xbfv 1"), b"v 1");
    }

    #[test]
    fn names_are_distinct_however_many_there_are() {
        let mut names = Distinct::default();
        assert!(names.take("x") && !names.take("x"));
        let first = ["x", "a", "a", "a_", "a"].map(|n| names.name(n.to_owned()));
        assert_eq!(first, ["x_", "a", "a_", "a__", "a___"]);
        let many: HashSet<String> = (0..50_000).map(|_| names.name("a".to_owned())).collect();
        assert_eq!(many.len(), 50_000);
        assert!(many.iter().all(|n| n.len() < 12));
    }

    #[test]
    fn integers_are_checked() {
        assert_eq!(integer(b"-12"), Some(-12));
        assert_eq!(integer(b"+7"), Some(7));
        for bad in [&b""[..], b"-", b"1.0", b"99999999999999999999", b"x"] {
            assert_eq!(integer(bad), None);
        }
    }

    #[test]
    fn tokens_know_their_line() {
        let mut tokens = Tokens::new(b"a b\n\n c rest of it\nd", 0);
        assert_eq!(tokens.nth(2), Some(&b"c"[..]));
        assert_eq!(tokens.line(), 3);
        assert_eq!(tokens.rest_of_line(), b"rest of it");
        assert_eq!(tokens.next(), Some(&b"d"[..]));
        assert_eq!(tokens.next(), None);
    }

    #[test]
    fn lines_end_in_three_ways() {
        for end in ["\n", "\r", "\r\n"] {
            let text = ["a b", "", "c d", "e"].join(end);
            let mut tokens = Tokens::new(text.as_bytes(), 1);
            assert_eq!(tokens.rest_of_line(), b"b");
            assert_eq!(tokens.rest_of_line(), b"");
            assert_eq!(tokens.next(), Some(&b"c"[..]));
            assert_eq!(tokens.line(), 3, "{end:?}");
            assert_eq!(tokens.rest_of_line(), b"d");
            assert_eq!(tokens.rest_of_line(), b"e");
            assert_eq!(tokens.left(), 0);
        }
    }
}
