//! Defects of edges, vertices and faces: open, non-manifold and misoriented edges, degenerate, duplicate and intersecting faces.

use glam::DVec3;
use rayon::prelude::*;
use robust::{Coord, orient2d};

use super::{Component, Defect, DefectKind, Subject};
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{DisjointSets, Mesh, Topology, VertexFaces, has_several_fans};
use crate::spatial::{intersecting, partners};
use crate::threads::CollectFiltered;

impl Defect {
    /// A defect without a list of its faces.
    pub(crate) fn named(kind: DefectKind, count: usize) -> Self {
        Self {
            kind,
            count,
            faces: Vec::new(),
            places: Vec::new(),
        }
    }

    /// A defect from all faces that have it, in any order.
    pub(super) fn new(kind: DefectKind, count: usize, mut faces: Vec<u32>, mesh: &Mesh) -> Self {
        faces.sort_unstable();
        faces.dedup();
        let corners: Vec<[u32; 3]> = faces.iter().map(|f| mesh.faces[*f as usize]).collect();
        Self {
            faces,
            places: places(mesh, &corners),
            ..Self::named(kind, count)
        }
    }

    /// A defect of edges or vertices, with all faces at these.
    fn at<const N: usize>(
        kind: DefectKind,
        at: &[[u32; N]],
        mut faces: Vec<u32>,
        mesh: &Mesh,
    ) -> Self {
        faces.sort_unstable();
        faces.dedup();
        Self {
            faces,
            places: places(mesh, at),
            ..Self::named(kind, at.len())
        }
    }
}

/// A place of each group of faces, edges or vertices connected by vertices, in the order of their first members: the mean of their
/// centres, of faces the centre that is nearest to it, so that it lies on the surface.
fn places<const N: usize>(mesh: &Mesh, items: &[[u32; N]]) -> Vec<DVec3> {
    let corners = (0..).zip(items).flat_map(|(i, item)| item.map(|v| (v, i)));
    let mut corners: Vec<(u32, u32)> = corners.collect();
    corners.sort_unstable();
    let mut sets = DisjointSets::new(items.len());
    for pair in corners.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        sets.join(pair[0].1, pair[1].1);
    }
    let centre = |item: &[u32; N]| {
        let all: DVec3 = item.iter().map(|v| mesh.positions[*v as usize]).sum();
        all / N as f64
    };
    let centres: Vec<DVec3> = items.iter().map(centre).collect();
    let groups: Vec<usize> = (0..items.len() as u32)
        .map(|i| sets.find(i) as usize)
        .collect();
    let mut sums: Vec<(DVec3, f64)> = vec![(DVec3::ZERO, 0.0); items.len()];
    for (centre, group) in centres.iter().zip(&groups) {
        let sum = &mut sums[*group];
        *sum = (sum.0 + centre, sum.1 + 1.0);
    }
    let mut places: Vec<DVec3> = sums.iter().map(|(sum, count)| sum / count).collect();
    if N == 3 {
        let mut nearest = vec![(f64::INFINITY, DVec3::ZERO); items.len()];
        for (centre, group) in centres.iter().zip(&groups) {
            let distance = centre.distance(places[*group]);
            if distance < nearest[*group].0 {
                nearest[*group] = (distance, *centre);
            }
        }
        places = nearest.into_iter().map(|(_, centre)| centre).collect();
    }
    let of_groups = places.into_iter().zip(sums);
    let of_groups = of_groups.filter(|(_, (_, count))| *count > 0.0);
    of_groups.map(|(place, _)| place).collect()
}

/// Defects visible from the connectivity: boundary edges, non-manifold edges and vertices, and edges whose faces disagree in
/// orientation.
pub(super) fn of_topology(subject: &Subject) -> Vec<Defect> {
    let Subject { mesh, topology, .. } = *subject;
    let half_edges = || 0..topology.boundary.len() as u32;
    let edge = |h: u32| [start(mesh, h), end(mesh, h)];
    let is_border = |h: &u32| topology.boundary[*h as usize];
    let border: Vec<u32> = half_edges().filter(is_border).collect();
    let crowded = topology.non_manifold_edges(mesh);
    let around = VertexFaces::new(mesh);
    let pinched = pinched(mesh, topology, &around, &crowded);
    // Undo the reorientation: faces disagree in the input if they disagree now or exactly one of them was turned, but not both.
    let misoriented: Vec<u32> = half_edges()
        .filter(|&h| {
            let o = topology.opposite[h as usize];
            let turned = |h: u32| topology.turned[h as usize / 3];
            o != NONE && o < h && ((start(mesh, h) == start(mesh, o)) != (turned(h) != turned(o)))
        })
        .collect();
    let edges =
        |half_edges: &[u32]| -> Vec<[u32; 2]> { half_edges.iter().map(|h| edge(*h)).collect() };
    let first = |edge: &Vec<u32>| edge.first().copied();
    let crowded_edges: Vec<u32> = crowded.iter().filter_map(first).collect();
    let both = |h: &u32| [topology.opposite[*h as usize] / 3, h / 3];
    let at_pinched = pinched.iter().flat_map(|&v| around.of(v)).copied();
    let pinched: Vec<[u32; 1]> = pinched.iter().map(|v| [*v]).collect();
    vec![
        Defect::at(
            DefectKind::BoundaryEdge,
            &edges(&border),
            border.iter().map(|h| h / 3).collect(),
            mesh,
        ),
        Defect::at(
            DefectKind::NonManifoldEdge,
            &edges(&crowded_edges),
            crowded.iter().flatten().map(|h| h / 3).collect(),
            mesh,
        ),
        Defect::at(
            DefectKind::NonManifoldVertex,
            &pinched,
            at_pinched.collect(),
            mesh,
        ),
        Defect::at(
            DefectKind::Misoriented,
            &edges(&misoriented),
            misoriented.iter().flat_map(both).collect(),
            mesh,
        ),
    ]
}

/// Non-manifold vertices: several fans of faces meet there. Vertices of non-manifold edges are not counted.
fn pinched(
    mesh: &Mesh,
    topology: &Topology,
    around: &VertexFaces,
    crowded: &[Vec<u32>],
) -> Vec<u32> {
    let mut on_crowded = vec![false; mesh.positions.len()];
    for &h in crowded.iter().flatten() {
        on_crowded[start(mesh, h) as usize] = true;
        on_crowded[end(mesh, h) as usize] = true;
    }
    (0..mesh.positions.len() as u32)
        .into_par_iter()
        .filter(|&v| !on_crowded[v as usize] && has_several_fans(mesh, topology, around, v))
        .collect_filtered()
}

/// Closed components with negative volume, except cavities, which lie inside an odd number of others.
pub(super) fn inside_out(subject: &Subject, components: &[Component]) -> Defect {
    let wrong: Vec<bool> = components.iter().map(Component::is_inside_out).collect();
    let topology = subject.topology;
    let faces = topology.faces();
    let faces = faces.filter(|&f| wrong[topology.component[f as usize] as usize]);
    let count = wrong.iter().filter(|wrong| **wrong).count();
    Defect::new(DefectKind::InsideOut, count, faces.collect(), subject.mesh)
}

impl Component {
    /// Whether the component is closed, inside out, and not a cavity of another one.
    pub(crate) fn is_inside_out(&self) -> bool {
        self.closed && self.volume < 0.0 && self.depth.is_multiple_of(2)
    }
}

/// Degenerate, duplicate and intersecting faces.
pub(super) fn of_faces(subject: &Subject) -> [Defect; 3] {
    let Subject { mesh, topology, .. } = *subject;
    let degenerate: Vec<u32> = (0..mesh.faces.len() as u32)
        .into_par_iter()
        .filter(|&f| topology.component[f as usize] == NONE || is_flat(mesh.corners(f)))
        .collect_filtered();
    let twice = duplicates(mesh, topology);
    let crossing = self_intersections(mesh, topology);
    let crossing: Vec<u32> = crossing.iter().map(|pair| pair.0).collect();
    let make = |kind, faces: Vec<u32>| Defect::new(kind, faces.len(), faces, mesh);
    [
        make(DefectKind::Degenerate, degenerate),
        make(DefectKind::Duplicate, twice),
        make(DefectKind::SelfIntersection, crossing),
    ]
}

/// Whether three points are collinear, decided exactly.
#[doc(hidden)]
pub fn is_flat(corners: [DVec3; 3]) -> bool {
    (0..3).all(|k| {
        let [a, b, c] = corners.map(|p| Coord {
            x: p[k],
            y: p[(k + 1) % 3],
        });
        orient2d(a, b, c) == 0.0
    })
}

/// Faces with the same three vertices as an earlier face, in either orientation, ascending. Degenerate faces do not count.
#[doc(hidden)]
pub fn duplicates(mesh: &Mesh, topology: &Topology) -> Vec<u32> {
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

/// The faces of a welded mesh that intersect or touch others, ascending, each with one of them. Faces that use a vertex twice are
/// ignored.
#[doc(hidden)]
pub fn self_intersections(mesh: &Mesh, topology: &Topology) -> Vec<(u32, u32)> {
    pairs(mesh, topology, |faces| {
        intersecting(&mesh.positions, faces, faces.len())
    })
}

/// Some of the faces that [`self_intersections`] reports, given in ascending order, each with the partner that it reports.
#[doc(hidden)]
pub fn self_intersections_among(mesh: &Mesh, topology: &Topology, some: &[u32]) -> Vec<(u32, u32)> {
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

/// Runs a search on the faces that use no vertex twice and returns its result in face numbers of the mesh.
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
