//! On which side of a surface the nodes of a lattice lie.
//!
//! Along a row of nodes the winding number changes by one where the row passes through a face, and off the surface by as
//! much as the rims of an open mesh let it. So it is carried along, and measured only where it is in doubt.

use std::collections::HashMap;
use std::sync::OnceLock;

use glam::DVec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

use crate::mesh::{Mesh, Topology};
use crate::spatial::{Bvh, WindingTree};

/// How far the winding number may be off, since distant faces are summed up together.
pub(super) const WINDING_ERROR: f64 = 0.02;

/// Closer to the surface than this part of a voxel the winding number is on its jump.
const ON_SURFACE: f64 = 1e-3;

/// The winding numbers of nodes on rows along the first axis.
pub(super) struct Signs<'a> {
    mesh: &'a Mesh,
    bvh: &'a Bvh,
    voxel: f64,
    rims: Rims,
    /// Gathered when it is first asked for.
    winding: OnceLock<WindingTree>,
}

impl<'a> Signs<'a> {
    /// Prepares the signs at nodes that lie a voxel apart.
    pub fn new(mesh: &'a Mesh, topology: &Topology, bvh: &'a Bvh, voxel: f64) -> Self {
        Self {
            mesh,
            bvh,
            voxel,
            rims: Rims::new(mesh, topology),
            winding: OnceLock::new(),
        }
    }

    /// Gives the distances along a row their signs: negative where the magnitude of the winding number exceeds one half.
    /// The row starts outside the box round the mesh.
    pub fn row(&self, start: DVec3, distances: &mut [f64]) {
        let step = self.voxel * (1.0 + 1e-9);
        let mut jumps = self.jumps(start, distances.len()).into_iter().peekable();
        // The winding number and by how much it may be off.
        let mut known = self.rims.are_none().then_some((0.0, 0.0));
        for (i, value) in distances.iter_mut().enumerate() {
            let mut jump = 0.0;
            while let Some((_, by)) = jumps.next_if(|(at, _)| *at <= i) {
                jump += by;
            }
            let p = self.node(start, i);
            let change = match known {
                Some(_) => self.rims.rate(p, step) * step,
                None => 0.0,
            };
            let carried = known
                .map(|(winding, error)| (winding + jump, error + change))
                .filter(|(winding, error)| (winding.abs() - 0.5).abs() > *error);
            let (winding, error) = carried.unwrap_or_else(|| (self.measured(p), WINDING_ERROR));
            let is_lasting = carried.is_some() || *value > ON_SURFACE * self.voxel;
            known = is_lasting.then_some((winding, error));
            if winding.abs() > 0.5 {
                *value = -*value;
            }
        }
    }

    fn measured(&self, p: DVec3) -> f64 {
        let tree = self.winding.get_or_init(|| WindingTree::new(self.bvh));
        tree.winding_number(self.bvh, p)
    }

    fn node(&self, start: DVec3, i: usize) -> DVec3 {
        super::node(start, i, self.voxel)
    }

    /// Where a row passes through faces: the first node behind, and by how much the winding number changes, in order.
    fn jumps(&self, start: DVec3, count: usize) -> Vec<(usize, f64)> {
        let mut jumps = Vec::new();
        let end = self.node(start, count);
        self.bvh.for_each_in_box(start, end, |face| {
            let corners = self.mesh.corners(face);
            let around = turns(corners, start);
            if around != 0 {
                jumps.push((
                    self.first_behind(corners, around, start, count),
                    -f64::from(around),
                ));
            }
        });
        jumps.sort_unstable_by_key(|(at, _)| *at);
        jumps
    }

    /// The first node on the far side of a triangle that the row passes through, exactly; `count` if there is none.
    fn first_behind(&self, corners: [DVec3; 3], around: i32, start: DVec3, count: usize) -> usize {
        let [a, b, c] = corners;
        let is_behind = |i: usize| {
            let [a, b, c, p] = [a, b, c, self.node(start, i)].map(coord3);
            // Positive below a triangle that is seen counter-clockwise from above.
            orient3d(a, b, c, p) * f64::from(around) < 0.0
        };
        let normal = (b - a).cross(c - a);
        let x = a.x - (normal.y * (start.y - a.y) + normal.z * (start.z - a.z)) / normal.x;
        let (low, high) = (a.min(b).min(c).x, a.max(b).max(c).x);
        let guess = (x.max(low).min(high) - start.x) / self.voxel;
        let mut i = (guess.ceil() as usize).min(count);
        while i > 0 && is_behind(i - 1) {
            i -= 1;
        }
        while i < count && !is_behind(i) {
            i += 1;
        }
        i
    }
}

/// How often a triangle, seen along the first axis from its far end, runs round a point counter-clockwise: −1, 0 or 1.
///
/// Exact, and an edge belongs to one of two triangles beside it, so that no passage through a surface is lost or counted
/// twice (Hormann and Agathos, "The point in polygon problem for arbitrary polygons", 2001).
fn turns(corners: [DVec3; 3], p: DVec3) -> i32 {
    let mut turns = 0;
    for k in 0..3 {
        let (u, v) = (corners[k], corners[(k + 1) % 3]);
        let side = || orient2d(coord2(u), coord2(v), coord2(p));
        if u.z <= p.z && v.z > p.z && side() > 0.0 {
            turns += 1;
        } else if v.z <= p.z && u.z > p.z && side() < 0.0 {
            turns -= 1;
        }
    }
    turns
}

fn coord2(p: DVec3) -> Coord<f64> {
    Coord { x: p.y, y: p.z }
}

fn coord3(p: DVec3) -> Coord3D<f64> {
    Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    }
}

/// The rims of a mesh, in groups, to bound how fast the winding number changes off the surface.
///
/// Its gradient is that of the solid angle of the rims, at most `L / (4 π d²)` at the distance `d` from a rim of length
/// `L` (the law of Biot and Savart).
struct Rims {
    /// Bounding box and length of each group.
    groups: Vec<(DVec3, DVec3, f64)>,
    /// Whether there are edges besides at which the winding number has a source.
    unknown: bool,
}

impl Rims {
    /// The most groups that are told apart.
    const MOST: usize = 48;

    fn new(mesh: &Mesh, topology: &Topology) -> Self {
        let defects = &topology.defects;
        let mut groups: Vec<(DVec3, DVec3, f64)> = Vec::new();
        let mut of_vertex: HashMap<u32, usize> = HashMap::new();
        for h in (0..topology.boundary.len()).filter(|h| topology.boundary[*h]) {
            let face = mesh.faces[h / 3];
            let ends = [face[h % 3], face[(h + 1) % 3]];
            let [a, b] = ends.map(|v| mesh.positions[v as usize]);
            let known = ends.iter().find_map(|v| of_vertex.get(v).copied());
            let group = known.unwrap_or_else(|| {
                groups.push((a, a, 0.0));
                groups.len() - 1
            });
            ends.iter().for_each(|v| {
                of_vertex.insert(*v, group);
            });
            let (low, high, length) = &mut groups[group];
            (*low, *high) = (low.min(a).min(b), high.max(a).max(b));
            *length += a.distance(b);
        }
        Self {
            groups: merged(groups, Self::MOST),
            unknown: defects.non_manifold_edges > 0 || defects.misoriented_edges > 0,
        }
    }

    /// Whether there is nothing that changes the winding number off the surface.
    fn are_none(&self) -> bool {
        self.groups.is_empty() && !self.unknown
    }

    /// The most that the winding number changes with the distance, within a step of a point.
    fn rate(&self, p: DVec3, step: f64) -> f64 {
        if self.unknown {
            return f64::INFINITY;
        }
        let one = |(low, high, length): &(DVec3, DVec3, f64)| {
            let distance = p.distance(p.clamp(*low, *high)) - step;
            match distance > 0.0 {
                true => length / (4.0 * std::f64::consts::PI * distance * distance),
                false => f64::INFINITY,
            }
        };
        self.groups.iter().map(one).sum()
    }
}

/// Joins groups whose boxes meet, then all, if there are more than so many.
fn merged(groups: Vec<(DVec3, DVec3, f64)>, most: usize) -> Vec<(DVec3, DVec3, f64)> {
    let join = |a: &mut (DVec3, DVec3, f64), b: &(DVec3, DVec3, f64)| {
        *a = (a.0.min(b.0), a.1.max(b.1), a.2 + b.2);
    };
    let mut out: Vec<(DVec3, DVec3, f64)> = Vec::new();
    for group in groups {
        let meets = |o: &(DVec3, DVec3, f64)| o.0.cmple(group.1).all() && group.0.cmple(o.1).all();
        match out.iter().position(meets) {
            Some(other) => join(&mut out[other], &group),
            None if out.len() < most => out.push(group),
            None => join(&mut out[most - 1], &group),
        }
    }
    out
}
