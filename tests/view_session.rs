//! `isomend view`: a session of steps, what is saved of it, and the recipe that does the same.

mod desk;
mod served;
mod shapes;

use std::fs;

use desk::{Desk, ball};
use isomend::io::{Contents, Format, WriteOptions, model_to_bytes, read_path};
use isomend::mesh::attributes::{Attribute, Attributes, LabelKind, Labels, Material, Role, Scalar};
use serde_json::{Value, json};
use served::{Served, in_ball};
use shapes::sphere;

fn fill(hole: usize) -> Value {
    json!({ "kind": "fill", "params": { "holes": [hole] } })
}

#[test]
fn steps_are_undone_and_what_has_changed_is_sent() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let holes = served.state()["holes"].as_array().unwrap().len();
    let state = served.step(&fill(1));
    assert_eq!(state["holes"].as_array().unwrap().len(), holes - 1);
    assert_eq!(
        state["states"][1]["command"],
        json!(["fill", "--holes", "1"])
    );
    assert_eq!(
        (&state["undo"], &state["redo"]),
        (&json!(true), &json!(false))
    );
    let count = |header: &Value, name: &str| {
        let arrays = header["arrays"].as_array().unwrap().iter();
        arrays
            .filter(|a| a["name"] == name)
            .map(|a| a["count"].as_u64().unwrap())
            .sum::<u64>()
    };
    let (whole, _) = served.arrays("api/mesh/1");
    let (delta, array) = served.arrays("api/mesh/1?from=0");
    let [old, new] = [0, 1].map(|i| state["states"][i]["faces"].as_u64().unwrap());
    assert_eq!(
        (whole["from"].clone(), count(&whole, "faces")),
        (Value::Null, new)
    );
    assert_eq!(
        (delta["from"].clone(), count(&delta, "faces")),
        (json!(0), new - old)
    );
    assert_eq!(
        array("kept_faces"),
        [[0, 0, 0, 0], (old as u32).to_le_bytes()].concat()
    );
    let (back, _) = served.arrays("api/mesh/0?from=1");
    assert_eq!((back["from"].clone(), count(&back, "faces")), (json!(1), 0));
    assert_eq!(served.post("api/undo", &json!({})).json()["current"], 0);
    assert_eq!(served.post("api/undo", &json!({})).status, 409);
    assert_eq!(served.state()["holes"].as_array().unwrap().len(), holes);
    assert_eq!(served.post("api/redo", &json!({})).json()["current"], 1);
    assert_eq!(
        served.post("api/goto", &json!({ "id": 0 })).json()["current"],
        0
    );
    assert_eq!(served.post("api/goto", &json!({ "id": 5 })).status, 404);
    let state = served.step(&fill(2));
    let ids: Vec<&Value> = state["states"]
        .as_array()
        .unwrap()
        .iter()
        .map(|s| &s["id"])
        .collect();
    assert_eq!(ids, [0, 2]);
    assert_eq!(served.get("api/mesh/1").status, 404);
    let mask = in_ball(&served, [0.0, 0.0, -1.0], 0.5);
    let state =
        served.step(&json!({ "kind": "restore", "mask": mask, "params": { "keep_shape": 0.5 } }));
    assert_eq!(
        state["states"][2]["command"],
        json!(["restore", "--keep-shape", "0.5"])
    );
    let (delta, array) = served.arrays("api/mesh/3?from=2");
    assert_eq!(delta["from"], 2);
    let origins = array("origin_runs");
    assert!(
        origins.len() >= 3 * 8,
        "of the file, of the fill, of this step"
    );
}

#[test]
fn previews_stand_beside_the_history() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let preview = |finish: &str| {
        let step = json!({ "kind": "fill", "params": { "holes": [1], "finish": finish }, "preview": true });
        assert_eq!(served.post("api/step", &step).status, 202);
        served.wait(|s| s["busy"].is_null())
    };
    preview("auto");
    let state = preview("none");
    assert_eq!(
        (&state["current"], &state["undo"]),
        (&json!(0), &json!(false))
    );
    let shown: Vec<&Value> = state["states"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|s| s["preview"] == true)
        .collect();
    assert_eq!(shown.len(), 2);
    assert_eq!(served.get("api/mesh/1").status, 200);
    assert_eq!(
        served.post("api/adopt", &json!({ "id": 2 })).json()["current"],
        2
    );
    assert_eq!(served.post("api/adopt", &json!({ "id": 1 })).status, 409);
    assert_eq!(served.post("api/discard", &json!({ "id": 1 })).status, 200);
    assert_eq!(served.get("api/mesh/1").status, 404);
    for _ in 0..5 {
        preview("auto");
    }
    let all = served.state()["states"].as_array().unwrap().len();
    assert_eq!(all, 2 + 4);
}

/// Colours, and a texture where it is wanted.
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

/// A file of the desk in a format, with what it can carry.
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

/// Runs the recipe's shell form, with the program that is tested before all others.
#[cfg(unix)]
fn run_shell(desk: &Desk, script: &str) {
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

/// Runs the recipe's table: each step's options as a file for `--config`.
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
            // The strings and flags of the table are JSON's too.
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

/// A session in a format whose steps are saved in others; the recipe must give the same bytes.
fn assert_recipe(format: Format, saved: &[&str]) {
    let desk = Desk::new();
    let name = input(&desk, format);
    let served = Served::new(&desk, &[&name]);
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
        #[cfg(unix)]
        {
            run_shell(&desk, &format!("{output}.again.sh"));
            assert!(
                fs::read(desk.path(output)).unwrap() == made,
                "{format} {output} by the shell"
            );
            fs::remove_file(desk.path(output)).unwrap();
            assert_eq!(desk.files(), before, "files that were left");
        }
        run_table(&desk, &format!("{output}.again.toml"));
        assert!(
            fs::read(desk.path(output)).unwrap() == made,
            "{format} {output} by the table"
        );
        let kept = fs::remove_file(desk.path("options.toml"));
        assert!(kept.is_ok() && desk.files().len() == before.len() + 1);
    }
}

#[test]
fn the_recipe_of_a_ply_session_gives_the_same_bytes() {
    assert_recipe(Format::Ply, &["out.ply", "out.glb", "out.stl", "out.obj"]);
}

#[test]
fn the_recipe_of_an_obj_session_gives_the_same_bytes() {
    assert_recipe(Format::Obj, &["out.obj", "out.ply"]);
}

#[test]
fn the_recipe_of_a_textured_glb_session_gives_the_same_bytes() {
    assert_recipe(Format::Glb, &["out.glb", "out.ply"]);
}

#[test]
fn the_recipe_of_an_stl_session_gives_the_same_bytes() {
    assert_recipe(Format::Stl, &["out.stl", "out.vtp"]);
}

#[test]
fn the_file_itself_can_be_saved_in_another_format_and_drawn() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    served.save("mesh", "out.obj");
    let saved = read_path(&desk.path("out.obj"), None).unwrap();
    assert_eq!(
        saved.mesh,
        read_path(&desk.path("ball.ply"), None).unwrap().mesh
    );
    served.save("report", "before.html");
    served.step(&fill(1));
    served.save("report", "after.html");
    let page = fs::read_to_string(desk.path("after.html")).unwrap();
    assert!(page.contains("isomend fill --holes 1"), "its command line");
    let answer = served.get("api/report/1");
    assert!(
        answer
            .head
            .contains("content-security-policy: sandbox allow-scripts"),
        "{}",
        answer.head
    );
    assert!(
        answer.body.starts_with(b"<!doctype html>") || answer.body.starts_with(b"<!DOCTYPE html>")
    );
    let answer = served.post(
        "api/save",
        &json!({ "kind": "mask", "path": "m.faces", "mask": [[0, 2], [5, 6]] }),
    );
    assert_eq!(answer.status, 200);
    assert_eq!(
        fs::read_to_string(desk.path("m.faces")).unwrap(),
        "0\n1\n5\n"
    );
    let loaded = served.post("api/mask/load", &json!({ "path": "m.faces" }));
    assert_eq!(loaded.json()["runs"], json!([[0, 2], [5, 6]]));
    fs::write(desk.path("far.faces"), "0\n999999\n").unwrap();
    assert_eq!(
        served
            .post("api/mask/load", &json!({ "path": "far.faces" }))
            .status,
        422
    );
}

#[test]
fn values_textures_and_defects_are_sent() {
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
    let (header, array) = served.arrays("api/values/0?name=curvature");
    assert_eq!(header["on"], "vertex");
    let float = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
    let values: Vec<f32> = array("values").chunks(4).map(float).collect();
    let sum: f32 = values.iter().sum();
    assert!(
        (sum / values.len() as f32 - 2.0).abs() < 0.2,
        "of a unit ball"
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
        !check["marks"]["border"]["faces"]
            .as_array()
            .unwrap()
            .is_empty()
    );
}

#[cfg(unix)]
#[test]
fn unsaved_steps_are_kept_and_made_again() {
    let desk = Desk::new();
    let session = ".ball.ply.isomend-session.json".to_owned();
    let served = Served::new(&desk, &["ball.ply"]);
    served.step(&fill(1));
    assert!(desk.files().contains(&session));
    let mask = in_ball(&served, [0.0, 0.0, -1.0], 0.5);
    served.step(&json!({ "kind": "restore", "mask": mask }));
    served.save("mesh", "first.ply");
    assert!(!desk.files().contains(&session), "all is saved");
    let mask = in_ball(&served, [-1.0, 0.0, 0.0], 0.5);
    served.step(&json!({ "kind": "restore", "mask": mask }));
    let answer = served.post(
        "api/save",
        &json!({ "kind": "mesh", "path": "second.ply", "id": 3 }),
    );
    assert_eq!(answer.status, 200);
    served.post("api/undo", &json!({}));
    served.post("api/redo", &json!({}));
    let mask = in_ball(&served, [0.0, -1.0, 0.0], 0.5);
    served.step(&json!({ "kind": "restore", "mask": mask }));
    let (code, said) = served.signalled("-INT");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("--resume"), "{said}");
    let served = Served::new(&desk, &["--resume", "ball.ply"]);
    let state = served.wait(|s| s["busy"].is_null());
    assert_eq!(state["current"], 4);
    served.post("api/undo", &json!({}));
    let wanted = json!({ "kind": "mesh", "path": "again.ply" });
    assert_eq!(served.post("api/save", &wanted).status, 200);
    assert_eq!(
        fs::read(desk.path("again.ply")).unwrap(),
        fs::read(desk.path("second.ply")).unwrap()
    );
    let (code, _) = served.signalled("-TERM");
    assert_eq!(code, Some(0));
    desk.save("ball.ply", &sphere(4), Format::Ply);
    fs::write(desk.path(&session), b"{").unwrap();
    let refused = desk.run(&["view", "ball.ply", "--resume", "--no-browser"]);
    desk::assert_code(&refused, 1);
    assert!(desk::text(&refused.stderr).contains("is not the file of a session"));
}
