//! The number types of VTK files.

use super::super::text;
pub(super) use crate::mesh::attributes::Scalar;

impl Scalar {
    /// From the name used in XML files.
    pub(super) fn from_xml(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"Int8" => Scalar::I8,
            b"UInt8" => Scalar::U8,
            b"Int16" => Scalar::I16,
            b"UInt16" => Scalar::U16,
            b"Int32" => Scalar::I32,
            b"UInt32" => Scalar::U32,
            b"Int64" => Scalar::I64,
            b"UInt64" => Scalar::U64,
            b"Float32" => Scalar::F32,
            b"Float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// From the name used in legacy files.
    pub(super) fn from_legacy(name: &[u8]) -> Option<Self> {
        Some(match &name.to_ascii_lowercase()[..] {
            b"char" | b"signed_char" => Scalar::I8,
            b"unsigned_char" => Scalar::U8,
            b"short" => Scalar::I16,
            b"unsigned_short" => Scalar::U16,
            b"int" | b"vtkidtype" => Scalar::I32,
            b"unsigned_int" => Scalar::U32,
            b"long" | b"vtktypeint64" => Scalar::I64,
            b"unsigned_long" | b"vtktypeuint64" => Scalar::U64,
            b"float" => Scalar::F32,
            b"double" => Scalar::F64,
            _ => return None,
        })
    }

    /// Decodes one number of exactly this type's size. Integers beyond 2⁵³ lose digits; no index is that large.
    fn decode(self, bytes: &[u8], big: bool) -> f64 {
        let mut le = [0; 8];
        for (to, from) in le.iter_mut().zip(bytes) {
            *to = *from;
        }
        let size = self.size();
        if big {
            le[..size].reverse();
        }
        let [a, b, c, d, ..] = le;
        match self {
            Scalar::I8 => f64::from(a as i8),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::I64 => i64::from_le_bytes(le) as f64,
            Scalar::U64 => u64::from_le_bytes(le) as f64,
            Scalar::F64 => f64::from_le_bytes(le),
        }
    }

    /// Decodes all whole numbers in the bytes.
    pub(super) fn decode_all(self, bytes: &[u8], big: bool) -> Vec<f64> {
        self.decode_iter(bytes, big).collect()
    }

    /// The whole numbers in the bytes, one after another.
    pub(super) fn decode_iter(self, bytes: &[u8], big: bool) -> impl Iterator<Item = f64> + '_ {
        bytes
            .chunks_exact(self.size())
            .map(move |chunk| self.decode(chunk, big))
    }

    /// Reads a number in text with the precision of the type.
    pub(super) fn parse(self, token: &[u8]) -> Option<f64> {
        match self {
            Scalar::F32 => text::number_f32(token).map(f64::from),
            _ => text::number(token),
        }
    }
}
