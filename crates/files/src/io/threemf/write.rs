//! Writes a mesh as a 3MF package, with objects, colours or materials, and patch marks.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use quick_xml::escape::escape;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::super::{Contents, Format, IoError, Written, lost};
use super::model::{NO_MATERIAL, PATCH_FACES, UNITS};
use isomend_core::mesh::Unit;
use isomend_core::mesh::attributes::{Attribute, LabelKind, Labels, NONE, PATCH_NAME, Role};

const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
const MATERIAL: &str = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02";
const CONTENT_TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>
"#;
const RELATIONSHIPS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
"#;
/// Colour (red, green, blue, opacity) of base materials without another colour, and of patches.
const GREY: [u8; 4] = [200, 200, 200, 255];
const ORANGE: [u8; 4] = [0xe6, 0x78, 0x14, 255];
/// The id of the group of properties. The ids of objects follow.
const GROUP: u32 = 1;

/// Writes a package with one object per object label.
pub(in super::super) fn write(model: &Contents<'_>) -> Result<Written, IoError> {
    let unit = model.attributes.unit;
    let properties = Properties::new(model);
    let text = markup(model, unit.unwrap_or(Unit::Millimetre), &properties);
    let bytes = packed(&text).map_err(|error| IoError::NotWritable {
        format: Format::ThreeMf,
        what: error.to_string(),
        advice: "write PLY instead",
    })?;
    let mut notes: Vec<String> = Vec::new();
    if unit.is_none() {
        notes.push(
            "the unit of the coordinates is not known, so millimetres are written".to_owned(),
        );
    }
    let holds_label = |kind: LabelKind| match kind {
        LabelKind::Object | LabelKind::Part => true,
        // A face has only one property: if there are colours, materials are left out.
        LabelKind::Material => !matches!(properties, Properties::Colours { .. }),
        _ => false,
    };
    let listed = model
        .attributes
        .listed_where(|a| !properties.holds(a), |k| !holds_label(k));
    notes.extend(lost::note(&listed, Format::ThreeMf));
    Ok(Written { bytes, notes })
}

fn packed(model: &str) -> Result<Vec<u8>, zip::result::ZipError> {
    let mut package = ZipWriter::new(Cursor::new(Vec::new()));
    // A constant time stamp, so that the same mesh gives the same bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        // Parts of 4 GB or more need ZIP64.
        .large_file(model.len() >= u32::MAX as usize);
    for (name, text) in [
        ("[Content_Types].xml", CONTENT_TYPES),
        ("_rels/.rels", RELATIONSHIPS),
        ("3D/3dmodel.model", model),
    ] {
        package.start_file(name, options)?;
        package.write_all(text.as_bytes())?;
    }
    Ok(package.finish()?.into_inner())
}

fn markup(model: &Contents<'_>, unit: Unit, properties: &Properties) -> String {
    let mesh = model.mesh;
    let word = UNITS
        .iter()
        .find(|(_, u)| *u == unit)
        .map_or("millimeter", |(word, _)| word);
    let mut out = String::with_capacity(mesh.positions.len() * 60 + mesh.faces.len() * 50);
    // Writing to a string does not fail.
    let _ = writeln!(
        out,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"{word}\" xml:lang=\"en-US\" xmlns=\"{CORE}\" xmlns:m=\"{MATERIAL}\" \
         xmlns:isomend=\"urn:isomend\">\n<metadata name=\"Application\">isomend</metadata>\n<resources>"
    );
    properties.write(&mut out);
    let objects = objects(model);
    let is_only = objects.len() == 1 && objects[0].1.len() == 1;
    let mut number_of = vec![NONE; mesh.positions.len()];
    let (mut number, mut items) = (GROUP, Vec::new());
    for (name, parts) in &objects {
        let first = number + 1;
        for (part, faces) in parts {
            number += 1;
            // A mesh that is the whole object has the object's name.
            let own = if parts.len() == 1 { name } else { part };
            let scratch = (is_only, &mut number_of[..]);
            object(&mut out, model, properties, (number, own), faces, scratch);
        }
        if parts.len() > 1 {
            let components = first..=number;
            number += 1;
            assembly(&mut out, (number, name), components);
        }
        items.push(number);
    }
    out.push_str("</resources>\n<build>\n");
    for number in items {
        let _ = writeln!(out, "<item objectid=\"{number}\"/>");
    }
    out.push_str("</build>\n</model>\n");
    out
}

/// Writes an object that consists of other objects.
fn assembly(
    out: &mut String,
    (number, name): (u32, &str),
    components: std::ops::RangeInclusive<u32>,
) {
    let _ = write!(out, "<object id=\"{number}\" type=\"model\"");
    if !name.is_empty() {
        let _ = write!(out, " name=\"{}\"", escape(name));
    }
    out.push_str(">\n<components>\n");
    for component in components {
        let _ = writeln!(out, "<component objectid=\"{component}\"/>");
    }
    out.push_str("</components>\n</object>\n");
}

/// A name and the faces that have it.
type Named<'a, F> = (&'a str, Vec<F>);

/// The objects with their parts: names and faces, in the order of their labels. This is the order of the input, also where an object's
/// faces were replaced and come last in the mesh.
fn objects<'a>(model: &Contents<'a>) -> Vec<Named<'a, Named<'a, u32>>> {
    let parts = model.attributes.labels_of(LabelKind::Part);
    let objects = labelled(model, LabelKind::Object, 0..model.mesh.faces.len() as u32);
    let with_parts = |(name, faces): Named<'a, u32>| match parts {
        None => (name, vec![("", faces)]),
        Some(_) => (name, labelled(model, LabelKind::Part, faces.into_iter())),
    };
    objects.into_iter().map(with_parts).collect()
}

/// Faces by their label of a kind, in the order of the labels; those without one come last.
fn labelled<'a>(
    model: &Contents<'a>,
    kind: LabelKind,
    faces: impl Iterator<Item = u32>,
) -> Vec<Named<'a, u32>> {
    let labels = model.attributes.labels_of(kind);
    let mut all: BTreeMap<u32, Named<'a, u32>> = BTreeMap::new();
    for f in faces {
        let label = labels.map_or(NONE, |l| l.of_face[f as usize]);
        let name = || labels.and_then(|l| l.get(f as usize)).unwrap_or_default();
        let own = all.entry(label).or_insert_with(|| (name(), Vec::new()));
        own.1.push(f);
    }
    all.into_values().collect()
}

/// Writes an object. `number_of` is scratch space: `NONE` for each vertex before and after, within the function the
/// index of each vertex in this object.
fn object(
    out: &mut String,
    model: &Contents<'_>,
    properties: &Properties,
    (number, name): (u32, &str),
    faces: &[u32],
    (is_only, number_of): (bool, &mut [u32]),
) {
    let mesh = model.mesh;
    let _ = write!(out, "<object id=\"{number}\" type=\"model\"");
    if !name.is_empty() {
        let _ = write!(out, " name=\"{}\"", escape(name));
    }
    if let Some(place) = properties.usual(faces) {
        let _ = write!(out, " pid=\"{GROUP}\" pindex=\"{place}\"");
    }
    out.push_str(">\n");
    let patches = ranges(faces.iter().map(|f| model.attributes.is_patch(*f as usize)));
    if !patches.is_empty() {
        let _ = writeln!(
            out,
            "<metadatagroup><metadata name=\"{PATCH_FACES}\" type=\"xs:string\" preserve=\"1\">{patches}</metadata></metadatagroup>"
        );
    }
    // A single object also keeps the vertices that no face uses.
    let mut used: Vec<u32> = match is_only {
        true => (0..mesh.positions.len() as u32).collect(),
        false => faces.iter().flat_map(|f| mesh.faces[*f as usize]).collect(),
    };
    used.sort_unstable();
    used.dedup();
    out.push_str("<mesh>\n<vertices>\n");
    for (new, &v) in (0..).zip(&used) {
        number_of[v as usize] = new;
        let p = mesh.positions[v as usize];
        let _ = writeln!(out, "<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", p.x, p.y, p.z);
    }
    out.push_str("</vertices>\n<triangles>\n");
    for &f in faces {
        let [a, b, c] = mesh.faces[f as usize].map(|v| number_of[v as usize]);
        let _ = write!(out, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"");
        properties.of_face(out, f as usize);
        out.push_str("/>\n");
    }
    used.iter().for_each(|v| number_of[*v as usize] = NONE);
    out.push_str("</triangles>\n</mesh>\n</object>\n");
}

/// The indices of true values as ranges, for example `3-5,9`.
fn ranges(marks: impl Iterator<Item = bool>) -> String {
    let mut all: Vec<[usize; 2]> = Vec::new();
    for (f, _) in marks.enumerate().filter(|(_, mark)| *mark) {
        match all.last_mut() {
            Some([_, last]) if *last + 1 == f => *last = f,
            _ => all.push([f, f]),
        }
    }
    let text = |[from, to]: &[usize; 2]| match from == to {
        true => from.to_string(),
        false => format!("{from}-{to}"),
    };
    all.iter().map(text).collect::<Vec<_>>().join(",")
}

/// The property of each triangle: colours if there are any, else materials, else orange for patches and grey for the
/// other faces.
enum Properties<'a> {
    Colours {
        palette: Vec<[u8; 4]>,
        /// The index in the palette of each corner's colour.
        of_face: Vec<[u32; 3]>,
        /// The attributes that the colours represent completely.
        held: Vec<&'a Attribute>,
    },
    Materials(&'a Labels, Vec<[u8; 4]>),
    Patches(Vec<bool>),
    Nothing,
}

impl<'a> Properties<'a> {
    fn new(model: &Contents<'a>) -> Self {
        let all = model.attributes;
        if let Some(colours) = Self::colours(model) {
            return colours;
        }
        let labels = all.labels_of(LabelKind::Material);
        if let Some(labels) = labels.filter(|l| !l.names.is_empty()) {
            let look = |name: &String| {
                let look = all.materials.iter().find(|m| m.name == *name);
                let byte = |x: f32| (255.0 * x).round().clamp(0.0, 255.0) as u8;
                let patch = if name == PATCH_NAME { ORANGE } else { GREY };
                look.and_then(|m| Some((m, m.colour?)))
                    .map_or(patch, |(m, [r, g, b])| {
                        [r, g, b, m.opacity.unwrap_or(1.0)].map(byte)
                    })
            };
            return Self::Materials(labels, labels.names.iter().map(look).collect());
        }
        let patches: Vec<bool> = (0..model.mesh.faces.len())
            .map(|f| all.is_patch(f))
            .collect();
        match patches.contains(&true) {
            true => Self::Patches(patches),
            false => Self::Nothing,
        }
    }

    /// Corner colours. Faces of patches take their face colour first; otherwise the order is corner, vertex, face.
    fn colours(model: &Contents<'a>) -> Option<Self> {
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
        let (mut uses_corner, mut uses_vertex, mut uses_face) = (false, false, face.is_some());
        for (f, vertices) in model.mesh.faces.iter().enumerate() {
            let own = face.and_then(|a| Some(bytes(a, a.get(f)?)));
            let first = own.filter(|_| all.is_patch(f));
            let mut colour = |k: usize| {
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
            held: corner.into_iter().chain(vertex).chain(face).collect(),
        })
    }

    /// Whether the colours represent this attribute.
    fn holds(&self, attribute: &Attribute) -> bool {
        let Self::Colours { held, .. } = self else {
            return false;
        };
        held.iter().any(|own| std::ptr::eq(*own, attribute))
    }

    /// The index of an object's default property. An object needs a default if any of its faces has a property.
    fn usual(&self, faces: &[u32]) -> Option<u32> {
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

    fn write(&self, out: &mut String) {
        let hex = |colour: &[u8; 4]| {
            let digits: String = colour.iter().map(|byte| format!("{byte:02X}")).collect();
            format!("#{digits}")
        };
        let base = |out: &mut String, name: &str, colour: &[u8; 4]| {
            let (name, colour) = (escape(name), hex(colour));
            let _ = writeln!(out, "<base name=\"{name}\" displaycolor=\"{colour}\"/>");
        };
        match self {
            Self::Nothing => {}
            Self::Colours { palette, .. } => {
                let _ = writeln!(out, "<m:colorgroup id=\"{GROUP}\">");
                for colour in palette {
                    let _ = writeln!(out, "<m:color color=\"{}\"/>", hex(colour));
                }
                out.push_str("</m:colorgroup>\n");
            }
            Self::Materials(labels, appearances) => {
                let _ = writeln!(out, "<basematerials id=\"{GROUP}\">");
                for (name, look) in labels.names.iter().zip(appearances) {
                    base(out, name, look);
                }
                if labels.of_face.contains(&NONE) {
                    base(out, NO_MATERIAL, &GREY);
                }
                out.push_str("</basematerials>\n");
            }
            Self::Patches(_) => {
                let _ = writeln!(out, "<basematerials id=\"{GROUP}\">");
                base(out, "surface", &GREY);
                base(out, PATCH_NAME, &ORANGE);
                out.push_str("</basematerials>\n");
            }
        }
    }

    /// Writes the property attributes of a triangle.
    fn of_face(&self, out: &mut String, f: usize) {
        let _ = match self {
            Self::Colours { of_face, .. } => match of_face[f] {
                [a, b, c] if a == b && b == c => write!(out, " pid=\"{GROUP}\" p1=\"{a}\""),
                [a, b, c] => write!(out, " pid=\"{GROUP}\" p1=\"{a}\" p2=\"{b}\" p3=\"{c}\""),
            },
            Self::Materials(labels, _) if labels.of_face[f] != NONE => {
                write!(out, " pid=\"{GROUP}\" p1=\"{}\"", labels.of_face[f])
            }
            Self::Patches(patches) if patches[f] => write!(out, " pid=\"{GROUP}\" p1=\"1\""),
            _ => Ok(()),
        };
    }
}
