//! Writes the changed mesh of an object into the text of its model.

use std::collections::BTreeSet;
use std::ops::Range;

use quick_xml::events::Event;

use super::super::super::Contents;
use super::super::document::BESIDE;
use super::super::model::PATCH_FACES;
use super::super::properties::{Properties, write_none};
use super::super::settings::VOLUME_RANGE;
use super::super::values::number;
use super::super::write::ranges;
use super::edits::{Edits, value_range};
use super::faces::PlacedObject;
use super::outline::{ObjectOutline, Outline};
use super::triangle::{Take, attributes, begin};
use isomend_core::mesh::attributes::{NONE, PATCH_NAME};
use isomend_core::mesh::{Attributes, Mesh};

/// The properties of faces that are not the file's.
pub(super) struct NewProperties<'a> {
    /// Colours and materials. A face has the first property that there is.
    groups: Vec<Properties<'a>>,
    /// For each face its index among the new ones; none for the others.
    index: &'a [u32],
}

/// The mesh and the attributes of the faces that are not the file's.
pub(super) struct NewFaces {
    mesh: Mesh,
    attributes: Attributes,
    index: Vec<u32>,
}

impl NewFaces {
    /// The faces that do not come unchanged from the file. None if there are none, or if faces have no properties.
    pub(super) fn new(model: &Contents<'_>) -> Option<Self> {
        let all = model.attributes;
        let has_faces = all.face.iter().any(|values| values.name != PATCH_NAME);
        let has_materials = !all.materials.is_empty();
        if all.corner.is_empty() && all.vertex.is_empty() && !has_faces && !has_materials {
            return None;
        }
        let is_old = |f: usize| {
            let origin = all.file_faces.as_ref().map(|of| of[f]);
            origin.is_some_and(|o| o.face != NONE && o.corners == [0, 1, 2])
        };
        let is_new: Vec<bool> = (0..model.mesh.faces.len()).map(|f| !is_old(f)).collect();
        let mut index = vec![NONE; is_new.len()];
        let mut faces = Vec::new();
        for (f, _) in is_new.iter().enumerate().filter(|(_, new)| **new) {
            index[f] = faces.len() as u32;
            faces.push(model.mesh.faces[f]);
        }
        (!faces.is_empty()).then(|| Self {
            mesh: Mesh::new(model.mesh.positions.clone(), faces),
            attributes: all.with_faces(&is_new),
            index,
        })
    }

    /// Their properties; none if they have neither colours nor materials.
    pub(super) fn properties(&self) -> Option<NewProperties<'_>> {
        let contents = Contents {
            mesh: &self.mesh,
            attributes: &self.attributes,
            document: None,
        };
        let groups = [
            Properties::colours(&contents),
            Properties::materials(&contents),
        ];
        let has_some = |group: &Properties<'_>| (0..self.mesh.faces.len()).any(|f| group.has(f));
        let groups: Vec<Properties<'_>> = groups.into_iter().flatten().filter(has_some).collect();
        (!groups.is_empty()).then_some(NewProperties {
            groups,
            index: &self.index,
        })
    }
}

impl NewProperties<'_> {
    /// The groups of properties from a number on, with the prefixes of the core and the material namespaces. With the group of no material
    /// if an object takes it as its default.
    pub(super) fn markup(&self, first: u32, prefixes: [&str; 2], with_none: bool) -> String {
        let mut out = String::from("\n");
        for (number, group) in (first..).zip(&self.groups) {
            group.write(&mut out, number, prefixes);
        }
        if with_none {
            write_none(&mut out, self.none(first), prefixes[0]);
        }
        out.truncate(out.trim_end().len());
        out
    }

    /// Whether its colours need the namespace of materials.
    pub(super) fn has_colours(&self) -> bool {
        let is_colour = |group: &Properties<'_>| matches!(group, Properties::Colours { .. });
        self.groups.iter().any(is_colour)
    }

    /// The number of the group of no material, which follows the others.
    fn none(&self, first: u32) -> u32 {
        first.saturating_add(self.groups.len() as u32)
    }

    /// Writes the property of a face. Returns whether it has one.
    fn of_face(&self, out: &mut String, face: u32, first: u32, is_mirrored: bool) -> bool {
        let index = self.index[face as usize] as usize;
        let mut groups = (first..).zip(&self.groups);
        let own = groups.find(|(_, group)| index != NONE as usize && group.has(index));
        if let Some((number, group)) = own {
            group.of_face(out, index, number, is_mirrored);
        }
        own.is_some()
    }
}

/// What is needed to write the objects of a model.
pub(super) struct ModelText<'a> {
    pub(super) text: &'a str,
    pub(super) outline: &'a Outline,
    /// The properties of new faces, and the number of their first group.
    pub(super) properties: Option<(&'a NewProperties<'a>, u32)>,
}

/// What became of an object that was written.
#[derive(Default)]
pub(super) struct Recount {
    /// Its number of triangles before and after.
    pub(super) triangles: [usize; 2],
    /// The first and the last triangle of each part, before and after; none for a part that lost all.
    pub(super) parts: Vec<([usize; 2], Option<[usize; 2]>)>,
    /// Number of triangles that lost paint or properties.
    pub(super) unpainted: usize,
    /// Names of elements of its mesh that were left out, since they number its vertices or triangles.
    pub(super) lost: BTreeSet<String>,
    /// Whether unused vertices stay that were to be left out, since elements number its vertices.
    pub(super) keeps_unused: bool,
    /// Whether it lists patches.
    pub(super) has_marks: bool,
    /// Whether new properties were written for its triangles.
    pub(super) has_new_properties: bool,
    /// Whether it takes the group of no material as its default.
    pub(super) takes_none: bool,
}

impl Recount {
    /// The new range of the part with these first and last triangles; `Some(None)` if it has no triangles any more.
    pub(super) fn range(&self, old: [Option<u32>; 2]) -> Option<Option<[usize; 2]>> {
        let old = [old[0]? as usize, old[1]? as usize];
        // The parts are in the order of their triangles.
        let found = self.parts.binary_search_by_key(&old, |part| part.0);
        Some(self.parts[found.ok()?].1)
    }
}

/// An object that is being written. `of_file` gives the vertex of the file for each vertex of the mesh.
pub(super) struct ObjectText<'a> {
    pub(super) model: &'a ModelText<'a>,
    pub(super) own: PlacedObject<'a>,
    pub(super) outline: &'a ObjectOutline,
    pub(super) of_file: &'a [u32],
}

impl ObjectText<'_> {
    /// Writes the mesh. `number_of` is scratch space with `NONE` for each vertex of the mesh, before and after.
    ///
    /// # Errors
    /// The reason why the object cannot be written.
    pub(super) fn write(
        &self,
        edits: &mut Edits,
        number_of: &mut [u32],
    ) -> Result<Recount, String> {
        let mut recount = Recount {
            triangles: [self.own.object.triangles.len(), self.own.faces().count()],
            ..Recount::default()
        };
        // Elements that number vertices or triangles stay true only if all of these keep their numbers.
        let keeps_numbers = self.own.placement.parts.len() == 1 && self.keeps_triangles();
        let keeps_all = keeps_numbers && !self.outline.others.is_empty();
        recount.keeps_unused = keeps_all && self.own.drops_unused && self.own.has_unused();
        let vertices = self.vertices(number_of, keeps_all)?;
        edits.replace(self.outline.vertices.clone(), vertices);
        let triangles = self.triangles(number_of, &mut recount);
        edits.replace(self.outline.triangles.clone(), triangles);
        self.own.forget_vertices(number_of);
        for (name, range) in &self.outline.others {
            let text = match name.rsplit(':').next() {
                Some("volumes") => self.volumes(range, &recount),
                _ if keeps_numbers => continue,
                _ => None,
            };
            if text.is_none() {
                recount.lost.insert(name.clone());
            }
            edits.replace(range.clone(), text.unwrap_or_default());
        }
        self.mark(edits, &mut recount);
        // An object needs a default property if a triangle has one.
        let needs_default = recount.has_new_properties && !self.outline.has_default;
        let new = self.model.properties.filter(|_| needs_default);
        if let Some((properties, first)) = new {
            let default = format!(" pid=\"{}\" pindex=\"0\"", properties.none(first));
            edits.insert(self.outline.start.end - 1, default);
            recount.takes_none = true;
        }
        Ok(recount)
    }

    /// The list of volumes that Slic3r writes into a mesh, with their new ranges of triangles. None if a volume has no triangles any more, or
    /// if the volumes are not the parts.
    fn volumes(&self, list: &Range<usize>, recount: &Recount) -> Option<String> {
        let text = self.model.text.get(list.clone())?;
        let mut reader = quick_xml::Reader::from_str(text);
        let mut edits = Edits::default();
        loop {
            match reader.read_event().ok()? {
                Event::Eof => return Some(edits.applied(text)),
                Event::Start(tag) | Event::Empty(tag) if tag.local_name().as_ref() == "volume" => {
                    let new = recount.range(VOLUME_RANGE.map(|name| number(&tag, name)))??;
                    for (name, new) in VOLUME_RANGE.into_iter().zip(new) {
                        edits.replace(value_range(text, &tag, name)?, new.to_string());
                    }
                }
                _ => {}
            }
        }
    }

    /// Whether all triangles of the file are still there, in their order and first.
    fn keeps_triangles(&self) -> bool {
        let old = self.own.object.triangles.len();
        let mut first = self.own.faces().take(old);
        let is_old = |t: usize| {
            first
                .next()
                .is_some_and(|f| self.own.origin(f) == Some((t, [0, 1, 2])))
        };
        (0..old).all(is_old)
    }

    fn triangles(&self, number_of: &[u32], recount: &mut Recount) -> String {
        let lead = self.lead(&self.outline.triangles, &self.outline.faces);
        let (mut out, mut first) = (String::new(), 0);
        for (part, faces) in self.own.parts.iter().enumerate() {
            for &f in faces {
                out.push_str(lead);
                self.triangle(&mut out, f, number_of, recount);
            }
            if let Some(old) = self.own.placement.parts.get(part) {
                let range = (!faces.is_empty()).then(|| [first, first + faces.len() - 1]);
                recount.parts.push((old.faces, range));
            }
            first += faces.len();
        }
        out.push_str(self.tail(&self.outline.triangles, &self.outline.faces));
        out
    }

    /// Writes a triangle.
    fn triangle(&self, out: &mut String, f: u32, number_of: &[u32], recount: &mut Recount) {
        let own = &self.own;
        let face = own.model.mesh.faces[f as usize].map(|v| number_of[v as usize]);
        let (prefix, corners) = (&self.model.outline.prefix, own.turned(face));
        let origin = own.origin(f);
        let old = origin.map(|(t, _)| (&self.model.text[self.outline.faces[t].clone()], t));
        let take = origin.map(|(_, corners)| match corners {
            [0, 1, 2] => Take::All,
            corners if [0, 1, 2].iter().all(|k| corners.contains(k)) => {
                let of_file = |k: u8| own.turned([0, 1, 2])[usize::from(k)];
                Take::Turned(own.turned(corners.map(of_file)))
            }
            BESIDE => Take::Paint,
            _ => Take::Part,
        });
        match (old, take) {
            (Some((text, t)), Some(Take::All)) if own.object.triangles[t].corners == corners => {
                out.push_str(text);
            }
            (Some((text, _)), Some(take @ (Take::All | Take::Turned(_)))) => {
                begin(out, prefix, corners);
                let taken = attributes(out, text, take);
                out.push_str(taken.rest);
                recount.unpainted += usize::from(taken.loses_paint);
            }
            (Some((text, _)), Some(Take::Part)) => {
                begin(out, prefix, corners);
                let taken = attributes(out, text, Take::Part);
                // Properties that differ between the corners were interpolated, if they were read.
                let loses = taken.loses_properties && !self.new_property(out, f, recount);
                recount.unpainted += usize::from(taken.loses_paint || loses);
                out.push_str("/>");
            }
            (old, _) => {
                begin(out, prefix, corners);
                self.new_property(out, f, recount);
                // A face beside the triangle, which continues its paint, loses none.
                if let Some((text, _)) = old {
                    attributes(out, text, Take::Paint);
                }
                out.push_str("/>");
            }
        }
    }

    /// Writes the property of a new face. Returns whether it has one.
    fn new_property(&self, out: &mut String, f: u32, recount: &mut Recount) -> bool {
        let is_mirrored = self.own.placement.is_mirrored();
        let own = self.model.properties;
        let has = own.is_some_and(|(own, first)| own.of_face(out, f, first, is_mirrored));
        recount.has_new_properties |= has;
        has
    }

    /// Writes the list of faces of patches.
    fn mark(&self, edits: &mut Edits, recount: &mut Recount) {
        let prefix = &self.model.outline.prefix;
        let is_patch = |f: u32| self.own.model.attributes.is_patch(f as usize);
        let patches = ranges(self.own.faces().map(is_patch));
        recount.has_marks = !patches.is_empty();
        let element = match patches.is_empty() {
            true => String::new(),
            false => format!(
                "<{prefix}metadata name=\"{PATCH_FACES}\" type=\"xs:string\" preserve=\"1\">{patches}</{prefix}metadata>"
            ),
        };
        let group = |element| format!("<{prefix}metadatagroup>{element}</{prefix}metadatagroup>");
        match (&self.outline.marks, self.outline.metadata.clone()) {
            (Some(range), _) => edits.replace(range.clone(), element),
            (None, _) if element.is_empty() => {}
            (None, Some(range)) if range.is_empty() => edits.replace(range, element),
            (None, Some(empty_group)) => edits.replace(empty_group, group(element)),
            (None, None) => edits.insert(self.outline.start.end, group(element)),
        }
    }
}
