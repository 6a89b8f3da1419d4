//! The numbers of a data array in a VTK XML file: text, base64 or raw bytes, compressed or not.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::super::text;
use super::scalar::Scalar;

/// How the blocks of binary arrays are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compressor {
    Zlib,
    Lz4,
    Lzma,
}

impl Compressor {
    pub(super) fn parse(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"vtkZLibDataCompressor" => Compressor::Zlib,
            b"vtkLZ4DataCompressor" => Compressor::Lz4,
            b"vtkLZMADataCompressor" => Compressor::Lzma,
            _ => return None,
        })
    }
}

/// What the head of the file says about all its binary arrays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encoding {
    /// Whether the most significant byte comes first.
    pub(super) big: bool,
    /// The type of the sizes in front of an array: `U32` or `U64`.
    pub(super) sizes: Scalar,
    pub(super) compressor: Option<Compressor>,
}

/// Where the numbers of an array are.
pub(super) enum Source<'a> {
    /// Decimal text.
    Text(Cow<'a, [u8]>),
    /// Base64 of sizes and data.
    Base64(Cow<'a, [u8]>),
    /// Sizes and data, with anything behind them.
    Raw(&'a [u8]),
}

/// Decodes all numbers of an array. The error says what is wrong, not where.
pub(super) fn decode(
    source: &Source<'_>,
    scalar: Scalar,
    encoding: &Encoding,
) -> Result<Vec<f64>, String> {
    let bytes = match source {
        Source::Text(text) => return decode_text(text, scalar),
        Source::Base64(text) => {
            let bytes = decode_base64(text).ok_or("its base64 text is damaged")?;
            unpack(&bytes, encoding)?.into_owned()
        }
        Source::Raw(bytes) => unpack(bytes, encoding)?.into_owned(),
    };
    Ok(scalar.decode_all(&bytes, encoding.big))
}

fn decode_text(text: &[u8], scalar: Scalar) -> Result<Vec<f64>, String> {
    let number = |token: &[u8]| {
        scalar
            .parse(token)
            .ok_or_else(|| format!("{} is not a number", text::shown(token)))
    };
    text::Tokens::new(text, 0).map(number).collect()
}

/// Decodes base64 that may be several encodings one after another, each with its own padding: VTK encodes the sizes and
/// the data of a compressed array apart.
fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    let compact: Vec<u8> = text
        .iter()
        .copied()
        .filter(|b| !b.is_ascii_whitespace())
        .collect();
    let mut bytes = Vec::with_capacity(compact.len() / 4 * 3);
    let mut rest = &compact[..];
    while !rest.is_empty() {
        let body = memchr::memchr(b'=', rest).unwrap_or(rest.len());
        let padding = rest[body..].iter().take_while(|b| **b == b'=').count();
        STANDARD
            .decode_vec(&rest[..body + padding], &mut bytes)
            .ok()?;
        rest = &rest[body + padding..];
    }
    Some(bytes)
}

/// Takes the sizes off the front and decompresses.
fn unpack<'a>(bytes: &'a [u8], encoding: &Encoding) -> Result<Cow<'a, [u8]>, String> {
    let width = encoding.sizes.size();
    let size = |index: usize| -> Result<usize, String> {
        let at = index.checked_mul(width).ok_or("its sizes are damaged")?;
        let word = bytes
            .get(at..)
            .and_then(|rest| rest.get(..width))
            .ok_or("it ends inside its sizes")?;
        let mut le = [0; 8];
        le[..width].copy_from_slice(word);
        if encoding.big {
            le[..width].reverse();
        }
        usize::try_from(u64::from_le_bytes(le)).map_err(|_| "its sizes are damaged".to_string())
    };
    let Some(compressor) = encoding.compressor else {
        let length = size(0)?;
        let data = &bytes[width..];
        let short = || format!("it claims {length} bytes, but {} are left", data.len());
        return data.get(..length).map(Cow::Borrowed).ok_or_else(short);
    };
    let blocks = size(0)?;
    if blocks == 0 {
        return Ok(Cow::Borrowed(&[]));
    }
    let (full, partial) = (size(1)?, size(2)?);
    // The last compressed size being there means that the list of sizes is no longer than the data.
    size(blocks.checked_add(2).ok_or("its sizes are damaged")?)?;
    let mut at = (3 + blocks) * width;
    let mut out = Vec::new();
    for block in 0..blocks {
        let packed = size(3 + block)?;
        let data = bytes
            .get(at..)
            .and_then(|rest| rest.get(..packed))
            .ok_or("its compressed data is cut short")?;
        let length = if block + 1 == blocks && partial != 0 {
            partial
        } else {
            full
        };
        inflate(compressor, data, length, &mut out)?;
        at += packed;
    }
    Ok(Cow::Owned(out))
}

/// Appends `length` decompressed bytes.
fn inflate(
    compressor: Compressor,
    data: &[u8],
    length: usize,
    out: &mut Vec<u8>,
) -> Result<(), String> {
    let before = out.len();
    let limit = length as u64;
    let done = match compressor {
        Compressor::Zlib => flate2::read::ZlibDecoder::new(data)
            .take(limit)
            .read_to_end(out)
            .is_ok(),
        Compressor::Lzma => xz2::read::XzDecoder::new(data)
            .take(limit)
            .read_to_end(out)
            .is_ok(),
        // No LZ4 byte stands for more than 255 bytes.
        Compressor::Lz4 if length / 255 > data.len() => false,
        Compressor::Lz4 => match lz4_flex::block::decompress(data, length) {
            Ok(block) => {
                out.extend_from_slice(&block);
                true
            }
            Err(_) => false,
        },
    };
    if done && out.len() - before == length {
        Ok(())
    } else {
        Err("its compressed data is damaged".to_string())
    }
}
