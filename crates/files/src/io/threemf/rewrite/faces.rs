//! Sorts the faces of a mesh into the objects of the 3MF package that the mesh came from.

use std::collections::BTreeMap;

use super::super::super::Contents;
use super::super::document::{BESIDE, Placement, ThreeMfDocument};
use super::super::model::Object;
use isomend_core::mesh::FaceOrigin;
use isomend_core::mesh::attributes::{LabelKind, NONE};

/// The faces of each part of a placement, in the order of the mesh; last those that belong to no part.
pub(super) type FacesOfParts = Vec<Vec<u32>>;

/// The place of a face: placement and part.
type Home = [usize; 2];

/// The faces of each placement of the document.
///
/// # Errors
/// The reason why the mesh does not belong to the document.
pub(super) fn sorted(
    document: &ThreeMfDocument,
    model: &Contents<'_>,
) -> Result<Vec<FacesOfParts>, String> {
    let faces = &model.mesh.faces;
    let origins = model.attributes.file_faces.as_deref();
    if origins.is_some_and(|origins| origins.len() != faces.len()) {
        return Err("its faces do not belong to the file".to_owned());
    }
    let names = Names::new(document, model);
    let mut homes: Vec<Option<Home>> = Vec::with_capacity(faces.len());
    for f in 0..faces.len() {
        homes.push(match origins.map(|origins| origins[f].face) {
            None | Some(NONE) => names.home(f),
            Some(of_file) => Some(home(&document.placements, of_file as usize)?),
        });
    }
    if homes.iter().any(Option::is_none) {
        find_by_vertices(model, &mut homes);
    }
    let only = (document.placements.len() == 1).then_some([0, 0]);
    let empty = |placement: &Placement| vec![Vec::new(); placement.parts.len() + 1];
    let mut sorted: Vec<FacesOfParts> = document.placements.iter().map(empty).collect();
    for (f, home) in homes.into_iter().enumerate() {
        let Some([placement, part]) = home.or(only) else {
            return Err("some of its new faces belong to no object of the file".to_owned());
        };
        sorted[placement][part].push(f as u32);
    }
    Ok(sorted)
}

/// The place of a face of the file.
fn home(placements: &[Placement], face: usize) -> Result<Home, String> {
    let number = placements.partition_point(|p| p.faces.0 + p.faces.1 <= face);
    let placement = placements.get(number);
    let placement = placement.ok_or("it has faces that the file does not have")?;
    let own = face - placement.faces.0;
    Ok([number, placement.part_of(own)])
}

/// The places that the labels of objects and parts name.
struct Names<'a> {
    model: &'a Contents<'a>,
    homes: BTreeMap<[&'a str; 2], Home>,
    /// The object of faces if there are no labels.
    only: &'a str,
}

impl<'a> Names<'a> {
    fn new(document: &'a ThreeMfDocument, model: &'a Contents<'a>) -> Self {
        let mut homes = BTreeMap::new();
        for (number, placement) in document.placements.iter().enumerate() {
            for (part, own) in placement.parts.iter().enumerate() {
                let key = [&placement.name[..], &own.name[..]];
                homes.entry(key).or_insert([number, part]);
            }
        }
        let first = document.placements.first();
        Self {
            model,
            homes,
            only: first.map_or("", |placement| &placement.name),
        }
    }

    fn home(&self, face: usize) -> Option<Home> {
        let label = |kind| self.model.attributes.labels_of(kind);
        let object = match label(LabelKind::Object) {
            Some(labels) => labels.get(face)?,
            None => self.only,
        };
        let part = label(LabelKind::Part).and_then(|labels| labels.get(face));
        self.homes.get(&[object, part.unwrap_or_default()]).copied()
    }
}

/// Gives each face without a place the place of a face that shares a vertex, or of the face before it.
fn find_by_vertices(model: &Contents<'_>, homes: &mut [Option<Home>]) {
    let mut of_vertex: Vec<Option<Home>> = vec![None; model.mesh.positions.len()];
    let faces = &model.mesh.faces;
    let known = faces.iter().zip(homes.iter());
    for (face, home) in known.filter(|(_, home)| home.is_some()) {
        face.iter().for_each(|v| of_vertex[*v as usize] = *home);
    }
    let mut last = None;
    for (face, home) in faces.iter().zip(homes) {
        let beside = || face.iter().find_map(|v| of_vertex[*v as usize]);
        *home = home.or_else(beside).or(last);
        face.iter().for_each(|v| of_vertex[*v as usize] = *home);
        last = *home;
    }
}

/// Whether triangles use all vertices up to a number.
pub(super) fn uses_all(count: usize, triangles: impl Iterator<Item = [u32; 3]>) -> bool {
    let mut is_used = vec![false; count];
    triangles.flatten().for_each(|v| is_used[v as usize] = true);
    !is_used.contains(&false)
}

/// An object of the file in one of its places, with its faces in the mesh.
#[derive(Clone, Copy)]
pub(super) struct PlacedObject<'a> {
    pub(super) placement: &'a Placement,
    pub(super) object: &'a Object,
    pub(super) model: &'a Contents<'a>,
    pub(super) parts: &'a FacesOfParts,
    /// Whether vertices that neither the file nor the mesh uses are left out.
    pub(super) drops_unused: bool,
    /// Whether that is all that is to be changed.
    pub(super) only_unused: bool,
}

impl<'a> PlacedObject<'a> {
    /// Its faces in the mesh, part by part.
    pub(super) fn faces(&self) -> impl Iterator<Item = u32> + use<'a> {
        self.parts.iter().flatten().copied()
    }

    /// The triangle of the object from which a face comes, and the corner of the triangle that each corner is; 3 for none. Corners are
    /// counted as in the mesh.
    pub(super) fn origin(&self, face: u32) -> Option<(usize, [u8; 3])> {
        let origins = self.model.attributes.file_faces.as_ref()?;
        let FaceOrigin { face, corners } = origins[face as usize];
        Some((
            (face as usize).checked_sub(self.placement.faces.0)?,
            corners,
        ))
        .filter(|(triangle, _)| *triangle < self.object.triangles.len())
    }

    /// Exchanges the last two corners if the transform reverses the orientation: between the order of the mesh and of the file.
    pub(super) fn turned<T: Copy>(&self, [a, b, c]: [T; 3]) -> [T; 3] {
        match self.placement.is_mirrored() {
            true => [a, c, b],
            false => [a, b, c],
        }
    }

    /// For each vertex of its faces the vertex of the object that it is, in `of_file`, whose other values stay. A vertex of the object that
    /// is at another position now is none.
    pub(super) fn find_vertices(&self, of_file: &mut [u32]) {
        for f in self.faces() {
            let Some((triangle, corners)) = self.origin(f) else {
                continue;
            };
            let old = self.turned(self.object.triangles[triangle].corners);
            for (v, corner) in self.model.mesh.faces[f as usize].into_iter().zip(corners) {
                let Some(own) = old.get(usize::from(corner)) else {
                    continue;
                };
                let placed = self.placement.placed(self.object.positions[*own as usize]);
                if placed == self.model.mesh.positions[v as usize] {
                    let place = &mut of_file[v as usize];
                    *place = (*place).min(*own);
                }
            }
        }
    }

    /// Sets the values of its vertices to none again.
    pub(super) fn forget_vertices(&self, of_file: &mut [u32]) {
        for f in self.faces() {
            let face = self.model.mesh.faces[f as usize];
            face.iter().for_each(|v| of_file[*v as usize] = NONE);
        }
    }

    /// Whether the object has vertices that none of its triangles uses.
    pub(super) fn has_unused(&self) -> bool {
        let triangles = self.object.triangles.iter();
        !uses_all(self.object.positions.len(), triangles.map(|t| t.corners))
    }

    /// Extends ranges of heights in the build by its triangles: the first range by the triangles of the file, the second by its faces in
    /// the mesh.
    pub(super) fn add_heights(&self, [before, after]: &mut [[f64; 2]; 2]) {
        let add = |[low, high]: &mut [f64; 2], z: f64| {
            (*low, *high) = (low.min(z), high.max(z));
        };
        for v in self.object.triangles.iter().flat_map(|t| t.corners) {
            let p = self.object.positions[v as usize];
            add(before, self.placement.placed(p).z);
        }
        for v in self.faces().flat_map(|f| self.model.mesh.faces[f as usize]) {
            add(after, self.model.mesh.positions[v as usize].z);
        }
    }

    /// Whether its mesh is the same as in the file. `of_file` is filled by [`PlacedObject::find_vertices`].
    pub(super) fn is_same(&self, of_file: &[u32]) -> bool {
        let mut vertex_of = vec![NONE; self.object.positions.len()];
        let mut count = 0;
        // In the order of the file, in which triangles between two parts may belong to none.
        let mut faces: Vec<u32> = self.faces().collect();
        faces.sort_unstable();
        for (number, f) in faces.into_iter().enumerate() {
            if self.origin(f) != Some((number, [0, 1, 2])) {
                return false;
            }
            let old = self.turned(self.object.triangles[number].corners);
            for (v, own) in self.model.mesh.faces[f as usize].into_iter().zip(old) {
                let known = &mut vertex_of[own as usize];
                if of_file[v as usize] != own || !(*known == NONE || *known == v) {
                    return false;
                }
                *known = v;
            }
            count += 1;
        }
        count == self.object.triangles.len()
    }

    /// Whether the same triangles were kept as in another place of the same object, and both or none have new faces. New faces that
    /// are painted as a triangle beside them are new as well.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let kept_as = |own: &Self, f| own.origin(f).filter(|(_, corners)| *corners != BESIDE);
        let kept = |own: &Self| {
            let own = *own;
            own.faces().filter_map(move |f| kept_as(&own, f))
        };
        let has_new = |own: &Self| own.faces().any(|f| kept_as(own, f).is_none());
        kept(self).eq(kept(other)) && has_new(self) == has_new(other)
    }
}
