//! Writes a mesh as the text of a USD stage: a mesh for each object, with values, subsets of materials and groups, and the materials.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::super::text::Distinct;
use super::super::{Contents, FileDocument, Format, IoError, Written, extent, lost, rounded};
use super::document::UsdDocument;
use super::write_values::{Decimal, Lines, Local, identifier, primvars};
use isomend_core::mesh::Unit;
use isomend_core::mesh::attributes::{LabelKind, Labels, Material, NONE, PATCH_NAME};

/// The prim that holds everything.
const ROOT: &str = "Root";

/// Writes a stage.
pub(super) fn write(model: &Contents<'_>, format: Format) -> Result<Written, IoError> {
    let (points, mut notes) = rounded(model.mesh, format)?;
    let document = model.document.and_then(FileDocument::usd);
    let size = 40 * points.len() + 24 * model.mesh.faces.len();
    let mut out = Lines {
        text: String::with_capacity(size),
        depth: 0,
    };
    notes.extend(header(&mut out, model, document));
    let mut names = Distinct::default();
    let materials = materials(model, &mut names);
    out.open(&format!("def Xform \"{ROOT}\" (kind = \"component\")"));
    let objects = objects(model);
    let is_only = objects.len() == 1;
    let mut siblings = Distinct::default();
    siblings.take("Materials");
    let mut number_of = vec![NONE; points.len()];
    for (name, faces) in &objects {
        let name = siblings.name(identifier(name, "mesh"));
        let mut used: Vec<u32> = match is_only {
            true => (0..points.len() as u32).collect(),
            false => faces
                .iter()
                .flat_map(|f| model.mesh.faces[*f as usize])
                .collect(),
        };
        used.sort_unstable();
        used.dedup();
        for (new, old) in (0..).zip(&used) {
            number_of[*old as usize] = new;
        }
        let local = Local {
            model,
            faces,
            used: &used,
            keeps_names: document.is_some(),
        };
        mesh(&mut out, &local, &points, (&name, &number_of), &materials);
        used.iter().for_each(|old| number_of[*old as usize] = NONE);
    }
    appearances(&mut out, model, &materials);
    out.close();
    notes.extend(lost::note(&without_place(model), format));
    let rest = document.map(UsdDocument::rest).unwrap_or_default();
    if !rest.is_empty() {
        notes.push(format!(
            "left out, because the stage is written anew: {}",
            rest.join(", ")
        ));
    }
    Ok(Written {
        bytes: out.text.into_bytes(),
        notes,
    })
}

/// What a stage has no place for.
fn without_place(model: &Contents<'_>) -> String {
    let attributes = model.attributes;
    let mut listed = attributes.listed_where(|_| false, |kind| kind == LabelKind::Smoothing);
    let materials = attributes.materials.iter();
    let textures = materials.filter(|material| material.texture.is_some());
    let of_gltf = model.document.and_then(FileDocument::gltf);
    let images = of_gltf.into_iter().flat_map(|gltf| gltf.images_of_faces());
    let images: BTreeSet<usize> = images.filter_map(|(_, image)| image).collect();
    let count = textures.count() + images.len();
    if count > 0 {
        let join = if listed.is_empty() { "" } else { ", " };
        listed += &format!("{join}textures of materials: {count}");
    }
    listed
}

/// Writes the metadata of the stage; returns a remark if the unit is not known.
fn header(out: &mut Lines, model: &Contents<'_>, document: Option<&UsdDocument>) -> Option<String> {
    let is_gltf = model.is_of_gltf();
    let own = document.and_then(|document| document.metres);
    // A unit of a stage that has no name here is kept.
    let unit = model
        .attributes
        .unit
        .map(Unit::metres)
        .or(own)
        .or(is_gltf.then_some(1.0));
    let is_y_up = document.map_or(is_gltf, |document| document.is_y_up);
    // Readers take centimetres for a stage without a unit: it stays without, so that it keeps its size.
    let is_usual = unit.is_none() && document.is_some();
    let unit_line = match unit.unwrap_or_else(|| Unit::Millimetre.metres()) {
        _ if is_usual => String::new(),
        metres => format!("    metersPerUnit = {metres}\n"),
    };
    let _ = write!(
        out.text,
        "#usda 1.0\n(\n    defaultPrim = \"{ROOT}\"\n{unit_line}    upAxis = \"{}\"\n)\n\n",
        if is_y_up { "Y" } else { "Z" },
    );
    (unit.is_none() && !is_usual)
        .then(|| "the unit of the coordinates is not known, so millimetres are written".to_owned())
}

/// The names of the materials in the file, by their labels.
fn materials(model: &Contents<'_>, names: &mut Distinct) -> Vec<String> {
    let labels = model.attributes.labels_of(LabelKind::Material);
    let all = labels.map_or(&[][..], |labels| &labels.names);
    all.iter()
        .map(|name| names.name(identifier(name, "material")))
        .collect()
}

/// The objects and their parts: names and faces, in the order of their labels; faces without a label come last.
fn objects(model: &Contents<'_>) -> Vec<(String, Vec<u32>)> {
    let labels = [LabelKind::Object, LabelKind::Part].map(|kind| model.attributes.labels_of(kind));
    let mut all: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for face in 0..model.mesh.faces.len() {
        let key = labels.map(|labels| labels.map_or(NONE, |labels| labels.of_face[face]));
        all.entry(key).or_default().push(face as u32);
    }
    let name = |key: &[u32; 2]| {
        let own = labels
            .iter()
            .zip(key)
            .filter_map(|(labels, place)| labels.as_ref()?.names.get(*place as usize));
        own.filter(|name| !name.is_empty())
            .cloned()
            .collect::<Vec<_>>()
            .join("_")
    };
    all.into_iter()
        .map(|(key, faces)| (name(&key), faces))
        .collect()
}

/// Writes a mesh. `number_of` are the numbers of vertices in this mesh.
fn mesh(
    out: &mut Lines,
    local: &Local<'_>,
    points: &[[f32; 3]],
    (name, number_of): (&str, &[u32]),
    materials: &[String],
) {
    let labels = local.model.attributes.labels_of(LabelKind::Material);
    let of_face = |face: &u32| labels.map_or(NONE, |labels| labels.of_face[*face as usize]);
    let first = local.faces.first().map_or(NONE, of_face);
    let is_single = local.faces.iter().all(|face| of_face(face) == first);
    let bound = materials.get(first as usize).filter(|_| is_single);
    out.open(&format!("def Mesh \"{name}\"{}", binding_api(bound)));
    shape(out, local, points, number_of);
    out.line("uniform token subdivisionScheme = \"none\"");
    primvars(out, local);
    bind(out, bound);
    let mut names = Distinct::default();
    names.take(PATCH_NAME);
    if let Some(labels) = labels.filter(|_| !is_single) {
        out.line("uniform token subsetFamily:materialBind:familyType = \"nonOverlapping\"");
        subsets(out, local, labels, &mut names, Some(materials));
    }
    if let Some(labels) = local.model.attributes.labels_of(LabelKind::Group) {
        subsets(out, local, labels, &mut names, None);
    }
    let patches = local.places(|face| local.model.attributes.is_patch(face));
    if !patches.is_empty() {
        subset(out, PATCH_NAME, "isomend", &patches, None);
    }
    out.close();
}

/// Writes the points and the faces of a mesh.
fn shape(out: &mut Lines, local: &Local<'_>, points: &[[f32; 3]], number_of: &[u32]) {
    let own: Vec<[f32; 3]> = local.used.iter().map(|v| points[*v as usize]).collect();
    let decimals = |all: &[[f32; 3]]| -> Vec<[Decimal<f32>; 3]> {
        all.iter().map(|point| point.map(Decimal)).collect()
    };
    if !own.is_empty() {
        let bounds = decimals(&extent(&own));
        out.array("float3[] extent", bounds.iter().map(|p| &p[..]), &[]);
    }
    out.array(
        "int[] faceVertexCounts",
        local.faces.iter().map(|_| &[3u32][..]),
        &[],
    );
    let corners = local
        .faces
        .iter()
        .map(|f| local.model.mesh.faces[*f as usize].map(|v| number_of[v as usize]));
    let corners: Vec<[u32; 3]> = corners.collect();
    out.array(
        "int[] faceVertexIndices",
        corners.as_flattened().chunks(1),
        &[],
    );
    out.array(
        "point3f[] points",
        decimals(&own).iter().map(|p| &p[..]),
        &[],
    );
}

/// Writes the faces of each label as a subset.
fn subsets(
    out: &mut Lines,
    local: &Local<'_>,
    labels: &Labels,
    names: &mut Distinct,
    materials: Option<&[String]>,
) {
    let mut faces: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (new, old) in (0..).zip(local.faces) {
        let label = labels.of_face[*old as usize];
        if label != NONE && labels.names[label as usize] != PATCH_NAME {
            faces.entry(label).or_default().push(new);
        }
    }
    for (label, faces) in faces {
        let material = materials.map(|materials| &materials[label as usize]);
        let name = material
            .cloned()
            .unwrap_or_else(|| identifier(&labels.names[label as usize], "group"));
        let family = if material.is_some() {
            "materialBind"
        } else {
            "group"
        };
        subset(out, &names.name(name), family, &faces, material);
    }
}

fn subset(out: &mut Lines, name: &str, family: &str, faces: &[u32], material: Option<&String>) {
    out.open(&format!(
        "def GeomSubset \"{name}\"{}",
        binding_api(material)
    ));
    out.line("uniform token elementType = \"face\"");
    out.line(&format!("uniform token familyName = \"{family}\""));
    out.array("int[] indices", faces.chunks(1), &[]);
    bind(out, material);
    out.close();
}

/// The schema of what has a material, behind the name of a prim.
fn binding_api(material: Option<&String>) -> &'static str {
    match material {
        Some(_) => " (prepend apiSchemas = [\"MaterialBindingAPI\"])",
        None => "",
    }
}

/// Binds a prim to its material, if it has one.
fn bind(out: &mut Lines, material: Option<&String>) {
    if let Some(material) = material {
        out.line(&format!(
            "rel material:binding = </{ROOT}/Materials/{material}>"
        ));
    }
}

/// Writes the materials, with what is known of their appearance.
fn appearances(out: &mut Lines, model: &Contents<'_>, names: &[String]) {
    let labels = model.attributes.labels_of(LabelKind::Material);
    let labels = labels.map_or(&[][..], |labels| &labels.names);
    if labels.is_empty() {
        return;
    }
    out.open("def Scope \"Materials\"");
    for (label, name) in labels.iter().zip(names) {
        out.open(&format!("def Material \"{name}\""));
        let known = model
            .attributes
            .materials
            .iter()
            .find(|material| material.name == *label);
        if let Some(known) = known {
            out.line(&format!(
                "token outputs:surface.connect = </{ROOT}/Materials/{name}/Surface.outputs:surface>"
            ));
            surface(out, known);
        }
        out.close();
    }
    out.close();
}

fn surface(out: &mut Lines, material: &Material) {
    out.open("def Shader \"Surface\"");
    out.line("uniform token info:id = \"UsdPreviewSurface\"");
    if let Some([r, g, b]) = material.colour {
        out.line(&format!("color3f inputs:diffuseColor = ({r}, {g}, {b})"));
    }
    for (name, value) in [
        ("opacity", material.opacity),
        ("roughness", material.roughness),
        ("metallic", material.metallic),
    ] {
        if let Some(value) = value {
            out.line(&format!("float inputs:{name} = {value}"));
        }
    }
    out.line("token outputs:surface");
    out.close();
}
