//! The scalar types of vectors, `f32` and `f64`.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Mul, Sub};

/// `f32` or `f64`.
pub trait Real:
    Copy
    + Send
    + Sync
    + Default
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Sum
    + 'static
{
    /// Zero.
    const ZERO: Self;
    /// Converts from single precision, exactly.
    fn of(value: f32) -> Self;
}

impl Real for f32 {
    const ZERO: Self = 0.0;

    #[inline]
    fn of(value: f32) -> Self {
        value
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;

    #[inline]
    fn of(value: f32) -> Self {
        value.into()
    }
}
