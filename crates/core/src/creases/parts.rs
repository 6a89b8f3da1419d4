//! Triangulation of a part of a patch between creases, in the plane: projected along its mean normal, or unrolled around its axis
//! if it turns far.

use glam::{DVec2, DVec3};

use super::CreaseRefusal;
use super::collar::Collar;
use super::sheet::{Sheet, onto};
use crate::elementary::{angle_of, at_angle};
use crate::linalg::{second_moments, solve_spd, symmetric_eigen};
use crate::mesh::triangulate::constrained_delaunay;
use crate::tuning::{Tunable, tunable};

/// A part is unrolled if the cosine of one of its normals with their mean is below this.
const TURNS: Tunable<f64> = tunable("creases.parts.turns", 0.5);
/// Maximum component along the axis of the unit normals of an unrolled part.
const ALONG_AXIS: Tunable<f64> = tunable("creases.parts.along_axis", 0.5);
/// Maximum radius of an unrolled part, in diameters of the hole.
const MOST_RADIUS: Tunable<f64> = tunable("creases.parts.most_radius", 5.0);
/// Minimum distance of inner points from the outline, in edges.
const FROM_OUTLINE: Tunable<f64> = tunable("creases.parts.from_outline", 0.45);
/// Steps that project inner points on the sheet.
const STEPS: Tunable<usize> = tunable("creases.parts.steps", 12);
/// Maximum number of inner points of a part.
const MOST_POINTS: Tunable<f64> = tunable("creases.parts.most_points", 200_000.0);

/// A triangulated part: positions of its inner points, and triangles with indices into the outline followed by the inner points.
pub(super) struct Triangles {
    pub(super) inner: Vec<DVec3>,
    pub(super) faces: Vec<[usize; 3]>,
}

/// The map between a part and the plane.
enum Chart {
    Projected {
        origin: DVec3,
        axes: [DVec3; 2],
    },
    /// Around an axis: angles times the radius, and heights. The sign of heights keeps the orientation.
    Unrolled {
        axis: DVec3,
        across: [DVec3; 2],
        centre: DVec2,
        radius: f64,
        sign: f64,
    },
}

/// Triangulates the region inside an outline on a sheet.
pub(super) fn triangulate(
    collar: &Collar,
    sheet: &Sheet,
    outline: &[DVec3],
) -> Result<Triangles, CreaseRefusal> {
    let normals: Vec<DVec3> = outline.iter().map(|p| sheet.normal(*p)).collect();
    let mean = normals.iter().sum::<DVec3>().normalize_or_zero();
    let least = normals
        .iter()
        .map(|n| n.dot(mean))
        .fold(f64::INFINITY, f64::min);
    let (chart, flat) = match least < TURNS.get() {
        true => unroll(collar, sheet, outline, &normals)?,
        false => project(outline, mean),
    };
    if area(&flat) < 0.0 {
        return Err(CreaseRefusal::Reversed);
    }
    let inner = inner_points(&flat, collar.rim_edge)?;
    let faces = constrained_delaunay(&flat, &inner).ok_or(CreaseRefusal::Crosses)?;
    let longest = 0.3 * collar.diameter;
    let back = |p: &DVec2| onto(&[sheet], chart.back(*p), STEPS.get(), longest);
    Ok(Triangles {
        inner: inner.iter().map(back).collect(),
        faces,
    })
}

impl Chart {
    fn back(&self, p: DVec2) -> DVec3 {
        match self {
            Self::Projected { origin, axes } => origin + axes[0] * p.x + axes[1] * p.y,
            Self::Unrolled {
                axis,
                across,
                centre,
                radius,
                sign,
            } => {
                let at = *centre + *radius * at_angle(p.x / radius);
                across[0] * at.x + across[1] * at.y + *axis * (sign * p.y)
            }
        }
    }
}

fn project(outline: &[DVec3], normal: DVec3) -> (Chart, Vec<DVec2>) {
    let x = normal.any_orthonormal_vector();
    let axes = [x, normal.cross(x)];
    let origin = outline.iter().sum::<DVec3>() / outline.len() as f64;
    let flat = outline.iter().map(|p| *p - origin);
    let flat = flat
        .map(|p| DVec2::new(p.dot(axes[0]), p.dot(axes[1])))
        .collect();
    (Chart::Projected { origin, axes }, flat)
}

/// Unrolls an outline around the axis that is most nearly perpendicular to its normals. The circle is fitted to the sheet's
/// points nearby.
fn unroll(
    collar: &Collar,
    sheet: &Sheet,
    outline: &[DVec3],
    normals: &[DVec3],
) -> Result<(Chart, Vec<DVec2>), CreaseRefusal> {
    // The axis, and coordinates across it.
    let axis = symmetric_eigen(&second_moments(normals.iter().copied())).1[0];
    let x = axis.cross(normals[0]).normalize_or_zero();
    let across = [x, axis.cross(x)];
    let flat_of = |p: DVec3| DVec2::new(p.dot(across[0]), p.dot(across[1]));
    // The circle through the sheet's points near the outline, or through all of them if these are too few.
    let middle = outline.iter().sum::<DVec3>() / outline.len() as f64;
    let is_near = |p: &&DVec3| p.distance(middle) < 2.0 * collar.diameter;
    let mut points: Vec<DVec2> = sheet
        .points
        .iter()
        .filter(is_near)
        .map(|p| flat_of(*p))
        .collect();
    if points.len() <= 6 {
        points = sheet.points.iter().map(|p| flat_of(*p)).collect();
    }
    let (centre, radius) = circle(&points).ok_or(CreaseRefusal::Turns)?;
    // Angles around the axis, without jumps of 2π along the outline.
    let mut angles: Vec<f64> = outline
        .iter()
        .map(|p| angle_of(flat_of(*p) - centre))
        .collect();
    for i in 1..angles.len() {
        let turns = (angles[i - 1] - angles[i]) / std::f64::consts::TAU;
        angles[i] += turns.round() * std::f64::consts::TAU;
    }
    // The outline must not go around the axis, and its normals must be across it.
    let closes = (angles[angles.len() - 1] - angles[0]).abs() <= std::f64::consts::PI;
    let along = normals
        .iter()
        .map(|n| n.dot(axis).abs())
        .fold(0.0, f64::max);
    if !closes || along > ALONG_AXIS.get() || radius > MOST_RADIUS.get() * collar.diameter {
        return Err(CreaseRefusal::Turns);
    }
    // The orientation: whether normals point away from the axis.
    let outwards = outline.iter().zip(normals).map(|(p, n)| {
        let at = flat_of(*p) - centre;
        n.dot(across[0] * at.x + across[1] * at.y)
    });
    let sign = if outwards.sum::<f64>() > 0.0 {
        1.0
    } else {
        -1.0
    };
    let flat = outline.iter().zip(&angles);
    let flat = flat
        .map(|(p, angle)| DVec2::new(radius * angle, sign * p.dot(axis)))
        .collect();
    let chart = Chart::Unrolled {
        axis,
        across,
        centre,
        radius,
        sign,
    };
    Ok((chart, flat))
}

/// The least-squares circle through points of the plane (Kåsa 1976): centre and radius.
pub(crate) fn circle(points: &[DVec2]) -> Option<(DVec2, f64)> {
    let middle = points.iter().sum::<DVec2>() / points.len().max(1) as f64;
    let mut matrix = [0.0; 9];
    let mut right = [0.0; 3];
    for p in points.iter().map(|p| *p - middle) {
        let row = [2.0 * p.x, 2.0 * p.y, 1.0];
        for i in 0..3 {
            (0..3).for_each(|j| matrix[3 * i + j] += row[i] * row[j]);
            right[i] += row[i] * p.length_squared();
        }
    }
    solve_spd(&mut matrix, &mut right).then_some(())?;
    let centre = DVec2::new(right[0], right[1]);
    let radius = (right[2] + centre.length_squared()).max(0.0).sqrt();
    (radius > 0.0 && radius.is_finite()).then_some((middle + centre, radius))
}

fn next<T: Copy>(list: &[T], i: usize) -> T {
    list[(i + 1) % list.len()]
}

fn area(outline: &[DVec2]) -> f64 {
    let twice = (0..outline.len()).map(|i| outline[i].perp_dot(next(outline, i)));
    0.5 * twice.sum::<f64>()
}

/// Points of a regular triangular lattice inside an outline, at a minimum distance from it.
fn inner_points(outline: &[DVec2], edge: f64) -> Result<Vec<DVec2>, CreaseRefusal> {
    let low = outline.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let high = outline
        .iter()
        .copied()
        .fold(DVec2::NEG_INFINITY, DVec2::max);
    let row = 0.866 * edge;
    let size = ((high - low) / DVec2::new(edge, row)).ceil();
    if size.x.is_nan() || size.x * size.y > MOST_POINTS.get() {
        return Err(CreaseRefusal::TooLarge);
    }
    let mut points = Vec::new();
    for j in 0..size.y as usize {
        for i in 0..size.x as usize {
            let shift = if j % 2 == 1 { 0.5 * edge } else { 0.0 };
            points.push(low + DVec2::new(i as f64 * edge + shift, j as f64 * row));
        }
    }
    points.retain(|p| is_well_inside(outline, *p, edge));
    Ok(points)
}

/// Whether a point is inside an outline, at a minimum distance from it.
pub(crate) fn is_well_inside(outline: &[DVec2], p: DVec2, edge: f64) -> bool {
    is_inside(outline, p) && distance(outline, p) > FROM_OUTLINE.get() * edge
}

/// Whether a point is inside a polygon, by the even-odd rule.
fn is_inside(outline: &[DVec2], p: DVec2) -> bool {
    let crosses = |i: &usize| {
        let (a, b) = (outline[*i], next(outline, *i));
        (a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x
    };
    (0..outline.len()).filter(crosses).count() % 2 == 1
}

fn distance(outline: &[DVec2], p: DVec2) -> f64 {
    let squares = (0..outline.len()).map(|i| {
        let (a, b) = (outline[i], next(outline, i));
        let t = (p - a).dot(b - a) / (b - a).length_squared().max(f64::MIN_POSITIVE);
        p.distance_squared(a.lerp(b, t.clamp(0.0, 1.0)))
    });
    squares.fold(f64::INFINITY, f64::min).sqrt()
}
