//! Mutations of seeds: of bytes, of binary numbers, and of numbers and words in text.

use std::ops::Range;

use fastrand::Rng;

/// Inputs do not become longer.
const MOST_BYTES: usize = 16 << 10;

/// Numbers in text that have made trouble somewhere.
const NUMBERS: [&str; 22] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "3",
    "127",
    "256",
    "65536",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "18446744073709551616",
    "-9223372036854775808",
    "1e-320",
    "1e31",
    "-1e150",
    "1e308",
    "1e999",
    "nan",
    "inf",
];

/// The same as 32-bit numbers.
const WORDS: [u32; 11] = [
    0,
    1,
    2,
    255,
    65536,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7fc0_0000,
    0x7f7f_ffff,
    0x0000_0001_u32.swap_bytes(),
];

/// A seed with one to eight mutations, few more often than many.
pub fn mutate(seeds: &[Vec<u8>], rng: &mut Rng) -> Vec<u8> {
    let mut data = seeds[rng.usize(..seeds.len())].clone();
    let other = &seeds[rng.usize(..seeds.len())];
    let most = rng.usize(1..=8);
    for _ in 0..rng.usize(1..=most) {
        mutate_once(&mut data, other, rng);
    }
    data.truncate(MOST_BYTES);
    data
}

fn mutate_once(data: &mut Vec<u8>, other: &[u8], rng: &mut Rng) {
    if data.is_empty() {
        data.extend_from_slice(other);
        return;
    }
    let at = rng.usize(..data.len());
    match rng.u8(..12) {
        0 => data[at] ^= 1 << rng.u8(..8),
        1 => {
            data[at] =
                [0, 1, 0x7f, 0x80, 0xff, b' ', b'\n', b'-', b'9', rng.u8(..)][rng.usize(..10)]
        }
        2 => {
            data.drain(part(data, rng));
        }
        3 => {
            let copy = data[part(data, rng)].to_vec();
            insert(data, at, &copy);
        }
        4 => insert(data, at, &other[part(other, rng)]),
        5 => {
            let from = &other[part(other, rng)];
            let end = data.len().min(at + from.len());
            data[at..end].copy_from_slice(&from[..end - at]);
        }
        6 => data.truncate(at),
        7 => {
            let bytes: Vec<u8> = (0..rng.usize(1..9)).map(|_| rng.u8(..)).collect();
            insert(data, at, &bytes);
        }
        8 => {
            let word = WORDS[rng.usize(..WORDS.len())];
            let bytes = if rng.bool() {
                word.to_le_bytes()
            } else {
                word.to_be_bytes()
            };
            let end = data.len().min(at + 4);
            data[at..end].copy_from_slice(&bytes[..end - at]);
        }
        9 | 10 => {
            let number = NUMBERS[rng.usize(..NUMBERS.len())];
            let is_part = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
            replace(data, at, is_part, number.as_bytes());
        }
        _ => {
            let from = if other.is_empty() {
                0
            } else {
                rng.usize(..other.len())
            };
            let is_part = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_';
            let word = other[run(other, from, is_part)].to_vec();
            replace(data, at, is_part, &word);
        }
    }
}

/// A part of the bytes, short ones more often than long ones.
fn part(data: &[u8], rng: &mut Rng) -> Range<usize> {
    let start = rng.usize(..=data.len());
    let most = (data.len() - start).min(1 << rng.u8(..12));
    start..start + rng.usize(..=most)
}

fn insert(data: &mut Vec<u8>, at: usize, bytes: &[u8]) {
    data.splice(at..at, bytes.iter().copied());
}

/// The first run of such bytes at or behind a place; empty, at the end, where there is none.
fn run(data: &[u8], at: usize, is_part: impl Fn(&u8) -> bool) -> Range<usize> {
    let behind = |from: usize, wanted: bool| {
        let rest = data[from..].iter().position(|b| is_part(b) == wanted);
        rest.map_or(data.len(), |n| from + n)
    };
    let start = behind(at, true);
    start..behind(start, false)
}

fn replace(data: &mut Vec<u8>, at: usize, is_part: impl Fn(&u8) -> bool, with: &[u8]) {
    let old = run(data, at, is_part);
    data.splice(old, with.iter().copied());
}
