//! Gathers the vertex attributes, material labels and patch marks of a glTF scene from its primitives.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use super::accessor::Raw;
use super::scene::{Block, PlacedPrimitive};
use isomend_core::mesh::Attributes;
use isomend_core::mesh::attributes::{
    Attribute, LabelKind, Labels, NONE, PATCH_NAME, Role, Scalar,
};

/// Builds the attributes of `vertices` vertices and `faces` faces. Normals and tangents are transformed to the scene.
pub(super) fn attributes(
    values: Vec<(usize, String, Raw)>,
    blocks: &[Block],
    parts: &[PlacedPrimitive],
    [vertices, faces]: [usize; 2],
    materials: Vec<String>,
) -> Attributes {
    let mut out = Attributes::default();
    let mut names: BTreeMap<_, Vec<(&Block, &Raw)>> = BTreeMap::new();
    for (block, name, raw) in &values {
        let sources = names.entry((order(name), name)).or_default();
        sources.push((&blocks[*block], raw));
    }
    for ((_, name), sources) in names {
        out.vertex.push(gather(name, &sources, vertices));
    }
    if !materials.is_empty() {
        let mut labels = Labels::new(LabelKind::Material);
        labels.names = materials;
        labels.of_face = vec![NONE; faces];
        for part in parts {
            let (start, count) = part.faces;
            let known = part.material.filter(|m| *m < labels.names.len());
            labels.of_face[start..start + count].fill(known.map_or(NONE, |m| m as u32));
        }
        out.labels.push(labels);
    }
    if parts.iter().any(|part| part.patch) {
        let mut marks = Attribute::new(PATCH_NAME, Role::Other, Scalar::U8, 1);
        marks.values = vec![0.0; faces];
        for part in parts.iter().filter(|part| part.patch) {
            let (start, count) = part.faces;
            marks.values[start..start + count].fill(1.0);
        }
        out.face.push(marks);
    }
    out
}

/// Sort key of a name: sets of one kind are ordered by their numbers.
fn order(name: &str) -> (String, u32) {
    let (stem, number) = name.rsplit_once('_').unwrap_or((name, ""));
    match number.parse() {
        Ok(number) => (stem.to_owned(), number),
        Err(_) => (name.to_owned(), 0),
    }
}

/// The meaning of an attribute by its name.
pub(super) fn role(name: &str) -> Role {
    let set = |prefix: &str| name.strip_prefix(prefix)?.parse().ok();
    match name {
        "NORMAL" => Role::Normal,
        "TANGENT" => Role::Tangent,
        _ if set("COLOR_").is_some() => Role::Colour,
        _ => set("TEXCOORD_").map_or(Role::Other, Role::Uv),
    }
}

fn gather(name: &str, sources: &[(&Block, &Raw)], vertices: usize) -> Attribute {
    let (_, first) = sources[0];
    let same = |raw: &Raw| raw.scalar == first.scalar && raw.normalized == first.normalized;
    let alike = sources.iter().all(|(_, raw)| same(raw));
    let turned = matches!(name, "NORMAL" | "TANGENT");
    let role = role(name);
    let widest = sources.iter().map(|(_, raw)| raw.components).max();
    // Colours with and without alpha are combined; other attributes have the width of the first primitive.
    let components = match role {
        Role::Colour => widest.unwrap_or(3),
        _ => first.components,
    };
    let keep = alike && !turned;
    let scalar = if keep { first.scalar } else { Scalar::F32 };
    let mut out = Attribute::new(name, role, scalar, components);
    out.normalized = keep && first.normalized;
    out.values = vec![0.0; vertices * components];
    out.missing = vec![true; vertices];
    for (block, raw) in sources {
        if raw.components != components && role != Role::Colour {
            continue;
        }
        let unit = |value: f64| match raw.normalized && !keep {
            true => (value / raw.scalar.range()[1]).max(-1.0),
            false => value,
        };
        let full = if keep { out.unit() } else { 1.0 };
        for (i, value) in raw.values.chunks_exact(raw.components).enumerate() {
            let vertex = block.start as usize + i;
            let row = &mut out.values[vertex * components..][..components];
            row.fill(full);
            for (to, from) in row.iter_mut().zip(value) {
                *to = unit(*from);
            }
            if turned {
                turn(block, role, row);
            }
            out.missing[vertex] = !row.iter().all(|v| v.is_finite());
        }
    }
    if !out.missing.contains(&true) {
        out.missing = Vec::new();
    }
    out
}

/// Transforms a normal or tangent from a node's local coordinates to the scene.
fn turn(block: &Block, role: Role, row: &mut [f64]) {
    if block.local.is_empty() || row.len() < 3 {
        return;
    }
    let matrix = DMat3::from_mat4(block.transform);
    let vector = DVec3::from_slice(row);
    let turned = match role {
        Role::Normal => matrix.inverse().transpose() * vector,
        _ => matrix * vector,
    };
    row[..3].copy_from_slice(&turned.normalize_or(vector).to_array());
}

/// Transforms a normal or tangent from the scene to a node's local coordinates.
pub(super) fn turn_back(block: &Block, role: Role, vector: DVec3) -> DVec3 {
    if block.local.is_empty() {
        return vector;
    }
    let matrix = DMat3::from_mat4(block.transform);
    let turned = match role {
        Role::Normal => matrix.transpose() * vector,
        _ => matrix.inverse() * vector,
    };
    turned.normalize_or(vector)
}
