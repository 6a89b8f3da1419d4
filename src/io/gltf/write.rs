//! Writing glTF and GLB: one mesh of one primitive.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Target, View};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Accessor, Asset, Buffer, Index, Mesh as JsonMesh, Node, Root, Scene, Value};

use super::super::{Format, IoError, Written, rounded};
use crate::mesh::Mesh;

/// Writes a GLB file.
pub(in super::super) fn write_glb(mesh: &Mesh) -> Result<Written, IoError> {
    let (points, notes) = rounded(mesh, Format::Glb)?;
    let data = buffer(mesh, &points);
    let json = describe(mesh, &points, data.len(), None, Format::Glb)?;
    let glb = gltf::binary::Glb {
        header: gltf::binary::Header {
            magic: *b"glTF",
            version: 2,
            length: 0,
        },
        json: json.into(),
        bin: Some(data.into()),
    };
    if glb.json.len() + glb.bin.as_ref().map_or(0, |bin| bin.len()) > u32::MAX as usize - 64 {
        return Err(refuse(
            Format::Glb,
            "the mesh is larger than the 4 GB a GLB file can hold".to_string(),
        ));
    }
    let bytes = glb
        .to_vec()
        .map_err(|error| refuse(Format::Glb, error.to_string()))?;
    Ok(Written { bytes, notes })
}

/// Writes a glTF file with its buffer as a data URI.
pub(in super::super) fn write_gltf(mesh: &Mesh) -> Result<Written, IoError> {
    let (points, notes) = rounded(mesh, Format::Gltf)?;
    let data = buffer(mesh, &points);
    let uri = format!(
        "data:application/octet-stream;base64,{}",
        STANDARD.encode(&data)
    );
    let bytes = describe(mesh, &points, data.len(), Some(uri), Format::Gltf)?;
    Ok(Written { bytes, notes })
}

/// Positions, then indices.
fn buffer(mesh: &Mesh, points: &[[f32; 3]]) -> Vec<u8> {
    let mut data = Vec::with_capacity(12 * (points.len() + mesh.faces.len()));
    data.extend(
        points
            .iter()
            .flatten()
            .flat_map(|value| value.to_le_bytes()),
    );
    data.extend(
        mesh.faces
            .iter()
            .flatten()
            .flat_map(|index| index.to_le_bytes()),
    );
    data
}

fn describe(
    mesh: &Mesh,
    points: &[[f32; 3]],
    size: usize,
    uri: Option<String>,
    format: Format,
) -> Result<Vec<u8>, IoError> {
    if points.is_empty() || mesh.faces.is_empty() {
        return Err(refuse(format, "the mesh is empty".to_string()));
    }
    let mut root = Root {
        asset: Asset {
            generator: Some("isomend".to_string()),
            ..Asset::default()
        },
        ..Root::default()
    };
    let buffer = root.push(Buffer {
        byte_length: USize64::from(size),
        name: None,
        uri,
        extensions: None,
        extras: Default::default(),
    });
    let split = points.len() * 12;
    let view_of_positions = view(&mut root, buffer, 0, split, Target::ArrayBuffer);
    let view_of_indices = view(
        &mut root,
        buffer,
        split,
        size - split,
        Target::ElementArrayBuffer,
    );
    let mut positions = accessor(
        view_of_positions,
        points.len(),
        ComponentType::F32,
        Type::Vec3,
    );
    positions.min = Some(bound(points, f32::min));
    positions.max = Some(bound(points, f32::max));
    let positions = root.push(positions);
    let indices = root.push(accessor(
        view_of_indices,
        mesh.faces.len() * 3,
        ComponentType::U32,
        Type::Scalar,
    ));
    place(&mut root, positions, indices);
    root.to_vec()
        .map_err(|error| refuse(format, error.to_string()))
}

/// The component-wise minimum or maximum.
fn bound(points: &[[f32; 3]], pick: fn(f32, f32) -> f32) -> Value {
    let first = points.first().copied().unwrap_or_default();
    let extreme = points.iter().fold(first, |a, b| {
        [pick(a[0], b[0]), pick(a[1], b[1]), pick(a[2], b[2])]
    });
    Value::from(extreme.to_vec())
}

/// Adds the mesh, its node and the scene.
fn place(root: &mut Root, positions: Index<Accessor>, indices: Index<Accessor>) {
    let primitive = Primitive {
        attributes: [(Checked::Valid(Semantic::Positions), positions)]
            .into_iter()
            .collect(),
        extensions: None,
        extras: Default::default(),
        indices: Some(indices),
        material: None,
        mode: Checked::Valid(Mode::Triangles),
        targets: None,
    };
    let mesh = root.push(JsonMesh {
        extensions: None,
        extras: Default::default(),
        name: None,
        primitives: vec![primitive],
        weights: None,
    });
    let node = root.push(Node {
        mesh: Some(mesh),
        ..Node::default()
    });
    root.scene = Some(root.push(Scene {
        extensions: None,
        extras: Default::default(),
        name: None,
        nodes: vec![node],
    }));
}

fn view(
    root: &mut Root,
    buffer: Index<Buffer>,
    start: usize,
    length: usize,
    target: Target,
) -> Index<View> {
    root.push(View {
        buffer,
        byte_length: USize64::from(length),
        byte_offset: Some(USize64::from(start)),
        byte_stride: None,
        name: None,
        target: Some(Checked::Valid(target)),
        extensions: None,
        extras: Default::default(),
    })
}

fn accessor(view: Index<View>, count: usize, component: ComponentType, type_: Type) -> Accessor {
    Accessor {
        buffer_view: Some(view),
        byte_offset: Some(USize64::from(0usize)),
        count: USize64::from(count),
        component_type: Checked::Valid(GenericComponentType(component)),
        extensions: None,
        extras: Default::default(),
        type_: Checked::Valid(type_),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    }
}

fn refuse(format: Format, what: String) -> IoError {
    IoError::NotWritable {
        format,
        what,
        advice: "write PLY instead",
    }
}
