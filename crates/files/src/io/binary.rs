//! Reads binary numbers of any scalar type and byte order, and writes them in the usual one.

use isomend_core::mesh::attributes::Scalar;

/// A number of a scalar type at the start of bytes.
pub(super) trait BinaryNumber {
    /// The number at the start of the bytes, and the bytes after it; `None` if there are too few. Integers beyond 2⁵³
    /// lose digits, but no index is that large.
    fn take<const BIG_ENDIAN: bool>(self, bytes: &[u8]) -> Option<(f64, &[u8])>;
    /// Appends a number of this type, the least significant byte first. Integers are cut to their range.
    fn put(self, number: f64, bytes: &mut Vec<u8>);
}

impl BinaryNumber for Scalar {
    #[inline]
    fn take<const BIG_ENDIAN: bool>(self, bytes: &[u8]) -> Option<(f64, &[u8])> {
        fn front<const BIG_ENDIAN: bool, const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
            let (value, rest) = bytes.split_first_chunk::<N>()?;
            *bytes = rest;
            let mut value = *value;
            if BIG_ENDIAN {
                value.reverse();
            }
            Some(value)
        }
        let mut rest = bytes;
        macro_rules! number {
            ($kind:ty) => {
                <$kind>::from_le_bytes(front::<BIG_ENDIAN, { size_of::<$kind>() }>(&mut rest)?)
            };
        }
        let value = match self {
            Scalar::I8 => f64::from(number!(i8)),
            Scalar::U8 => f64::from(number!(u8)),
            Scalar::I16 => f64::from(number!(i16)),
            Scalar::U16 => f64::from(number!(u16)),
            Scalar::I32 => f64::from(number!(i32)),
            Scalar::U32 => f64::from(number!(u32)),
            Scalar::I64 => number!(i64) as f64,
            Scalar::U64 => number!(u64) as f64,
            Scalar::F32 => f64::from(number!(f32)),
            Scalar::F64 => number!(f64),
        };
        Some((value, rest))
    }

    #[inline]
    fn put(self, number: f64, bytes: &mut Vec<u8>) {
        match self {
            Scalar::I8 => bytes.push(number as i8 as u8),
            Scalar::U8 => bytes.push(number as u8),
            Scalar::I16 => bytes.extend((number as i16).to_le_bytes()),
            Scalar::U16 => bytes.extend((number as u16).to_le_bytes()),
            Scalar::I32 => bytes.extend((number as i32).to_le_bytes()),
            Scalar::U32 => bytes.extend((number as u32).to_le_bytes()),
            Scalar::I64 => bytes.extend((number as i64).to_le_bytes()),
            Scalar::U64 => bytes.extend((number as u64).to_le_bytes()),
            Scalar::F32 => bytes.extend((number as f32).to_le_bytes()),
            Scalar::F64 => bytes.extend(number.to_le_bytes()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_all_types_are_read_in_both_orders_of_bytes_and_written() {
        use Scalar::*;
        let cases: [(Scalar, f64, Vec<u8>); 10] = [
            (I8, -2.0, (-2i8).to_le_bytes().to_vec()),
            (U8, 254.0, 254u8.to_le_bytes().to_vec()),
            (I16, -513.0, (-513i16).to_le_bytes().to_vec()),
            (U16, 65000.0, 65000u16.to_le_bytes().to_vec()),
            (I32, -70000.0, (-70000i32).to_le_bytes().to_vec()),
            (U32, 4e9, 4_000_000_000u32.to_le_bytes().to_vec()),
            (I64, -5e12, (-5_000_000_000_000i64).to_le_bytes().to_vec()),
            (U64, 5e12, 5_000_000_000_000u64.to_le_bytes().to_vec()),
            (F32, 0.15625, 0.15625f32.to_le_bytes().to_vec()),
            (F64, 0.1, 0.1f64.to_le_bytes().to_vec()),
        ];
        for (scalar, value, little) in cases {
            let big: Vec<u8> = little.iter().rev().copied().collect();
            let more = [&little[..], b"more"].concat();
            assert_eq!(scalar.take::<false>(&more), Some((value, &b"more"[..])));
            assert_eq!(scalar.take::<true>(&big), Some((value, &b""[..])));
            assert_eq!(scalar.take::<false>(&little[1..]), None, "{scalar:?}");
            let mut written = b"before".to_vec();
            scalar.put(value, &mut written);
            assert_eq!(written, [&b"before"[..], &little].concat());
        }
    }
}
