//! Tests of 3MF packages of other programs: names of parts, older namespaces, beams.

use super::super::samples::*;
use super::super::{Contents, WriteOptions, model_to_bytes};
use super::tests::{alone, model, package, triangle};
use super::*;
use isomend_core::mesh::attributes::LabelKind;

/// Relationships that name the main model.
fn relationships(target: &str) -> String {
    format!(
        "<Relationships><Relationship Target=\"{target}\" Id=\"r\" \
         Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>"
    )
}

#[test]
fn the_model_may_have_any_name_that_the_relationships_give() {
    let text = model("inch", &triangle(1, ""), "<item objectid=\"1\"/>");
    let (plain, ending) = ("/3D/body.custom", "/a/b.XML");
    for name in [plain, ending] {
        let rels = relationships(name);
        let bytes = package(&[("_rels/.rels", &rels), (&name[1..], &text)]);
        let format = Format::detect(&bytes, std::path::Path::new("a.zip")).unwrap();
        assert_eq!(format, Format::ThreeMf);
        assert_eq!(read_alone(&bytes, format).unwrap().mesh.faces.len(), 1);
    }
    let other = "<Relationships><Relationship Target=\"/word/document.xml\" Type=\"office\"/></Relationships>";
    let bytes = package(&[("_rels/.rels", other), ("word/document.xml", "<x/>")]);
    assert!(Format::sniff(&bytes).is_err());
}

#[test]
fn models_of_the_first_namespace_are_read_without_their_colours() {
    let resources = "<color id=\"1\" value=\"#FF0000\"/><material id=\"2\" colorid=\"1\"/>"
        .to_owned()
        + &triangle(3, " materialid=\"2\"");
    let text = model("inch", &resources, "<item objectid=\"3\"/>");
    let first = "http://schemas.microsoft.com/3dmanufacturing/2013/01";
    let text = text.replace("xmlns=\"c\"", &format!("xmlns=\"{first}\""));
    let loaded = read_alone(&alone(&text), Format::ThreeMf).unwrap();
    assert_eq!(loaded.mesh.faces.len(), 1);
}

#[test]
fn beams_are_named() {
    let lattice = "<b:beamlattice><b:beams><b:beam v1=\"0\" v2=\"1\"/><b:beam v1=\"1\" v2=\"2\"/></b:beams></b:beamlattice>";
    let with = |object: &str| object.replace("</mesh>", &format!("{lattice}</mesh>"));
    let both = model("inch", &with(&triangle(1, "")), "<item objectid=\"1\"/>");
    let notes = read_alone(&alone(&both), Format::ThreeMf).unwrap().notes;
    assert_eq!(notes, ["beams of lattices, which are not read: 2"]);
    let none = both.replace("<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>", "");
    let message = refusal(&alone(&none), Format::ThreeMf);
    assert!(message.contains("only 2 beams of lattices"), "{message}");
}

#[test]
fn objects_without_triangle_meshes_are_named() {
    let resources = triangle(1, "")
        + "<object id=\"2\"><bo:booleanshape objectid=\"1\"><bo:boolean objectid=\"1\"/></bo:booleanshape></object>\
           <object id=\"3\"><d:displacementmesh><d:vertices/></d:displacementmesh></object>\
           <object id=\"4\"><components><component objectid=\"1\"/></components></object>";
    let items = [1, 2, 3, 4].map(|id| format!("<item objectid=\"{id}\"/>"));
    let text = model("inch", &resources, &items.concat());
    let loaded = read_alone(&alone(&text), Format::ThreeMf).unwrap();
    assert_eq!(loaded.mesh.faces.len(), 2);
    let what = "objects that are no triangle meshes, such as boolean shapes, which are not read: 2";
    assert_eq!(loaded.notes, [what]);
}

#[test]
fn each_placed_mesh_of_an_object_is_a_part_with_a_name_of_its_own() {
    let resources = triangle(1, "")
        + &triangle(2, "")
        + "<object id=\"3\" name=\"pair\"><components><component objectid=\"1\"/><component objectid=\"2\"/><component objectid=\"1\"/>\
           </components></object>";
    let build = "<item objectid=\"3\"/><item objectid=\"1\"/><item objectid=\"1\"/>";
    let loaded = read_alone(
        &alone(&model("millimeter", &resources, build)),
        Format::ThreeMf,
    )
    .unwrap();
    let bodies = loaded.bodies().unwrap();
    let names = ["pair/o1", "pair/o2", "pair/o1_2", "o1", "o1_2"];
    assert_eq!(bodies.names, names);
    let contents = Contents {
        mesh: &loaded.mesh,
        attributes: &loaded.attributes,
        document: None,
    };
    let written = model_to_bytes(&contents, Format::ThreeMf, &WriteOptions::default()).unwrap();
    let again = read_alone(&written.bytes, Format::ThreeMf).unwrap();
    assert_eq!(again.bodies().unwrap().names, names);
    assert_eq!(again.mesh, loaded.mesh);
    // The name of a single object stays too.
    let single = alone(&model(
        "millimeter",
        &triangle(1, ""),
        "<item objectid=\"1\"/>",
    ));
    let loaded = read_alone(&single, Format::ThreeMf).unwrap();
    assert_eq!(
        loaded
            .attributes
            .labels_of(LabelKind::Object)
            .unwrap()
            .names,
        ["o1"]
    );
    assert!(loaded.bodies().is_none());
}

#[test]
fn long_names_of_many_placed_objects_are_charged_to_the_memory_allowance() {
    let named = triangle(1, "").replace("\"o1\"", &format!("\"{}\"", "o".repeat(4000)));
    let items = "<item objectid=\"1\"/>".repeat(20_000);
    let message = refusal(&alone(&model("inch", &named, &items)), Format::ThreeMf);
    assert!(message.contains("do not fit into memory"), "{message}");
}

#[test]
fn notes_on_unknown_volumes_and_parts_name_no_object() {
    let name = |name: &str| format!("<metadata key=\"name\" value=\"{name}\"/>");
    let text = format!(
        "<config><object id=\"1\">{}<volume firstid=\"a\">{}</volume><part>{}</part></object></config>",
        name("Body"),
        name("volume"),
        name("part")
    );
    let settings = super::settings::Settings::new(&[text]);
    assert_eq!(settings.objects[&1].name, "Body");
}
