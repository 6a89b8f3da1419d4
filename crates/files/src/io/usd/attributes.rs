//! Gathers the values of all meshes of a USD stage, and labels of faces: meshes, materials and subsets.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use glam::{DMat3, DVec3};

use super::super::mesh_builder::CutFrom;
use super::super::{IoError, Loaded};
use super::layers::Layers;
use super::primvar::{Interpolation, Primvar};
use super::stage::{Scene, StageMesh};
use isomend_core::mesh::attributes::{
    Attribute, CornerAttribute, LabelKind, Labels, NONE, PATCH_NAME, Role, Scalar,
};

/// Estimated memory in bytes of the labels of a face that a subset lists.
const LISTED_FACE: usize = 24;

/// Adds the attributes of all meshes. `cut` says from which faces and corners the triangles come.
pub(super) fn gather(
    scene: &Scene,
    cut: &CutFrom,
    loaded: &mut Loaded,
    layers: &mut Layers<'_>,
) -> Result<(), IoError> {
    let mut order: Vec<&str> = Vec::new();
    let mut by_name: HashMap<&str, Vec<(usize, &Primvar)>> = HashMap::new();
    let mut left_out = 0usize;
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
            } else {
                left_out += 1;
            }
        }
    }
    if left_out > 0 {
        loaded.notes.push(format!(
            "skipped: values of meshes whose name has another type in an earlier mesh: {left_out}"
        ));
    }
    let sets = texture_sets(&order, &by_name);
    let (vertices, faces) = (loaded.mesh.positions.len(), loaded.mesh.faces.len());
    for name in order {
        let all = &by_name[name][..];
        let components = all[0].1.components;
        let is_only =
            |wanted: &[Interpolation]| all.iter().all(|(_, p)| wanted.contains(&p.interpolation));
        let is_of_faces = is_only(&[Interpolation::Uniform]);
        let is_of_vertices = is_only(&[Interpolation::Vertex, Interpolation::Constant]);
        let items = match (is_of_faces, is_of_vertices) {
            (true, _) => faces,
            (_, true) => vertices,
            _ => all.iter().fold(3 * faces, |sum, (_, p)| sum + p.stored()),
        };
        layers.budget.spend(items.saturating_mul(9 * components))?;
        let gathering = Gathering {
            scene,
            cut,
            primvars: all,
            role: sets.get(name).map_or(all[0].1.role, |set| Role::Uv(*set)),
        };
        let found = &mut loaded.attributes;
        match (is_of_faces, is_of_vertices) {
            (true, _) => found.face.push(gathering.of_faces()),
            (_, true) => found.vertex.push(gathering.of_vertices(vertices)),
            _ => found.corner.push(gathering.of_corners(&loaded.mesh.faces)),
        }
    }
    let listed = scene.meshes.iter().flat_map(|mesh| &mesh.subsets);
    for subset in listed {
        let size = LISTED_FACE * subset.faces.numbers().len();
        layers.budget.spend(size)?;
    }
    loaded.attributes.labels = labels(scene, cut);
    mark_patches(scene, cut, loaded);
    Ok(())
}

/// The number of each set of texture coordinates, by name: `st` is the first, the others follow as the meshes name them.
fn texture_sets<'n>(
    order: &[&'n str],
    by_name: &HashMap<&str, Vec<(usize, &Primvar)>>,
) -> HashMap<&'n str, u32> {
    let is_set = |name: &&&str| matches!(by_name[**name][0].1.role, Role::Uv(_));
    let mut sets: Vec<&str> = order.iter().filter(is_set).copied().collect();
    sets.sort_by_key(|name| *name != "st");
    sets.into_iter().zip(0..).collect()
}

/// The primvars of one name of several meshes.
struct Gathering<'a> {
    scene: &'a Scene,
    cut: &'a CutFrom,
    primvars: &'a [(usize, &'a Primvar)],
    /// The role of the values; texture coordinates have the number of their set.
    role: Role,
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
        let mut attribute = Attribute::new(&first.name, self.role, scalar, first.components);
        attribute.normalized = first.role == Role::Colour && !scalar.is_float();
        attribute
    }

    fn of_vertices(&self, count: usize) -> Attribute {
        let mut out = self.attribute();
        for (mesh, primvar) in self.primvars {
            let mesh = &self.scene.meshes[*mesh];
            let turning = turning(mesh, primvar);
            out.pad(mesh.vertices.start);
            for item in 0..mesh.vertices.len() {
                let item = if primvar.interpolation == Interpolation::Constant {
                    0
                } else {
                    item
                };
                out.push(turned(primvar.get(item), turning).as_deref());
            }
        }
        out.pad(count);
        out
    }

    fn of_faces(&self) -> Attribute {
        let mut out = self.attribute();
        let own = self.primvars.iter().map(|(mesh, primvar)| {
            let turning = turning(&self.scene.meshes[*mesh], primvar);
            (*mesh, (*primvar, turning))
        });
        let of_mesh: HashMap<usize, (&Primvar, Option<DMat3>)> = own.collect();
        for face in &self.cut.face {
            let (mesh, face) = self.scene.faces[*face as usize];
            let value = of_mesh
                .get(&(mesh as usize))
                .and_then(|(primvar, turning)| turned(primvar.get(face as usize), *turning));
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
            let turning = turning(&self.scene.meshes[*mesh], primvar);
            for place in 0..primvar.stored() {
                pool.push(turned(primvar.at(place), turning).as_deref());
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
            let place = primvar.place(item)?;
            let is_there = pool.get(start.checked_add(place)?).is_some()
                && place < primvar.values.numbers().len() / primvar.components;
            is_there.then_some((start + place) as u32)
        };
        let corners = (0..faces.len()).map(|t| [0, 1, 2].map(|k| place(t, k).unwrap_or(NONE)));
        let corners = corners.collect();
        CornerAttribute { corners, pool }
    }
}

/// The matrix by which values are turned to the stage; `None` if they are not normals, or the mesh is not turned.
fn turning(mesh: &StageMesh, primvar: &Primvar) -> Option<DMat3> {
    let matrix = DMat3::from_mat4(mesh.transform);
    let is_turned = primvar.role == Role::Normal && matrix != DMat3::IDENTITY;
    is_turned.then(|| matrix.inverse().transpose())
}

/// A value, turned to the stage.
fn turned(value: Option<&[f64]>, turning: Option<DMat3>) -> Option<Cow<'_, [f64]>> {
    let (Some(value), Some(turning)) = (value, turning) else {
        return value.map(Cow::Borrowed);
    };
    let normal = DVec3::from_slice(value);
    let turned = turning * normal;
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
            for face in subset.faces_of(mesh.face_count) {
                of_faces.entry(face).or_insert([usual, NONE])[which] = place;
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
    let patches = scene.meshes.iter().map(|mesh| {
        let mut subsets = mesh.subsets.iter();
        let subset = subsets.find(|subset| subset.name == PATCH_NAME)?;
        Some(subset.faces_of(mesh.face_count).collect())
    });
    let patches: Vec<Option<HashSet<u32>>> = patches.collect();
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
