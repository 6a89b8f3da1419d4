//! Writes a mesh as a 3MF package, with objects, colours or materials, and patch marks.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use quick_xml::escape::escape;
use zip::ZipWriter;

use super::super::{Contents, Format, IoError, Written, lost};
use super::model::{PATCH_FACES, unit_word};
use super::package::options;
use super::properties::Properties;
use isomend_core::mesh::Unit;
use isomend_core::mesh::attributes::{LabelKind, NONE};

/// The namespace of the metadata of isomend.
pub(super) const ISOMEND: &str = "urn:isomend";
const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
/// The namespace of the material extension.
pub(super) const MATERIAL: &str = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02";
const CONTENT_TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>
"#;
const RELATIONSHIPS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
"#;
/// The id of the group of properties. The ids of objects follow.
const GROUP: u32 = 1;

/// Writes a package with one object per object label.
pub(super) fn write(model: &Contents<'_>) -> Result<Written, IoError> {
    // glTF has metres by definition.
    let of_gltf = model.is_of_gltf().then_some(Unit::Metre);
    let unit = model.attributes.unit.or(of_gltf);
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
    for (name, text) in [
        ("[Content_Types].xml", CONTENT_TYPES),
        ("_rels/.rels", RELATIONSHIPS),
        ("3D/3dmodel.model", model),
    ] {
        package.start_file(name, options(text))?;
        package.write_all(text.as_bytes())?;
    }
    Ok(package.finish()?.into_inner())
}

fn markup(model: &Contents<'_>, unit: Unit, properties: &Properties) -> String {
    let mesh = model.mesh;
    let word = unit_word(unit);
    let mut out = String::with_capacity(mesh.positions.len() * 60 + mesh.faces.len() * 50);
    // Writing to a string does not fail.
    let _ = writeln!(
        out,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"{word}\" xml:lang=\"en-US\" xmlns=\"{CORE}\" xmlns:m=\"{MATERIAL}\" \
         xmlns:isomend=\"{ISOMEND}\">\n<metadata name=\"Application\">isomend</metadata>\n<resources>"
    );
    properties.write(&mut out, GROUP, ["", "m:"]);
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
        properties.of_face(out, f as usize, GROUP, false);
        out.push_str("/>\n");
    }
    used.iter().for_each(|v| number_of[*v as usize] = NONE);
    out.push_str("</triangles>\n</mesh>\n</object>\n");
}

/// The indices of true values as ranges, for example `3-5,9`.
pub(super) fn ranges(marks: impl Iterator<Item = bool>) -> String {
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
