//! Traverses the nodes of a glTF scene and collects the triangles and attributes of their meshes.

use std::collections::BTreeMap;

use glam::{DMat4, DQuat, DVec3};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::scene::Node;
use gltf_json::validation::Checked;
use gltf_json::{Root, Value};

use super::super::mesh_builder::MeshBuilder;
use super::super::{Format, IoError, Location};
use super::accessor::{self, Raw};
use super::buffers::Buffers;
use super::morph;
use isomend_core::mesh::attributes::PATCH_NAME;

/// Most vertices, and most triangles, that are collected from a file.
const MOST: usize = 1 << 26;

/// Estimated memory in bytes of a block and of one of its attributes, without their values.
const BLOCK: usize = 512;
const NAMED: usize = 256;

/// A range of vertices from one accessor of positions, under one node.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct Block {
    pub(super) node: usize,
    /// From the node's local coordinates to the scene.
    pub(super) transform: DMat4,
    pub(super) start: u32,
    pub(super) count: u32,
    /// The positions in local coordinates; empty if these equal the scene's.
    pub(super) local: Vec<[f64; 3]>,
    position: usize,
    /// The accessors of displacements that are added to the positions, each with its weight.
    #[serde(default)]
    morph: Vec<(usize, f32)>,
    /// The accessors of the other attributes by name.
    attributes: BTreeMap<String, usize>,
}

/// The triangles of a primitive under a node.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct PlacedPrimitive {
    pub(super) mesh: usize,
    pub(super) primitive: usize,
    /// The block of its vertices.
    pub(super) block: usize,
    /// The first face and the number of faces.
    pub(super) faces: (usize, usize),
    pub(super) material: Option<usize>,
    /// Whether an earlier run of isomend marked it as a patch.
    pub(super) patch: bool,
}

/// The collected content of a scene.
pub(super) struct Scene {
    pub(super) surface: MeshBuilder,
    pub(super) blocks: Vec<Block>,
    pub(super) parts: Vec<PlacedPrimitive>,
    /// Vertex attributes: block, name and values.
    pub(super) values: Vec<(usize, String, Raw)>,
}

/// Collects the triangles of the default scene. A mesh is read once for each node that uses it.
pub(super) fn read(root: &Root, buffers: &mut Buffers<'_>) -> Result<Scene, IoError> {
    let mut reader = Reader {
        root,
        scene: Scene {
            surface: MeshBuilder::new(buffers.format),
            blocks: Vec::new(),
            parts: Vec::new(),
            values: Vec::new(),
        },
        skipped_primitives: 0,
        unread_attributes: 0,
        morphed: 0,
        buffers,
    };
    let mut visited = vec![false; root.nodes.len()];
    let mut stack: Vec<(usize, DMat4)> = start(root, reader.buffers.format)?
        .into_iter()
        .map(|n| (n, DMat4::IDENTITY))
        .collect();
    stack.reverse();
    let mut skinned = 0;
    while let Some((index, outer)) = stack.pop() {
        let fault = |what: String| {
            IoError::malformed(reader.buffers.format, Location::Item("node", index), what)
        };
        let Some(node) = root.nodes.get(index) else {
            return Err(fault(format!(
                "the file has only {} nodes",
                root.nodes.len()
            )));
        };
        if std::mem::replace(&mut visited[index], true) {
            return Err(fault(
                "it is reached twice, so the nodes form a cycle or share a child".to_string(),
            ));
        }
        let transform = outer * local_transform(node);
        if let Some(mesh) = node.mesh {
            reader.mesh(mesh.value(), index, &transform)?;
        }
        skinned += usize::from(node.skin.is_some());
        stack.extend(
            node.children
                .iter()
                .flatten()
                .rev()
                .map(|child| (child.value(), transform)),
        );
    }
    reader.remark(skinned);
    reader.spend_on_attributes()?;
    Ok(reader.scene)
}

/// The root nodes: the roots of the default scene, or if the file has no scene all nodes without a parent.
fn start(root: &Root, format: Format) -> Result<Vec<usize>, IoError> {
    let scene = root.scene.map_or(0, |scene| scene.value());
    match root.scenes.get(scene) {
        Some(scene) => Ok(scene.nodes.iter().map(|node| node.value()).collect()),
        None if root.scene.is_none() => {
            let mut is_child = vec![false; root.nodes.len()];
            for child in root
                .nodes
                .iter()
                .flat_map(|node| node.children.iter().flatten())
            {
                if let Some(flag) = is_child.get_mut(child.value()) {
                    *flag = true;
                }
            }
            Ok((0..root.nodes.len())
                .filter(|node| !is_child[*node])
                .collect())
        }
        None => {
            let what = format!(
                "the default scene is {scene}, but the file has only {}",
                root.scenes.len()
            );
            Err(IoError::malformed(format, Location::File, what))
        }
    }
}

/// Whether the extras mark a primitive as a patch.
fn is_marked(extras: Option<&gltf_json::extras::RawValue>) -> bool {
    let extras = extras.and_then(|raw| serde_json::from_str::<Value>(raw.get()).ok());
    extras.is_some_and(|e| {
        e.get(PATCH_NAME)
            .is_some_and(|mark| *mark == Value::Bool(true))
    })
}

fn local_transform(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |r| {
        DQuat::from_array(r.0.map(f64::from)).normalize()
    });
    DMat4::from_scale_rotation_translation(
        node.scale.map_or(DVec3::ONE, vector),
        rotation,
        node.translation.map_or(DVec3::ZERO, vector),
    )
}

struct Reader<'r, 'b> {
    root: &'r Root,
    buffers: &'r mut Buffers<'b>,
    scene: Scene,
    skipped_primitives: usize,
    unread_attributes: usize,
    /// Number of primitives whose positions are displaced by the default weights of their morph targets.
    morphed: usize,
}

impl Reader<'_, '_> {
    /// Adds remarks on skipped content.
    fn remark(&mut self, skinned: usize) {
        if skinned > 0 {
            self.scene.surface.notes.push(format!(
                "nodes whose skin was ignored, so that their mesh is in its bind pose: {skinned}"
            ));
        }
        if self.skipped_primitives > 0 {
            let note = format!(
                "primitives of points or lines, skipped: {}",
                self.skipped_primitives
            );
            self.scene.surface.notes.push(note);
        }
        if self.morphed > 0 {
            let what =
                "primitives in the shape that the default weights of their morph targets give";
            let note = format!("{what}: {}", self.morphed);
            self.scene.surface.notes.push(note);
        }
        if self.unread_attributes > 0 {
            let note = format!(
                "vertex attributes that cannot be read and are left out: {}",
                self.unread_attributes
            );
            self.scene.surface.notes.push(note);
        }
    }

    fn mesh(&mut self, index: usize, node: usize, transform: &DMat4) -> Result<(), IoError> {
        let Some(mesh) = self.root.meshes.get(index) else {
            let what = format!("the file has only {} meshes", self.root.meshes.len());
            return Err(IoError::malformed(
                self.buffers.format,
                Location::Item("mesh", index),
                what,
            ));
        };
        // Primitives of a mesh often share their positions; these are read only once.
        let first_block = self.scene.blocks.len();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let mode = match primitive.mode {
                Checked::Valid(
                    mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan),
                ) => mode,
                Checked::Valid(_) => {
                    self.skipped_primitives += 1;
                    continue;
                }
                Checked::Invalid => {
                    return Err(self.fault(index, "a primitive has an unknown mode".to_string()));
                }
            };
            let weights = self.root.nodes[node].weights.as_ref();
            let weights = weights
                .or(mesh.weights.as_ref())
                .map_or(&[][..], Vec::as_slice);
            let morph = morph::displacements(primitive, weights);
            self.morphed += usize::from(!morph.is_empty());
            let block = self.block(index, primitive, morph, first_block, (node, transform))?;
            let start = self.scene.surface.triangles_mut().len();
            self.primitive(index, primitive, mode, block)?;
            let end = self.scene.surface.triangles_mut().len();
            self.scene.parts.push(PlacedPrimitive {
                mesh: index,
                primitive: number,
                block,
                faces: (start, end - start),
                material: primitive.material.map(|m| m.value()),
                patch: mesh.name.as_deref() == Some(PATCH_NAME)
                    || is_marked(primitive.extras.as_deref()),
            });
        }
        Ok(())
    }

    fn primitive(
        &mut self,
        mesh: usize,
        primitive: &Primitive,
        mode: Mode,
        block: usize,
    ) -> Result<(), IoError> {
        let Block {
            start,
            count,
            transform,
            ..
        } = self.scene.blocks[block];
        let mut corners = match primitive.indices {
            Some(indices) => accessor::indices(self.buffers, indices.value())?,
            None => (0..count).collect(),
        };
        if let Some(outside) = corners.iter().find(|corner| **corner >= count) {
            return Err(self.fault(
                mesh,
                format!("an index is {outside}, but the primitive has only {count} vertices"),
            ));
        }
        // Bytes: each triangle takes 12; a strip or fan has nearly one triangle per corner.
        let each = if mode == Mode::Triangles { 4 } else { 12 };
        self.buffers.spend(each * corners.len())?;
        corners.iter_mut().for_each(|corner| *corner += start);
        self.faces(mesh, mode, &corners, transform.determinant() < 0.0)
    }

    /// The block of a primitive's vertices. Reuses a block of the same mesh with the same positions, unless an
    /// attribute of the same name has another accessor.
    fn block(
        &mut self,
        mesh: usize,
        primitive: &Primitive,
        morph: Vec<(usize, f32)>,
        first: usize,
        (node, transform): (usize, &DMat4),
    ) -> Result<usize, IoError> {
        let Some(position) = primitive
            .attributes
            .get(&Checked::Valid(Semantic::Positions))
        else {
            return Err(self.fault(mesh, "a primitive has no positions".to_string()));
        };
        let position = position.value();
        let attributes: BTreeMap<String, usize> = primitive
            .attributes
            .iter()
            .filter_map(|(name, index)| match name {
                Checked::Valid(Semantic::Positions) | Checked::Invalid => None,
                Checked::Valid(name) => Some((name.to_string(), index.value())),
            })
            .collect();
        let agrees = |block: &Block| {
            let other = |name: &String, accessor: &usize| {
                block.attributes.get(name).is_some_and(|a| a != accessor)
            };
            block.position == position
                && block.morph == morph
                && !attributes.iter().any(|(n, a)| other(n, a))
        };
        let found = self.scene.blocks[first..].iter().position(agrees);
        let block = match found {
            Some(found) => first + found,
            None => {
                self.buffers.spend(BLOCK)?;
                let (start, count, local) = self.positions(mesh, position, &morph, transform)?;
                self.scene.blocks.push(Block {
                    node,
                    transform: *transform,
                    start,
                    count,
                    local,
                    position,
                    morph,
                    attributes: BTreeMap::new(),
                });
                self.scene.blocks.len() - 1
            }
        };
        for (name, accessor) in attributes {
            self.attribute(block, name, accessor)?;
        }
        Ok(block)
    }

    /// Reads an attribute of a block, unless it was read before. A damaged attribute is left out.
    fn attribute(&mut self, block: usize, name: String, accessor: usize) -> Result<(), IoError> {
        if self.scene.blocks[block].attributes.contains_key(&name) {
            return Ok(());
        }
        self.buffers.spend(NAMED)?;
        let count = self.scene.blocks[block].count as usize;
        // Attributes of another length are not decoded.
        let known = self.root.accessors.get(accessor);
        let fits = known.is_some_and(|a| a.count.0 == count as u64);
        match fits.then(|| accessor::attribute(self.buffers, accessor)) {
            Some(Ok(raw)) if raw.values.len() == count * raw.components => {
                self.scene.values.push((block, name.clone(), raw));
            }
            Some(Err(error)) if self.buffers.budget.is_exhausted() => return Err(error),
            _ => self.unread_attributes += 1,
        }
        self.scene.blocks[block].attributes.insert(name, accessor);
        Ok(())
    }

    /// Appends the displaced and transformed positions of an accessor. Returns the first index, the count, and the local positions if
    /// the transform changes them.
    fn positions(
        &mut self,
        mesh: usize,
        index: usize,
        morph: &[(usize, f32)],
        transform: &DMat4,
    ) -> Result<(u32, u32, Vec<[f64; 3]>), IoError> {
        let mut local = accessor::positions(self.buffers, index)?;
        morph::displace(self.buffers, mesh, morph, &mut local)?;
        let positions = &self.scene.surface.positions;
        let (start, count) = (positions.len(), local.len());
        self.check_size(mesh, start + count)?;
        self.buffers.spend(count * size_of::<DVec3>())?;
        let points = local.iter().copied().map(DVec3::from_array);
        let positions = &mut self.scene.surface.positions;
        if *transform == DMat4::IDENTITY {
            positions.extend(points);
            return Ok((start as u32, count as u32, Vec::new()));
        }
        positions.extend(points.map(|p| transform.transform_point3(p)));
        Ok((start as u32, count as u32, local))
    }

    /// Appends triangles; a mirroring transform reverses their orientation.
    fn faces(
        &mut self,
        mesh: usize,
        mode: Mode,
        corners: &[u32],
        mirrored: bool,
    ) -> Result<(), IoError> {
        let before = self.scene.surface.triangles_mut().len();
        self.check_size(mesh, before + corners.len())?;
        match mode {
            Mode::TriangleStrip => self.scene.surface.push_strip(corners),
            Mode::TriangleFan => self.scene.surface.push_fan(corners),
            _ if !corners.len().is_multiple_of(3) => {
                let what = format!(
                    "a primitive has {} corners, which do not make whole triangles",
                    corners.len()
                );
                return Err(self.fault(mesh, what));
            }
            _ => corners
                .chunks_exact(3)
                .for_each(|c| self.scene.surface.push_triangle([c[0], c[1], c[2]])),
        }
        if mirrored {
            self.scene.surface.triangles_mut()[before..]
                .iter_mut()
                .for_each(|face| face.swap(1, 2));
        }
        Ok(())
    }

    /// Charges the memory of the vertex attributes of the whole mesh, into which the values of the blocks are copied.
    fn spend_on_attributes(&mut self) -> Result<(), IoError> {
        let mut widest: BTreeMap<&str, usize> = BTreeMap::new();
        for (_, name, raw) in &self.scene.values {
            let components = widest.entry(name).or_default();
            *components = raw.components.max(*components);
        }
        let each: usize = widest.values().map(|components| 8 * components + 1).sum();
        self.buffers
            .spend(each.saturating_mul(self.scene.surface.positions.len()))
    }

    /// Limits the scene: many nodes that use one mesh could make a small file very large.
    fn check_size(&self, mesh: usize, size: usize) -> Result<(), IoError> {
        if size <= MOST {
            return Ok(());
        }
        Err(self
            .fault(
                mesh,
                format!("with it the scene has more than {MOST} vertices or triangles"),
            )
            .advise("save the parts of the scene to be repaired as separate files"))
    }

    fn fault(&self, mesh: usize, what: String) -> IoError {
        IoError::malformed(self.buffers.format, Location::Item("mesh", mesh), what)
    }
}
