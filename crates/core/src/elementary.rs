//! Elementary functions with the same bits on every platform, by the crate `libm`.
//!
//! The functions of the standard library come from the system's C library, whose last bits differ between systems, and between
//! processors with and without fused multiply-add. Results must not: `clippy.toml` forbids them. Square roots, rounding and powers
//! with constant integers are exact or compiled to the same operations, and are taken from the standard library.

pub use libm::{acos, atan2, cbrt, cos, exp, hypot, log as ln, log2, log10, pow as powf, sin};

use glam::{DMat3, DQuat, DVec2, DVec3};

/// The root of the mean of squares; 0 without values.
pub fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(s, n), v| (s + v * v, n + 1.0));
    match count > 0.0 {
        true => (sum / count).sqrt(),
        false => 0.0,
    }
}

/// An integer power, by repeated squaring.
pub fn powi(x: f64, exponent: i32) -> f64 {
    let (mut power, mut square, mut rest) = (1.0, x, exponent.unsigned_abs());
    while rest > 0 {
        if rest % 2 == 1 {
            power *= square;
        }
        square *= square;
        rest /= 2;
    }
    if exponent < 0 { 1.0 / power } else { power }
}

/// Sine and cosine.
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// The unit vector at an angle from the x axis, in radians.
pub fn at_angle(angle: f64) -> DVec2 {
    let (sine, cosine) = sin_cos(angle);
    DVec2::new(cosine, sine)
}

/// The angle of a vector from the x axis, in (−π, π].
pub fn angle_of(v: DVec2) -> f64 {
    atan2(v.y, v.x)
}

/// The angle between two vectors, in [0, π].
pub fn angle_between(a: DVec3, b: DVec3) -> f64 {
    let cosine = a.dot(b) / (a.length_squared() * b.length_squared()).sqrt();
    acos(cosine.clamp(-1.0, 1.0))
}

/// The rotation by a vector: about its direction, by its length in radians.
pub fn rotation(turn: DVec3) -> DMat3 {
    let angle = turn.length();
    if angle == 0.0 {
        return DMat3::IDENTITY;
    }
    let (sine, cosine) = sin_cos(0.5 * angle);
    let axis = turn * (sine / angle);
    DMat3::from_quat(DQuat::from_xyzw(axis.x, axis.y, axis.z, cosine))
}

#[cfg(test)]
mod tests {
    use super::*;

    type Function = fn(f64) -> f64;

    #[test]
    fn the_bits_are_those_of_every_other_system() {
        let functions: [(Function, Function); 8] = [
            (exp, f64::exp),
            (|x| ln(x.abs()), |x| x.abs().ln()),
            (|x| log10(x.abs()), |x| x.abs().log10()),
            (|x| powf(x.abs(), 1.7), |x| x.abs().powf(1.7)),
            (|x| sin_cos(x).0, f64::sin),
            (|x| sin_cos(x).1, f64::cos),
            (cbrt, f64::cbrt),
            (|x| atan2(x, 2.0), |x| x.atan2(2.0)),
        ];
        // FNV-1a over the bits.
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for i in -2000..2000 {
            let x = (f64::from(i) + 0.37) / 61.0;
            for (own, system) in functions {
                let (own, system) = (own(x), system(x));
                assert!(
                    (own - system).abs() <= 4e-16 * system.abs().max(1e-2),
                    "{x}: {own} {system}"
                );
                hash = (hash ^ own.to_bits()).wrapping_mul(0x0100_0000_01b3);
            }
        }
        assert_eq!(hash, 0xfc56_e810_af2b_124a, "{hash:#x}");
    }

    #[test]
    fn angles_and_rotations_are_right() {
        let (x, y) = (DVec3::X, DVec3::new(1.0, 2.0, 2.0));
        assert!((angle_between(x, y).cos() - 1.0 / 3.0).abs() < 1e-15);
        assert_eq!(angle_between(x, 2.0 * x), 0.0);
        let turn = DVec3::new(0.0, 0.0, 0.3);
        let turned = rotation(turn) * x;
        assert!((angle_of(turned.truncate()) - 0.3).abs() < 1e-15);
        assert!((at_angle(0.3) - turned.truncate()).length() < 1e-15);
        assert_eq!(rotation(DVec3::ZERO), DMat3::IDENTITY);
        assert_eq!(
            [powi(10.0, 3), powi(2.0, -2), powi(3.0, 0)],
            [1000.0, 0.25, 1.0]
        );
    }
}
