//! The filters of `EXT_meshopt_compression`, which follow the decoding of attributes.
//!
//! Source: the extension's specification, appendix B.

use super::Filter;

/// Applies a filter to elements of `stride` bytes.
pub(super) fn apply(filter: Filter, stride: usize, bytes: &mut [u8]) {
    let elements = bytes.chunks_exact_mut(stride);
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => elements.for_each(octahedral_8),
        (Filter::Octahedral, _) => elements.for_each(octahedral_16),
        (Filter::Quaternion, _) => elements.for_each(quaternion),
        (Filter::Exponential, _) => bytes.chunks_exact_mut(4).for_each(exponential),
    }
}

/// A unit vector from its place on an octahedron: x, y, and the number that stands for 1.
fn octahedral(x: f32, y: f32, one: f32) -> [f32; 3] {
    let (mut x, mut y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    // Below the middle the sides are folded outward.
    let fold = z.min(0.0);
    x += fold.copysign(-x);
    y += fold.copysign(-y);
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

fn octahedral_8(element: &mut [u8]) {
    let part = |at: usize| f32::from(element[at] as i8);
    let vector = octahedral(part(0), part(1), part(2));
    for (byte, value) in element.iter_mut().zip(vector) {
        *byte = (value * 127.0).round() as i8 as u8;
    }
}

fn octahedral_16(element: &mut [u8]) {
    let vector = octahedral(
        f32::from(short(element, 0)),
        f32::from(short(element, 1)),
        f32::from(short(element, 2)),
    );
    for (at, value) in vector.into_iter().enumerate() {
        set_short(element, at, (value * 32767.0).round() as i16);
    }
}

/// A unit quaternion from three of its components; the largest one is computed. The last number of the element says which one that is and,
/// in its other bits, which number stands for 1.
fn quaternion(element: &mut [u8]) {
    let last = short(element, 3);
    let one = f32::from(last | 3);
    let scale = std::f32::consts::FRAC_1_SQRT_2 / one;
    let small = [0, 1, 2].map(|at| f32::from(short(element, at)) * scale);
    let rest: f32 = small.iter().map(|x| x * x).sum();
    let largest = (1.0 - rest).max(0.0).sqrt();
    let at = usize::from((last & 3) as u16);
    let all = [largest, small[0], small[1], small[2]];
    for (step, value) in all.into_iter().enumerate() {
        set_short(element, (at + step) % 4, (value * 32767.0).round() as i16);
    }
}

/// A number from an 8-bit exponent of two and a 24-bit mantissa, both signed.
fn exponential(bytes: &mut [u8]) {
    let Some(bytes) = bytes.first_chunk_mut::<4>() else {
        return;
    };
    let value = i32::from_le_bytes(*bytes);
    let (exponent, mantissa) = (value >> 24, value << 8 >> 8);
    // A power of two from its bits: 1023 is the exponent of 1 in 64-bit floats.
    let power = f64::from_bits(((1023 + exponent) as u64) << 52);
    let number = f64::from(mantissa) * power;
    *bytes = (number as f32).to_le_bytes();
}

fn short(element: &[u8], at: usize) -> i16 {
    i16::from_le_bytes([element[2 * at], element[2 * at + 1]])
}

fn set_short(element: &mut [u8], at: usize, value: i16) {
    element[2 * at..2 * at + 2].copy_from_slice(&value.to_le_bytes());
}
