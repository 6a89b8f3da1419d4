//! Values of vertices, faces and corners of USD meshes (primvars), and labels of faces: meshes, materials and subsets.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use glam::{DMat3, DVec3};

use super::super::mesh_builder::CutFrom;
use super::super::{IoError, Loaded};
use super::compose::{Layers, Prim};
use super::layer::{Property, Value};
use super::mesh::StageMesh;
use super::scene::Scene;
use isomend_core::mesh::attributes::{
    Attribute, CornerAttribute, LabelKind, Labels, NONE, PATCH_NAME, Role, Scalar,
};

/// What the values of a primvar belong to.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Interpolation {
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
    name: String,
    role: Role,
    scalar: Scalar,
    components: usize,
    interpolation: Interpolation,
    values: Value,
    /// For each item the place of its value; each item has its own without.
    places: Option<Value>,
}

impl Primvar {
    /// The value of an item; `None` if it is missing or not finite.
    fn get(&self, item: usize) -> Option<&[f64]> {
        let place = match &self.places {
            None => item,
            Some(places) => match places.numbers().get(item) {
                Some(place) if *place >= 0.0 => *place as usize,
                _ => return None,
            },
        };
        let start = place.checked_mul(self.components)?;
        let value = self
            .values
            .numbers()
            .get(start..start.checked_add(self.components)?)?;
        value.iter().all(|x| x.is_finite()).then_some(value)
    }

    /// The number of items.
    fn len(&self) -> usize {
        let values = self.values.numbers().len() / self.components.max(1);
        self.places
            .as_ref()
            .map_or(values, |places| places.numbers().len())
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
    let (mut found, mut unread, mut sets) = (Vec::new(), 0, 0);
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
        match primvar(name, property, places, &mut sets) {
            Some(primvar) if primvar.len() > 0 => found.push(primvar),
            Some(_) => {}
            None => unread += 1,
        }
    }
    (found, unread)
}

fn primvar(
    name: &str,
    property: Property,
    places: Option<Value>,
    sets: &mut u32,
) -> Option<Primvar> {
    let values = property.value.or(property.sample)?;
    let (scalar, single) = layout(&property.kind)?;
    let interpolation = match property.interpolation.as_deref() {
        // Normals without an interpolation are those of vertices.
        None if name == "normals" => Interpolation::Vertex,
        None | Some("constant") => Interpolation::Constant,
        Some("uniform") => Interpolation::Uniform,
        Some("vertex" | "varying") => Interpolation::Vertex,
        Some("faceVarying") => Interpolation::FaceVarying,
        Some(_) => return None,
    };
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
        2 if is_uv => {
            *sets += 1;
            Role::Uv(*sets - 1)
        }
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
    })
}

/// Adds the attributes of all meshes. `cut` says from which faces and corners the triangles come.
pub(super) fn gather(
    scene: &Scene,
    cut: &CutFrom,
    loaded: &mut Loaded,
    layers: &mut Layers<'_>,
) -> Result<(), IoError> {
    let mut order: Vec<&str> = Vec::new();
    let mut by_name: HashMap<&str, Vec<(usize, &Primvar)>> = HashMap::new();
    for (mesh, own) in scene.meshes.iter().enumerate() {
        for primvar in &own.primvars {
            let all = by_name.entry(&primvar.name).or_insert_with(|| {
                order.push(&primvar.name);
                Vec::new()
            });
            // Meshes may give the same name to values of different kinds.
            if all.first().is_none_or(|(_, first)| {
                first.components == primvar.components && first.role == primvar.role
            }) {
                all.push((mesh, primvar));
            }
        }
    }
    let (vertices, faces) = (loaded.mesh.positions.len(), loaded.mesh.faces.len());
    for name in order {
        let all = &by_name[name];
        let components = all[0].1.components;
        let is_only =
            |wanted: &[Interpolation]| all.iter().all(|(_, p)| wanted.contains(&p.interpolation));
        let (items, pool) = match () {
            () if is_only(&[Interpolation::Uniform]) => (faces, 0),
            () if is_only(&[Interpolation::Vertex, Interpolation::Constant]) => (vertices, 0),
            () => (3 * faces, all.iter().map(|(_, p)| p.len()).sum()),
        };
        layers
            .budget
            .spend(items.saturating_add(pool).saturating_mul(9 * components))?;
        let gathering = Gathering {
            scene,
            cut,
            primvars: all,
        };
        match (items, pool) {
            (_, 0) if items == faces && is_only(&[Interpolation::Uniform]) => {
                loaded.attributes.face.push(gathering.of_faces())
            }
            (_, 0) => loaded
                .attributes
                .vertex
                .push(gathering.of_vertices(vertices)),
            _ => loaded
                .attributes
                .corner
                .push(gathering.of_corners(&loaded.mesh.faces)),
        }
    }
    loaded.attributes.labels = labels(scene, cut);
    mark_patches(scene, cut, loaded);
    Ok(())
}

/// The primvars of one name of several meshes.
struct Gathering<'a> {
    scene: &'a Scene,
    cut: &'a CutFrom,
    primvars: &'a [(usize, &'a Primvar)],
}

impl Gathering<'_> {
    /// An attribute for the values, of the widest type of number.
    fn attribute(&self) -> Attribute {
        let (_, first) = self.primvars[0];
        let is_same = self
            .primvars
            .iter()
            .all(|(_, primvar)| primvar.scalar == first.scalar);
        let scalar = if is_same { first.scalar } else { Scalar::F64 };
        let mut attribute = Attribute::new(&first.name, first.role, scalar, first.components);
        attribute.normalized = first.role == Role::Colour && !scalar.is_float();
        attribute
    }

    fn of_vertices(&self, count: usize) -> Attribute {
        let mut out = self.attribute();
        for (mesh, primvar) in self.primvars {
            let mesh = &self.scene.meshes[*mesh];
            out.pad(mesh.vertices.start);
            for item in 0..mesh.vertices.len() {
                let item = if primvar.interpolation == Interpolation::Constant {
                    0
                } else {
                    item
                };
                out.push(turned(mesh, primvar, item).as_deref());
            }
        }
        out.pad(count);
        out
    }

    fn of_faces(&self) -> Attribute {
        let mut out = self.attribute();
        let of_mesh: HashMap<usize, &Primvar> = self.primvars.iter().copied().collect();
        for face in &self.cut.face {
            let (mesh, face) = self.scene.faces[*face as usize];
            let value = of_mesh
                .get(&(mesh as usize))
                .and_then(|p| turned(&self.scene.meshes[mesh as usize], p, face as usize));
            out.push(value.as_deref());
        }
        out
    }

    fn of_corners(&self, faces: &[[u32; 3]]) -> CornerAttribute {
        let mut pool = self.attribute();
        // The first place of each mesh in the pool.
        let mut starts: HashMap<usize, (usize, &Primvar)> = HashMap::new();
        for (mesh, primvar) in self.primvars {
            starts.insert(*mesh, (pool.len(), primvar));
            let own = &self.scene.meshes[*mesh];
            let count = primvar.values.numbers().len() / primvar.components;
            let plain = Primvar {
                places: None,
                name: String::new(),
                values: primvar.values.clone(),
                ..**primvar
            };
            for item in 0..count {
                pool.push(turned(own, &plain, item).as_deref());
            }
        }
        let place = |t: usize, k: usize| {
            let (mesh, face) = self.scene.faces[self.cut.face[t] as usize];
            let (start, primvar) = starts.get(&(mesh as usize))?;
            let item = match primvar.interpolation {
                Interpolation::Constant => 0,
                Interpolation::Uniform => face as usize,
                Interpolation::Vertex => {
                    faces[t][k] as usize - self.scene.meshes[mesh as usize].vertices.start
                }
                Interpolation::FaceVarying => {
                    self.scene.corners[self.cut.corners[t][k] as usize] as usize
                }
            };
            let place = match &primvar.places {
                None => item,
                Some(places) => {
                    *places.numbers().get(item).filter(|place| **place >= 0.0)? as usize
                }
            };
            let is_there = pool.get(start.checked_add(place)?).is_some()
                && place < primvar.values.numbers().len() / primvar.components;
            is_there.then_some((start + place) as u32)
        };
        let corners = (0..faces.len()).map(|t| [0, 1, 2].map(|k| place(t, k).unwrap_or(NONE)));
        let corners = corners.collect();
        CornerAttribute { corners, pool }
    }
}

/// The value of an item; normals are turned to the stage.
fn turned<'p>(mesh: &StageMesh, primvar: &'p Primvar, item: usize) -> Option<Cow<'p, [f64]>> {
    let value = primvar.get(item)?;
    let matrix = DMat3::from_mat4(mesh.transform);
    if primvar.role != Role::Normal || matrix == DMat3::IDENTITY {
        return Some(Cow::Borrowed(value));
    }
    let normal = DVec3::from_slice(value);
    let turned = matrix.inverse().transpose() * normal;
    Some(Cow::Owned(turned.normalize_or(normal).to_array().to_vec()))
}

/// Labels of faces: the meshes, their materials and other subsets.
fn labels(scene: &Scene, cut: &CutFrom) -> Vec<Labels> {
    let mut objects = Labels::new(LabelKind::Object);
    objects.names = scene.meshes.iter().map(|mesh| mesh.name.clone()).collect();
    let mut materials = Named::new(LabelKind::Material);
    let mut groups = Named::new(LabelKind::Group);
    // The labels of the faces of the file, by mesh.
    let mut of_meshes = Vec::new();
    for mesh in &scene.meshes {
        let usual = mesh
            .material
            .as_deref()
            .map_or(NONE, |name| materials.place(name));
        let mut of_faces: HashMap<u32, [u32; 2]> = HashMap::new();
        for subset in mesh
            .subsets
            .iter()
            .filter(|subset| subset.name != PATCH_NAME)
        {
            let (which, place) = match subset.is_material {
                true => (0, materials.place(&subset.name)),
                false => (1, groups.place(&subset.name)),
            };
            for face in &subset.faces {
                of_faces.entry(*face as u32).or_insert([usual, NONE])[which] = place;
            }
        }
        of_meshes.push((usual, of_faces));
    }
    for face in &cut.face {
        let (mesh, face) = scene.faces[*face as usize];
        let (usual, of_faces) = &of_meshes[mesh as usize];
        let [material, group] = of_faces.get(&face).copied().unwrap_or([*usual, NONE]);
        objects.of_face.push(mesh);
        materials.labels.of_face.push(material);
        groups.labels.of_face.push(group);
    }
    let all = [objects, materials.labels, groups.labels].into_iter();
    all.filter(|labels| !labels.names.is_empty()).collect()
}

/// Marks the faces of the subset of patches that an earlier run of isomend wrote.
fn mark_patches(scene: &Scene, cut: &CutFrom, loaded: &mut Loaded) {
    let subsets = scene
        .meshes
        .iter()
        .map(|mesh| mesh.subsets.iter().find(|subset| subset.name == PATCH_NAME));
    let patches: Vec<Option<HashSet<u32>>> = subsets
        .map(|subset| subset.map(|subset| subset.faces.iter().map(|face| *face as u32).collect()))
        .collect();
    if patches.iter().all(Option::is_none) {
        return;
    }
    let mut marks = Attribute::new(PATCH_NAME, Role::Other, Scalar::U8, 1);
    for face in &cut.face {
        let (mesh, face) = scene.faces[*face as usize];
        let is_patch = patches[mesh as usize]
            .as_ref()
            .is_some_and(|faces| faces.contains(&face));
        marks.push(Some(&[f64::from(u8::from(is_patch))]));
    }
    loaded.attributes.face.push(marks);
}

/// Labels with their places by name.
struct Named {
    labels: Labels,
    places: HashMap<String, u32>,
}

impl Named {
    fn new(kind: LabelKind) -> Self {
        Self {
            labels: Labels::new(kind),
            places: HashMap::new(),
        }
    }

    fn place(&mut self, name: &str) -> u32 {
        if let Some(place) = self.places.get(name) {
            return *place;
        }
        let place = self.labels.names.len() as u32;
        self.labels.names.push(name.to_owned());
        self.places.insert(name.to_owned(), place);
        place
    }
}
