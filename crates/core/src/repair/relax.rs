//! Moves vertices of folds and noise until their faces no longer intersect, before any face is cut out.
//!
//! Intersecting faces form clusters. A cluster is a fold or noise if its faces, with two rings round them, are one connected piece of
//! the surface; two parts of a surface that pass through each other are two pieces, and nothing moves there. In each round the
//! vertices of the faces that still intersect, and one ring round them, move half of the way to the mean of their neighbours
//! (umbrella operator: Kobbelt, Campagna, Vorsatz, Seidel, "Interactive multi-resolution modeling on arbitrary meshes", 1998).
//! Vertices on non-manifold edges stay; those on boundaries stay too, or slide along these in later rounds. A cluster of which more
//! than a small part still intersects is put back.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::RepairReport;
use super::cracks::FOLDED;
use super::draft::Draft;
use crate::mend::{FillError, Inspection};
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{DisjointSets, Mesh, VertexFaces, area_vector};
use crate::spatial::{Bounds, BoxTree, intersecting_pairs};
use crate::tuning::{Tunable, tunable};

/// Intersecting faces. With more than this, no vertices are moved: it bounds the time.
pub(super) const RELAXED_FACES: Tunable<usize> = tunable("repair.relaxed_faces", 50_000);

/// Rings of faces round intersecting ones. If the faces are connected with these, they are a fold or noise, whose vertices
/// may move.
const RELAXED_RINGS: Tunable<usize> = tunable("repair.relaxed_rings", 2);

/// Rounds in which vertices move, at most.
const RELAXED_ROUNDS: Tunable<usize> = tunable("repair.relaxed_rounds", 60);

/// The first of these rounds in which vertices on boundaries slide along these.
const SLIDING_ROUND: Tunable<usize> = tunable("repair.sliding_round", 5);

/// Fraction of the way to the mean of the neighbours by which a vertex moves in a round.
const RELAXED_STEP: Tunable<f64> = tunable("repair.relaxed_step", 0.5);

/// Mean lengths of the edges at a vertex. It moves by this at most.
const RELAXED_REACH: Tunable<f64> = tunable("repair.relaxed_reach", 1.5);

/// Fraction of the intersecting faces of a fold or of noise. If more intersect still, the vertices are put back.
const RELAXED_LEFT: Tunable<f64> = tunable("repair.relaxed_left", 0.1);

/// Diagonals of the bounding box. No vertex moves by more than this.
const RELAXED_MOST: Tunable<f64> = tunable("repair.relaxed_most", 0.1);

/// Moves vertices where the surface is folded or noisy, if fewer faces intersect others then and nothing else gets worse.
pub(super) fn relax(draft: &mut Draft, report: &mut RepairReport) -> Result<(), FillError> {
    let crossing = draft.self_intersections()?;
    if crossing.is_empty() || crossing.len() > RELAXED_FACES.get() {
        return Ok(());
    }
    let found = draft.inspect()?;
    let mut relaxation = Relaxation::new(&found, &crossing);
    relaxation.run();
    relaxation.put_back(&crossing);
    if relaxation.owner.is_empty() {
        return Ok(());
    }
    let faults = draft.faults()?;
    let before = draft.clone();
    for (v, w) in found.weld.iter().enumerate() {
        if relaxation.owner.contains_key(w) {
            let from = draft.mesh.positions[v];
            let shift = relaxation.mesh.positions[*w as usize] - from;
            draft.mesh.positions[v] = draft.rounding.moved(from, shift);
            if draft.origins.vertices[v] != NONE {
                draft.displaced.vertices.entry(v as u32).or_insert(from);
            }
        }
    }
    draft.displaced.faces.extend(relaxation.moves());
    draft.forget_positions();
    let is_worse = relaxation.is_more_folded() || draft.faults()? >= faults;
    log::debug!(
        "{} vertices moved: {faults:?} before, {:?} after{}",
        relaxation.owner.len(),
        draft.faults()?,
        if is_worse { ", undone" } else { "" }
    );
    if is_worse {
        *draft = before;
        return Ok(());
    }
    let by = |(v, from): (&u32, &DVec3)| from.distance(draft.mesh.positions[*v as usize]);
    report.steps.relaxed_vertices = draft.displaced.vertices.len();
    report.steps.largest_relaxation = draft.displaced.vertices.iter().map(by).fold(0.0, f64::max);
    Ok(())
}

/// The moving mesh, with what does not change.
struct Relaxation<'a> {
    found: &'a Inspection<'a>,
    mesh: Mesh,
    around: VertexFaces,
    /// Whether each vertex is on a boundary or a non-manifold edge.
    stays: Vec<bool>,
    /// The vertices before and after each vertex of a boundary; none if the vertex stays.
    border: BTreeMap<u32, Option<[u32; 2]>>,
    /// The cluster of each face that intersects others or was moved.
    clusters: DisjointSets,
    /// The faces that may come to intersect moved faces.
    near: Vec<u32>,
    /// The moved vertices, each with a face of its cluster.
    owner: BTreeMap<u32, u32>,
    /// The intersecting pairs of which one face is to move.
    pairs: Vec<[u32; 2]>,
    /// The longest displacement of any vertex, in mesh units.
    most: f64,
}

impl<'a> Relaxation<'a> {
    fn new(found: &'a Inspection<'a>, crossing: &[u32]) -> Self {
        let mesh = Mesh::clone(&found.mesh);
        let [low, high] = mesh.bounds();
        let mut stays = vec![false; mesh.positions.len()];
        let mut border: BTreeMap<u32, Option<[u32; 2]>> = BTreeMap::new();
        for h in (0..3 * mesh.faces.len() as u32)
            .filter(|h| found.topology.opposite[*h as usize] == NONE)
        {
            let ends = [start(&mesh, h), end(&mesh, h)];
            ends.iter().for_each(|v| stays[*v as usize] = true);
            let is_border = found.topology.boundary[h as usize];
            for k in 0..2 {
                let known = border.entry(ends[k]).or_insert(Some([NONE; 2]));
                *known = known
                    .filter(|n| is_border && n[1 - k] == NONE)
                    .map(|mut n| {
                        n[1 - k] = ends[1 - k];
                        n
                    });
            }
        }
        let mut relaxation = Self {
            around: VertexFaces::new(&mesh),
            clusters: DisjointSets::new(mesh.faces.len()),
            most: RELAXED_MOST.get() * low.distance(high),
            near: Vec::new(),
            owner: BTreeMap::new(),
            pairs: Vec::new(),
            found,
            mesh,
            stays,
            border,
        };
        relaxation.find_clusters(crossing);
        relaxation.find_near();
        relaxation
    }

    /// Finds the clusters of intersecting faces, and the pairs of those that are one piece of the surface.
    fn find_clusters(&mut self, crossing: &[u32]) {
        self.near = crossing.to_vec();
        let pairs = self.intersecting(crossing);
        let of_vertex: BTreeMap<u32, u32> = (crossing.iter())
            .flat_map(|f| self.mesh.faces[*f as usize].map(|v| (v, *f)))
            .collect();
        for f in crossing {
            for v in self.mesh.faces[*f as usize] {
                self.clusters.join(*f, of_vertex[&v]);
            }
        }
        for [f, g] in &pairs {
            self.clusters.join(*f, *g);
        }
        let mut of_cluster: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for f in crossing {
            of_cluster
                .entry(self.clusters.find(*f))
                .or_default()
                .push(*f);
        }
        let local: BTreeSet<u32> = (of_cluster.into_iter())
            .filter(|(_, faces)| self.is_one_piece(faces))
            .map(|(cluster, _)| cluster)
            .collect();
        let pairs = pairs.into_iter();
        self.pairs = pairs
            .filter(|[f, _]| local.contains(&self.clusters.find(*f)))
            .collect();
    }

    /// Whether some faces with rings round them are connected across edges.
    fn is_one_piece(&self, faces: &[u32]) -> bool {
        let mut piece: BTreeSet<u32> = faces.iter().copied().collect();
        for _ in 0..RELAXED_RINGS.get() {
            piece = self.ring(piece.iter());
        }
        let Some(first) = piece.pop_first() else {
            return false;
        };
        let mut left = vec![first];
        while let Some(f) = left.pop() {
            for h in 3 * f..3 * f + 3 {
                let o = self.found.topology.opposite[h as usize];
                if o != NONE && piece.remove(&(o / 3)) {
                    left.push(o / 3);
                }
            }
        }
        piece.is_empty()
    }

    /// Some faces with those that share a vertex with them.
    fn ring<'f>(&self, faces: impl Iterator<Item = &'f u32>) -> BTreeSet<u32> {
        let corners = faces.flat_map(|f| self.mesh.faces[*f as usize]);
        let proper = |f: &u32| self.found.topology.component[*f as usize] != NONE;
        corners
            .flat_map(|v| self.around.of(v))
            .copied()
            .filter(proper)
            .collect()
    }

    /// Finds the faces within reach of those that may move.
    fn find_near(&mut self) {
        let topology = &self.found.topology;
        let own: BTreeSet<u32> = self.pairs.iter().flatten().copied().collect();
        let own: Vec<Bounds> = (own.iter())
            .map(|f| {
                let corners = self.mesh.corners(*f);
                let around = self.ring([*f].iter());
                let size = around.iter().map(|f| Bounds::of(self.mesh.corners(*f)));
                let all = size.fold(Bounds::of(corners), |all, own| all.join(&own));
                all.widened((all.high - all.low).length().min(2.0 * self.most))
            })
            .collect();
        let tree = BoxTree::new(&own);
        let is_near = |f: &u32| {
            tree.find(&Bounds::of(self.mesh.corners(*f)), |_| true)
                .is_some()
        };
        self.near = match own.is_empty() {
            true => Vec::new(),
            false => topology.faces().filter(is_near).collect(),
        };
    }

    /// The intersecting pairs of the `asked` faces with those nearby. All lists are ascending.
    fn intersecting(&self, asked: &[u32]) -> Vec<[u32; 2]> {
        let faces: Vec<[u32; 3]> = self
            .near
            .iter()
            .map(|f| self.mesh.faces[*f as usize])
            .collect();
        let place = |f: &u32| self.near.binary_search(f).ok().map(|i| i as u32);
        let asked: Vec<u32> = asked.iter().filter_map(place).collect();
        let pairs = intersecting_pairs(&self.mesh.positions, &faces, &asked);
        let number = |i: u32| self.near[i as usize];
        let mut pairs: Vec<[u32; 2]> = pairs.into_iter().map(|p| p.map(number)).collect();
        pairs.sort_unstable();
        pairs
    }

    /// The intersecting pairs of faces with a moved vertex.
    fn intersecting_moved(&self) -> Vec<[u32; 2]> {
        let moved: Vec<u32> = self.moved().into_iter().collect();
        self.intersecting(&moved)
    }

    /// Moves vertices in rounds, until nothing that moves intersects or is folded. Ends with the last state without intersections, if
    /// there was one.
    fn run(&mut self) {
        let mut clear = None;
        for round in 0..RELAXED_ROUNDS.get() {
            let mut active: BTreeSet<u32> = self.pairs.iter().flatten().copied().collect();
            if active.is_empty() {
                active = self.folded(&self.mesh);
                if active.is_empty() || self.owner.is_empty() {
                    return;
                }
                clear = Some((self.mesh.positions.clone(), self.owner.clone()));
            }
            self.move_round(&active, round >= SLIDING_ROUND.get());
            self.pairs = self.intersecting_moved();
        }
        if let Some((positions, owner)) = clear.filter(|_| !self.pairs.is_empty()) {
            (self.mesh.positions, self.owner) = (positions, owner);
        }
    }

    /// Moves the vertices of the `active` faces and of a ring round them. If one `slides`, vertices on a boundary move along it.
    fn move_round(&mut self, active: &BTreeSet<u32>, slides: bool) {
        let mut targets: BTreeMap<u32, DVec3> = BTreeMap::new();
        for f in active {
            let ring = self.ring([*f].iter());
            for g in &ring {
                self.clusters.join(*f, *g);
            }
            for v in ring.iter().flat_map(|g| self.mesh.faces[*g as usize]) {
                if targets.contains_key(&v) {
                    continue;
                }
                let target = match self.stays[v as usize] {
                    false => Some(self.target(v)),
                    true => self.border[&v].filter(|_| slides).map(|n| self.slid(v, n)),
                };
                if let Some(target) = target {
                    targets.insert(v, target);
                    self.owner.entry(v).or_insert(*f);
                }
            }
        }
        for (v, to) in targets {
            self.mesh.positions[v as usize] = to;
        }
    }

    /// Half of the way from a vertex to the mean of its neighbours, within the longest displacement.
    fn target(&self, v: u32) -> DVec3 {
        let at = self.mesh.positions[v as usize];
        let first = self.found.mesh.positions[v as usize];
        let (mut mean, mut length, mut count) = (DVec3::ZERO, 0.0, 0.0);
        for w in self
            .around
            .of(v)
            .iter()
            .flat_map(|f| self.mesh.faces[*f as usize])
        {
            if w != v {
                mean += self.mesh.positions[w as usize];
                length += self.found.mesh.positions[w as usize].distance(first);
                count += 1.0;
            }
        }
        let most = (RELAXED_REACH.get() * length / count).min(self.most);
        let to = at + RELAXED_STEP.get() * (mean / count - at);
        first + (to - first).clamp_length_max(most)
    }

    /// The point of a boundary next to a vertex that is nearest to half of the way to the mean of its two neighbours there.
    fn slid(&self, v: u32, neighbours: [u32; 2]) -> DVec3 {
        let at = |mesh: &Mesh, v: u32| mesh.positions[v as usize];
        let [before, after] = neighbours.map(|w| at(&self.mesh, w));
        let own = at(&self.mesh, v);
        let to = own + RELAXED_STEP.get() * (0.5 * (before + after) - own);
        let first = at(&self.found.mesh, v);
        let [a, b] = neighbours.map(|w| {
            let side = at(&self.found.mesh, w) - first;
            let along = (to - first).dot(side) / side.length_squared();
            first + along.clamp(0.0, 1.0) * side
        });
        if a.distance_squared(to) <= b.distance_squared(to) {
            a
        } else {
            b
        }
    }

    /// Puts back the clusters in which more than a small part of the faces that intersected do so still.
    fn put_back(&mut self, crossing: &[u32]) {
        loop {
            let pairs = self.intersecting_moved();
            let left: BTreeSet<u32> = pairs.into_iter().flatten().collect();
            let clusters = &mut self.clusters;
            let mut counts: BTreeMap<u32, [usize; 2]> = BTreeMap::new();
            for f in crossing {
                counts.entry(clusters.find(*f)).or_default()[0] += 1;
            }
            for f in &left {
                counts.entry(clusters.find(*f)).or_default()[1] += 1;
            }
            let is_bad = |cluster: u32| {
                let [before, left] = counts.get(&cluster).copied().unwrap_or_default();
                left as f64 > RELAXED_LEFT.get() * before as f64
            };
            let back: Vec<u32> = (self.owner.iter())
                .filter(|(_, f)| is_bad(clusters.find(**f)))
                .map(|(v, _)| *v)
                .collect();
            if back.is_empty() {
                return;
            }
            for v in back {
                self.owner.remove(&v);
                self.mesh.positions[v as usize] = self.found.mesh.positions[v as usize];
            }
        }
    }

    /// The faces with a moved vertex.
    fn moved(&self) -> BTreeSet<u32> {
        let faces = self.owner.keys().flat_map(|v| self.around.of(*v));
        faces.copied().collect()
    }

    /// The moved faces with their corners before and their largest displacements.
    fn moves(&self) -> Vec<([DVec3; 3], f64)> {
        let of = |f: u32| {
            let (from, to) = (self.found.mesh.corners(f), self.mesh.corners(f));
            let most = (0..3).map(|k| from[k].distance(to[k])).fold(0.0, f64::max);
            (from, most)
        };
        self.moved().into_iter().map(of).collect()
    }

    /// The moved faces that are folded onto a neighbour in a mesh with these faces, or have no area.
    fn folded(&self, mesh: &Mesh) -> BTreeSet<u32> {
        let normal = |f: u32| area_vector(mesh.corners(f)).normalize_or_zero();
        let is_folded = |f: &u32| {
            let own = normal(*f);
            let mut opposite = (3 * f..3 * f + 3).map(|h| self.found.topology.opposite[h as usize]);
            own == DVec3::ZERO
                || opposite.any(|o| o != NONE && own.dot(normal(o / 3)) < -FOLDED.get())
        };
        self.moved().into_iter().filter(is_folded).collect()
    }

    /// Whether more moved faces are folded than before.
    fn is_more_folded(&self) -> bool {
        self.folded(&self.mesh).len() > self.folded(&self.found.mesh).len()
    }
}
