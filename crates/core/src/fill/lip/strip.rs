//! The edge of a wall between two places, swept along a curve.

use glam::{DMat3, DVec3, Vec3Swizzles};

use super::ends::End;
use crate::mesh::Mesh;
use crate::tuning::{Tunable, tunable};

/// Cosine between the chord from end to end and the directions of the edge at both, at least.
const LEAST_TOWARDS: Tunable<f64> = tunable("fill.lip.least_towards", 0.14);
/// Chords. The curve is at most this long.
const LONGEST: Tunable<f64> = tunable("fill.lip.longest", 1.35);
/// Root mean square distance of the places of the edge from the curve, over their distance from its ends, at most: half a circle is no cubic
/// curve, and is refused by this.
const MOST_OFF: Tunable<f64> = tunable("fill.lip.most_off", 0.25);
/// Fits of the curve, each with the length of the one before.
const FITS: usize = 4;
/// Parts of the curve by which its length is measured.
const PARTS: usize = 32;
/// Rows of the strip at most.
const MOST_ROWS: usize = 400;

/// A cubic curve from end to end, by its ends and its derivatives there.
#[derive(Clone, Copy, Debug)]
struct Cubic {
    ends: [DVec3; 2],
    slopes: [DVec3; 2],
}

/// The four cubic Hermite polynomials: of the values at 0 and 1, and of the slopes there.
fn hermite(u: f64) -> [f64; 4] {
    let (v, uu) = (1.0 - u, u * u);
    [
        v * v * (1.0 + 2.0 * u),
        uu * (3.0 - 2.0 * u),
        u * v * v,
        -uu * v,
    ]
}

impl Cubic {
    /// The curve between two ends that fits further places before the first and after the second one, by least squares; places count less
    /// the farther they are. None if it turns back or is much longer than its chord.
    fn fitted(ends: [DVec3; 2], places: &[Vec<DVec3>; 2]) -> Option<Self> {
        let chord = ends[1] - ends[0];
        let mut length = chord.length();
        let mut curve = Self {
            ends,
            slopes: [chord; 2],
        };
        for _ in 0..FITS {
            curve = curve.refitted(places, length)?;
            length = curve.length();
        }
        let towards = |slope: DVec3| slope.normalize_or_zero().dot(chord.normalize_or_zero());
        let [off, far] = curve.misfit(places, length);
        log::debug!("edge of a wall: curve off by {off:.4} of {far:.4}, length {length:.4}");
        let is_curve = off < MOST_OFF.get() * far
            && curve
                .slopes
                .iter()
                .all(|s| towards(*s) > LEAST_TOWARDS.get())
            && length < LONGEST.get() * chord.length();
        is_curve.then_some(curve)
    }

    /// Places beyond the ends: the end, the parameter of the curve there, and the place.
    fn beyond(
        &self,
        places: &[Vec<DVec3>; 2],
        length: f64,
    ) -> impl Iterator<Item = (DVec3, f64, DVec3)> {
        let [before, after] = [0, 1].map(|k| {
            let (end, mut last, mut way) = (self.ends[k], self.ends[k], 0.0);
            places[k].iter().map(move |p| {
                way += last.distance(*p) / length;
                last = *p;
                (end, if k == 0 { -way } else { 1.0 + way }, *p)
            })
        });
        before.chain(after)
    }

    /// Root sums of squares of the distances of the places from the curve, and from the ends.
    fn misfit(&self, places: &[Vec<DVec3>; 2], length: f64) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for (end, u, p) in self.beyond(places, length) {
            sums[0] += self.at(u).distance_squared(p);
            sums[1] += end.distance_squared(p);
        }
        sums.map(f64::sqrt)
    }

    fn refitted(&self, places: &[Vec<DVec3>; 2], length: f64) -> Option<Self> {
        // Normal equations of both slopes.
        let (mut matrix, mut sides) = ([0.0; 3], [DVec3::ZERO; 2]);
        for (_, u, p) in self.beyond(places, length) {
            let [a, b, c, d] = hermite(u);
            let way = f64::max(-u, u - 1.0);
            let weight = 1.0 / (1.0 + (4.0 * way).powi(2));
            let rest = p - a * self.ends[0] - b * self.ends[1];
            matrix[0] += weight * c * c;
            matrix[1] += weight * c * d;
            matrix[2] += weight * d * d;
            sides[0] += weight * c * rest;
            sides[1] += weight * d * rest;
        }
        let [a, b, c] = matrix;
        let determinant = a * c - b * b;
        (determinant > 1e-9 * a * c).then(|| Self {
            slopes: [
                (c * sides[0] - b * sides[1]) / determinant,
                (a * sides[1] - b * sides[0]) / determinant,
            ],
            ..*self
        })
    }

    fn at(&self, u: f64) -> DVec3 {
        let [a, b, c, d] = hermite(u);
        a * self.ends[0] + b * self.ends[1] + c * self.slopes[0] + d * self.slopes[1]
    }

    /// Unit tangent.
    fn tangent(&self, u: f64) -> DVec3 {
        let [v, chord] = [1.0 - u, 6.0 * u * (1.0 - u)];
        let slopes = v * (1.0 - 3.0 * u) * self.slopes[0] + u * (3.0 * u - 2.0) * self.slopes[1];
        (chord * (self.ends[1] - self.ends[0]) + slopes).normalize_or_zero()
    }

    fn length(&self) -> f64 {
        let at = |i: usize| self.at(i as f64 / PARTS as f64);
        (0..PARTS).map(|i| at(i).distance(at(i + 1))).sum()
    }
}

/// The edge of a wall between two ends: new vertices, numbered after the mesh's, and faces between the profiles of the ends.
pub(super) struct Strip {
    pub(super) positions: Vec<DVec3>,
    pub(super) faces: Vec<[u32; 3]>,
}

impl Strip {
    /// Sweeps the profile of the first end to the profile of the second one. `places` has further places of the edge, from each end into the
    /// mesh; `edge` is the length of the strip's edges. Profiles that lean along the edge are upright after `reach` times as far as they lean.
    pub(super) fn swept(
        mesh: &Mesh,
        ends: &[End; 2],
        places: &[Vec<DVec3>; 2],
        edge: f64,
        reach: f64,
    ) -> Option<Self> {
        let curve = Cubic::fitted([ends[0].tip, ends[1].tip], places)?;
        // Frames have the columns along, outwards and across.
        let frame = |u: f64| {
            let along = curve.tangent(u);
            let outwards = ends[0].outwards.lerp(ends[1].outwards, u);
            let outwards = outwards.reject_from_normalized(along).try_normalize()?;
            let across = along.cross(outwards);
            Some(DMat3::from_cols(along, outwards, across))
        };
        let columns = ends.iter().map(|e| e.profile.len()).max()?;
        let profile = |k: usize| {
            let frame = frame(k as f64)?;
            let local = |&v: &u32| frame.transpose() * (mesh.positions[v as usize] - ends[k].tip);
            let points: Vec<DVec3> = ends[k].profile.iter().map(local).collect();
            let at = fractions(&points);
            let even = evenly(&points, &at, columns);
            let row = Row {
                vertices: ends[k].profile.clone(),
                at,
            };
            Some((Profile::new(even, edge, reach), row))
        };
        let ([a, b], [first, end]) = {
            let [(a, first), (b, end)] = [profile(0)?, profile(1)?];
            ([a, b], [first, end])
        };
        let length = curve.length();
        let rows = ((length / edge).round() as usize).clamp(2, MOST_ROWS);
        let mut positions = Vec::new();
        let mut faces = Vec::new();
        let mut last = first;
        for row in 1..=rows {
            let u = row as f64 / rows as f64;
            let next = match row == rows {
                true => end.clone(),
                false => {
                    let first = (mesh.positions.len() + positions.len()) as u32;
                    let frame = frame(u)?;
                    let local = |i: usize| {
                        let [first, second] = [a.at(i, u * length), b.at(i, (1.0 - u) * length)];
                        first.lerp(second, u)
                    };
                    positions.extend((0..columns).map(|i| curve.at(u) + frame * local(i)));
                    Row {
                        vertices: (first..first + columns as u32).collect(),
                        at: even_fractions(columns),
                    }
                }
            };
            between(&last, &next, &mut faces);
            last = next;
        }
        Some(Self { positions, faces })
    }
}

/// The profile of the edge at an end, in the frame of the curve there: along, outwards and across.
struct Profile {
    /// In the plane across the curve.
    flat: Vec<DVec3>,
    /// How far along the curve the rim's points are from that plane.
    offsets: Vec<f64>,
    /// Length of the curve at which nothing is left of the offsets.
    reach: f64,
}

impl Profile {
    fn new(points: Vec<DVec3>, edge: f64, reach: f64) -> Self {
        let across = |p: &DVec3| DVec3::new(0.0, p.y, p.z);
        let flat: Vec<DVec3> = points.iter().map(across).collect();
        let offsets: Vec<f64> = points.iter().map(|p| p.x).collect();
        let largest = offsets.iter().map(|x| x.abs()).fold(edge, f64::max);
        Self {
            flat,
            offsets,
            reach: reach * largest,
        }
    }

    /// A point at a distance from the end along the curve.
    fn at(&self, i: usize, way: f64) -> DVec3 {
        self.flat[i] + f64::max(1.0 - way / self.reach, 0.0) * self.offsets[i] * DVec3::X
    }
}

/// Where the points of a polyline are along it, seen along the first axis: from 0 to 1.
fn fractions(points: &[DVec3]) -> Vec<f64> {
    let mut at = vec![0.0];
    for (i, pair) in points.windows(2).enumerate() {
        at.push(at[i] + (pair[1] - pair[0]).yz().length());
    }
    let whole = at[points.len() - 1].max(f64::MIN_POSITIVE);
    at.iter().map(|way| way / whole).collect()
}

/// Points of a polyline at even fractions of it.
fn evenly(points: &[DVec3], at: &[f64], count: usize) -> Vec<DVec3> {
    let mut segment = 0;
    let mut point = |fraction: f64| {
        while segment + 2 < points.len() && at[segment + 1] < fraction {
            segment += 1;
        }
        let own = at[segment + 1] - at[segment];
        let part = (fraction - at[segment]) / own.max(f64::MIN_POSITIVE);
        points[segment].lerp(points[segment + 1], part.clamp(0.0, 1.0))
    };
    even_fractions(count).into_iter().map(&mut point).collect()
}

fn even_fractions(count: usize) -> Vec<f64> {
    let last = (count - 1).max(1) as f64;
    (0..count).map(|k| k as f64 / last).collect()
}

/// Vertices of a row of the strip, and their fractions of its length.
#[derive(Clone)]
struct Row {
    vertices: Vec<u32>,
    at: Vec<f64>,
}

/// Triangles between two rows, which use the edges of the first one forwards.
fn between(first: &Row, second: &Row, faces: &mut Vec<[u32; 3]>) {
    let (a, b) = (&first.vertices, &second.vertices);
    let (m, n) = (a.len() - 1, b.len() - 1);
    let (mut i, mut j) = (0, 0);
    while i < m || j < n {
        // The row whose next vertex comes first.
        if j == n || i < m && first.at[i + 1] <= second.at[j + 1] {
            faces.push([a[i], a[i + 1], b[j]]);
            i += 1;
        } else {
            faces.push([a[i], b[j + 1], b[j]]);
            j += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_between_two_parts_of_a_circle_is_an_arc() {
        let at = |degrees: f64| {
            let t = degrees.to_radians();
            10.0 * DVec3::new(t.cos(), t.sin(), 0.0)
        };
        let beyond = [-20.0, 20.0].map(|end: f64| {
            let places = (1..=8).map(|k| at(end + end.signum() * 2.0 * f64::from(k)));
            places.collect::<Vec<_>>()
        });
        let curve = Cubic::fitted([at(-20.0), at(20.0)], &beyond).unwrap();
        for i in 0..=20 {
            let off = curve.at(f64::from(i) / 20.0).length() - 10.0;
            assert!(off.abs() < 0.02, "{off}");
        }
        // The tangent is the derivative.
        let step = (curve.at(0.3 + 1e-6) - curve.at(0.3 - 1e-6)).normalize();
        assert!(step.distance(curve.tangent(0.3)) < 1e-6);
    }

    #[test]
    fn rows_of_different_lengths_are_joined_by_all_their_edges() {
        let mut faces = Vec::new();
        let row = |vertices: &[u32]| Row {
            vertices: vertices.to_vec(),
            at: even_fractions(vertices.len()),
        };
        between(&row(&[0, 1, 2, 3]), &row(&[4, 5]), &mut faces);
        assert_eq!(faces.len(), 4);
        for edge in [[0, 1], [1, 2], [2, 3], [5, 4]] {
            let uses = |f: &&[u32; 3]| (0..3).any(|k| [f[k], f[(k + 1) % 3]] == edge);
            assert_eq!(faces.iter().filter(uses).count(), 1, "{edge:?}");
        }
    }
}
