//! Reads what slicers note about the objects of a 3MF project: names, and the volumes that an object's triangles belong to.
//!
//! PrusaSlicer and SuperSlicer write the meshes of all volumes of an object as one mesh, and the range of triangles of each volume into
//! a file; Slic3r writes the ranges into the mesh. Bambu Studio and OrcaSlicer write an object for each volume, and its name into
//! `Metadata/model_settings.config`. Both files may be missing or damaged: then there are no names and no volumes.

use std::collections::BTreeMap;

use quick_xml::events::{BytesStart, Event};

use super::values::{check_name, number, unescaped};

/// The files with the volumes of each object, in the order in which SuperSlicer looks for them. It writes several; PrusaSlicer writes the
/// last one.
pub(super) const VOLUMES: [&str; 3] = [
    "Metadata/Slic3r_model.config",
    "Metadata/SuperSlicer_model.config",
    "Metadata/Slic3r_PE_model.config",
];
/// The attributes of a volume in these files: its first and its last triangle.
pub(super) const FILE_RANGE: [&str; 2] = ["firstid", "lastid"];
/// The same of a volume in a mesh of Slic3r.
pub(super) const VOLUME_RANGE: [&str; 2] = ["ts", "te"];
/// The file of Bambu Studio and OrcaSlicer with the parts of each object.
pub(super) const PARTS: &str = "Metadata/model_settings.config";

/// What slicers note about the objects of the main model, by the numbers of these.
#[derive(Default)]
pub(super) struct Settings {
    pub(super) objects: BTreeMap<u32, ObjectSettings>,
}

/// What slicers note about an object.
#[derive(Default)]
pub(super) struct ObjectSettings {
    /// Its name; empty for none.
    pub(super) name: String,
    /// Its volumes in the order of their triangles.
    pub(super) volumes: Vec<Volume>,
    /// The names of its components, by the numbers of their objects.
    pub(super) parts: BTreeMap<u32, String>,
}

/// A range of an object's triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Volume {
    /// First and last triangle.
    pub(super) faces: [usize; 2],
    pub(super) name: String,
}

impl Settings {
    /// Reads the given files; faults end the reading of a file without an error.
    pub(super) fn new(files: &[String]) -> Self {
        let mut settings = Self::default();
        for text in files {
            settings.read(text);
        }
        for object in settings.objects.values_mut() {
            object.volumes.sort_by_key(|volume| volume.faces);
        }
        settings
    }

    fn read(&mut self, text: &str) {
        let mut reader = quick_xml::Reader::from_str(text);
        let (mut object, mut inner) = (None, Inner::Object);
        loop {
            match reader.read_event() {
                Err(_) | Ok(Event::Eof) => return,
                Ok(Event::Start(tag)) => self.start(&tag, &mut object, &mut inner),
                Ok(Event::Empty(tag)) => {
                    let before = (object, inner);
                    self.start(&tag, &mut object, &mut inner);
                    (object, inner) = before;
                }
                Ok(Event::End(tag)) => match tag.name().as_ref() {
                    "object" => object = None,
                    "volume" | "part" => inner = Inner::Object,
                    _ => {}
                },
                Ok(_) => {}
            }
        }
    }

    fn start(&mut self, tag: &BytesStart<'_>, object: &mut Option<u32>, inner: &mut Inner) {
        match tag.name().as_ref() {
            "object" => {
                *object = number(tag, "id");
                *inner = Inner::Object;
                if let Some(id) = *object {
                    self.objects.entry(id).or_default();
                }
            }
            "volume" => {
                let faces = number(tag, FILE_RANGE[0]).zip(number(tag, FILE_RANGE[1]));
                *inner = Inner::Unknown;
                if let (Some(own), Some((first, last))) = (self.of(*object), faces) {
                    own.volumes.push(Volume {
                        faces: [first as usize, last as usize],
                        name: String::new(),
                    });
                    *inner = Inner::Volume;
                }
            }
            "part" => {
                *inner = Inner::Unknown;
                if let (Some(own), Some(id)) = (self.of(*object), number(tag, "id")) {
                    own.parts.entry(id).or_default();
                    *inner = Inner::Part(id);
                }
            }
            "metadata" if value(tag, "key").as_deref() == Some("name") => {
                let name = value(tag, "value").map(|name| unescaped(&name));
                let name = name.filter(|name| check_name(name).is_ok());
                let (Some(own), Some(name)) = (self.of(*object), name) else {
                    return;
                };
                let place = match *inner {
                    Inner::Object => Some(&mut own.name),
                    Inner::Volume => own.volumes.last_mut().map(|volume| &mut volume.name),
                    Inner::Part(id) => own.parts.get_mut(&id),
                    Inner::Unknown => None,
                };
                if let Some(place) = place {
                    name.trim().clone_into(place);
                }
            }
            _ => {}
        }
    }

    fn of(&mut self, object: Option<u32>) -> Option<&mut ObjectSettings> {
        self.objects.get_mut(&object?)
    }

    /// The volumes of an object with this number of triangles: those that a file notes of the object of the main model with this number, or
    /// else those in its mesh. None if they are fewer than two, overlap or are not all in the object.
    pub(super) fn volumes<'a>(
        &'a self,
        of_main: Option<u32>,
        in_mesh: &'a [Volume],
        triangles: usize,
    ) -> &'a [Volume] {
        let noted = of_main.and_then(|id| self.objects.get(&id));
        let all = [noted.map(|own| &own.volumes[..]), Some(in_mesh)];
        let mut all = all.into_iter().flatten();
        all.find(|all| all.len() > 1 && are_ranges(all, triangles))
            .unwrap_or_default()
    }
}

/// Whether sorted volumes are disjoint ranges of this number of triangles.
fn are_ranges(volumes: &[Volume], triangles: usize) -> bool {
    let mut next = 0;
    volumes.iter().all(|volume| {
        let [first, last] = volume.faces;
        let fits = next <= first && first <= last && last < triangles;
        next = last.saturating_add(1);
        fits
    })
}

/// The element to which a name belongs.
#[derive(Clone, Copy)]
enum Inner {
    Object,
    Volume,
    Part(u32),
    /// A volume without a range of triangles, or a part without a number.
    Unknown,
}

/// The raw value of an attribute.
fn value(tag: &BytesStart<'_>, name: &str) -> Option<String> {
    let found = tag.try_get_attribute(name).ok().flatten()?;
    Some(found.value.to_string())
}
