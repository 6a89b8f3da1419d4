//! Vertex welding: merges points that are exactly equal (zero equals minus zero).

use std::hash::Hasher;

use glam::DVec3;
use rustc_hash::FxHasher;

use super::{Bodies, Mesh};

/// For each vertex, the first vertex at exactly the same position.
///
/// This map connects files that split vertices at seams or have no indices; the mesh itself keeps its vertices.
pub fn weld_map(mesh: &Mesh) -> Vec<u32> {
    let mut welder = Welder::with_capacity(mesh.positions.len());
    let mut first = Vec::with_capacity(mesh.positions.len());
    let of = |(v, p): (usize, &DVec3)| {
        let Some(index) = welder.index(*p) else {
            return v as u32;
        };
        if index as usize == first.len() {
            first.push(v as u32);
        }
        first[index as usize]
    };
    mesh.positions.iter().enumerate().map(of).collect()
}

/// The same within each body: vertices of different bodies at the same position stay apart.
pub fn weld_map_of_bodies(mesh: &Mesh, bodies: &Bodies) -> Vec<u32> {
    let mut map: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    for own in &bodies.vertices {
        let positions = own.iter().map(|v| mesh.positions[*v as usize]);
        let part = Mesh::new(positions.collect(), Vec::new());
        for (v, first) in own.iter().zip(weld_map(&part)) {
            map[*v as usize] = own[first as usize];
        }
    }
    map
}

/// The mesh with its faces on welded vertices, and the number of merged vertices.
pub fn welded(mesh: &Mesh) -> (Mesh, usize) {
    let map = weld_map(mesh);
    let merged = map
        .iter()
        .enumerate()
        .filter(|&(v, &w)| v as u32 != w)
        .count();
    let faces = mesh
        .faces
        .iter()
        .map(|f| f.map(|v| map[v as usize]))
        .collect();
    (Mesh::new(mesh.positions.clone(), faces), merged)
}

/// Assigns the same index to equal points, in the order of their first occurrence. Zero and minus zero are equal.
///
/// An open-addressing hash table of indices; the points themselves are the keys.
pub struct Welder {
    /// The distinct points.
    pub points: Vec<DVec3>,
    slots: Vec<u32>,
}

const EMPTY: u32 = u32::MAX;

impl Welder {
    /// A welder with room for about `points` distinct points.
    pub fn with_capacity(points: usize) -> Self {
        let slots = (points * 2).next_power_of_two().max(64);
        Self {
            points: Vec::with_capacity(points),
            slots: vec![EMPTY; slots],
        }
    }

    /// The index of a point; `None` if 32-bit indices are exhausted.
    pub fn index(&mut self, point: DVec3) -> Option<u32> {
        if self.points.len() * 2 > self.slots.len() {
            self.grow();
        }
        let slot = self.slot_of(point);
        if self.slots[slot] == EMPTY {
            let index = u32::try_from(self.points.len())
                .ok()
                .filter(|index| *index != EMPTY)?;
            self.slots[slot] = index;
            self.points.push(point);
        }
        Some(self.slots[slot])
    }

    /// The slot that contains the point, or the empty slot where it would be inserted.
    fn slot_of(&self, point: DVec3) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash(point) as usize & mask;
        while self.slots[slot] != EMPTY && self.points[self.slots[slot] as usize] != point {
            slot = (slot + 1) & mask;
        }
        slot
    }

    fn grow(&mut self) {
        let size = self.slots.len() * 2;
        self.slots.clear();
        self.slots.resize(size, EMPTY);
        for (index, point) in self.points.iter().enumerate() {
            let mut slot = hash(*point) as usize & (size - 1);
            while self.slots[slot] != EMPTY {
                slot = (slot + 1) & (size - 1);
            }
            self.slots[slot] = index as u32;
        }
    }
}

/// A key of a position: the same for positions that are equal.
fn position_key(point: DVec3) -> [u64; 3] {
    // Adding zero turns minus zero into zero.
    point.to_array().map(|x| (x + 0.0).to_bits())
}

/// A key of the corners of a face: the same in each order of the corners.
pub(crate) fn corner_key(corners: [DVec3; 3]) -> [[u64; 3]; 3] {
    let mut key = corners.map(position_key);
    key.sort_unstable();
    key
}

fn hash(point: DVec3) -> u64 {
    let mut hasher = FxHasher::default();
    position_key(point)
        .into_iter()
        .for_each(|x| hasher.write_u64(x));
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_points_share_an_index_in_order_of_occurrence() {
        let mut welder = Welder::with_capacity(0);
        let points: Vec<DVec3> = (0..1000)
            .map(|i| DVec3::new(f64::from(i % 500), 0.0, f64::from(i % 7 % 2)))
            .collect();
        let indices: Vec<u32> = points.iter().map(|p| welder.index(*p).unwrap()).collect();
        let mut seen: Vec<DVec3> = Vec::new();
        for (point, index) in points.iter().zip(indices) {
            let expected = seen.iter().position(|s| s == point).unwrap_or_else(|| {
                seen.push(*point);
                seen.len() - 1
            });
            assert_eq!(index as usize, expected);
        }
        assert_eq!(welder.points, seen);
        let zero = welder.index(DVec3::new(0.0, -0.0, -0.0));
        assert_eq!(zero, Some(0));
    }

    #[test]
    fn vertices_map_to_the_first_at_their_position() {
        let (a, b) = (DVec3::X, DVec3::new(0.0, -0.0, 2.0));
        let mesh = Mesh::new(
            vec![a, b, a, -DVec3::ZERO + b, a],
            vec![[2, 1, 3], [4, 3, 0]],
        );
        assert_eq!(weld_map(&mesh), [0, 1, 0, 1, 0]);
        let (welded, merged) = welded(&mesh);
        assert_eq!((welded.faces, merged), (vec![[0, 1, 1], [0, 1, 0]], 3));
    }
}
