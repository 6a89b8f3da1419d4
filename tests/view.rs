//! `isomend view`: the server, as a page and as a foe asks it.

mod desk;
mod served;
mod shapes;

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;

use desk::{Desk, ball};
use isomend::io::{Contents, Format, WriteOptions, model_to_bytes, read_path};
use isomend::mesh::attributes::{Attribute, Attributes, LabelKind, Labels, Material, Role, Scalar};
use serde_json::{Value, json};
use served::Served;
use shapes::sphere;

/// A fill that takes a second or more.
fn long_fill() -> Value {
    json!({ "kind": "fill", "params": { "voxel": { "length": 0.005 }, "holes": [1] } })
}

fn fill(hole: usize) -> Value {
    json!({ "kind": "fill", "params": { "holes": [hole] } })
}

/// The faces of a mesh in a ball, as ranges.
fn in_ball(served: &Served, centre: [f32; 3], radius: f32) -> Value {
    let current = served.state()["current"].as_u64().unwrap();
    let (header, array) = served.arrays(&format!("api/mesh/{current}"));
    let float = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
    let positions: Vec<f32> = array("positions").chunks(4).map(float).collect();
    let index = |b: &[u8]| u32::from_le_bytes(b.try_into().unwrap()) as usize;
    let faces: Vec<usize> = array("faces").chunks(4).map(index).collect();
    let origin: Vec<f32> = (0..3)
        .map(|k| header["centre"][k].as_f64().unwrap() as f32)
        .collect();
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for (f, corners) in faces.chunks(3).enumerate() {
        let distance = |v: &usize| {
            let d = (0..3).map(|k| positions[3 * v + k] + origin[k] - centre[k]);
            d.map(|x| x * x).sum::<f32>().sqrt()
        };
        if !corners.iter().all(|v| distance(v) < radius) {
            continue;
        }
        match runs.last_mut() {
            Some(last) if last[1] == f => last[1] += 1,
            _ => runs.push([f, f + 1]),
        }
    }
    assert!(!runs.is_empty());
    json!(runs)
}

#[test]
fn the_page_is_served_with_a_strict_policy() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    for (name, kind) in [
        ("", "text/html"),
        ("page.css", "text/css"),
        ("page.js", "text/javascript"),
        ("worker.js", "text/javascript"),
        ("api/state", "application/json"),
    ] {
        let answer = served.get(name);
        assert_eq!(answer.status, 200, "{name}");
        for header in [
            &format!("content-type: {kind}")[..],
            "content-security-policy: default-src 'none'; script-src 'self'",
            "frame-ancestors 'none'",
            "x-content-type-options: nosniff",
            "referrer-policy: no-referrer",
            "cache-control: no-store",
        ] {
            assert!(answer.head.contains(header), "{name}: {}", answer.head);
        }
        assert!(!answer.head.contains("access-control"));
    }
    assert_eq!(served.get("page.html").status, 404);
    assert_eq!(served.get("api/nothing").status, 404);
    assert_eq!(served.get("api/mesh/7").status, 404);
    assert_eq!(served.get("api/mesh/-1").status, 400);
}

#[test]
fn who_does_not_know_the_token_or_comes_from_elsewhere_is_refused() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let (host, token) = (served.host(), served.token.clone());
    let path = format!("/{token}/api/state");
    let get = |path: &str, headers: &[(&str, &str)]| served.ask("GET", path, headers, b"");
    assert_eq!(get(&path, &[("Host", &host)]).status, 200);
    let refused = |answer: served::Answer, what: &str| {
        assert_eq!(answer.status, 403, "{what}");
        assert!(answer.body.is_empty(), "{what}");
    };
    let other = if token.starts_with('A') { "B" } else { "A" };
    let wrong = format!("/{other}{}/api/state", &token[1..]);
    let short = format!("/{}/api/state", &token[..42]);
    let encoded = format!("/%{:02x}{}/api/state", token.as_bytes()[0], &token[1..]);
    for path in ["/", "/api/state", "//api/state", &wrong, &short, &encoded] {
        refused(get(path, &[("Host", &host)]), path);
    }
    let port = served.port;
    for name in [
        "evil.example".to_owned(),
        format!("evil.example:{port}"),
        "127.0.0.1".to_owned(),
        format!("127.0.0.1.evil.example:{port}"),
        format!("localhost:{}", port.wrapping_add(1)),
        String::new(),
    ] {
        refused(get(&path, &[("Host", &name)]), &name);
    }
    refused(
        get(&path, &[("Host", &host), ("Host", "evil.example")]),
        "two hosts",
    );
    let local = format!("localhost:{port}");
    assert_eq!(get(&path, &[("Host", &local)]).status, 200);
    let absolute = format!("http://evil.example:{port}{path}");
    refused(get(&absolute, &[("Host", &host)]), "absolute address");
    for origin in [
        "http://evil.example",
        "null",
        "https://127.0.0.1",
        &format!("http://127.0.0.1:{}", port ^ 1),
    ] {
        refused(get(&path, &[("Host", &host), ("Origin", origin)]), origin);
    }
    for site in ["cross-site", "same-site"] {
        refused(
            get(&path, &[("Host", &host), ("Sec-Fetch-Site", site)]),
            site,
        );
    }
    let undo = format!("/{token}/api/undo");
    let json = ("Content-Type", "application/json");
    let post = |headers: &[(&str, &str)]| served.ask("POST", &undo, headers, b"{}");
    refused(post(&[("Host", &host)]), "no type");
    for kind in [
        "text/plain",
        "application/x-www-form-urlencoded",
        "multipart/form-data",
    ] {
        refused(post(&[("Host", &host), ("Content-Type", kind)]), kind);
    }
    refused(
        post(&[("Host", &host), json, ("Sec-Fetch-Site", "cross-site")]),
        "cross-site",
    );
    refused(
        post(&[("Host", &host), json, ("Origin", "http://evil.example")]),
        "origin",
    );
    for method in ["PUT", "DELETE", "OPTIONS", "PATCH", "TRACE"] {
        refused(served.ask(method, &path, &[("Host", &host)], b""), method);
    }
    assert_eq!(post(&[("Host", &host), json]).status, 409);
}

#[test]
fn only_files_below_the_root_are_touched() {
    let desk = Desk::new();
    let top = desk.0.path();
    fs::create_dir_all(top.join("root/sub")).unwrap();
    fs::write(top.join("secret.faces"), "1\n").unwrap();
    fs::write(top.join("root/old.ply"), "old").unwrap();
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(top, top.join("root/up")).unwrap();
        std::os::unix::fs::symlink("../secret.faces", top.join("root/link.faces")).unwrap();
        std::os::unix::fs::symlink("../new.ply", top.join("root/link.ply")).unwrap();
    }
    let served = Served::new(&desk, &["ball.ply", "--root", "root"]);
    let before = desk.files();
    let save = |path: &str, overwrite: bool| {
        let wanted = json!({ "kind": "mesh", "path": path, "overwrite": overwrite });
        served.post("api/save", &wanted)
    };
    let absolute = top.join("new.ply");
    let mut outside = vec![
        "../new.ply",
        "sub/../../new.ply",
        "/new.ply",
        absolute.to_str().unwrap(),
    ];
    if cfg!(unix) {
        outside.extend(["up/new.ply", "link.ply"]);
    }
    for path in outside {
        let answer = save(path, true);
        assert_eq!(answer.status, 403, "{path}: {}", answer.json());
    }
    for path in [
        "../secret.faces",
        "sub/../../secret.faces",
        "/etc/passwd",
        "link.faces",
    ] {
        if cfg!(unix) || path != "link.faces" {
            let answer = served.post("api/mask/load", &json!({ "path": path }));
            assert_eq!(answer.status, 403, "{path}: {}", answer.json());
        }
    }
    for path in [
        "",
        "new",
        "new.txt",
        ".bashrc",
        "sub",
        "sub/",
        "none/new.ply",
        "a\u{0}.ply",
        "new.vti",
    ] {
        assert_eq!(save(path, true).status, 422, "{path}");
    }
    assert_eq!(save("old.ply", false).status, 409);
    assert_eq!(fs::read(top.join("root/old.ply")).unwrap(), b"old");
    assert_eq!(desk.files(), before);
    assert_eq!(save("old.ply", true).status, 200);
    let answer = save("sub/new.glb", false);
    assert_eq!(answer.status, 200, "{}", answer.json());
    assert!(read_path(&top.join("root/sub/new.glb"), None).is_ok());
    for (kind, path) in [
        ("report", "a.ply"),
        ("recipe", "a.html"),
        ("mask", "a.sh"),
        ("mesh", "a.html"),
    ] {
        let answer = served.post(
            "api/save",
            &json!({ "kind": kind, "path": path, "mask": [[0, 1]] }),
        );
        assert_eq!(answer.status, 422, "{kind} {path}");
    }
    drop(served);
    let served = Served::new(&desk, &["ball.ply"]);
    let wanted = json!({ "kind": "mesh", "path": "ball.ply", "overwrite": true });
    assert_eq!(served.post("api/save", &wanted).status, 409);
}

#[test]
fn what_makes_no_sense_is_refused_and_breaks_nothing() {
    let desk = Desk::new();
    let mut served = Served::new(&desk, &["ball.ply"]);
    let step = |text: &str| served.post_bytes("api/step", text.as_bytes());
    for text in [
        "",
        "{",
        "[]",
        "null",
        "{\"kind\":\"fill\",\"mask\":[[NaN,1]]}",
        "{\"kind\":\"eat\"}",
        "\u{fffd}",
    ] {
        let answer = step(text);
        assert_eq!(answer.status, 400, "{text}");
        assert!(answer.json()["error"].is_string());
    }
    let faces = served.state()["states"][0]["faces"].as_u64().unwrap();
    let over = json!([[0, faces + 1]]);
    for mask in [
        json!([]),
        json!([[1, 1]]),
        json!([[2, 1]]),
        json!([[0, 4], [2, 6]]),
        over,
        json!([[0, u32::MAX]]),
    ] {
        let answer = served.post("api/step", &json!({ "kind": "restore", "mask": mask }));
        assert_eq!(answer.status, 422, "{mask}");
        assert_eq!(answer.json()["where"], "mask");
    }
    for mask in [
        json!([[-1, 2]]),
        json!([[0.5, 2]]),
        json!([[0, 1e99]]),
        json!([[0]]),
        json!("all"),
    ] {
        let answer = served.post("api/step", &json!({ "kind": "restore", "mask": mask }));
        assert_eq!(answer.status, 400, "{mask}");
    }
    for (kind, params) in [
        ("fill", json!({ "edge_ratio": 0.001 })),
        ("fill", json!({ "holes": [] })),
        ("fill", json!({ "holes": [0] })),
        ("fill", json!({ "voxel": { "length": -1.0 } })),
        ("fill", json!({ "steps": 0 })),
        ("fill", json!({ "colour": 1 })),
        ("fill", json!({ "max_diameter": 0.0 })),
        ("fill", json!([1])),
        ("fair", json!({ "extent": { "strength": 0.0 } })),
        ("repair", json!({ "weld": 0.0 })),
        ("repair", json!({ "weld": 0.1, "fill": { "holes": [1] } })),
    ] {
        let answer = served.post("api/step", &json!({ "kind": kind, "params": params }));
        assert_eq!(answer.status, 422, "{kind} {params}");
        assert_eq!(answer.json()["where"], "params", "{kind} {params}");
    }
    let head = format!(
        "POST /{}/api/step HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nContent-Length: 99999999999\r\n\r\n{{",
        served.token,
        served.host()
    );
    assert_eq!(served.raw(head.as_bytes()).status, 413);
    let long = vec![b' '; 100 << 10];
    assert_eq!(served.post_bytes("api/cancel", &long).status, 413);
    for name in [
        "values/0?name=attribute:none",
        "values/0?name=",
        "texture/0",
        "uv/0",
        "values/9?name=sigma",
    ] {
        assert_eq!(served.get(&format!("api/{name}")).status, 404, "{name}");
    }
    assert_eq!(served.get("api/check/0?thin=NaN").status, 422);
    // A hole that there is not is found out when the step is made.
    assert_eq!(served.post("api/step", &fill(99)).status, 202);
    let state = served.wait(|s| s["busy"].is_null());
    assert_eq!(
        (&state["current"], &state["undo"]),
        (&json!(0), &json!(false))
    );
    assert!(served.lives());
    served.step(&fill(2));
}

#[test]
fn a_step_can_be_cancelled_and_only_one_is_made_at_a_time() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let before = served.state();
    let job = served.post("api/step", &long_fill()).json()["job"].clone();
    assert_eq!(served.state()["busy"]["job"], job);
    assert_eq!(served.post("api/step", &fill(2)).status, 409);
    assert_eq!(served.post("api/undo", &json!({})).status, 409);
    assert_eq!(served.post("api/cancel", &json!({ "job": 99 })).status, 404);
    assert_eq!(
        served.post("api/cancel", &json!({ "job": job })).status,
        202
    );
    let after = served.wait(|s| s["busy"].is_null());
    for part in ["current", "states", "holes", "undo", "redo"] {
        assert_eq!(before[part], after[part], "{part}");
    }
    assert_eq!(
        served.post("api/cancel", &json!({ "job": job })).status,
        404
    );
    assert!(!desk.files().iter().any(|f| f.contains("session")));
}

#[test]
fn a_browser_that_is_closed_stops_nothing() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let mut stream = TcpStream::connect(("127.0.0.1", served.port)).unwrap();
    let ask = format!(
        "GET /{}/api/events HTTP/1.1\r\nHost: {}\r\n\r\n",
        served.token,
        served.host()
    );
    stream.write_all(ask.as_bytes()).unwrap();
    assert_eq!(served.post("api/step", &fill(1)).status, 202);
    let (mut told, mut part) = (String::new(), [0; 1024]);
    while !told.contains("event: progress") {
        let n = stream.read(&mut part).unwrap();
        assert!(n > 0, "{told}");
        told += &String::from_utf8_lossy(&part[..n]);
    }
    drop(stream);
    let state = served.wait(|s| s["busy"].is_null());
    assert_eq!(state["current"], 1, "{state}");
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
        let step = json!({ "kind": "fill", "params": { "holes": [2], "finish": finish }, "preview": true });
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

#[test]
fn listening_to_others_is_warned_of() {
    let desk = Desk::new();
    let refused = desk.run(&["view", "-", "--no-browser"]);
    desk::assert_usage(&refused, &["standard input"]);
    let refused = desk.run(&["view", "none.ply", "--no-browser"]);
    desk::assert_code(&refused, 1);
    let served = Served::new(&desk, &["ball.ply", "--listen", "0.0.0.0"]);
    assert_eq!(served.get("api/state").status, 200);
    #[cfg(unix)]
    {
        let (_, said) = served.signalled("-INT");
        assert!(said.contains("other machines"), "{said}");
    }
}
