//! Search for intersecting faces among many long, thin faces: a tree of oriented boxes, and fans of faces around common vertices.
//!
//! The axis-aligned boxes of long, thin faces overlap although the faces do not: n sectors of a disc have about n² / 8 pairs of
//! overlapping boxes. Oriented boxes (Gottschalk, Lin and Manocha 1996) are as thin as the faces. Faces around a common vertex all
//! touch there; they are compared by their directions as seen from that vertex.

use glam::DVec3;
use rayon::prelude::*;

use super::oriented::{Oriented, OrientedTree, ROUNDING, Triangles};
use super::predicates::faces_intersect;
use super::{Bounds, BoxTree};
use crate::mesh::topology::NONE;
use crate::threads::CollectIndexed;

/// Faces. A vertex with at least this many is a hub: its faces are compared by their directions.
const HUB_FACES: u32 = 64;
/// Sizes of meshes between these bounds have squares that neither overflow nor underflow.
const SIZES: [f64; 2] = [1e-100, 1e100];

/// For each of the faces in `asked`, whether it intersects any other face; none if the coordinates are too large or too small
/// for squares of lengths.
pub(super) fn have_partners(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    asked: &[u32],
) -> Option<Vec<bool>> {
    let all = faces.iter().flatten().map(|&v| positions[v as usize]);
    let (low, high) = crate::mesh::bounds(all);
    let size = (high - low).max_element();
    if !(SIZES[0]..SIZES[1]).contains(&size) {
        return None;
    }
    let mesh = Soup {
        positions,
        faces,
        hub: hubs(positions.len(), faces),
        margin: ROUNDING * low.abs().max(high.abs()).max_element(),
    };
    // Corners relative to the centre: the margin is for their rounding errors.
    let centre = 0.5 * (low + high);
    let corners = |f: &[u32; 3]| f.map(|v| positions[v as usize] - centre);
    let corners: Vec<[DVec3; 3]> = faces.iter().map(corners).collect();
    let tree = OrientedTree::new(&Triangles {
        corners: &corners,
        groups: &mesh.hub,
        margin: mesh.margin,
    });
    let fans = mesh.fans();
    let places = mesh.places(&fans);
    let has = |&f: &u32| {
        let (fan, place) = places[f as usize];
        (fan != NONE && fans[fan as usize].has_partner(&mesh, place))
            || has_partner(&mesh, &tree, &corners, f)
    };
    Some(asked.par_iter().map(has).collect_indexed())
}

/// Faces with their hubs.
struct Soup<'a> {
    positions: &'a [DVec3],
    faces: &'a [[u32; 3]],
    /// For each face its vertex with the most faces, if that is a hub.
    hub: Vec<u32>,
    /// Margin of oriented boxes for rounding errors, in mesh units.
    margin: f64,
}

/// For each face its vertex with the most faces, the smaller number first, or `NONE` if it has fewer than [`HUB_FACES`].
fn hubs(vertices: usize, faces: &[[u32; 3]]) -> Vec<u32> {
    let mut valence = vec![0u32; vertices];
    faces
        .iter()
        .flatten()
        .for_each(|&v| valence[v as usize] += 1);
    let hub = |f: &[u32; 3]| {
        let most = f
            .iter()
            .max_by_key(|&&v| (valence[v as usize], u32::MAX - v));
        let is_hub = |v: &&u32| valence[**v as usize] >= HUB_FACES;
        most.filter(is_hub).copied().unwrap_or(NONE)
    };
    faces.iter().map(hub).collect()
}

impl Soup<'_> {
    fn intersect(&self, f: u32, g: u32) -> bool {
        f != g
            && faces_intersect(
                self.positions,
                self.faces[f as usize],
                self.faces[g as usize],
            )
    }

    /// The fans of all hubs, in the order of the hubs.
    fn fans(&self) -> Vec<Fan> {
        let with_hub = (0..self.faces.len() as u32).filter(|f| self.hub[*f as usize] != NONE);
        let mut by_hub: Vec<(u32, u32)> = with_hub.map(|f| (self.hub[f as usize], f)).collect();
        by_hub.sort_unstable();
        let groups = by_hub.chunk_by(|a, b| a.0 == b.0);
        groups.map(|group| Fan::new(self, group)).collect()
    }

    /// For each face the index of its fan and its place there; `NONE` for the faces without a hub.
    fn places(&self, fans: &[Fan]) -> Vec<(u32, u32)> {
        let mut places = vec![(NONE, 0); self.faces.len()];
        for (fan, i) in fans.iter().zip(0..) {
            for (&f, k) in fan.faces.iter().zip(0..) {
                places[f as usize] = (i, k);
            }
        }
        places
    }
}

/// The faces of a hub, as arcs on the unit sphere around it: the directions in which the hub sees each face. Two of these faces
/// have a further point in common if and only if their arcs have one.
struct Fan {
    faces: Vec<u32>,
    /// Boxes that contain the arcs.
    arcs: Vec<Bounds>,
    tree: BoxTree,
}

impl Fan {
    fn new(mesh: &Soup, group: &[(u32, u32)]) -> Self {
        let faces: Vec<u32> = group.iter().map(|(_, f)| *f).collect();
        let arcs: Vec<Bounds> = group.iter().map(|&(v, f)| arc(mesh, v, f)).collect();
        Self {
            tree: BoxTree::new(&arcs),
            faces,
            arcs,
        }
    }

    /// Whether the face at a place of the fan intersects another face of the fan.
    fn has_partner(&self, mesh: &Soup, place: u32) -> bool {
        let own = self.faces[place as usize];
        let hit = |other: u32| mesh.intersect(own, self.faces[other as usize]);
        self.tree.find(&self.arcs[place as usize], hit).is_some()
    }
}

/// A box around the arc of directions in which a vertex sees its face.
fn arc(mesh: &Soup, vertex: u32, face: u32) -> Bounds {
    let at = mesh.positions[vertex as usize];
    let corners = mesh.faces[face as usize];
    let k = corners.iter().position(|&v| v == vertex).unwrap_or(0);
    let direction = |k: usize| {
        let way = mesh.positions[corners[k % 3] as usize] - at;
        (way / way.abs().max_element()).normalize()
    };
    let (a, b) = (direction(k + 1), direction(k + 2));
    let chord = Bounds::of([a, b, a]);
    // An arc of angle t rises 1 - cos(t / 2) over its chord; the length of a + b is 2 cos(t / 2).
    let rise = 1.0 - 0.5 * (a + b).length();
    match rise.is_finite() {
        true => chord.widened(rise + 1e-12),
        // A corner lies on the vertex: the face has no direction.
        false => Bounds::of_ball(DVec3::ZERO, 2.0),
    }
}

/// Whether a face intersects another one, other than faces of the same hub.
fn has_partner(mesh: &Soup, tree: &OrientedTree, corners: &[[DVec3; 3]], face: u32) -> bool {
    let own = Oriented::around(&corners[face as usize], mesh.margin);
    let hub = mesh.hub[face as usize];
    let mut stack = vec![0u32];
    while let Some(i) = stack.pop() {
        let node = &tree.nodes[i as usize];
        let is_own_fan = node.group != NONE && node.group == hub;
        if is_own_fan || !node.bounds.meets(&own) {
            continue;
        }
        if node.second != 0 {
            stack.extend([node.second, i + 1]);
            continue;
        }
        let faces = tree.triangles(node);
        if faces.iter().any(|&other| mesh.intersect(face, other)) {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::noise;
    use glam::DMat3;

    /// Faces of every kind that the search treats apart: two fans with a common rim, one of them pierced, slivers in many
    /// directions, small faces.
    fn mixed() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let mut noise = noise(5);
        let mut random = || DVec3::new(noise(), noise(), noise()) - 0.5;
        let turn = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(0.3);
        let n = 200u32;
        let mut positions: Vec<DVec3> = (0..n)
            .map(|i| f64::from(i) * std::f64::consts::TAU / f64::from(n))
            .map(|t| turn * DVec3::new(t.cos(), t.sin(), 0.0))
            .collect();
        positions.extend([turn * DVec3::Z, turn * -DVec3::Z]);
        let mut faces = Vec::new();
        for i in 0..n {
            let next = (i + 1) % n;
            faces.extend([[i, next, n], [next, i, n + 1]]);
        }
        // A face at the first hub that runs through its fan.
        positions.push(turn * DVec3::new(0.5, 0.4, 0.0));
        faces.push([n, 3, n + 2]);
        for k in 0..300 {
            let length = if k % 2 == 0 { 0.8 } else { 0.05 };
            let from = 2.0 * random();
            let way = length * random();
            let at = positions.len() as u32;
            positions.extend([from, from + way, from + 0.5 * way + 0.01 * random()]);
            faces.push([at, at + 1, at + 2]);
        }
        (positions, faces)
    }

    #[test]
    fn the_faces_with_partners_are_those_of_all_pairs() {
        let (positions, faces) = mixed();
        for (scale, shift) in [(1.0, 0.0), (1e-6, 3.0), (1e9, 0.0)] {
            let positions: Vec<DVec3> = positions.iter().map(|p| scale * *p + shift).collect();
            let asked: Vec<u32> = (0..faces.len() as u32).collect();
            let found = have_partners(&positions, &faces, &asked).unwrap();
            let hit =
                |i: usize, j: usize| i != j && faces_intersect(&positions, faces[i], faces[j]);
            let wanted: Vec<bool> = (0..faces.len())
                .map(|i| (0..faces.len()).any(|j| hit(i, j)))
                .collect();
            let some = wanted.iter().filter(|w| **w).count();
            assert!(some > 20 && some < faces.len() - 200, "{some}");
            assert_eq!(found, wanted, "scale {scale}, shift {shift}");
        }
    }

    #[test]
    fn sizes_beyond_squares_are_refused() {
        let huge = [DVec3::ZERO, 1e200 * DVec3::X, 1e200 * DVec3::Y];
        assert_eq!(have_partners(&huge, &[[0, 1, 2]], &[0]), None);
    }
}
