//! The edge of a wall between two places, swept along a curve.

use glam::{DMat3, DVec2, DVec3};

use super::curve::Curve;
use super::ends::End;
use crate::creases::is_well_inside;
use crate::mesh::Mesh;
use crate::mesh::triangulate::constrained_delaunay;

/// Edges. Columns of the strip are at least this far from each other.
const COLUMNS_APART: f64 = 0.6;
/// Rows of the strip at most.
const MOST_ROWS: f64 = 1000.0;
/// Upper bound of the factor by which profiles are stretched in the chart.
const MOST_STRETCHED: f64 = 3.0;

/// The edge of a wall between two ends: new vertices, numbered after the mesh's, and faces between the profiles of the ends.
pub(super) struct Strip {
    pub(super) positions: Vec<DVec3>,
    pub(super) faces: Vec<[u32; 3]>,
}

impl Strip {
    /// Sweeps the profile of the first end to the profile of the second one along a curve. The strip is triangulated in the plane, where
    /// the profiles are upright lines but for the rim's teeth. `edge` is the length of its edges. None where the profiles reach into each
    /// other.
    pub(super) fn swept(mesh: &Mesh, ends: &[End; 2], curve: &Curve, edge: f64) -> Option<Self> {
        let sweep = Sweep::new(mesh, ends, curve, edge)?;
        // Counter-clockwise: along the first profile, the second side, back along the second profile, and the first side.
        let rims = [0, 1].map(|k| sweep.rim_of(k));
        let [first, second] = &rims;
        let [up, down] = [
            between(*first.last()?, *second.last()?, edge),
            between(second[0], first[0], edge),
        ];
        let back: Vec<DVec2> = second.iter().rev().copied().collect();
        let outline = [&first[..], &up, &back, &down].concat();
        let mut inner = sweep.lattice(&rims, edge);
        inner.retain(|p| is_well_inside(&outline, *p, edge));
        let triangles = constrained_delaunay(&outline, &inner)?;

        // The rim's vertices are the mesh's, the other points are new.
        let profiles = ends.each_ref().map(|e| &e.profile[..]);
        let count = mesh.positions.len();
        let mut positions = Vec::new();
        let mut new = |points: &[DVec2]| -> Option<Vec<u32>> {
            let first = count + positions.len();
            for p in points {
                positions.push(sweep.at(*p)?);
            }
            Some((first..count + positions.len()).map(|v| v as u32).collect())
        };
        let [up, down, inner] = [new(&up)?, new(&down)?, new(&inner)?];
        let back: Vec<u32> = profiles[1].iter().rev().copied().collect();
        let numbers = [profiles[0], &up, &back, &down, &inner].concat();
        Some(Self {
            positions,
            faces: triangles.iter().map(|f| f.map(|i| numbers[i])).collect(),
        })
    }
}

/// Points between two others, about an edge apart.
fn between(a: DVec2, b: DVec2, edge: f64) -> Vec<DVec2> {
    let parts = (a.distance(b) / edge).round() as usize;
    (1..parts)
        .map(|i| a.lerp(b, i as f64 / parts as f64))
        .collect()
}

/// The sweep of two profiles along a curve. Its chart has the way along the profiles first, then the way along the curve.
struct Sweep<'a> {
    curve: &'a Curve,
    outwards: [DVec3; 2],
    profiles: [Profile; 2],
    /// Length of the curve.
    length: f64,
    /// Length of the profiles in the chart: rims' edges across the curve are as long there as edges along it.
    width: f64,
}

/// The profile of the edge at an end, in the frame of the curve there: along, outwards and across.
struct Profile {
    /// The rim's points, in the plane across the curve.
    flat: Vec<DVec3>,
    /// The length of the profile up to each.
    ways: Vec<f64>,
    /// How far along the curve the rim's points are from that plane.
    offsets: Vec<f64>,
}

impl<'a> Sweep<'a> {
    fn new(mesh: &Mesh, ends: &[End; 2], curve: &'a Curve, edge: f64) -> Option<Self> {
        let outwards = [ends[0].outwards, ends[1].outwards];
        let profile = |k: usize| {
            let inverse = frame(curve, outwards, k as f64)?.transpose();
            let local = |&v: &u32| inverse * (mesh.positions[v as usize] - ends[k].tip);
            let points: Vec<DVec3> = ends[k].profile.iter().map(local).collect();
            Some(Profile::new(&points))
        };
        let profiles = [profile(0)?, profile(1)?];
        let length = profiles[0].length() + profiles[1].length();
        let edges = profiles[0].ways.len() + profiles[1].ways.len() - 2;
        let width = 0.5 * (edge * edges as f64).clamp(length, MOST_STRETCHED * length);
        let sweep = Self {
            curve,
            outwards,
            profiles,
            length: curve.length(),
            width,
        };
        (sweep.width > 0.0 && sweep.length > 0.0).then_some(sweep)
    }

    /// The rim's points of an end, in the chart.
    fn rim_of(&self, k: usize) -> Vec<DVec2> {
        let profile = &self.profiles[k];
        let scale = self.width / profile.length().max(f64::MIN_POSITIVE);
        let points = profile.ways.iter().zip(&profile.offsets);
        let start = k as f64 * self.length;
        points
            .map(|(s, x)| DVec2::new(s * scale, start + x))
            .collect()
    }

    /// Points of the chart in rows across the curve, of which each has the rim's points of the nearer end.
    fn lattice(&self, rims: &[Vec<DVec2>; 2], edge: f64) -> Vec<DVec2> {
        let columns = rims.each_ref().map(|rim| {
            let mut columns: Vec<f64> = vec![0.0];
            for p in rim {
                let last = columns[columns.len() - 1];
                if p.x - last >= COLUMNS_APART * edge {
                    let count = ((p.x - last) / edge).round().max(1.0);
                    let step = (p.x - last) / count;
                    columns.extend((1..=count as usize).map(|i| last + i as f64 * step));
                }
            }
            columns
        });
        let ways = || rims.iter().flatten().map(|p| p.y);
        let [low, high] = [
            ways().fold(f64::INFINITY, f64::min),
            ways().fold(f64::NEG_INFINITY, f64::max),
        ];
        let rows = ((high - low) / edge).min(MOST_ROWS) as usize;
        let row = |j: usize| {
            let y = low + (j as f64 + 0.5) * (high - low) / rows as f64;
            let nearer = usize::from(2.0 * y > self.length);
            columns[nearer].iter().map(move |x| DVec2::new(*x, y))
        };
        (0..rows).flat_map(row).collect()
    }

    /// The place of a point of the chart.
    fn at(&self, p: DVec2) -> Option<DVec3> {
        let (s, u) = (p.x / self.width, p.y / self.length);
        let [first, second] = self.profiles.each_ref().map(|profile| profile.at(s));
        let frame = frame(self.curve, self.outwards, u)?;
        Some(self.curve.at(u) + frame * first.lerp(second, u.clamp(0.0, 1.0)))
    }
}

/// Unit vectors along the curve, outwards and across, as columns, from the directions outwards at its ends.
fn frame(curve: &Curve, outwards: [DVec3; 2], u: f64) -> Option<DMat3> {
    let along = curve.tangent(u);
    let outwards = curve.between(outwards, u);
    let outwards = outwards.reject_from_normalized(along).try_normalize()?;
    Some(DMat3::from_cols(along, outwards, along.cross(outwards)))
}

impl Profile {
    fn new(points: &[DVec3]) -> Self {
        let flat: Vec<DVec3> = points.iter().map(|p| p.with_x(0.0)).collect();
        let mut ways = vec![0.0];
        for (i, pair) in flat.windows(2).enumerate() {
            ways.push(ways[i] + pair[0].distance(pair[1]));
        }
        Self {
            flat,
            ways,
            offsets: points.iter().map(|p| p.x).collect(),
        }
    }

    fn length(&self) -> f64 {
        self.ways[self.ways.len() - 1]
    }

    /// The point at a part of its length.
    fn at(&self, part: f64) -> DVec3 {
        let way = part * self.length();
        let next = self.ways.partition_point(|w| *w < way);
        let next = next.clamp(1, self.ways.len() - 1);
        let [a, b] = [self.ways[next - 1], self.ways[next]];
        let between = (way - a) / (b - a).max(f64::MIN_POSITIVE);
        self.flat[next - 1].lerp(self.flat[next], between.clamp(0.0, 1.0))
    }
}
