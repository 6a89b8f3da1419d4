//! Packages: what is written is read again, and what other programs write.

use std::io::{Cursor, Write};

use glam::DVec3;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::super::samples::*;
use super::super::{Contents, WriteOptions, model_to_bytes};
use super::*;
use crate::mesh::attributes::{LabelKind, PATCH_NAME, Role};
use crate::mesh::{Attributes, Mesh, Unit};

/// A package of parts.
fn package(parts: &[(&str, &str)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    for (name, text) in parts {
        zip.start_file(*name, options).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// A model with its resources and its build.
fn model(unit: &str, resources: &str, build: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?><model unit=\"{unit}\" xmlns=\"c\" xmlns:m=\"m\" xmlns:p=\"p\"><resources>{resources}</resources>\
         <build>{build}</build></model>"
    )
}

/// An object of one triangle.
fn triangle(id: u32, more: &str) -> String {
    format!(
        "<object id=\"{id}\" name=\"o{id}\" type=\"model\"{more}><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" \
         z=\"0\"/><vertex x=\"0\" y=\"1\" z=\"0\"/></vertices><triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\"/></triangles></mesh></object>"
    )
}

fn alone(text: &str) -> Vec<u8> {
    package(&[("3D/3dmodel.model", text)])
}

#[test]
fn round_trip_is_exact_and_damage_is_survived() {
    for mesh in [open_tetrahedron(), fine_tetrahedron()] {
        let attributes = Attributes {
            unit: Some(Unit::Inch),
            ..Attributes::default()
        };
        let contents = Contents {
            mesh: &mesh,
            attributes: &attributes,
            document: None,
        };
        let written = model_to_bytes(&contents, Format::ThreeMf, &WriteOptions::default()).unwrap();
        assert_eq!(written.notes, Vec::<String>::new());
        let loaded = read_alone(&written.bytes, Format::ThreeMf).unwrap();
        assert_eq!(loaded.mesh, mesh);
        assert_eq!(loaded.attributes.unit, Some(Unit::Inch));
        let again = model_to_bytes(&contents, Format::ThreeMf, &WriteOptions::default());
        assert_eq!(again.unwrap().bytes, written.bytes);
        assert!(is_package(&written.bytes));
        if mesh == open_tetrahedron() {
            assert_survives_damage(&written.bytes, Format::ThreeMf);
        }
    }
}

#[test]
fn objects_are_put_where_transforms_say_in_the_unit_of_the_model() {
    let resources = triangle(1, "")
        + &triangle(2, "")
        + "<object id=\"3\"><components><component objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 10 0 0\"/>\
           <component objectid=\"2\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 0\"/></components></object>";
    let build =
        "<item objectid=\"3\" transform=\"2 0 0 0 2 0 0 0 2 0 0 5\"/><item objectid=\"1\"/>";
    let loaded = read_alone(&alone(&model("inch", &resources, build)), Format::ThreeMf).unwrap();
    let at = |f: usize| loaded.mesh.corners(f as u32);
    assert_eq!(at(0)[1], DVec3::new(22.0, 0.0, 5.0));
    // The mirrored one is turned, so that its front stays its front.
    let [a, b, c] = at(1);
    assert!((b - a).cross(c - a).z > 0.0);
    assert_eq!(at(2)[1], DVec3::X);
    assert_eq!(loaded.attributes.unit, Some(Unit::Inch));
    let names = loaded.attributes.labels_of(LabelKind::Object).unwrap();
    assert_eq!(names.names, ["object_3", "o1"]);
}

#[test]
fn parts_of_other_models_come_in_their_own_unit() {
    let inner = model("centimeter", &triangle(7, ""), "");
    let resources = "<object id=\"1\"><components><component p:path=\"/3D/Objects/a.model\" objectid=\"7\" \
                     transform=\"1 0 0 0 1 0 0 0 1 3 0 0\"/></components></object>";
    let main = model("millimeter", resources, "<item objectid=\"1\"/>");
    let rels = "<Relationships><Relationship Target=\"/3D/main.model\" Id=\"r\" \
                Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
    let bytes = package(&[
        ("_rels/.rels", rels),
        ("3D/main.model", &main),
        ("3D/Objects/a.model", &inner),
    ]);
    let loaded = read_alone(&bytes, Format::ThreeMf).unwrap();
    assert_eq!(loaded.mesh.corners(0)[1], DVec3::new(13.0, 0.0, 0.0));
}

#[test]
fn colours_and_materials_come_back() {
    let resources = "<m:colorgroup id=\"5\"><m:color color=\"#FF0000\"/><m:color color=\"#00FF0080\"/></m:colorgroup>".to_owned()
        + &triangle(1, " pid=\"5\" pindex=\"1\"");
    let bytes = alone(&model("meter", &resources, "<item objectid=\"1\"/>"));
    let loaded = read_alone(&bytes, Format::ThreeMf).unwrap();
    let colours = &loaded.attributes.corner[0];
    assert_eq!(colours.get(0, 2), Some(&[0.0, 255.0, 0.0, 128.0][..]));
    let written = model_to_bytes(
        &Contents {
            mesh: &loaded.mesh,
            attributes: &loaded.attributes,
            document: None,
        },
        Format::ThreeMf,
        &WriteOptions::default(),
    );
    let again = read_alone(&written.unwrap().bytes, Format::ThreeMf).unwrap();
    assert_eq!(again.attributes.corner[0].get(0, 2), colours.get(0, 2));
    let resources = "<basematerials id=\"4\"><base name=\"red &amp; dead\" displaycolor=\"#FF0000\"/></basematerials>".to_owned()
        + &triangle(1, " pid=\"4\" pindex=\"0\"");
    let bytes = alone(&model("micron", &resources, "<item objectid=\"1\"/>"));
    let loaded = read_alone(&bytes, Format::ThreeMf).unwrap();
    assert_eq!(loaded.attributes.materials[0].name, "red & dead");
    assert!(loaded.attributes.vertex_role(Role::Colour).is_none());
}

#[test]
fn patches_are_marked() {
    let mesh = open_tetrahedron();
    let mut marks = crate::mesh::attributes::Attribute::new(
        PATCH_NAME,
        Role::Other,
        crate::mesh::attributes::Scalar::U8,
        1,
    );
    [0.0, 1.0, 1.0]
        .iter()
        .for_each(|mark| marks.push(Some(&[*mark])));
    let attributes = Attributes {
        face: vec![marks],
        unit: Some(Unit::Millimetre),
        ..Attributes::default()
    };
    let contents = Contents {
        mesh: &mesh,
        attributes: &attributes,
        document: None,
    };
    let written = model_to_bytes(&contents, Format::ThreeMf, &WriteOptions::default()).unwrap();
    let loaded = read_alone(&written.bytes, Format::ThreeMf).unwrap();
    let is_patch = [0, 1, 2].map(|f| loaded.attributes.is_patch(f));
    assert_eq!(is_patch, [false, true, true]);
    let materials = loaded.attributes.labels_of(LabelKind::Material).unwrap();
    assert_eq!(materials.get(2), Some(PATCH_NAME));
}

#[test]
fn bombs_and_loops_are_refused() {
    let long = " ".repeat(70 << 20);
    let text = model("inch", &(triangle(1, "") + &long), "<item objectid=\"1\"/>");
    let message = refusal(&alone(&text), Format::ThreeMf);
    assert!(message.contains("larger unpacked"), "{message}");
    let own = "<object id=\"1\"><components><component objectid=\"1\"/></components></object>";
    let message = refusal(
        &alone(&model("inch", own, "<item objectid=\"1\"/>")),
        Format::ThreeMf,
    );
    assert!(message.contains("lie in each other"), "{message}");
    // Each object is twice the one before it.
    let mut resources = triangle(1, "");
    for id in 2..30 {
        let inner = format!("<component objectid=\"{}\"/>", id - 1).repeat(2);
        resources += &format!("<object id=\"{id}\"><components>{inner}</components></object>");
    }
    let text = model("inch", &resources, "<item objectid=\"29\"/>");
    let message = refusal(&alone(&text), Format::ThreeMf);
    assert!(message.contains("uses objects more than"), "{message}");
}

#[test]
fn what_is_wrong_is_said() {
    let item = "<item objectid=\"1\"/>";
    let bad_vertex = triangle(1, "").replace("v3=\"2\"", "v3=\"9\"");
    let bad_number = triangle(1, "").replace("x=\"1\"", "x=\"one\"");
    for (text, said) in [
        (model("parsec", &triangle(1, ""), item), "no unit 'parsec'"),
        (model("inch", &bad_vertex, item), "uses vertex 9"),
        (model("inch", &bad_number, item), "'one' is no coordinate"),
        (
            model("inch", &triangle(1, ""), "<item objectid=\"4\"/>"),
            "no object 4",
        ),
        (model("inch", "", ""), "no faces"),
        ("<x/>".to_owned(), "no model element"),
        ("<model".to_owned(), "XML is damaged"),
    ] {
        let message = refusal(&alone(&text), Format::ThreeMf);
        assert!(message.contains(said), "{message}");
    }
    let message = refusal(&package(&[("a.txt", "b")]), Format::ThreeMf);
    assert!(message.contains("no part '3d/3dmodel.model'"), "{message}");
    assert!(refusal(b"PK\x03\x04 no archive", Format::ThreeMf).contains("ZIP archive is damaged"));
    assert_eq!(Mesh::default().faces.len(), 0);
}
