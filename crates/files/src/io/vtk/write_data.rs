//! Converts attributes to point and cell data of vtkio.

use std::borrow::Cow;

use vtkio::IOBuffer;
use vtkio::model::{Attribute as Item, Attributes as Data, DataArray, ElementType, FieldArray};

use super::super::{Contents, Format, lost, text};
use super::scalar::Scalar;
use isomend_core::mesh::attributes::{Active, Attribute, CornerAttribute, Role};

/// The data of a model for a format, and the remark on attributes that are left out.
pub(super) fn data(model: &Contents<'_>, format: Format) -> (Data, Vec<String>) {
    let all = model.attributes;
    // Corner attributes become point data where all corners at a point agree.
    let corner: Vec<Option<Attribute>> = all
        .corner
        .iter()
        .map(|c: &CornerAttribute| c.per_vertex(model.mesh))
        .collect();
    let held = |a: &Attribute| {
        let place = all.corner.iter().position(|c| std::ptr::eq(&c.pool, a));
        place.is_none_or(|place| corner[place].is_some())
    };
    let note = lost::note(&all.listed_where(|a| !held(a), |_| true), format);
    let point: Vec<&Attribute> = all.vertex.iter().chain(corner.iter().flatten()).collect();
    let cell: Vec<&Attribute> = all.face.iter().collect();
    let mut data = Data::new();
    (data.point, data.cell) = (items(&point, format, true), items(&cell, format, false));
    (data, note.into_iter().collect())
}

fn items(attributes: &[&Attribute], format: Format, of_points: bool) -> Vec<Item> {
    let (mut names, mut uses) = (text::Distinct::default(), Vec::new());
    let (mut items, mut field) = (Vec::new(), Vec::new());
    for attribute in attributes {
        let mut name = name(attribute);
        if name.is_empty() && format == Format::Vtk {
            // An empty name would leave the line of the array one word short.
            name = "unnamed".to_owned();
        }
        let name = names.name(name);
        let mut use_ = use_of(attribute, of_points);
        if uses.contains(&use_) {
            use_ = Active::Plain;
        }
        uses.push(use_);
        let data = buffer(attribute);
        let components = attribute.components as u32;
        match element(use_, components) {
            // Legacy files hold plain arrays and further scalars only in a field.
            ElementType::Generic(elem) if format == Format::Vtk => {
                let name = encoded(&name);
                field.push(FieldArray { name, elem, data });
            }
            elem => {
                let name = if format == Format::Vtk {
                    encoded(&name)
                } else {
                    name
                };
                items.push(Item::DataArray(DataArray { name, elem, data }));
            }
        }
    }
    if !field.is_empty() {
        items.push(Item::Field {
            name: "FieldData".to_owned(),
            data_array: field,
        });
    }
    items
}

/// How VTK is to use an array.
fn use_of(attribute: &Attribute, of_points: bool) -> Active {
    if let Some(use_) = attribute.active {
        return use_;
    }
    match attribute.role {
        Role::Normal if of_points && attribute.components == 3 => Active::Normals,
        Role::Uv(0) if of_points => Active::TextureCoordinates,
        Role::Colour if matches!(attribute.components, 3 | 4) => Active::Scalars,
        _ => Active::Plain,
    }
}

fn element(use_: Active, components: u32) -> ElementType {
    match (use_, components) {
        (Active::Scalars, 1..=4) => ElementType::Scalars {
            num_comp: components,
            lookup_table: None,
        },
        (Active::Vectors, 3) => ElementType::Vectors,
        (Active::Normals, 3) => ElementType::Normals,
        (Active::TextureCoordinates, 1..=3) => ElementType::TCoords(components),
        (Active::Tensors, 9) => ElementType::Tensors,
        _ => ElementType::Generic(components),
    }
}

/// The name in a VTK file: the attribute's own if it came from a VTK file, or else the usual name of its role.
fn name(attribute: &Attribute) -> String {
    let role = attribute.role;
    match (attribute.active, role, attribute.components) {
        (None, Role::Normal, _) => "Normals".to_owned(),
        (None, Role::Colour, 4) => "RGBA".to_owned(),
        (None, Role::Colour, 3) => "RGB".to_owned(),
        (None, Role::Uv(0), _) => "TCoords".to_owned(),
        (None, Role::Uv(set), _) => format!("TCoords{set}"),
        (None, Role::Tangent, _) => "Tangents".to_owned(),
        _ if attribute.name.is_empty() => "array".to_owned(),
        _ => attribute.name.clone(),
    }
}

/// Encodes a name for a legacy file, where blanks separate words.
fn encoded(name: &str) -> String {
    let mut out = String::new();
    for byte in name.bytes() {
        if (33..=126).contains(&byte) && byte != b'"' && byte != b'%' {
            out.push(char::from(byte));
        } else {
            out += &format!("%{byte:02X}");
        }
    }
    out
}

/// The values in the type to write. Attributes that did not come from a VTK file are converted to what VTK expects:
/// bytes for colours, floats for fractions.
fn buffer(attribute: &Attribute) -> IOBuffer {
    let own = attribute.active.is_some();
    let unit = attribute.unit();
    let (scalar, factor) = match attribute.role {
        Role::Colour if !own => (Scalar::U8, 255.0 / unit),
        _ if !own && unit != 1.0 => (Scalar::F32, 1.0 / unit),
        _ => (attribute.scalar, 1.0),
    };
    let mut values = Cow::Borrowed(&attribute.values);
    if factor != 1.0 || scalar != attribute.scalar {
        let scaled = |v: &mut f64| *v = scalar.nearest(*v * factor);
        values.to_mut().iter_mut().for_each(scaled);
    }
    let v = values.iter();
    match scalar {
        Scalar::I8 => IOBuffer::I8(v.map(|v| *v as i8).collect()),
        Scalar::U8 => IOBuffer::U8(v.map(|v| *v as u8).collect()),
        Scalar::I16 => IOBuffer::I16(v.map(|v| *v as i16).collect()),
        Scalar::U16 => IOBuffer::U16(v.map(|v| *v as u16).collect()),
        Scalar::I32 => IOBuffer::I32(v.map(|v| *v as i32).collect()),
        Scalar::U32 => IOBuffer::U32(v.map(|v| *v as u32).collect()),
        Scalar::I64 => IOBuffer::I64(v.map(|v| *v as i64).collect()),
        Scalar::U64 => IOBuffer::U64(v.map(|v| *v as u64).collect()),
        Scalar::F32 => IOBuffer::F32(v.map(|v| *v as f32).collect()),
        Scalar::F64 => IOBuffer::F64(values.into_owned()),
    }
}
