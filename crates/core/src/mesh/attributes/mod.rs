//! Mesh attributes: normals, colours, texture coordinates, materials, groups and named values.
//!
//! Numbers are stored as `f64` together with their type in the file; this is exact for every type except 64-bit integers beyond
//! 2⁵³.

mod roles;
mod scalar;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{FaceOrigin, Origins, Unit};

pub use roles::{Active, Role};
pub use scalar::Scalar;

/// Marks a corner without a value, or a face without a label.
pub const NONE: u32 = u32::MAX;

/// Name that marks new faces: as a face attribute, a group, a material, or a node of a scene.
pub const PATCH_NAME: &str = "isomend_patch";
/// Name of the vertex attribute with expected errors: 0 for vertices of the input, negative if unknown.
pub const EXPECTED_ERROR_NAME: &str = "isomend_sigma";
/// Name of the hole numbers in files that contain only patches.
pub const HOLE_NAME: &str = "isomend_hole";

/// Named values of equal length: one for each vertex or face, or a pool to which corners refer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attribute {
    /// Name in the file.
    pub name: String,
    /// Component names, if the file has them; otherwise empty.
    pub fields: Vec<String>,
    /// Meaning of the values.
    pub role: Role,
    /// Type of the numbers.
    pub scalar: Scalar,
    /// Whether integers stand for fractions of the largest integer.
    pub normalized: bool,
    /// Numbers per value.
    pub components: usize,
    /// The numbers, value by value.
    pub values: Vec<f64>,
    /// Role of the array for a viewer, if the file has one.
    pub active: Option<Active>,
    /// Marks missing values; empty if none is missing.
    pub missing: Vec<bool>,
}

impl Attribute {
    /// An attribute without values.
    pub fn new(name: &str, role: Role, scalar: Scalar, components: usize) -> Self {
        Self {
            name: name.to_owned(),
            fields: Vec::new(),
            role,
            scalar,
            normalized: false,
            components,
            values: Vec::new(),
            active: None,
            missing: Vec::new(),
        }
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        self.values.len() / self.components.max(1)
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The value of an item; `None` if it is missing.
    pub fn get(&self, item: usize) -> Option<&[f64]> {
        if self.missing.get(item).copied().unwrap_or(false) {
            return None;
        }
        let start = item.checked_mul(self.components)?;
        self.values.get(start..start + self.components)
    }

    /// Appends a value, rounded to the type; `None` appends a missing value.
    pub fn push(&mut self, value: Option<&[f64]>) {
        let at = self.len();
        match value {
            Some(value) => {
                let scalar = self.scalar;
                self.values.extend(value.iter().map(|v| scalar.nearest(*v)));
            }
            None => self
                .values
                .extend(std::iter::repeat_n(0.0, self.components)),
        }
        if value.is_none() && self.missing.is_empty() {
            self.missing.resize(at, false);
        }
        if value.is_none() || !self.missing.is_empty() {
            self.missing.push(value.is_none());
        }
    }

    /// Appends missing values up to a length.
    pub fn pad(&mut self, length: usize) {
        while self.len() < length {
            self.push(None);
        }
    }

    /// The divisor of integers that stand for fractions: the largest number of the type; 1 otherwise.
    pub fn unit(&self) -> f64 {
        let colour = self.role == Role::Colour && !self.scalar.is_float();
        if (self.normalized && !self.scalar.is_float()) || colour {
            self.scalar.range()[1]
        } else {
            1.0
        }
    }

    /// The values at the given items.
    pub fn selected(&self, items: impl Iterator<Item = usize>) -> Self {
        let mut out = Self {
            values: Vec::new(),
            missing: Vec::new(),
            ..self.clone()
        };
        items.for_each(|item| out.push(self.get(item)));
        out
    }
}

/// Whether two values are the same, or both are missing. NaN is the same as NaN.
pub(crate) fn same_value(one: Option<&[f64]>, other: Option<&[f64]>) -> bool {
    let same = |(a, b): (&f64, &f64)| a == b || (a.is_nan() && b.is_nan());
    match (one, other) {
        (Some(one), Some(other)) => one.len() == other.len() && one.iter().zip(other).all(same),
        (one, other) => one.is_none() && other.is_none(),
    }
}

/// Values from a pool that corners of faces refer to, for example texture coordinates with seams.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CornerAttribute {
    /// The pool.
    pub pool: Attribute,
    /// For each face, the pool indices of its corners' values; `u32::MAX` for a missing value.
    pub corners: Vec<[u32; 3]>,
}

impl CornerAttribute {
    /// Converts to values of vertices, if all corners of each vertex have the same value; otherwise `None`.
    pub fn per_vertex(&self, mesh: &super::Mesh) -> Option<Attribute> {
        let mut place = vec![NONE; mesh.positions.len()];
        for (face, corners) in mesh.faces.iter().zip(&self.corners) {
            for (vertex, new) in face.iter().zip(corners) {
                let old = &mut place[*vertex as usize];
                if *old == NONE || *new == NONE {
                    *old = (*new).min(*old);
                } else if !same_value(self.pool.get(*old as usize), self.pool.get(*new as usize)) {
                    return None;
                }
            }
        }
        Some(self.pool.selected(place.into_iter().map(|p| p as usize)))
    }

    /// The value at a corner.
    pub fn get(&self, face: usize, corner: usize) -> Option<&[f64]> {
        let place = self.corners.get(face)?[corner];
        if place == NONE {
            return None;
        }
        self.pool.get(place as usize)
    }
}

/// Kind of a face label.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum LabelKind {
    /// An object.
    Object,
    /// A part of an object: a mesh of its own, which shares no vertices with other parts.
    Part,
    /// A group of faces, for example a part of an object.
    Group,
    /// A material.
    Material,
    /// A smoothing group: faces that are shaded as one smooth surface.
    Smoothing,
}

/// Labels of one kind on faces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Labels {
    /// Kind of the labels.
    pub kind: LabelKind,
    /// The distinct labels.
    pub names: Vec<String>,
    /// For each face, the index of its label in `names`, or `u32::MAX`.
    pub of_face: Vec<u32>,
}

impl Labels {
    /// No labels yet.
    pub fn new(kind: LabelKind) -> Self {
        Self {
            kind,
            names: Vec::new(),
            of_face: Vec::new(),
        }
    }

    /// The label of a face.
    pub fn get(&self, face: usize) -> Option<&str> {
        let place = *self.of_face.get(face)?;
        self.names.get(place as usize).map(String::as_str)
    }

    /// The index of a name, which is added if it is new.
    pub fn place(&mut self, name: &str) -> u32 {
        let found = self.names.iter().position(|n| n == name);
        found.unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        }) as u32
    }
}

/// Appearance of a material, as far as known. Numbers are between 0 and 1.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Name, which face labels refer to.
    pub name: String,
    /// Red, green and blue of the surface; multiplied with the texture.
    pub colour: Option<[f32; 3]>,
    /// 1 for an opaque material.
    pub opacity: Option<f32>,
    /// The image on the surface, as a path relative to the mesh file with `/` between folders. It must be in the file's folder or
    /// below.
    pub texture: Option<String>,
    /// 0 for a mirror, 1 for a surface without highlights.
    pub roughness: Option<f32>,
    /// 1 for a metal.
    pub metallic: Option<f32>,
}

/// All attributes of a mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Attributes {
    /// One value for each vertex.
    pub vertex: Vec<Attribute>,
    /// One value for each face.
    pub face: Vec<Attribute>,
    /// Values at the corners of faces.
    pub corner: Vec<CornerAttribute>,
    /// Labels of faces.
    pub labels: Vec<Labels>,
    /// Whether objects and their parts are bodies of their own, as in 3MF: each is checked and mended by itself.
    #[serde(default)]
    pub separate: bool,
    /// Materials named by labels.
    pub materials: Vec<Material>,
    /// Names of material files as written in the mesh file.
    pub libraries: Vec<String>,
    /// Names of texture files as written in the mesh file.
    pub textures: Vec<String>,
    /// Vertices that duplicate others with different attributes: the duplicate and its original.
    pub copies: Vec<(u32, u32)>,
    /// After faces were removed: which faces of the file still exist, in the file's order.
    pub kept_of_file: Option<Vec<bool>>,
    /// For each face, the face of the file from which it comes. Only for files that are written back together with what they hold
    /// besides the mesh, as 3MF.
    #[serde(default)]
    pub file_faces: Option<Vec<FaceOrigin>>,
    /// The unit of the coordinates, if known.
    #[serde(default)]
    pub unit: Option<Unit>,
}

impl Attributes {
    /// Whether there is nothing to carry over.
    pub fn is_empty(&self) -> bool {
        self.vertex.is_empty()
            && self.face.is_empty()
            && self.corner.is_empty()
            && self.labels.is_empty()
    }

    /// The first vertex attribute with a role.
    pub fn vertex_role(&self, role: Role) -> Option<&Attribute> {
        self.vertex.iter().find(|a| a.role == role)
    }

    /// The labels of a kind.
    pub fn labels_of(&self, kind: LabelKind) -> Option<&Labels> {
        self.labels.iter().find(|l| l.kind == kind)
    }

    /// Whether a face is marked as a face of a patch.
    pub fn is_patch(&self, face: usize) -> bool {
        let marks = self.face.iter().find(|a| a.name == PATCH_NAME);
        marks.is_some_and(|a| a.get(face).is_some_and(|v| v[0] != 0.0))
    }

    /// The attributes of the mesh with only the faces marked in `keep`, in their order. Vertices are unchanged.
    pub fn with_faces(&self, keep: &[bool]) -> Self {
        let kept = || (0..keep.len()).filter(|&f| keep[f]);
        let mut marks = keep.iter().copied();
        let kept_of_file = match &self.kept_of_file {
            None => keep.to_vec(),
            Some(before) => before
                .iter()
                .map(|there| *there && marks.next().unwrap_or(false))
                .collect(),
        };
        Self {
            vertex: self.vertex.clone(),
            face: self.face.iter().map(|a| a.selected(kept())).collect(),
            corner: self
                .corner
                .iter()
                .map(|a| CornerAttribute {
                    pool: a.pool.clone(),
                    corners: kept().map(|f| a.corners[f]).collect(),
                })
                .collect(),
            labels: self
                .labels
                .iter()
                .map(|l| Labels {
                    of_face: kept().map(|f| l.of_face[f]).collect(),
                    ..l.clone()
                })
                .collect(),
            materials: self.materials.clone(),
            libraries: self.libraries.clone(),
            textures: self.textures.clone(),
            copies: self.copies.clone(),
            kept_of_file: Some(kept_of_file),
            file_faces: (self.file_faces.as_ref()).map(|of| kept().map(|f| of[f]).collect()),
            unit: self.unit,
            separate: self.separate,
        }
    }

    /// The attributes of the mesh with only the vertices marked in `keep`, in their order. Faces are unchanged.
    pub fn with_vertices(&self, keep: &[bool]) -> Self {
        let kept = || (0..keep.len()).filter(|&v| keep[v]);
        let mut number = vec![NONE; keep.len()];
        for (new, old) in kept().enumerate() {
            number[old] = new as u32;
        }
        let at = |v: u32| number.get(v as usize).copied().filter(|n| *n != NONE);
        let copies = self.copies.iter();
        Self {
            vertex: self.vertex.iter().map(|a| a.selected(kept())).collect(),
            copies: copies
                .filter_map(|&(copy, of)| Some((at(copy)?, at(of)?)))
                .collect(),
            ..self.clone()
        }
    }

    /// The attributes of a mesh that was derived from this one. `kept` marks the faces of this mesh that still exist.
    #[must_use]
    pub fn derived(&self, origins: &Origins, kept: &[bool]) -> Self {
        // The first new vertex of each old one, for the list of copies.
        let mut number = BTreeMap::new();
        for (new, &old) in origins.vertices.iter().enumerate() {
            number.entry(old).or_insert(new as u32);
        }
        let at = |v: u32| number.get(&v).copied();
        let vertices = || origins.vertices.iter().map(|&v| v as usize);
        let faces = || origins.faces.iter().map(|o| o.face as usize);
        let corners = |c: &CornerAttribute| {
            let of = |o: &FaceOrigin| {
                let old = c.corners[o.face as usize];
                o.corners
                    .map(|k| old.get(k as usize).copied().unwrap_or(NONE))
            };
            origins.faces.iter().map(of).collect()
        };
        Self {
            vertex: self.vertex.iter().map(|a| a.selected(vertices())).collect(),
            face: self.face.iter().map(|a| a.selected(faces())).collect(),
            corner: (self.corner.iter())
                .map(|c| CornerAttribute {
                    pool: c.pool.clone(),
                    corners: corners(c),
                })
                .collect(),
            labels: (self.labels.iter())
                .map(|l| Labels {
                    of_face: faces().map(|f| l.of_face[f]).collect(),
                    ..l.clone()
                })
                .collect(),
            materials: self.materials.clone(),
            libraries: self.libraries.clone(),
            textures: self.textures.clone(),
            copies: (self.copies.iter())
                .filter_map(|&(copy, of)| Some((at(copy)?, at(of)?)))
                .collect(),
            kept_of_file: self.with_faces(kept).kept_of_file,
            file_faces: (self.file_faces.as_ref())
                .map(|of| origins.faces.iter().map(|o| o.before(of)).collect()),
            unit: self.unit,
            separate: self.separate,
        }
    }

    /// Whether two vertices have identical attributes.
    pub fn are_alike(&self, a: u32, b: u32) -> bool {
        let bits = |v: &Attribute, i: u32| -> Option<Vec<u64>> {
            let values = v.get(i as usize)?;
            Some(values.iter().map(|x| x.to_bits()).collect())
        };
        self.vertex.iter().all(|v| bits(v, a) == bits(v, b))
    }

    /// A one-line list of the attributes, for example `normals, colours`; empty if there are only marks of patches.
    pub fn listed(&self) -> String {
        self.listed_where(|_| true, |_| true)
    }

    /// [`Attributes::listed`] for selected attributes and labels.
    pub fn listed_where(
        &self,
        attribute: impl Fn(&Attribute) -> bool,
        labels: impl Fn(LabelKind) -> bool,
    ) -> String {
        let corner = self.corner.iter().map(|c| &c.pool);
        let all = self.vertex.iter().chain(corner).chain(&self.face);
        let mut words: Vec<String> = all
            .filter(|a| a.name != PATCH_NAME && a.name != EXPECTED_ERROR_NAME && attribute(a))
            .map(|a| match a.role {
                Role::Normal => "normals".to_owned(),
                Role::Colour => "colours".to_owned(),
                Role::Uv(0) => "texture coordinates".to_owned(),
                Role::Uv(set) => format!("texture coordinates {set}"),
                Role::Tangent => "tangents".to_owned(),
                Role::Other => format!("'{}'", a.name),
            })
            .collect();
        // The name of the only object tells nothing that the file's name does not.
        let is_name = |l: &&Labels| l.kind == LabelKind::Object && l.names.len() == 1;
        let kinds = self.labels.iter().filter(|l| !is_name(l));
        let kinds = kinds.map(|l| l.kind).filter(|k| labels(*k));
        words.extend(kinds.map(|kind| {
            match kind {
                LabelKind::Object => "objects",
                LabelKind::Part => "parts of objects",
                LabelKind::Group => "groups",
                LabelKind::Material => "materials",
                LabelKind::Smoothing => "smoothing groups",
            }
            .to_owned()
        }));
        let mut seen = std::collections::BTreeSet::new();
        words.retain(|w| seen.insert(w.clone()));
        words.join(", ")
    }
}
