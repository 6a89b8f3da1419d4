//! The two places where a rim crosses the edge of a wall.

use glam::DVec3;

use crate::mesh::{Mesh, VertexFaces, vertex_normal};
use crate::tuning::{Tunable, tunable};

/// Cosine between the normals of two vertices on the two sides of a wall, at most.
const OPPOSITE: Tunable<f64> = tunable("fill.lip.opposite", -0.7);
/// Cosine between a vertex's normal, or the opposite one, and the way to the other side, at least.
const ALONG_NORMAL: Tunable<f64> = tunable("fill.lip.along_normal", 0.5);
/// Fraction of the rim's vertices that have the other side of the wall behind them, at least.
const FEWEST_ON_SIDES: Tunable<f64> = tunable("fill.lip.fewest_on_sides", 0.5);
/// Median thicknesses. Pairs of vertices that are nearer or farther are none.
const THICKNESSES: [f64; 2] = [0.4, 2.0];
/// Thicknesses. The two ends are at least this far apart.
const LEAST_APART: Tunable<f64> = tunable("fill.lip.least_apart", 1.5);
/// Vertices before and after one, of which the normals are averaged.
const AVERAGED: usize = 2;

/// The edge of a wall where a rim crosses it.
#[derive(Clone, Debug)]
pub(super) struct End {
    /// Vertices of the rim from the first side of the wall over the edge to the second.
    pub(super) profile: Vec<u32>,
    /// The outermost place of the edge, midway between the sides.
    pub(super) tip: DVec3,
    /// Unit vector out of the wall, perpendicular to the way across it.
    pub(super) outwards: DVec3,
}

/// The two ends of the edge of a wall at a rim, and the median thickness of the wall.
pub(super) struct Ends {
    pub(super) both: [End; 2],
    pub(super) thickness: f64,
}

/// A vertex of a rim, and the nearest one on the other side of the wall.
struct Pair {
    from: usize,
    to: usize,
}

/// A rim, with the smoothed normals of its vertices.
pub(super) struct Rim<'a> {
    vertices: &'a [u32],
    at: Vec<DVec3>,
    normals: Vec<DVec3>,
    /// Length of the rim up to each vertex, and the whole.
    lengths: Vec<f64>,
}

impl<'a> Rim<'a> {
    pub(super) fn new(mesh: &Mesh, vertices: &'a [u32]) -> Self {
        let around = VertexFaces::new(mesh);
        Self::with_normals(mesh, vertices, |v| vertex_normal(mesh, &around, v))
    }

    /// With the unit normals of its vertices.
    pub(super) fn with_normals(
        mesh: &Mesh,
        vertices: &'a [u32],
        normal: impl Fn(u32) -> DVec3,
    ) -> Self {
        let n = vertices.len();
        let at: Vec<DVec3> = vertices
            .iter()
            .map(|&v| mesh.positions[v as usize])
            .collect();
        let own: Vec<DVec3> = vertices.iter().map(|&v| normal(v)).collect();
        let mean = |i: usize| {
            let near = (0..=2 * AVERAGED).map(|k| own[(i + n + k - AVERAGED) % n]);
            near.sum::<DVec3>().normalize_or_zero()
        };
        let mut lengths = vec![0.0];
        for i in 0..n {
            lengths.push(lengths[i] + at[i].distance(at[(i + 1) % n]));
        }
        Self {
            vertices,
            normals: (0..n).map(mean).collect(),
            at,
            lengths,
        }
    }

    fn len(&self) -> usize {
        self.vertices.len()
    }

    fn distance(&self, pair: &Pair) -> f64 {
        self.at[pair.from].distance(self.at[pair.to])
    }

    /// The two ends of the edge of a wall, if the rim runs along one side, over the edge, back along the other side, and over the edge
    /// again; none for any other rim. Their profiles reach `beyond` thicknesses of the wall beyond the last pair of opposite vertices.
    pub(super) fn ends(&self, beyond: f64) -> Option<Ends> {
        // The other side of a groove is in front of the first, the other side of a wall is behind it.
        let fronts = [-1.0, 1.0];
        fronts
            .into_iter()
            .find_map(|front| self.ends_at(front, beyond))
    }

    /// The two ends of a wall (`front` is −1) or of a groove (1).
    fn ends_at(&self, front: f64, beyond: f64) -> Option<Ends> {
        let (pairs, thickness) = self.pairs(front)?;
        let near = self.nearest(&pairs, |p| self.way(p.from, p.to))?;
        // Along the rim from there: the second side, the far end, the first side.
        let after = |i: usize| (i + self.len() - near.to) % self.len();
        let from_first = pairs
            .iter()
            .filter(|p| after(p.to) < after(p.from) && after(p.from) <= after(near.from));
        let far = self.nearest(from_first, |p| self.way(p.to, p.from))?;
        let first = self.end([near.from, near.to], front, beyond * thickness)?;
        let mut second = self.end([far.to, far.from], front, beyond * thickness)?;
        second.profile.reverse();
        let apart = first.tip.distance(second.tip);
        (apart > LEAST_APART.get() * thickness).then_some(Ends {
            both: [first, second],
            thickness,
        })
    }

    /// The pair with the shortest way.
    fn nearest<'p>(
        &self,
        pairs: impl IntoIterator<Item = &'p Pair>,
        way: impl Fn(&Pair) -> f64,
    ) -> Option<&'p Pair> {
        let by_way = |a: &&Pair, b: &&Pair| way(a).total_cmp(&way(b));
        pairs.into_iter().min_by(by_way)
    }

    /// Length of the rim from one vertex on to another.
    fn way(&self, from: usize, to: usize) -> f64 {
        let way = self.lengths[to] - self.lengths[from];
        if way < 0.0 {
            way + self.lengths[self.len()]
        } else {
            way
        }
    }

    /// The vertices that have the other side of the wall behind them, and the median thickness of the wall; none if these are few.
    fn pairs(&self, front: f64) -> Option<(Vec<Pair>, f64)> {
        (self.len() > 4 * AVERAGED).then_some(())?;
        let pairs = (0..self.len()).filter_map(|i| self.pair(i, front));
        let mut pairs: Vec<Pair> = pairs.collect();
        let mut distances: Vec<f64> = pairs.iter().map(|p| self.distance(p)).collect();
        distances.sort_unstable_by(f64::total_cmp);
        let median = *distances.get(distances.len() / 2)?;
        let [least, most] = THICKNESSES.map(|part| part * median);
        pairs.retain(|p| (least..=most).contains(&self.distance(p)));
        let fewest = FEWEST_ON_SIDES.get() * self.len() as f64;
        (pairs.len() as f64 >= fewest).then_some((pairs, median))
    }

    /// A vertex and the nearest one on the other side of the wall, if there is one.
    fn pair(&self, from: usize, front: f64) -> Option<Pair> {
        let (at, normal) = (self.at[from], self.normals[from]);
        let mut best = (f64::INFINITY, from);
        for (to, (other, n)) in self.at.iter().zip(&self.normals).enumerate() {
            let (way, distance) = (*other - at, at.distance(*other));
            let is_there = front * way.dot(normal) > ALONG_NORMAL.get() * distance;
            if distance < best.0 && is_there && n.dot(normal) < OPPOSITE.get() {
                best = (distance, to);
            }
        }
        best.0.is_finite().then_some(Pair { from, to: best.1 })
    }

    /// The end whose last pair of vertices is given, in the direction of the rim; its profile reaches farther by a length.
    fn end(&self, [from, to]: [usize; 2], front: f64, reach: f64) -> Option<End> {
        let n = self.len();
        let (mut first, mut last) = (from, to);
        while self.way(first, from) < reach {
            first = (first + n - 1) % n;
        }
        while self.way(to, last) < reach {
            last = (last + 1) % n;
        }
        let count = (last + n - first) % n;
        let places: Vec<usize> = (0..=count).map(|k| (first + k) % n).collect();
        let across = (self.at[from] - self.at[to]).try_normalize()?;
        let middle = 0.5 * (self.at[from] + self.at[to]);
        let normals = places.iter().map(|&i| self.normals[i]);
        let outwards = -front * normals.sum::<DVec3>().reject_from_normalized(across);
        let outwards = outwards.try_normalize()?;
        let height = |&i: &usize| (self.at[i] - middle).dot(outwards);
        let highest = places.iter().map(height).fold(0.0, f64::max);
        Some(End {
            profile: places.iter().map(|&i| self.vertices[i]).collect(),
            tip: middle + highest * outwards,
            outwards,
        })
    }
}
