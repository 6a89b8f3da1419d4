//! Splits the new faces of a filled mesh into patches, and finds the input's face corners along their rims.

use std::collections::HashMap;

use crate::mesh::{Bodies, Mesh, weld_map, weld_map_of_bodies};

/// A vertex of one patch. A vertex of the mesh where several patches meet is a slot in each of them.
pub struct Slot {
    /// The patch.
    pub patch: u32,
    /// The vertex of the filled mesh.
    pub vertex: u32,
    /// Corners of the input's faces across the rim edges at the slot: face and corner. Empty inside the patch.
    pub rim: Vec<(u32, u8)>,
}

/// The new faces, split into patches that are connected through edges.
pub struct Patches {
    pub slots: Vec<Slot>,
    /// The new faces in order, with the indices of their slots as corners.
    pub faces: Vec<[u32; 3]>,
    /// The patch of each new face.
    pub of_face: Vec<u32>,
    /// The input's faces at the rim of each patch, in ascending order.
    pub rim_faces: Vec<Vec<u32>>,
    /// For each vertex of the original mesh, the first vertex at the same position.
    pub weld: Vec<u32>,
}

impl Patches {
    /// Vertices of different `bodies` stay apart.
    pub fn new(original: &Mesh, filled: &Mesh, bodies: Option<&Bodies>) -> Self {
        // Vertices of the mesh at the same position count as one, so that a patch stays connected where the mesh doubles
        // vertices (seams of texture coordinates).
        let weld = match bodies {
            None => weld_map(original),
            Some(bodies) => weld_map_of_bodies(original, bodies),
        };
        let canonical = |v: u32| weld.get(v as usize).copied().unwrap_or(v);
        let faces: Vec<[u32; 3]> = filled.faces[original.faces.len()..]
            .iter()
            .map(|f| f.map(canonical))
            .collect();
        // The new face of each directed edge. An edge that no new face uses in the opposite direction is on the rim of
        // a patch.
        let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
        for (f, face) in faces.iter().enumerate() {
            for k in 0..3 {
                edges
                    .entry((face[k], face[(k + 1) % 3]))
                    .or_insert(f as u32);
            }
        }
        let (of_face, count) = connected(&faces, &edges);
        // One slot per pair of patch and vertex, numbered in the order of the faces. Where two patches meet at a
        // vertex, each may have its own values.
        let (mut slots, mut number) = (Vec::new(), HashMap::new());
        let in_slots = faces
            .iter()
            .zip(&of_face)
            .map(|(face, &patch)| {
                face.map(|vertex| {
                    *number.entry((patch, vertex)).or_insert_with(|| {
                        slots.push(Slot {
                            patch,
                            vertex,
                            rim: Vec::new(),
                        });
                        slots.len() as u32 - 1
                    })
                })
            })
            .collect();
        let mut patches = Self {
            slots,
            faces: in_slots,
            of_face,
            rim_faces: vec![Vec::new(); count],
            weld,
        };
        // The input corners across the rim edges give the values at the rim.
        patches.find_rim_corners(original, &edges, &number);
        patches
    }

    /// Finds the input's faces and corners across the rim edges of the patches.
    fn find_rim_corners(
        &mut self,
        original: &Mesh,
        edges: &HashMap<(u32, u32), u32>,
        number: &HashMap<(u32, u32), u32>,
    ) {
        let mut on_rim = vec![false; original.positions.len()];
        for slot in &self.slots {
            if let Some(flag) = on_rim.get_mut(slot.vertex as usize) {
                *flag = true;
            }
        }
        for (f, face) in original.faces.iter().enumerate() {
            let corners = face.map(|v| self.weld[v as usize]);
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                if !on_rim[a as usize] || !on_rim[b as usize] {
                    continue;
                }
                // The new face has the edge in the opposite direction, unless the input's face is wrongly oriented.
                let (forth, back) = (edges.get(&(a, b)), edges.get(&(b, a)));
                let new = match (forth, back) {
                    (None, Some(new)) | (Some(new), None) => *new,
                    _ => continue,
                };
                let patch = self.of_face[new as usize];
                for (vertex, corner) in [(a, k), (b, (k + 1) % 3)] {
                    if let Some(&slot) = number.get(&(patch, vertex)) {
                        self.slots[slot as usize].rim.push((f as u32, corner as u8));
                    }
                }
                if self.rim_faces[patch as usize].last() != Some(&(f as u32)) {
                    self.rim_faces[patch as usize].push(f as u32);
                }
            }
        }
    }
}

/// The component of each face (connected through edges that two faces use in opposite directions), and the number of
/// components.
fn connected(faces: &[[u32; 3]], edges: &HashMap<(u32, u32), u32>) -> (Vec<u32>, usize) {
    let mut part = vec![u32::MAX; faces.len()];
    let (mut count, mut stack) = (0, Vec::new());
    for seed in 0..faces.len() {
        if part[seed] != u32::MAX {
            continue;
        }
        part[seed] = count as u32;
        stack.push(seed);
        while let Some(f) = stack.pop() {
            for k in 0..3 {
                let across = edges.get(&(faces[f][(k + 1) % 3], faces[f][k]));
                if let Some(&g) = across
                    && part[g as usize] == u32::MAX
                {
                    part[g as usize] = count as u32;
                    stack.push(g as usize);
                }
            }
        }
        count += 1;
    }
    (part, count)
}
