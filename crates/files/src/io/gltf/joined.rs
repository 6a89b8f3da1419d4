//! Bodies of several nodes that new faces join.
//!
//! A node's positions are 32-bit floats in its own coordinates, so a point has different rounding errors under nodes with different
//! transforms, and faces of such nodes do not meet exactly. A body whose new faces have vertices of several such nodes is therefore
//! written under one of them.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;

use super::super::Contents;
use super::document::GltfDocument;
use super::scene::Block;
use isomend_core::mesh::DisjointSets;

/// Which faces are written under another node than their own.
#[derive(Default)]
pub(super) struct Joined {
    /// The block under whose node all faces of a connected component are written, for each vertex; none where nothing is joined.
    home: Vec<Option<u32>>,
}

/// What is known about a connected component.
#[derive(Default)]
struct Component {
    /// The coordinate systems of the vertices of its new faces.
    frames: Vec<usize>,
    /// The number of corners in each block.
    corners: BTreeMap<usize, usize>,
}

impl Joined {
    /// Finds the connected components whose new faces, those from `first` on, have vertices of nodes with different transforms.
    /// `of_file` is the vertex of the file that a vertex is, or is a copy of.
    pub(super) fn new(
        document: &GltfDocument,
        model: &Contents<'_>,
        first: usize,
        of_file: impl Fn(u32) -> Option<u32>,
    ) -> Self {
        let frames = frames(&document.blocks);
        let faces = &model.mesh.faces;
        if first >= faces.len() || frames.iter().all(|f| *f == 0) {
            return Self::default();
        }
        let mut sets = connected(&model.mesh.positions, faces);
        let mut components: BTreeMap<u32, Component> = BTreeMap::new();
        for (f, face) in faces.iter().enumerate() {
            let component = components.entry(sets.find(face[0])).or_default();
            for vertex in face.iter().filter_map(|v| of_file(*v)) {
                let block = document.block_of(vertex);
                *component.corners.entry(block).or_default() += 1;
                if f >= first && !component.frames.contains(&frames[block]) {
                    component.frames.push(frames[block]);
                }
            }
        }
        let joined = components.into_iter().filter(|(_, c)| c.frames.len() > 1);
        let homes: BTreeMap<u32, u32> = joined
            .map(|(set, c)| (set, most_corners(&c.corners) as u32))
            .collect();
        if homes.is_empty() {
            return Self::default();
        }
        let vertices = 0..model.mesh.positions.len() as u32;
        let home = vertices.map(|v| homes.get(&sets.find(v)).copied());
        Self {
            home: home.collect(),
        }
    }

    /// The block under whose node a face is written because its body is joined from several.
    pub(super) fn home(&self, face: [u32; 3]) -> Option<usize> {
        Some((*self.home.get(face[0] as usize)?)? as usize)
    }

    /// The block to which a face of a block moves: its body is written under a node with another transform.
    pub(super) fn new_home(
        &self,
        document: &GltfDocument,
        block: usize,
        face: [u32; 3],
    ) -> Option<usize> {
        let transform = |block: usize| document.blocks[block].transform;
        let home = self.home(face);
        home.filter(|home| transform(*home) != transform(block))
    }
}

/// The block with the most corners; the first of several.
pub(super) fn most_corners(corners: &BTreeMap<usize, usize>) -> usize {
    let most = corners
        .iter()
        .max_by_key(|(block, n)| (**n, usize::MAX - **block));
    most.map_or(0, |(block, _)| *block)
}

/// A number for each block, the same for blocks with equal transforms.
fn frames(blocks: &[Block]) -> Vec<usize> {
    let mut known: HashMap<[u64; 16], usize> = HashMap::new();
    let bits = |block: &Block| block.transform.to_cols_array().map(f64::to_bits);
    let mut number = |block| {
        let next = known.len();
        *known.entry(bits(block)).or_insert(next)
    };
    blocks.iter().map(&mut number).collect()
}

/// The connected components of faces that share vertices or positions.
fn connected(positions: &[DVec3], faces: &[[u32; 3]]) -> DisjointSets {
    let mut sets = DisjointSets::new(positions.len());
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    let bits = |v: u32| positions[v as usize].to_array().map(f64::to_bits);
    order.sort_unstable_by_key(|v| bits(*v));
    for pair in order.windows(2).filter(|p| bits(p[0]) == bits(p[1])) {
        sets.join(pair[0], pair[1]);
    }
    for [a, b, c] in faces {
        sets.join(*a, *b);
        sets.join(*a, *c);
    }
    sets
}
