//! Parses the XML of a model in a 3MF package: objects, properties, build items.

use std::collections::BTreeMap;

use glam::{DAffine3, DVec3};
use quick_xml::events::{BytesStart, Event};

use super::super::{Format, IoError, Location, text};
use super::fault;
use super::settings::{VOLUME_RANGE, Volume};
use super::values::{check_name, colour_of, number, patch_ranges, transform, unescaped, whole};
use isomend_core::mesh::Unit;
use isomend_core::mesh::attributes::NONE;

/// Name of the object metadata that lists the faces of patches.
pub(super) const PATCH_FACES: &str = "isomend:patch";

/// Name of the base material that isomend writes for faces without a material, because an object with properties must
/// name one.
pub(super) const NO_MATERIAL: &str = "isomend:none";

/// Names of units in the `unit` attribute.
const UNITS: [(&str, Unit); 6] = [
    ("micron", Unit::Micrometre),
    ("millimeter", Unit::Millimetre),
    ("centimeter", Unit::Centimetre),
    ("inch", Unit::Inch),
    ("foot", Unit::Foot),
    ("meter", Unit::Metre),
];

/// The word for a unit in the `unit` attribute.
pub(super) fn unit_word(unit: Unit) -> &'static str {
    let known = UNITS.iter().find(|(_, known)| *known == unit);
    known.map_or("millimeter", |(word, _)| word)
}

/// Most names of attributes of triangles that are listed as not read.
const MOST_MARKS: usize = 16;

/// Most attributes of a tag. The check for duplicate attributes takes quadratic time.
const MOST_ATTRIBUTES: usize = 256;

/// A parsed model part: its objects, properties and build items.
pub(super) struct Part {
    pub(super) unit: Unit,
    /// Number of objects whose list of patch faces does not match their faces and is ignored.
    pub(super) unmatched_marks: usize,
    pub(super) objects: BTreeMap<u32, Object>,
    pub(super) groups: BTreeMap<u32, Group>,
    pub(super) items: Vec<Use>,
    /// Number of beams of the lattices of its objects, which are not read.
    pub(super) beams: usize,
    /// Names of the attributes of triangles that are not read, such as paint; at most [`MOST_MARKS`].
    pub(super) marks: Vec<String>,
    /// Whether it has metadata besides the name of the program that wrote it.
    pub(super) has_metadata: bool,
}

impl Part {
    /// The names of other parts that its items and components refer to.
    pub(super) fn other_parts(&self) -> impl Iterator<Item = String> {
        let components = self.objects.values().flat_map(|o| &o.components);
        let uses = self.items.iter().chain(components);
        uses.filter_map(|u| u.part.clone())
    }
}

/// An object: a mesh, or a set of other objects.
#[derive(Default)]
pub(super) struct Object {
    pub(super) name: String,
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: Vec<Triangle>,
    pub(super) components: Vec<Use>,
    /// Default property of its triangles: group and index.
    pub(super) property: Option<[u32; 2]>,
    /// Faces of patches: first and last face of ascending, disjoint ranges.
    pub(super) patches: Vec<[usize; 2]>,
    /// Whether the object is a support for printing.
    pub(super) is_support: bool,
    /// The volumes of its triangles, as Slic3r writes them into the mesh.
    pub(super) volumes: Vec<Volume>,
}

/// A triangle with its property: the group (`NONE` for none) and the index in the group for each corner.
#[derive(Clone, Copy)]
pub(super) struct Triangle {
    pub(super) corners: [u32; 3],
    pub(super) group: u32,
    pub(super) places: [u32; 3],
}

/// A group of properties, to which triangles refer by index.
pub(super) enum Group {
    /// Red, green, blue, opacity; 0 to 255.
    Colours(Vec<[u8; 4]>),
    /// Names and colours of base materials.
    Materials(Vec<(String, [u8; 4])>),
}

/// A placed object: a build item or a component.
#[derive(Clone)]
pub(super) struct Use {
    pub(super) object: u32,
    /// The part that contains the object; `None` for the same part.
    pub(super) part: Option<String>,
    pub(super) transform: DAffine3,
}

/// Parses a model. `left`: bytes of memory that parsed items may still take, over all models.
pub(super) fn parse(markup: &str, left: &mut usize) -> Result<Part, IoError> {
    let mut reader = quick_xml::Reader::from_str(markup);
    let mut open = Open {
        part: Part {
            unit: Unit::Millimetre,
            unmatched_marks: 0,
            objects: BTreeMap::new(),
            groups: BTreeMap::new(),
            items: Vec::new(),
            beams: 0,
            marks: Vec::new(),
            has_metadata: false,
        },
        left,
        core: Vec::new(),
        object: None,
        group: None,
        in_mesh: false,
        reads_patches: false,
        patches: String::new(),
    };
    loop {
        let event = reader.read_event();
        let at = reader.buffer_position() as usize;
        let damaged = |what: String| {
            IoError::malformed(
                Format::ThreeMf,
                Location::File,
                format!("byte {at} of the model: {what}"),
            )
        };
        match event.map_err(|e| damaged(format!("the XML is damaged ({e})")))? {
            Event::Eof => break,
            Event::Start(tag) if !open.start(&tag).map_err(damaged)? => {
                let skipped = reader.read_to_end(tag.name());
                skipped.map_err(|e| damaged(format!("the XML is damaged ({e})")))?;
            }
            Event::Empty(tag) if open.start(&tag).map_err(damaged)? => {
                open.end(tag.local_name().as_ref());
            }
            Event::Text(content) if open.reads_patches => open.patches += &content,
            Event::End(tag) => open.end(tag.local_name().as_ref()),
            _ => {}
        }
    }
    match open.core.is_empty() {
        false => Ok(open.part),
        true => Err(fault("there is no model element in it")),
    }
}

/// The state of a model being parsed.
struct Open<'a> {
    part: Part,
    /// Bytes of memory that parsed items may still take.
    left: &'a mut usize,
    /// The prefixes of the core namespace, that is, the namespace of the model element. Empty before that element.
    core: Vec<String>,
    /// The open object, and below the open group of properties.
    object: Option<u32>,
    group: Option<u32>,
    in_mesh: bool,
    reads_patches: bool,
    /// The text of the open object's list of patch faces.
    patches: String,
}

impl Open<'_> {
    /// Handles a start tag. Returns false for elements that are not read, whose content is then skipped.
    fn start(&mut self, tag: &BytesStart<'_>) -> Result<bool, String> {
        let (name, prefix) = tag.name().decompose();
        let prefix = prefix.as_ref().map_or("", |prefix| prefix.as_ref());
        let is_core = self.core.iter().any(|core| core == prefix);
        match name.as_ref() {
            // Elements of the beam lattice extension.
            "beamlattice" | "beams" => {}
            "beam" => self.part.beams += 1,
            // Elements of the material extension. Older colours, outside of a group, have another form.
            "colorgroup" => self.begin_group(tag, Group::Colours(Vec::new()))?,
            "color" if self.group.is_some() => self.colour(tag)?,
            "model" if self.core.is_empty() => self.model(tag)?,
            "volumes" if self.in_mesh => {}
            "volume" if self.in_mesh => self.volume(tag)?,
            _ if !is_core => return Ok(false),
            "vertex" if self.in_mesh => self.vertex(tag)?,
            "triangle" if self.in_mesh => self.triangle(tag)?,
            "object" => self.begin_object(tag)?,
            "mesh" if self.object.is_some() => self.in_mesh = true,
            "component" => {
                let used = used(tag)?;
                self.spend(size_of::<Use>())?;
                if let Some(object) = self.open_object() {
                    object.components.push(used);
                }
            }
            "item" => {
                self.spend(size_of::<Use>())?;
                self.part.items.push(used(tag)?);
            }
            "basematerials" => self.begin_group(tag, Group::Materials(Vec::new()))?,
            "base" => self.base(tag)?,
            "metadata" => {
                let mut name = String::new();
                each(tag, |key, value| {
                    if key == "name" {
                        name = value.to_owned();
                    }
                })?;
                self.part.has_metadata |= self.object.is_none() && name != "Application";
                self.reads_patches = name == PATCH_FACES && self.object.is_some();
            }
            "resources" | "build" | "vertices" | "triangles" | "components" | "metadatagroup" => {}
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn end(&mut self, name: &str) {
        self.reads_patches = false;
        match name {
            "mesh" => self.in_mesh = false,
            "object" => self.end_object(),
            "basematerials" | "colorgroup" => self.group = None,
            _ => {}
        }
    }

    /// Charges memory for a parsed item.
    fn spend(&mut self, bytes: usize) -> Result<(), String> {
        let left = self.left.checked_sub(bytes);
        *self.left = left.ok_or("its objects take more memory than is allowed")?;
        Ok(())
    }

    /// Reads a volume of Slic3r: the first and the last of its triangles.
    fn volume(&mut self, tag: &BytesStart<'_>) -> Result<(), String> {
        let range = number(tag, VOLUME_RANGE[0]).zip(number(tag, VOLUME_RANGE[1]));
        self.spend(size_of::<Volume>())?;
        if let (Some(object), Some((first, last))) = (self.open_object(), range) {
            object.volumes.push(Volume {
                faces: [first as usize, last as usize],
                name: String::new(),
            });
        }
        Ok(())
    }

    fn base(&mut self, tag: &BytesStart<'_>) -> Result<(), String> {
        let [mut name, mut colour] = [String::new(), String::new()];
        each(tag, |key, value| match key {
            "name" => name = unescaped(value),
            "displaycolor" => colour = value.to_owned(),
            _ => {}
        })?;
        check_name(&name)?;
        self.spend(size_of::<(String, [u8; 4])>() + name.len())?;
        if let Some(Group::Materials(all)) = self.open_group() {
            all.push((name, colour_of(&colour).unwrap_or([200, 200, 200, 255])));
        }
        Ok(())
    }

    fn colour(&mut self, tag: &BytesStart<'_>) -> Result<(), String> {
        let mut colour = String::new();
        each(tag, |key, value| {
            if key == "color" {
                colour = value.to_owned();
            }
        })?;
        let colour = colour_of(&colour)
            .ok_or_else(|| format!("{} is not a colour", text::shown(colour.as_bytes())))?;
        self.spend(size_of::<[u8; 4]>())?;
        if let Some(Group::Colours(all)) = self.open_group() {
            all.push(colour);
        }
        Ok(())
    }

    fn model(&mut self, tag: &BytesStart<'_>) -> Result<(), String> {
        let mut word = None;
        each(tag, |key, value| {
            if key == "unit" {
                word = Some(value.to_owned());
            }
        })?;
        if let Some(word) = word {
            let unit = UNITS.iter().find(|(name, _)| *name == word);
            let unknown = || format!("there is no unit {}", text::shown(word.as_bytes()));
            self.part.unit = unit.ok_or_else(unknown)?.1;
        }
        // All prefixes that are declared for the namespace of this element.
        let own = tag.name().prefix();
        let own = own.as_ref().map_or("", |prefix| prefix.as_ref());
        let declared = tag.attributes().filter_map(|attribute| {
            let attribute = attribute.ok()?;
            let prefix = match attribute.key.as_ref() {
                "xmlns" => "",
                key => key.strip_prefix("xmlns:")?,
            };
            Some((prefix.to_owned(), attribute.value.to_string()))
        });
        let declared: BTreeMap<String, String> = declared.collect();
        let namespace = declared.get(own);
        let same = |(_, other): &(&String, &String)| Some(*other) == namespace;
        let same = declared.iter().filter(same).map(|(prefix, _)| prefix);
        self.core = same.cloned().chain([own.to_owned()]).collect();
        Ok(())
    }

    fn begin_object(&mut self, tag: &BytesStart<'_>) -> Result<(), String> {
        let mut object = Object::default();
        let (mut id, mut group, mut place) = (None, None, None);
        each(tag, |key, value| match key {
            "id" => id = whole(value),
            "name" => object.name = unescaped(value),
            "type" => object.is_support = matches!(value, "support" | "solidsupport"),
            "pid" => group = whole(value),
            "pindex" => place = whole(value),
            _ => {}
        })?;
        let id = id.ok_or("an object has no numeric id")?;
        object.property = group.map(|group| [group, place.unwrap_or(0)]);
        check_name(&object.name)?;
        self.spend(size_of::<Object>() + object.name.len())?;
        self.object = Some(id);
        match self.part.objects.insert(id, object) {
            None => Ok(()),
            Some(_) => Err(format!("there are two objects {id}")),
        }
    }

    /// Ends an object: checks its list of patch faces.
    fn end_object(&mut self) {
        let text = std::mem::take(&mut self.patches);
        self.in_mesh = false;
        if let Some(object) = self
            .object
            .take()
            .and_then(|id| self.part.objects.get_mut(&id))
        {
            match patch_ranges(&text, object.triangles.len()) {
                Some(ranges) => object.patches = ranges,
                None => self.part.unmatched_marks += 1,
            }
        }
    }

    fn begin_group(&mut self, tag: &BytesStart<'_>, group: Group) -> Result<(), String> {
        let mut id = None;
        each(tag, |key, value| {
            if key == "id" {
                id = whole(value);
            }
        })?;
        let id = id.ok_or("a group of properties has no numeric id")?;
        self.spend(size_of::<Group>())?;
        self.group = Some(id);
        self.part.groups.insert(id, group);
        Ok(())
    }

    fn open_object(&mut self) -> Option<&mut Object> {
        self.part.objects.get_mut(&self.object?)
    }

    fn open_group(&mut self) -> Option<&mut Group> {
        self.part.groups.get_mut(&self.group?)
    }

    fn vertex(&mut self, tag: &BytesStart<'_>) -> Result<(), String> {
        let mut point = [None; 3];
        let mut wrong = None;
        each(tag, |key, value| {
            let axis = ["x", "y", "z"].iter().position(|axis| *axis == key);
            if let Some(axis) = axis {
                point[axis] = text::number(value.trim().as_bytes());
                if point[axis].is_none_or(|x| !x.is_finite()) {
                    wrong = Some(format!(
                        "{} is not a coordinate",
                        text::shown(value.as_bytes())
                    ));
                }
            }
        })?;
        if let Some(wrong) = wrong {
            return Err(wrong);
        }
        let [Some(x), Some(y), Some(z)] = point else {
            return Err("a vertex lacks a coordinate".to_owned());
        };
        self.spend(size_of::<DVec3>())?;
        if let Some(object) = self.open_object() {
            object.positions.push(DVec3::new(x, y, z));
        }
        Ok(())
    }

    fn triangle(&mut self, tag: &BytesStart<'_>) -> Result<(), String> {
        let [mut corners, mut places] = [[None; 3]; 2];
        let mut group = NONE;
        let marks = &mut self.part.marks;
        each(tag, |key, value| match key {
            "v1" => corners[0] = whole(value),
            "v2" => corners[1] = whole(value),
            "v3" => corners[2] = whole(value),
            "p1" => places[0] = whole(value),
            "p2" => places[1] = whole(value),
            "p3" => places[2] = whole(value),
            "pid" => group = whole(value).unwrap_or(NONE),
            _ if marks.len() < MOST_MARKS && !marks.iter().any(|mark| mark == key) => {
                marks.push(text::shown(key.as_bytes()).trim_matches('\'').to_owned());
            }
            _ => {}
        })?;
        let [Some(a), Some(b), Some(c)] = corners else {
            return Err("a triangle lacks a corner".to_owned());
        };
        self.spend(size_of::<Triangle>())?;
        let Some(object) = self.open_object() else {
            return Ok(());
        };
        let first = places[0];
        let own = |k: usize| places[k].or(first);
        let (group, places) = match (group, first, object.property) {
            // With a group but no index a triangle has no property. With an index but no group it uses the object's
            // group.
            (NONE, None, Some([group, place])) => (group, [place; 3]),
            (NONE, Some(_), Some([group, _])) => (group, [0, 1, 2].map(|k| own(k).unwrap_or(0))),
            (NONE, ..) | (_, None, _) => (NONE, [0; 3]),
            (group, ..) => (group, [0, 1, 2].map(|k| own(k).unwrap_or(0))),
        };
        object.triangles.push(Triangle {
            corners: [a, b, c],
            group,
            places,
        });
        Ok(())
    }
}

/// Calls `take` with the local name and the value of each attribute of a tag.
fn each(tag: &BytesStart<'_>, mut take: impl FnMut(&str, &str)) -> Result<(), String> {
    for (number, attribute) in tag.attributes().enumerate() {
        if number >= MOST_ATTRIBUTES {
            return Err(format!("a tag has more than {MOST_ATTRIBUTES} attributes"));
        }
        let attribute = attribute.map_err(|error| format!("the XML is damaged ({error})"))?;
        take(attribute.key.local_name().as_ref(), &attribute.value);
    }
    Ok(())
}

/// A part name in the form used for comparison: lower case, slashes for backslashes, none in front.
pub(super) fn part_name(name: &str) -> String {
    let name = name.replace('\\', "/");
    name.trim_start_matches('/').to_ascii_lowercase()
}

/// Parses the object and transform of an item or component.
fn used(tag: &BytesStart<'_>) -> Result<Use, String> {
    let (mut object, mut part, mut matrix) = (None, None, None);
    each(tag, |key, value| match key {
        "objectid" => object = whole(value),
        "path" => part = Some(part_name(&unescaped(value))),
        "transform" => matrix = Some(value.to_owned()),
        _ => {}
    })?;
    let object = object.ok_or("an item or component names no object")?;
    let transform = match matrix {
        None => DAffine3::IDENTITY,
        Some(words) => transform(&words)
            .ok_or_else(|| format!("{} is not a transform", text::shown(words.as_bytes())))?,
    };
    Ok(Use {
        object,
        part,
        transform,
    })
}
