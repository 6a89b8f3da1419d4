//! Clusters of components to unite: those that touch or intersect, directly or through others.

use std::collections::{BTreeSet, HashMap};
use std::f64::consts::TAU;

use crate::check::components;
use crate::elementary::atan2;
use crate::mend::Inspection;
use crate::mesh::topology::{NONE, apex, end, start};
use crate::mesh::{DisjointSets, Mesh, Topology};
use crate::repair::balance::{open_sets, ran_up};

/// Radians. Faces at an edge whose angles differ by less count as lying on each other. Rounding to 32-bit floats tilts faces of a
/// hundredth of the size of the coordinates by this angle.
const COINCIDENT_ANGLE: f64 = 1e-5;

/// Clusters of components to unite.
pub(super) struct Clusters {
    /// The faces of all clusters, ascending.
    pub(super) faces: Vec<u32>,
    /// The cluster of each face of the mesh; `u32::MAX` if it is in none.
    pub(super) of_face: Vec<u32>,
    /// Number of bodies in the clusters.
    pub(super) bodies: usize,
}

/// Components grouped by shared edges, as touching bodies have once their vertices are merged.
pub(super) struct Bodies {
    sets: DisjointSets,
    /// For the representative of each group whether an edge is unbalanced: more faces run one way along it than the other.
    open: Vec<bool>,
}

impl Bodies {
    pub(super) fn new(found: &Inspection) -> Self {
        let (mesh, topology) = (&found.mesh, &found.topology);
        let count = topology.component_faces.len();
        let component = |h: u32| topology.component[h as usize / 3];
        let crowded = topology.non_manifold_edges(mesh);
        let mut sets = DisjointSets::new(count);
        for edge in &crowded {
            edge.iter()
                .for_each(|h| _ = sets.join(component(edge[0]), component(*h)));
        }
        let runs_up = |h: u32| ran_up(mesh, topology, h);
        let open = open_sets(topology, &crowded, |p| sets.find(p), runs_up);
        Self { sets, open }
    }

    /// Whether any of these faces belongs to a closed group.
    pub(super) fn any_closed(&mut self, topology: &Topology, faces: &[u32]) -> bool {
        faces.iter().any(|f| self.is_closed(topology, *f))
    }

    /// Whether a face belongs to a closed group.
    fn is_closed(&mut self, topology: &Topology, face: u32) -> bool {
        let component = topology.component[face as usize];
        component != NONE && !self.open[self.sets.find(component) as usize]
    }
}

/// The clusters of closed bodies with intersecting faces. `pairs` are indices into `crossing`.
pub(super) fn clusters(
    found: &Inspection,
    bodies: Bodies,
    crossing: &[u32],
    pairs: &[[u32; 2]],
) -> Clusters {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let count = topology.component_faces.len() as u32;
    let component = |f: u32| topology.component[f as usize];
    let Bodies {
        mut sets,
        open: own_open,
    } = bodies;
    let closed: Vec<bool> = (0..count)
        .map(|p| !own_open[sets.find(p) as usize])
        .collect();
    for pair in pairs {
        let [f, g] = pair.map(|i| crossing[i as usize]);
        sets.join(component(f), component(g));
    }
    let all = components(mesh, topology, 0.0);
    for ((i, c), closed) in (0..).zip(&all).zip(closed) {
        // A cavity belongs to the body that encloses it.
        if let Some(outer) = c.inside.filter(|_| closed && c.volume < 0.0) {
            sets.join(i, outer as u32);
        }
    }
    // A cluster with an open component is open.
    let mut open = vec![false; count as usize];
    for p in (0..count).filter(|p| own_open[*p as usize]) {
        open[sets.find(p) as usize] = true;
    }
    let mut takes_part = vec![false; count as usize];
    for &f in crossing {
        let set = sets.find(component(f)) as usize;
        takes_part[set] = !open[set];
    }
    // Only closed sets with intersecting faces take part.
    let of_component: Vec<u32> = (0..count)
        .map(|p| sets.find(p))
        .map(|set| if takes_part[set as usize] { set } else { NONE })
        .collect();
    let of_face: Vec<u32> = (topology.component.iter())
        .map(|p| of_component.get(*p as usize).copied().unwrap_or(NONE))
        .collect();
    let mut paired = paired_components(mesh, topology);
    let own = (0..count).filter(|p| of_component[*p as usize] != NONE);
    let own: BTreeSet<u32> = own.map(|p| paired.find(p)).collect();
    Clusters {
        faces: (topology.faces())
            .filter(|f| of_face[*f as usize] != NONE)
            .collect(),
        of_face,
        bodies: own.len(),
    }
}

/// Joins components across non-manifold edges if a body lies between two of their faces. Of coincident faces each counts for its
/// own body.
pub(in crate::repair) fn paired_components(mesh: &Mesh, topology: &Topology) -> DisjointSets {
    let mut sets = DisjointSets::new(topology.component_faces.len());
    for edge in topology.non_manifold_edges(mesh) {
        let a = start(mesh, edge[0]);
        let at = |v: u32| mesh.positions[v as usize];
        let along = (at(end(mesh, edge[0])) - at(a)).normalize_or_zero();
        let across = |h: u32| (at(apex(mesh, h)) - at(a)).reject_from_normalized(along);
        let x = across(edge[0]).normalize_or_zero();
        let y = along.cross(x);
        let angle = |h: u32| atan2(y.dot(across(h)), x.dot(across(h)));
        let (up, down): (Vec<u32>, Vec<u32>) =
            (edge.iter().copied()).partition(|h| start(mesh, *h) == a);
        // The body extends from the face that runs down to the face that runs up, in the direction of rising angle.
        // Pair each face with the nearest one that runs the other way, smallest angles first.
        let mut turns: Vec<(f64, u32, u32)> = Vec::new();
        for (&d, &u) in down.iter().flat_map(|d| up.iter().map(move |u| (d, u))) {
            let turn = (angle(u) - angle(d)).rem_euclid(TAU);
            let is_none = !(COINCIDENT_ANGLE..=TAU - COINCIDENT_ANGLE).contains(&turn);
            turns.push((if is_none { TAU } else { turn }, d, u));
        }
        turns.sort_by(|s, t| s.0.total_cmp(&t.0).then((s.1, s.2).cmp(&(t.1, t.2))));
        let mut taken = BTreeSet::new();
        for (_, d, u) in turns {
            if !taken.contains(&d) && !taken.contains(&u) {
                taken.extend([d, u]);
                let component = |h: u32| topology.component[h as usize / 3];
                sets.join(component(d), component(u));
            }
        }
    }
    sets
}

/// Whether all of these faces belong to closed bodies.
pub(in crate::repair) fn are_closed(found: &Inspection, faces: &[u32]) -> bool {
    let mut bodies = Bodies::new(found);
    (faces.iter()).all(|f| bodies.is_closed(&found.topology, *f))
}

/// The duplicate faces that are walls between touching bodies: with them each edge of the bodies is balanced, without them not.
pub(in crate::repair) fn walls(found: &Inspection, duplicates: &[u32]) -> Vec<u32> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    if duplicates.is_empty() {
        return Vec::new();
    }
    let mut bodies = Bodies::new(found);
    let mut sums: HashMap<(u32, u32), (i32, u32)> = HashMap::new();
    for h in duplicates.iter().flat_map(|f| 3 * f..3 * f + 3) {
        let (a, b) = (start(mesh, h), end(mesh, h));
        let sum = sums.entry((a.min(b), a.max(b))).or_insert((0, h));
        sum.0 += if ran_up(mesh, topology, h) { 1 } else { -1 };
    }
    let mut body = |f: u32| bodies.sets.find(topology.component[f as usize]) as usize;
    let mut opens = vec![false; topology.component_faces.len()];
    for (sum, h) in sums.values() {
        opens[body(h / 3)] |= *sum != 0;
    }
    let of: Vec<usize> = duplicates.iter().map(|f| body(*f)).collect();
    let walls = duplicates.iter().zip(of);
    walls
        .filter(|(_, body)| opens[*body] && !bodies.open[*body])
        .map(|(f, _)| *f)
        .collect()
}
