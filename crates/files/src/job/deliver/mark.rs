//! Marks patches in the written file by a colour or by hatching, so that the new faces can be seen.

use std::str::FromStr;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::components::Component;
use super::mark_surface;
use crate::io::{Format, GltfDocument};
use isomend_core::mesh::attributes::{Attribute, Role, Scalar};
use isomend_core::mesh::{Mesh, Model, area_vector};
use isomend_core::tuning::{Tunable, tunable};

/// Mean edge lengths of the patch. Lower bound of the stripe width on hatched patches: vertex colours cannot show finer
/// stripes.
const STRIPE_EDGES: Tunable<f64> = tunable("deliver.stripe_edges", 2.5);

/// Number of stripes across a patch, at most.
const STRIPES: Tunable<f64> = tunable("deliver.stripes", 24.0);

/// The colour of hatches.
const ORANGE: [u8; 3] = [0xe6, 0x78, 0x14];

/// How patches are marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// In one colour: red, green, blue.
    Colour([u8; 3]),
    /// Orange stripes over the colour that was continued from the surroundings; on steep patches the stripes run along z.
    Hatch,
}

impl FromStr for Mark {
    type Err = String;

    /// Takes `hatch` or `colour=RRGGBB`.
    fn from_str(text: &str) -> Result<Self, String> {
        if text == "hatch" {
            return Ok(Self::Hatch);
        }
        let wrong =
            || format!("'{text}' is not a mark; use hatch, or a colour such as colour=ff8000");
        let colour = text
            .strip_prefix("colour=")
            .or_else(|| text.strip_prefix("color="));
        let digits = colour.ok_or_else(wrong)?;
        let is_hex = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
        let number = u32::from_str_radix(digits, 16).ok().filter(|_| is_hex);
        let [_, r, g, b] = number.ok_or_else(wrong)?.to_be_bytes();
        Ok(Self::Colour([r, g, b]))
    }
}

impl Mark {
    /// Colours the patches of a mesh whose first `kept` faces are the input's. Returns remarks.
    ///
    /// New vertices get the colour; vertices that faces of the input use keep their colours. If the format has face colours, the new
    /// faces get the colour too, so that the edge of a patch is sharp.
    pub(in crate::job) fn apply(
        self,
        model: &mut Model,
        kept: usize,
        components: &[Component],
        (format, document): (Format, Option<&GltfDocument>),
    ) -> Vec<String> {
        let Model {
            mesh, attributes, ..
        } = model;
        // Vertices that no face of the input uses.
        let mut is_own = vec![true; mesh.positions.len()];
        let old = mesh.faces[..kept].iter().flatten();
        old.for_each(|v| is_own[*v as usize] = false);
        let has_uv = |a: &Attribute| matches!(a.role, Role::Uv(_));
        let textured = attributes.vertex.iter().any(has_uv)
            || attributes.corner.iter().any(|c| has_uv(&c.pool));
        // Renderers multiply textures by the colour: white leaves a texture unchanged.
        let plain = if textured { [255.0; 3] } else { [200.0; 3] };
        // Take the colours of corners, vertices and faces out of the attributes, or make new ones.
        let on_faces = has_face_colours(format);
        let mut of_corners = mark_surface::corner_colours(attributes, mesh, format);
        let mut vertex = colours(&mut attributes.vertex, mesh.positions.len(), plain);
        let has_own = attributes.face.iter().any(|a| a.role == Role::Colour);
        let mut face = on_faces.then(|| colours(&mut attributes.face, mesh.faces.len(), plain));
        if let Some(face) = face.as_mut().filter(|_| !has_own) {
            mean_of_corners(face, &vertex, mesh);
        }
        // Colour the patches; `hidden` counts faces that keep the input's colours at all corners.
        let mut hidden = 0;
        let stripes: Vec<Stripes> = components.iter().map(|c| Stripes::new(mesh, c)).collect();
        let colour_of = |component: usize, p: DVec3| match self {
            Self::Colour(colour) => Some(colour),
            Self::Hatch => stripes[component].is_dark(p).then_some(ORANGE),
        };
        if let Some(of_corners) = &mut of_corners {
            mark_surface::paint_corners(of_corners, components, mesh, &colour_of);
        }
        for (c, component) in components.iter().enumerate() {
            let colour_at = |p: DVec3| colour_of(c, p);
            for &f in &component.faces {
                let corners = mesh.faces[f as usize];
                for v in corners.into_iter().filter(|v| is_own[*v as usize]) {
                    let colour = colour_at(mesh.positions[v as usize]);
                    paint(&mut vertex, v as usize, colour);
                }
                let centre = mesh.corners(f).into_iter().sum::<DVec3>() / 3.0;
                match &mut face {
                    Some(face) => paint(face, f as usize, colour_at(centre)),
                    None if corners.iter().all(|v| !is_own[*v as usize]) => hidden += 1,
                    None => {}
                }
            }
        }
        attributes.vertex.push(vertex);
        attributes.face.extend(face);
        attributes.corner.extend(of_corners);
        let through = mark_surface::material_note(model, kept, format, document);
        let note = format!(
            "new faces that could not be marked: {hidden} ({format} stores colours at vertices only, and all vertices of these faces \
             belong to the input)"
        );
        let hidden = (hidden > 0).then_some(note);
        hidden.into_iter().chain(through).collect()
    }
}

/// Whether files of a format hold colours, of vertices at least.
pub(in crate::job) fn has_colours(format: Format) -> bool {
    format != Format::Stl
}

/// Whether files of a format hold colours of faces.
pub(super) fn has_face_colours(format: Format) -> bool {
    matches!(
        format,
        Format::Ply
            | Format::Vtk
            | Format::Vtp
            | Format::Off
            | Format::ThreeMf
            | Format::Usda
            | Format::Usdz
    )
}

/// Takes the colours out of a list of attributes, or makes new ones. Items without a colour get `plain`, in 0..255.
fn colours(all: &mut Vec<Attribute>, count: usize, plain: [f64; 3]) -> Attribute {
    let is_colour = |a: &Attribute| a.role == Role::Colour && (3..=4).contains(&a.components);
    let mut colours = match all.iter().position(is_colour) {
        Some(place) => all.remove(place),
        None => Attribute::new("colour", Role::Colour, Scalar::U8, 3),
    };
    colours.pad(count);
    let missing = std::mem::take(&mut colours.missing);
    let (unit, components) = (colours.unit(), colours.components);
    for (item, _) in missing.iter().enumerate().filter(|(_, gone)| **gone) {
        let values = &mut colours.values[item * components..(item + 1) * components];
        for (k, value) in values.iter_mut().enumerate() {
            *value = unit * plain.get(k).map_or(1.0, |x| x / 255.0);
        }
    }
    if missing.iter().any(|gone| *gone) && !colours.scalar.is_float() {
        let scalar = colours.scalar;
        let all = colours.values.iter_mut();
        all.for_each(|value| *value = scalar.nearest(*value));
    }
    colours
}

/// Gives each face the mean colour of its corners.
fn mean_of_corners(face: &mut Attribute, vertex: &Attribute, mesh: &Mesh) {
    let (unit, part) = (face.unit(), 1.0 / (3.0 * vertex.unit()));
    let count = vertex.components;
    for (f, corners) in mesh.faces.iter().enumerate() {
        for k in 0..face.components {
            let sum: f64 = (corners.iter())
                .map(|v| vertex.values[*v as usize * count + k])
                .sum();
            face.values[3 * f + k] = face.scalar.nearest(unit * part * sum);
        }
    }
}

/// Gives an item an opaque colour; `None` leaves its colour as it is.
fn paint(colours: &mut Attribute, item: usize, colour: Option<[u8; 3]>) {
    let Some(colour) = colour else {
        return;
    };
    let (unit, scalar, components) = (colours.unit(), colours.scalar, colours.components);
    for k in 0..components {
        let part = colour.get(k).map_or(1.0, |x| f64::from(*x) / 255.0);
        colours.values[item * components + k] = scalar.nearest(unit * part);
    }
}

/// Parallel stripes on a component.
struct Stripes {
    /// Unit vector across the stripes.
    across: DVec3,
    /// Width of a stripe, in units of the mesh.
    width: f64,
}

impl Stripes {
    /// Stripes upright along z, or along y on a component that faces up or down. A stripe is at least `stripe_edges` mean edges wide, and
    /// there are at most about `stripes` of them.
    fn new(mesh: &Mesh, component: &Component) -> Self {
        let faces = || component.faces.iter().map(|f| mesh.corners(*f));
        let normal: DVec3 = faces().map(area_vector).sum();
        let normal = normal.normalize_or(DVec3::Y);
        let up = match normal.z.abs() > 0.9 {
            true => DVec3::Y,
            false => DVec3::Z,
        };
        let across = normal.cross(up).normalize_or(DVec3::X);
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        let (mut edges, mut count) = (0.0, 0.0);
        for corners in faces() {
            for k in 0..3 {
                let at = corners[k].dot(across);
                ends = [ends[0].min(at), ends[1].max(at)];
                edges += corners[k].distance(corners[(k + 1) % 3]);
                count += 1.0;
            }
        }
        let fine: f64 = STRIPE_EDGES.get() * edges / f64::max(count, 1.0);
        Self {
            across,
            width: fine
                .max((ends[1] - ends[0]) / STRIPES.get())
                .max(f64::MIN_POSITIVE),
        }
    }

    fn is_dark(&self, p: DVec3) -> bool {
        (p.dot(self.across) / self.width).floor().rem_euclid(2.0) == 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_read_from_words() {
        assert_eq!("hatch".parse(), Ok(Mark::Hatch));
        let colour = Mark::Colour([255, 128, 0]);
        assert_eq!("colour=ff8000".parse(), Ok(colour));
        assert_eq!("color=FF8000".parse(), Ok(colour));
        for wrong in ["", "colour=", "colour=ff80", "colour=+f8000", "red"] {
            assert!(wrong.parse::<Mark>().is_err(), "{wrong}");
        }
    }
}
