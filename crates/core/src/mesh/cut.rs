//! Cutting: removes marked faces from a mesh and leaves clean rims.

use std::collections::BTreeSet;

use super::topology::NONE;
use super::{DisjointSets, Mesh, Topology, VertexFaces};

/// Remaining parts with at most this number of faces are removed too,
const SMALL_FACES: usize = 2;
/// and remaining parts with at most 1 / `SMALL_PART` of the faces removed from their component.
const SMALL_PART: usize = 10;

/// Rounds in which single faces that stick out of the edge of a cut are removed too. One more would eat further along the edge:
/// on a regular mesh the edge of a mask rises and falls in steps of one row.
const SPIKE_ROUNDS: usize = 2;

/// The marks plus the faces with at least two marked neighbours: the edge of a mask is a staircase, and at its inner corners
/// single faces would stick into the cut.
pub fn without_spikes(topology: &Topology, marked: &[bool]) -> Vec<bool> {
    let mut marked = marked.to_vec();
    for _ in 0..SPIKE_ROUNDS {
        let is_spike = |f: &usize| {
            let sides = &topology.opposite[3 * f..3 * f + 3];
            let is_marked_neighbour = |o: &&u32| **o != NONE && marked[**o as usize / 3];
            !marked[*f] && sides.iter().filter(is_marked_neighbour).count() > 1
        };
        let spikes: Vec<usize> = (0..marked.len()).filter(is_spike).collect();
        spikes.iter().for_each(|&f| marked[f] = true);
        if spikes.is_empty() {
            break;
        }
    }
    marked
}

/// The faces to remove so that all marked faces are removed and clean rims remain.
///
/// If remaining faces would meet only in a vertex, the smaller fan is removed too. So are small parts that would remain inside
/// (parts of a few faces), and degenerate faces that would be connected to nothing. `mesh` is welded, `topology` is its topology.
/// If `small_parts` is false, only parts of one or two faces are removed.
pub fn settled(mesh: &Mesh, topology: &Topology, marked: &[bool], small_parts: bool) -> Vec<bool> {
    let around = VertexFaces::new(mesh);
    let mut removed = marked.to_vec();
    let corners = |faces: &[u32]| -> BTreeSet<u32> {
        faces.iter().flat_map(|&f| mesh.faces[f as usize]).collect()
    };
    let all = (0..mesh.faces.len() as u32).filter(|&f| marked[f as usize]);
    let mut queue = corners(&all.collect::<Vec<_>>());
    loop {
        while let Some(vertex) = queue.pop_first() {
            let more = smaller_fans(mesh, topology, around.of(vertex), vertex, &removed);
            more.iter().for_each(|&f| removed[f as usize] = true);
            queue.extend(corners(&more));
        }
        let more = small_parts_of(topology, &removed, small_parts);
        if more.is_empty() {
            break;
        }
        more.iter().for_each(|&f| removed[f as usize] = true);
        queue = corners(&more);
    }
    remove_loose(mesh, topology, &around, &mut removed);
    removed
}

/// The remaining faces at a vertex that are no longer connected around it, except the largest sector of each former fan.
fn smaller_fans(
    mesh: &Mesh,
    topology: &Topology,
    faces: &[u32],
    vertex: u32,
    removed: &[bool],
) -> Vec<u32> {
    let known = |f: u32| topology.component[f as usize] != NONE;
    let faces: Vec<u32> = faces.iter().copied().filter(|&f| known(f)).collect();
    let stays = |i: usize| !removed[faces[i] as usize];
    // Fans before the removal and sectors after it, as sets of the vertex's faces.
    let mut fans = DisjointSets::new(faces.len());
    let mut sectors = DisjointSets::new(faces.len());
    for (i, &f) in faces.iter().enumerate() {
        for k in 0..3 {
            let corners = mesh.faces[f as usize];
            if corners[k] != vertex && corners[(k + 1) % 3] != vertex {
                continue;
            }
            let opposite = topology.opposite[3 * f as usize + k];
            let Some(j) = (opposite != NONE)
                .then(|| faces.binary_search(&(opposite / 3)).ok())
                .flatten()
            else {
                continue;
            };
            fans.join(i as u32, j as u32);
            if stays(i) && stays(j) {
                sectors.join(i as u32, j as u32);
            }
        }
    }
    // The number of faces of each sector that stay, and the largest sector of each fan; of equal ones the one with the first face.
    let left: Vec<usize> = (0..faces.len()).filter(|&i| stays(i)).collect();
    let mut size = vec![0usize; faces.len()];
    let sector: Vec<usize> = (0..faces.len() as u32)
        .map(|i| sectors.find(i) as usize)
        .collect();
    left.iter().for_each(|&i| size[sector[i]] += 1);
    let fan: Vec<usize> = (0..faces.len() as u32)
        .map(|i| fans.find(i) as usize)
        .collect();
    let mut largest = vec![None; faces.len()];
    for &i in &left {
        let best = &mut largest[fan[i]];
        if best.is_none_or(|best| size[sector[i]] > size[best]) {
            *best = Some(sector[i]);
        }
    }
    let goes = left.iter().filter(|&&i| largest[fan[i]] != Some(sector[i]));
    goes.map(|&i| faces[i]).collect()
}

/// The faces of small parts of components that lost faces; the largest part of each component is not small.
fn small_parts_of(topology: &Topology, removed: &[bool], small_parts: bool) -> Vec<u32> {
    // Number of removed faces of each component.
    let mut lost = vec![0usize; topology.component_faces.len()];
    for (&component, _) in topology.component.iter().zip(removed).filter(|(_, r)| **r) {
        if component != NONE {
            lost[component as usize] += 1;
        }
    }
    // The connected parts of what remains of these components.
    let mut seen = removed.to_vec();
    let mut parts: Vec<(u32, Vec<u32>)> = Vec::new();
    for seed in 0..removed.len() {
        let component = topology.component[seed];
        if component == NONE || seen[seed] || lost[component as usize] == 0 {
            continue;
        }
        seen[seed] = true;
        let mut part = vec![seed as u32];
        let mut next = 0;
        while next < part.len() {
            for k in 0..3 {
                let opposite = topology.opposite[3 * part[next] as usize + k];
                if opposite != NONE && !std::mem::replace(&mut seen[opposite as usize / 3], true) {
                    part.push(opposite / 3);
                }
            }
            next += 1;
        }
        parts.push((component, part));
    }
    // Keeps the small ones in the list.
    let mut largest = vec![0; topology.component_faces.len()];
    for (component, part) in &parts {
        let most = &mut largest[*component as usize];
        *most = part.len().max(*most);
    }
    parts.retain(|(component, part)| {
        let most = match small_parts {
            true => SMALL_FACES.max(lost[*component as usize] / SMALL_PART),
            false => SMALL_FACES,
        };
        part.len() <= most && part.len() < largest[*component as usize]
    });
    parts.into_iter().flat_map(|(_, part)| part).collect()
}

/// Removes degenerate faces that touch removed ones and have a vertex that no remaining face uses.
fn remove_loose(mesh: &Mesh, topology: &Topology, around: &VertexFaces, removed: &mut [bool]) {
    for f in 0..mesh.faces.len() {
        if topology.component[f] != NONE || removed[f] {
            continue;
        }
        let of = |v: u32| around.of(v).iter().map(|&g| g as usize);
        let loose = mesh.faces[f].iter().any(|&v| {
            of(v).any(|g| removed[g])
                && !of(v).any(|g| topology.component[g] != NONE && !removed[g])
        });
        removed[f] = loose;
    }
}

/// The result of a cut: a mesh without some of its faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Remainder {
    /// The remaining mesh.
    pub mesh: Mesh,
    /// Marks the remaining faces.
    pub faces: Vec<bool>,
    /// Marks the remaining vertices.
    pub vertices: Vec<bool>,
}

impl Remainder {
    /// The mesh without the removed faces; everything else keeps its order. Vertices that only removed faces used are removed
    /// too, unless `all_vertices` is true.
    pub fn new(mesh: &Mesh, removed: &[bool], all_vertices: bool) -> Self {
        let mut vertices = vec![true; mesh.positions.len()];
        if !all_vertices {
            let marks = || mesh.faces.iter().zip(removed);
            marks()
                .filter(|(_, r)| **r)
                .for_each(|(f, _)| f.iter().for_each(|&v| vertices[v as usize] = false));
            marks()
                .filter(|(_, r)| !**r)
                .for_each(|(f, _)| f.iter().for_each(|&v| vertices[v as usize] = true));
        }
        let mut number = vec![NONE; vertices.len()];
        let mut left = Mesh::default();
        for (v, _) in vertices.iter().enumerate().filter(|(_, kept)| **kept) {
            number[v] = left.positions.len() as u32;
            left.positions.push(mesh.positions[v]);
        }
        let kept = mesh.faces.iter().zip(removed).filter(|(_, r)| !**r);
        left.faces
            .extend(kept.map(|(f, _)| f.map(|v| number[v as usize])));
        Self {
            mesh: left,
            faces: removed.iter().map(|r| !r).collect(),
            vertices,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A flat sheet of `n` × `n` squares, each of two faces.
    fn sheet(n: u32) -> Mesh {
        let mut mesh = Mesh::default();
        for i in 0..=n {
            for j in 0..=n {
                mesh.positions
                    .push(DVec3::new(f64::from(i), f64::from(j), 0.0));
            }
        }
        for i in 0..n {
            for j in 0..n {
                let (a, b) = (i * (n + 1) + j, (i + 1) * (n + 1) + j);
                mesh.faces.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
        }
        mesh
    }

    fn removed_faces(mesh: &Mesh, marked: impl Fn(DVec3) -> bool) -> Vec<bool> {
        let mut mesh = mesh.clone();
        let topology = Topology::new(&mut mesh);
        let centre =
            |f: &[u32; 3]| f.map(|v| mesh.positions[v as usize]).iter().sum::<DVec3>() / 3.0;
        let marks: Vec<bool> = mesh.faces.iter().map(|f| marked(centre(f))).collect();
        settled(&mesh, &topology, &marks, true)
    }

    #[test]
    fn regions_that_meet_in_a_vertex_become_one() {
        let mesh = sheet(8);
        let square = |p: DVec3, x: f64| p.x > x && p.x < x + 2.0 && p.y > x && p.y < x + 2.0;
        let removed = removed_faces(&mesh, |p| square(p, 2.0) || square(p, 4.0));
        let count = removed.iter().filter(|r| **r).count();
        assert!((17..=20).contains(&count), "{count}");
        let mut left = Remainder::new(&mesh, &removed, false).mesh;
        let mut topology = Topology::new(&mut left);
        let (holes, open) = crate::mesh::find_holes(&left, &mut topology);
        assert_eq!((holes.len(), open.len()), (2, 0));
        assert_eq!(topology.defects.non_manifold_boundary_vertices, 0);
    }

    #[test]
    fn small_parts_inside_go_and_the_rest_stays_in_order() {
        let mesh = sheet(8);
        let inner = |p: DVec3| (p - DVec3::new(4.3, 4.6, 0.0)).length() < 0.3;
        let ring = |p: DVec3| p.x > 2.0 && p.x < 6.0 && p.y > 2.0 && p.y < 6.0 && !inner(p);
        let removed = removed_faces(&mesh, ring);
        assert_eq!(removed.iter().filter(|r| **r).count(), 32);
        let left = Remainder::new(&mesh, &removed, false);
        assert_eq!(left.mesh.positions.len(), 81 - 9);
        let all = Remainder::new(&mesh, &removed, true);
        assert_eq!(all.mesh.positions, mesh.positions);
        let kept = mesh.faces.iter().zip(&removed).filter(|(_, r)| !**r);
        assert!(kept.map(|(f, _)| f).eq(&all.mesh.faces));
    }

    #[test]
    fn a_component_that_is_marked_entirely_is_removed_entirely() {
        assert!(removed_faces(&sheet(3), |_| true).iter().all(|r| *r));
        assert!(removed_faces(&sheet(3), |_| false).iter().all(|r| !*r));
    }
}
