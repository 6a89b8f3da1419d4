//! Signs of the distances at lattice nodes, from the winding number along rows.
//!
//! Along a row the winding number changes by one at each face that the row passes through. Elsewhere it changes only
//! near the boundary edges of an open mesh, by a bounded amount. It is therefore carried from node to node, and
//! computed only where the carried value with its error does not decide the sign.

use std::collections::HashMap;
use std::sync::OnceLock;

use glam::DVec3;
use robust::orient3d;

use crate::mesh::{Mesh, Topology};
use crate::spatial::{Bvh, WindingTree, coord3, turns};

/// Error of the computed winding number, which sums distant faces with an expansion.
pub(super) const WINDING_ERROR: f64 = 0.02;

/// In voxels. Nodes closer to the surface are at the jump of the winding number; a value computed there is not carried
/// on.
const ON_SURFACE: f64 = 1e-3;

/// Computes winding numbers at nodes on rows along the x axis.
pub(super) struct Signs<'a> {
    mesh: &'a Mesh,
    bvh: &'a Bvh,
    voxel: f64,
    rims: Rims,
    /// Built on first use.
    winding: OnceLock<WindingTree>,
}

impl<'a> Signs<'a> {
    /// Prepares the signs for nodes with spacing `voxel`.
    pub fn new(mesh: &'a Mesh, topology: &Topology, bvh: &'a Bvh, voxel: f64) -> Self {
        Self {
            mesh,
            bvh,
            voxel,
            rims: Rims::new(mesh, topology),
            winding: OnceLock::new(),
        }
    }

    /// Makes the distances along a row negative where the magnitude of the winding number exceeds one half. The row
    /// starts outside the bounding box of the mesh.
    pub fn row(&self, start: DVec3, distances: &mut [f64]) {
        let step = self.voxel * (1.0 + 1e-9);
        let mut jumps = self.jumps(start, distances.len()).into_iter().peekable();
        // The winding number at the last node and the bound of its error; (0, 0) outside a closed mesh.
        let mut known = self.rims.is_empty().then_some((0.0, 0.0));
        for (i, value) in distances.iter_mut().enumerate() {
            // Jumps at the faces between the last node and this one.
            let mut jump = 0.0;
            while let Some((_, by)) = jumps.next_if(|(at, _)| *at <= i) {
                jump += by;
            }
            let p = self.node(start, i);
            // Bound of the continuous change within one step, which increases the error.
            let change = match known {
                Some(_) => self.rims.rate(p, step) * step,
                None => 0.0,
            };
            // The carried value counts only if its error leaves no doubt about the sign.
            let carried = known
                .map(|(winding, error)| (winding + jump, error + change))
                .filter(|(winding, error)| (winding.abs() - 0.5).abs() > *error);
            let (winding, error) = carried.unwrap_or_else(|| (self.measured(p), WINDING_ERROR));
            let is_reliable = carried.is_some() || *value > ON_SURFACE * self.voxel;
            known = is_reliable.then_some((winding, error));
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

    /// The faces that a row passes through: the first node behind each, and the change of the winding number, in order.
    fn jumps(&self, start: DVec3, count: usize) -> Vec<(usize, f64)> {
        let mut jumps = Vec::new();
        let end = self.node(start, count);
        self.bvh.for_each_in_box(start, end, |face| {
            let corners = self.mesh.corners(face);
            let around = turns(corners, start, 0);
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

    /// The first node behind a triangle that the row passes through, by exact predicates; `count` if there is none.
    fn first_behind(&self, corners: [DVec3; 3], around: i32, start: DVec3, count: usize) -> usize {
        let [a, b, c] = corners;
        let is_behind = |i: usize| {
            let [a, b, c, p] = [a, b, c, self.node(start, i)].map(coord3);
            // `orient3d` is positive for points below a triangle that is counter-clockwise seen from above.
            orient3d(a, b, c, p) * f64::from(around) < 0.0
        };
        // Guess from the plane of the triangle, corrected with the exact predicate.
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

/// The boundary edges of a mesh in groups, which bound the rate of change of the winding number off the surface.
///
/// The gradient of the winding number is at most `L / (4 π d²)` at distance `d` from boundary edges of total length `L`
/// (law of Biot and Savart).
struct Rims {
    /// Bounding box and total edge length of each group.
    groups: Vec<(DVec3, DVec3, f64)>,
    /// Whether non-manifold or misoriented edges also contribute, for which no bound is computed.
    unknown: bool,
}

impl Rims {
    /// Most groups.
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

    /// Whether the mesh is closed and consistently oriented, so that the winding number is constant off the surface.
    fn is_empty(&self) -> bool {
        self.groups.is_empty() && !self.unknown
    }

    /// Upper bound of the change of the winding number per unit length, within `step` of a point.
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

/// Joins groups whose boxes overlap, and all further groups beyond `most`.
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
