//! Corrects what slicers note about the triangles of objects in their own files: ranges and numbers of triangles.

use std::collections::BTreeMap;
use std::ops::Range;

use quick_xml::events::{BytesStart, Event};

use super::super::settings::FILE_RANGE;
use super::super::values::number;
use super::edits::{Edits, value_range};
use super::object::Recount;

/// The changed objects by model part and number.
pub(super) type Recounts = BTreeMap<(String, u32), Recount>;

/// The components of the objects of the main model: model part and number of each.
pub(super) type Components = BTreeMap<u32, Vec<(String, u32)>>;

/// The kind of the parts that the number of faces of a whole object counts. A part without a kind is one of them.
const COUNTED_PART: &str = "normal_part";

/// A file of a slicer that is being corrected.
pub(super) struct Config<'a> {
    pub(super) text: &'a str,
    /// The name of the main model.
    pub(super) main: &'a str,
    pub(super) recounts: &'a Recounts,
    pub(super) components: &'a Components,
    /// The parts of each object that the object's number of faces counts.
    pub(super) counted: BTreeMap<u32, Vec<u32>>,
}

/// What was corrected.
pub(super) struct Corrected {
    pub(super) edits: Edits,
    /// Number of volumes that lost all triangles, and of volumes of changed objects whose range is none of the mesh.
    pub(super) emptied: usize,
    pub(super) unknown: usize,
}

impl Config<'_> {
    /// What became of a part of an object, if its mesh changed.
    fn part(&self, object: u32, part: u32) -> Option<&Recount> {
        let mut components = self.components.get(&object)?.iter();
        self.recounts.get(components.find(|(_, id)| *id == part)?)
    }

    /// Corrects ranges of volumes (PrusaSlicer, SuperSlicer) and numbers of faces (Bambu Studio, OrcaSlicer).
    pub(super) fn corrected(&self) -> Corrected {
        let mut done = Corrected {
            edits: Edits::default(),
            emptied: 0,
            unknown: 0,
        };
        let mut reader = quick_xml::Reader::from_str(self.text);
        let (mut object, mut part) = (None, None);
        // The start of the volume that is being removed.
        let mut removed: Option<usize> = None;
        loop {
            let from = reader.buffer_position() as usize;
            let event = reader.read_event();
            let to = reader.buffer_position() as usize;
            match event {
                Err(_) | Ok(Event::Eof) => return done,
                Ok(Event::End(tag)) => match tag.name().as_ref() {
                    "object" => object = None,
                    "part" => part = None,
                    "volume" => {
                        if let Some(start) = removed.take() {
                            done.edits.replace(start..to, "");
                        }
                    }
                    _ => {}
                },
                Ok(Event::Start(tag)) => match tag.name().as_ref() {
                    "object" => object = number(&tag, "id"),
                    "part" => part = number(&tag, "id"),
                    "volume" if self.is_emptied(object, &tag) => {
                        removed = Some(from);
                        done.emptied += 1;
                    }
                    _ => self.tag(&tag, object, part, &mut done),
                },
                Ok(Event::Empty(tag)) if self.is_emptied(object, &tag) => {
                    done.edits.replace(from..to, "");
                    done.emptied += 1;
                }
                Ok(Event::Empty(tag)) if removed.is_none() => {
                    self.tag(&tag, object, part, &mut done);
                }
                Ok(_) => {}
            }
        }
    }

    /// Whether a tag is a volume that has no triangles any more.
    fn is_emptied(&self, object: Option<u32>, tag: &BytesStart<'_>) -> bool {
        tag.name().as_ref() == "volume" && self.range(object, tag) == Some(None)
    }

    /// The new range of a volume of a changed object; `Some(None)` if it has no triangles any more.
    fn range(&self, object: Option<u32>, tag: &BytesStart<'_>) -> Option<Option<[usize; 2]>> {
        let recount = self.recounts.get(&(self.main.to_owned(), object?))?;
        recount.range(FILE_RANGE.map(|name| number(tag, name)))
    }

    fn tag(
        &self,
        tag: &BytesStart<'_>,
        object: Option<u32>,
        part: Option<u32>,
        done: &mut Corrected,
    ) {
        let edits = &mut done.edits;
        match tag.name().as_ref() {
            "volume" => {
                let key = object.map(|id| (self.main.to_owned(), id));
                let is_changed = key.is_some_and(|key| self.recounts.contains_key(&key));
                let Some(Some(range)) = self.range(object, tag) else {
                    done.unknown += usize::from(is_changed);
                    return;
                };
                for (name, new) in FILE_RANGE.into_iter().zip(range) {
                    self.set(tag, name, new, edits);
                }
            }
            "mesh_stat" => {
                if let (Some(object), Some(part)) = (object, part)
                    && let Some(recount) = self.part(object, part)
                {
                    self.set(tag, "face_count", recount.triangles[1], edits);
                }
            }
            "metadata" if part.is_none() => {
                let (Some(old), Some(object)) = (number(tag, "face_count"), object) else {
                    return;
                };
                let parts = self.counted.get(&object).into_iter().flatten();
                let recounts = parts.filter_map(|part| self.part(object, *part));
                let mut new = old as usize;
                for Recount { triangles, .. } in recounts {
                    new = (new + triangles[1]).saturating_sub(triangles[0]);
                }
                self.set(tag, "face_count", new, edits);
            }
            _ => {}
        }
    }

    /// Sets the value of an attribute if it is another.
    fn set(&self, tag: &BytesStart<'_>, name: &str, value: usize, edits: &mut Edits) {
        let range: Option<Range<usize>> = value_range(self.text, tag, name);
        let value = value.to_string();
        if let Some(range) = range.filter(|range| self.text[range.clone()] != value) {
            edits.replace(range, value);
        }
    }
}

/// The parts of each object that the object's number of faces counts, by their numbers.
pub(super) fn counted_parts(text: &str) -> BTreeMap<u32, Vec<u32>> {
    let mut counted: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let mut reader = quick_xml::Reader::from_str(text);
    let mut object = None;
    while let Ok(event) = reader.read_event() {
        match event {
            Event::Eof => break,
            Event::Start(tag) | Event::Empty(tag) => match tag.name().as_ref() {
                "object" => object = number(&tag, "id"),
                "part" => {
                    let subtype = tag.try_get_attribute("subtype").ok().flatten();
                    let is_counted = subtype.is_none_or(|own| own.value == COUNTED_PART);
                    let part = number(&tag, "id").filter(|_| is_counted);
                    if let (Some(object), Some(part)) = (object, part) {
                        counted.entry(object).or_default().push(part);
                    }
                }
                _ => {}
            },
            _ => {}
        }
    }
    counted
}
