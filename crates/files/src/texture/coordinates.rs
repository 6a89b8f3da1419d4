//! Stores the texture coordinates of charts in the attributes of a mesh.

use super::unfolded::Chart;
use isomend_core::attributes::FieldSource;
use isomend_core::mesh::attributes::{Attribute, NONE, Role};
use isomend_core::mesh::{Attributes, Mesh, Model};

/// The first set of texture coordinates, if it has at least two components.
pub(super) fn first_set(attributes: &Attributes) -> Option<FieldSource<'_>> {
    let pools = attributes.corner.iter().map(FieldSource::Corner);
    let mut all = pools.chain(attributes.vertex.iter().map(FieldSource::Vertex));
    all.find(|s| s.attribute().role == Role::Uv(0) && s.attribute().components >= 2)
}

/// The rounding of texture coordinates by their scalar type and to 32-bit floats; `None` without texture coordinates.
pub(super) fn uv_rounding(attributes: &Attributes) -> Option<impl Fn(f64) -> f64 + Sync + use<>> {
    let source = first_set(attributes)?;
    let (scalar, unit) = (source.attribute().scalar, source.attribute().unit());
    // Most file formats store 32-bit floats.
    Some(move |x: f64| f64::from((scalar.nearest(x * unit) / unit) as f32))
}

/// Stores the texture coordinates of a chart's faces, at corners or at vertices, as the mesh has them. `uv` holds the coordinates of the
/// chart's vertices; the input has `first_new` vertices and `kept` faces.
pub(super) fn put(
    chart: &Chart,
    uv: &[[f64; 2]],
    [first_new, kept]: [usize; 2],
    model: &mut Model,
) {
    let is_uv = |a: &Attribute| a.role == Role::Uv(0) && a.components >= 2;
    let Model {
        mesh, attributes, ..
    } = model;
    if let Some(pool) = attributes.corner.iter_mut().find(|c| is_uv(&c.pool)) {
        let first = pool.pool.len() as u32;
        let (unit, components) = (pool.pool.unit(), pool.pool.components);
        for value in uv {
            pool.pool.push(Some(&padded(*value, unit, components)));
        }
        for (face, f) in chart.disk.faces.iter().zip(&chart.faces) {
            pool.corners[kept + f] = face.map(|v| first + v);
        }
        return;
    }
    let Some(place) = attributes.vertex.iter().position(is_uv) else {
        return;
    };
    // A new vertex without texture coordinates takes the first ones assigned to it; further ones go to copies of the vertex.
    let mut vertex_of = vec![NONE; uv.len()];
    for (face, f) in chart.disk.faces.iter().zip(&chart.faces) {
        for (k, &v) in face.iter().enumerate() {
            if vertex_of[v as usize] == NONE {
                let there = mesh.faces[kept + f][k];
                vertex_of[v as usize] = own_vertex(there, first_new, mesh, attributes, place);
                let uvs = &mut attributes.vertex[place];
                let value = padded(uv[v as usize], uvs.unit(), uvs.components);
                set(uvs, vertex_of[v as usize] as usize, &value);
            }
            mesh.faces[kept + f][k] = vertex_of[v as usize];
        }
    }
}

/// The vertex itself if it is new and has no texture coordinates, else a new copy of it.
fn own_vertex(
    vertex: u32,
    first_new: usize,
    mesh: &mut Mesh,
    attributes: &mut Attributes,
    uv: usize,
) -> u32 {
    let is_free = attributes.vertex[uv].get(vertex as usize).is_none();
    if is_free && vertex as usize >= first_new {
        return vertex;
    }
    let copy = mesh.positions.len() as u32;
    mesh.positions.push(mesh.positions[vertex as usize]);
    attributes.copies.push((copy, vertex));
    for attribute in &mut attributes.vertex {
        let value: Option<Vec<f64>> = attribute.get(vertex as usize).map(<[f64]>::to_vec);
        attribute.push(value.as_deref());
    }
    copy
}

/// Stores a value, rounded to the scalar type, and marks the item as present.
fn set(attribute: &mut Attribute, item: usize, value: &[f64]) {
    let (scalar, start) = (attribute.scalar, item * attribute.components);
    for (to, from) in attribute.values[start..].iter_mut().zip(value) {
        *to = scalar.nearest(*from);
    }
    if let Some(missing) = attribute.missing.get_mut(item) {
        *missing = false;
    }
}

/// Texture coordinates in the attribute's unit, padded with zeros to its number of components.
fn padded([u, v]: [f64; 2], unit: f64, components: usize) -> Vec<f64> {
    let mut value = vec![0.0; components];
    value[0] = u * unit;
    value[1] = v * unit;
    value
}
