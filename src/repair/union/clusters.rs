//! Which components are united with which: those that touch or intersect, directly or through others.

use std::collections::HashMap;

use crate::check::components;
use crate::mend::Inspection;
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{DisjointSets, Mesh, Topology};

/// Components to be united.
pub(super) struct Clusters {
    /// The faces of all of them, in rising order.
    pub(super) faces: Vec<u32>,
    /// For each face of the mesh its cluster; `u32::MAX` where it is in none.
    pub(super) of_face: Vec<u32>,
    /// How many bodies there are in them.
    pub(super) bodies: usize,
}

/// The clusters of closed components in which faces intersect; `pairs` are places in the list of faces that do.
pub(super) fn clusters(found: &Inspection, crossing: &[u32], pairs: &[[u32; 2]]) -> Clusters {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let count = topology.piece_faces.len();
    let piece = |f: u32| topology.piece[f as usize];
    // Bodies: components that share edges.
    let mut bodies = DisjointSets::new(count);
    let crowded = topology.crowded_edges(mesh);
    for edge in &crowded {
        edge.iter()
            .for_each(|h| _ = bodies.join(piece(edge[0] / 3), piece(h / 3)));
    }
    let mut sets = bodies.clone();
    for pair in pairs {
        let [f, g] = pair.map(|i| crossing[i as usize]);
        sets.join(piece(f), piece(g));
    }
    let all = components(mesh, topology, 0.0);
    for (i, c) in (0..).zip(&all) {
        // A cavity is one of the body round it.
        if let Some(outer) = c.inside.filter(|_| c.closed && c.volume < 0.0) {
            sets.join(i, outer as u32);
        }
    }
    let mut open = vec![false; count];
    for p in open_pieces(mesh, topology, &crowded) {
        open[sets.find(p) as usize] = true;
    }
    let mut takes_part = vec![false; count];
    for &f in crossing {
        let set = sets.find(piece(f));
        takes_part[set as usize] = !open[set as usize];
    }
    let of_piece: Vec<u32> = (0..count as u32)
        .map(|p| sets.find(p))
        .map(|set| if takes_part[set as usize] { set } else { NONE })
        .collect();
    let of_face: Vec<u32> = (topology.piece.iter())
        .map(|p| of_piece.get(*p as usize).copied().unwrap_or(NONE))
        .collect();
    let own = (0..count as u32).filter(|p| of_piece[*p as usize] != NONE);
    let mut own: Vec<u32> = own.map(|p| bodies.find(p)).collect();
    own.sort_unstable();
    own.dedup();
    Clusters {
        faces: (topology.faces())
            .filter(|f| of_face[*f as usize] != NONE)
            .collect(),
        of_face,
        bodies: own.len(),
    }
}

/// Those of some duplicate faces that bound bodies which touch in them: with them each edge of these bodies runs as often one way as the
/// other, without them not.
pub(in crate::repair) fn walls(found: &Inspection, duplicates: &[u32]) -> Vec<u32> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    if duplicates.is_empty() {
        return Vec::new();
    }
    let crowded = topology.crowded_edges(mesh);
    let piece = |f: u32| topology.piece[f as usize];
    let mut bodies = DisjointSets::new(topology.piece_faces.len());
    for edge in &crowded {
        edge.iter()
            .for_each(|h| _ = bodies.join(piece(edge[0] / 3), piece(h / 3)));
    }
    let mut open = vec![false; topology.piece_faces.len()];
    for p in open_pieces(mesh, topology, &crowded) {
        open[bodies.find(p) as usize] = true;
    }
    let mut sums: HashMap<(u32, u32), (i32, u32)> = HashMap::new();
    for h in duplicates.iter().flat_map(|f| 3 * f..3 * f + 3) {
        let (a, b) = (start(mesh, h), end(mesh, h));
        let sum = sums.entry((a.min(b), a.max(b))).or_insert((0, h));
        sum.0 += if runs_up(mesh, topology, h) { 1 } else { -1 };
    }
    let mut opens = vec![false; open.len()];
    for (sum, h) in sums.values() {
        opens[bodies.find(piece(h / 3)) as usize] |= *sum != 0;
    }
    let is_wall = |f: &&u32| {
        let body = bodies.find(piece(**f)) as usize;
        opens[body] && !open[body]
    };
    duplicates.iter().filter(is_wall).copied().collect()
}

/// Whether a half-edge of the mesh as it is given runs from the smaller to the larger number.
fn runs_up(mesh: &Mesh, topology: &Topology, h: u32) -> bool {
    (start(mesh, h) < end(mesh, h)) != topology.turned[h as usize / 3]
}

/// Components with edges along which not as many faces of the mesh as it is given run one way as the other.
fn open_pieces(mesh: &Mesh, topology: &Topology, crowded: &[Vec<u32>]) -> Vec<u32> {
    let runs_up = |h: u32| runs_up(mesh, topology, h);
    let mut open = Vec::new();
    for h in 0..topology.opposite.len() as u32 {
        let o = topology.opposite[h as usize];
        if topology.boundary[h as usize] || (o != NONE && runs_up(h) == runs_up(o)) {
            open.push(topology.piece[h as usize / 3]);
        }
    }
    for edge in crowded {
        let up = edge.iter().filter(|h| runs_up(**h)).count();
        if 2 * up != edge.len() {
            open.push(topology.piece[edge[0] as usize / 3]);
        }
    }
    open.retain(|p| *p != NONE);
    open.sort_unstable();
    open.dedup();
    open
}
