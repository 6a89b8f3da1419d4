//! `isomend view`: recipes of sessions give the same bytes in all formats, and values and textures are sent to the page.

use std::fs;

use crate::desk::{self, Desk, ball};
use crate::served::{Served, in_ball};
use crate::shapes::{joined, moved};
use glam::DVec3;
use isomend::Mesh;
use isomend::io::{Contents, Format, WriteOptions, model_to_bytes};
use isomend::{Attribute, Attributes, CornerAttribute, LabelKind, Labels, Material, Role, Scalar};
use serde_json::{Value, json};

fn fill(hole: usize) -> Value {
    json!({ "kind": "fill", "params": { "holes": [hole] } })
}

/// Colours of vertices, and on request texture coordinates and a material with a texture.
fn dressed(mesh: &isomend::Mesh, texture: bool) -> Attributes {
    let mut colour = Attribute::new("colour", Role::Colour, Scalar::U8, 3);
    let mut uv = Attribute::new("uv", Role::Uv(0), Scalar::F32, 2);
    for p in &mesh.positions {
        colour.push(Some(&[127.0 + 100.0 * p.x, 127.0 - 100.0 * p.y, 9.0]));
        uv.push(Some(&[0.5 + 0.4 * p.x, 0.5 + 0.4 * p.y]));
    }
    if !texture {
        return Attributes {
            vertex: vec![colour],
            ..Attributes::default()
        };
    }
    let mut material = Labels::new(LabelKind::Material);
    let skin = material.place("skin");
    material.of_face = vec![skin; mesh.faces.len()];
    let look = Material {
        name: "skin".to_owned(),
        texture: Some("skin.png".to_owned()),
        ..Material::default()
    };
    Attributes {
        vertex: vec![colour, uv],
        labels: vec![material],
        materials: vec![look],
        ..Attributes::default()
    }
}

/// Writes the ball in a format, with colours and (for GLB) a texture; returns the file's name.
fn input(desk: &Desk, format: Format) -> String {
    let mesh = ball();
    let attributes = dressed(&mesh, format == Format::Glb);
    let model = Contents {
        mesh: &mesh,
        attributes: &attributes,
        document: None,
    };
    let bytes = model_to_bytes(&model, format, &WriteOptions::default())
        .unwrap()
        .bytes;
    let name = format!("my model.{}", format.extension());
    fs::write(desk.path(&name), bytes).unwrap();
    fs::write(desk.path("skin.png"), b"\x89PNG\r\n\x1a\n and so on").unwrap();
    name
}

/// Runs the shell form of a recipe; the program under test comes first in `PATH`.
#[cfg(unix)]
pub fn run_shell(desk: &Desk, script: &str) {
    let program = assert_cmd::cargo::cargo_bin("isomend");
    let folder = program.parent().unwrap().display().to_string();
    let path = format!("{folder}:{}", std::env::var("PATH").unwrap());
    let done = std::process::Command::new("sh")
        .arg(desk.path(script))
        .env("PATH", path)
        .output()
        .unwrap();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
}

/// Runs the TOML form of a recipe: the options of each step become a file for `--config`.
fn run_table(desk: &Desk, name: &str) {
    let text = fs::read_to_string(desk.path(name)).unwrap();
    let mut parts = text.split("\n[[step]]\n");
    let between = parts
        .next()
        .unwrap()
        .lines()
        .find_map(|l| l.strip_prefix("between = "))
        .unwrap();
    for step in parts {
        let (head, options) = step.split_once("[step.options]\n").unwrap();
        let value = |key: &str| -> Value {
            let line = head
                .lines()
                .find_map(|l| l.strip_prefix(&format!("{key} = ")));
            // Strings and flags of the table are valid JSON.
            serde_json::from_str(line.unwrap()).unwrap()
        };
        fs::write(desk.path("options.toml"), options).unwrap();
        let [command, input, output] = ["command", "input", "output"].map(value);
        let word = |value: &Value| value.as_str().unwrap().to_owned();
        let done = desk.run(&[
            &word(&command),
            &word(&input),
            "-o",
            &word(&output),
            "--config",
            "options.toml",
        ]);
        desk::assert_code(&done, if value("in_part") == true { 3 } else { 0 });
    }
    let between: Vec<String> = serde_json::from_str(between).unwrap();
    for file in between {
        fs::remove_file(desk.path(&file)).unwrap();
    }
}

/// Writes the ball as OBJ with materials and texture coordinates in two charts: patches between the charts get a new material.
pub fn input_with_materials(desk: &Desk) -> String {
    let mesh = ball();
    let mut uv = Attribute::new("uv", Role::Uv(0), Scalar::F32, 2);
    let mut corners = Vec::new();
    for face in &mesh.faces {
        let points = face.map(|v| mesh.positions[v as usize]);
        let aside = if points[0].x + points[1].x + points[2].x > 0.0 {
            5.0
        } else {
            0.0
        };
        corners.push(points.map(|p| {
            uv.push(Some(&[aside + p.x, p.y]));
            uv.len() as u32 - 1
        }));
    }
    let mut attributes = dressed(&mesh, true);
    attributes.vertex.clear();
    attributes.corner = vec![CornerAttribute { pool: uv, corners }];
    attributes.libraries = vec!["skin.mtl".to_owned()];
    let model = Contents {
        mesh: &mesh,
        attributes: &attributes,
        document: None,
    };
    let bytes = model_to_bytes(&model, Format::Obj, &WriteOptions::default())
        .unwrap()
        .bytes;
    fs::write(desk.path("dressed.obj"), bytes).unwrap();
    desk.text("skin.mtl", "newmtl skin\nmap_Kd skin.png\n");
    fs::write(desk.path("skin.png"), b"\x89PNG\r\n\x1a\n and so on").unwrap();
    "dressed.obj".to_owned()
}

/// Makes the steps of a session, saves the mesh in several formats, and asserts that both forms of the recipe give the same bytes.
fn assert_recipe(desk: &Desk, name: &str, saved: &[&str]) {
    let served = Served::new(desk, &[name]);
    served.step(&json!({ "kind": "fill", "params": { "holes": [2], "keep_open": [1] } }));
    let mask = in_ball(&served, [0.0, 0.0, -1.0], 0.5);
    served.step(&json!({ "kind": "restore", "mask": mask, "params": { "keep_shape": 0.25, "fill": { "edge_ratio": 0.8 } } }));
    served.step(&fill(1));
    assert_eq!(served.post("api/undo", &json!({})).status, 200);
    let mask = in_ball(&served, [-1.0, 0.0, 0.0], 0.55);
    served.step(
        &json!({ "kind": "fair", "mask": mask, "params": { "extent": { "strength": 0.4 } } }),
    );
    for output in saved {
        served.save("mesh", output);
        let made = fs::read(desk.path(output)).unwrap();
        served.save("recipe", &format!("{output}.again.sh"));
        fs::remove_file(desk.path(output)).unwrap();
        let before = desk.files();
        // The recipe writes this file, whether it exists or not.
        let _ = fs::remove_file(desk.path("isomend_patch.mtl"));
        #[cfg(unix)]
        {
            run_shell(desk, &format!("{output}.again.sh"));
            assert!(
                fs::read(desk.path(output)).unwrap() == made,
                "{name} {output} by the shell"
            );
            fs::remove_file(desk.path(output)).unwrap();
            assert_eq!(desk.files(), before, "files that were left");
        }
        run_table(desk, &format!("{output}.again.toml"));
        assert!(
            fs::read(desk.path(output)).unwrap() == made,
            "{name} {output} by the table"
        );
        let kept = fs::remove_file(desk.path("options.toml"));
        assert!(kept.is_ok() && desk.files().len() == before.len() + 1);
    }
}

#[test]
fn the_recipe_of_a_ply_session_gives_the_same_bytes() {
    let desk = Desk::new();
    let name = input(&desk, Format::Ply);
    assert_recipe(&desk, &name, &["out.ply", "out.glb", "out.stl", "out.obj"]);
}

#[test]
fn the_recipe_of_an_obj_session_gives_the_same_bytes() {
    let desk = Desk::new();
    let name = input(&desk, Format::Obj);
    assert_recipe(&desk, &name, &["out.obj", "out.ply"]);
}

#[test]
fn the_recipe_of_an_obj_session_with_materials_gives_the_same_bytes() {
    let desk = Desk::new();
    let name = input_with_materials(&desk);
    assert_recipe(&desk, &name, &["out.obj"]);
    let saved = fs::read_to_string(desk.path("out.obj")).unwrap();
    assert!(
        saved.contains("usemtl isomend_patch"),
        "a patch between two charts"
    );
}

#[test]
fn the_recipe_of_a_textured_glb_session_gives_the_same_bytes() {
    let desk = Desk::new();
    let name = input(&desk, Format::Glb);
    assert_recipe(&desk, &name, &["out.glb", "out.ply"]);
}

#[test]
fn the_recipe_of_an_stl_session_gives_the_same_bytes() {
    let desk = Desk::new();
    let name = input(&desk, Format::Stl);
    assert_recipe(&desk, &name, &["out.stl", "out.vtp"]);
}

#[test]
fn textures_and_colours_are_sent_to_the_page() {
    let desk = Desk::new();
    let name = input(&desk, Format::Glb);
    let served = Served::new(&desk, &[&name]);
    let state = served.state();
    assert_eq!(state["texture"]["url"], "api/texture/0");
    let answer = served.get("api/texture/0");
    assert_eq!(
        (answer.status, answer.body.starts_with(b"\x89PNG")),
        (200, true)
    );
    let (header, _) = served.arrays("api/uv/0");
    assert_eq!(
        (
            header["v_up"].clone(),
            header["arrays"][0]["count"].as_u64()
        ),
        (
            json!(false),
            state["states"][0]["faces"].as_u64().map(|f| 3 * f)
        )
    );
    let colour = state["attributes"]
        .as_array()
        .unwrap()
        .iter()
        .find(|a| a["kind"] == "colour")
        .unwrap();
    let path = format!(
        "api/values/0?name=attribute:{}",
        colour["name"].as_str().unwrap()
    );
    let (header, _) = served.arrays(&path);
    assert_eq!(
        (
            header["arrays"][0]["type"].clone(),
            header["arrays"][0]["components"].clone()
        ),
        (json!("u8"), json!(4))
    );
}

#[test]
fn values_and_defects_are_sent_to_the_page() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let (header, array) = served.arrays("api/values/0?name=curvature");
    assert_eq!(header["on"], "vertex");
    let float = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
    let values: Vec<f32> = array("values").chunks(4).map(float).collect();
    let sum: f32 = values.iter().sum();
    assert!(
        (sum / values.len() as f32 - 2.0).abs() < 0.2,
        "of a unit ball"
    );
    served.step(&fill(1));
    let (_, array) = served.arrays("api/values/1?name=distance");
    let values: Vec<f32> = array("values").chunks(4).map(float).collect();
    assert!(values.iter().any(|d| *d > 0.05) && values[0] == 0.0);
    let (header, _) = served.arrays("api/values/1?name=sigma");
    assert!(header["high"].as_f64().unwrap() > 0.0);
    let check = served.get("api/check/1").json();
    assert_eq!(
        (check["sound"].clone(), check["holes"].clone()),
        (json!(false), json!(1))
    );
    assert!(
        !check["marks"]["boundary_edge"]["faces"]
            .as_array()
            .unwrap()
            .is_empty()
    );
}

#[test]
fn expected_errors_are_sent_for_every_format() {
    let desk = Desk::new();
    for format in [Format::Ply, Format::Obj, Format::Glb] {
        let name = input(&desk, format);
        let served = Served::new(&desk, &[&name]);
        assert_eq!(served.state()["errors"], false);
        assert_eq!(served.get("api/values/0?name=sigma").status, 404);
        served.step(&fill(2));
        served.step(&fill(1));
        let state = served.state();
        assert_eq!(state["errors"], true, "{name}");
        let listed = state["attributes"].as_array().unwrap().iter();
        let names: Vec<&Value> = listed.map(|a| &a["name"]).collect();
        assert!(!names.contains(&&json!("isomend_sigma")), "{names:?}");
        let (header, array) = served.arrays("api/values/2?name=sigma");
        assert_eq!(header["unit"], "in the mesh's units");
        assert_eq!(header["low"], 0.0);
        let high = header["high"].as_f64().unwrap();
        assert!(high > 0.0 && high < 1.0, "{name}: {high}");
        let float = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
        let errors: Vec<f32> = array("values").chunks(4).map(float).collect();
        let count = |id: usize| state["states"][id]["vertices"].as_u64().unwrap() as usize;
        let known = |part: &[f32]| part.iter().filter(|e| **e > 0.0).count();
        assert!(
            errors[..count(0)].iter().all(|e| *e == 0.0),
            "{name}: of the file"
        );
        // Errors of the step before are kept.
        assert!(
            known(&errors[count(0)..count(1)]) > 0,
            "{name}: of the first step"
        );
        assert!(known(&errors[count(1)..]) > 0, "{name}: of the last step");
        assert!(
            errors.iter().all(|e| e.is_nan() || *e >= 0.0),
            "{name}: no sentinel"
        );
    }
}

#[test]
fn corner_attributes_are_sent_to_the_page() {
    let desk = Desk::new();
    let name = input_with_materials(&desk);
    let served = Served::new(&desk, &[&name]);
    let state = served.state();
    let all = state["attributes"].as_array().unwrap();
    assert!(all.iter().any(|a| a["on"] == "corner"), "{all:?}");
    for attribute in all {
        let name = attribute["name"].as_str().unwrap().replace(' ', "%20");
        let (header, _) = served.arrays(&format!("api/values/0?name=attribute:{name}"));
        assert_eq!(header["on"], attribute["on"]);
        let corners = 3 * state["states"][0]["faces"].as_u64().unwrap();
        if attribute["on"] == "corner" {
            assert_eq!(header["arrays"][0]["count"], corners);
        }
    }
}

/// The expected errors of a mesh's corners, three a face; NaN where unknown.
fn errors_of_corners(served: &Served, id: usize) -> Vec<f32> {
    let float = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
    let (header, array) = served.arrays(&format!("api/values/{id}?name=sigma"));
    let errors: Vec<f32> = array("values").chunks(4).map(float).collect();
    let (_, array) = served.arrays(&format!("api/mesh/{id}"));
    let index = |b: &[u8]| u32::from_le_bytes(b.try_into().unwrap()) as usize;
    match header["on"] == "corner" {
        true => errors,
        false => array("faces").chunks(4).map(|b| errors[index(b)]).collect(),
    }
}

/// The origins of a mesh's faces: 0 the input, 1 the last step, 2 an earlier one.
fn origins(served: &Served, id: usize) -> Vec<u8> {
    let (_, array) = served.arrays(&format!("api/mesh/{id}"));
    array("origin").to_vec()
}

#[test]
fn expected_errors_of_patches_without_vertices_of_their_own_are_unknown() {
    let desk = Desk::new();
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let open = Mesh::new(corners.to_vec(), vec![[0, 2, 1], [0, 1, 3], [1, 2, 3]]);
    let both = joined(&ball(), &moved(&open, 0.5, DVec3::splat(3.0)));
    desk.save("both.ply", &both, Format::Ply);
    let served = Served::new(&desk, &["both.ply"]);
    served.step(&json!({ "kind": "fill", "params": {} }));
    let (errors, origins) = (errors_of_corners(&served, 1), origins(&served, 1));
    let unknown = |f: usize| errors[3 * f..][..3].iter().all(|e| e.is_nan());
    let found: Vec<usize> = (0..origins.len()).filter(|f| unknown(*f)).collect();
    assert_eq!(found.len(), 1, "the triangle that closes the tetrahedron");
    assert_eq!(origins[found[0]], 1);
    assert!(errors.iter().any(|e| *e > 0.0));
}

#[test]
fn expected_errors_of_a_faired_region_are_unknown() {
    let desk = Desk::new();
    for format in [Format::Ply, Format::Obj] {
        let name = input(&desk, format);
        let served = Served::new(&desk, &[&name]);
        served.step(&fill(1));
        let mask = in_ball(&served, [-1.0, 0.0, 0.0], 0.55);
        let params = json!({ "extent": { "strength": 0.4 } });
        served.step(&json!({ "kind": "fair", "mask": mask, "params": params }));
        let (errors, origins) = (errors_of_corners(&served, 2), &origins(&served, 2));
        let corners = |f: usize| 3 * f..3 * f + 3;
        let of = |wanted: u8| (0..origins.len()).filter(move |f| origins[*f] == wanted);
        let unknown = |f: usize| corners(f).filter(|corner| errors[*corner].is_nan()).count();
        let count = |wanted: u8| of(wanted).map(unknown).sum::<usize>();
        // Origin 1 is the faired region, 0 the input, 2 the fill before.
        assert!(count(1) > of(1).count(), "{name}");
        assert_eq!((count(0), count(2)), (0, 0), "{name}");
        assert!(
            of(2).flat_map(corners).any(|corner| errors[corner] > 0.0),
            "{name}"
        );
    }
}
