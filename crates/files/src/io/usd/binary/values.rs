//! Values of the binary USD format: a representation of 64 bits holds the type and either the value itself or its place in the file.

use std::rc::Rc;

use super::super::super::IoError;
use super::super::super::binary::BinaryNumber;
use super::super::Budget;
use super::super::layer::Value;
use super::fault;
use super::sections::{Cursor, Sections};
use isomend_core::mesh::attributes::Scalar;

/// Bits of a representation.
const IS_ARRAY: u64 = 1 << 63;
const IS_INLINED: u64 = 1 << 62;
const IS_COMPRESSED: u64 = 1 << 61;
/// Arrays of fewer items are not compressed.
const LEAST_COMPRESSED: usize = 16;

/// Types of values that are not numbers.
pub(super) const STRING: u8 = 10;
pub(super) const TOKEN: u8 = 11;
pub(super) const ASSET: u8 = 12;
pub(super) const PATH_LIST: u8 = 34;
pub(super) const REFERENCE_LIST: u8 = 35;
pub(super) const PATHS: u8 = 40;
pub(super) const TOKENS: u8 = 41;
pub(super) const SELECTION: u8 = 45;
pub(super) const SAMPLES: u8 = 46;
pub(super) const PAYLOAD: u8 = 47;
pub(super) const STRINGS: u8 = 50;
pub(super) const PAYLOAD_LIST: u8 = 55;

/// A number type: its scalar (`None` for 16-bit floats) and how many make a value.
#[derive(Clone, Copy)]
struct Numeric {
    scalar: Option<Scalar>,
    components: usize,
    /// Its real part is stored last.
    is_quaternion: bool,
}

impl Numeric {
    /// The number type of a type number.
    fn of(kind: u8) -> Option<Self> {
        let (double, single) = (Some(Scalar::F64), Some(Scalar::F32));
        let (scalar, components) = match kind {
            1 | 2 => (Some(Scalar::U8), 1),
            3 => (Some(Scalar::I32), 1),
            4 => (Some(Scalar::U32), 1),
            5 => (Some(Scalar::I64), 1),
            6 => (Some(Scalar::U64), 1),
            7 => (None, 1),
            8 => (single, 1),
            9 | 56 => (double, 1),
            13 => (double, 4),
            14 => (double, 9),
            15 => (double, 16),
            16..=18 => ([double, single, None][usize::from(kind - 16)], 4),
            // Vectors of 2, 3 and 4 components, each of doubles, floats, halves and integers.
            19..=30 => {
                let scalars = [double, single, None, Some(Scalar::I32)];
                (
                    scalars[usize::from(kind - 19) % 4],
                    2 + usize::from(kind - 19) / 4,
                )
            }
            _ => return None,
        };
        Some(Self {
            scalar,
            components,
            is_quaternion: (16..=18).contains(&kind),
        })
    }

    /// Bytes of a number.
    fn size(self) -> usize {
        self.scalar.map_or(2, Scalar::size)
    }

    /// The numbers in bytes.
    fn numbers(self, bytes: &[u8]) -> Vec<f64> {
        let number = |bytes: &[u8]| match self.scalar {
            Some(scalar) => scalar
                .take::<false>(bytes)
                .map_or(f64::NAN, |(number, _)| number),
            None => half(u16::from_le_bytes([bytes[0], bytes[1]])),
        };
        let mut numbers: Vec<f64> = bytes.chunks_exact(self.size()).map(number).collect();
        if self.is_quaternion {
            numbers
                .chunks_exact_mut(4)
                .for_each(|all| all.rotate_right(1));
        }
        numbers
    }

    /// The numbers of a value that its representation holds: small integers for vectors and diagonals of matrices.
    fn inlined(self, payload: u64) -> Vec<f64> {
        let bytes = payload.to_le_bytes();
        let small = |at: usize| f64::from(bytes[at] as i8);
        match (self.scalar, self.components) {
            (Some(Scalar::F64), 1) => vec![f64::from(f32::from_bits(payload as u32))],
            (Some(Scalar::I64), 1) => vec![f64::from(payload as u32 as i32)],
            (Some(Scalar::U64), 1) => vec![f64::from(payload as u32)],
            (_, 1) => self.numbers(&bytes[..self.size()]),
            (_, 9 | 16) => {
                let side = if self.components == 9 { 3 } else { 4 };
                let at = |k: usize| {
                    if k.is_multiple_of(side + 1) {
                        small(k / (side + 1))
                    } else {
                        0.0
                    }
                };
                (0..self.components).map(at).collect()
            }
            (_, components) => (0..components.min(4)).map(small).collect(),
        }
    }
}

/// A 16-bit float.
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (u64::from(bits >> 10 & 31), f64::from(bits & 1023));
    let size = match exponent {
        0 => fraction / f64::from(1 << 24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        // The exponent of a 64-bit float is larger by the difference of their biases.
        _ => (1.0 + fraction / 1024.0) * f64::from_bits((exponent + 1023 - 15) << 52),
    };
    if bits >> 15 == 1 { -size } else { size }
}

/// Reads values.
pub(super) struct Values<'a, 'b> {
    pub(super) bytes: &'a [u8],
    pub(super) sections: &'a Sections,
    pub(super) budget: &'b mut Budget,
}

/// The type number of a representation.
pub(super) fn kind(value: u64) -> u8 {
    (value >> 48) as u8
}

impl<'a> Values<'a, '_> {
    /// The place in the file that a representation refers to.
    pub(super) fn cursor(&self, value: u64) -> Cursor<'a> {
        let at = usize::try_from(value & ((1 << 48) - 1)).unwrap_or(usize::MAX);
        Cursor {
            bytes: self.bytes,
            at,
        }
    }

    /// A value of any type; of types that are not needed, `Other`.
    pub(super) fn value(&mut self, value: u64) -> Result<Value, IoError> {
        let kind = kind(value);
        if let Some(numeric) = Numeric::of(kind) {
            let numbers = match (value & IS_ARRAY != 0, value & IS_INLINED != 0) {
                (true, _) => self.array(value, numeric)?,
                (false, true) => numeric.inlined(value & ((1 << 48) - 1)),
                (false, false) => {
                    let bytes = self
                        .cursor(value)
                        .take(numeric.size() * numeric.components, self.budget)?;
                    numeric.numbers(bytes)
                }
            };
            return Ok(Value::Numbers(Rc::new(numbers)));
        }
        match kind {
            STRING | TOKEN | ASSET | TOKENS | STRINGS => {
                Ok(Value::Texts(Rc::new(self.texts(value)?)))
            }
            _ => Ok(Value::Other),
        }
    }

    /// The length of an array; the cursor is then at its items.
    fn length(&self, cursor: &mut Cursor<'_>) -> Result<usize, IoError> {
        let version = self.sections.version;
        if version < 5 {
            cursor.short(self.budget)?;
        }
        match version < 7 {
            true => Ok(cursor.short(self.budget)? as usize),
            false => cursor.size(self.budget),
        }
    }

    /// The numbers of an array.
    fn array(&mut self, value: u64, numeric: Numeric) -> Result<Vec<f64>, IoError> {
        let mut cursor = self.cursor(value);
        if cursor.at == 0 {
            return Ok(Vec::new());
        }
        let count = self.length(&mut cursor)?;
        let is_raw =
            value & IS_COMPRESSED == 0 || count < LEAST_COMPRESSED || numeric.components > 1;
        match (is_raw, numeric.scalar) {
            (true, _) => {
                let size = count
                    .saturating_mul(numeric.components)
                    .saturating_mul(numeric.size());
                let bytes = cursor.take(size, self.budget)?;
                self.budget.spend(8 * (bytes.len() / numeric.size()))?;
                Ok(numeric.numbers(bytes))
            }
            (false, Some(scalar)) if !scalar.is_float() => {
                let integers = cursor.wide_integers(count, scalar.size(), self.budget)?;
                // Unsigned numbers are stored by their bits.
                let number = |n: &i64| match scalar {
                    Scalar::U32 => f64::from(*n as u32),
                    Scalar::U64 => *n as u64 as f64,
                    _ => *n as f64,
                };
                Ok(integers.iter().map(number).collect())
            }
            (false, _) => self.compressed_floats(&mut cursor, count, numeric),
        }
    }

    /// Floats that are whole numbers, or that refer to a table of the distinct ones.
    fn compressed_floats(
        &mut self,
        cursor: &mut Cursor<'_>,
        count: usize,
        numeric: Numeric,
    ) -> Result<Vec<f64>, IoError> {
        let at = cursor.at;
        self.budget.spend(count.saturating_mul(8))?;
        match cursor.take(1, self.budget)? {
            b"i" => {
                let integers = cursor.integers(count, self.budget)?;
                Ok(integers.iter().map(|n| *n as f64).collect())
            }
            b"t" => {
                let size = cursor.short(self.budget)? as usize;
                let bytes = cursor.take(size.saturating_mul(numeric.size()), self.budget)?;
                self.budget.spend(8 * size)?;
                let table = numeric.numbers(bytes);
                let places = cursor.integers(count, self.budget)?;
                let value = |place: &i64| table.get(*place as u32 as usize).copied();
                let values: Option<Vec<f64>> = places.iter().map(value).collect();
                values
                    .ok_or_else(|| fault(self.budget, at, "a compressed float is not in its table"))
            }
            _ => Err(fault(
                self.budget,
                at,
                "compressed floats have an unknown form",
            )),
        }
    }

    /// The string of a number.
    pub(super) fn string(&self, number: u32) -> String {
        let word = self.sections.strings.get(number as usize);
        word.map_or_else(String::new, |word| self.sections.word(*word).to_owned())
    }

    /// Strings, tokens or names of files; none for other types.
    pub(super) fn texts(&mut self, value: u64) -> Result<Vec<String>, IoError> {
        let kind = kind(value);
        let is_string = matches!(kind, STRING | STRINGS);
        if !matches!(kind, STRING | TOKEN | ASSET | TOKENS | STRINGS) {
            return Ok(Vec::new());
        }
        let numbers = match value & IS_INLINED != 0 && value & IS_ARRAY == 0 {
            true => vec![value as u32],
            false => {
                let mut cursor = self.cursor(value);
                if cursor.at == 0 {
                    return Ok(Vec::new());
                }
                let count = match value & IS_ARRAY != 0 {
                    true => self.length(&mut cursor)?,
                    false => cursor.size(self.budget)?,
                };
                let bytes = cursor.take(count.saturating_mul(4), self.budget)?;
                bytes
                    .as_chunks()
                    .0
                    .iter()
                    .map(|b| u32::from_le_bytes(*b))
                    .collect()
            }
        };
        let mut texts = Vec::with_capacity(numbers.len());
        for number in numbers {
            let text = match is_string {
                true => self.string(number),
                false => self.sections.word(number).to_owned(),
            };
            self.budget.spend(32 + text.len())?;
            texts.push(text);
        }
        Ok(texts)
    }

    /// The first text of a value.
    pub(super) fn text(&mut self, value: u64) -> Result<Option<String>, IoError> {
        Ok(self.texts(value)?.into_iter().next())
    }

    /// The word of a specifier.
    pub(super) fn specifier(&self, value: u64) -> &'static str {
        match value as u32 {
            0 => "def",
            1 => "over",
            _ => "class",
        }
    }

    /// The first value of values in time: behind an offset their times, behind another one their number and the values.
    pub(super) fn first_sample(&mut self, value: u64) -> Result<Option<Value>, IoError> {
        if kind(value) != SAMPLES {
            return Ok(None);
        }
        let mut cursor = self.cursor(value);
        for _ in 0..2 {
            self.jump(&mut cursor)?;
            let _times_or_count = cursor.word(self.budget)?;
        }
        let first = cursor.word(self.budget)?;
        match kind(first) {
            SAMPLES => Ok(None),
            _ => self.value(first).map(Some),
        }
    }

    /// Goes to the place that an offset from here gives.
    pub(super) fn jump(&mut self, cursor: &mut Cursor<'_>) -> Result<(), IoError> {
        let start = cursor.at;
        let offset = cursor.word(self.budget)? as i64;
        let to = i64::try_from(start)
            .ok()
            .and_then(|start| start.checked_add(offset));
        let to = to.and_then(|to| usize::try_from(to).ok());
        cursor.at =
            to.ok_or_else(|| fault(self.budget, start, "an offset leads out of the file"))?;
        Ok(())
    }
}
