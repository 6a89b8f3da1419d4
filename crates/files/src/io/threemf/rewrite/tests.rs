//! Tests of meshes that are written into the package they came from: properties of new faces, extensions, and what is named as lost.

use super::super::super::samples::*;
use super::super::super::{Contents, Format, Loaded, WriteOptions, Written, model_to_bytes};
use super::super::tests::{alone, model, package, parts_of};
use isomend_core::attributes::transfer;
use isomend_core::mesh::attributes::LabelKind;
use isomend_core::mesh::{FaceOrigin, Mesh, Origins};

/// An open tetrahedron as an object; `inside` stands at the end of its mesh, `of_face` gives attributes of its triangles.
pub(super) fn open(id: u32, inside: &str, of_face: &str) -> String {
    let points = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]];
    let points: String = points
        .map(|[x, y, z]| format!("\n<vertex x=\"{x}.0\" y=\"{y}\" z=\"{z}\" s:a=\"1\"/>"))
        .concat();
    let faces: String = [[0, 2, 1], [0, 1, 3], [0, 3, 2]]
        .map(|[a, b, c]| format!("\n<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"{of_face}/>"))
        .concat();
    format!(
        "<object id=\"{id}\" s:b=\"x\"><mesh><vertices>{points}\n</vertices><triangles>{faces}\n</triangles>{inside}</mesh></object>"
    )
}

pub(super) fn read(bytes: &[u8]) -> Loaded {
    read_alone(bytes, Format::ThreeMf).unwrap()
}

/// The file with further faces.
pub(super) fn filled(loaded: &Loaded, faces: &[[u32; 3]]) -> Written {
    let mut mesh = loaded.mesh.clone();
    mesh.faces.extend(faces);
    let done = transfer(&loaded.mesh, &loaded.attributes, mesh);
    written(loaded, &done.mesh, &done.attributes)
}

pub(super) fn written(
    loaded: &Loaded,
    mesh: &Mesh,
    attributes: &isomend_core::mesh::Attributes,
) -> Written {
    let contents = Contents {
        mesh,
        attributes,
        document: loaded.document.as_ref(),
    };
    model_to_bytes(&contents, Format::ThreeMf, &WriteOptions::default()).unwrap()
}

pub(super) fn text(written: &Written) -> String {
    parts_of(&written.bytes)["3D/3dmodel.model"].clone()
}

pub(super) const ITEM: &str = "<item objectid=\"1\"/>";

#[test]
fn only_the_lists_of_a_filled_object_change() {
    let strange = "<s:x y='1'><![CDATA[<object id=\"9\">]]></s:x><!-- a --><?b c?>";
    let before = model(
        "inch",
        &(strange.to_owned() + &open(1, "", " s:c='\"2\"'")),
        ITEM,
    );
    let bytes = package(&[("3D/3dmodel.model", &before), ("a/b.bin", "\0\u{1}")]);
    let done = filled(&read(&bytes), &[[1, 2, 3]]);
    assert_eq!(done.notes, Vec::<String>::new());
    let after = text(&done)
        .replace("\n<triangle v1=\"1\" v2=\"2\" v3=\"3\"/>", "")
        .replace(" xmlns:isomend=\"urn:isomend\"", "");
    let list = "<metadata name=\"isomend:patch\" type=\"xs:string\" preserve=\"1\">3</metadata>";
    assert_eq!(
        after.replace(&format!("<metadatagroup>{list}</metadatagroup>"), ""),
        before
    );
    assert_eq!(parts_of(&done.bytes)["a/b.bin"], "\0\u{1}");
    // The marks are found again, and their list is extended in its group.
    let again = read(&done.bytes);
    assert!(again.attributes.is_patch(3));
    let twice = text(&filled(&again, &[[1, 3, 2]]));
    assert!(
        twice.contains(&format!(
            "<metadatagroup>{}</metadatagroup>",
            list.replace('3', "3-4")
        )),
        "{twice}"
    );
}

#[test]
fn new_faces_continue_colours_and_materials_in_a_group_of_their_own() {
    let colours = "<m:colorgroup id=\"5\"><m:color color=\"#FF0000\"/></m:colorgroup>";
    let materials =
        "<basematerials id=\"5\"><base name=\"oak\" displaycolor=\"#102030\"/></basematerials>";
    for (group, expected) in [
        (colours, "#FF0000FF"),
        (materials, "name=\"oak\" displaycolor=\"#102030FF\""),
    ] {
        let resources = group.to_owned() + &open(1, "", " pid=\"5\" p1=\"0\"");
        let bytes = alone(&model("inch", &resources, ITEM));
        let done = filled(&read(&bytes), &[[1, 2, 3]]);
        let text = text(&done);
        assert!(text.contains(group), "{text}");
        let new = text.split("id=\"6\"").nth(1).unwrap();
        assert!(new.contains(expected), "{text}");
        assert!(
            text.contains("v1=\"1\" v2=\"2\" v3=\"3\" pid=\"6\" p1=\"0\""),
            "{text}"
        );
        let again = read(&done.bytes).attributes;
        match again.labels_of(LabelKind::Material) {
            Some(labels) => assert_eq!([labels.get(0), labels.get(3)], [Some("oak"); 2]),
            None => assert_eq!(again.corner[0].get(3, 1), again.corner[0].get(0, 0)),
        }
    }
}

#[test]
fn elements_that_number_triangles_stay_while_their_numbers_do() {
    let inside = "<b:beamlattice><b:beams><b:beam v1=\"0\" v2=\"1\"/></b:beams></b:beamlattice><t:trianglesets/>";
    let bytes = alone(&model("inch", &open(1, inside, ""), ITEM));
    let loaded = read(&bytes);
    let done = filled(&loaded, &[[1, 2, 3]]);
    assert!(
        text(&done).contains(inside) && done.notes.is_empty(),
        "{:?}",
        done.notes
    );
    let keep = [true, false, true];
    let mut mesh = loaded.mesh.clone();
    mesh.faces.remove(1);
    let done = written(&loaded, &mesh, &loaded.attributes.with_faces(&keep));
    assert!(!text(&done).contains("beamlattice"));
    assert!(
        done.notes[0].ends_with("b:beamlattice, t:trianglesets"),
        "{:?}",
        done.notes
    );
    assert_eq!(read(&done.bytes).mesh.faces.len(), 2);
}

#[test]
fn turned_faces_exchange_the_properties_of_their_corners() {
    let colours = "<m:colorgroup id=\"5\"><m:color color=\"#FF0000\"/><m:color color=\"#00FF00\"/></m:colorgroup>";
    let object = open(
        1,
        "",
        " pid=\"5\" p1=\"0\" p2=\"1\" p3=\"0\" paint_seam=\"8\"",
    );
    // The second place is mirrored.
    for transform in ["", " transform=\"1 0 0 0 1 0 0 0 -1 2 3 4\""] {
        let item = format!("<item objectid=\"1\"{transform}/>");
        let loaded = read(&alone(&model(
            "inch",
            &(colours.to_owned() + &object),
            &item,
        )));
        let mut mesh = loaded.mesh.clone();
        mesh.faces[1].swap(1, 2);
        let mut origins = Origins::of(&mesh);
        origins.faces[1] = FaceOrigin {
            face: 1,
            corners: [0, 2, 1],
        };
        let done = loaded.derived(mesh.clone(), &origins, &[true, false, true]);
        let out = written(&loaded, &done.mesh, &done.attributes);
        let turned = "<triangle v1=\"0\" v2=\"3\" v3=\"1\" pid=\"5\" paint_seam=\"8\" p1=\"0\" p2=\"0\" p3=\"1\"/>";
        assert!(text(&out).contains(turned), "{}", text(&out));
        assert_eq!(out.notes, Vec::<String>::new());
        assert_eq!(read(&out.bytes).mesh.faces, mesh.faces);
    }
}

#[test]
fn vertices_that_were_separated_stay_apart_with_the_same_coordinates() {
    let loaded = read(&alone(&model(
        "inch",
        &open(1, "", ""),
        "<item objectid=\"1\" transform=\"0 1 0 -1 0 0 0 0 1 0.1 0.2 0.3\"/>",
    )));
    let mut mesh = loaded.mesh.clone();
    mesh.positions.push(mesh.positions[0]);
    mesh.faces[2][0] = 4;
    let done = loaded.derived(
        mesh.clone(),
        &Origins {
            vertices: vec![0, 1, 2, 3, 0],
            ..Origins::of(&mesh)
        },
        &[true; 3],
    );
    let again = read(&written(&loaded, &done.mesh, &done.attributes).bytes);
    assert_eq!(again.mesh, mesh);
}

#[test]
fn prefixes_of_the_core_namespace_are_used_in_new_elements() {
    let plain = model("inch", &open(1, "", ""), ITEM).replace("xmlns=\"c\"", "xmlns:k=\"c\"");
    let mut text = plain.replace("<?xml version=\"1.0\"?>", "");
    for name in [
        "model",
        "resources",
        "object",
        "mesh",
        "vertices",
        "vertex",
        "triangles",
        "triangle",
        "build",
        "item",
    ] {
        for (from, to) in [("<", "<k:"), ("</", "</k:")] {
            text = text.replace(&format!("{from}{name} "), &format!("{to}{name} "));
            text = text.replace(&format!("{from}{name}>"), &format!("{to}{name}>"));
        }
    }
    let done = filled(&read(&alone(&text)), &[[1, 2, 3]]);
    assert_eq!(done.notes, Vec::<String>::new());
    assert_eq!(read(&done.bytes).mesh.faces.len(), 4);
}

#[test]
fn a_package_that_cannot_be_kept_is_written_anew_and_named() {
    let text = model(
        "inch",
        &open(1, "<s:triangles/>", " paint_seam=\"8\""),
        ITEM,
    );
    let foreign = text.replace("</triangles>", "<s:triangle/></triangles>");
    let flat = text.replace(
        "objectid=\"1\"",
        "objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 0 0 0 0\"",
    );
    for (text, reason) in [(foreign, "unusual"), (flat, "has no inverse")] {
        let bytes = package(&[("3D/3dmodel.model", &text), ("Metadata/x.config", "y")]);
        let done = filled(&read(&bytes), &[[1, 2, 3]]);
        let note = &done.notes[0];
        assert!(
            note.contains(reason)
                && note.contains("paint_seam of triangles, the parts Metadata/x.config"),
            "{note}"
        );
        assert_eq!(read(&done.bytes).mesh.faces.len(), 4);
    }
}

#[test]
fn volumes_that_lose_all_triangles_or_name_others_are_told_apart() {
    let config = |ranges: [[u32; 2]; 2]| {
        let volumes = ranges.map(|[first, last]| {
            format!("<volume firstid=\"{first}\" lastid=\"{last}\"><metadata type=\"volume\" key=\"name\" value=\"v{first}\"/></volume>")
        });
        format!(
            "<config><object id=\"1\">{}</object></config>",
            volumes.concat()
        )
    };
    let name = "Metadata/Slic3r_PE_model.config";
    let without_first = |ranges| {
        let text = model("inch", &open(1, "", ""), ITEM);
        let loaded = read(&package(&[
            ("3D/3dmodel.model", &text),
            (name, &config(ranges)),
        ]));
        let mut mesh = loaded.mesh.clone();
        mesh.faces.remove(0);
        let done = written(
            &loaded,
            &mesh,
            &loaded.attributes.with_faces(&[false, true, true]),
        );
        (parts_of(&done.bytes)[name].clone(), done.notes)
    };
    let (text, notes) = without_first([[0, 0], [1, 2]]);
    assert!(
        !text.contains("v0") && text.contains("firstid=\"0\" lastid=\"1\"") && text.contains("v1"),
        "{text}"
    );
    assert!(
        notes[0].starts_with("volumes without triangles"),
        "{notes:?}"
    );
    let (text, notes) = without_first([[0, 1], [1, 2]]);
    assert_eq!(text, config([[0, 1], [1, 2]]));
    assert!(
        notes[0].starts_with("volumes that name other triangles"),
        "{notes:?}"
    );
}

#[test]
fn packages_near_the_memory_allowance_are_written_again() {
    // Blanks between the resources, of more than half the allowance of 64 MB.
    let blanks = " ".repeat(40 << 20);
    let text = model("inch", &(blanks + &open(1, "", "")), ITEM);
    let done = filled(&read(&alone(&text)), &[[1, 2, 3]]);
    assert_eq!(read(&done.bytes).mesh.faces.len(), 4);
}

#[test]
fn other_encodings_are_written_as_utf_8_and_damaged_text_is_written_anew() {
    let named = |encoding: &str| {
        let text = model("inch", &open(1, "", ""), ITEM);
        let text = text.replace(
            "version=\"1.0\"",
            &format!("version=\"1.0\" encoding='{encoding}'"),
        );
        text.replace("id=\"1\" s:b=\"x\"", "id=\"1\" name=\"K\u{fc}hler\"")
    };
    let bytes = |text: &str| {
        text.chars()
            .map(|c| u32::from(c) as u8)
            .collect::<Vec<u8>>()
    };
    let wide = named("UTF-16LE");
    let wide: Vec<u8> = wide.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for (bytes, is_kept) in [
        (bytes(&named("ISO-8859-1")), true),
        (wide, true),
        (bytes(&named("UTF-8")), false),
    ] {
        let done = filled(&read(&packed(&bytes)), &[[1, 2, 3]]);
        let anew = done.notes.iter().any(|note| note.contains("written anew"));
        let text = text(&done);
        assert_eq!(text.contains("encoding='UTF-8'?"), is_kept, "{text}");
        assert_eq!(text.contains("name=\"K\u{fc}hler\""), is_kept, "{text}");
        assert_eq!(anew, !is_kept, "{:?}", done.notes);
    }
}

fn packed(model: &[u8]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    for (name, bytes) in [("3D/3dmodel.model", model), ("Metadata/x.config", b"y")] {
        zip.start_file(name, options).unwrap();
        std::io::Write::write_all(&mut zip, bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// A file whose second triangle is divided at a new vertex, with a patch in the hole.
fn divided(loaded: &Loaded) -> Written {
    let mut mesh = loaded.mesh.clone();
    mesh.positions.push(glam::DVec3::new(2.0, 0.0, 0.0));
    mesh.faces[1] = [0, 4, 3];
    mesh.faces.push([4, 1, 3]);
    let mut origins = Origins::of(&mesh);
    origins.vertices[4] = 0;
    for (f, corners) in [(1, [0, 3, 2]), (3, [3; 3])] {
        origins.faces[f] = FaceOrigin { face: 1, corners };
    }
    let done = loaded.derived(mesh, &origins, &[true, false, true, false]);
    written(loaded, &done.mesh, &done.attributes)
}

#[test]
fn divided_triangles_keep_what_holds_for_the_whole_triangle() {
    let groups = "<m:texture2dgroup id=\"4\" texid=\"9\"/><m:colorgroup id=\"5\"><m:color color=\"#FF0000\"/></m:colorgroup>";
    for (of_face, kept, loses) in [
        (" pid=\"5\" p1=\"0\" face_property=\"2\"", true, false),
        (" pid=\"4\" p1=\"1\" p2=\"1\" a=\"b\"", true, false),
        (" pid=\"4\" p1=\"1\" p2=\"2\"", false, true),
        (" paint_seam=\"4C3\"", false, true),
    ] {
        let resources = groups.to_owned() + &open(1, "", of_face);
        let done = divided(&read(&alone(&model("inch", &resources, ITEM))));
        let text = text(&done);
        // All four triangles, or the two that stay.
        let count = text.matches(&format!("{of_face}/>")).count();
        assert_eq!(count, if kept { 4 } else { 2 }, "{text}");
        let note = done.notes.iter().any(|note| note.ends_with("corners: 2"));
        assert_eq!(note, loses, "{:?}", done.notes);
        assert_eq!(text.matches("colorgroup id").count(), 1, "{text}");
    }
}

#[test]
fn patches_have_the_property_of_their_own_object_or_none() {
    let groups = "<m:colorgroup id=\"5\"><m:color color=\"#FF0000\"/></m:colorgroup>\
        <basematerials id=\"6\"><base name=\"oak\" displaycolor=\"#102030\"/></basematerials>";
    let objects =
        open(1, "", " pid=\"5\" p1=\"0\"") + &open(2, "", " pid=\"6\" p1=\"0\"") + &open(3, "", "");
    let items: String = (1..=3)
        .map(|id| format!("<item objectid=\"{id}\"/>"))
        .collect();
    let loaded = read(&alone(&model(
        "inch",
        &(groups.to_owned() + &objects),
        &items,
    )));
    let done = filled(&loaded, &[[1, 2, 3], [5, 6, 7], [9, 10, 11]]);
    let text = text(&done);
    let new = text.split("v1=\"1\" v2=\"2\" v3=\"3\"").skip(1);
    let new: Vec<&str> = new.map(|rest| rest.split("/>").next().unwrap()).collect();
    assert_eq!(
        new,
        [" pid=\"7\" p1=\"0\"", " pid=\"8\" p1=\"0\"", ""],
        "{text}"
    );
    // The objects with new properties get a default, which is no material; the other stays as it was.
    assert_eq!(
        text.matches(" s:b=\"x\" pid=\"9\" pindex=\"0\">").count(),
        2
    );
    let again = read(&done.bytes).attributes;
    let materials = again.labels_of(LabelKind::Material).unwrap();
    assert_eq!(materials.names, ["oak"]);
    let oak: Vec<usize> = (0..12).filter(|f| materials.get(*f).is_some()).collect();
    assert_eq!(oak, [4, 5, 6, 7]);
    let coloured: Vec<usize> = (0..12)
        .filter(|f| again.corner[0].get(*f, 0).is_some())
        .collect();
    assert_eq!(coloured, [0, 1, 2, 3]);
}

#[test]
fn markup_of_other_programs_stays_well_formed() {
    // Blanks around signs of equality, and an empty group of metadata.
    let colours = "<m3:colorgroup id=\"5\"><m3:color color=\"#FF0000\"/></m3:colorgroup>";
    let object = open(1, "", " pid=\"5\" p1=\"0\"").replacen("<mesh>", "<metadatagroup/><mesh>", 1);
    let text = model("inch", &(colours.to_owned() + &object), ITEM).replace(
        "xmlns:m=\"m\"",
        "xmlns:m =\"x\" xmlns:isomend =\"urn:isomend\" xmlns:m3=\"m\"",
    );
    let done = filled(&read(&alone(&text)), &[[1, 2, 3]]);
    let out = self::text(&done);
    let tag = out
        .split("<model")
        .nth(1)
        .unwrap()
        .split('>')
        .next()
        .unwrap();
    for prefix in ["m", "isomend", "m3", "material"] {
        let count = tag
            .replace(" =", "=")
            .matches(&format!("xmlns:{prefix}="))
            .count();
        assert_eq!(count, 1, "{prefix} in {tag}");
    }
    assert!(!out.contains("<metadatagroup/>"), "{out}");
    assert!(read(&done.bytes).attributes.is_patch(3), "{out}");
}

#[test]
fn remarks_name_few_elements_and_each_once() {
    let inside: String = (0..100).map(|k| format!("<s:e{}/>", k / 4)).collect();
    let loaded = read(&alone(&model("inch", &open(1, &inside, ""), ITEM)));
    let mut mesh = loaded.mesh.clone();
    mesh.faces.remove(1);
    let attributes = loaded.attributes.with_faces(&[true, false, true]);
    let done = written(&loaded, &mesh, &attributes);
    assert!(
        done.notes[0].ends_with(": s:e0, s:e1, s:e10, s:e11 and 21 more"),
        "{:?}",
        done.notes
    );
}
