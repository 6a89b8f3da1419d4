//! Rims that the missing flat side of a body leaves: they lie in one plane, and the walls that end at them stand on it steeply and
//! straight. They get flat caps; a rim inside another one of the same plane bounds a hole of that one's cap.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::Inspection;
use crate::fill::{FEW_EDGES, FillParams};
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{Hole, face_normal};
use crate::spatial::{Bounds, BoxTree};
use crate::tuning::{Tunable, tunable};

/// Diameters of a rim. A rim whose vertices deviate less from a plane is planar: twenty units in the last place of 32-bit
/// floats at ten diameters from the origin.
const PLANAR_RIM: Tunable<f64> = tunable("fill.planar_rim", 3e-5);

/// Mean edges of a rim. A rim whose vertices deviate less from a plane is planar too. Boxes, cylinders and rings without their bottom,
/// with noise up to a hundredth of an edge, get flat ones.
const NOISY_RIM: Tunable<f64> = tunable("fill.noisy_rim", 0.03);

/// Diameters of a rim, at most, of such noise: a rim of few long edges is not planar by them.
const NOISY_RIM_MOST: Tunable<f64> = tunable("fill.noisy_rim_most", 2e-3);

/// Cosine. Walls whose normals are at least this far from a rim's normal stand steeply on its plane (53°).
const STEEP: Tunable<f64> = tunable("fill.steep", 0.6);

/// Cosine. Faces whose normals are farther than this from a rim's normal leave its plane (18°): a plane cut through a body.
const LEAVING: Tunable<f64> = tunable("fill.leaving", 0.95);

/// Cosine. The normals of straight walls differ by less than this in their angle with the rim's normal. On a ball that was
/// cut through its middle they differ by 0.5 within `WALL_DEPTH`.
const STRAIGHT: Tunable<f64> = tunable("fill.straight", 0.03);

/// Cosine per mean edge of a rim. Noise of the rim tilts the faces of its walls, which are straight still if their normals differ by
/// less than this times the deviation of the rim from its plane.
const TILT_OF_NOISE: Tunable<f64> = tunable("fill.tilt_of_noise", 16.0);

/// Cosine. Upper bound of such a difference.
const MOST_TILT_OF_NOISE: Tunable<f64> = tunable("fill.most_tilt_of_noise", 0.15);

/// Cosine. A wall ends at edges with larger dihedral angles (50°): a prism of eight sides has 45° between its sides and 90°
/// at its bottom, a coarse ball of 80 faces 36°.
const WALL_EDGE: Tunable<f64> = tunable("fill.wall_edge", 0.64);

/// Distance between the planes of two parallel rims, one round the other, over the distance between the rims. If it is less, a flat
/// ring joins them: the slope of 1 in 4 of a chamfered rim of a stove, which became a bowl.
const RING_SLOPE: Tunable<f64> = tunable("fill.ring_slope", 0.25);

/// Diameters of a rim. The depth to which its walls are looked at.
const WALL_DEPTH: Tunable<f64> = tunable("fill.wall_depth", 0.35);

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
    let has_few_edges = |h: usize| found.holes[h].edges <= FEW_EDGES.get();
    let is_planar = |h: &Hole| h.height <= noise(h) && h.normal != DVec3::ZERO;
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
        let apart = (b.centre - a.centre).dot(a.normal).abs();
        let is_same = apart <= noise(a).max(noise(b));
        let is_parallel = |cosine: f64| cosine > 1.0 - PLANAR_RIM.get();
        let cosine = a.normal.dot(b.normal);
        // A ring whose inner rim is a little higher or lower than its outer one.
        let is_ring = || {
            let may_be_flat = apart <= RING_SLOPE.get() * (a.diameter - b.diameter).abs();
            is_parallel(-cosine) && may_be_flat && !is_steep_between(found, a, b, apart)
        };
        is_same && is_parallel(cosine.abs()) || is_ring()
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

/// Whether vertices of two rims, whose planes are so far apart, are too near to each other for a flat ring.
fn is_steep_between(found: &Inspection, a: &Hole, b: &Hole, apart: f64) -> bool {
    let at = |v: u32| found.mesh.positions[v as usize];
    let points: Vec<Bounds> = b.rim.iter().map(|v| Bounds::of_ball(at(*v), 0.0)).collect();
    let tree = BoxTree::new(&points);
    // Twice the distance that decides, which rounding does not reach.
    let reach = 2.0 * apart / RING_SLOPE.get();
    a.rim.iter().any(|&v| {
        let is_near = |w: u32| apart > RING_SLOPE.get() * at(v).distance(at(b.rim[w as usize]));
        tree.find(&Bounds::of_ball(at(v), reach), is_near).is_some()
    })
}

/// By how much the vertices of a planar rim may deviate from its plane.
fn noise(hole: &Hole) -> f64 {
    let edge = hole.length / hole.edges as f64;
    let noisy = (NOISY_RIM.get() * edge).min(NOISY_RIM_MOST.get() * hole.diameter);
    noisy.max(PLANAR_RIM.get() * hole.diameter)
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
    let (mesh, topology) = (&found.mesh, &found.topology);
    let tilt = |f: u32| face_normal(mesh, f).dot(hole.normal);
    let depth = |f: u32| {
        let corners = mesh.corners(f).into_iter();
        let heights = corners.map(|p| (hole.centre - p).dot(hole.normal).abs());
        heights.fold(f64::INFINITY, f64::min)
    };
    let leaving = seen.iter().filter(|f| tilt(**f).abs() <= LEAVING.get());
    let leave_plane = 4 * leaving.count() >= 3 * seen.len();
    if !seen.iter().all(|f| tilt(*f).abs() <= STEEP.get()) {
        return Walls {
            leave_plane,
            are_straight: false,
        };
    }
    let of_noise = TILT_OF_NOISE.get() * hole.height * hole.edges as f64 / hole.length;
    let spread = of_noise.clamp(STRAIGHT.get(), MOST_TILT_OF_NOISE.get());
    let mut known: HashSet<u32> = seen.iter().copied().collect();
    let mut next = 0;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    while let Some(&f) = seen.get(next) {
        next += 1;
        (low, high) = (low.min(tilt(f)), high.max(tilt(f)));
        if high - low > spread {
            break;
        }
        for h in 3 * f..3 * f + 3 {
            let o = topology.opposite[h as usize];
            if o == NONE {
                continue;
            }
            let g = o / 3;
            let is_smooth = face_normal(mesh, f).dot(face_normal(mesh, g)) > WALL_EDGE.get();
            if is_smooth && depth(g) < WALL_DEPTH.get() * hole.diameter && known.insert(g) {
                seen.push(g);
            }
        }
    }
    Walls {
        leave_plane,
        are_straight: high - low <= spread,
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
