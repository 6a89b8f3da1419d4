//! The properties of the triangles of a 3MF mesh: colours, base materials, or marks of patches.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use quick_xml::escape::escape;

use super::super::Contents;
use super::model::NO_MATERIAL;
use isomend_core::mesh::attributes::{Attribute, LabelKind, Labels, NONE, PATCH_NAME, Role};

/// Colour (red, green, blue, opacity) of base materials without another colour, and of patches.
const GREY: [u8; 4] = [200, 200, 200, 255];
const ORANGE: [u8; 4] = [0xe6, 0x78, 0x14, 255];
/// The property of each triangle: colours if there are any, else materials, else orange for patches and grey for the
/// other faces.
pub(super) enum Properties<'a> {
    Colours {
        palette: Vec<[u8; 4]>,
        /// The index in the palette of each corner's colour.
        of_face: Vec<[u32; 3]>,
        /// Whether each face has a colour; grey stands for none.
        coloured: Vec<bool>,
        /// The attributes that the colours represent completely.
        held: Vec<&'a Attribute>,
    },
    Materials(&'a Labels, Vec<[u8; 4]>),
    Patches(Vec<bool>),
    Nothing,
}

impl<'a> Properties<'a> {
    pub(super) fn new(model: &Contents<'a>) -> Self {
        let all = model.attributes;
        if let Some(colours) = Self::colours(model) {
            return colours;
        }
        if let Some(materials) = Self::materials(model) {
            return materials;
        }
        let patches: Vec<bool> = (0..model.mesh.faces.len())
            .map(|f| all.is_patch(f))
            .collect();
        match patches.contains(&true) {
            true => Self::Patches(patches),
            false => Self::Nothing,
        }
    }

    /// The materials; none if there are no names.
    pub(super) fn materials(model: &Contents<'a>) -> Option<Self> {
        let all = model.attributes;
        let labels = all.labels_of(LabelKind::Material);
        let labels = labels.filter(|l| !l.names.is_empty())?;
        let look = |name: &String| {
            let look = all.materials.iter().find(|m| m.name == *name);
            let byte = |x: f32| (255.0 * x).round().clamp(0.0, 255.0) as u8;
            let patch = if name == PATCH_NAME { ORANGE } else { GREY };
            look.and_then(|m| Some((m, m.colour?)))
                .map_or(patch, |(m, [r, g, b])| {
                    [r, g, b, m.opacity.unwrap_or(1.0)].map(byte)
                })
        };
        let looks = labels.names.iter().map(look).collect();
        Some(Self::Materials(labels, looks))
    }

    /// Whether a face has a property of its own.
    pub(super) fn has(&self, f: usize) -> bool {
        match self {
            Self::Colours { coloured, .. } => coloured[f],
            Self::Materials(labels, _) => labels.of_face[f] != NONE,
            Self::Patches(patches) => patches[f],
            Self::Nothing => false,
        }
    }

    /// Corner colours. Faces of patches take their face colour first; otherwise the order is corner, vertex, face.
    pub(super) fn colours(model: &Contents<'a>) -> Option<Self> {
        let all = model.attributes;
        let is_colour = |a: &&Attribute| a.role == Role::Colour && (3..=4).contains(&a.components);
        let vertex = all.vertex.iter().find(is_colour);
        let face = all.face.iter().find(is_colour);
        let corner = all.corner.iter().find(|c| is_colour(&&c.pool));
        if vertex.is_none() && face.is_none() && corner.is_none() {
            return None;
        }
        let bytes = |a: &Attribute, value: &[f64]| {
            let unit = a.unit();
            let byte = |x: f64| (255.0 * x / unit).round().clamp(0.0, 255.0) as u8;
            let opacity = value.get(3).map_or(255, |x| byte(*x));
            [byte(value[0]), byte(value[1]), byte(value[2]), opacity]
        };
        let mut palette = Vec::new();
        let mut known: BTreeMap<[u8; 4], u32> = BTreeMap::new();
        let mut place = |colour: [u8; 4]| {
            *known.entry(colour).or_insert_with(|| {
                palette.push(colour);
                (palette.len() - 1) as u32
            })
        };
        let mut of_face = Vec::with_capacity(model.mesh.faces.len());
        let mut coloured = vec![false; model.mesh.faces.len()];
        let (mut uses_corner, mut uses_vertex, mut uses_face) = (false, false, face.is_some());
        for (f, vertices) in model.mesh.faces.iter().enumerate() {
            let own = face.and_then(|a| Some(bytes(a, a.get(f)?)));
            let first = own.filter(|_| all.is_patch(f));
            let mut colour = |k: usize| {
                coloured[f] |= own.is_some();
                if let Some(colour) = first {
                    return colour;
                }
                let v = vertices[k] as usize;
                let at_corner = corner.and_then(|c| Some(bytes(&c.pool, c.get(f, k)?)));
                let at_vertex = || vertex.and_then(|a| Some(bytes(a, a.get(v)?)));
                uses_corner |= at_corner.is_some();
                let found = at_corner.or_else(|| {
                    let found = at_vertex();
                    uses_vertex |= found.is_some();
                    found
                });
                // The face colour is lost where a corner or vertex colour replaces it.
                uses_face &= own.is_none() || found.is_none();
                coloured[f] |= found.is_some();
                found.or(own).unwrap_or(GREY)
            };
            of_face.push([0, 1, 2].map(|k| place(colour(k))));
        }
        let corner = corner.map(|c| &c.pool).filter(|_| uses_corner);
        let vertex = vertex.filter(|_| uses_vertex);
        let face = face.filter(|_| uses_face);
        Some(Self::Colours {
            palette,
            of_face,
            coloured,
            held: corner.into_iter().chain(vertex).chain(face).collect(),
        })
    }

    /// Whether the colours represent this attribute.
    pub(super) fn holds(&self, attribute: &Attribute) -> bool {
        let Self::Colours { held, .. } = self else {
            return false;
        };
        held.iter().any(|own| std::ptr::eq(*own, attribute))
    }

    /// The index of an object's default property. An object needs a default if any of its faces has a property.
    pub(super) fn usual(&self, faces: &[u32]) -> Option<u32> {
        match self {
            Self::Nothing => None,
            Self::Colours { .. } | Self::Patches(_) => Some(0),
            Self::Materials(labels, appearances) => {
                let mut own = faces.iter().map(|f| labels.of_face[*f as usize]);
                let first = own.clone().find(|label| *label != NONE)?;
                // The material for faces without one follows the others.
                Some(match own.any(|label| label == NONE) {
                    true => appearances.len() as u32,
                    false => first,
                })
            }
        }
    }

    /// Writes the group of properties, with the prefixes of the core and the material namespaces.
    pub(super) fn write(&self, out: &mut String, group: u32, [core, material]: [&str; 2]) {
        match self {
            Self::Nothing => {}
            Self::Colours { palette, .. } => {
                let _ = writeln!(out, "<{material}colorgroup id=\"{group}\">");
                for colour in palette {
                    let _ = writeln!(out, "<{material}color color=\"{}\"/>", hex(colour));
                }
                let _ = writeln!(out, "</{material}colorgroup>");
            }
            Self::Materials(labels, appearances) => {
                let _ = writeln!(out, "<{core}basematerials id=\"{group}\">");
                for (name, look) in labels.names.iter().zip(appearances) {
                    base(out, core, (name, look));
                }
                if labels.of_face.contains(&NONE) {
                    base(out, core, (NO_MATERIAL, &GREY));
                }
                let _ = writeln!(out, "</{core}basematerials>");
            }
            Self::Patches(_) => {
                let _ = writeln!(out, "<{core}basematerials id=\"{group}\">");
                base(out, core, ("surface", &GREY));
                base(out, core, (PATCH_NAME, &ORANGE));
                let _ = writeln!(out, "</{core}basematerials>");
            }
        }
    }

    /// Writes the property attributes of a triangle; with its second and third corner exchanged if it is mirrored.
    pub(super) fn of_face(&self, out: &mut String, f: usize, group: u32, is_mirrored: bool) {
        let _ = match self {
            Self::Colours { of_face, .. } => match of_face[f] {
                [a, b, c] if a == b && b == c => write!(out, " pid=\"{group}\" p1=\"{a}\""),
                [a, b, c] => {
                    let [b, c] = if is_mirrored { [c, b] } else { [b, c] };
                    write!(out, " pid=\"{group}\" p1=\"{a}\" p2=\"{b}\" p3=\"{c}\"")
                }
            },
            Self::Materials(labels, _) if labels.of_face[f] != NONE => {
                write!(out, " pid=\"{group}\" p1=\"{}\"", labels.of_face[f])
            }
            Self::Patches(patches) if patches[f] => write!(out, " pid=\"{group}\" p1=\"1\""),
            _ => Ok(()),
        };
    }
}

/// Writes a group with the material that stands for none: the default of objects of which only some triangles have properties.
pub(super) fn write_none(out: &mut String, group: u32, core: &str) {
    let _ = writeln!(out, "<{core}basematerials id=\"{group}\">");
    base(out, core, (NO_MATERIAL, &GREY));
    let _ = writeln!(out, "</{core}basematerials>");
}

/// Writes a base material.
fn base(out: &mut String, core: &str, (name, colour): (&str, &[u8; 4])) {
    let (name, colour) = (escape(name), hex(colour));
    let _ = writeln!(
        out,
        "<{core}base name=\"{name}\" displaycolor=\"{colour}\"/>"
    );
}

fn hex(colour: &[u8; 4]) -> String {
    let digits: String = colour.iter().map(|byte| format!("{byte:02X}")).collect();
    format!("#{digits}")
}
