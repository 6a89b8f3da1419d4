//! The meshes of a USD stage as they are collected, before their polygons are cut.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::DMat4;

use super::super::mesh_builder::MeshBuilder;
use super::super::text::Distinct;
use super::layer::Value;
use super::primvar::Primvar;

/// The meshes of a stage.
pub(super) struct Scene {
    pub(super) surface: MeshBuilder,
    pub(super) meshes: Vec<StageMesh>,
    /// For each face, the mesh and the face of it.
    pub(super) faces: Vec<(u32, u32)>,
    /// For each corner of these faces, the corner of the mesh.
    pub(super) corners: Vec<u32>,
    /// How many things of each kind are skipped.
    pub(super) skipped: BTreeMap<&'static str, usize>,
    /// How many things of each kind are not written back.
    pub(super) others: BTreeMap<&'static str, usize>,
    pub(super) names: Distinct,
}

impl Scene {
    /// Counts something that is skipped.
    pub(super) fn skip(&mut self, what: &'static str, count: usize) {
        if count > 0 {
            *self.skipped.entry(what).or_default() += count;
        }
    }

    /// What is not written back, with counts.
    pub(super) fn rest(&self) -> Vec<String> {
        let others = self.others.iter().filter(|(_, count)| **count > 0);
        let mut all: Vec<String> = others
            .map(|(what, count)| format!("{what}: {count}"))
            .collect();
        all.sort_unstable();
        all
    }
}

/// A mesh of the stage.
pub(super) struct StageMesh {
    pub(super) name: String,
    pub(super) transform: DMat4,
    /// Its vertices in the whole mesh.
    pub(super) vertices: Range<usize>,
    /// The number of its faces in the file, before any are left out.
    pub(super) face_count: usize,
    pub(super) primvars: Vec<Primvar>,
    /// The material of faces that no subset has.
    pub(super) material: Option<String>,
    pub(super) subsets: Vec<Subset>,
}

/// A subset of the faces of a mesh.
pub(super) struct Subset {
    /// Its material, or its own name if it has none.
    pub(super) name: String,
    pub(super) is_material: bool,
    /// The numbers of its faces, which need not exist.
    pub(super) faces: Value,
}

impl Subset {
    /// The numbers of its faces that a mesh of `count` faces has.
    pub(super) fn faces_of(&self, count: usize) -> impl Iterator<Item = u32> + '_ {
        let range = 0.0..count as f64;
        let all = self.faces.numbers().iter();
        all.filter(move |face| range.contains(face))
            .map(|face| *face as u32)
    }
}
