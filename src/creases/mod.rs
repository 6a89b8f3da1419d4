//! Sharp edges continued across a hole: the smooth sides round the rim, where their continuations meet, and the parts between.

mod collar;
mod labels;
mod network;
mod parts;
mod rings;
mod segment;
mod sheet;
#[cfg(test)]
mod tests;

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use thiserror::Error;

use crate::mesh::Mesh;
use collar::{Collar, median};
use labels::{LabelCosts, labels};
use network::{CreaseLine, Network, ends};
pub(crate) use rings::without_rings;
use segment::Sides;

/// Why no creases are continued across a hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub(crate) enum Declined {
    /// The rim is not one loop of edges with one face each.
    #[error("the rim is not a simple loop")]
    Rim,
    /// There is no smooth side at the rim.
    #[error("no smooth side comes to the rim")]
    NoSide,
    /// The rim lies off the sheets of its edges.
    #[error("the rim does not lie on smooth sides")]
    RimOff,
    /// All of the rim is on one side, and runs along no crease.
    #[error("one side")]
    OneSide,
    /// Two sides meet at too small an angle for a crease.
    #[error("sides join smoothly")]
    Smooth,
    /// Two sides face each other.
    #[error("sides fold back")]
    Folds,
    /// More than three sides meet.
    #[error("{0} sides meet")]
    Arcs(usize),
    /// Three sheets meet nowhere near.
    #[error("no corner")]
    NoCorner,
    /// A crease ends beside its rim vertex.
    #[error("a crease ends beside the rim")]
    EndOffCrease,
    /// Two sheets meet nowhere between two ends.
    #[error("sides do not meet")]
    NoCrease,
    /// A crease makes a detour.
    #[error("a crease is too long")]
    LongCrease,
    /// A part turns too far to be unrolled.
    #[error("a part turns too far")]
    Turns,
    /// A part is turned round.
    #[error("a part is reversed")]
    Reversed,
    /// A part meets itself.
    #[error("a part crosses itself")]
    Crosses,
    /// A part is too large for the edges at the rim.
    #[error("a part is too large")]
    TooLarge,
    /// Two parts have the same edge, or one of the mesh.
    #[error("parts are not joined to a manifold")]
    NotManifold,
}

impl Declined {
    /// Whether other ends of the creases may be better.
    fn may_shift(self) -> bool {
        matches!(self, Self::Crosses | Self::NotManifold | Self::Reversed)
    }
}

/// A patch with creases.
#[derive(Clone, Debug)]
pub(crate) struct Continued {
    /// Positions of its own vertices, numbered behind those of the mesh.
    pub(crate) positions: Vec<DVec3>,
    pub(crate) faces: Vec<[u32; 3]>,
    pub(crate) creases: Vec<Crease>,
    /// The largest residual of the sheets of its parts, in edges.
    pub(crate) residual: f64,
}

/// A crease across a hole.
#[derive(Clone, Debug)]
pub(crate) struct Crease {
    /// Its length in the mesh's units.
    pub(crate) length: f64,
    /// Mean angle between the normals of both sides along it, in degrees.
    pub(crate) angle: f64,
}

/// The thresholds for a kind of mesh.
#[derive(Clone, Copy, Debug)]
struct Limits {
    labels: LabelCosts,
    /// Largest and median distance of rim vertices from the nearer sheet of their edges, in edges.
    rim: [f64; 2],
}

/// For meshes whose sides are exact and whose creases are edges.
const CLEAN: Limits = Limits {
    labels: LabelCosts {
        tolerance: 0.12,
        beyond: 0.3,
        change: 2.0,
        ring: 1,
    },
    rim: [0.15, 0.03],
};
/// For scans, in which creases are bevelled by half a face and positions are noisy.
const SCAN: Limits = Limits {
    labels: LabelCosts {
        tolerance: 0.25,
        beyond: 0.15,
        change: 4.0,
        ring: 2,
    },
    rim: [0.9, 0.2],
};
/// A mesh is clean when less than this part of the collar's faces is in no sheet,
const MOST_FREE: f64 = 0.02;
/// and the median residual of sheets is less than this, in edges.
const MOST_NOISE: f64 = 0.03;
/// Sides that meet at a smaller angle than this, in degrees, have no crease between them;
const CREASE: f64 = 28.0;
/// but of one crease with two ends the larger angle is at least the first, and the other at least the second: it may fade.
const FADING: [f64; 2] = [25.0, 6.0];
/// and at a larger angle than this they fold back.
const FOLD: f64 = 150.0;
/// A rim runs along a crease where this part of its length does.
const ALONG: f64 = 0.1;
/// Where creases begin inside the hole, in edges from the rim: tried in turn.
const LEADS: [f64; 4] = [0.3, 0.6, 1.0, 1.5];
/// Most combinations of shifted ends.
const MOST_SHIFTS: usize = 60;

/// Continues the creases that end at a rim, or keeps to the one side of a rim that runs along creases.
pub(crate) fn continue_creases(mesh: &Mesh, rim: &[u32]) -> Result<Continued, Declined> {
    let collar = Collar::new(mesh, rim).ok_or(Declined::Rim)?;
    let sides = Sides::new(&collar);
    let is_exact = sides.free() < MOST_FREE && sides.noise(collar.edge) < MOST_NOISE;
    let work = Work {
        collar: &collar,
        sides: &sides,
        limits: if is_exact { CLEAN } else { SCAN },
        taken: edges_between(mesh, rim),
        count: mesh.positions.len() as u32,
    };
    work.best()
}

/// Edges of a mesh between vertices of a rim.
fn edges_between(mesh: &Mesh, rim: &[u32]) -> HashSet<(u32, u32)> {
    let on_rim: HashSet<u32> = rim.iter().copied().collect();
    let sides = mesh
        .faces
        .iter()
        .flat_map(|f| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])]);
    sides
        .filter(|(a, b)| on_rim.contains(a) && on_rim.contains(b))
        .collect()
}

struct Work<'a> {
    collar: &'a Collar,
    sides: &'a Sides,
    limits: Limits,
    /// Directed edges of the mesh between vertices of the rim.
    taken: HashSet<(u32, u32)>,
    count: u32,
}

impl Work<'_> {
    /// The first valid patch, with ends of creases shifted along the rim as little as possible: on bevelled meshes the vertex at which a
    /// crease ends is not certain.
    fn best(&self) -> Result<Continued, Declined> {
        let labels =
            labels(self.collar, self.sides, &self.limits.labels).ok_or(Declined::NoSide)?;
        let ends = ends(&labels);
        let mut first = None;
        for (at, shifts) in shifts(ends.len()).iter().enumerate() {
            let Some(labels) = shifted(&labels, &ends, shifts) else {
                continue;
            };
            for lead in LEADS {
                match self.patch(&labels, lead) {
                    Ok(patch) => return Ok(patch),
                    Err(why) => {
                        first.get_or_insert(why);
                        if !why.may_shift() {
                            if at == 0 {
                                return Err(why);
                            }
                            break;
                        }
                    }
                }
            }
        }
        Err(first.unwrap_or(Declined::NoSide))
    }

    fn patch(&self, labels: &[usize], lead: f64) -> Result<Continued, Declined> {
        self.check_rim(labels)?;
        self.check_angles(labels)?;
        let network = Network::new(self.collar, self.sides, labels, lead)?;
        let rim = self.collar.rim.len();
        let mut points = network.points.clone();
        let mut faces = Vec::new();
        for part in network.parts.iter().filter(|p| p.outline.len() >= 3) {
            let outline: Vec<DVec3> = part.outline.iter().map(|&i| network.points[i]).collect();
            let sheet = &self.sides.list[part.side].sheet;
            let done = parts::triangulate(self.collar, sheet, &outline)?;
            let first = points.len();
            let number = |i: usize| match part.outline.get(i) {
                Some(point) => *point,
                None => first + i - part.outline.len(),
            };
            faces.extend(done.faces.iter().map(|f| f.map(number)));
            points.extend(done.inner);
        }
        let number = |i: usize| match self.collar.rim.get(i) {
            Some(v) => *v,
            None => self.count + (i - rim) as u32,
        };
        let faces: Vec<[u32; 3]> = faces.iter().map(|f| f.map(number)).collect();
        self.check_joined(&faces)?;
        let residuals = network.parts.iter().map(|p| &self.sides.list[p.side].sheet);
        let residuals = residuals.map(|sheet| sheet.residual / self.collar.edge);
        let of_line = |line: &CreaseLine| {
            let at = line.points.iter().map(|&i| points[i]);
            let at: Vec<DVec3> = at.collect();
            let angle = |p: &DVec3| self.angle(*p, line.sides);
            Crease {
                length: at.windows(2).map(|w| w[0].distance(w[1])).sum(),
                angle: at.iter().map(angle).sum::<f64>() / at.len() as f64,
            }
        };
        Ok(Continued {
            positions: points[rim..]
                .iter()
                .map(|p| *p + self.collar.origin)
                .collect(),
            faces,
            creases: network.lines.iter().map(of_line).collect(),
            residual: residuals.fold(0.0, f64::max),
        })
    }

    /// Whether the rim lies on the sheets of its edges.
    fn check_rim(&self, labels: &[usize]) -> Result<(), Declined> {
        let count = labels.len();
        let off = |i: usize| {
            let of = |side: usize| {
                self.sides.list[side]
                    .sheet
                    .distance(self.collar.rim_point(i))
                    .abs()
            };
            of(labels[i]).min(of(labels[(i + count - 1) % count])) / self.collar.edge
        };
        let mut off: Vec<f64> = (0..count).map(off).collect();
        let largest = off.iter().copied().fold(0.0, f64::max);
        match largest <= self.limits.rim[0] && median(&mut off) <= self.limits.rim[1] {
            true => Ok(()),
            false => Err(Declined::RimOff),
        }
    }

    /// Whether sides meet at such angles that there are creases between them.
    fn check_angles(&self, labels: &[usize]) -> Result<(), Declined> {
        let ends = ends(labels);
        if ends.is_empty() {
            return self.check_along(labels[0]);
        }
        let count = labels.len();
        let angle = |&i: &usize| {
            let sides = [labels[i], labels[(i + count - 1) % count]];
            self.angle(self.collar.rim_point(i), sides)
        };
        let angles: Vec<f64> = ends.iter().map(angle).collect();
        let least = angles.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = angles.iter().copied().fold(0.0, f64::max);
        let may_fade = ends.len() == 2;
        let fewest = if may_fade { FADING[1] } else { CREASE };
        if largest > FOLD {
            return Err(Declined::Folds);
        }
        match least >= fewest && largest >= FADING[0] {
            true => Ok(()),
            false => Err(Declined::Smooth),
        }
    }

    /// The angle between the normals of two sides at a point, in degrees.
    fn angle(&self, point: DVec3, sides: [usize; 2]) -> f64 {
        let [a, b] = sides.map(|s| self.sides.list[s].sheet.normal(point));
        a.dot(b).clamp(-1.0, 1.0).acos().to_degrees()
    }

    /// Whether a rim with one side runs along a crease.
    fn check_along(&self, side: usize) -> Result<(), Declined> {
        let (collar, count) = (self.collar, self.collar.rim.len());
        let sheet = &self.sides.list[side].sheet;
        let (mut along, mut all) = (0.0, 0.0);
        for i in 0..count {
            let (p, q) = (collar.rim_point(i), collar.rim_point(i + 1));
            let beyond = collar.smoothed[collar.beyond[i] as usize];
            all += p.distance(q);
            if sheet.normal(p).dot(beyond) < CREASE.to_radians().cos() {
                along += p.distance(q);
            }
        }
        match along >= ALONG * all {
            true => Ok(()),
            false => Err(Declined::OneSide),
        }
    }

    /// Whether the faces use each edge of the rim once, and no edge twice.
    fn check_joined(&self, faces: &[[u32; 3]]) -> Result<(), Declined> {
        let mut edges: HashMap<(u32, u32), ()> = HashMap::with_capacity(3 * faces.len());
        for f in faces {
            for (a, b) in [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])] {
                if edges.insert((a, b), ()).is_some() || self.taken.contains(&(a, b)) {
                    return Err(Declined::NotManifold);
                }
            }
        }
        let rim = &self.collar.rim;
        let on_rim: HashSet<(u32, u32)> = (0..rim.len())
            .map(|i| (rim[i], rim[(i + 1) % rim.len()]))
            .collect();
        let is_right = |&(a, b): &(u32, u32)| match on_rim.contains(&(a, b)) {
            true => !edges.contains_key(&(b, a)),
            // The other side of an inner edge is the patch's, and the mesh has no such edge.
            false => edges.contains_key(&(b, a)) && !self.taken.contains(&(b, a)),
        };
        let has_all = on_rim.iter().all(|edge| edges.contains_key(edge));
        match has_all && edges.keys().all(is_right) {
            true => Ok(()),
            false => Err(Declined::NotManifold),
        }
    }
}

/// The ways in which so many ends are shifted along the rim, by up to two vertices; fewer the more ends there are. The least shifts first.
fn shifts(ends: usize) -> Vec<Vec<i32>> {
    let most = match ends {
        0..=3 => 2,
        4..=6 => 1,
        _ => 0,
    };
    let mut all: Vec<Vec<i32>> = vec![Vec::new()];
    for _ in 0..ends {
        let longer = |d: &Vec<i32>| {
            (-most..=most)
                .map(|x| [&d[..], &[x]].concat())
                .collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all.sort_by_key(|d| (d.iter().map(|x| x.abs()).sum::<i32>(), d.clone()));
    all.truncate(MOST_SHIFTS);
    all
}

/// Labels with their changes shifted; none where that loses or adds one.
fn shifted(labels: &[usize], at: &[usize], shifts: &[i32]) -> Option<Vec<usize>> {
    let count = labels.len();
    let mut all = labels.to_vec();
    for (&i, &shift) in at.iter().zip(shifts) {
        let (before, own) = (labels[(i + count - 1) % count], labels[i]);
        let distance = shift.unsigned_abs() as usize;
        for k in 0..distance.min(count) {
            match shift > 0 {
                true => all[(i + k) % count] = before,
                false => all[(i + count - 1 - k) % count] = own,
            }
        }
    }
    (ends(&all).len() == at.len()).then_some(all)
}
