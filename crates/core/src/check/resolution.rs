//! Welding tolerance from the precision of the coordinates: 32-bit floats, decimal digits or 64-bit floats, recognised from the
//! values.

use glam::DVec3;

use crate::elementary::{log10, powi};
use crate::mesh::Mesh;
use crate::tuning::{Tunable, tunable};

/// Diagonals of the bounding box. Boundary vertices within this distance are merged by default.
const WELD: Tunable<f64> = tunable("check.weld", 1e-9);

/// Units in the last place of the file's coordinates. Boundary vertices within this distance are merged by default:
/// positions that were computed twice differed by up to three units.
pub(crate) const WELD_UNITS: Tunable<f64> = tunable("check.weld_units", 4.0);

/// Diagonals of the bounding box. Upper bound of the distance of `WELD_UNITS`: coordinates with few digits, such as voxel
/// coordinates, are often exact.
const WELD_MOST: Tunable<f64> = tunable("check.weld_most", 1e-5);

/// Decimal digits. Smallest precision looked for in the coordinates of text files.
const LEAST_DIGITS: Tunable<i32> = tunable("check.least_digits", 4);

/// Decimal digits. Largest precision looked for in the coordinates of text files.
const MOST_DIGITS: Tunable<i32> = tunable("check.most_digits", 12);

/// Relative distance. A coordinate this close to a 32-bit float counts as one written with nine digits or more.
const SINGLE: Tunable<f64> = tunable("check.single", 5e-9);

/// The distance within which boundary vertices count as one (mesh units): a fraction of the diagonal of the bounding box, or, if
/// larger, a few units in the last place of the largest coordinate, up to a limit. This place is the last bit of a 32-bit float
/// or the last decimal digit.
pub(crate) fn weld_length(mesh: &Mesh) -> f64 {
    let mut used = vec![false; mesh.positions.len()];
    let corners = mesh.faces.iter().flatten();
    corners.for_each(|&v| used[v as usize] = true);
    let points = mesh.positions.iter().zip(used).filter(|(_, used)| *used);
    let points: Vec<DVec3> = points.map(|(p, _)| *p).collect();
    let (low, high) = crate::mesh::bounds(points.iter().copied());
    let diagonal = low.distance(high);
    let unit = WELD_UNITS.get() * unit(&points);
    let most = WELD_MOST.get() * diagonal;
    (WELD.get() * diagonal).max(unit.min(most))
}

/// The unit in the last place of the largest coordinate, in the format that the coordinates seem to have been written in.
fn unit(points: &[DVec3]) -> f64 {
    let largest = points.iter().map(|p| p.abs().max_element());
    let largest = largest.fold(0.0, f64::max);
    if largest == 0.0 {
        return 0.0;
    }
    let is_single = |p: &DVec3| {
        let apart = (p.as_vec3().as_dvec3() - *p).abs();
        apart.cmple(SINGLE.get() * p.abs()).all()
    };
    if points.iter().all(is_single) {
        return f64::from(f32::EPSILON) * largest;
    }
    let is_of = |digits: i32| {
        let step = step(largest, digits);
        points.iter().flat_map(|p| p.to_array()).all(|x| {
            let steps = x / step;
            (steps - steps.round()).abs() * step <= 2.0 * f64::EPSILON * largest
        })
    };
    let digits = (LEAST_DIGITS.get()..=MOST_DIGITS.get()).find(|d| is_of(*d));
    digits.map_or(f64::EPSILON * largest, |digits| step(largest, digits))
}

/// The unit of the last decimal digit of `largest` written with `digits` significant digits.
fn step(largest: f64, digits: i32) -> f64 {
    powi(10.0, log10(largest).floor() as i32 + 1 - digits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::icosphere;

    #[test]
    fn floats_and_digits_are_told_from_the_coordinates() {
        let ball = icosphere(2);
        let mapped = |f: &dyn Fn(f64) -> f64| {
            let mut mesh = ball.clone();
            for p in &mut mesh.positions {
                *p = DVec3::from_array((*p * 37.0).to_array().map(f));
            }
            let largest = mesh.positions.iter().map(|p| p.abs().max_element());
            (unit(&mesh.positions), largest.fold(0.0, f64::max))
        };
        let (single, largest) = mapped(&|x| f64::from(x as f32));
        assert_eq!(single, f64::from(f32::EPSILON) * largest);
        let (decimals, _) = mapped(&|x| (x * 1e4).round() / 1e4);
        assert!((decimals / 1e-4 - 1.0).abs() < 1e-9, "{decimals}");
        let (exact, largest) = mapped(&|x| x / 3.0);
        assert!(exact <= 2.0 * f64::EPSILON * largest, "{exact}");
    }
}
