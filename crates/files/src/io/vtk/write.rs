//! Writes VTK legacy poly data with vtkio.

use vtkio::IOBuffer;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, DataArray, DataSet, ElementType, FieldArray, PolyDataPiece,
    Version, VertexNumbers, Vtk,
};

use super::super::{Contents, Format, IoError, Precision, WriteOptions, Written, rounded};
use super::arrays::Array;
use super::scalar::Scalar;
use super::write_data::arrays;
use isomend_core::mesh::Mesh;
use isomend_core::mesh::attributes::Active;

const TITLE: &str = "written by isomend";

/// Writes a legacy file of version 3, which every version of VTK reads.
pub(in super::super) fn write_legacy(
    model: &Contents<'_>,
    options: &WriteOptions,
) -> Result<Written, IoError> {
    let mesh = model.mesh;
    let too_large = || refuse("the mesh has more faces than 32-bit counts can name".to_string());
    let num_cells = u32::try_from(mesh.faces.len())
        .ok()
        .filter(|n| *n < u32::MAX / 4)
        .ok_or_else(too_large)?;
    let (points, mut notes) = points(mesh, options)?;
    let ([point, cell], lost) = arrays(model, Format::Vtk);
    notes.extend(lost);
    let vertices = mesh
        .faces
        .iter()
        .flat_map(|[a, b, c]| [3, *a, *b, *c])
        .collect();
    let mut data = Attributes::new();
    (data.point, data.cell) = (items(point), items(cell));
    let piece = PolyDataPiece {
        points,
        polys: Some(VertexNumbers::Legacy {
            num_cells,
            vertices,
        }),
        data,
        ..PolyDataPiece::default()
    };
    let vtk = Vtk {
        version: Version::new_legacy(3, 0),
        byte_order: ByteOrder::BigEndian,
        title: TITLE.to_string(),
        file_path: None,
        data: DataSet::inline(piece),
    };
    let bytes = if options.ascii {
        let mut text = String::new();
        vtk.write_legacy_ascii(&mut text)
            .map(|()| text.into_bytes())
    } else {
        let mut bytes = Vec::new();
        vtk.write_legacy(&mut bytes).map(|()| bytes)
    };
    match bytes {
        Ok(bytes) => Ok(Written { bytes, notes }),
        Err(error) => Err(refuse(error.to_string())),
    }
}

fn points(mesh: &Mesh, options: &WriteOptions) -> Result<(IOBuffer, Vec<String>), IoError> {
    Ok(match options.precision {
        Precision::F32 => {
            let (points, notes) = rounded(mesh, Format::Vtk)?;
            (IOBuffer::F32(points.into_flattened()), notes)
        }
        Precision::F64 => (
            IOBuffer::F64(mesh.positions.iter().flat_map(|p| p.to_array()).collect()),
            Vec::new(),
        ),
    })
}

/// The arrays as data of vtkio. Legacy files hold plain arrays only in a field.
fn items(arrays: Vec<Array>) -> Vec<Attribute> {
    let (mut items, mut field) = (Vec::new(), Vec::new());
    for array in arrays {
        let name = encoded(&array.name);
        let components = array.components as u32;
        let data = buffer(array.scalar, array.values);
        let elem = match array.use_ {
            Active::Plain => {
                field.push(FieldArray {
                    name,
                    elem: components,
                    data,
                });
                continue;
            }
            Active::Scalars => ElementType::Scalars {
                num_comp: components,
                lookup_table: None,
            },
            Active::Vectors => ElementType::Vectors,
            Active::Normals => ElementType::Normals,
            Active::TextureCoordinates => ElementType::TCoords(components),
            Active::Tensors => ElementType::Tensors,
        };
        items.push(Attribute::DataArray(DataArray { name, elem, data }));
    }
    if !field.is_empty() {
        items.push(Attribute::Field {
            name: "FieldData".to_owned(),
            data_array: field,
        });
    }
    items
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

/// The values of an array in its type.
fn buffer(scalar: Scalar, values: Vec<f64>) -> IOBuffer {
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
        Scalar::F64 => IOBuffer::F64(values),
    }
}

fn refuse(what: String) -> IoError {
    IoError::NotWritable {
        format: Format::Vtk,
        what,
        advice: "write PLY instead",
    }
}
