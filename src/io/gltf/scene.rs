//! Walking the nodes of a scene and collecting the triangles of their meshes.

use std::collections::BTreeMap;

use glam::{DMat4, DQuat, DVec3};
use gltf_json::Root;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::scene::Node;
use gltf_json::validation::Checked;

use super::super::surface::Surface;
use super::super::{Format, IoError, Place};
use super::accessor;
use super::buffers::Buffers;
use super::unsupported_extension;

/// The most vertices or triangles that are collected from one file.
const MOST: usize = 1 << 26;

/// Collects the triangles of the default scene. A mesh that several nodes use is read once for each.
pub(super) fn read(root: &Root, buffers: &mut Buffers<'_>) -> Result<Surface, IoError> {
    let mut reader = Reader {
        root,
        surface: Surface::new(buffers.format),
        passed_over: 0,
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
            IoError::malformed(reader.buffers.format, Place::Item("node", index), what)
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
            reader.mesh(mesh.value(), &transform)?;
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
    if skinned > 0 {
        reader.surface.notes.push(format!(
            "nodes whose skin was passed over, so that their mesh is in its bind pose: {skinned}"
        ));
    }
    if reader.passed_over > 0 {
        let note = format!(
            "primitives of points or lines passed over: {}",
            reader.passed_over
        );
        reader.surface.notes.push(note);
    }
    Ok(reader.surface)
}

/// The nodes to begin with: those of the default scene, or all that are no one's child where there is no scene.
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
            Err(IoError::malformed(format, Place::File, what))
        }
    }
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
    surface: Surface,
    passed_over: usize,
}

impl Reader<'_, '_> {
    fn mesh(&mut self, index: usize, transform: &DMat4) -> Result<(), IoError> {
        let Some(mesh) = self.root.meshes.get(index) else {
            let what = format!("the file has only {} meshes", self.root.meshes.len());
            return Err(IoError::malformed(
                self.buffers.format,
                Place::Item("mesh", index),
                what,
            ));
        };
        // Primitives of one mesh often share their positions, which are then taken over once.
        let mut taken: BTreeMap<usize, (u32, u32)> = BTreeMap::new();
        for primitive in &mesh.primitives {
            self.primitive(index, primitive, transform, &mut taken)?;
        }
        Ok(())
    }

    fn primitive(
        &mut self,
        mesh: usize,
        primitive: &Primitive,
        transform: &DMat4,
        taken: &mut BTreeMap<usize, (u32, u32)>,
    ) -> Result<(), IoError> {
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => {
                mode
            }
            Checked::Valid(_) => {
                self.passed_over += 1;
                return Ok(());
            }
            Checked::Invalid => {
                return Err(self.fault(mesh, "a primitive has an unknown mode".to_string()));
            }
        };
        let Some(attribute) = primitive
            .attributes
            .get(&Checked::Valid(Semantic::Positions))
        else {
            return Err(self.no_positions(mesh));
        };
        let (base, count) = match taken.get(&attribute.value()) {
            Some(range) => *range,
            None => {
                let range = self.positions(mesh, attribute.value(), transform)?;
                taken.insert(attribute.value(), range);
                range
            }
        };
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
        corners.iter_mut().for_each(|corner| *corner += base);
        self.faces(mesh, mode, &corners, transform.determinant() < 0.0)
    }

    /// Appends the transformed positions of an accessor; returns where they begin and how many they are.
    fn positions(
        &mut self,
        mesh: usize,
        index: usize,
        transform: &DMat4,
    ) -> Result<(u32, u32), IoError> {
        let points = accessor::positions(self.buffers, index)?;
        let base = self.surface.positions.len();
        self.check_size(mesh, base + points.len())?;
        let range = (base as u32, points.len() as u32);
        let points = points.into_iter().map(DVec3::from_array);
        if *transform == DMat4::IDENTITY {
            self.surface.positions.extend(points);
        } else {
            self.surface
                .positions
                .extend(points.map(|p| transform.transform_point3(p)));
        }
        Ok(range)
    }

    /// Appends triangles, turned round when the transform mirrors.
    fn faces(
        &mut self,
        mesh: usize,
        mode: Mode,
        corners: &[u32],
        mirrored: bool,
    ) -> Result<(), IoError> {
        let before = self.surface.triangles_mut().len();
        self.check_size(mesh, before + corners.len())?;
        match mode {
            Mode::TriangleStrip => self.surface.push_strip(corners),
            Mode::TriangleFan => self.surface.push_fan(corners),
            _ if !corners.len().is_multiple_of(3) => {
                let what = format!(
                    "a primitive has {} corners, which do not make whole triangles",
                    corners.len()
                );
                return Err(self.fault(mesh, what));
            }
            _ => corners
                .chunks_exact(3)
                .for_each(|c| self.surface.push_triangle([c[0], c[1], c[2]])),
        }
        if mirrored {
            self.surface.triangles_mut()[before..]
                .iter_mut()
                .for_each(|face| face.swap(1, 2));
        }
        Ok(())
    }

    /// Many nodes that use one mesh can make a small file enormous.
    fn check_size(&self, mesh: usize, size: usize) -> Result<(), IoError> {
        if size <= MOST {
            return Ok(());
        }
        Err(self
            .fault(
                mesh,
                format!("with it the scene has more than {MOST} vertices or triangles"),
            )
            .advise("save the parts of the scene to be mended on their own"))
    }

    fn no_positions(&self, mesh: usize) -> IoError {
        match self
            .root
            .extensions_used
            .iter()
            .find(|name| name.contains("draco"))
        {
            Some(name) => unsupported_extension(self.buffers.format, name),
            None => self.fault(mesh, "a primitive has no positions".to_string()),
        }
    }

    fn fault(&self, mesh: usize, what: String) -> IoError {
        IoError::malformed(self.buffers.format, Place::Item("mesh", mesh), what)
    }
}
