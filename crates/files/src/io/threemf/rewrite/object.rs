//! Writes the changed mesh of an object into the text of its model.

use std::collections::BTreeSet;
use std::fmt::Write as _;
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
        edits.replace(
            self.outline.vertices.clone(),
            self.vertices(number_of, keeps_all)?,
        );
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

    /// The vertices, part by part: first the vertices of the file in their order, then new ones. Fills in the number of each vertex of the mesh.
    fn vertices(&self, number_of: &mut [u32], keeps_all: bool) -> Result<String, String> {
        let (own, points) = (&self.own, &self.outline.points);
        let back = own.placement.back();
        let back = back.ok_or("the transform of a changed object has no inverse")?;
        let lead = self.lead(&self.outline.vertices, points.first());
        let parts = self.vertices_of_parts(keeps_all);
        let (mut out, mut next) = (String::new(), 0);
        let mut used = vec![NONE; points.len()];
        for f in own.faces() {
            for v in own.model.mesh.faces[f as usize] {
                if let Some(first) = used.get_mut(self.of_file[v as usize] as usize) {
                    *first = (*first).min(v);
                }
            }
        }
        for (part, faces) in parts.iter().zip(own.parts) {
            for &point in part {
                out.push_str(lead);
                out.push_str(&self.model.text[points[point as usize].clone()]);
                if let Some(number) = number_of.get_mut(used[point as usize] as usize) {
                    *number = next;
                }
                next += 1;
            }
            let corners = faces.iter().flat_map(|f| own.model.mesh.faces[*f as usize]);
            let mut new: Vec<u32> = corners.filter(|v| number_of[*v as usize] == NONE).collect();
            new.sort_unstable();
            new.dedup();
            for v in new {
                out.push_str(lead);
                // A copy of a vertex of the file has the same text.
                match points.get(self.of_file[v as usize] as usize) {
                    Some(range) => out.push_str(&self.model.text[range.clone()]),
                    None => {
                        let p = back(own.model.mesh.positions[v as usize]);
                        let prefix = &self.model.outline.prefix;
                        let _ = write!(
                            out,
                            "<{prefix}vertex x=\"{}\" y=\"{}\" z=\"{}\"/>",
                            p.x, p.y, p.z
                        );
                    }
                }
                number_of[v as usize] = next;
                next += 1;
            }
        }
        out.push_str(self.tail(&self.outline.vertices, points.last()));
        Ok(out)
    }

    /// The vertices of the file that stay, for each part. A vertex stays if a face uses it, or if no triangle of the file did.
    fn vertices_of_parts(&self, keeps_all: bool) -> Vec<Vec<u32>> {
        let (own, parts) = (&self.own, &self.own.placement.parts);
        let count = own.object.positions.len();
        let mut part_of = vec![NONE; count];
        for (t, triangle) in own.object.triangles.iter().enumerate() {
            let part = own.placement.part_of(t) as u32;
            for v in triangle.corners {
                part_of[v as usize] = part_of[v as usize].min(part);
            }
        }
        let mut stays: Vec<bool> = part_of.iter().map(|p| keeps_all || *p == NONE).collect();
        for f in own.faces() {
            for v in own.model.mesh.faces[f as usize] {
                if let Some(stays) = stays.get_mut(self.of_file[v as usize] as usize) {
                    *stays = true;
                }
            }
        }
        let mut all = vec![Vec::new(); parts.len() + 1];
        let mut last = 0;
        for (v, part) in part_of.into_iter().enumerate() {
            if part != NONE {
                last = part as usize;
            }
            if stays[v] {
                all[last].push(v as u32);
            }
        }
        all
    }

    fn triangles(&self, number_of: &[u32], recount: &mut Recount) -> String {
        let lead = self.lead(&self.outline.triangles, self.outline.faces.first());
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
        out.push_str(self.tail(&self.outline.triangles, self.outline.faces.last()));
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

    /// The blanks before each element of a list; a line break if the list is empty.
    fn lead(&self, list: &Range<usize>, first: Option<&Range<usize>>) -> &str {
        let blank = first.and_then(|first| self.model.text.get(list.start..first.start));
        blank.unwrap_or("\n")
    }

    /// The blanks after the last element of a list.
    fn tail(&self, list: &Range<usize>, last: Option<&Range<usize>>) -> &str {
        let text = last.and_then(|last| self.model.text.get(last.end..list.end));
        text.unwrap_or("\n")
    }
}
