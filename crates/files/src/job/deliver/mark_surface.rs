//! Marks patches on meshes with colours at corners or from materials.

use std::collections::BTreeMap;

use glam::DVec3;

use super::components::Component;
use crate::io::{Format, GltfDocument};
use isomend_core::mesh::attributes::{
    Attribute, CornerAttribute, LabelKind, NONE, PATCH_NAME, Role, Scalar,
};
use isomend_core::mesh::{Attributes, Mesh, Model};

/// Whether values are colours.
fn is_colour(a: &Attribute) -> bool {
    a.role == Role::Colour && (3..=4).contains(&a.components)
}

/// Takes the corner colours out of a model's attributes, and adds vertex colours to these if there are none. If only materials colour the
/// mesh, and the format (3MF) has either colours or materials on a face, the corner colours are made from the materials: otherwise marking
/// patches would remove all other colours.
pub(super) fn corner_colours(
    attributes: &mut Attributes,
    mesh: &Mesh,
    format: Format,
) -> Option<CornerAttribute> {
    let found = found_colours(attributes, mesh, format)?;
    if !attributes.vertex.iter().any(is_colour) {
        attributes.vertex.push(vertex_colours(&found, mesh));
    }
    Some(found)
}

/// The corner colours, of the mesh or from its materials; `None` if there are none.
fn found_colours(
    attributes: &mut Attributes,
    mesh: &Mesh,
    format: Format,
) -> Option<CornerAttribute> {
    if let Some(place) = attributes.corner.iter().position(|c| is_colour(&c.pool)) {
        return Some(attributes.corner.remove(place));
    }
    let has_others = attributes
        .vertex
        .iter()
        .chain(&attributes.face)
        .any(is_colour);
    if format != Format::ThreeMf || has_others {
        return None;
    }
    let labels = attributes.labels_of(LabelKind::Material)?;
    let colours = labels.names.iter().map(|name| {
        let own = attributes.materials.iter().find(|m| m.name == name.trim());
        let [r, g, b] = own.and_then(|m| m.colour)?;
        let opacity = own.and_then(|m| m.opacity).unwrap_or(1.0);
        Some([r, g, b, opacity].map(|x| (255.0 * f64::from(x)).round()))
    });
    let colours: Vec<Option<[f64; 4]>> = colours.collect();
    colours.iter().flatten().next()?;
    let mut pool = Attribute::new("colour", Role::Colour, Scalar::U8, 4);
    for colour in &colours {
        pool.push(Some(&colour.unwrap_or([200.0, 200.0, 200.0, 255.0])));
    }
    let corner = |f: usize| labels.of_face.get(f).copied().unwrap_or(NONE);
    let corners = (0..mesh.faces.len()).map(|f| [corner(f); 3]).collect();
    Some(CornerAttribute { pool, corners })
}

/// The mean of the corners' colours at each vertex, for formats with vertex colours only.
fn vertex_colours(of_corners: &CornerAttribute, mesh: &Mesh) -> Attribute {
    let pool = &of_corners.pool;
    let mut sums = vec![vec![0.0; pool.components + 1]; mesh.positions.len()];
    for (f, face) in mesh.faces.iter().enumerate() {
        for (k, &v) in face.iter().enumerate() {
            let Some(value) = of_corners.get(f, k) else {
                continue;
            };
            let sum = &mut sums[v as usize];
            sum.iter_mut().zip(value).for_each(|(s, x)| *s += x);
            sum[pool.components] += 1.0;
        }
    }
    let mut colours = Attribute {
        values: Vec::new(),
        missing: Vec::new(),
        ..pool.clone()
    };
    for sum in sums {
        let count = sum[pool.components];
        let mean: Vec<f64> = sum[..pool.components].iter().map(|s| s / count).collect();
        colours.push((count > 0.0).then_some(&mean));
    }
    colours
}

/// Colours the corners of patches. `colour_at` takes the index of a component and a corner's position; a corner keeps its colour if the
/// result is `None`.
pub(super) fn paint_corners(
    of_corners: &mut CornerAttribute,
    components: &[Component],
    mesh: &Mesh,
    colour_at: &dyn Fn(usize, DVec3) -> Option<[u8; 3]>,
) {
    let mut places: BTreeMap<[u8; 3], u32> = BTreeMap::new();
    let pool = &mut of_corners.pool;
    for (c, component) in components.iter().enumerate() {
        for &f in &component.faces {
            let points = mesh.corners(f);
            for (k, point) in points.into_iter().enumerate() {
                let Some(colour) = colour_at(c, point) else {
                    continue;
                };
                let place = *places.entry(colour).or_insert_with(|| {
                    let unit = pool.unit();
                    let part = |k: usize| colour.get(k).map_or(1.0, |x| f64::from(*x) / 255.0);
                    let value: Vec<f64> = (0..pool.components).map(|k| unit * part(k)).collect();
                    pool.push(Some(&value));
                    pool.len() as u32 - 1
                });
                of_corners.corners[f as usize][k] = place;
            }
        }
    }
}

/// A remark on marked faces with coloured or textured materials: viewers multiply the vertex colours by these, or show the materials alone.
/// `document` holds the materials of a glTF file.
pub(super) fn material_note(
    model: &Model,
    kept: usize,
    format: Format,
    document: Option<&GltfDocument>,
) -> Option<String> {
    if !matches!(format, Format::Obj | Format::Gltf | Format::Glb) {
        return None;
    }
    let attributes = &model.attributes;
    let labels = attributes.labels_of(LabelKind::Material)?;
    let is_plain = |(place, name): (usize, &String)| {
        let material = attributes.materials.iter().find(|m| m.name == name.trim());
        match (material, document) {
            _ if name == PATCH_NAME => true,
            (Some(m), _) => m.texture.is_none() && m.colour.is_none_or(|c| c == [1.0; 3]),
            (None, Some(document)) => {
                let own = document.base_colour(place);
                own.image.is_none() && own.factor[..3] == [1.0; 3]
            }
            (None, None) => true,
        }
    };
    let plain: Vec<bool> = labels.names.iter().enumerate().map(is_plain).collect();
    let is_coloured = |f: &&u32| plain.get(**f as usize) == Some(&false);
    let count = labels.of_face[kept..].iter().filter(is_coloured).count();
    (count > 0).then(|| {
        format!(
            "marked faces whose material has a colour or texture, by which viewers multiply the mark, or which they show instead: {count}"
        )
    })
}
