//! Tests of VTK volumes: VTI in every encoding and legacy structured points.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;

use super::super::{IoError, Precision, read_volume_bytes, volume_to_bytes};
use isomend_core::grid::Volume;

fn sample() -> Volume {
    let dims = [3, 4, 5];
    Volume {
        dims,
        origin: DVec3::new(0.1, -1e6 / 3.0, 1e-9),
        spacing: DVec3::new(1.0 / 3.0, 0.7, 1e-5),
        values: (0..60).map(|i| f64::from(i).sqrt() - 3.5).collect(),
    }
}

fn read(bytes: &[u8]) -> Volume {
    read_volume_bytes(bytes, None).unwrap()
}

fn refusal(bytes: &[u8]) -> String {
    read_volume_bytes(bytes, None).unwrap_err().to_string()
}

#[test]
fn written_volumes_come_back() {
    let volume = sample();
    let exact = volume_to_bytes(&volume, "distance", Precision::F64).unwrap();
    assert_eq!(read(&exact), volume);
    let single = read(&volume_to_bytes(&volume, "distance", Precision::F32).unwrap());
    assert_eq!(
        (single.origin, single.spacing),
        (volume.origin, volume.spacing)
    );
    for (a, b) in single.values.iter().zip(&volume.values) {
        assert_eq!(*a, f64::from(*b as f32));
    }
    // More than one compressed block; the last block is full.
    let large = Volume {
        dims: [64, 64, 64],
        values: (0..1 << 18).map(|i| f64::from(i % 977)).collect(),
        ..volume
    };
    assert_eq!(
        read(&volume_to_bytes(&large, "d", Precision::F64).unwrap()),
        large
    );
}

#[test]
fn what_cannot_be_written_is_refused() {
    let mut volume = sample();
    volume.values[7] = 1e300;
    assert!(volume_to_bytes(&volume, "d", Precision::F64).is_ok());
    let error = volume_to_bytes(&volume, "d", Precision::F32).unwrap_err();
    assert!(error.to_string().contains("node 7"), "{error}");
    volume.values.pop();
    assert!(volume_to_bytes(&volume, "d", Precision::F64).is_err());
}

/// A file of 2 × 2 × 2 nodes with the given arrays and appended data.
fn vti(head: &str, arrays: &str, tail: &[u8]) -> Vec<u8> {
    let text = format!(
        "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\" {head}>\n<ImageData WholeExtent=\"2 3 0 1 -1 0\" \
         Origin=\"1 2 3\" Spacing=\"0.5 1 2\">\n<Piece Extent=\"2 3 0 1 -1 0\">\n<PointData>\n{arrays}\n</PointData>\n\
         </Piece>\n</ImageData>\n"
    );
    [text.as_bytes(), tail, b"</VTKFile>"].concat()
}

const ASCII: &str =
    "<DataArray type=\"Int16\" Name=\"a\" format=\"ascii\">0 1 2 3 4 5 6 -7</DataArray>";

fn assert_eight(bytes: &[u8]) {
    let volume = read(bytes);
    assert_eq!(volume.dims, [2, 2, 2]);
    assert_eq!(
        volume.origin,
        DVec3::new(2.0, 2.0, 1.0),
        "of the first node of the extent"
    );
    assert_eq!(volume.values, [0., 1., 2., 3., 4., 5., 6., -7.]);
    assert_eq!(volume.at([1, 0, 1]), 5.0);
}

#[test]
fn text_base64_and_raw_data_are_read() {
    assert_eight(&vti("", ASCII, b""));
    let values: Vec<u8> = [0f32, 1., 2., 3., 4., 5., 6., -7.]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let sized = [&32u32.to_le_bytes()[..], &values].concat();
    let inline = format!(
        "<DataArray type=\"Float32\" Name=\"a\" format=\"binary\">{}</DataArray>",
        STANDARD.encode(&sized)
    );
    assert_eight(&vti("", &inline, b""));
    let appended = "<DataArray type=\"Float32\" Name=\"a\" format=\"appended\" offset=\"0\"/>";
    let raw = [
        b"<AppendedData encoding=\"raw\">_",
        &sized[..],
        b"</AppendedData>",
    ]
    .concat();
    assert_eight(&vti("", appended, &raw));
    let block = lz4_flex::block::compress(&values);
    let head = [1u32, 32, 0, block.len() as u32]
        .map(u32::to_le_bytes)
        .concat();
    let packed = [
        b"<AppendedData encoding=\"raw\">_",
        &head[..],
        &block,
        b"</AppendedData>",
    ]
    .concat();
    assert_eight(&vti(
        "compressor=\"vtkLZ4DataCompressor\"",
        appended,
        &packed,
    ));
}

#[test]
fn an_array_is_named_where_there_are_several() {
    let vector = "<DataArray type=\"Int8\" Name=\"v\" NumberOfComponents=\"3\">0</DataArray>";
    assert_eight(&vti("", &format!("{vector}{ASCII}"), b""));
    let other = ASCII.replace("\"a\"", "\"b\"").replace("-7", "9");
    let two = vti("", &format!("{ASCII}{other}"), b"");
    assert!(refusal(&two).contains("'a', 'b'"), "{}", refusal(&two));
    assert_eq!(read_volume_bytes(&two, Some("b")).unwrap().values[7], 9.0);
    let error = read_volume_bytes(&two, Some("c")).unwrap_err().to_string();
    assert!(error.contains("'c'") && error.contains("VTI"), "{error}");
    let cells = String::from_utf8(vti("", ASCII, b"")).unwrap();
    assert!(refusal(cells.replace("PointData", "CellData").as_bytes()).contains("cells"));
}

#[test]
fn pieces_are_put_together() {
    let piece = |extent: &str, values: &str| {
        format!(
            "<Piece Extent=\"{extent}\"><PointData><DataArray type=\"Float64\" Name=\"a\">{values}</DataArray>\
             </PointData></Piece>"
        )
    };
    let file = |pieces: &str| {
        format!(
            "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 2 0 1 0 0\">{pieces}</ImageData></VTKFile>"
        )
    };
    let (left, right) = (
        piece("0 1 0 1 0 0", "0 1 3 4"),
        piece("1 2 0 1 0 0", "1 2 4 5"),
    );
    assert_eq!(
        read(file(&(left.clone() + &right)).as_bytes()).values,
        [0., 1., 2., 3., 4., 5.]
    );
    assert!(refusal(file(&left).as_bytes()).contains("only 4 values"));
    let twice = left.clone() + &left;
    assert!(refusal(file(&twice).as_bytes()).contains("node 2"));
    let outside = piece("2 3 0 1 0 0", "1 2 4 5");
    assert!(refusal(file(&(left + &outside)).as_bytes()).contains("outside"));
}

#[test]
fn legacy_volumes_are_read() {
    let head = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n\
                ORIGIN 2 2 1\nSPACING 0.5 1 2\nPOINT_DATA 8\n";
    let scalars = "SCALARS a float 1\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 -7\n";
    assert_eight(format!("{head}{scalars}").as_bytes());
    assert_eight(format!("{head}FIELD f 1\na 1 8 double\n0 1 2 3 4 5 6 -7\n").as_bytes());
    let both = format!("{head}{scalars}{}", scalars.replace(" a ", " b "));
    assert!(refusal(both.as_bytes()).contains("'a', 'b'"));
    let mut binary = format!("{head}SCALARS a float\nLOOKUP_TABLE default\n")
        .replace("ASCII", "BINARY")
        .into_bytes();
    binary.extend(
        [0f32, 1., 2., 3., 4., 5., 6., -7.]
            .iter()
            .flat_map(|v| v.to_be_bytes()),
    );
    assert_eight(&binary);
    let claim = format!("{head}{scalars}").replace("2 2 2", "99999 99999 99999");
    assert!(
        refusal(claim.as_bytes()).contains("room"),
        "{}",
        refusal(claim.as_bytes())
    );
    assert!(
        refusal(b"# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\n").contains("POLYDATA")
    );
}

#[test]
fn damage_is_named_or_survived() {
    let text = String::from_utf8(vti("", ASCII, b"")).unwrap();
    let edited = |from: &str, to: &str| refusal(text.replace(from, to).as_bytes());
    assert!(edited("2 3 0 1 -1 0", "2 3 0 1").contains("six numbers"));
    assert!(edited("2 3 0 1 -1 0", "3 2 0 1 -1 0").contains("no nodes"));
    assert!(edited("2 3 0 1 -1 0", "0 2000000000 0 2000000000 0 2000000000").contains("nodes"));
    assert!(edited("Spacing=\"0.5", "Spacing=\"-0.5").contains("spacing"));
    for spacing in ["1e160", "1e-160"] {
        let to = format!("Spacing=\"{spacing}");
        assert!(edited("Spacing=\"0.5", &to).contains("to measure"));
    }
    assert!(edited(" -7", "").contains("8 numbers are declared, but there are 7"));
    assert!(edited("Spacing", "Direction=\"0 1 0 1 0 0 0 0 1\" Spacing").contains("rotated"));
    assert!(edited("type=\"ImageData\"", "type=\"PolyData\"").contains("PolyData"));
    let written = volume_to_bytes(&sample(), "d", Precision::F32).unwrap();
    for bytes in [text.as_bytes(), &written] {
        for length in 0..bytes.len() {
            let _: Result<Volume, IoError> = read_volume_bytes(&bytes[..length], None);
        }
        for at in 0..bytes.len() {
            for value in [0u8, 0x7f, 0xff, b'-', b'9'] {
                let mut damaged = bytes.to_vec();
                damaged[at] = value;
                let _: Result<Volume, IoError> = read_volume_bytes(&damaged, None);
            }
        }
    }
}
