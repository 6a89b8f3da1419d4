//! Parses attribute values of a 3MF model: integers, names, colours, transforms, ranges of faces.

use glam::{DAffine3, DMat3, DVec3};
use quick_xml::events::BytesStart;

use super::super::text;

/// Bytes. Longest name that is accepted; longer names would make comparisons slow.
const MOST_NAME: usize = 4096;

pub(super) fn check_name(name: &str) -> Result<(), String> {
    match name.len() > MOST_NAME {
        true => Err(format!("a name is longer than {MOST_NAME} bytes")),
        false => Ok(()),
    }
}

/// The faces in a list such as `3-5,9`, as ascending disjoint ranges. `None` if it has more ranges than the object has
/// faces, or a face that the object does not have.
pub(super) fn patch_ranges(text: &str, faces: usize) -> Option<Vec<[usize; 2]>> {
    let mut ranges: Vec<[usize; 2]> = Vec::new();
    for range in text.split(',').filter(|range| !range.trim().is_empty()) {
        let (from, to) = range.split_once('-').unwrap_or((range, range));
        let [from, to] = [from, to].map(|word| word.trim().parse::<usize>().ok());
        let (from, to) = (from?, to?);
        if from > to || to >= faces || ranges.len() >= faces {
            return None;
        }
        ranges.push([from, to]);
    }
    ranges.sort_unstable();
    ranges.dedup_by(|next, last| {
        let overlaps = next[0] <= last[1];
        if overlaps {
            last[1] = last[1].max(next[1]);
        }
        overlaps
    });
    Some(ranges)
}

pub(super) fn whole(value: &str) -> Option<u32> {
    value.trim().parse().ok()
}

/// The value of an attribute that is a whole number.
pub(super) fn number(tag: &BytesStart<'_>, name: &str) -> Option<u32> {
    let found = tag.try_get_attribute(name).ok().flatten()?;
    whole(&found.value)
}

pub(super) fn unescaped(value: &str) -> String {
    match quick_xml::escape::unescape(value) {
        Ok(text) => text.into_owned(),
        Err(_) => value.to_owned(),
    }
}

/// A colour of the form `#RRGGBB` or `#RRGGBBAA`.
pub(super) fn colour_of(text: &str) -> Option<[u8; 4]> {
    let digits = text.trim().strip_prefix('#')?;
    let is_hex = digits.bytes().all(|b| b.is_ascii_hexdigit());
    let number = u32::from_str_radix(digits, 16).ok().filter(|_| is_hex)?;
    match digits.len() {
        6 => Some(((number << 8) | 255).to_be_bytes()),
        8 => Some(number.to_be_bytes()),
        _ => None,
    }
}

/// A transform of 12 numbers, row by row, for row vectors multiplied from the left; the last row is the translation.
pub(super) fn transform(words: &str) -> Option<DAffine3> {
    let numbers: Option<Vec<f64>> = (text::Tokens::new(words.as_bytes(), 0))
        .map(|word| text::number(word).filter(|x| x.is_finite()))
        .collect();
    let n: [f64; 12] = numbers?.try_into().ok()?;
    let row = |i: usize| DVec3::new(n[3 * i], n[3 * i + 1], n[3 * i + 2]);
    Some(DAffine3::from_mat3_translation(
        DMat3::from_cols(row(0), row(1), row(2)),
        row(3),
    ))
}
