//! Writes OBJ text with texture coordinates, normals, colours and groups.

use std::io::Write;

use super::super::{Contents, Format, Written, lost};
use isomend_core::mesh::attributes::{Attribute, LabelKind, NONE, PATCH_NAME, Role, Scalar};

/// Writes a mesh as OBJ text. Decimals are the shortest that give the same floats when read.
pub(in super::super) fn write(model: &Contents<'_>) -> Written {
    let mesh = model.mesh;
    let mut bytes = Vec::with_capacity(mesh.positions.len() * 40 + mesh.faces.len() * 24);
    // Writing to a vector does not fail.
    for library in &model.attributes.libraries {
        let _ = writeln!(bytes, "mtllib {library}");
    }
    let colour = model.attributes.vertex_role(Role::Colour);
    for (v, p) in mesh.positions.iter().enumerate() {
        let _ = write!(bytes, "v {} {} {}", p.x, p.y, p.z);
        if let Some((colour, value)) = colour.and_then(|c| Some((c, c.get(v)?))) {
            numbers(&mut bytes, colour, value);
        }
        bytes.push(b'\n');
    }
    let corners = [Role::Uv(0), Role::Normal].map(|role| Corners::new(model, role));
    for (pool, word) in corners.iter().zip(["vt", "vn"]) {
        pool.write(&mut bytes, word);
    }
    faces(&mut bytes, model, &corners);
    Written {
        bytes,
        notes: notes(model),
    }
}

fn notes(model: &Contents<'_>) -> Vec<String> {
    let all = model.attributes;
    let of_face = |a: &Attribute| all.face.iter().any(|b| std::ptr::eq(a, b));
    let held =
        |a: &Attribute| matches!(a.role, Role::Uv(0) | Role::Normal | Role::Colour) && !of_face(a);
    let listed = all.listed_where(|a| !held(a), |_| false);
    let mut notes: Vec<String> = lost::note(&listed, Format::Obj).into_iter().collect();
    if model.is_of_gltf() && all.labels_of(LabelKind::Material).is_some() {
        notes.push(
            "materials are written by name only: no material file is made, and no textures"
                .to_owned(),
        );
    }
    notes
}

/// Writes the numbers of a value, each after a blank; normalised integers are written as fractions.
fn numbers(bytes: &mut Vec<u8>, attribute: &Attribute, value: &[f64]) {
    let unit = attribute.unit();
    for number in value {
        let _ = if attribute.scalar == Scalar::F64 {
            write!(bytes, " {number}")
        } else {
            write!(bytes, " {}", (number / unit) as f32)
        };
    }
}

/// Where the values of one role (texture coordinates or normals) come from.
enum Corners<'a> {
    None,
    OfVertices(&'a Attribute),
    Pool(&'a Attribute, &'a [[u32; 3]]),
}

impl<'a> Corners<'a> {
    fn new(model: &Contents<'a>, role: Role) -> Self {
        let attributes = model.attributes;
        if let Some(found) = attributes.corner.iter().find(|c| c.pool.role == role) {
            return Corners::Pool(&found.pool, &found.corners);
        }
        match attributes.vertex_role(role) {
            Some(found) => Corners::OfVertices(found),
            None => Corners::None,
        }
    }

    fn write(&self, bytes: &mut Vec<u8>, word: &str) {
        let (Corners::OfVertices(pool) | Corners::Pool(pool, _)) = self else {
            return;
        };
        for item in 0..pool.len() {
            bytes.extend_from_slice(word.as_bytes());
            let start = item * pool.components;
            numbers(bytes, pool, &pool.values[start..start + pool.components]);
            bytes.push(b'\n');
        }
    }

    /// The index of a corner's value, counted from 1.
    fn number(&self, face: usize, corner: usize, vertex: u32) -> Option<u64> {
        let (pool, place) = match self {
            Corners::None => return None,
            Corners::OfVertices(pool) => (pool, vertex),
            Corners::Pool(pool, corners) => (pool, corners[face][corner]),
        };
        let there = place != NONE && pool.get(place as usize).is_some();
        there.then_some(u64::from(place) + 1)
    }
}

fn faces(bytes: &mut Vec<u8>, model: &Contents<'_>, corners: &[Corners<'_>; 2]) {
    let plain = corners.iter().all(|c| matches!(c, Corners::None));
    let mut states = States::new(model);
    for (f, face) in model.mesh.faces.iter().enumerate() {
        states.write(bytes, f);
        bytes.push(b'f');
        // VTK refuses a face whose corners have different kinds of values: on patches all three have one, or none.
        let is_patch = model.attributes.is_patch(f);
        let is_whole = corners
            .each_ref()
            .map(|values| !is_patch || (0..3).all(|k| values.number(f, k, face[k]).is_some()));
        for (k, &vertex) in face.iter().enumerate() {
            let number = u64::from(vertex) + 1;
            let _ = if plain {
                write!(bytes, " {number}")
            } else {
                let [uv, normal] = [0, 1].map(|i| {
                    let number = corners[i].number(f, k, vertex);
                    number.filter(|_| is_whole[i])
                });
                match (uv, normal) {
                    (None, None) => write!(bytes, " {number}"),
                    (Some(uv), None) => write!(bytes, " {number}/{uv}"),
                    (None, Some(normal)) => write!(bytes, " {number}//{normal}"),
                    (Some(uv), Some(normal)) => write!(bytes, " {number}/{uv}/{normal}"),
                }
            };
        }
        bytes.push(b'\n');
    }
}

/// Writes labels (object, group, material, smoothing group) where they change from one face to the next.
struct States<'m> {
    model: &'m Contents<'m>,
    now: [Option<&'m str>; 4],
}

const KINDS: [(LabelKind, &str); 4] = [
    (LabelKind::Object, "o"),
    (LabelKind::Group, "g"),
    (LabelKind::Material, "usemtl"),
    (LabelKind::Smoothing, "s"),
];

impl<'m> States<'m> {
    fn new(model: &'m Contents<'m>) -> Self {
        Self {
            model,
            now: [None; 4],
        }
    }

    fn write(&mut self, bytes: &mut Vec<u8>, face: usize) {
        let attributes = self.model.attributes;
        for (now, (kind, word)) in self.now.iter_mut().zip(KINDS) {
            let label = attributes.labels_of(kind).and_then(|l| l.get(face));
            let patch = kind == LabelKind::Group && attributes.is_patch(face);
            let label = match (label, kind) {
                (None, LabelKind::Group) if patch => Some(PATCH_NAME),
                // Ends the previous label, which would otherwise apply to this face.
                (None, LabelKind::Group) if now.is_some() => Some("default"),
                (None, LabelKind::Smoothing) if now.is_some() => Some("off"),
                (label, _) => label,
            };
            if label.is_some() && label != *now {
                let _ = writeln!(bytes, "{word} {}", label.unwrap_or_default());
                *now = label;
            }
        }
    }
}
