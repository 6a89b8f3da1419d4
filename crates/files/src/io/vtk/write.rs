//! Writes VTK legacy and XML poly data (VTP) with vtkio.

use vtkio::IOBuffer;
use vtkio::model::{Attributes, ByteOrder, DataSet, PolyDataPiece, Version, VertexNumbers, Vtk};

use super::super::{Contents, Format, IoError, Precision, WriteOptions, Written, rounded};
use super::write_data::data;
use isomend_core::mesh::Mesh;

const TITLE: &str = "written by isomend";

/// Writes a legacy file of version 3, which every version of VTK reads.
pub(in super::super) fn write_legacy(
    model: &Contents<'_>,
    options: &WriteOptions,
) -> Result<Written, IoError> {
    let mesh = model.mesh;
    let too_large = || {
        refuse(
            Format::Vtk,
            "the mesh has more faces than 32-bit counts can name".to_string(),
        )
    };
    let num_cells = u32::try_from(mesh.faces.len())
        .ok()
        .filter(|n| *n < u32::MAX / 4)
        .ok_or_else(too_large)?;
    let (points, mut notes) = points(mesh, options, Format::Vtk)?;
    let (data, lost) = data(model, Format::Vtk);
    notes.extend(lost);
    let vertices = mesh
        .faces
        .iter()
        .flat_map(|[a, b, c]| [3, *a, *b, *c])
        .collect();
    let polys = VertexNumbers::Legacy {
        num_cells,
        vertices,
    };
    let vtk = file(
        Version::new_legacy(3, 0),
        ByteOrder::BigEndian,
        points,
        polys,
        data,
    );
    let bytes = if options.ascii {
        let mut text = String::new();
        vtk.write_legacy_ascii(&mut text)
            .map(|()| text.into_bytes())
    } else {
        let mut bytes = Vec::new();
        vtk.write_legacy(&mut bytes).map(|()| bytes)
    };
    finish(bytes, notes, Format::Vtk)
}

/// Writes a VTP file with base64 arrays.
pub(in super::super) fn write_xml(
    model: &Contents<'_>,
    options: &WriteOptions,
) -> Result<Written, IoError> {
    let mesh = model.mesh;
    let (points, mut notes) = points(mesh, options, Format::Vtp)?;
    let (data, lost) = data(model, Format::Vtp);
    notes.extend(lost);
    let polys = VertexNumbers::XML {
        connectivity: mesh.faces.iter().flatten().map(|i| u64::from(*i)).collect(),
        offsets: (1..=mesh.faces.len() as u64).map(|i| 3 * i).collect(),
    };
    let vtk = file(
        Version::new_xml(1, 0),
        ByteOrder::LittleEndian,
        points,
        polys,
        data,
    );
    let mut bytes = Vec::new();
    let done = vtk.write_xml(&mut bytes).map(|()| bytes);
    finish(done, notes, Format::Vtp)
}

fn points(
    mesh: &Mesh,
    options: &WriteOptions,
    format: Format,
) -> Result<(IOBuffer, Vec<String>), IoError> {
    Ok(match options.precision {
        Precision::F32 => {
            let (points, notes) = rounded(mesh, format)?;
            (IOBuffer::F32(points.into_flattened()), notes)
        }
        Precision::F64 => (
            IOBuffer::F64(mesh.positions.iter().flat_map(|p| p.to_array()).collect()),
            Vec::new(),
        ),
    })
}

fn file(
    version: Version,
    byte_order: ByteOrder,
    points: IOBuffer,
    polys: VertexNumbers,
    data: Attributes,
) -> Vtk {
    let piece = PolyDataPiece {
        points,
        polys: Some(polys),
        data,
        ..PolyDataPiece::default()
    };
    Vtk {
        version,
        byte_order,
        title: TITLE.to_string(),
        file_path: None,
        data: DataSet::inline(piece),
    }
}

fn finish(
    bytes: Result<Vec<u8>, vtkio::Error>,
    notes: Vec<String>,
    format: Format,
) -> Result<Written, IoError> {
    match bytes {
        Ok(bytes) => Ok(Written { bytes, notes }),
        Err(error) => Err(refuse(format, error.to_string())),
    }
}

fn refuse(format: Format, what: String) -> IoError {
    IoError::NotWritable {
        format,
        what,
        advice: "write PLY instead",
    }
}
