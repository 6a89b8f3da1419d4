//! Rims that the missing flat side of a body leaves: they lie in one plane, and the walls that end at them stand on it steeply and
//! straight. They get flat caps; a rim inside another one of the same plane bounds a hole of that one's cap.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::Inspection;
use crate::fill::FillParams;
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{Hole, face_normal};
use crate::tuning::tuning;

/// Groups of holes, as indices, that get one flat cap each: the outer rim first, then those inside it. Only `chosen` holes are
/// considered, and none that the caller bridges.
pub(super) fn planar_rims(
    found: &Inspection,
    params: &FillParams,
    chosen: &[usize],
) -> Vec<Vec<usize>> {
    if params.like.is_some() || !params.crease.is_empty() {
        return Vec::new();
    }
    let is_free = |h: &Hole| !params.bridges(&[h.id]) && !h.outer_boundary;
    let has_few_edges = |h: usize| found.holes[h].edges <= tuning().fill.few_edges;
    let is_planar =
        |h: &Hole| h.height <= tuning().fill.planar_rim * h.diameter && h.normal != DVec3::ZERO;
    let mut flat: Vec<usize> = chosen.to_vec();
    flat.retain(|&h| is_free(&found.holes[h]) && is_planar(&found.holes[h]));
    if flat.is_empty() {
        return Vec::new();
    }
    let at_rims = at_rims(found, &flat);
    let rims = flat.iter().zip(at_rims);
    let straight: Vec<Walls> = rims
        .map(|(&h, faces)| walls(found, &found.holes[h], faces))
        .collect();
    let coplanar = |a: usize, b: usize| {
        let (a, b) = (&found.holes[a], &found.holes[b]);
        let size = a.diameter.max(b.diameter);
        let apart = (b.centre - a.centre).dot(a.normal).abs();
        a.normal.dot(b.normal).abs() > 1.0 - tuning().fill.planar_rim
            && apart <= tuning().fill.planar_rim * size
    };
    // A plane cut through a body leaves several rims of it in one plane; one alone may be the rim of a round part that is to be
    // continued.
    let component = |i: usize| found.holes[flat[i]].component;
    let is_cut = |i: usize| {
        let others = (0..flat.len()).filter(|&j| j != i && component(j) == component(i));
        let leaves_plane = |j: usize| straight[j].leave_plane && !has_few_edges(flat[j]);
        let mut cut = others.filter(|&j| leaves_plane(j) && coplanar(flat[i], flat[j]));
        leaves_plane(i) && cut.next().is_some()
    };
    let own: Vec<usize> = (0..flat.len())
        .filter(|&i| straight[i].are_straight || is_cut(i))
        .map(|i| flat[i])
        .collect();
    let mut groups = nested(found, &own, &coplanar);
    // Triangles between its vertices close a rim of few edges, unless there are others inside it.
    groups.retain(|group| group.len() > 1 || !has_few_edges(group[0]));
    groups
}

/// Groups of rims of the same planes: each rim that winds the other way round joins the smallest one around it.
fn nested(
    found: &Inspection,
    rims: &[usize],
    coplanar: &dyn Fn(usize, usize) -> bool,
) -> Vec<Vec<usize>> {
    let hole = |i: usize| &found.holes[i];
    let encloses = |outer: usize, inner: usize| {
        let p = found.mesh.positions[hole(inner).rim[0] as usize];
        coplanar(outer, inner)
            && hole(outer).normal.dot(hole(inner).normal) < 0.0
            && hole(outer).diameter > hole(inner).diameter
            && winds_round(found, hole(outer), p)
    };
    let around: Vec<Option<usize>> = (rims.iter())
        .map(|&inner| {
            let outer = rims.iter().copied().filter(|&o| encloses(o, inner));
            outer.min_by(|a, b| hole(*a).diameter.total_cmp(&hole(*b).diameter))
        })
        .collect();
    let is_outer = |i: &usize| !around.contains(&None) || around[*i].is_none();
    (0..rims.len())
        .filter(is_outer)
        .map(|i| {
            let inner = (0..rims.len()).filter(|&j| around[j] == Some(rims[i]));
            [rims[i]]
                .into_iter()
                .chain(inner.map(|j| rims[j]))
                .collect()
        })
        .collect()
}

/// Whether a planar rim winds round a point of its plane: the sum of the angles that its edges subtend there.
fn winds_round(found: &Inspection, hole: &Hole, p: DVec3) -> bool {
    let at = |v: u32| found.mesh.positions[v as usize] - p;
    let next = hole.rim.iter().cycle().skip(1);
    let angle = |(a, b): (&u32, &u32)| {
        let (a, b) = (at(*a), at(*b));
        crate::elementary::atan2(a.cross(b).dot(hole.normal), a.dot(b))
    };
    hole.rim.iter().zip(next).map(angle).sum::<f64>().abs() > std::f64::consts::PI
}

/// The walls that end at a rim.
struct Walls {
    /// Whether most of their faces at the rim leave its plane.
    leave_plane: bool,
    /// Whether they are steep, and equally so down to a fraction of the rim's diameter, or to their next sharp edge.
    are_straight: bool,
}

/// The walls at a rim, found from the faces that have an edge on it.
fn walls(found: &Inspection, hole: &Hole, mut seen: Vec<u32>) -> Walls {
    let rules = &tuning().fill;
    let (mesh, topology) = (&found.mesh, &found.topology);
    let tilt = |f: u32| face_normal(mesh, f).dot(hole.normal);
    let depth = |f: u32| {
        let corners = mesh.corners(f).into_iter();
        let heights = corners.map(|p| (hole.centre - p).dot(hole.normal).abs());
        heights.fold(f64::INFINITY, f64::min)
    };
    let leaving = seen.iter().filter(|f| tilt(**f).abs() <= rules.leaving);
    let leave_plane = 4 * leaving.count() >= 3 * seen.len();
    if !seen.iter().all(|f| tilt(*f).abs() <= rules.steep) {
        return Walls {
            leave_plane,
            are_straight: false,
        };
    }
    let mut known: HashSet<u32> = seen.iter().copied().collect();
    let mut next = 0;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    while let Some(&f) = seen.get(next) {
        next += 1;
        (low, high) = (low.min(tilt(f)), high.max(tilt(f)));
        if high - low > rules.straight {
            break;
        }
        for h in 3 * f..3 * f + 3 {
            let o = topology.opposite[h as usize];
            if o == NONE {
                continue;
            }
            let g = o / 3;
            let is_smooth = face_normal(mesh, f).dot(face_normal(mesh, g)) > rules.wall_edge;
            if is_smooth && depth(g) < rules.wall_depth * hole.diameter && known.insert(g) {
                seen.push(g);
            }
        }
    }
    Walls {
        leave_plane,
        are_straight: high - low <= rules.straight,
    }
}

/// For each of some holes the faces with an edge on its rim.
fn at_rims(found: &Inspection, holes: &[usize]) -> Vec<Vec<u32>> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let mut of_edge: HashMap<(u32, u32), usize> = HashMap::new();
    for (i, &h) in holes.iter().enumerate() {
        let rim = &found.holes[h].rim;
        let next = rim.iter().cycle().skip(1);
        of_edge.extend(rim.iter().zip(next).map(|(v, w)| ((*v, *w), i)));
    }
    let mut faces = vec![Vec::new(); holes.len()];
    let half_edges = (0..topology.boundary.len() as u32).filter(|h| topology.boundary[*h as usize]);
    for h in half_edges {
        // A rim runs against the mesh's own edges.
        if let Some(&i) = of_edge.get(&(end(mesh, h), start(mesh, h))) {
            faces[i].push(h / 3);
        }
    }
    faces
}
