//! Formatting of numbers, lengths and points with bounded width for any unit of the mesh.

use glam::DVec3;

/// Powers of ten of numbers that are printed with decimals; all others are in scientific notation. The bounds keep numbers within nine
/// characters.
const ORDINARY: std::ops::Range<i32> = -4..7;
/// Significant digits of numbers.
const DIGITS: i32 = 4;
/// Significant digits of a coordinate of the size of the mesh.
const POINT_DIGITS: i32 = 5;
/// Values below this fraction of their reference size are rounding errors.
const NOTHING: f64 = 1e-9;

/// The power of ten of the first digit of a number that is rounded to `digits` significant digits.
fn magnitude(x: f64, digits: i32) -> i32 {
    let text = format!("{x:.*e}", (digits - 1).max(0) as usize);
    let power = text
        .rsplit_once('e')
        .and_then(|(_, power)| power.parse().ok());
    power.unwrap_or(0)
}

/// Formats a number with `digits` significant digits, but all those before the decimal point, and without zeros at the end of its decimals.
/// Very large and small numbers are in scientific notation.
#[doc(hidden)]
pub fn significant(x: f64, digits: i32) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let magnitude = magnitude(x, digits);
    if !ORDINARY.contains(&magnitude) || !x.is_finite() {
        return format!("{x:.*e}", (digits - 1).max(0) as usize);
    }
    without_zeros(format!("{x:.*}", (digits - 1 - magnitude).max(0) as usize))
}

/// A number without zeros at the end of its decimals.
fn without_zeros(text: String) -> String {
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// Formats a number with four significant digits, as [`significant`].
#[doc(hidden)]
pub fn number(x: f64) -> String {
    significant(x, DIGITS)
}

/// Formats a length with four significant digits, as [`significant`].
#[doc(hidden)]
pub fn length(x: f64) -> String {
    number(x)
}

/// Formats a length that is the smallest of its kind: rounded up, so that the number itself is possible.
pub fn at_least(x: f64) -> String {
    // Half a unit of the last digit.
    length(x * (1.0 + 0.5 * 10f64.powi(1 - DIGITS)))
}

/// Formats a length relative to a reference size: 0 if it is only rounding error.
#[doc(hidden)]
pub fn length_beside(x: f64, size: f64) -> String {
    length(beside(x, size))
}

/// A length relative to a reference size: 0 if it is only rounding error.
pub fn beside(x: f64, size: f64) -> f64 {
    match x.abs() <= NOTHING * size.abs() {
        true => 0.0,
        false => x,
    }
}

/// Formats a point with commas between its coordinates: with as many decimals as five significant digits of the larger of the reference size
/// and the largest coordinate have, without zeros at their end, or in scientific notation if that is very large or small.
#[doc(hidden)]
pub fn point(p: DVec3, size: f64) -> String {
    let scale = size.abs().max(p.abs().max_element());
    let magnitude = magnitude(scale, POINT_DIGITS);
    let decimals = (POINT_DIGITS - 1 - magnitude).max(0) as usize;
    let one = |x: f64| {
        if x.abs() <= NOTHING * scale {
            "0".to_owned()
        } else if ORDINARY.contains(&magnitude) {
            let text = without_zeros(format!("{x:.decimals$}"));
            let is_zero = text.bytes().all(|b| matches!(b, b'-' | b'0'));
            if is_zero { "0".to_owned() } else { text }
        } else {
            format!("{x:.4e}")
        }
    };
    p.to_array().map(one).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_at_any_scale() {
        let cases = [
            (0.0, "0"),
            (2.5, "2.5"),
            (-1234.56, "-1235"),
            (9863.166254, "9863"),
            (92387.712, "92388"),
            (9.6460123, "9.646"),
            (99.996, "100"),
            (0.187085, "0.1871"),
            (1e31, "1.000e31"),
            (1.25e-7, "1.250e-7"),
        ];
        for (x, text) in cases {
            assert_eq!(length(x), text);
        }
        assert_eq!(significant(0.020_4, 2), "0.02");
        let mut x = 1e-300;
        while x < 1e300 {
            assert!(length(-x / 3.0).len() <= 11, "{x}");
            assert!(point(DVec3::splat(-x), x).len() <= 3 * 12 + 4, "{x}");
            x *= 7.0;
        }
    }

    #[test]
    fn lengths_that_are_rounding_are_nothing() {
        assert_eq!(length_beside(-4.4e-16, 2.0), "0");
        assert_eq!(length_beside(4.4e-16, 1e-12), "4.400e-16");
    }

    #[test]
    fn coordinates_that_are_rounding_are_nothing() {
        let p = DVec3::new(1e-17, -3e-5, 0.25);
        assert_eq!(point(p, 1.0), "0, 0, 0.25");
        assert_eq!(
            point(DVec3::new(-103.0206, 0.5, 7.0), 345.0),
            "-103.02, 0.5, 7"
        );
        assert_eq!(point(1e30 * p, 1e30), "0, -3.0000e25, 2.5000e29");
        assert_eq!(point(1e-20 * p, 1e-20), "0, -3.0000e-25, 2.5000e-21");
    }
}
