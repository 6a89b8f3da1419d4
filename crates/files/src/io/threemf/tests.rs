//! Tests of 3MF: round trips, packages of other programs, damaged and malicious packages.

use std::collections::BTreeMap;
use std::io::{Cursor, Read, Write};

use glam::DVec3;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::super::samples::*;
use super::super::{Contents, WriteOptions, Written, model_to_bytes};
use super::values::patch_ranges;
use super::*;
use isomend_core::mesh::attributes::{
    Attribute, LabelKind, Labels, NONE, PATCH_NAME, Role, Scalar,
};
use isomend_core::mesh::{Attributes, Mesh, Unit};

/// A package of the given parts: names and texts.
pub(super) fn package(parts: &[(&str, &str)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    for (name, text) in parts {
        zip.start_file(*name, options).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// A model with the given resources and build.
pub(super) fn model(unit: &str, resources: &str, build: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?><model unit=\"{unit}\" xmlns=\"c\" xmlns:m=\"m\" xmlns:p=\"p\"><resources>{resources}</resources>\
         <build>{build}</build></model>"
    )
}

/// An object of one triangle.
pub(super) fn triangle(id: u32, more: &str) -> String {
    format!(
        "<object id=\"{id}\" name=\"o{id}\" type=\"model\"{more}><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" \
         z=\"0\"/><vertex x=\"0\" y=\"1\" z=\"0\"/></vertices><triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\"/></triangles></mesh></object>"
    )
}

pub(super) fn alone(text: &str) -> Vec<u8> {
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
    // The mirrored triangle is reversed, so that its front side stays its front side.
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
    let mut marks = isomend_core::mesh::attributes::Attribute::new(
        PATCH_NAME,
        Role::Other,
        isomend_core::mesh::attributes::Scalar::U8,
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
    assert!(message.contains("unpacked parts exceed"), "{message}");
    let own = "<object id=\"1\"><components><component objectid=\"1\"/></components></object>";
    let message = refusal(
        &alone(&model("inch", own, "<item objectid=\"1\"/>")),
        Format::ThreeMf,
    );
    assert!(message.contains("objects are nested"), "{message}");
    // Each object consists of two copies of the previous one.
    let mut resources = triangle(1, "");
    for id in 2..30 {
        let inner = format!("<component objectid=\"{}\"/>", id - 1).repeat(2);
        resources += &format!("<object id=\"{id}\"><components>{inner}</components></object>");
    }
    let text = model("inch", &resources, "<item objectid=\"29\"/>");
    let message = refusal(&alone(&text), Format::ThreeMf);
    assert!(message.contains("uses objects more than"), "{message}");
}

/// The parts of a package as texts.
pub(super) fn parts_of(bytes: &[u8]) -> BTreeMap<String, String> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let count = archive.len();
    let read = |place: usize| {
        let mut part = archive.by_index(place).unwrap();
        let mut text = String::new();
        part.read_to_string(&mut text).unwrap();
        (part.name().unwrap().into_owned(), text)
    };
    (0..count).map(read).collect()
}

/// The text of the model in a package.
fn markup_of(bytes: &[u8]) -> String {
    parts_of(bytes)["3D/3dmodel.model"].clone()
}

fn written(mesh: &Mesh, attributes: &Attributes) -> Written {
    let contents = Contents {
        mesh,
        attributes,
        document: None,
    };
    model_to_bytes(&contents, Format::ThreeMf, &WriteOptions::default()).unwrap()
}

fn colour(name: &str, values: &[Option<[f64; 3]>]) -> Attribute {
    let mut out = Attribute::new(name, Role::Colour, Scalar::U8, 3);
    values
        .iter()
        .for_each(|value| out.push(value.as_ref().map(|v| &v[..])));
    out
}

fn materials(of_face: [u32; 3]) -> Labels {
    Labels {
        kind: LabelKind::Material,
        names: vec!["steel".to_owned(), "wood".to_owned()],
        of_face: of_face.to_vec(),
    }
}

#[test]
fn only_core_meshes_of_objects_are_read() {
    // Vertices and triangles that are not the object's: in a slice stack, in a foreign mesh, after the object.
    let slices = "<s:slicestack id=\"9\"><s:slice ztop=\"1\"><s:vertices><s:vertex x=\"7\" y=\"7\"/></s:vertices></s:slice>\
                  <vertex x=\"7\"/></s:slicestack>";
    let foreign =
        "<s:mesh><vertices><vertex x=\"7\" y=\"7\" z=\"7\"/></vertices></s:mesh><s:triangle/>";
    let object = triangle(1, "").replace("</mesh>", &format!("{foreign}</mesh>"));
    let behind = "<vertex x=\"7\" y=\"7\" z=\"7\"/><triangle v1=\"0\" v2=\"1\" v3=\"2\"/>";
    let resources = format!("{slices}{object}{behind}{slices}");
    let text = model("inch", &resources, "<item objectid=\"1\"/>");
    let loaded = read_alone(&alone(&text), Format::ThreeMf).unwrap();
    assert_eq!(loaded.mesh.positions.len(), 3);
    assert_eq!(loaded.mesh.faces.len(), 1);
    // The core namespace may have one prefix or several.
    let prefixed = "<k:model xmlns:k=\"core\" xmlns=\"core\" xmlns:s=\"s\"><k:resources>"
        .to_owned()
        + &triangle(1, "")
        + "</k:resources><k:build><k:item objectid=\"1\"/></k:build></k:model>";
    let loaded = read_alone(&alone(&prefixed), Format::ThreeMf).unwrap();
    assert_eq!(loaded.mesh.faces.len(), 1);
}

#[test]
fn marks_of_patches_are_merged_or_ignored() {
    assert_eq!(patch_ranges("", 3), Some(vec![]));
    assert_eq!(patch_ranges("4-6, 1,5-8,1", 9), Some(vec![[1, 1], [4, 8]]));
    assert_eq!(patch_ranges("0-1,0-1,0-1", 2), None);
    assert_eq!(patch_ranges("0-9", 9), None);
    let marked = |marks: &str| {
        let metadata = format!("<metadata name=\"isomend:patch\">{marks}</metadata><mesh>");
        let text = triangle(1, "").replace("<mesh>", &metadata);
        let text = model("inch", &text, "<item objectid=\"1\"/>");
        read_alone(&alone(&text), Format::ThreeMf).unwrap()
    };
    let loaded = marked("0");
    assert!(loaded.attributes.is_patch(0) && loaded.notes.is_empty());
    let loaded = marked("0,0");
    assert!(!loaded.attributes.is_patch(0));
    assert!(loaded.notes[0].contains("do not match their faces"));
}

#[test]
fn many_names_of_objects_and_materials_take_no_time_by_their_square() {
    let count = 40_000;
    let bases: String = (0..count)
        .map(|k| format!("<base name=\"m{k}\" displaycolor=\"#010203\"/>"))
        .collect();
    let triangles: String = (0..count)
        .map(|k| format!("<triangle v1=\"0\" v2=\"1\" v3=\"2\" pid=\"5\" p1=\"{k}\"/>"))
        .collect();
    let object = triangle(1, "").replace("<triangles>", &format!("<triangles>{triangles}"));
    let resources = format!("<basematerials id=\"5\">{bases}</basematerials>{object}");
    let start = std::time::Instant::now();
    let text = model("inch", &resources, "<item objectid=\"1\"/>");
    let loaded = read_alone(&alone(&text), Format::ThreeMf).unwrap();
    let names = loaded.attributes.labels_of(LabelKind::Material).unwrap();
    assert_eq!(names.names.len(), count);
    // One object with each other object as component. Without a build, each object is looked up among all components.
    let objects: String = (2..count)
        .map(|id| {
            format!(
                "<object id=\"{id}\"><components><component objectid=\"1\"/></components></object>"
            )
        })
        .collect();
    let text = model("inch", &(triangle(1, "") + &objects), "");
    let loaded = read_alone(&alone(&text), Format::ThreeMf).unwrap();
    assert_eq!(loaded.mesh.faces.len(), count - 2);
    // An algorithm of quadratic time took minutes here.
    assert!(start.elapsed().as_secs() < 20);
}

#[test]
fn memory_of_items_long_names_and_many_attributes_are_bounded() {
    let text = model("inch", &triangle(1, ""), "<item objectid=\"1\"/>");
    let mut left = 100;
    let message = model::parse(&text, &mut left).err().unwrap().to_string();
    assert!(message.contains("more memory than is allowed"), "{message}");
    let mut left = 10_000;
    assert!(model::parse(&text, &mut left).is_ok() && left < 10_000);
    let long = text.replace("\"o1\"", &format!("\"{}\"", "o".repeat(5000)));
    let message = refusal(&alone(&long), Format::ThreeMf);
    assert!(message.contains("a name is longer than"), "{message}");
    let many: String = (0..300).map(|k| format!(" a{k}=\"\"")).collect();
    let text = model("inch", &triangle(1, &many), "<item objectid=\"1\"/>");
    let message = refusal(&alone(&text), Format::ThreeMf);
    assert!(message.contains("more than 256 attributes"), "{message}");
}

#[test]
fn text_with_a_byte_order_mark_or_in_utf_16_is_read() {
    let text = model("inch", &triangle(1, ""), "<item objectid=\"1\"/>");
    let marked = format!("\u{feff}{text}");
    let wide: Vec<u8> = marked.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [marked.into_bytes(), wide] {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default();
        zip.start_file("3D/3DModel.model", options).unwrap();
        zip.write_all(&bytes).unwrap();
        let bytes = zip.finish().unwrap().into_inner();
        let loaded = read_alone(&bytes, Format::ThreeMf).unwrap();
        assert_eq!(loaded.mesh.faces.len(), 1);
    }
}

#[test]
fn properties_that_are_not_written_are_listed_as_lost() {
    let mesh = open_tetrahedron();
    let red = Some([255.0, 0.0, 0.0]);
    let all = Attributes {
        vertex: vec![colour("colour", &[red; 5])],
        labels: vec![materials([0, 1, 0])],
        unit: Some(Unit::Inch),
        ..Attributes::default()
    };
    let notes = written(&mesh, &all).notes;
    assert!(
        notes.len() == 1 && notes[0].ends_with(": materials"),
        "{notes:?}"
    );
    // Colours of vertices take precedence over colours of faces.
    let all = Attributes {
        face: vec![colour("colour", &[red; 3])],
        labels: Vec::new(),
        ..all
    };
    let notes = written(&mesh, &all).notes;
    assert!(
        notes.len() == 1 && notes[0].ends_with(": colours"),
        "{notes:?}"
    );
    let alone = Attributes {
        vertex: Vec::new(),
        ..all
    };
    assert_eq!(written(&mesh, &alone).notes, Vec::<String>::new());
}

#[test]
fn components_of_other_parts_hide_no_object_and_supports_are_skipped() {
    let inner = model("inch", &triangle(1, ""), "");
    let component = "<component p:path=\"/3D/a.model\" objectid=\"1\"/>";
    let resources = triangle(1, "")
        + &format!("<object id=\"2\"><components>{component}</components></object>")
        + &triangle(3, "").replace("\"model\"", "\"support\"")
        + &triangle(4, "").replace("\"model\"", "\"solidsupport\"");
    let main = model("inch", &resources, "");
    let bytes = package(&[("3D/3dmodel.model", &main), ("3D/a.model", &inner)]);
    let loaded = read_alone(&bytes, Format::ThreeMf).unwrap();
    assert_eq!(loaded.mesh.faces.len(), 2);
    assert_eq!(loaded.notes, ["support objects, which are not read: 2"]);
}

#[test]
fn objects_whose_faces_have_properties_name_one() {
    let mesh = open_tetrahedron();
    let all = |of_face: [u32; 3]| Attributes {
        labels: vec![materials(of_face)],
        unit: Some(Unit::Inch),
        ..Attributes::default()
    };
    let out = written(&mesh, &all([1, 0, 1])).bytes;
    assert!(markup_of(&out).contains("type=\"model\" pid=\"1\" pindex=\"1\""));
    // Faces without a material keep none.
    let out = written(&mesh, &all([1, NONE, 0])).bytes;
    assert!(markup_of(&out).contains("type=\"model\" pid=\"1\" pindex=\"2\""));
    let again = read_alone(&out, Format::ThreeMf).unwrap().attributes;
    let labels = again.labels_of(LabelKind::Material).unwrap();
    assert_eq!(
        [0, 1, 2].map(|f| labels.get(f)),
        [Some("wood"), None, Some("steel")]
    );
    let red = Some([255.0, 0.0, 0.0]);
    let coloured = Attributes {
        face: vec![colour("colour", &[red; 3])],
        ..Attributes::default()
    };
    let out = written(&mesh, &coloured).bytes;
    assert!(markup_of(&out).contains("type=\"model\" pid=\"1\" pindex=\"0\""));
}

#[test]
fn vertices_of_several_objects_are_numbered_in_each() {
    let mesh = open_tetrahedron();
    let objects = Labels {
        kind: LabelKind::Object,
        names: vec!["a".to_owned(), "b".to_owned()],
        of_face: vec![0, 1, 0],
    };
    let all = Attributes {
        labels: vec![objects],
        unit: Some(Unit::Inch),
        ..Attributes::default()
    };
    let loaded = read_alone(&written(&mesh, &all).bytes, Format::ThreeMf).unwrap();
    let order = [0, 2, 1];
    for (new, old) in order.into_iter().enumerate() {
        assert_eq!(loaded.mesh.corners(new as u32), mesh.corners(old));
    }
}

#[test]
fn faults_are_described() {
    let item = "<item objectid=\"1\"/>";
    let bad_vertex = triangle(1, "").replace("v3=\"2\"", "v3=\"9\"");
    let bad_number = triangle(1, "").replace("x=\"1\"", "x=\"one\"");
    for (text, said) in [
        (model("parsec", &triangle(1, ""), item), "no unit 'parsec'"),
        (model("inch", &bad_vertex, item), "uses vertex 9"),
        (
            model("inch", &bad_number, item),
            "'one' is not a coordinate",
        ),
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

#[test]
fn objects_of_one_name_stay_apart() {
    let named = |id: u32| triangle(id, "").replace(&format!("name=\"o{id}\""), "name=\"part\"");
    let other = triangle(3, "").replace("name=\"o3\"", "name=\"part_2\"");
    let resources = named(1) + &named(2) + &other;
    let items = [3, 1, 2, 1].map(|id| format!("<item objectid=\"{id}\"/>"));
    let bytes = alone(&model("meter", &resources, &items.concat()));
    let loaded = read_alone(&bytes, Format::ThreeMf).unwrap();
    let labels = loaded.attributes.labels_of(LabelKind::Object).unwrap();
    assert_eq!(labels.names, ["part_2", "part", "part_3", "part_4"]);
    assert_eq!(labels.of_face, [0, 1, 2, 3]);
    assert!(
        loaded.notes[0].ends_with("have the same name: 2"),
        "{:?}",
        loaded.notes
    );
}
