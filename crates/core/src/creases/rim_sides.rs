//! The smooth sides around a rim: which side continues each rim edge, and where creases end at the rim.

use std::collections::BTreeSet;

use glam::DVec3;
use rustc_hash::FxHashSet;

use super::CreaseRefusal;
use super::collar::{Collar, median, rings};
use super::labels::{LabelCosts, labels};
use super::network::ends;
use super::segment::Sides;
use crate::cancel::Cancel;
use crate::elementary::{acos, cos};
use crate::mesh::{Mesh, VertexFaces};
use crate::tuning::{Tunable, tunable};

/// Thresholds for a kind of mesh.
#[derive(Clone, Copy, Debug)]
struct Limits {
    labels: LabelCosts,
    /// Whether a face may lie between two sides (a bevel).
    is_bevelled: bool,
    /// Maximum of the largest and of the median distance of rim vertices from the nearer sheet of their edges, in edges.
    rim: [f64; 2],
}

/// Thresholds for meshes with exact sides whose creases are edges.
const CLEAN: Limits = Limits {
    labels: LabelCosts {
        tolerance: 0.12,
        beyond: 0.3,
        change: 2.0,
        ring: 1,
    },
    is_bevelled: false,
    rim: [0.15, 0.03],
};
/// Thresholds for scans: creases are bevelled by half a face and positions are noisy.
const SCAN: Limits = Limits {
    labels: LabelCosts {
        tolerance: 0.25,
        beyond: 0.15,
        change: 4.0,
        ring: 2,
    },
    is_bevelled: true,
    rim: [0.9, 0.2],
};
/// A mesh is clean if less than this fraction of the collar's faces is on no sheet,
const MOST_FREE: Tunable<f64> = tunable("creases.rim_sides.most_free", 0.02);
/// and the median residual of sheets is below this, in edges.
const MOST_NOISE: Tunable<f64> = tunable("creases.rim_sides.most_noise", 0.03);
/// Minimum angle of a crease between two sides, in degrees.
const CREASE: Tunable<f64> = tunable("creases.rim_sides.crease", 28.0);
/// Exception for a crease with two ends, which may fade: minimum of the larger and of the smaller angle at its ends, in degrees.
const FADING: [f64; 2] = [25.0, 6.0];
/// Sides that meet at more than this angle fold back, in degrees.
const FOLD: Tunable<f64> = tunable("creases.rim_sides.fold", 150.0);
/// At the end of a crease the residuals of both sides are below this, in edges,
const MOST_NOISE_OF_END: Tunable<f64> = tunable("creases.rim_sides.most_noise_of_end", 0.1);
/// and the chain of vertices where they meet is longer than this, in edges.
const LEAST_CHAIN: Tunable<f64> = tunable("creases.rim_sides.least_chain", 2.5);
/// A rim runs along a crease if at least this fraction of its length does.
const ALONG: Tunable<f64> = tunable("creases.rim_sides.along", 0.1);

/// A rim vertex at which a crease of the mesh ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SharpEnd {
    /// Vertex of the rim.
    pub(crate) vertex: u32,
    /// Angle between the normals of the two sides, in degrees.
    pub(crate) angle: f64,
}

/// A rim with the smooth sides around it.
pub(crate) struct RimSides {
    pub(super) collar: Collar,
    pub(super) sides: Sides,
    limits: Limits,
    /// For each edge of the rim, the side that continues it.
    pub(super) labels: Vec<usize>,
    /// Directed edges of the mesh between vertices of the rim.
    pub(super) taken: FxHashSet<(u32, u32)>,
}

impl RimSides {
    /// Finds the sides around a rim of a mesh; once the token is set, only some of them.
    pub(crate) fn new(
        mesh: &Mesh,
        around: &VertexFaces,
        rim: &[u32],
        cancel: &Cancel,
    ) -> Result<Self, CreaseRefusal> {
        let collar = Collar::new(mesh, around, rim, rings, cancel).ok_or(CreaseRefusal::Rim)?;
        let sides = Sides::new(&collar).ok_or(CreaseRefusal::ManySides)?;
        let is_exact =
            sides.free() < MOST_FREE.get() && sides.noise(collar.edge) < MOST_NOISE.get();
        let limits = if is_exact { CLEAN } else { SCAN };
        let labels = labels(&collar, &sides, &limits.labels).ok_or(CreaseRefusal::NoSide)?;
        Ok(Self {
            collar,
            sides,
            limits,
            labels,
            taken: edges_between(mesh, around, rim),
        })
    }

    /// Median residual of the sides' sheets, in edges.
    pub(crate) fn noise(&self) -> f64 {
        self.sides.noise(self.collar.edge)
    }

    /// On exact meshes, adds kriged residuals to the sheets of the sides at the rim; returns whether there were any. Not on
    /// scans: vertices at bevelled edges and noise would be taken for shape, and errors on 67 holes were three times as large.
    pub(crate) fn refine(&mut self) -> bool {
        if self.limits.is_bevelled {
            return false;
        }
        let at_rim: BTreeSet<usize> = self.labels.iter().copied().collect();
        let refined = at_rim
            .iter()
            .map(|&side| self.sides.refine(side, &self.collar));
        // `count` and not `any`, so that all of them are refined.
        refined.filter(|is_refined| *is_refined).count() > 0
    }

    /// Where creases end at the rim; empty if the rim is not on the sides.
    pub(crate) fn ends(&self) -> Vec<SharpEnd> {
        if self.check_rim(&self.labels).is_err() {
            return Vec::new();
        }
        let end = |i: usize| SharpEnd {
            vertex: self.collar.rim[i],
            angle: self.angle_at(i, &self.labels),
        };
        let seen = |i: &usize| {
            (CREASE.get()..=FOLD.get()).contains(&self.angle_at(*i, &self.labels))
                && self.is_chain(*i)
        };
        let all = ends(&self.labels).into_iter().filter(seen);
        all.map(end).collect()
    }

    /// Whether a chain of vertices where the sides before and after a rim vertex meet leads away from that vertex.
    fn is_chain(&self, at: usize) -> bool {
        let count = self.labels.len();
        let [a, b] = [self.labels[(at + count - 1) % count], self.labels[at]];
        let is_exact = |s: usize| {
            self.sides.list[s].sheet.residual < MOST_NOISE_OF_END.get() * self.collar.edge
        };
        let is_between = |v: u32| {
            let meets = |f: u32| {
                let side = self.sides.of_face[f as usize];
                [side == a, side == b]
            };
            let faces = self.collar.around(v).iter();
            let met = match self.limits.is_bevelled {
                false => faces.map(|&f| meets(f)).fold([false; 2], either),
                // There may be a face between the sides.
                true => faces
                    .flat_map(|&f| self.collar.corners_of(f))
                    .flat_map(|w| self.collar.around(w))
                    .map(|&f| meets(f))
                    .fold([false; 2], either),
            };
            met == [true; 2]
        };
        is_exact(a)
            && is_exact(b)
            && self.collar.reach(at, is_between) > LEAST_CHAIN.get() * self.collar.edge
    }

    /// Checks that creases can be continued between sides with these labels.
    pub(super) fn check(&self, labels: &[usize]) -> Result<(), CreaseRefusal> {
        self.check_rim(labels)?;
        self.check_angles(labels)
    }

    /// Checks that the rim is on the sheets of its edges.
    fn check_rim(&self, labels: &[usize]) -> Result<(), CreaseRefusal> {
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
            false => Err(CreaseRefusal::RimOff),
        }
    }

    /// Checks that sides meet at angles that give creases.
    fn check_angles(&self, labels: &[usize]) -> Result<(), CreaseRefusal> {
        let ends = ends(labels);
        if ends.is_empty() {
            return self.check_along(labels[0]);
        }
        let angles = ends.iter().map(|&i| self.angle_at(i, labels));
        let angles: Vec<f64> = angles.collect();
        if angles.iter().any(|angle| *angle > FOLD.get()) {
            return Err(CreaseRefusal::Folds);
        }
        // The stretches of the rim between consecutive ends. If the sides before and after a stretch are the same, one crease
        // joins its two ends and may fade.
        let count = ends.len();
        let side = |j: usize| labels[ends[j % count]];
        let mut is_sharp: Vec<bool> = angles.iter().map(|angle| *angle >= CREASE.get()).collect();
        for j in 0..count {
            let pair = [angles[j], angles[(j + 1) % count]];
            let [least, largest] = [pair[0].min(pair[1]), pair[0].max(pair[1])];
            let is_joined = side(j + count - 1) == side(j + 1);
            if is_joined && largest >= FADING[0] && least >= FADING[1] {
                is_sharp[j] = true;
                is_sharp[(j + 1) % count] = true;
            }
        }
        match is_sharp.iter().all(|is| *is) {
            true => Ok(()),
            false => Err(CreaseRefusal::Smooth),
        }
    }

    /// The angle between the normals of the sides before and after a rim vertex, in degrees.
    fn angle_at(&self, at: usize, labels: &[usize]) -> f64 {
        let count = labels.len();
        let sides = [labels[at], labels[(at + count - 1) % count]];
        self.angle(self.collar.rim_point(at), sides)
    }

    /// The angle between the normals of two sides at a point, in degrees.
    pub(super) fn angle(&self, point: DVec3, sides: [usize; 2]) -> f64 {
        let [a, b] = sides.map(|s| self.sides.list[s].sheet.normal(point));
        acos(a.dot(b).clamp(-1.0, 1.0)).to_degrees()
    }

    /// Checks that a rim with a single side runs along a crease or that the side is flat.
    fn check_along(&self, side: usize) -> Result<(), CreaseRefusal> {
        let (collar, count) = (&self.collar, self.collar.rim.len());
        let sheet = &self.sides.list[side].sheet;
        let (mut along, mut all) = (0.0, 0.0);
        for i in 0..count {
            let (p, q) = (collar.rim_point(i), collar.rim_point(i + 1));
            let beyond = collar.smoothed[collar.beyond[i] as usize];
            all += p.distance(q);
            if sheet.normal(p).dot(beyond) < cos(CREASE.get().to_radians()) {
                along += p.distance(q);
            }
        }
        match along >= ALONG.get() * all || sheet.is_plane() {
            true => Ok(()),
            false => Err(CreaseRefusal::OneSide),
        }
    }
}

fn either(a: [bool; 2], b: [bool; 2]) -> [bool; 2] {
    [a[0] || b[0], a[1] || b[1]]
}

/// Directed edges of the mesh between vertices of a rim.
fn edges_between(mesh: &Mesh, around: &VertexFaces, rim: &[u32]) -> FxHashSet<(u32, u32)> {
    let on_rim: FxHashSet<u32> = rim.iter().copied().collect();
    let faces = rim.iter().flat_map(|&v| around.of(v));
    let sides = faces.flat_map(|&f| {
        let f = mesh.faces[f as usize];
        [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])]
    });
    sides
        .filter(|(a, b)| on_rim.contains(a) && on_rim.contains(b))
        .collect()
}
