//! Writes a mesh as a new glTF scene of one node, with a primitive for each material and for patches.

use std::collections::HashMap;

use serde_json::{Map, Value, json};

use super::super::{Contents, Format, IoError, Written, lost, rounded};
use super::build::Builder;
use super::materials::{Materials, turned};
use isomend_core::mesh::attributes::{
    Attribute, Attributes, LabelKind, NONE, PATCH_NAME, Role, Scalar,
};

/// Writes a glTF or GLB file.
pub(super) fn write(model: &Contents<'_>, format: Format) -> Result<Written, IoError> {
    let mesh = model.mesh;
    if mesh.positions.is_empty() || mesh.faces.is_empty() {
        return Err(IoError::NotWritable {
            format,
            what: "the mesh is empty".to_string(),
            advice: "write PLY instead",
        });
    }
    let (mut points, mut notes) = rounded(mesh, format)?;
    let split = Split::new(model);
    let copies: Vec<[f32; 3]> = split
        .copies
        .iter()
        .map(|(v, _)| points[*v as usize])
        .collect();
    points.extend(copies);
    let mut builder = Builder::new();
    let position = builder.positions(&points);
    let mut columns: Vec<Column> = Vec::new();
    let vertex = model.attributes.vertex.iter().map(|a| (a, None));
    let pools = model.attributes.corner.iter().enumerate();
    let all = vertex.chain(pools.map(|(i, c)| (&c.pool, Some(i))));
    let textured = model
        .attributes
        .materials
        .iter()
        .any(|m| m.texture.is_some());
    let mut omitted = model
        .attributes
        .listed_where(|_| false, |k| k != LabelKind::Material);
    for (attribute, pool) in all {
        // Coordinates of two components are turned already.
        let is_long = textured && attribute.components > 2;
        let turned = is_long.then(|| turned(attribute)).flatten();
        let attribute = turned.as_ref().unwrap_or(attribute);
        let name = name(attribute, &columns);
        match name.filter(|_| attribute.components <= 4) {
            Some(name) => {
                columns.push(split.column(&mut builder, attribute, pool, name, points.len()))
            }
            None => {
                let join = if omitted.is_empty() { "" } else { ", " };
                omitted += &format!("{join}'{}'", attribute.name);
            }
        }
    }
    notes.extend(lost::note(&omitted, format));
    let marked = |a: &Attribute| model.attributes.face.iter().any(|f| std::ptr::eq(f, a));
    notes.extend(lost::note(
        &model.attributes.listed_where(marked, |_| false),
        format,
    ));
    let primitives = primitives(&mut builder, model.attributes, &split, position, &columns);
    builder.push("meshes", json!({ "primitives": primitives }));
    builder.push("nodes", json!({ "mesh": 0 }));
    builder.push("scenes", json!({ "nodes": [0] }));
    builder.json["scene"] = json!(0);
    let bytes = builder.finish(format)?;
    Ok(Written { bytes, notes })
}

/// Splits vertices whose corners differ in their values, as glTF requires. The first combination keeps the original
/// vertex.
struct Split {
    /// Faces with the vertices of the file.
    faces: Vec<[u32; 3]>,
    /// The number of vertices of the mesh; copies follow them.
    vertices: usize,
    /// For each vertex, the index of its value in each pool; empty if there are no pools.
    places: Vec<Vec<u32>>,
    /// For each added vertex, the vertex that it is a copy of and its indices in the pools.
    copies: Vec<(u32, Vec<u32>)>,
}

impl Split {
    fn new(model: &Contents<'_>) -> Self {
        let pools = &model.attributes.corner;
        let count = model.mesh.positions.len();
        let mut split = Self {
            faces: model.mesh.faces.clone(),
            vertices: count,
            places: Vec::new(),
            copies: Vec::new(),
        };
        if pools.is_empty() {
            return split;
        }
        split.places = vec![Vec::new(); count];
        let mut others: HashMap<(u32, Vec<u32>), u32> = HashMap::new();
        for (f, face) in split.faces.iter_mut().enumerate() {
            for (k, vertex) in face.iter_mut().enumerate() {
                let wanted: Vec<u32> = pools.iter().map(|p| p.corners[f][k]).collect();
                let own = &mut split.places[*vertex as usize];
                if own.is_empty() {
                    *own = wanted;
                } else if *own != wanted {
                    let copies = &mut split.copies;
                    *vertex = *others.entry((*vertex, wanted.clone())).or_insert_with(|| {
                        copies.push((*vertex, wanted));
                        (count + copies.len() - 1) as u32
                    });
                }
            }
        }
        split
    }

    /// The value of a vertex of the file.
    fn value<'a>(
        &self,
        attribute: &'a Attribute,
        pool: Option<usize>,
        v: usize,
    ) -> Option<&'a [f64]> {
        let copy = v.checked_sub(self.vertices).map(|i| &self.copies[i]);
        match (pool, copy) {
            (None, None) => attribute.get(v),
            (None, Some((of, _))) => attribute.get(*of as usize),
            (Some(p), copy) => {
                let places = match copy {
                    Some((_, places)) => places,
                    None => self.places.get(v)?,
                };
                let place = places.get(p).copied().filter(|place| *place != NONE)?;
                attribute.get(place as usize)
            }
        }
    }

    fn column(
        &self,
        builder: &mut Builder,
        attribute: &Attribute,
        pool: Option<usize>,
        name: String,
        vertices: usize,
    ) -> Column {
        let there: Vec<bool> = (0..vertices)
            .map(|v| self.value(attribute, pool, v).is_some())
            .collect();
        let value = |v: usize| self.value(attribute, pool, v);
        let accessor = if attribute.role == Role::Colour && attribute.scalar == Scalar::U8 {
            let colours: Vec<[u8; 4]> = (0..vertices).map(|v| colour_bytes(value(v))).collect();
            builder.bytes(&colours)
        } else {
            let mut values = Vec::with_capacity(vertices * attribute.components);
            for v in 0..vertices {
                push_floats(&mut values, attribute, value(v));
            }
            builder.floats(&values, attribute.components)
        };
        Column {
            name,
            accessor,
            there,
        }
    }
}

fn colour_bytes(value: Option<&[f64]>) -> [u8; 4] {
    let mut bytes = [255; 4];
    for (byte, v) in bytes.iter_mut().zip(value.unwrap_or(&[])) {
        *byte = *v as u8;
    }
    bytes
}

/// Appends a value in glTF's form: colours as fractions of 1, normals and tangents with unit length.
pub(super) fn push_floats(out: &mut Vec<f32>, attribute: &Attribute, value: Option<&[f64]>) {
    let start = out.len();
    let unit = attribute.unit();
    match value {
        Some(value) => out.extend(value.iter().map(|v| (v / unit) as f32)),
        None => out.extend(std::iter::repeat_n(0.0, attribute.components)),
    }
    let directed = matches!(attribute.role, Role::Normal | Role::Tangent);
    if directed && attribute.components >= 3 {
        let [x, y, z] = [out[start], out[start + 1], out[start + 2]];
        let vector = glam::Vec3::new(x, y, z);
        if (vector.length() - 1.0).abs() > 1e-4 {
            let unit = vector.normalize_or(glam::Vec3::Z).to_array();
            out[start..start + 3].copy_from_slice(&unit);
        }
    }
    if attribute.role == Role::Colour {
        out[start..].iter_mut().for_each(|v| *v = v.clamp(0.0, 1.0));
    }
    if attribute.role == Role::Tangent && attribute.components == 4 {
        out[start + 3] = if out[start + 3] < 0.0 { -1.0 } else { 1.0 };
    }
}

/// A vertex attribute of the file.
struct Column {
    name: String,
    accessor: usize,
    /// Whether each vertex has a value.
    there: Vec<bool>,
}

/// The name of an attribute in glTF; `None` if its number of components is not allowed for the name, or the name is in
/// use.
fn name(attribute: &Attribute, taken: &[Column]) -> Option<String> {
    let custom = || {
        let word = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let name: String = attribute.name.chars().map(word).collect();
        format!("_{}", name.trim_start_matches('_').to_ascii_uppercase())
    };
    let is_free = |name: &String| !taken.iter().any(|c| c.name == *name);
    let (fits, name) = match attribute.role {
        Role::Normal => (attribute.components == 3, "NORMAL".to_owned()),
        Role::Tangent => (attribute.components == 4, "TANGENT".to_owned()),
        Role::Colour => {
            let colours = taken.iter().filter(|c| c.name.starts_with("COLOR_"));
            let fits = (3..=4).contains(&attribute.components);
            (fits, format!("COLOR_{}", colours.count()))
        }
        Role::Uv(_) => {
            let sets = taken.iter().filter(|c| c.name.starts_with("TEXCOORD_"));
            let fits = attribute.components == 2;
            (fits, format!("TEXCOORD_{}", sets.count()))
        }
        Role::Other => (true, custom()),
    };
    Some(name).filter(|name| fits && is_free(name))
}

/// Most attributes by which primitives are separated: the bits of an integer.
const MOST_PARTIAL: usize = 64;

/// What the faces of a primitive have in common: whether they are patches, their material, and which of the attributes that not all
/// vertices have they have.
type Key = (bool, u32, u64);

/// The corners of the faces of each primitive, in the order of their first faces.
fn grouped(attributes: &Attributes, split: &Split, columns: &[Column]) -> Vec<(Key, Vec<u32>)> {
    let materials = attributes.labels_of(LabelKind::Material);
    let there = columns.iter().map(|column| &column.there[..]);
    let partial: Vec<&[bool]> = there
        .filter(|there| there.contains(&false))
        .take(MOST_PARTIAL)
        .collect();
    let held = |face: &[u32; 3]| -> u64 {
        let has = |there: &[bool]| face.iter().all(|v| there[*v as usize]);
        let bits = partial.iter().enumerate();
        bits.map(|(bit, there)| u64::from(has(there)) << bit).sum()
    };
    let mut groups: Vec<(Key, Vec<u32>)> = Vec::new();
    let mut known: HashMap<Key, usize> = HashMap::new();
    for (f, face) in split.faces.iter().enumerate() {
        let material = materials.map_or(NONE, |m| m.of_face[f]);
        let key = (attributes.is_patch(f), material, held(face));
        let group = *known.entry(key).or_insert_with(|| {
            groups.push((key, Vec::new()));
            groups.len() - 1
        });
        groups[group].1.extend(face);
    }
    groups
}

/// One primitive per material, separately for kept faces and patches, and for faces with different attributes: all vertices of a primitive
/// have the same ones.
fn primitives(
    builder: &mut Builder,
    attributes: &Attributes,
    split: &Split,
    position: usize,
    columns: &[Column],
) -> Vec<Value> {
    let mut materials_of_file = Materials::new(builder, attributes);
    let mut primitives = Vec::new();
    for ((patch, material, _), corners) in grouped(attributes, split, columns) {
        let mut names = Map::new();
        names.insert("POSITION".to_owned(), json!(position));
        let (mut sets, mut colours) = (0, 0);
        for column in columns {
            let there = corners.iter().all(|c| column.there[*c as usize]);
            // Sets must be numbered without gaps.
            let next = match column.name.split_once('_') {
                Some(("TEXCOORD", set)) => set == sets.to_string(),
                Some(("COLOR", set)) => set == colours.to_string(),
                _ => true,
            };
            if there && next {
                sets += usize::from(column.name.starts_with("TEXCOORD_"));
                colours += usize::from(column.name.starts_with("COLOR_"));
                names.insert(column.name.clone(), json!(column.accessor));
            }
        }
        let indices = builder.indices(&corners);
        let mut primitive = json!({ "attributes": names, "indices": indices, "mode": 4 });
        if material != NONE {
            primitive["material"] = json!(materials_of_file.index(builder, material, sets > 0));
        }
        if patch {
            primitive["extras"] = json!({ PATCH_NAME: true });
        }
        primitives.push(primitive);
    }
    primitives
}
