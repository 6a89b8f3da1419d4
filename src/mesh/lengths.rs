//! Formatting of lengths and points with bounded width for any unit of the mesh.

use glam::DVec3;

/// Lengths and coordinates in this range are printed with fixed decimals, all others in scientific notation. The lower bound
/// still has four significant digits with six decimals; the upper bound keeps numbers within fourteen characters.
const ORDINARY: std::ops::Range<f64> = 1e-3..1e7;
/// Values below this fraction of their reference size are rounding errors.
const NOTHING: f64 = 1e-9;

/// Formats a length: six decimals, or scientific notation if it is very large or small.
pub fn length(x: f64) -> String {
    if x == 0.0 || ORDINARY.contains(&x.abs()) {
        format!("{x:.6}")
    } else {
        format!("{x:.5e}")
    }
}

/// Formats a length relative to a reference size: 0 if it is only rounding error.
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

/// Formats a point with commas between its coordinates: five decimals, or scientific notation if the coordinates and the
/// reference size are very large or small.
pub fn point(p: DVec3, size: f64) -> String {
    let scale = size.abs().max(p.abs().max_element());
    let one = |x: f64| {
        if scale == 0.0 || ORDINARY.contains(&scale) {
            format!("{x:.5}")
        } else if x.abs() <= NOTHING * scale {
            "0".to_owned()
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
            (0.0, "0.000000"),
            (2.5, "2.500000"),
            (-1234.5, "-1234.500000"),
            (1e31, "1.00000e31"),
            (1.25e-7, "1.25000e-7"),
        ];
        for (x, text) in cases {
            assert_eq!(length(x), text);
        }
        let mut x = 1e-300;
        while x < 1e300 {
            assert!(length(-x / 3.0).len() <= 15, "{x}");
            assert!(point(DVec3::splat(-x), x).len() <= 3 * 14 + 4, "{x}");
            x *= 7.0;
        }
    }

    #[test]
    fn lengths_that_are_rounding_are_nothing() {
        assert_eq!(length_beside(-4.4e-16, 2.0), "0.000000");
        assert_eq!(length_beside(4.4e-16, 1e-12), "4.40000e-16");
    }

    #[test]
    fn coordinates_that_are_rounding_are_nothing() {
        let p = DVec3::new(1e-17, -3e-5, 0.25);
        assert_eq!(point(p, 1.0), "0.00000, -0.00003, 0.25000");
        assert_eq!(point(1e30 * p, 1e30), "0, -3.0000e25, 2.5000e29");
        assert_eq!(point(1e-20 * p, 1e-20), "0, -3.0000e-25, 2.5000e-21");
    }
}
