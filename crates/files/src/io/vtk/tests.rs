//! Tests of VTK surfaces: legacy files and every layout of XML arrays.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use lzma_rust2::XzOptions;

use super::super::samples::*;
use super::super::{Format, Precision, WriteOptions};

const POINTS: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];

fn faces(bytes: &[u8], format: Format) -> Vec<[u32; 3]> {
    let loaded = read_alone(bytes, format).unwrap();
    assert_eq!(loaded.mesh.positions[2].to_array(), [1.0, 1.0, 0.0]);
    loaded.mesh.faces
}

pub(super) fn legacy(rest: &str) -> Vec<u8> {
    format!(
        "# vtk DataFile Version 3.0\ntitle\nASCII\n\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0\n1 1 0 0 1 0\n{rest}"
    )
    .into_bytes()
}

#[test]
fn round_trip_is_exact() {
    for ascii in [false, true] {
        for format in [Format::Vtk, Format::Vtp] {
            assert_round_trip(
                &open_tetrahedron(),
                format,
                WriteOptions {
                    ascii,
                    precision: Precision::F32,
                },
            );
            assert_round_trip(
                &fine_tetrahedron(),
                format,
                WriteOptions {
                    ascii,
                    precision: Precision::F64,
                },
            );
        }
    }
}

#[test]
fn legacy_polygons_and_strips() {
    let text = "VERTICES 1 2\n1 0\nPOLYGONS 2 9\n4 0 1 2 3\n3 0 1 2\nTRIANGLE_STRIPS 1 5\n4 0 1 3 2\nPOINT_DATA 4\nanything";
    let expected = [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 1, 3], [3, 1, 2]];
    let loaded = read_alone(&legacy(text), Format::Vtk).unwrap();
    assert_eq!(loaded.mesh.faces, expected);
    assert_eq!(loaded.notes.len(), 3);
    assert!(loaded.notes.iter().any(|note| note.contains("'anything'")));
}

#[test]
fn legacy_fields_and_metadata_are_passed_over() {
    let text = "METADATA\nINFORMATION 1\nNAME x LOCATION y\n\nFIELD f 2\na 2 2 double\n1 2 3 4\nb 1 1 int\n7\nPOLYGONS 1 4\n3 0 1 2\n";
    assert_eq!(faces(&legacy(text), Format::Vtk), [[0, 1, 2]]);
}

#[test]
fn legacy_version_5_stores_offsets() {
    let text = String::from_utf8(legacy(
        "POLYGONS 3 7\nOFFSETS vtktypeint64\n0 4 7\nCONNECTIVITY vtktypeint64\n0 1 2 3 0 1 2\n",
    ));
    let bytes = text.unwrap().replace("3.0", "5.1").into_bytes();
    assert_eq!(
        faces(&bytes, Format::Vtk),
        [[0, 1, 2], [0, 2, 3], [0, 1, 2]]
    );
}

#[test]
fn legacy_binary_is_big_endian() {
    let mut bytes =
        b"# vtk DataFile Version 2.0\n\nBINARY\nDATASET POLYDATA\nPOINTS 4 float\n".to_vec();
    bytes.extend(POINTS.iter().flat_map(|v| v.to_be_bytes()));
    bytes.extend(b"\nPOLYGONS 1 5\n");
    bytes.extend([4i32, 0, 1, 2, 3].iter().flat_map(|v| v.to_be_bytes()));
    assert_eq!(faces(&bytes, Format::Vtk), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn unstructured_grids_are_read_when_they_hold_only_faces() {
    let grid = |types: &str| {
        let text = legacy(&format!(
            "CELLS 4 17\n3 0 1 2\n4 0 1 2 3\n4 0 1 3 2\n2 0 1\nCELL_TYPES 4\n{types}\n"
        ));
        String::from_utf8(text)
            .unwrap()
            .replace("POLYDATA", "UNSTRUCTURED_GRID")
            .into_bytes()
    };
    let expected = [[0, 1, 2], [0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 2, 3]];
    assert_eq!(faces(&grid("5 9 8 3"), Format::Vtk), expected);
    let message = refusal(&grid("5 10 8 3"), Format::Vtk);
    assert!(
        message.contains("cell 1 is of type 10, a tetrahedron"),
        "{message}"
    );
}

#[test]
fn legacy_faults_are_named() {
    let cases = [
        ("POLYGONS -1 4\n3 0 1 2\n", "line 9: '-1' is not a count"),
        (
            "POLYGONS 1 4000000000\n3 0 1 2\n",
            "4000000000 cell corners are claimed",
        ),
        ("POLYGONS 2 4\n3 0 1 2\n", "polygon 1"),
        (
            "POLYGONS 1 4\n4 0 1 2\n",
            "polygon 0: its corners do not fit",
        ),
        ("POLYGONS 1 4\n3 0 1 -2\n", "polygon 0: it uses point -2"),
        ("POLYGONS 1 4\n3 0 1 4\n", "face 0: it uses vertex 4"),
        ("POLYGONS 1 4\n3 0 1 x\n", "line 10: 'x' is not a number"),
        ("POLYGONS 1 3\n2 0 1\n", "2 corners"),
        ("POINTS 1 quad\n", "'quad' is not a data type"),
        ("POINTS 99999999999999 float\n0 0 0\n", "are claimed"),
        ("WHAT 3\n", "'WHAT' is not a supported section"),
        ("", "no faces"),
    ];
    for (text, expected) in cases {
        let message = refusal(&legacy(text), Format::Vtk);
        assert!(message.contains(expected), "{message}");
    }
    let volume = String::from_utf8(legacy(""))
        .unwrap()
        .replace("POLYDATA", "STRUCTURED_POINTS");
    assert!(refusal(volume.as_bytes(), Format::Vtk).contains("STRUCTURED_POINTS"));
    assert!(refusal(b"# vtk DataFile Version x\n", Format::Vtk).contains("line 1"));
}

/// How the arrays of a test file are stored.
#[derive(Clone, Copy, PartialEq)]
enum Layout {
    Inline,
    AppendedRaw,
    AppendedBase64,
}

/// A square in two pieces: a quad, and a strip with the same points.
fn vtp(layout: Layout, compressor: &str, wide: bool) -> Vec<u8> {
    let mut appended = Vec::new();
    let mut array = |kind: &str, name: &str, data: &[u8]| {
        let packed = pack(data, compressor, wide, layout != Layout::AppendedRaw);
        let (attributes, text) = match layout {
            Layout::Inline => (
                "format=\"binary\"".to_string(),
                String::from_utf8(packed).unwrap(),
            ),
            _ => {
                let offset = appended.len();
                appended.extend(packed);
                (
                    format!("format=\"appended\" offset=\"{offset}\""),
                    String::new(),
                )
            }
        };
        let extra = "<InformationKey name=\"k\"><Value index=\"0\">1</Value></InformationKey>";
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" {attributes}>\n {text}\n{extra}</DataArray>"
        )
    };
    let points: Vec<u8> = POINTS.iter().flat_map(|v| v.to_le_bytes()).collect();
    let corners = |list: [i64; 4]| {
        list.iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let mut pieces = String::new();
    for (section, list) in [("Polys", [0, 1, 2, 3]), ("Strips", [0, 1, 3, 2])] {
        pieces += &format!(
            "<Piece NumberOfPoints=\"4\" NumberOf{section}=\"1\"><Points>{}</Points><{section}>{}{}</{section}></Piece>",
            array("Float32", "Points", &points),
            array("Int64", "connectivity", &corners(list)),
            array("Int32", "offsets", &4i32.to_le_bytes()),
        );
    }
    let width = if wide { "UInt64" } else { "UInt32" };
    let head = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" header_type=\"{width}\" compressor=\"{compressor}\">"
    );
    let mut bytes = format!("{head}<PolyData>{pieces}</PolyData>").into_bytes();
    if layout != Layout::Inline {
        let encoding = if layout == Layout::AppendedRaw {
            "raw"
        } else {
            "base64"
        };
        bytes.extend(format!("<AppendedData encoding=\"{encoding}\">\n_").into_bytes());
        bytes.extend(appended);
        bytes.extend(b"\n</AppendedData>");
    }
    bytes.extend(b"</VTKFile>");
    bytes
}

/// Sizes and data of an array; compressed arrays have blocks of 16 bytes.
fn pack(data: &[u8], compressor: &str, wide: bool, base64: bool) -> Vec<u8> {
    let size = |value: usize| {
        let bytes = (value as u64).to_le_bytes();
        if wide {
            bytes.to_vec()
        } else {
            bytes[..4].to_vec()
        }
    };
    let (mut sizes, mut body) = (Vec::new(), Vec::new());
    if compressor.is_empty() {
        sizes.extend(size(data.len()));
        body.extend_from_slice(data);
    } else {
        sizes.extend(
            [data.len().div_ceil(16), 16, data.len() % 16]
                .into_iter()
                .flat_map(size),
        );
        for block in data.chunks(16) {
            let packed = compress(block, compressor);
            sizes.extend(size(packed.len()));
            body.extend(packed);
        }
    }
    match (base64, compressor.is_empty()) {
        (false, _) => [sizes, body].concat(),
        (true, true) => STANDARD.encode([sizes, body].concat()).into_bytes(),
        (true, false) => [STANDARD.encode(sizes), STANDARD.encode(body)]
            .concat()
            .into_bytes(),
    }
}

fn compress(block: &[u8], compressor: &str) -> Vec<u8> {
    match compressor {
        "vtkZLibDataCompressor" => {
            let mut encoder =
                flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            encoder.write_all(block).unwrap();
            encoder.finish().unwrap()
        }
        "vtkLZ4DataCompressor" => lz4_flex::block::compress(block),
        _ => {
            let mut encoder =
                lzma_rust2::XzWriter::new(Vec::new(), XzOptions::with_preset(6)).unwrap();
            encoder.write_all(block).unwrap();
            encoder.finish().unwrap()
        }
    }
}

const COMPRESSORS: [&str; 4] = [
    "",
    "vtkZLibDataCompressor",
    "vtkLZ4DataCompressor",
    "vtkLZMADataCompressor",
];

#[test]
fn every_layout_of_xml_arrays_is_read() {
    for layout in [Layout::Inline, Layout::AppendedRaw, Layout::AppendedBase64] {
        for compressor in COMPRESSORS {
            for wide in [false, true] {
                let expected = [[0, 1, 2], [0, 2, 3], [4, 5, 7], [7, 5, 6]];
                assert_eq!(faces(&vtp(layout, compressor, wide), Format::Vtp), expected);
            }
        }
    }
}

#[test]
fn xml_text_arrays_are_read() {
    let text = "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"4\" NumberOfPolys=\"1\"><PointData>\
                <DataArray type=\"String\" Name=\"s\" format=\"ascii\">1 x</DataArray></PointData><Points>\
                <DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 1 1 0 0 .1 0</DataArray>\
                </Points><Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray>\
                <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">3</DataArray></Polys></Piece></PolyData></VTKFile>";
    assert_eq!(faces(text.as_bytes(), Format::Vtp), [[0, 1, 2]]);
    let edited = |from: &str, to: &str| refusal(text.replacen(from, to, 1).as_bytes(), Format::Vtp);
    assert!(edited("NumberOfPoints=\"4\"", "NumberOfPoints=\"40\"").contains("claims 40 points"));
    assert!(
        edited("NumberOfPolys=\"1\"", "NumberOfPolys=\"9\"")
            .contains("claims 9 polygons: 9 numbers are declared, but there are 1")
    );
    assert!(edited(">3<", ">4<").contains("4 numbers are declared, but there are 3"));
    assert!(edited(">0 1 2<", ">0 1 -2<").contains("polygon 0: it uses point -2"));
    assert!(edited(">0 1 2<", ">0 1 x<").contains("connectivity: 'x' is not a number"));
    assert!(edited("Float32", "Float16").contains("'Float16' is not known"));
    assert!(edited("ascii\">0 0", "appended\">0 0").contains("nothing is"));
    assert!(edited("<Points>", "<Points <").contains("byte"));
}

#[test]
fn other_kinds_of_xml_data_are_refused_by_name() {
    for kind in ["ImageData", "UnstructuredGrid", "PPolyData"] {
        let message = refusal(
            format!("<VTKFile type=\"{kind}\"></VTKFile>").as_bytes(),
            Format::Vtp,
        );
        assert!(message.contains(kind), "{message}");
    }
    let message = refusal(
        b"<VTKFile type=\"PolyData\" compressor=\"vtkBrotli\"/>",
        Format::Vtp,
    );
    assert!(
        message.contains("VTKFile") || message.contains("vtkBrotli"),
        "{message}"
    );
}

#[test]
fn damage_is_survived() {
    assert_damage_is_survived(Format::Vtk);
    assert_damage_is_survived(Format::Vtp);
    for compressor in COMPRESSORS {
        assert_survives_damage(&vtp(Layout::AppendedRaw, compressor, false), Format::Vtp);
        assert_survives_damage(&vtp(Layout::AppendedBase64, compressor, true), Format::Vtp);
    }
}
