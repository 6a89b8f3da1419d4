//! Decodes the numbers of a data array in a VTK XML file: text, base64 or raw bytes, with or without compression.

use std::cell::Cell;
use std::io::{Read, Write};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::bufread::ZlibDecoder;
use lzma_rust2::XzReader;

use super::super::text;
use super::scalar::{Scalar, VtkScalar};

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

/// The encoding of all binary arrays of a file, as its root element states it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encoding {
    /// Whether the byte order is big endian.
    pub(super) big: bool,
    /// The type of the sizes before an array: `U32` or `U64`.
    pub(super) sizes: Scalar,
    pub(super) compressor: Option<Compressor>,
}

/// Where the numbers of an array are.
pub(super) enum Source<'a> {
    /// Decimal text.
    Text(&'a [u8]),
    /// Base64 of sizes and data.
    Base64(&'a [u8]),
    /// Sizes and data; other bytes may follow.
    Raw(&'a [u8]),
}

/// The number of values that an array must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Expected {
    /// Exactly this number.
    Exactly(usize),
    /// This number or one more.
    OrOneMore(usize),
    /// At least this number; further values are ignored.
    First(usize),
}

impl Expected {
    /// The number of values to take from `there`; an error if `there` does not fit.
    fn of(self, there: usize) -> Result<usize, String> {
        let declared = match self {
            Expected::Exactly(n) if there == n => return Ok(n),
            Expected::OrOneMore(n) if there == n || there.checked_sub(1) == Some(n) => {
                return Ok(there);
            }
            Expected::First(n) if there >= n => return Ok(n),
            Expected::Exactly(n) | Expected::OrOneMore(n) | Expected::First(n) => n,
        };
        Err(format!(
            "{declared} numbers are declared, but there are {there}"
        ))
    }
}

/// Memory that the decoded arrays of a file may still take, so that a small file cannot claim any amount.
pub(super) struct Budget {
    left: Cell<usize>,
    all: usize,
}

impl Budget {
    /// A budget of `least` bytes plus `times` the size of the file.
    pub(super) fn new(file: &[u8], [least, times]: [usize; 2]) -> Self {
        let all = file.len().saturating_mul(times).saturating_add(least);
        Self {
            left: Cell::new(all),
            all,
        }
    }

    /// Charges bytes before they are allocated.
    pub(super) fn take(&self, bytes: usize) -> Result<(), String> {
        match self.left.get().checked_sub(bytes) {
            Some(left) => {
                self.left.set(left);
                Ok(())
            }
            None => Err(format!(
                "{bytes} more bytes are needed to unpack it, but the limit for a file of this size is {} and {} are left; \
                if the file is correct, write it without compression",
                self.all,
                self.left.get()
            )),
        }
    }
}

/// Decodes the numbers of an array. The error says what is wrong but not where.
pub(super) fn decode(
    source: &Source<'_>,
    scalar: Scalar,
    encoding: &Encoding,
    expected: Expected,
    budget: &Budget,
) -> Result<Vec<f64>, String> {
    match source {
        Source::Text(text) => decode_text(text, scalar, expected, budget),
        Source::Base64(text) => {
            budget.take(text.len())?;
            let bytes = decode_base64(text).ok_or("its base64 text is damaged")?;
            unpack(&bytes, scalar, encoding, expected, budget)
        }
        Source::Raw(bytes) => unpack(bytes, scalar, encoding, expected, budget),
    }
}

fn decode_text(
    text: &[u8],
    scalar: Scalar,
    expected: Expected,
    budget: &Budget,
) -> Result<Vec<f64>, String> {
    let count = expected.of(text::Tokens::new(text, 0).count())?;
    budget.take(count.saturating_mul(8))?;
    let number = |token: &[u8]| {
        scalar
            .parse(token)
            .ok_or_else(|| format!("{} is not a number", text::shown(token)))
    };
    text::Tokens::new(text, 0).take(count).map(number).collect()
}

/// Decodes base64. The text may be several encodings in sequence, each with its own padding, because VTK encodes the
/// sizes and the data of a compressed array separately.
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

/// The list of sizes before the data of an array.
struct Sizes<'a> {
    bytes: &'a [u8],
    width: usize,
    big: bool,
}

impl Sizes<'_> {
    fn get(&self, index: usize) -> Result<usize, String> {
        let width = self.width;
        let at = index.checked_mul(width).ok_or(BAD_SIZES)?;
        let word = self
            .bytes
            .get(at..)
            .and_then(|rest| rest.get(..width))
            .ok_or("it ends inside its sizes")?;
        let mut le = [0; 8];
        le[..width].copy_from_slice(word);
        if self.big {
            le[..width].reverse();
        }
        usize::try_from(u64::from_le_bytes(le)).map_err(|_| BAD_SIZES.to_owned())
    }
}

const BAD_SIZES: &str = "its sizes are damaged";

/// Reads the sizes, compares them with the expected count, and decompresses the blocks.
fn unpack(
    bytes: &[u8],
    scalar: Scalar,
    encoding: &Encoding,
    expected: Expected,
    budget: &Budget,
) -> Result<Vec<f64>, String> {
    let sizes = Sizes {
        bytes,
        width: encoding.sizes.size(),
        big: encoding.big,
    };
    // Uncompressed: one size, then the data.
    let Some(compressor) = encoding.compressor else {
        let length = sizes.get(0)?;
        let data = &bytes[sizes.width..];
        let short = || format!("it claims {length} bytes, but {} are left", data.len());
        let data = data.get(..length).ok_or_else(short)?;
        let count = expected.of(length / scalar.size())?;
        budget.take(count.saturating_mul(8))?;
        return Ok(scalar.decode_all(&data[..count * scalar.size()], encoding.big));
    };
    // Compressed: number of blocks, size of a full block, size of a partial last block (0 if full), compressed size of
    // each block.
    let blocks = sizes.get(0)?;
    if blocks == 0 {
        return expected.of(0).map(|_| Vec::new());
    }
    let (full, partial) = (sizes.get(1)?, sizes.get(2)?);
    // If the last compressed size exists, the list of sizes is no longer than the data.
    sizes.get(blocks.checked_add(2).ok_or(BAD_SIZES)?)?;
    let last = if partial == 0 { full } else { partial };
    let total = full.checked_mul(blocks - 1).ok_or(BAD_SIZES)?;
    let total = total.checked_add(last).ok_or(BAD_SIZES)?;
    let count = expected.of(total / scalar.size())?;
    if full == 0 && (blocks > 1 || count > 0) {
        return Err(BAD_SIZES.to_owned());
    }
    let mut numbers = Numbers::new(count, scalar, encoding.big, budget)?;
    let mut inflater = Inflater::new(compressor);
    let mut at = (3 + blocks) * sizes.width;
    for block in 0..blocks {
        if numbers.missing() == 0 {
            break;
        }
        let packed = sizes.get(3 + block)?;
        let data = bytes
            .get(at..)
            .and_then(|rest| rest.get(..packed))
            .ok_or("its compressed data is cut short")?;
        let length = if block + 1 == blocks { last } else { full };
        inflater.inflate(data, length, &mut numbers, budget)?;
        at += packed;
    }
    if numbers.missing() > 0 {
        return Err(DAMAGED.to_owned());
    }
    Ok(numbers.values)
}

const DAMAGED: &str = "its compressed data is damaged";

/// Converts decompressed bytes to numbers in a stream, so that the bytes are never held as a whole.
struct Numbers {
    values: Vec<f64>,
    wanted: usize,
    scalar: Scalar,
    big: bool,
    /// The first bytes of a number that is not complete yet.
    incomplete: Vec<u8>,
}

impl Numbers {
    fn new(wanted: usize, scalar: Scalar, big: bool, budget: &Budget) -> Result<Self, String> {
        budget.take(wanted.saturating_mul(8))?;
        Ok(Self {
            values: Vec::with_capacity(wanted),
            wanted,
            scalar,
            big,
            incomplete: Vec::new(),
        })
    }

    /// The number of bytes still needed.
    fn missing(&self) -> usize {
        (self.wanted - self.values.len()) * self.scalar.size() - self.incomplete.len()
    }

    fn push(&mut self, mut bytes: &[u8]) {
        bytes = &bytes[..bytes.len().min(self.missing())];
        let size = self.scalar.size();
        if !self.incomplete.is_empty() {
            let (end, rest) = bytes.split_at(bytes.len().min(size - self.incomplete.len()));
            self.incomplete.extend_from_slice(end);
            bytes = rest;
            if self.incomplete.len() == size {
                let incomplete = std::mem::take(&mut self.incomplete);
                self.values
                    .extend(self.scalar.decode_iter(&incomplete, self.big));
            }
        }
        let (whole, incomplete) = bytes.split_at(bytes.len() / size * size);
        self.values.extend(self.scalar.decode_iter(whole, self.big));
        self.incomplete.extend_from_slice(incomplete);
    }
}

impl Write for Numbers {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.push(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Decompresses blocks; the state of the zlib decoder is reused.
struct Inflater<'a> {
    compressor: Compressor,
    zlib: ZlibDecoder<&'a [u8]>,
}

impl<'a> Inflater<'a> {
    fn new(compressor: Compressor) -> Self {
        Self {
            compressor,
            zlib: ZlibDecoder::new(&[]),
        }
    }

    /// Decompresses a block of `length` bytes and appends it, or the part of it that is still needed.
    fn inflate(
        &mut self,
        data: &'a [u8],
        length: usize,
        numbers: &mut Numbers,
        budget: &Budget,
    ) -> Result<(), String> {
        // Kilobytes. Memory limit of the xz decoder; its strongest preset needs 65 MB.
        const XZ_MEMORY: u32 = 80 << 10;
        let wanted = length.min(numbers.missing()) as u64;
        let decompressed = match self.compressor {
            Compressor::Zlib => {
                self.zlib.reset(data);
                std::io::copy(&mut (&mut self.zlib).take(wanted), numbers).ok()
            }
            Compressor::Lzma => {
                let decoder = XzReader::new_mem_limit(data, false, XZ_MEMORY);
                std::io::copy(&mut decoder.take(wanted), numbers).ok()
            }
            // LZ4 expands by a factor of at most 255.
            Compressor::Lz4 if length / 255 > data.len() => None,
            Compressor::Lz4 => {
                budget.take(length)?;
                let block = lz4_flex::block::decompress(data, length).ok();
                block.filter(|b| b.len() == length).map(|block| {
                    numbers.push(&block);
                    wanted
                })
            }
        };
        if decompressed == Some(wanted) {
            Ok(())
        } else {
            Err(DAMAGED.to_owned())
        }
    }
}
