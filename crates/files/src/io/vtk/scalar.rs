//! The number types of VTK files: names and decoding.

use super::super::binary::BinaryNumber;
use super::super::text;
pub(super) use isomend_core::mesh::attributes::Scalar;

/// The names of the types in XML files.
const XML_NAMES: [(Scalar, &str); 10] = [
    (Scalar::I8, "Int8"),
    (Scalar::U8, "UInt8"),
    (Scalar::I16, "Int16"),
    (Scalar::U16, "UInt16"),
    (Scalar::I32, "Int32"),
    (Scalar::U32, "UInt32"),
    (Scalar::I64, "Int64"),
    (Scalar::U64, "UInt64"),
    (Scalar::F32, "Float32"),
    (Scalar::F64, "Float64"),
];

/// What VTK files need of a scalar type.
pub(super) trait VtkScalar: Sized {
    /// The type of a name in XML files.
    fn from_xml(name: &[u8]) -> Option<Self>;
    /// Its name in XML files.
    fn xml_name(self) -> &'static str;
    /// The type of a name in legacy files.
    fn from_legacy(name: &[u8]) -> Option<Self>;
    /// Decodes all complete numbers in the bytes.
    fn decode_all(self, bytes: &[u8], big: bool) -> Vec<f64>;
    /// Iterates over the complete numbers in the bytes.
    fn decode_iter(self, bytes: &[u8], big: bool) -> impl Iterator<Item = f64> + '_;
    /// Parses a number with the precision of the type.
    fn parse(self, token: &[u8]) -> Option<f64>;
}

impl VtkScalar for Scalar {
    fn from_xml(name: &[u8]) -> Option<Self> {
        let mut names = XML_NAMES.iter();
        names
            .find(|(_, own)| own.as_bytes() == name)
            .map(|(scalar, _)| *scalar)
    }

    fn xml_name(self) -> &'static str {
        let mut names = XML_NAMES.iter();
        names
            .find(|(scalar, _)| *scalar == self)
            .map_or("", |(_, name)| name)
    }

    fn from_legacy(name: &[u8]) -> Option<Self> {
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

    fn decode_all(self, bytes: &[u8], big: bool) -> Vec<f64> {
        self.decode_iter(bytes, big).collect()
    }

    fn decode_iter(self, bytes: &[u8], big: bool) -> impl Iterator<Item = f64> + '_ {
        let number = move |chunk| match big {
            true => self.take::<true>(chunk),
            false => self.take::<false>(chunk),
        };
        let chunks = bytes.chunks_exact(self.size());
        chunks.filter_map(move |chunk| Some(number(chunk)?.0))
    }

    fn parse(self, token: &[u8]) -> Option<f64> {
        match self {
            Scalar::F32 => text::number_f32(token).map(f64::from),
            _ => text::number(token),
        }
    }
}
