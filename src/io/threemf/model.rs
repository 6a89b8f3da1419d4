//! The XML of a model in a 3MF package.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat3, DVec3};
use quick_xml::events::{BytesStart, Event};

use super::super::{Format, IoError, Location, text};
use super::fault;
use crate::mesh::Unit;
use crate::mesh::attributes::NONE;

/// The metadata of an object that lists the faces of patches.
pub(super) const PATCH_FACES: &str = "isomend:patch";

/// The words for units.
pub(super) const UNITS: [(&str, Unit); 6] = [
    ("micron", Unit::Micrometre),
    ("millimeter", Unit::Millimetre),
    ("centimeter", Unit::Centimetre),
    ("inch", Unit::Inch),
    ("foot", Unit::Foot),
    ("meter", Unit::Metre),
];

/// A model: its objects, and what of them is built.
pub(super) struct Part {
    pub(super) unit: Unit,
    pub(super) objects: BTreeMap<u32, Object>,
    pub(super) groups: BTreeMap<u32, Group>,
    pub(super) items: Vec<Use>,
}

impl Part {
    /// The names of other parts that its items and components name.
    pub(super) fn other_parts(&self) -> impl Iterator<Item = String> {
        let components = self.objects.values().flat_map(|o| &o.components);
        let uses = self.items.iter().chain(components);
        uses.filter_map(|u| u.part.clone())
    }
}

/// An object: a mesh, or other objects.
#[derive(Default)]
pub(super) struct Object {
    pub(super) name: String,
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: Vec<Triangle>,
    pub(super) components: Vec<Use>,
    /// Group and place of the property of triangles that name none.
    pub(super) property: Option<[u32; 2]>,
    /// Ranges of faces of patches, in words.
    pub(super) patches: String,
}

/// A triangle with its property: the group, `NONE` where it names none, and the place in it for each corner.
#[derive(Clone, Copy)]
pub(super) struct Triangle {
    pub(super) corners: [u32; 3],
    pub(super) group: u32,
    pub(super) places: [u32; 3],
}

/// A group of properties.
pub(super) enum Group {
    /// Red, green, blue, opacity.
    Colours(Vec<[u8; 4]>),
    /// Names and colours of base materials.
    Materials(Vec<(String, [u8; 4])>),
}

/// An object put somewhere.
#[derive(Clone)]
pub(super) struct Use {
    pub(super) object: u32,
    /// The part that it is in, where that is another one.
    pub(super) part: Option<String>,
    pub(super) transform: DAffine3,
}

/// Reads a model.
pub(super) fn parse(markup: &str) -> Result<Part, IoError> {
    let mut reader = quick_xml::Reader::from_str(markup);
    let mut open = Open {
        part: Part {
            unit: Unit::Millimetre,
            objects: BTreeMap::new(),
            groups: BTreeMap::new(),
            items: Vec::new(),
        },
        object: 0,
        group: 0,
        is_model: false,
        reads_patches: false,
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
            Event::Start(tag) => open.start(&tag).map_err(damaged)?,
            Event::Empty(tag) => {
                open.start(&tag).map_err(damaged)?;
                open.reads_patches = false;
            }
            Event::Text(content) if open.reads_patches => {
                let object = open.part.objects.entry(open.object).or_default();
                object.patches += &content;
            }
            Event::End(_) => open.reads_patches = false,
            _ => {}
        }
    }
    match open.is_model {
        true => Ok(open.part),
        false => Err(fault("there is no model element in it")),
    }
}

/// A model while it is read.
struct Open {
    part: Part,
    /// The object and the group of properties that are open.
    object: u32,
    group: u32,
    is_model: bool,
    reads_patches: bool,
}

impl Open {
    fn start(&mut self, tag: &BytesStart<'_>) -> Result<(), String> {
        match tag.local_name().as_ref() {
            "vertex" => self.vertex(tag),
            "triangle" => self.triangle(tag),
            "model" => {
                self.is_model = true;
                self.model(tag)
            }
            "object" => self.begin_object(tag),
            "component" => {
                let used = used(tag)?;
                self.open_object()?.components.push(used);
                Ok(())
            }
            "item" => {
                self.part.items.push(used(tag)?);
                Ok(())
            }
            name @ ("basematerials" | "colorgroup") => self.begin_group(tag, name),
            "base" => {
                let [mut name, mut colour] = [String::new(), String::new()];
                each(tag, |key, value| match key {
                    "name" => name = unescaped(value),
                    "displaycolor" => colour = value.to_owned(),
                    _ => {}
                })?;
                if let Some(Group::Materials(all)) = self.part.groups.get_mut(&self.group) {
                    all.push((name, colour_of(&colour).unwrap_or([200, 200, 200, 255])));
                }
                Ok(())
            }
            "color" => {
                let mut colour = String::new();
                each(tag, |key, value| {
                    if key == "color" {
                        colour = value.to_owned();
                    }
                })?;
                let colour = colour_of(&colour)
                    .ok_or_else(|| format!("{} is no colour", text::shown(colour.as_bytes())))?;
                if let Some(Group::Colours(all)) = self.part.groups.get_mut(&self.group) {
                    all.push(colour);
                }
                Ok(())
            }
            "metadata" => {
                let mut name = String::new();
                each(tag, |key, value| {
                    if key == "name" {
                        name = value.to_owned();
                    }
                })?;
                self.reads_patches = name == PATCH_FACES && self.object != 0;
                Ok(())
            }
            _ => Ok(()),
        }
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
        Ok(())
    }

    fn begin_object(&mut self, tag: &BytesStart<'_>) -> Result<(), String> {
        let mut object = Object::default();
        let (mut id, mut group, mut place) = (None, None, None);
        each(tag, |key, value| match key {
            "id" => id = whole(value),
            "name" => object.name = unescaped(value),
            "pid" => group = whole(value),
            "pindex" => place = whole(value),
            _ => {}
        })?;
        let id = id.ok_or("an object has no number")?;
        object.property = group.map(|group| [group, place.unwrap_or(0)]);
        self.object = id;
        match self.part.objects.insert(id, object) {
            None => Ok(()),
            Some(_) => Err(format!("there are two objects {id}")),
        }
    }

    fn begin_group(&mut self, tag: &BytesStart<'_>, name: &str) -> Result<(), String> {
        let mut id = None;
        each(tag, |key, value| {
            if key == "id" {
                id = whole(value);
            }
        })?;
        self.group = id.ok_or("a group of properties has no number")?;
        let group = match name {
            "colorgroup" => Group::Colours(Vec::new()),
            _ => Group::Materials(Vec::new()),
        };
        self.part.groups.insert(self.group, group);
        Ok(())
    }

    fn open_object(&mut self) -> Result<&mut Object, String> {
        let object = self.part.objects.get_mut(&self.object);
        object.ok_or_else(|| "there is a mesh outside of an object".to_owned())
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
                        "{} is no coordinate",
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
        self.open_object()?.positions.push(DVec3::new(x, y, z));
        Ok(())
    }

    fn triangle(&mut self, tag: &BytesStart<'_>) -> Result<(), String> {
        let [mut corners, mut places] = [[None; 3]; 2];
        let mut group = NONE;
        each(tag, |key, value| match key {
            "v1" => corners[0] = whole(value),
            "v2" => corners[1] = whole(value),
            "v3" => corners[2] = whole(value),
            "p1" => places[0] = whole(value),
            "p2" => places[1] = whole(value),
            "p3" => places[2] = whole(value),
            "pid" => group = whole(value).unwrap_or(NONE),
            _ => {}
        })?;
        let [Some(a), Some(b), Some(c)] = corners else {
            return Err("a triangle lacks a corner".to_owned());
        };
        let object = self.open_object()?;
        let first = places[0];
        let own = |k: usize| places[k].or(first);
        let (group, places) = match (group, first, object.property) {
            // A property without a place is none; without a group it is in that of the object.
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

/// Calls a function with the local names and the values of a tag's attributes.
fn each(tag: &BytesStart<'_>, mut take: impl FnMut(&str, &str)) -> Result<(), String> {
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|error| format!("the XML is damaged ({error})"))?;
        take(attribute.key.local_name().as_ref(), &attribute.value);
    }
    Ok(())
}

/// A name of a part in the form in which names are compared.
pub(super) fn part_name(name: &str) -> String {
    name.trim_start_matches('/').to_ascii_lowercase()
}

fn whole(value: &str) -> Option<u32> {
    value.trim().parse().ok()
}

fn unescaped(value: &str) -> String {
    match quick_xml::escape::unescape(value) {
        Ok(text) => text.into_owned(),
        Err(_) => value.to_owned(),
    }
}

/// A colour such as `#RRGGBB` or `#RRGGBBAA`.
fn colour_of(text: &str) -> Option<[u8; 4]> {
    let digits = text.trim().strip_prefix('#')?;
    let is_hex = digits.bytes().all(|b| b.is_ascii_hexdigit());
    let number = u32::from_str_radix(digits, 16).ok().filter(|_| is_hex)?;
    match digits.len() {
        6 => Some(((number << 8) | 255).to_be_bytes()),
        8 => Some(number.to_be_bytes()),
        _ => None,
    }
}

/// The object of an item or a component, and where it is put.
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
            .ok_or_else(|| format!("{} is no transform", text::shown(words.as_bytes())))?,
    };
    Ok(Use {
        object,
        part,
        transform,
    })
}

/// A transform of 12 numbers, row after row, by which row vectors are multiplied from the left; the last row is the translation.
fn transform(words: &str) -> Option<DAffine3> {
    let numbers: Option<Vec<f64>> = (text::Tokens::new(words.as_bytes(), 0))
        .map(|word| text::number(word).filter(|x| x.is_finite()))
        .collect();
    let n: [f64; 12] = numbers?.try_into().ok()?;
    let row = |i: usize| DVec3::new(n[3 * i], n[3 * i + 1], n[3 * i + 2]);
    Some(DAffine3::from_mat3_translation(
        DMat3::from_cols(row(0), row(1), row(2)),
        row(3),
    ))
}
