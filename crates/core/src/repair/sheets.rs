//! Non-manifold edges and vertices: separates the surfaces that meet there, or cuts them out.

mod halve;
mod pairs;

use std::collections::BTreeSet;

use glam::DVec3;

use super::RepairReport;
use super::draft::Draft;
use super::rounding::Rounding;
use super::shell_vertex::LEAST_APART;
use crate::mend::{FillError, Inspection};
use crate::mesh::topology::{NONE, Topology, end, start};
use crate::mesh::{Mesh, Part, VertexFaces, fans, has_several_fans, vertex_normal};
use crate::spatial::{Bounds, BoxTree, intersecting};
use crate::tuning::{Tunable, tunable};

pub(super) use pairs::paired;

/// Rounds of cuts: each changes which sheets touch.
const SHEET_ROUNDS: Tunable<usize> = tunable("repair.sheet_rounds", 8);

/// The first rounds of separating sheets, in which an edge that cannot be separated at its ends gets a vertex in its
/// middle.
const HALVING_ROUNDS: Tunable<usize> = tunable("repair.halving_rounds", 3);

/// Shortest edges. Separated vertices are moved apart by this.
const APART: Tunable<f64> = tunable("repair.apart", 1e-3);

/// Factor of `APART` where faces would intersect; then its inverse.
const APART_NEARER: Tunable<f64> = tunable("repair.apart_nearer", 0.1);

/// Separates surfaces that meet in edges or vertices if they bound bodies there; cuts out the others. `closes` is whether all holes
/// are to be filled.
pub(super) fn separate(
    draft: &mut Draft,
    report: &mut RepairReport,
    closes: bool,
) -> Result<(), FillError> {
    for round in 0..SHEET_ROUNDS.get() {
        let (cuts, copies) = {
            let mut found = draft.take_inspection()?;
            let crowded = found.topology.non_manifold_edges(&found.mesh);
            let (pairs, unclear) = paired(&found, &crowded);
            if unclear.is_empty() {
                for [a, b] in pairs {
                    found.topology.opposite[a as usize] = b;
                    found.topology.opposite[b as usize] = a;
                }
                let requests = touching(&found, |f| draft.region[f as usize] == NONE);
                (Vec::new(), placed(&found, requests, draft.rounding))
            } else {
                let mut cuts = cuts(&found, &unclear);
                let requests = detached(&found, &unclear, closes, &mut cuts);
                (cuts, placed(&found, requests, draft.rounding))
            }
        };
        if cuts.is_empty() && copies.is_empty() {
            return Ok(());
        }
        report.steps.split_vertices += copies.len();
        copies.into_iter().for_each(|copy| copy.make(draft));
        if !cuts.is_empty() {
            report.steps.non_manifold_faces += cut(draft, &cuts)?;
            continue;
        }
        // Surfaces that still meet in an edge are connected at both of its ends; a new vertex in its middle can be separated.
        if round < HALVING_ROUNDS.get() && halve::halve(draft)? > 0 {
            continue;
        }
        let left: Vec<u32> = {
            let found = draft.inspect()?;
            let crowded = found.topology.non_manifold_edges(&found.mesh);
            crowded.iter().flatten().map(|h| h / 3).collect()
        };
        if left.is_empty() || round + 1 == SHEET_ROUNDS.get() {
            return Ok(());
        }
        report.steps.non_manifold_faces += cut(draft, &left)?;
    }
    Ok(())
}

fn cut(draft: &mut Draft, faces: &[u32]) -> Result<usize, FillError> {
    let mut marks = vec![false; draft.mesh.faces.len()];
    faces.iter().for_each(|f| marks[*f as usize] = true);
    if marks.iter().all(|m| *m) {
        return Ok(0);
    }
    draft.cut(&marks)
}

/// The faces to cut out at inseparable edges: all but the best continuing pair of each edge. A component without boundary edges
/// that continues across none of them, i.e. a sheet that ends at such edges everywhere, is removed entirely.
fn cuts(found: &Inspection, unclear: &[Vec<u32>]) -> Vec<u32> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let size = |h: u32| topology.component_faces[topology.component[h as usize / 3] as usize];
    let normal = |h: u32| crate::mesh::face_normal(mesh, h / 3);
    let mut stays = vec![false; topology.component_faces.len()];
    let mut goes = Vec::new();
    for half_edges in unclear {
        // Best pair: the largest components first, then the flattest angle.
        let mut best: Option<(usize, f64, [u32; 2])> = None;
        for (i, &a) in half_edges.iter().enumerate() {
            for &b in &half_edges[i + 1..] {
                let score = (size(a).min(size(b)), normal(a).dot(normal(b)));
                let opposed = start(mesh, a) != start(mesh, b);
                if opposed && best.is_none_or(|(n, flat, _)| (n, flat) < score) {
                    best = Some((score.0, score.1, [a, b]));
                }
            }
        }
        let kept = best.map_or([NONE; 2], |b| b.2);
        for &h in half_edges {
            if kept.contains(&h) {
                stays[topology.component[h as usize / 3] as usize] = true;
            } else {
                goes.push(h / 3);
            }
        }
    }
    let open = open_components(topology);
    let mut whole = vec![false; open.len()];
    for f in &goes {
        let component = topology.component[*f as usize] as usize;
        whole[component] = !open[component] && !stays[component];
    }
    goes.extend(
        topology
            .faces()
            .filter(|&f| whole[topology.component[f as usize] as usize]),
    );
    goes.sort_unstable();
    goes.dedup();
    goes
}

/// Vertex copies that detach open sheets of which a cut would leave nothing, because all their faces are at inseparable edges,
/// from open surfaces. Their faces are removed from `cuts`. On closed surfaces and inside them such sheets are defects and are
/// cut; so are sheets of one or two faces on larger surfaces without an outer border, if it `closes` these.
fn detached(
    found: &Inspection,
    unclear: &[Vec<u32>],
    closes: bool,
    cuts: &mut Vec<u32>,
) -> Vec<CopyRequest> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let component = |f: u32| topology.component[f as usize] as usize;
    let mut left = topology.component_faces.clone();
    cuts.iter().for_each(|&f| left[component(f)] -= 1);
    let open = open_components(topology);
    let goes = |h: &u32| left[component(h / 3)] == 0 && open[component(h / 3)];
    let mut has_border = vec![false; open.len()];
    let borders = found.holes.iter().filter(|h| h.outer_boundary);
    borders.for_each(|h| has_border[h.component as usize] = true);
    let mut ends: BTreeSet<(usize, u32)> = BTreeSet::new();
    for half_edges in unclear {
        let stay = half_edges
            .iter()
            .map(|h| component(h / 3))
            .filter(|c| left[*c] > 0);
        let on_open = stay.clone().any(|c| open[c]);
        let cuts_fins = closes
            && stay
                .clone()
                .any(|c| !topology.is_loose(c as u32) && !has_border[c]);
        let is_fin = |h: &u32| cuts_fins && topology.is_loose(topology.component[*h as usize / 3]);
        let free = |h: &&u32| on_open && goes(h) && !is_fin(h);
        for &h in half_edges.iter().filter(free) {
            for v in [start(mesh, h), end(mesh, h)] {
                ends.insert((component(h / 3), v));
            }
        }
    }
    let around = VertexFaces::new(mesh);
    let mut requests = Vec::new();
    let free: BTreeSet<usize> = ends.iter().map(|(component, _)| *component).collect();
    for (own, v) in ends {
        let faces = around.of(v).iter().copied();
        let fan: Vec<u32> = faces
            .filter(|&f| topology.component[f as usize] == own as u32)
            .collect();
        let displacements = vec![along(mesh, &fan, v)];
        requests.push(CopyRequest {
            fan,
            vertex: v,
            displacements,
            is_alternative: false,
        });
    }
    cuts.retain(|&f| !free.contains(&component(f)));
    requests
}

/// Whether each component is open.
pub(super) fn open_components(topology: &Topology) -> Vec<bool> {
    let mut open = vec![false; topology.component_faces.len()];
    let border = (0..topology.boundary.len()).filter(|h| topology.boundary[*h]);
    border.for_each(|h| open[topology.component[h / 3] as usize] = true);
    open
}

/// A short displacement from a vertex along the faces of a fan.
fn along(mesh: &Mesh, fan: &[u32], vertex: u32) -> DVec3 {
    let p = mesh.positions[vertex as usize];
    let centre = |f: &u32| mesh.corners(*f).iter().sum::<DVec3>() / 3.0 - p;
    let direction: DVec3 = fan.iter().map(centre).sum();
    direction.normalize_or_zero() * short(mesh, fan, p)
}

/// The corners of a fan's faces at a vertex, in the numbering of the draft.
fn corners(found: &Inspection, fan: &[u32], vertex: u32) -> Vec<(u32, usize)> {
    let corner = |&f: &u32| {
        let face = found.mesh.faces[f as usize];
        let k = face.iter().position(|w| *w == vertex).unwrap_or(0);
        // Reorientation swaps the corners 1 and 2.
        let turned = found.topology.turned[f as usize];
        (f, if turned && k > 0 { 3 - k } else { k })
    };
    fan.iter().map(corner).collect()
}

/// A vertex copy for some faces, slightly displaced.
struct Copy {
    /// Corners of the draft's faces that get the copy.
    corners: Vec<(u32, usize)>,
    /// Displacement of the copy.
    shift: DVec3,
}

/// A fan that should get its own copy of its vertex.
struct CopyRequest {
    fan: Vec<u32>,
    vertex: u32,
    /// Candidate displacements, in the order in which they are tried.
    displacements: Vec<DVec3>,
    /// Whether the fan gets a copy only if no other fan at the vertex could.
    is_alternative: bool,
}

/// Vertex copies that separate surfaces meeting in a vertex. One fan keeps the vertex: an open one if there is one, else the one
/// with the most input faces, then the most faces. Open fans are not separated, since the fill of the gap between them may join
/// them.
fn touching(found: &Inspection, is_old: impl Fn(u32) -> bool) -> Vec<CopyRequest> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let around = VertexFaces::new(mesh);
    let mut requests = Vec::new();
    for v in 0..mesh.positions.len() as u32 {
        if around.of(v).len() < 6 || !has_several_fans(mesh, topology, &around, v) {
            continue;
        }
        let mut all = fans(mesh, topology, &around, v);
        if all.len() < 2 {
            continue;
        }
        // The sort is stable: of equal fans the one with the smallest face number comes first.
        let old = |fan: &[u32]| fan.iter().filter(|f| is_old(**f)).count();
        all.sort_by_key(|fan| std::cmp::Reverse((old(fan), fan.len())));
        let closed = |fan: &Vec<u32>| is_closed(mesh, topology, fan, v);
        let spared = all.iter().position(|fan| !closed(fan)).unwrap_or(0);
        let others = (0..all.len()).filter(|i| *i != spared);
        for i in others.chain([spared]) {
            let fan = &all[i];
            if !closed(fan) {
                continue;
            }
            let ways = [inward(mesh, fan, v), along(mesh, fan, v)];
            let nearer = APART_NEARER.get();
            let factors = [1.0, nearer, 1.0 / nearer];
            requests.push(CopyRequest {
                fan: fan.clone(),
                vertex: v,
                displacements: (factors.iter())
                    .flat_map(|factor| ways.map(|way| *factor * way))
                    .collect(),
                is_alternative: i == spared,
            });
        }
    }
    requests
}

/// Chooses for each fan the first displacement that adds no intersecting faces; fans without one are not separated.
fn placed(found: &Inspection, requests: Vec<CopyRequest>, rounding: Rounding) -> Vec<Copy> {
    if requests.is_empty() {
        return Vec::new();
    }
    let mesh = &found.mesh;
    let faces: Vec<u32> = found.topology.faces().collect();
    let boxes: Vec<Bounds> = (faces.iter())
        .map(|f| Bounds::of(mesh.corners(*f)))
        .collect();
    let tree = BoxTree::new(&boxes);
    let place = |request: CopyRequest| {
        let p = mesh.positions[request.vertex as usize];
        let longest = request
            .displacements
            .iter()
            .map(|displacement| displacement.length())
            .fold(0.0, f64::max);
        // Faces near the fan, within the longest displacement.
        let mut near = Vec::new();
        for f in &request.fan {
            let reach = Bounds::of(mesh.corners(*f)).widened(longest);
            tree.for_each(&reach, |i| near.push(faces[i as usize]));
        }
        near.sort_unstable();
        near.dedup();
        near.retain(|f| !request.fan.contains(f));
        let part = Part::new(
            mesh,
            &[&request.fan[..], &near].concat(),
            std::iter::empty(),
        );
        let (count, own) = (request.fan.len(), part.local(request.vertex));
        let (mut positions, mut all) = (part.mesh.positions, part.mesh.faces);
        // Compare the intersections of the fan before and after it gets its own vertex.
        let before = intersecting(&positions, &all, count).len();
        let copy = positions.len() as u32;
        for v in all[..count].iter_mut().flatten().filter(|v| **v == own) {
            *v = copy;
        }
        positions.push(p);
        let fits = |displacement: &&DVec3| {
            positions[copy as usize] = rounding.moved(p, **displacement);
            positions[copy as usize] != p && intersecting(&positions, &all, count).len() <= before
        };
        let displacement = request.displacements.iter().find(fits)?;
        Some(Copy {
            corners: corners(found, &request.fan, request.vertex),
            shift: *displacement,
        })
    };
    let mut copies = Vec::new();
    let mut done: BTreeSet<u32> = BTreeSet::new();
    for request in requests {
        let vertex = request.vertex;
        if request.is_alternative && done.contains(&vertex) {
            continue;
        }
        if let Some(copy) = place(request) {
            done.insert(vertex);
            copies.push(copy);
        }
    }
    copies
}

/// Whether a fan closes round its vertex.
fn is_closed(mesh: &Mesh, topology: &Topology, fan: &[u32], vertex: u32) -> bool {
    let mut half_edges = fan.iter().flat_map(|f| 3 * f..3 * f + 3);
    half_edges.all(|h| {
        let other = start(mesh, h) != vertex && end(mesh, h) != vertex;
        other || topology.opposite[h as usize] != NONE
    })
}

/// A short displacement from a vertex into the body that a fan bounds.
fn inward(mesh: &Mesh, fan: &[u32], vertex: u32) -> DVec3 {
    let part = Part::new(mesh, fan, std::iter::empty());
    let own = part.local(vertex);
    let normal = vertex_normal(&part.mesh, &VertexFaces::new(&part.mesh), own);
    -normal * short(mesh, fan, mesh.positions[vertex as usize])
}

/// Displacement of separated vertices, in mesh units.
fn short(mesh: &Mesh, fan: &[u32], p: DVec3) -> f64 {
    let others = fan.iter().flat_map(|f| mesh.corners(*f));
    let distances = others.map(|q| q.distance(p)).filter(|d| *d > 0.0);
    let shortest = distances.fold(f64::INFINITY, f64::min);
    let least = LEAST_APART.get() * f64::from(f32::EPSILON) * p.abs().max_element();
    (APART.get() * shortest).max(least)
}

impl Copy {
    fn make(self, draft: &mut Draft) {
        // Vertices that are duplicated for a seam of colours or texture each get their own copy.
        let mut made: Vec<(u32, u32)> = Vec::new();
        for (f, k) in self.corners {
            let old = draft.mesh.faces[f as usize][k];
            let copy = match made.iter().find(|(of, _)| *of == old) {
                Some((_, copy)) => *copy,
                None => {
                    let old_position = draft.mesh.positions[old as usize];
                    let moved = draft.rounding.moved(old_position, self.shift);
                    let copy = draft.copy_vertex(old, moved);
                    made.push((old, copy));
                    copy
                }
            };
            draft.mesh.faces[f as usize][k] = copy;
        }
    }
}
