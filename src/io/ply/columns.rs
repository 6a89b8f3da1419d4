//! PLY properties as attributes: which of them belong together, and where their numbers go.

use std::collections::HashMap;

use super::super::mesh_builder::CutFrom;
use super::header::{Element, Property};
use crate::mesh::attributes::{Attribute, CornerAttribute, NONE, Role, Scalar};

/// Properties that make up one attribute, by their names without the number of a texture set.
const GROUPS: [(&[&str], &str, Role); 8] = [
    (&["nx", "ny", "nz"], "normal", Role::Normal),
    (&["red", "green", "blue", "alpha"], "colour", Role::Colour),
    (&["red", "green", "blue"], "colour", Role::Colour),
    (&["r", "g", "b"], "colour", Role::Colour),
    (
        &["diffuse_red", "diffuse_green", "diffuse_blue"],
        "diffuse",
        Role::Colour,
    ),
    (&["texture_u", "texture_v"], "texture", Role::Uv(0)),
    (&["s", "t"], "texture", Role::Uv(0)),
    (&["u", "v"], "texture", Role::Uv(0)),
];

/// What becomes of the numbers of a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// Coordinates and lists of corners are read by themselves; other lists are passed over.
    Nothing,
    /// The coordinate of an axis.
    Axis(usize),
    /// A component of an attribute.
    Value { attribute: usize, component: usize },
    /// The texture coordinates of a face's corners.
    CornerUv,
}

/// The columns of an element.
pub(super) struct Columns {
    pub(super) uses: Vec<Use>,
    pub(super) attributes: Vec<Attribute>,
}

impl Columns {
    /// Sorts the properties of an element; those of an axis are left to the caller.
    pub(super) fn new(element: &Element, axes: &[Option<usize>]) -> Self {
        let properties = &element.properties;
        let mut columns = Columns {
            uses: axes
                .iter()
                .map(|axis| axis.map_or(Use::Nothing, Use::Axis))
                .collect(),
            attributes: Vec::new(),
        };
        let mut free: Vec<bool> = properties
            .iter()
            .zip(axes)
            .map(|(p, axis)| p.length.is_none() && axis.is_none())
            .collect();
        let mut by_name = places(properties, &free);
        for at in 0..properties.len() {
            if !free[at] {
                continue;
            }
            let (places, role) = group(properties, &free, &mut by_name, at);
            let first = &properties[places[0]];
            let name = match role {
                (Role::Other, _) => String::from_utf8_lossy(&first.name).into_owned(),
                (_, name) => name.to_owned(),
            };
            let mut attribute = Attribute::new(&name, role.0, first.scalar, places.len());
            for (component, place) in places.into_iter().enumerate() {
                let field = String::from_utf8_lossy(&properties[place].name).into_owned();
                attribute.fields.push(field);
                free[place] = false;
                columns.uses[place] = Use::Value {
                    attribute: columns.attributes.len(),
                    component,
                };
            }
            columns.attributes.push(attribute);
        }
        columns
    }

    /// Makes room for so many values.
    pub(super) fn reserve(&mut self, count: usize) {
        for attribute in &mut self.attributes {
            attribute.values.reserve(count * attribute.components);
        }
    }

    /// Makes room for the values of one more item, into which [`Columns::set`] writes.
    pub(super) fn next_row(&mut self) {
        for attribute in &mut self.attributes {
            let longer = attribute.values.len() + attribute.components;
            attribute.values.resize(longer, 0.0);
        }
    }

    #[inline]
    pub(super) fn set(&mut self, attribute: usize, component: usize, value: f64) {
        let attribute = &mut self.attributes[attribute];
        let row = attribute.values.len() - attribute.components;
        attribute.values[row + component] = value;
    }
}

/// Where the properties of a name, texture set and type are; the first of them is the last of the list.
type Places<'a> = HashMap<(&'a [u8], u32, Scalar), Vec<usize>>;

fn places<'a>(properties: &'a [Property], free: &[bool]) -> Places<'a> {
    let mut places = Places::new();
    for (at, property) in properties
        .iter()
        .enumerate()
        .rev()
        .filter(|(at, _)| free[*at])
    {
        let (name, set) = without_set(&property.name);
        places
            .entry((name, set, property.scalar))
            .or_default()
            .push(at);
    }
    places
}

/// The properties, in order of component, of the attribute that a property belongs to.
fn group(
    properties: &[Property],
    free: &[bool],
    places: &mut Places<'_>,
    at: usize,
) -> (Vec<usize>, (Role, &'static str)) {
    let (name, set) = without_set(&properties[at].name);
    for (names, title, role) in GROUPS {
        if !names.iter().any(|n| n.as_bytes() == name) || (set > 0 && role != Role::Uv(0)) {
            continue;
        }
        let mut find = |wanted: &&'static str| {
            let key = (wanted.as_bytes(), set, properties[at].scalar);
            let list = places.get_mut(&key)?;
            while list.last().is_some_and(|place| !free[*place]) {
                list.pop();
            }
            list.last().copied()
        };
        let found: Option<Vec<usize>> = names.iter().map(&mut find).collect();
        if let Some(found) = found {
            let role = if role == Role::Uv(0) {
                Role::Uv(set)
            } else {
                role
            };
            return (found, (role, title));
        }
    }
    (vec![at], (Role::Other, ""))
}

/// A name without the digits at its end, and the number of the texture set that these stand for.
fn without_set(name: &[u8]) -> (&[u8], u32) {
    let digits = name.iter().rev().take_while(|b| b.is_ascii_digit()).count();
    let (stem, digits) = name.split_at(name.len() - digits);
    let number = std::str::from_utf8(digits)
        .ok()
        .and_then(|d| d.parse().ok());
    (stem, number.unwrap_or(0))
}

/// What was read of the faces: their values, and texture coordinates of their corners.
#[derive(Default)]
pub(super) struct FaceValues {
    pub(super) attributes: Vec<Attribute>,
    /// The pool, and for each corner of each face its place in it.
    pub(super) uv: Option<(Attribute, Vec<u32>)>,
}

impl FaceValues {
    /// Whether there is nothing.
    pub(super) fn is_empty(&self) -> bool {
        self.attributes.is_empty() && self.uv.is_none()
    }

    /// The values of the triangles that the faces were cut into.
    pub(super) fn cut(self, cut: &CutFrom) -> (Vec<Attribute>, Option<CornerAttribute>) {
        let of_triangles = |attribute: Attribute| {
            let mut out = Attribute {
                values: Vec::with_capacity(cut.face.len() * attribute.components),
                ..attribute.clone()
            };
            for face in &cut.face {
                let start = *face as usize * attribute.components;
                out.values
                    .extend_from_slice(&attribute.values[start..start + attribute.components]);
            }
            out
        };
        let uv = self.uv.map(|(pool, places)| CornerAttribute {
            pool,
            corners: cut
                .corners
                .iter()
                .map(|face| face.map(|c| places.get(c as usize).copied().unwrap_or(NONE)))
                .collect(),
        });
        (self.attributes.into_iter().map(of_triangles).collect(), uv)
    }
}
