//! Groups PLY properties into attributes, such as `nx`, `ny`, `nz` into a normal.

use std::collections::HashMap;

use super::super::mesh_builder::CutFrom;
use super::header::{Element, Property};
use isomend_core::mesh::attributes::{Attribute, CornerAttribute, NONE, Role, Scalar};

/// Properties that together form one attribute. Names are without the number of a texture set.
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

/// Where the numbers of a property go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// Skipped. (The list of corners is also marked so, because it is read separately.)
    Nothing,
    /// The coordinate of an axis.
    Axis(usize),
    /// A component of an attribute.
    Value { attribute: usize, component: usize },
    /// The list of texture coordinates of the face's corners.
    CornerUv,
}

/// The attributes of an element, and where each of its properties goes.
pub(super) struct Columns {
    pub(super) uses: Vec<Use>,
    pub(super) attributes: Vec<Attribute>,
}

impl Columns {
    /// Groups the properties of an element. Properties of an axis are read by the caller.
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

    /// Reserves memory for `count` items.
    pub(super) fn reserve(&mut self, count: usize) {
        for attribute in &mut self.attributes {
            attribute.values.reserve(count * attribute.components);
        }
    }

    /// Adds an item with zeros, into which [`Columns::set`] writes.
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

/// The indices of the properties of a name, texture set and type, in descending order.
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

/// The properties, in order of components, of the attribute that property `at` belongs to.
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

/// A name without its final digits, and the number of the texture set that they give.
fn without_set(name: &[u8]) -> (&[u8], u32) {
    let digits = name.iter().rev().take_while(|b| b.is_ascii_digit()).count();
    let (stem, digits) = name.split_at(name.len() - digits);
    let number = std::str::from_utf8(digits)
        .ok()
        .and_then(|d| d.parse().ok());
    (stem, number.unwrap_or(0))
}

/// The attributes of faces, and the texture coordinates of their corners.
#[derive(Default)]
pub(super) struct FaceValues {
    pub(super) attributes: Vec<Attribute>,
    /// The pool, and for each corner of each face its index in the pool.
    pub(super) uv: Option<(Attribute, Vec<u32>)>,
}

impl FaceValues {
    pub(super) fn is_empty(&self) -> bool {
        self.attributes.is_empty() && self.uv.is_none()
    }

    /// The attributes of the triangles that the faces were cut into.
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
