//! Tests of projects of slicers that are written again: unused vertices, comments, numbers of faces, heights of layers, names of parts.

use super::super::super::Loaded;
use super::super::tests::{alone, model, package, parts_of};
use super::tests::{ITEM, filled, open, read, text, written};
use glam::DVec3;
use isomend_core::attributes::transfer;
use isomend_core::mesh::{Mesh, Origins};

/// An open tetrahedron whose mesh has an unused vertex among the others and one after them.
fn with_unused(id: u32, inside: &str) -> String {
    let points = [[0, 0], [7, 7], [4, 0], [0, 4], [1, 1], [8, 8]];
    let points = points.map(|[x, y]| {
        let z = u32::from(x == 1);
        format!("\n<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")
    });
    let faces = [[0, 3, 2], [0, 2, 4], [0, 4, 3]].map(|[a, b, c]| {
        format!("\n<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\" paint_seam=\"8\"/>")
    });
    let [points, faces] = [points.concat(), faces.concat()];
    format!(
        "<object id=\"{id}\"><mesh><vertices>{points}\n</vertices><triangles>{faces}\n</triangles>{inside}</mesh></object>"
    )
}

/// The first coordinates of the vertices in a text.
fn first_coordinates(text: &str) -> String {
    let rest = text.split("<vertex x=\"").skip(1);
    let all: Vec<&str> = rest.map(|rest| rest.split('"').next().unwrap()).collect();
    all.join(" ")
}

/// A file without its unused vertices.
fn without_unused(loaded: &Loaded) -> (Mesh, Origins) {
    let mut is_used = vec![false; loaded.mesh.positions.len()];
    let corners = loaded.mesh.faces.iter().flatten();
    corners.for_each(|v| is_used[*v as usize] = true);
    let used: Vec<u32> = (0..).take(is_used.len()).collect();
    let used: Vec<u32> = used.into_iter().filter(|v| is_used[*v as usize]).collect();
    let number = |v: u32| used.iter().position(|own| *own == v).unwrap() as u32;
    let mesh = Mesh::new(
        used.iter()
            .map(|v| loaded.mesh.positions[*v as usize])
            .collect(),
        loaded.mesh.faces.iter().map(|f| f.map(number)).collect(),
    );
    let origins = Origins {
        vertices: used,
        ..Origins::of(&loaded.mesh)
    };
    (mesh, origins)
}

/// The text and the notes of a mesh that came from a file, with further vertices and faces.
fn extended(
    loaded: &Loaded,
    (mesh, origins): (Mesh, Origins),
    (points, faces): (&[DVec3], &[[u32; 3]]),
) -> (String, Vec<String>) {
    let kept = vec![true; origins.faces.len()];
    let done = loaded.derived(mesh, &origins, &kept);
    let mut mesh = done.mesh.clone();
    mesh.positions.extend(points);
    mesh.faces.extend(faces);
    let done = transfer(&done.mesh, &done.attributes, mesh);
    let done = written(loaded, &done.mesh, &done.attributes);
    (text(&done), done.notes)
}

fn rewritten(loaded: &Loaded, own: (Mesh, Origins)) -> (String, Vec<String>) {
    extended(loaded, own, (&[], &[]))
}

#[test]
fn unused_vertices_stay_behind_the_new_ones_of_their_part() {
    let same = |loaded: &Loaded| (loaded.mesh.clone(), Origins::of(&loaded.mesh));
    let faces = [[2, 3, 6], [3, 4, 6], [4, 2, 6]];
    let new: (&[DVec3], &[[u32; 3]]) = (&[DVec3::new(5.0, 5.0, 0.0)], &faces);
    let text = model("inch", &with_unused(1, ""), ITEM);
    let loaded = read(&alone(&text));
    let (after, notes) = extended(&loaded, same(&loaded), new);
    assert_eq!(first_coordinates(&text), "0 7 4 0 1 8");
    assert_eq!(first_coordinates(&after), "0 7 4 0 1 5 8");
    assert!(after.contains("v1=\"2\" v2=\"3\" v3=\"5\""), "{after}");
    assert_eq!(notes, Vec::<String>::new());
    // Beams number the vertices.
    let text = model("inch", &with_unused(1, "<b:beamlattice/>"), ITEM);
    let loaded = read(&alone(&text));
    let (after, _) = extended(&loaded, same(&loaded), new);
    assert_eq!(first_coordinates(&after), "0 7 4 0 1 8 5");
}

#[test]
fn unused_vertices_are_left_out_if_the_mesh_has_none() {
    let beams = "<b:beamlattice><b:beam v1=\"1\" v2=\"5\"/></b:beamlattice>";
    let objects = [with_unused(1, ""), with_unused(2, beams), open(3, "", "")];
    let items = [1, 2, 3].map(|id| format!("<item objectid=\"{id}\"/>"));
    let text = model("inch", &objects.concat(), &items.concat());
    let bytes = package(&[("3D/3dmodel.model", &text), ("Metadata/x.gcode", "G1")]);
    let loaded = read(&bytes);
    let (after, notes) = rewritten(&loaded, without_unused(&loaded));
    assert_eq!(
        first_coordinates(&after),
        "0 4 0 1 0 7 4 0 1 8 0.0 4.0 0.0 0.0"
    );
    // No triangle changed, so that G-code is as true as before.
    let reason = "elements may refer to vertices by number: b:beamlattice";
    assert_eq!(
        notes,
        [format!("unused vertices of object 2 stay: {reason}")]
    );
    assert!(
        after.contains("v1=\"0\" v2=\"2\" v3=\"1\" paint_seam=\"8\"/>"),
        "{after}"
    );
    assert!(
        after.contains(&objects[1]) && after.contains(&objects[2]),
        "{after}"
    );
    let again = read(&alone(&after)).mesh;
    assert_eq!(again.faces[..3], without_unused(&loaded).0.faces[..3]);
    // The same of objects that were filled.
    for (object, id) in [(with_unused(1, ""), None), (with_unused(1, beams), Some(1))] {
        let loaded = read(&alone(&model("inch", &object, ITEM)));
        let (after, notes) = extended(&loaded, without_unused(&loaded), (&[], &[[1, 2, 3]]));
        let expected = id.map_or("0 4 0 1", |_| "0 7 4 0 1 8");
        assert_eq!(first_coordinates(&after), expected);
        let named = id.map(|id| format!("unused vertices of object {id} stay: {reason}"));
        assert_eq!(notes, Vec::from_iter(named));
    }
    // A mesh with unused vertices keeps the package as it is.
    let (mesh, origins) = (loaded.mesh.clone(), Origins::of(&loaded.mesh));
    assert_eq!(rewritten(&loaded, (mesh, origins)), (text, Vec::new()));
}

#[test]
fn comments_between_triangles_and_vertices_do_not_cost_the_project() {
    let [comment, instruction] = ["<!-- <vertex/> -->", "<?a b?>"];
    let places = [
        ("<vertices>", "<vertices>\n#"),
        ("\n<vertex x=\"4", "\n#\n#\n<vertex x=\"4"),
        ("\n</vertices>", "#\n</vertices>"),
        ("<triangles>", "<triangles>#"),
        ("\n</triangles>", "\n#\n</triangles>"),
    ];
    let plain = open(1, "", " paint_seam=\"8\"");
    let remarked = |remark: &str| {
        let add = |text: String, (place, with): &(&str, &str)| text.replacen(place, with, 1);
        let text = places.iter().fold(plain.clone(), add);
        model("inch", &text.replace('#', remark), ITEM)
    };
    let expected = text(&filled(
        &read(&alone(&model("inch", &plain, ITEM))),
        &[[1, 2, 3]],
    ));
    for remark in [comment, instruction] {
        let before = remarked(remark);
        let done = filled(&read(&alone(&before)), &[[1, 2, 3]]);
        let note = "comments between the vertices and triangles of object 1, left out: 6";
        assert_eq!(done.notes, [note]);
        assert_eq!(text(&done), expected);
    }
}

/// The file without the face with this number.
fn without(loaded: &Loaded, face: usize) -> (Mesh, Origins) {
    let mut mesh = loaded.mesh.clone();
    mesh.faces.remove(face);
    let mut origins = Origins::of(&loaded.mesh);
    origins.faces.remove(face);
    (mesh, origins)
}

#[test]
fn the_number_of_faces_of_an_object_counts_its_normal_parts() {
    let part = |id: u32, kind: &str| {
        format!("<part id=\"{id}\"{kind}><mesh_stat face_count=\"3\"/></part>")
    };
    let parts = [
        part(1, " subtype=\"normal_part\""),
        part(2, " subtype=\"modifier_part\""),
        part(3, ""),
    ];
    let config = format!(
        "<config><object id=\"9\"><metadata face_count=\"6\"/>{}</object></config>",
        parts.concat()
    );
    let name = "Metadata/model_settings.config";
    let objects = [1, 2, 3].map(|id| open(id, "", "")).concat();
    let used = [1, 2, 3].map(|id| format!("<component objectid=\"{id}\"/>"));
    let whole = format!(
        "<object id=\"9\"><components>{}</components></object>",
        used.concat()
    );
    let text = model("inch", &(objects + &whole), "<item objectid=\"9\"/>");
    let loaded = read(&package(&[("3D/3dmodel.model", &text), (name, &config)]));
    for (faces, counts) in [
        (vec![[5, 6, 7]], "6 3 4 3"),
        (vec![[1, 2, 3], [9, 10, 11]], "8 4 3 4"),
    ] {
        let done = filled(&loaded, &faces);
        let after = parts_of(&done.bytes)[name].clone();
        let found = after.split("face_count=\"").skip(1);
        let found: Vec<&str> = found.map(|rest| &rest[..1]).collect();
        assert_eq!(found.join(" "), counts);
    }
}

#[test]
fn heights_of_layers_that_slicers_drop_are_named() {
    let files = [
        "Metadata/Slic3r_PE_layer_heights_profile.txt",
        "Metadata/layer_heights_profile.txt",
        "Metadata/other.txt",
    ];
    for file in files {
        let objects = open(1, "", "") + &open(2, "", "");
        let objects = objects.replace("id=\"1\"", "id=\"1\" name=\"low\"");
        let items = "<item objectid=\"1\"/><item objectid=\"2\"/>";
        let bytes = package(&[
            ("3D/3dmodel.model", &model("millimeter", &objects, items)),
            (file, "object_id=1|0;0.2"),
        ]);
        let loaded = read(&bytes);
        // Moving the top by less than a micrometre leaves the heights.
        for (z, is_other) in [(4.0, false), (4.0009, false), (4.002, true)] {
            let (mut mesh, origins) = without(&loaded, 0);
            mesh.positions[3].z = z;
            let (_, notes) = rewritten(&loaded, (mesh, origins));
            let named: Vec<&String> = notes.iter().filter(|n| n.contains("layer")).collect();
            match is_other && file != files[2] {
                false => assert_eq!(named, Vec::<&String>::new()),
                true => assert!(named[0].contains(file) && named[0].ends_with(": low")),
            }
        }
    }
}

#[test]
fn names_of_parts_may_have_backslashes() {
    let text = model("inch", &open(1, "", " paint_seam=\"8\""), ITEM);
    let rels = "<Relationships><Relationship Target=\"/3D/3dmodel.model\" Id=\"r\" \
                Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
    let config = "Metadata\\Slic3r_PE_model.config";
    let volumes = "<config><object id=\"1\"><volume firstid=\"0\" lastid=\"0\"/><volume firstid=\"1\" lastid=\"2\"/></object></config>";
    let bytes = package(&[
        ("_rels\\.rels", rels),
        ("3D\\3dmodel.model", &text),
        (config, volumes),
    ]);
    let done = filled(&read(&bytes), &[[1, 2, 3]]);
    assert_eq!(done.notes, Vec::<String>::new());
    let parts = parts_of(&done.bytes);
    assert!(parts["3D\\3dmodel.model"].contains("paint_seam"));
    assert!(parts[config].contains("lastid=\"3\""), "{}", parts[config]);
    assert_eq!(parts.len(), 3);
    assert_eq!(read(&done.bytes).mesh.faces.len(), 4);
}
