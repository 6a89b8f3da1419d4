//! Reads the values of vertices, faces and corners of a USD mesh (primvars).

use super::layer::{Property, Value};
use super::prim::Prim;
use isomend_core::mesh::attributes::{Role, Scalar};

/// What the values of a primvar belong to.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Interpolation {
    /// The whole mesh.
    Constant,
    /// Each face.
    Uniform,
    /// Each vertex.
    Vertex,
    /// Each corner of a face.
    FaceVarying,
}

/// Values of a mesh.
pub(super) struct Primvar {
    pub(super) name: String,
    pub(super) role: Role,
    pub(super) scalar: Scalar,
    pub(super) components: usize,
    pub(super) interpolation: Interpolation,
    pub(super) values: Value,
    /// For each item the place of its value; each item has its own without.
    pub(super) places: Option<Value>,
    /// The place that stands for a missing value.
    pub(super) unauthored: Option<f64>,
}

impl Primvar {
    /// The place of the value of an item; `None` if it is missing.
    pub(super) fn place(&self, item: usize) -> Option<usize> {
        match &self.places {
            None => Some(item),
            Some(places) => {
                let place = *places.numbers().get(item)?;
                (place >= 0.0 && self.unauthored != Some(place)).then_some(place as usize)
            }
        }
    }

    /// The value of an item; `None` if it is missing or not finite.
    pub(super) fn get(&self, item: usize) -> Option<&[f64]> {
        self.at(self.place(item)?)
    }

    /// The value of a place; `None` if it is not finite or not there.
    pub(super) fn at(&self, place: usize) -> Option<&[f64]> {
        let start = place.checked_mul(self.components)?;
        let value = self
            .values
            .numbers()
            .get(start..start.checked_add(self.components)?)?;
        value.iter().all(|x| x.is_finite()).then_some(value)
    }

    /// The number of values, which items may share.
    pub(super) fn stored(&self) -> usize {
        self.values.numbers().len() / self.components.max(1)
    }

    /// The number of items.
    pub(super) fn len(&self) -> usize {
        self.places
            .as_ref()
            .map_or(self.stored(), |places| places.numbers().len())
    }
}

/// The type of the numbers of a value type such as `color3f[]`, and how many make a value; `None` if they are not numbers of items.
fn layout(kind: &str) -> Option<(Scalar, usize)> {
    let kind = kind.strip_suffix("[]").unwrap_or(kind);
    let simple = match kind {
        "bool" | "uchar" => Some(Scalar::U8),
        "int" => Some(Scalar::I32),
        "uint" => Some(Scalar::U32),
        "int64" => Some(Scalar::I64),
        "uint64" => Some(Scalar::U64),
        "half" | "float" => Some(Scalar::F32),
        "double" => Some(Scalar::F64),
        _ => None,
    };
    if let Some(scalar) = simple {
        return Some((scalar, 1));
    }
    for (stem, scalar) in [
        ("int", Scalar::I32),
        ("half", Scalar::F32),
        ("float", Scalar::F32),
        ("double", Scalar::F64),
    ] {
        if let Some(count) = kind.strip_prefix(stem).and_then(|count| count.parse().ok()) {
            return Some((scalar, count)).filter(|_| (2..=4).contains(&count));
        }
    }
    // A role, the number of components, and h, f or d.
    let stem = kind.trim_end_matches(['h', 'f', 'd']);
    let role = stem.trim_end_matches(|c: char| c.is_ascii_digit());
    let count = stem.strip_prefix(role)?.parse().ok()?;
    let is_known = ["point", "normal", "vector", "color", "texCoord"].contains(&role);
    let scalar = if kind.ends_with('d') {
        Scalar::F64
    } else {
        Scalar::F32
    };
    (is_known && (2..=4).contains(&count)).then_some((scalar, count))
}

/// The primvars of a mesh, and how many cannot be read.
pub(super) fn primvars(prim: &Prim) -> (Vec<Primvar>, usize) {
    let (mut found, mut unread) = (Vec::new(), 0);
    let has_primvar = prim.property("primvars:normals").is_some();
    for full in prim.property_names() {
        let name = match full.strip_prefix("primvars:") {
            Some(name) if !name.ends_with(":indices") => name,
            None if full == "normals" && !has_primvar => full,
            _ => continue,
        };
        let Some(property) = prim.property(full) else {
            continue;
        };
        let places = prim.value(&[full, ":indices"].concat());
        match primvar(name, property, places) {
            Some(primvar) if primvar.len() > 0 => found.push(primvar),
            Some(_) => {}
            None => unread += 1,
        }
    }
    (found, unread)
}

fn primvar(name: &str, property: Property, places: Option<Value>) -> Option<Primvar> {
    let values = property.value.or(property.sample)?;
    let (scalar, single) = layout(&property.kind)?;
    let interpolation = match property.interpolation.as_deref() {
        // Without an interpolation, normals belong to vertices.
        None if name == "normals" => Interpolation::Vertex,
        None | Some("constant") => Interpolation::Constant,
        Some("uniform") => Interpolation::Uniform,
        Some("vertex" | "varying") => Interpolation::Vertex,
        Some("faceVarying") => Interpolation::FaceVarying,
        Some(_) => return None,
    };
    let unauthored = property.unauthored;
    let elements = property
        .element_size
        .filter(|size| (1.0..=256.0).contains(size))
        .unwrap_or(1.0);
    let components = single * elements as usize;
    let is_uv = property.kind.starts_with("texCoord2")
        || (property.kind == "float2[]" && ["st", "uv", "UVMap"].contains(&name));
    let role = match components {
        3 if name == "normals" => Role::Normal,
        3 | 4 if property.kind.starts_with("color") => Role::Colour,
        // Sets are numbered when the names in all meshes are known.
        2 if is_uv => Role::Uv(0),
        _ => Role::Other,
    };
    Some(Primvar {
        name: name.to_owned(),
        role,
        scalar,
        components,
        interpolation,
        values,
        places,
        unauthored,
    })
}
