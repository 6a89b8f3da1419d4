//! Scalar types of attribute values: size, range, rounding.

use serde::{Deserialize, Serialize};

/// The scalar type of an attribute's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Scalar {
    /// 8-bit integer.
    I8,
    /// 8-bit natural number.
    U8,
    /// 16-bit integer.
    I16,
    /// 16-bit natural number.
    U16,
    /// 32-bit integer.
    I32,
    /// 32-bit natural number.
    U32,
    /// 64-bit integer.
    I64,
    /// 64-bit natural number.
    U64,
    /// 32-bit float.
    F32,
    /// 64-bit float.
    F64,
}

impl Scalar {
    /// Size in bytes.
    pub fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => 8,
        }
    }

    /// Whether it is a floating-point type.
    pub fn is_float(self) -> bool {
        matches!(self, Scalar::F32 | Scalar::F64)
    }

    /// The smallest and the largest number of an integer type; infinite for floats.
    pub fn range(self) -> [f64; 2] {
        match self {
            Scalar::I8 => [-128.0, 127.0],
            Scalar::U8 => [0.0, 255.0],
            Scalar::I16 => [-32768.0, 32767.0],
            Scalar::U16 => [0.0, 65535.0],
            Scalar::I32 => [f64::from(i32::MIN), f64::from(i32::MAX)],
            Scalar::U32 => [0.0, f64::from(u32::MAX)],
            Scalar::I64 => [i64::MIN as f64, i64::MAX as f64],
            Scalar::U64 => [0.0, u64::MAX as f64],
            Scalar::F32 | Scalar::F64 => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// The nearest number that the type can represent.
    pub fn nearest(self, value: f64) -> f64 {
        match self {
            Scalar::F64 => value,
            Scalar::F32 => f64::from(value as f32),
            _ => {
                let [low, high] = self.range();
                value.round().clamp(low, high)
            }
        }
    }
}
