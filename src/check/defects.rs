//! The defects of edges, vertices and faces.

use glam::DVec3;
use rayon::prelude::*;
use robust::{Coord, orient2d};

use super::{Component, Defect, DefectKind, Subject};
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{DisjointSets, Mesh, Topology, VertexFaces, has_several_fans};
use crate::spatial::{intersecting, partners};

impl Defect {
    /// Some of a kind whose faces are not told.
    pub(crate) fn named(kind: DefectKind, count: usize) -> Self {
        Self {
            kind,
            count,
            faces: Vec::new(),
            places: Vec::new(),
        }
    }

    /// Some of a kind, from all faces that have it in any order.
    pub(super) fn new(kind: DefectKind, count: usize, mut faces: Vec<u32>, mesh: &Mesh) -> Self {
        faces.sort_unstable();
        faces.dedup();
        let places = places(mesh, &faces);
        Self {
            kind,
            count,
            faces,
            places,
        }
    }
}

/// The middles of the groups of faces that hang together by vertices, in the order of their first faces.
fn places(mesh: &Mesh, faces: &[u32]) -> Vec<DVec3> {
    let mut corners: Vec<(u32, u32)> = faces
        .iter()
        .zip(0..)
        .flat_map(|(f, i)| mesh.faces[*f as usize].map(|v| (v, i)))
        .collect();
    corners.sort_unstable();
    let mut sets = DisjointSets::new(faces.len());
    for pair in corners.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        sets.join(pair[0].1, pair[1].1);
    }
    let mut sums: Vec<(DVec3, f64)> = vec![(DVec3::ZERO, 0.0); faces.len()];
    for (i, &f) in faces.iter().enumerate() {
        let [a, b, c] = mesh.corners(f);
        let sum = &mut sums[sets.find(i as u32) as usize];
        *sum = (sum.0 + (a + b + c) / 3.0, sum.1 + 1.0);
    }
    let some = sums.into_iter().filter(|(_, count)| *count > 0.0);
    some.map(|(sum, count)| sum / count).collect()
}

/// What the connectivity of a mesh tells: its border, edges and vertices that are not manifold, and how its faces are turned.
pub(super) fn of_topology(subject: &Subject) -> Vec<Defect> {
    let Subject { mesh, topology, .. } = *subject;
    let half_edges = || 0..topology.boundary.len() as u32;
    let border: Vec<u32> = half_edges()
        .filter(|&h| topology.boundary[h as usize])
        .map(|h| h / 3)
        .collect();
    let crowded = topology.crowded_edges(mesh);
    let at_crowded: Vec<u32> = crowded.iter().flatten().map(|h| h / 3).collect();
    let pinched = pinched(mesh, topology, &crowded);
    let around = VertexFaces::new(mesh);
    let at_pinched = pinched.iter().flat_map(|&v| around.of(v)).copied();
    // Two faces that were turned alike disagree where they still do.
    let misoriented: Vec<[u32; 2]> = half_edges()
        .filter_map(|h| {
            let o = topology.opposite[h as usize];
            let turned = |h: u32| topology.turned[h as usize / 3];
            let wrong = o != NONE
                && o < h
                && ((start(mesh, h) == start(mesh, o)) != (turned(h) != turned(o)));
            wrong.then_some([o / 3, h / 3])
        })
        .collect();
    let make = |kind, count, faces| Defect::new(kind, count, faces, mesh);
    vec![
        make(DefectKind::Border, border.len(), border),
        make(DefectKind::NonManifoldEdge, crowded.len(), at_crowded),
        make(
            DefectKind::NonManifoldVertex,
            pinched.len(),
            at_pinched.collect(),
        ),
        make(
            DefectKind::Misoriented,
            misoriented.len(),
            misoriented.concat(),
        ),
    ]
}

/// Vertices with several fans of faces that are on no edge with more than two faces.
fn pinched(mesh: &Mesh, topology: &Topology, crowded: &[Vec<u32>]) -> Vec<u32> {
    let around = VertexFaces::new(mesh);
    let mut on_crowded = vec![false; mesh.positions.len()];
    for &h in crowded.iter().flatten() {
        on_crowded[start(mesh, h) as usize] = true;
        on_crowded[end(mesh, h) as usize] = true;
    }
    (0..mesh.positions.len() as u32)
        .into_par_iter()
        .filter(|&v| !on_crowded[v as usize] && has_several_fans(mesh, topology, &around, v))
        .collect()
}

/// Closed components that enclose a negative volume, save those that lie inside an odd number of others: these are cavities.
pub(super) fn inside_out(subject: &Subject, components: &[Component]) -> Defect {
    let wrong: Vec<bool> = components.iter().map(Component::is_inside_out).collect();
    let topology = subject.topology;
    let faces = topology.faces();
    let faces = faces.filter(|&f| wrong[topology.component[f as usize] as usize]);
    let count = wrong.iter().filter(|wrong| **wrong).count();
    Defect::new(DefectKind::InsideOut, count, faces.collect(), subject.mesh)
}

impl Component {
    /// Whether it is closed, shows its inside, and is no cavity of another one.
    pub(crate) fn is_inside_out(&self) -> bool {
        self.closed && self.volume < 0.0 && self.depth.is_multiple_of(2)
    }
}

/// What is wrong with faces by themselves and with pairs of them.
pub(super) fn of_faces(subject: &Subject) -> [Defect; 3] {
    let Subject { mesh, topology, .. } = *subject;
    let degenerate: Vec<u32> = (0..mesh.faces.len() as u32)
        .into_par_iter()
        .filter(|&f| topology.component[f as usize] == NONE || is_flat(mesh.corners(f)))
        .collect();
    let twice = duplicates(mesh, topology);
    let crossing = crossing(mesh, topology);
    let crossing: Vec<u32> = crossing.iter().map(|pair| pair.0).collect();
    let make = |kind, faces: Vec<u32>| Defect::new(kind, faces.len(), faces, mesh);
    [
        make(DefectKind::Degenerate, degenerate),
        make(DefectKind::Duplicate, twice),
        make(DefectKind::Crossing, crossing),
    ]
}

/// Whether three points lie on one line, exactly.
pub(crate) fn is_flat(corners: [DVec3; 3]) -> bool {
    (0..3).all(|k| {
        let [a, b, c] = corners.map(|p| Coord {
            x: p[k],
            y: p[(k + 1) % 3],
        });
        orient2d(a, b, c) == 0.0
    })
}

/// Faces on the vertices of an earlier one, whichever way round, in rising order. Degenerate ones do not count.
pub(crate) fn duplicates(mesh: &Mesh, topology: &Topology) -> Vec<u32> {
    let mut keys: Vec<([u32; 3], u32)> = topology
        .faces()
        .map(|f| {
            let mut corners = mesh.faces[f as usize];
            corners.sort_unstable();
            (corners, f)
        })
        .collect();
    keys.par_sort_unstable();
    let again = keys.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    let mut faces: Vec<u32> = again.map(|pair| pair[1].1).collect();
    faces.sort_unstable();
    faces
}

/// The faces of a welded mesh that cross or touch others, in rising order, each with one of them. Faces that use a vertex twice
/// take no part.
pub(crate) fn crossing(mesh: &Mesh, topology: &Topology) -> Vec<(u32, u32)> {
    pairs(mesh, topology, |faces| {
        intersecting(&mesh.positions, faces, faces.len())
    })
}

/// Those of some faces in rising order, of which a search for [`crossing`] found others, each with the one that it found.
pub(crate) fn crossing_among(mesh: &Mesh, topology: &Topology, some: &[u32]) -> Vec<(u32, u32)> {
    if some.is_empty() {
        return Vec::new();
    }
    let proper: Vec<u32> = topology.faces().collect();
    let place = |f: &u32| proper.binary_search(f).ok().map(|i| i as u32);
    let asked: Vec<u32> = some.iter().filter_map(place).collect();
    pairs(mesh, topology, |faces| {
        partners(&mesh.positions, faces, &asked)
    })
}

/// What a search among the faces of a mesh that use no vertex twice finds, by the numbers of the mesh.
fn pairs(
    mesh: &Mesh,
    topology: &Topology,
    search: impl FnOnce(&[[u32; 3]]) -> Vec<(u32, u32)>,
) -> Vec<(u32, u32)> {
    let numbers: Vec<u32> = topology.faces().collect();
    let found = if numbers.len() == mesh.faces.len() {
        search(&mesh.faces)
    } else {
        let faces: Vec<[u32; 3]> = numbers.iter().map(|f| mesh.faces[*f as usize]).collect();
        search(&faces)
    };
    let number = |i: u32| numbers[i as usize];
    let numbered = found.into_iter().map(|(a, b)| (number(a), number(b)));
    numbered.collect()
}
