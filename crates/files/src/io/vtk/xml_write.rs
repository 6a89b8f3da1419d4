//! Writes poly data as XML (VTP), with arrays in base64 and in little-endian byte order.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use quick_xml::escape::escape;

use super::super::binary::BinaryNumber;
use super::super::{Contents, Format, IoError, Precision, WriteOptions, Written, rounded};
use super::arrays::Array;
use super::scalar::{Scalar, VtkScalar};
use super::write_data::arrays;
use isomend_core::mesh::attributes::Active;

/// Writes a VTP file.
pub(in super::super) fn write_xml(
    model: &Contents<'_>,
    options: &WriteOptions,
) -> Result<Written, IoError> {
    let mesh = model.mesh;
    let (scalar, mut notes) = match options.precision {
        // Coordinates that do not fit are refused.
        Precision::F32 => (Scalar::F32, rounded(mesh, Format::Vtp)?.1),
        Precision::F64 => (Scalar::F64, Vec::new()),
    };
    let ([point, cell], lost) = arrays(model, Format::Vtp);
    notes.extend(lost);
    let mut text =
        "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"><PolyData><Piece".to_owned();
    let sizes = [
        ("Points", mesh.positions.len()),
        ("Polys", mesh.faces.len()),
    ];
    for (what, size) in sizes.into_iter().filter(|(_, size)| *size > 0) {
        let _ = write!(text, " NumberOf{what}=\"{size}\"");
    }
    text.push('>');
    put_data(&mut text, "PointData", &point);
    put_data(&mut text, "CellData", &cell);
    text += "<Points>";
    let coordinates = mesh.positions.iter().flat_map(|p| p.to_array());
    put_array(&mut text, "Points", scalar, 3, coordinates);
    text += "</Points><Polys>";
    let corners = mesh.faces.iter().flatten().map(|v| f64::from(*v));
    put_array(&mut text, "connectivity", Scalar::U64, 1, corners);
    let ends = (1..=mesh.faces.len()).map(|i| 3.0 * i as f64);
    put_array(&mut text, "offsets", Scalar::U64, 1, ends);
    text += "</Polys></Piece></PolyData></VTKFile>";
    let bytes = text.into_bytes();
    Ok(Written { bytes, notes })
}

/// Appends point or cell data with the names of the active arrays; nothing if there are no arrays.
fn put_data(text: &mut String, element: &str, arrays: &[Array]) {
    if arrays.is_empty() {
        return;
    }
    let _ = write!(text, "<{element}");
    for (name, active) in [
        ("Scalars", Active::Scalars),
        ("Vectors", Active::Vectors),
        ("Normals", Active::Normals),
        ("Tensors", Active::Tensors),
        ("TCoords", Active::TextureCoordinates),
    ] {
        if let Some(array) = arrays.iter().find(|a| a.use_ == active) {
            let _ = write!(text, " {name}=\"{}\"", escape(&array.name));
        }
    }
    text.push('>');
    for array in arrays {
        let values = array.values.iter().copied();
        put_array(text, &array.name, array.scalar, array.components, values);
    }
    let _ = write!(text, "</{element}>");
}

/// Appends an array: the number of its bytes in 64 bits, then its numbers.
fn put_array(
    text: &mut String,
    name: &str,
    scalar: Scalar,
    components: usize,
    values: impl Iterator<Item = f64>,
) {
    let mut bytes = vec![0; size_of::<u64>()];
    let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
    for value in values {
        let value = scalar.nearest(value);
        (low, high) = (low.min(value), high.max(value));
        scalar.put(value, &mut bytes);
    }
    let length = (bytes.len() - size_of::<u64>()) as u64;
    bytes[..size_of::<u64>()].copy_from_slice(&length.to_le_bytes());
    let (kind, name) = (scalar.xml_name(), escape(name));
    let _ = write!(text, "<DataArray type=\"{kind}\"");
    if !name.is_empty() {
        let _ = write!(text, " Name=\"{name}\"");
    }
    if components != 1 {
        let _ = write!(text, " NumberOfComponents=\"{components}\"");
    }
    text.push_str(" format=\"binary\"");
    if low <= high {
        let _ = write!(text, " RangeMin=\"{low}\" RangeMax=\"{high}\"");
    }
    text.push('>');
    STANDARD.encode_string(&bytes, text);
    text.push_str("</DataArray>");
}
