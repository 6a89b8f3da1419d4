//! Which separated regions are inner skins: those whose openings are pinholes, or that are closed and parallel to the outer skin.

use std::collections::{BTreeMap, VecDeque};

use glam::DVec3;

use super::InnerSkins;
use super::group::SkinGroup;
use super::thickness::even_distance;
use crate::mesh::DisjointSets;
use crate::mesh::cut::without_spikes;
use crate::mesh::topology::{NONE, end, start};
use crate::tuning::{Tunable, tunable};

/// Fraction of the remaining area that must have an inner skin behind it. Double skins had 0.7 and more; a torus whose ring
/// the ball does not enter had a third.
const COVERED: Tunable<f64> = tunable("solid.covered", 0.4);

/// Fraction of the thickness by which the distance of parallel skins varies.
const CONSTANT: Tunable<f64> = tunable("solid.constant", 0.25);

/// Fraction of the area of a closed inner skin that is at this constant distance; else it bounds a cavity.
const CONSTANT_PART: Tunable<f64> = tunable("solid.constant_part", 0.7);

/// Diagonals of the body's bounding box. A closed inner skin farther than this from the outer one bounds a cavity.
const THIN: Tunable<f64> = tunable("solid.thin", 0.08);

/// Thicknesses. Largest radius of a pinhole along its longer side. Two that overlap had up to 2.6.
const OPENING: Tunable<f64> = tunable("solid.opening", 3.0);

/// Fraction of an inner skin's area that its pinholes have in all, at most. A bore has a quarter at twice its width.
const CAPS: Tunable<f64> = tunable("solid.caps", 0.15);

/// Fraction of an inner skin's area that must have the outer skin on its other side at a constant distance.
const SKIN_PART: Tunable<f64> = tunable("solid.skin_part", 0.5);

/// Cosine. The outer skin is a tube along the axis of an opening where its normals are perpendicular to the axis within this
/// (20°).
const TUBE: Tunable<f64> = tunable("solid.tube", 0.35);

/// Fraction of the outer skin's area round an opening that is such a tube at a mouth.
const TUBE_PART: Tunable<f64> = tunable("solid.tube_part", 0.7);

/// The smaller over the larger second moment of the normals across the axis: one for a round tube, zero for the two sides of
/// a thin edge. A mouth has at least this.
const ROUND: Tunable<f64> = tunable("solid.round", 0.3);

/// Thicknesses. Width of the outer skin round an opening whose normals count.
const BESIDE: Tunable<f64> = tunable("solid.beside", 1.5);

/// Thicknesses. Largest distance from a ring at which faces belong to a pinhole's neck: the lip round it is half a circle of the
/// diameter of one thickness, so that it ends at 0.7.
const NECK: Tunable<f64> = tunable("solid.neck", 1.4);

/// Cosine. Faces whose other side is parallel within this angle (14°), and at the thickness, belong to no neck.
const NECK_PARALLEL: Tunable<f64> = tunable("solid.neck_parallel", 0.97);

/// Fraction of the thickness by which the other side of such faces may be nearer or farther.
const NECK_CONSTANT: Tunable<f64> = tunable("solid.neck_constant", 0.1);

/// Rings of faces beside a neck that are removed with it. With two, small bodies lost up to 4.3 % of the outer skin.
const NECK_RINGS: Tunable<usize> = tunable("solid.neck_rings", 1);

/// A connected set of separated faces.
struct SkinRegion {
    faces: Vec<u32>,
    openings: Vec<Opening>,
}

/// A ring of edges between a region and the faces round it.
struct Opening {
    /// The half-edges of the region's faces.
    ring: Vec<u32>,
    /// The mean of the edges' midpoints.
    centre: DVec3,
    /// The largest distance of a midpoint from the centre, in mesh units.
    radius: f64,
    /// The vector area of a cap, outward, in squared mesh units.
    vector: DVec3,
}

/// The separated regions that are inner skins, with the necks of their pinholes.
pub(super) fn inner_skins(group: &SkinGroup, separated: &[bool]) -> InnerSkins {
    let mut skins = InnerSkins {
        removed: vec![false; separated.len()],
        ..InnerSkins::default()
    };
    let mut rings: Vec<u32> = Vec::new();
    for region in regions(group, separated) {
        let accepted = match region.openings.is_empty() {
            true => is_parallel(group, &region),
            false => is_behind_pinholes(group, &region, separated),
        };
        if accepted {
            region
                .faces
                .iter()
                .for_each(|f| skins.removed[*f as usize] = true);
            skins.skins += 1;
            skins.pinholes += region.openings.len();
            rings.extend(region.openings.iter().flat_map(|o| &o.ring));
        }
    }
    // The outer skin must have the inner ones behind it: else these are hollows of a solid body.
    let (mut kept, mut covered) = (0.0, 0.0);
    for &f in group.faces.iter().filter(|f| !skins.removed[**f as usize]) {
        let side = &group.sides[f as usize];
        kept += side.area;
        if group.is_skin(f) && skins.removed[side.opposite as usize] {
            covered += side.area;
        }
    }
    log::debug!(
        "thickness {:.4}, {} inner skins with {} pinholes behind {:.3} of the outer skin",
        group.thickness,
        skins.skins,
        skins.pinholes,
        covered / kept
    );
    if skins.skins == 0 || covered < COVERED.get() * kept {
        return InnerSkins::default();
    }
    skins.thickness = group.thickness;
    remove_necks(group, &rings, &mut skins.removed);
    skins
}

/// The connected sets of separated faces, in the order of their first faces.
fn regions(group: &SkinGroup, separated: &[bool]) -> Vec<SkinRegion> {
    let mut known = vec![false; separated.len()];
    let mut all = Vec::new();
    for &first in group.faces.iter().filter(|f| separated[**f as usize]) {
        if known[first as usize] {
            continue;
        }
        known[first as usize] = true;
        let (mut faces, mut border) = (vec![first], Vec::new());
        let mut next = 0;
        while next < faces.len() {
            for (h, g) in group.neighbours(faces[next]) {
                if !separated[g as usize] {
                    border.push(h);
                } else if !known[g as usize] {
                    known[g as usize] = true;
                    faces.push(g);
                }
            }
            next += 1;
        }
        all.push(SkinRegion {
            faces,
            openings: openings(group, border),
        });
    }
    all
}

/// The rings that half-edges form: those connected by vertices.
fn openings(group: &SkinGroup, mut border: Vec<u32>) -> Vec<Opening> {
    border.sort_unstable();
    let mesh = &group.found.mesh;
    let mut number: BTreeMap<u32, u32> = BTreeMap::new();
    for h in &border {
        for v in [start(mesh, *h), end(mesh, *h)] {
            let next = number.len() as u32;
            number.entry(v).or_insert(next);
        }
    }
    let mut sets = DisjointSets::new(number.len());
    for h in &border {
        sets.join(number[&start(mesh, *h)], number[&end(mesh, *h)]);
    }
    let mut rings: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for h in border {
        let set = sets.find(number[&start(mesh, h)]);
        rings.entry(set).or_default().push(h);
    }
    let ends = |h: &u32| [start(mesh, *h), end(mesh, *h)].map(|v| mesh.positions[v as usize]);
    let opening = |ring: Vec<u32>| {
        let middles = || ring.iter().map(&ends).map(|[a, b]| 0.5 * (a + b));
        let centre = middles().sum::<DVec3>() / ring.len() as f64;
        let radius = middles().map(|m| m.distance(centre)).fold(0.0, f64::max);
        let triangle = |[a, b]: [DVec3; 2]| 0.5 * (a - centre).cross(b - centre);
        let vector = ring.iter().map(&ends).map(triangle).sum();
        Opening {
            ring,
            centre,
            radius,
            vector,
        }
    };
    rings.into_values().map(opening).collect()
}

/// Whether a closed region is an inner skin, not a cavity: thin and of constant distance to the outer skin.
fn is_parallel(group: &SkinGroup, region: &SkinRegion) -> bool {
    let even = [CONSTANT.get(), CONSTANT_PART.get()];
    let distance = even_distance(group.sides, &region.faces, even);
    distance.is_some_and(|distance| distance < THIN.get() * group.diagonal)
}

/// Whether a region is a skin all of whose openings are pinholes.
fn is_behind_pinholes(group: &SkinGroup, region: &SkinRegion, separated: &[bool]) -> bool {
    let t = group.thickness;
    let (mut area, mut skin) = (0.0, 0.0);
    for &f in &region.faces {
        let side = &group.sides[f as usize];
        area += side.area;
        let is_parallel = (side.distance - t).abs() < CONSTANT.get() * t;
        if side.opposite != NONE && is_parallel && !separated[side.opposite as usize] {
            skin += side.area;
        }
    }
    let caps: f64 = region.openings.iter().map(|o| o.vector.length()).sum();
    let widest = region.openings.iter().map(|o| o.radius).fold(0.0, f64::max);
    let is_mouth = region
        .openings
        .iter()
        .any(|o| is_mouth(group, o, separated));
    log::debug!(
        "region of {} faces, {} openings: radius {:.2} thicknesses, caps {:.3} of the area, skin {:.3}, mouth {is_mouth}",
        region.faces.len(),
        region.openings.len(),
        widest / t,
        caps / area,
        skin / area,
    );
    widest < OPENING.get() * t
        && caps < CAPS.get() * area
        && skin > SKIN_PART.get() * area
        && !is_mouth
}

/// Whether an opening is the mouth of a pipe or of a bottle's neck: the outer skin round it is a tube along the normal of the
/// opening's cap. Round a pinhole the skin faces as the cap does, or both ways where the pinhole pierces a thin part.
fn is_mouth(group: &SkinGroup, opening: &Opening, separated: &[bool]) -> bool {
    let reach = opening.radius + BESIDE.get() * group.thickness;
    let faces = around(group, &opening.ring, separated, |f| {
        group.sides[f as usize].centre.distance(opening.centre) < reach
    });
    let axis = opening.vector.normalize_or_zero();
    if axis == DVec3::ZERO {
        return false;
    }
    let (x, y) = axis.any_orthonormal_pair();
    let (mut all, mut along) = (0.0, 0.0);
    // Second moments of the normals across the axis.
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for f in faces {
        let side = &group.sides[f as usize];
        if group.is_skin(f) && separated[side.opposite as usize] {
            let (u, v) = (side.normal.dot(x), side.normal.dot(y));
            all += side.area;
            if side.normal.dot(axis).abs() < TUBE.get() {
                along += side.area;
            }
            xx += side.area * u * u;
            xy += side.area * u * v;
            yy += side.area * v * v;
        }
    }
    let mean = 0.5 * (xx + yy);
    let half = (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
    all > 0.0 && along > TUBE_PART.get() * all && mean - half > ROUND.get() * (mean + half)
}

/// The faces outside that are connected with a ring through faces that `belongs` accepts, in the order of their distance in edges.
fn around(
    group: &SkinGroup,
    ring: &[u32],
    separated: &[bool],
    belongs: impl Fn(u32) -> bool,
) -> Vec<u32> {
    let opposite = &group.found.topology.opposite;
    let mut known = std::collections::HashSet::new();
    let mut faces: Vec<u32> = Vec::new();
    let mut queue: VecDeque<u32> = ring.iter().map(|h| opposite[*h as usize] / 3).collect();
    while let Some(f) = queue.pop_front() {
        if separated[f as usize] || !belongs(f) || !known.insert(f) {
            continue;
        }
        faces.push(f);
        queue.extend(group.neighbours(f).map(|(_, g)| g));
    }
    faces
}

/// Marks the faces of necks: near the half-edges of rings, those whose other side is not parallel to them. Without them patches
/// continue the outer skin.
fn remove_necks(group: &SkinGroup, rings: &[u32], removed: &mut Vec<bool>) {
    let (mesh, opposite) = (&group.found.mesh, &group.found.topology.opposite);
    let inner = removed.clone();
    let reach = NECK.get() * group.thickness;
    let is_neck = |f: u32| {
        let side = &group.sides[f as usize];
        let is_parallel = side.opposite != NONE
            && inner[side.opposite as usize]
            && (side.distance - group.thickness).abs() < NECK_CONSTANT.get() * group.thickness
            && side.normal.dot(group.sides[side.opposite as usize].normal) < -NECK_PARALLEL.get();
        !is_parallel
    };
    let middle = |h: u32| {
        0.5 * (mesh.positions[start(mesh, h) as usize] + mesh.positions[end(mesh, h) as usize])
    };
    let mut queue: VecDeque<(u32, DVec3)> = rings
        .iter()
        .map(|h| (opposite[*h as usize] / 3, middle(*h)))
        .collect();
    while let Some((f, from)) = queue.pop_front() {
        let is_near = group.sides[f as usize].centre.distance(from) < reach;
        if removed[f as usize] || !is_near || !is_neck(f) {
            continue;
        }
        removed[f as usize] = true;
        queue.extend(group.neighbours(f).map(|(_, g)| (g, from)));
    }
    // The skin bends a little beside the lip too.
    for _ in 0..NECK_RINGS.get() {
        let is_border = |f: &&u32| {
            !removed[**f as usize] && group.neighbours(**f).any(|(_, g)| removed[g as usize])
        };
        let border: Vec<u32> = group.faces.iter().filter(is_border).copied().collect();
        border.iter().for_each(|f| removed[*f as usize] = true);
    }
    *removed = without_spikes(&group.found.topology, removed);
}
