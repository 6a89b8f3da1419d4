//! Tests of VTK point and cell data.

use super::super::samples::*;
use super::super::{Contents, Format, Loaded, Precision, WriteOptions, model_to_bytes};
use super::tests::legacy;
use isomend_core::mesh::attributes::{Active, Attribute, Role, Scalar};

/// A square of two triangles, a strip and a line, with arrays of all kinds.
const DRESSED: &str = "LINES 1 3\n2 0 1\nPOLYGONS 1 5\n4 0 1 2 3\nTRIANGLE_STRIPS 1 5\n4 0 1 3 2\n\
    POINT_DATA 4\nSCALARS heat%20flow double\nLOOKUP_TABLE default\n0.1 0.2 0.3 0.4\n\
    SCALARS second int 1\nLOOKUP_TABLE default\n1 2 3 4\n\
    NORMALS Normals float\n0 0 1 0 0 1 0 0 1 0 0 1\n\
    TEXTURE_COORDINATES uv 2 float\n0 0 1 0 1 1 0 1\n\
    FIELD FieldData 2\nRGB 3 4 unsigned_char\n1 2 3 4 5 6 7 8 9 10 11 12\nMETADATA\nINFORMATION 0\n\n\
    ids 1 4 vtktypeint64\n9 8 7 -6\n\
    CELL_DATA 3\nVECTORS flow float\n9 9 9 1 2 3 4 5 6\nCOLOR_SCALARS paint 3\n0 0 0 1 0.5 0 0 0 1\n";

fn listed(all: &[Attribute]) -> Vec<(&str, Role, Scalar, usize, Option<Active>)> {
    all.iter()
        .map(|a| (&a.name[..], a.role, a.scalar, a.components, a.active))
        .collect()
}

fn assert_dressed(loaded: &Loaded) {
    let all = &loaded.attributes;
    assert_eq!(
        listed(&all.vertex)
            .iter()
            .map(|a| a.0)
            .collect::<std::collections::BTreeSet<_>>(),
        ["heat flow", "second", "Normals", "uv", "RGB", "ids"].into(),
    );
    let find =
        |list: &[Attribute], name: &str| list.iter().find(|a| a.name == name).unwrap().clone();
    let point = |name: &str| find(&all.vertex, name);
    assert_eq!(point("heat flow").values, [0.1, 0.2, 0.3, 0.4]);
    assert_eq!(point("heat flow").active, Some(Active::Scalars));
    assert_eq!(
        (point("second").scalar, point("second").active),
        (Scalar::I32, Some(Active::Plain))
    );
    assert_eq!(point("Normals").role, Role::Normal);
    assert_eq!(
        (point("uv").role, point("uv").values[4]),
        (Role::Uv(0), 1.0)
    );
    assert_eq!(
        (point("RGB").role, point("RGB").get(3)),
        (Role::Colour, Some(&[10., 11., 12.][..]))
    );
    assert_eq!(
        (point("ids").scalar, point("ids").values[3]),
        (Scalar::I64, -6.0)
    );
    // The line gives no face; the quad gives two, and so does the strip.
    let flow = find(&all.face, "flow");
    assert_eq!(
        flow.values,
        [1., 2., 3., 1., 2., 3., 4., 5., 6., 4., 5., 6.]
    );
    assert_eq!(flow.active, Some(Active::Vectors));
    let paint = find(&all.face, "paint");
    assert_eq!(
        paint.values,
        [255., 128., 0., 255., 128., 0., 0., 0., 255., 0., 0., 255.]
    );
}

#[test]
fn arrays_of_points_and_cells_go_through() {
    let loaded = read_alone(&legacy(DRESSED), Format::Vtk).unwrap();
    assert_eq!(loaded.mesh.faces.len(), 4);
    assert_dressed(&loaded);
    let model = Contents {
        mesh: &loaded.mesh,
        attributes: &loaded.attributes,
        document: None,
    };
    for (format, ascii) in [
        (Format::Vtk, true),
        (Format::Vtk, false),
        (Format::Vtp, false),
    ] {
        let options = WriteOptions {
            ascii,
            precision: Precision::F32,
        };
        let written = model_to_bytes(&model, format, &options).unwrap();
        assert_eq!(written.notes, Vec::<String>::new());
        let again = read_alone(&written.bytes, format).unwrap();
        assert_dressed(&again);
        assert_eq!(again.notes, Vec::<String>::new());
    }
}

#[test]
fn arrays_of_pieces_are_joined_and_what_cannot_be_read_is_named() {
    let piece = |point: &str, cell: &str| {
        format!(
            "<Piece NumberOfPoints=\"3\" NumberOfVerts=\"1\" NumberOfPolys=\"1\">\
             <PointData Scalars=\"a &amp; b\">{point}</PointData><CellData>{cell}</CellData>\
             <Points><DataArray type=\"Float32\" NumberOfComponents=\"3\">0 0 0 1 0 0 0 1 0</DataArray></Points>\
             <Polys><DataArray type=\"Int32\" Name=\"connectivity\">0 1 2</DataArray>\
             <DataArray type=\"Int32\" Name=\"offsets\">3</DataArray></Polys></Piece>"
        )
    };
    let array = |kind: &str, name: &str, values: &str| {
        format!("<DataArray type=\"{kind}\" Name=\"{name}\">{values}</DataArray>")
    };
    let a = array("Float64", "a &amp; b", "1 nan 3");
    let b = array("Float64", "a &amp; b", "4 5 6");
    let words = array("String", "words", "97 0");
    let short = array("Int8", "short", "1 2");
    let (c, d) = (
        array("UInt16", "scan", "7 8"),
        array("UInt16", "scan", "9 10"),
    );
    let text = format!(
        "<VTKFile type=\"PolyData\"><PolyData>{}{}</PolyData></VTKFile>",
        piece(&(a + &words + &short), &c),
        piece(&b, &(d + &array("Int8", "lonely", "1 2"))),
    );
    let loaded = read_alone(text.as_bytes(), Format::Vtp).unwrap();
    let all = &loaded.attributes;
    let scalars = ("a & b", Role::Other, Scalar::F64, 1, Some(Active::Scalars));
    assert_eq!(listed(&all.vertex), [scalars]);
    assert!(all.vertex[0].values[1].is_nan());
    assert_eq!(all.vertex[0].values[3..], [4.0, 5.0, 6.0]);
    // The first cell of each piece is a point.
    assert_eq!(
        (all.face.len(), &all.face[0].values[..]),
        (1, &[8.0, 10.0][..])
    );
    let notes = loaded.notes.join("\n");
    for name in ["'words'", "'short'", "'lonely'"] {
        assert!(notes.contains(name), "{notes}");
    }
}

#[test]
fn legacy_data_that_cannot_be_read_costs_the_data_only() {
    let read = |rest: &str| {
        read_alone(
            &legacy(&format!("POLYGONS 1 4\n3 0 1 2\n{rest}")),
            Format::Vtk,
        )
        .unwrap()
    };
    for (rest, kept, said) in [
        (
            "POINT_DATA 4\nSCALARS a int\nLOOKUP_TABLE default\n1 2 3",
            0,
            "room for 3",
        ),
        (
            "POINT_DATA 3\nSCALARS a int\nLOOKUP_TABLE default\n1 2 3",
            0,
            "3 points, not 4",
        ),
        (
            "POINT_DATA 4\nSCALARS a int\n1 2 3 4\nSOMETHING x",
            1,
            "SOMETHING",
        ),
        (
            "POINT_DATA 4\nFIELD f 2\na 1 4 int\n1 2 3 4\nb 1 1 string\nx",
            1,
            "'string'",
        ),
        (
            "POINT_DATA 99999999999\nNORMALS n float\n1 2 3",
            0,
            "claimed",
        ),
    ] {
        let loaded = read(rest);
        assert_eq!(loaded.attributes.vertex.len(), kept, "{rest}");
        assert!(loaded.notes.join("\n").contains(said), "{:?}", loaded.notes);
    }
}
