//! Rims of thousands of edges: a region is solved with some vertices of such a rim, as far apart as the shape allows, and the patch's
//! faces along it are divided into fans to the vertices between.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::framed::half_edges;
use crate::fill::RegionPatch;
use crate::mesh::topology::start;
use crate::mesh::{Hole, Mesh, Topology, area_vector, described};
use crate::stitch::{Patch, count_intersecting};
use crate::tuning::{Tunable, tunable};

/// Edges. Regions with longer rims are solved with fewer vertices of these, and fans of faces to those between, if the faces around
/// them are much larger. A flat plate whose hole has 20,000 edges took 10 to 100 s with all of them. Where the faces around are as
/// small as the rim's edges, a coarse patch in fine surroundings takes five times as long as a fine one.
const DENSE_RIM: Tunable<usize> = tunable("fill.dense_rim", 2000);

/// Edges of such a rim in the solve, at least: they are as long as the edges that leave the rim. Where its shape needs more, two to
/// eight times as many. A disc with this many takes about a second.
const COARSE_RIM: Tunable<usize> = tunable("fill.coarse_rim", 256);

/// Lengths of an edge of the coarse rim. The vertices between its ends are at most this far from it. On a circle of 256 edges
/// they are at 0.003.
const COARSE_RIM_ERROR: Tunable<f64> = tunable("fill.coarse_rim_error", 0.02);

/// Cosine. The faces at the rim turn by less when its vertices move to those that stay (3°): their normals are data of the fill.
const COARSE_RIM_TURN: Tunable<f64> = tunable("fill.coarse_rim_turn", 0.9986);

/// A part of the mesh whose long rims have fewer vertices. Vertices keep their numbers; those between the kept ones of a rim have no
/// faces.
pub(super) struct CoarseRims {
    pub(super) mesh: Mesh,
    /// The number in the part of each face.
    pub(super) faces: Vec<u32>,
    /// The holes with their coarse rims.
    pub(super) holes: Vec<Hole>,
    /// The rim's vertices between the ends of an edge of a coarse rim, in its direction.
    chains: HashMap<[u32; 2], Vec<u32>>,
}

impl CoarseRims {
    /// A part with coarse rims; none where no rim is long and much finer than the faces around it, or its shape needs its vertices. The
    /// vertices `fixed` stay.
    pub(super) fn new(part: &Mesh, holes: &[Hole], fixed: &[[u32; 2]]) -> Option<Self> {
        let wanted = wanted_edges(part, holes);
        wanted.iter().flatten().next()?;
        let topology = Topology::without_orienting(part);
        let mut pinned: HashSet<u32> = fixed.iter().flatten().copied().collect();
        // Vertices that the boundary passes more than once.
        let mut seen = HashSet::new();
        let boundary =
            (0..topology.boundary.len() as u32).filter(|&h| topology.boundary[h as usize]);
        pinned.extend(
            boundary
                .map(|h| start(part, h))
                .filter(|v| !seen.insert(*v)),
        );
        for factor in [1, 2, 4, 8] {
            let more = |(wanted, hole): (&Option<usize>, &Hole)| {
                let more = wanted.map(|count| factor * count);
                more.filter(|count| is_worthwhile(*count, hole))
            };
            let wanted: Vec<Option<usize>> = wanted.iter().zip(holes).map(more).collect();
            wanted.iter().flatten().next()?;
            if let Some(coarse) = Self::with(part, &topology, holes, &pinned, &wanted) {
                return Some(coarse);
            }
        }
        None
    }

    /// A part whose rims have about these numbers of edges; none: all of theirs.
    fn with(
        part: &Mesh,
        topology: &Topology,
        holes: &[Hole],
        pinned: &HashSet<u32>,
        wanted: &[Option<usize>],
    ) -> Option<Self> {
        let mut chains = HashMap::new();
        let mut new_of: Vec<u32> = (0..part.positions.len() as u32).collect();
        let mut rims = Vec::new();
        for (hole, wanted) in holes.iter().zip(wanted) {
            let rim = &hole.rim;
            let Some(wanted) = *wanted else {
                rims.push(rim.clone());
                continue;
            };
            let kept = kept_vertices(part, rim, pinned, wanted)?;
            rims.push(kept.iter().map(|&i| rim[i]).collect());
            // The vertices between move to the nearer end, counted in edges.
            for (k, &i) in kept.iter().enumerate() {
                let j = kept.get(k + 1).copied().unwrap_or(rim.len());
                let ends = [rim[i], rim[j % rim.len()]];
                for (at, &v) in rim.iter().enumerate().take(j).skip(i + 1) {
                    new_of[v as usize] = ends[usize::from(2 * at > i + j)];
                }
                if j > i + 1 {
                    chains.insert(ends, rim[i + 1..j].to_vec());
                }
            }
        }
        let (mesh, faces) = renumbered(part, &new_of)?;
        // The same surface with the same holes.
        let coarse = Topology::without_orienting(&mesh);
        let manifold = |t: &Topology| (t.defects.non_manifold_edges, t.component_faces.len());
        if manifold(&coarse) != manifold(topology) {
            return None;
        }
        let hole = |(rim, hole): (&Vec<u32>, &Hole)| {
            Some(Hole {
                id: hole.id,
                outer_boundary: hole.outer_boundary,
                object: hole.object.clone(),
                ..described(&mesh, &coarse, &half_edges(&mesh, &coarse, rim)?)
            })
        };
        let holes = rims.iter().zip(holes).map(hole).collect::<Option<_>>()?;
        Some(Self {
            mesh,
            faces,
            holes,
            chains,
        })
    }

    /// A patch of the coarse rims, with fans to the vertices between, for the part; none where it is no surface of its own, or a fan folds
    /// or intersects something.
    pub(super) fn fanned(&self, part: &Mesh, mut patch: RegionPatch) -> Option<RegionPatch> {
        if patch.mesh.positions.is_empty() {
            return None;
        }
        let count = part.positions.len();
        let new = &patch.mesh.positions;
        let at = |v: u32| match (v as usize).checked_sub(count) {
            Some(own) => new[own],
            None => part.positions[v as usize],
        };
        let (mut faces, mut used) = (Vec::new(), 0);
        for face in &patch.mesh.faces {
            let normal = area_vector(face.map(at));
            // A face at several edges of the rim is divided once for each of them.
            let mut open = vec![*face];
            while let Some([a, b, c]) = open.pop() {
                let sides = [[a, b, c], [b, c, a], [c, a, b]];
                let side = sides.iter().find_map(|&[from, to, apex]| {
                    let between = self.chains.get(&[from, to])?;
                    Some((from, between, to, apex))
                });
                let Some((mut from, between, to, apex)) = side else {
                    if area_vector([a, b, c].map(at)).dot(normal) <= 0.0 {
                        return None;
                    }
                    faces.push([a, b, c]);
                    continue;
                };
                used += 1;
                for &v in between.iter().chain([&to]) {
                    open.push([from, v, apex]);
                    from = v;
                }
            }
        }
        if used != self.chains.len() {
            return None;
        }
        let mut whole = Patch {
            positions: std::mem::take(&mut patch.mesh.positions),
            faces,
            ..Patch::default()
        };
        let crossing = count_intersecting(part, &whole.positions, &whole.faces);
        if crossing > patch.report.intersecting_faces {
            return None;
        }
        whole.measure(part, part.faces.iter().copied());
        let report = &mut patch.report;
        report.set_intersecting(crossing);
        report.new_faces = whole.faces.len();
        report.quality_mean = whole.report.quality_mean;
        if report.seam_angle_mean.is_some() {
            report.seam_angle_mean = Some(whole.report.seam_angle_mean);
            report.seam_angle_max = Some(whole.report.seam_angle_max);
        }
        patch.mesh = Mesh::new(whole.positions, whole.faces);
        Some(patch)
    }
}

/// Whether a coarse rim with this many edges has much fewer than the hole.
fn is_worthwhile(count: usize, hole: &Hole) -> bool {
    hole.edges > DENSE_RIM.get() && 4 * count <= hole.edges
}

/// For each hole the number of edges of its coarse rim: as long as the edges that leave the rim. None where the rim stays.
fn wanted_edges(part: &Mesh, holes: &[Hole]) -> Vec<Option<usize>> {
    let is_dense = |hole: &Hole| is_worthwhile(COARSE_RIM.get(), hole);
    if !holes.iter().any(is_dense) {
        return vec![None; holes.len()];
    }
    let rims = holes.iter().zip(0..);
    let hole_of: HashMap<u32, usize> = rims
        .flat_map(|(hole, i)| hole.rim.iter().map(move |&v| (v, i)))
        .collect();
    // The sum and number of the lengths of edges between a rim and other vertices.
    let mut sums = vec![(0.0, 0.0); holes.len()];
    for face in &part.faces {
        let own = face.map(|v| hole_of.get(&v).copied());
        for k in 0..3 {
            let (a, b) = (k, (k + 1) % 3);
            if own[a] != own[b] {
                let [p, q] = [a, b].map(|k| part.positions[face[k] as usize]);
                for i in [own[a], own[b]].into_iter().flatten() {
                    sums[i].0 += p.distance(q);
                    sums[i].1 += 1.0;
                }
            }
        }
    }
    let wanted = |(hole, (sum, count)): (&Hole, &(f64, f64))| {
        let edges = (hole.length * count / sum) as usize;
        let edges = edges.max(COARSE_RIM.get());
        is_worthwhile(edges, hole).then_some(edges)
    };
    holes.iter().zip(&sums).map(wanted).collect()
}

/// The indices of the vertices of a rim that stay, in rising order: about `wanted`, at equal distances along the rim, more where it
/// bends, and all pinned ones. None if these are not much fewer than all.
fn kept_vertices(
    mesh: &Mesh,
    rim: &[u32],
    pinned: &HashSet<u32>,
    wanted: usize,
) -> Option<Vec<usize>> {
    let count = rim.len();
    let at = |i: usize| mesh.positions[rim[i % count] as usize];
    // The distance along the rim to each vertex, and to the first one again.
    let mut along = vec![0.0];
    for i in 0..count {
        along.push(along[i] + at(i).distance(at(i + 1)));
    }
    let step = along[count] / wanted as f64;
    let is_straight = |i: usize, j: usize| {
        let most = COARSE_RIM_ERROR.get() * at(i).distance(at(j));
        (i + 1..j).all(|k| from_segment(at(k), at(i), at(j)) <= most)
    };
    let (mut kept, mut i) = (Vec::new(), 0);
    while i < count {
        kept.push(i);
        if 4 * kept.len() > 3 * count {
            return None;
        }
        let beyond = along.partition_point(|&length| length <= along[i] + 1.000_001 * step);
        let next = (i + 1..count).find(|&k| k + 1 >= beyond || pinned.contains(&rim[k]));
        let mut edges = next.unwrap_or(count) - i;
        while edges > 1 && !is_straight(i, i + edges) {
            edges /= 2;
        }
        i += edges;
    }
    Some(kept)
}

/// The distance of a point from a segment.
fn from_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let t = (p - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
    p.distance(a + t.clamp(0.0, 1.0) * along)
}

/// The faces of a mesh with other numbers for some vertices, without those that lose their area, and their numbers; none where a face
/// turns by much.
fn renumbered(part: &Mesh, new_of: &[u32]) -> Option<(Mesh, Vec<u32>)> {
    let (mut faces, mut numbers) = (Vec::new(), Vec::new());
    for (face, number) in part.faces.iter().zip(0..) {
        let moved = face.map(|v| new_of[v as usize]);
        if moved != *face {
            let [a, b, c] = moved;
            if a == b || b == c || c == a {
                continue;
            }
            let of = |face: [u32; 3]| {
                area_vector(face.map(|v| part.positions[v as usize])).normalize_or_zero()
            };
            if of(*face).dot(of(moved)) < COARSE_RIM_TURN.get() {
                return None;
            }
        }
        faces.push(moved);
        numbers.push(number);
    }
    Some((Mesh::new(part.positions.clone(), faces), numbers))
}
