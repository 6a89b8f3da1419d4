//! Files of earlier runs, marks on meshes with corner colours or materials, and remarks on units.

use std::fs;

use glam::DVec3;
use isomend::io::{Contents, Format, Loaded, WriteOptions, model_to_bytes, read_path};
use isomend::{Attribute, Attributes, LabelKind, Role, Scalar};

use crate::desk::{Desk, assert_code, text};
use crate::shapes::{cut, polar, sphere};

fn loaded(desk: &Desk, name: &str) -> Loaded {
    read_path(&desk.path(name), None).unwrap()
}

#[test]
fn files_of_earlier_runs_are_not_taken_for_results() {
    let desk = Desk::new();
    desk.save("whole.ply", &sphere(8), Format::Ply);
    let fill = |input: &str| desk.run(&["fill", input, "-o", "out.ply", "--patches", "new.ply"]);
    assert_code(&fill("ball.ply"), 0);
    let first = fs::read(desk.path("new.ply")).unwrap();
    let done = fill("whole.ply");
    assert_code(&done, 0);
    let said = text(&done.stderr);
    assert!(
        said.contains("there are no patches") && said.contains("is now"),
        "{said}"
    );
    assert!(!desk.path("new.ply").exists());
    assert_eq!(fs::read(desk.path("new_earlier.ply")).unwrap(), first);
    // No file remains that could be mistaken for a result.
    let done = fill("whole.ply");
    assert!(!text(&done.stderr).contains("is now"));
    // If one file cannot be written, none is.
    fs::remove_file(desk.path("out.ply")).unwrap();
    fs::create_dir(desk.path("new.ply")).unwrap();
    assert_ne!(fill("ball.ply").status.code(), Some(0));
    assert!(!desk.path("out.ply").exists());
}

#[test]
fn what_is_coloured_at_corners_or_by_materials_shows_the_mark() {
    let desk = Desk::new();
    let mesh = cut(&sphere(6), |p| polar(p) < 40.0);
    let faces = |property: &dyn Fn(usize) -> String| -> String {
        let row = |(f, [a, b, c]): (usize, &[u32; 3])| {
            format!(
                "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\" {}/>",
                property(f)
            )
        };
        mesh.faces.iter().enumerate().map(row).collect()
    };
    let point = |p: &glam::DVec3| format!("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", p.x, p.y, p.z);
    let points: String = mesh.positions.iter().map(point).collect();
    let colours = "<m:colorgroup id=\"1\"><m:color color=\"#0000FF\"/><m:color color=\"#0000A0\"/></m:colorgroup>";
    let materials = "<basematerials id=\"1\"><base name=\"a\" displaycolor=\"#0000FF\"/><base name=\"b\" displaycolor=\"#0000A0\"/></basematerials>";
    for (name, group) in [("corners", colours), ("materials", materials)] {
        let property = |f: usize| format!("pid=\"1\" p1=\"{}\"", f % 2);
        let model = format!(
            "<?xml version=\"1.0\"?><model unit=\"inch\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
             xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\"><resources>{group}<object id=\"2\" type=\"model\">\
             <mesh><vertices>{points}</vertices><triangles>{}</triangles></mesh></object></resources><build><item objectid=\"2\"/></build></model>",
            faces(&property)
        );
        let input = format!("{name}.3mf");
        fs::write(desk.path(&input), package(&model)).unwrap();
        for output in ["out.3mf", "out.ply"] {
            let done = desk.run(&["fill", &input, "-o", output, "--mark", "colour=ff0000"]);
            assert_code(&done, 0);
            let own = loaded(&desk, output);
            let corner = own
                .attributes
                .corner
                .iter()
                .find(|c| c.pool.role == Role::Colour);
            let vertex = own.attributes.vertex_role(Role::Colour);
            let face = own.attributes.face.iter().find(|a| a.role == Role::Colour);
            let colour = |f: usize, k: usize| {
                let at_corner = corner.and_then(|c| c.get(f, k));
                let at_face = || face.and_then(|a| a.get(f));
                let at_vertex = || vertex.and_then(|a| a.get(own.mesh.faces[f][k] as usize));
                let found = at_corner.or_else(at_face).or_else(at_vertex);
                // In a package that is kept, faces of the input keep their materials.
                let of_material = || {
                    let label = own.attributes.labels_of(LabelKind::Material)?.get(f)?;
                    let material = own.attributes.materials.iter().find(|m| m.name == label)?;
                    Some(
                        material
                            .colour?
                            .map(|x| f64::from(255.0 * x).round())
                            .to_vec(),
                    )
                };
                let found = found.map(|found| found[..3].to_vec());
                found.or_else(of_material).unwrap()
            };
            let kept = mesh.faces.len();
            for f in kept..own.mesh.faces.len() {
                assert_eq!(colour(f, 0), [255.0, 0.0, 0.0], "{name} {output}");
            }
            if output == "out.3mf" {
                for f in 0..kept {
                    let blue = if f % 2 == 0 { 255.0 } else { 160.0 };
                    assert_eq!(colour(f, 1), [0.0, 0.0, blue], "{name}");
                }
            }
            let says = text(&done.stderr).contains("PLY has no place for a unit");
            assert_eq!(says, output == "out.ply");
        }
    }
}

#[test]
fn a_material_through_which_the_mark_is_seen_is_named() {
    let desk = Desk::new();
    let mesh = cut(&sphere(6), |p| polar(p) < 40.0);
    let mut obj = "mtllib m.mtl\nusemtl red\n".to_owned();
    for p in &mesh.positions {
        obj += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.faces {
        obj += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    desk.text("ball.obj", &obj);
    for (colour, is_named) in [("0.5 0 0", true), ("1 1 1", false)] {
        desk.text("m.mtl", &format!("newmtl red\nKd {colour}\n"));
        let done = desk.run(&["fill", "ball.obj", "-o", "out.obj", "--mark", "hatch"]);
        assert_code(&done, 0);
        let said = text(&done.stderr);
        assert_eq!(
            said.contains("marked faces whose material"),
            is_named,
            "{said}"
        );
    }
}

#[test]
fn units_are_printed_by_commands_that_write_no_mesh() {
    let desk = Desk::new();
    let done = desk.run(&["convert", "ball.ply", "-o", "ball.3mf", "--unit", "in"]);
    assert_code(&done, 0);
    for (command, wanted) in [
        (&["inspect", "ball.3mf"][..], "lengths in mm:"),
        (
            &["check", "ball.3mf", "--min-wall", "0.5"],
            "unit of lengths:       mm",
        ),
        (&["compare", "ball.ply", "ball.3mf"], "lengths in mm:"),
    ] {
        let done = desk.run(&[command, &["--unit", "mm"]].concat());
        let said = text(&done.stdout);
        assert!(said.contains(wanted), "{said}");
        let note = text(&done.stderr);
        assert!(
            note.contains("coordinates in in, but mm was asked for"),
            "{note}"
        );
        assert!(!text(&desk.run(command).stdout).contains(" mm"));
        let done = desk.run(&[command, &["--unit", "cm", "--json", "-"]].concat());
        let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        assert_eq!(document["unit"], "cm");
        let done = desk.run(&[command, &["--json", "-"]].concat());
        let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        assert!(document.get("unit").is_none());
    }
}

/// A 3MF package with the given model.
fn package(model: &str) -> Vec<u8> {
    use std::io::{Cursor, Write};
    let mut package = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let relations = "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Target=\"/3D/a.model\" \
                     Id=\"r\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
    for (name, content) in [("_rels/.rels", relations), ("3D/a.model", model)] {
        let options = zip::write::SimpleFileOptions::default();
        package.start_file(name, options).unwrap();
        package.write_all(content.as_bytes()).unwrap();
    }
    package.finish().unwrap().into_inner()
}

#[test]
fn no_face_of_a_restoration_has_the_colour_of_the_mask() {
    let desk = Desk::new();
    let mesh = sphere(8);
    // A region with a ragged rim, so that new faces lie between three vertices of it.
    let is_red = |p: &DVec3| polar(*p) < 32.0 + 9.0 * (9.0 * p.y.atan2(p.x)).sin();
    let mut colours = Attribute::new("colour", Role::Colour, Scalar::U8, 3);
    for p in &mesh.positions {
        let colour = if is_red(p) {
            [255.0, 0.0, 0.0]
        } else {
            [0.0, 90.0, 200.0]
        };
        colours.push(Some(&colour));
    }
    let attributes = Attributes {
        vertex: vec![colours],
        ..Attributes::default()
    };
    let contents = Contents {
        mesh: &mesh,
        attributes: &attributes,
        document: None,
    };
    let written = model_to_bytes(&contents, Format::Ply, &WriteOptions::default()).unwrap();
    fs::write(desk.path("painted.ply"), written.bytes).unwrap();
    let mask = ["--colour", "ff0000"];
    let done = desk.run(
        &[
            &[
                "restore",
                "painted.ply",
                "-o",
                "whole.ply",
                "--json",
                "out.json",
            ][..],
            &mask,
        ]
        .concat(),
    );
    assert_code(&done, 0);
    assert!(text(&done.stderr).contains("keep the colour of the mask"));
    let whole = loaded(&desk, "whole.ply");
    let colours = whole.attributes.vertex_role(Role::Colour).unwrap();
    let red = |v: &u32| colours.get(*v as usize).unwrap()[..3] == [255.0, 0.0, 0.0];
    let left = whole
        .mesh
        .faces
        .iter()
        .filter(|f| f.iter().all(red))
        .count();
    assert_eq!(left, 0);
    assert!(!text(&done.stdout).contains("not known") && !text(&done.stderr).contains("not known"));
    // The report has the numbers of the written patch.
    let regions = desk.json("out.json")["regions"].clone();
    let sum = |key: &str| -> usize {
        let rows = regions.as_array().unwrap().iter();
        rows.map(|row| row[key].as_u64().unwrap() as usize).sum()
    };
    let kept = mesh
        .faces
        .iter()
        .filter(|f| !f.iter().all(|v| is_red(&mesh.positions[*v as usize])));
    let kept: Vec<[DVec3; 3]> = kept
        .map(|f| f.map(|v| mesh.positions[v as usize].as_vec3().as_dvec3()))
        .collect();
    let new = whole.mesh.faces.len() - sum("new_faces");
    let corners = |f: usize| whole.mesh.corners(f as u32);
    assert!((0..new).all(|f| kept.contains(&corners(f))));
    assert!((new..whole.mesh.faces.len()).all(|f| whole.attributes.is_patch(f)));
    assert_code(&desk.run(&["check", "whole.ply"]), 0);
}
