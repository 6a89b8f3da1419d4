//! Writes a glTF document with patches: the original content is kept, and patches are added as new nodes.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use serde_json::{Map, Value, json};

use super::super::{Contents, Format, IoError, Written};
use super::build::Builder;
use super::document::GltfDocument;
use super::joined::{Joined, most_corners};
use super::patch_materials;
use super::scene::{Block, PlacedPrimitive};
use super::values;
use super::write::push_floats;
use isomend_core::mesh::DisjointSets;
use isomend_core::mesh::attributes::{LabelKind, Labels, NONE, PATCH_NAME, Role};

/// The name of nodes and meshes of faces that left their own node.
const JOINED_NAME: &str = "isomend_joined";

/// Writes the original document with the new faces of the mesh, and without the removed ones.
pub(super) fn write(
    document: &GltfDocument,
    model: &Contents<'_>,
    format: Format,
) -> Result<Written, IoError> {
    let mut builder = merge(document);
    let mut notes = Vec::new();
    let patches = Patches::new(document, model);
    remove_faces(&mut builder, &patches);
    let mut materials =
        patch_materials::PatchMaterials::new(document, model.attributes, &mut builder);
    let mut meshes: BTreeMap<(usize, bool), Vec<Value>> = BTreeMap::new();
    for (group, faces) in &patches.groups {
        let block = &document.blocks[group.block];
        let mut primitive = patches.primitive(&mut builder, block, faces, format)?;
        if group.is_new {
            primitive["extras"] = json!({ PATCH_NAME: true });
        }
        if group.material != NONE {
            primitive["material"] = json!(materials.index(&mut builder, group.material));
        }
        let mesh = meshes.entry((group.block, group.is_new)).or_default();
        mesh.push(primitive);
    }
    for ((block, is_new), primitives) in meshes {
        let name = if is_new { PATCH_NAME } else { JOINED_NAME };
        add_node(&mut builder, document.blocks[block].node, name, primitives);
    }
    if patches.has_skinning() {
        notes.push(
            "joints and weights are left out on the patches, which follow their node only"
                .to_owned(),
        );
    }
    notes.extend(patches.joined_faces());
    let bytes = builder.finish(format)?;
    Ok(Written { bytes, notes })
}

/// Copies the document with all loaded buffers joined into one; buffer views are adjusted.
fn merge(document: &GltfDocument) -> Builder {
    let mut builder = Builder {
        json: document.json.clone(),
        data: Vec::new(),
    };
    let old = std::mem::take(builder.list("buffers"));
    builder.list("buffers").push(json!({}));
    let mut moved = Vec::new();
    // Buffers of the same file are written once.
    let mut written = BTreeMap::new();
    for (index, buffer) in document.buffers.iter().enumerate() {
        match buffer {
            Some(bytes) => {
                let start = *written.entry(Arc::as_ptr(bytes)).or_insert_with(|| {
                    let start = builder.data.len().next_multiple_of(4);
                    builder.data.resize(start, 0);
                    builder.data.extend_from_slice(bytes);
                    start
                });
                moved.push((0, start as u64));
            }
            None => {
                let outside = old.get(index).cloned().unwrap_or(Value::Null);
                moved.push((builder.push("buffers", outside), 0));
            }
        }
    }
    if builder.json.get("bufferViews").is_some() {
        for view in builder.list("bufferViews") {
            let buffer = view.get("buffer").and_then(Value::as_u64).unwrap_or(0);
            if let Some((to, start)) = moved.get(buffer as usize) {
                let offset = view.get("byteOffset").and_then(Value::as_u64).unwrap_or(0);
                view["buffer"] = json!(to);
                view["byteOffset"] = json!(offset + start);
            }
        }
    }
    builder
}

/// Writes new indices for primitives that lost faces. A mesh that several nodes use is copied for the node whose instance lost
/// faces.
fn remove_faces(builder: &mut Builder, patches: &Patches<'_>) {
    let document = patches.document;
    let mut copied: BTreeMap<usize, usize> = BTreeMap::new();
    let mut emptied: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (part, faces) in document.kept_faces(patches.model) {
        let new_home = |face: &[u32; 3]| patches.joined.new_home(document, part.block, *face);
        let staying = || faces.iter().filter(|face| new_home(face).is_none());
        if staying().count() == part.faces.1 {
            continue;
        }
        let block = &document.blocks[part.block];
        let mesh = own_mesh(builder, document, part, &mut copied);
        if staying().next().is_none() {
            emptied.entry(mesh).or_default().push(part.primitive);
            continue;
        }
        let mirrored = block.transform.determinant() < 0.0;
        let local = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|v| v - block.start);
            if mirrored { [a, c, b] } else { [a, b, c] }
        };
        let corners: Vec<u32> = staying().flat_map(local).collect();
        let indices = builder.indices(&corners);
        let primitive = &mut builder.list("meshes")[mesh]["primitives"][part.primitive];
        primitive["indices"] = json!(indices);
        primitive["mode"] = json!(4);
    }
    remove_primitives(builder, &emptied);
}

/// The mesh of a placed primitive; copied first if other nodes use it too.
fn own_mesh(
    builder: &mut Builder,
    document: &GltfDocument,
    part: &PlacedPrimitive,
    copied: &mut BTreeMap<usize, usize>,
) -> usize {
    let node = document.blocks[part.block].node;
    let users = builder.list("nodes").iter();
    let users = users.filter(|n| n.get("mesh").and_then(Value::as_u64) == Some(part.mesh as u64));
    if let Some(copy) = copied.get(&node) {
        return *copy;
    }
    if users.count() <= 1 {
        return part.mesh;
    }
    let copy = builder.list("meshes")[part.mesh].clone();
    let copy = builder.push("meshes", copy);
    builder.list("nodes")[node]["mesh"] = json!(copy);
    copied.insert(node, copy);
    copy
}

/// Removes primitives from their meshes, and references to meshes without faces from their nodes.
fn remove_primitives(builder: &mut Builder, emptied: &BTreeMap<usize, Vec<usize>>) {
    for (mesh, primitives) in emptied {
        let Some(list) = builder.list("meshes")[*mesh]["primitives"].as_array_mut() else {
            continue;
        };
        let mut place = 0;
        let all_gone = primitives.len() == list.len();
        if !all_gone {
            list.retain(|_| {
                place += 1;
                !primitives.contains(&(place - 1))
            });
            continue;
        }
        // A glTF mesh must have a primitive. A mesh that lost all faces therefore stays in the file, but no node refers to it.
        for node in builder.list("nodes") {
            if node.get("mesh").and_then(Value::as_u64) == Some(*mesh as u64)
                && let Some(node) = node.as_object_mut()
            {
                node.remove("mesh");
                node.remove("skin");
                node.remove("weights");
            }
        }
    }
}

/// Adds a mesh as a child of a node.
fn add_node(builder: &mut Builder, node: usize, name: &str, primitives: Vec<Value>) {
    let mesh = builder.push("meshes", json!({ "name": name, "primitives": primitives }));
    let child = builder.push("nodes", json!({ "name": name, "mesh": mesh }));
    let parent = &mut builder.list("nodes")[node];
    match parent.get_mut("children").and_then(Value::as_array_mut) {
        Some(children) => children.push(json!(child)),
        None => parent["children"] = json!([child]),
    }
}

/// Faces that are written as one primitive.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Group {
    /// The block under whose node they are written.
    block: usize,
    /// The label of their material.
    material: u32,
    /// Whether they are new, or faces of the file that left their own node.
    is_new: bool,
}

/// The new faces, and the faces that are written under another node than their own.
struct Patches<'a> {
    document: &'a GltfDocument,
    model: &'a Contents<'a>,
    /// The original vertex of each vertex that is a copy.
    origin: BTreeMap<u32, u32>,
    materials: Option<&'a Labels>,
    joined: Joined,
    groups: BTreeMap<Group, Vec<[u32; 3]>>,
}

impl<'a> Patches<'a> {
    fn new(document: &'a GltfDocument, model: &'a Contents<'a>) -> Self {
        let mut patches = Self {
            document,
            model,
            origin: model.attributes.copies.iter().copied().collect(),
            materials: model.attributes.labels_of(LabelKind::Material),
            joined: Joined::default(),
            groups: BTreeMap::new(),
        };
        let first = document.kept(model);
        patches.joined = Joined::new(document, model, first, |v| patches.of_file(v));
        patches.leaving();
        for faces in patches.connected(first) {
            let joined = patches.joined.home(model.mesh.faces[faces[0]]);
            let block = joined.unwrap_or_else(|| patches.home(&faces));
            faces.into_iter().for_each(|f| patches.add(f, block, true));
        }
        patches
    }

    /// Adds the faces of the file that are written under another node than their own.
    fn leaving(&mut self) {
        let (document, model) = (self.document, self.model);
        let kept = document.kept_faces(model);
        let kept = kept.flat_map(|(part, faces)| faces.iter().map(|face| (part.block, *face)));
        for (f, (block, face)) in kept.enumerate() {
            if let Some(home) = self.joined.new_home(document, block, face) {
                self.add(f, home, false);
            }
        }
    }

    /// Adds a face to its group.
    fn add(&mut self, face: usize, block: usize, is_new: bool) {
        let group = Group {
            block,
            material: self.materials.map_or(NONE, |m| m.of_face[face]),
            is_new,
        };
        let faces = self.groups.entry(group).or_default();
        faces.push(self.model.mesh.faces[face]);
    }

    /// The note about the faces that left their own node.
    fn joined_faces(&self) -> Option<String> {
        let leaving = self.groups.iter().filter(|(group, _)| !group.is_new);
        let count: usize = leaving.map(|(_, faces)| faces.len()).sum();
        (count > 0).then(|| {
            format!(
                "bodies of several nodes were joined: {count} faces are written under the node of the body that they were joined to, \
                 rounded to 32-bit coordinates there"
            )
        })
    }

    /// The vertex of the file that a vertex is, or is a copy of.
    fn of_file(&self, vertex: u32) -> Option<u32> {
        let vertex = self.origin.get(&vertex).copied().unwrap_or(vertex);
        ((vertex as usize) < self.document.counts().0).then_some(vertex)
    }

    /// The connected components (through vertices) of the new faces, from face `first` on.
    fn connected(&self, first: usize) -> Vec<Vec<usize>> {
        let faces = &self.model.mesh.faces;
        let mut sets = DisjointSets::new(self.model.mesh.positions.len());
        for face in &faces[first..] {
            sets.join(face[0], face[1]);
            sets.join(face[0], face[2]);
        }
        let mut parts: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (f, face) in faces.iter().enumerate().skip(first) {
            parts.entry(sets.find(face[0])).or_default().push(f);
        }
        parts.into_values().collect()
    }

    /// The block with the most corners of the given faces.
    fn home(&self, faces: &[usize]) -> usize {
        let mut votes: BTreeMap<usize, usize> = BTreeMap::new();
        let corners = faces.iter().flat_map(|f| self.model.mesh.faces[*f]);
        for vertex in corners.filter_map(|v| self.of_file(v)) {
            *votes.entry(self.document.block_of(vertex)).or_default() += 1;
        }
        most_corners(&votes)
    }

    /// Whether the file has skinning attributes, which patches cannot have.
    fn has_skinning(&self) -> bool {
        let mut all = self.model.attributes.vertex.iter();
        !self.groups.is_empty() && all.any(|a| is_skinning(&a.name))
    }

    /// A primitive of faces in the local coordinates of a block's node.
    fn primitive(
        &self,
        builder: &mut Builder,
        block: &Block,
        faces: &[[u32; 3]],
        format: Format,
    ) -> Result<Value, IoError> {
        let mut vertices: Vec<u32> = faces.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let number = |v: u32| vertices.partition_point(|w| *w < v) as u32;
        let mirrored = block.transform.determinant() < 0.0;
        let corners: Vec<u32> = faces
            .iter()
            .flat_map(|face| {
                let [a, b, c] = face.map(number);
                if mirrored { [a, c, b] } else { [a, b, c] }
            })
            .collect();
        let points = self.local_points(block, &vertices, format)?;
        let mut attributes = Map::new();
        attributes.insert("POSITION".to_owned(), json!(builder.positions(&points)));
        self.attributes(builder, block, &vertices, &mut attributes);
        let indices = builder.indices(&corners);
        Ok(json!({
            "attributes": attributes, "indices": indices, "mode": 4
        }))
    }

    /// Positions in the local coordinates of the block's node. Vertices of blocks with its transform keep the coordinates of the file.
    fn local_points(
        &self,
        block: &Block,
        vertices: &[u32],
        format: Format,
    ) -> Result<Vec<[f32; 3]>, IoError> {
        let inverse = block.transform.inverse();
        let local = |v: u32| {
            if block.local.is_empty() {
                return self.model.mesh.positions[v as usize];
            }
            let of_file = self
                .of_file(v)
                .map(|v| (v, &self.document.blocks[self.document.block_of(v)]));
            match of_file.filter(|(_, own)| own.transform == block.transform) {
                Some((v, own)) => DVec3::from_array(own.local[(v - own.start) as usize]),
                None => inverse.transform_point3(self.model.mesh.positions[v as usize]),
            }
        };
        let points = vertices.iter().map(|v| local(*v).as_vec3());
        points
            .map(|p| match p.is_finite() {
                true => Ok(p.to_array()),
                false => Err(IoError::NotWritable {
                    format,
                    what: format!(
                        "the transform of node {} is not invertible, so that no patch can be placed under it",
                        block.node
                    ),
                    advice: "write PLY instead, or apply the transforms first",
                }),
            })
            .collect()
    }

    /// Adds the attributes for which all vertices have a value, except joints and weights.
    fn attributes(
        &self,
        builder: &mut Builder,
        block: &Block,
        vertices: &[u32],
        names: &mut Map<String, Value>,
    ) {
        let (mut sets, mut colours) = (0, 0);
        for attribute in &self.model.attributes.vertex {
            let all = vertices
                .iter()
                .all(|v| attribute.get(*v as usize).is_some());
            // Sets must be numbered without gaps.
            let next = match attribute.name.split_once('_') {
                Some(("TEXCOORD", set)) => set == sets.to_string(),
                Some(("COLOR", set)) => set == colours.to_string(),
                _ => true,
            };
            if !all || !next || is_skinning(&attribute.name) || attribute.components > 4 {
                continue;
            }
            sets += usize::from(matches!(attribute.role, Role::Uv(_)));
            colours += usize::from(attribute.role == Role::Colour);
            let mut floats = Vec::with_capacity(vertices.len() * attribute.components);
            for v in vertices {
                let mut value = attribute.get(*v as usize).unwrap_or(&[]).to_vec();
                if matches!(attribute.role, Role::Normal | Role::Tangent) && value.len() >= 3 {
                    let vector = DVec3::from_slice(&value);
                    let turned = values::turn_back(block, attribute.role, vector);
                    value[..3].copy_from_slice(&turned.to_array());
                }
                push_floats(&mut floats, attribute, Some(&value));
            }
            let accessor = builder.floats(&floats, attribute.components);
            names.insert(attribute.name.clone(), json!(accessor));
        }
    }
}

fn is_skinning(name: &str) -> bool {
    name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_")
}
