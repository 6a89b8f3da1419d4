//! `isomend view`: the steps of a session, its choices, and its saved files.

use std::collections::HashMap;
use std::fs;

use crate::desk::{self, Desk};
use crate::served::{Served, in_ball};
use crate::shapes::{cut, open_cube, sphere};
use isomend::io::{Format, read_path};
use serde_json::{Value, json};

fn fill(hole: usize) -> Value {
    json!({ "kind": "fill", "params": { "holes": [hole] } })
}

/// The 32-bit numbers of an array.
fn numbers(bytes: &[u8]) -> Vec<u32> {
    let number = |b: &[u8]| u32::from_le_bytes(b.try_into().unwrap());
    bytes.chunks(4).map(number).collect()
}

/// An array of triples: the ranges `kept` of the old triples, followed by the new ones.
fn put_together(old: &[u32], kept: &[u32], new: &[u32]) -> Vec<u32> {
    let ranges = kept.chunks(2);
    let stays = ranges.flat_map(|r| old[3 * r[0] as usize..3 * r[1] as usize].to_vec());
    stays.chain(new.iter().copied()).collect()
}

/// Asserts that the changes from one mesh to another, as they are sent, give the same mesh as all of its data.
#[track_caller]
fn assert_delta(served: &Served, old: u64, new: u64) {
    let (_, before) = served.arrays(&format!("api/mesh/{old}"));
    let (header, after) = served.arrays(&format!("api/mesh/{new}"));
    assert_eq!(header["from"], Value::Null);
    let (header, delta) = served.arrays(&format!("api/mesh/{new}?from={old}"));
    assert_eq!(header["from"], old);
    let kept = numbers(&delta("kept_vertices"));
    let positions = put_together(
        &numbers(&before("positions")),
        &kept,
        &numbers(&delta("positions")),
    );
    assert!(positions == numbers(&after("positions")));
    let stays = kept.chunks(2).flat_map(|r| r[0]..r[1]);
    let number: HashMap<u32, u32> = stays.zip(0..).collect();
    let old_faces = numbers(&before("faces"));
    let renumbered: Vec<u32> = old_faces
        .iter()
        .map(|v| number.get(v).copied().unwrap_or(u32::MAX))
        .collect();
    let faces = put_together(
        &renumbered,
        &numbers(&delta("kept_faces")),
        &numbers(&delta("faces")),
    );
    assert!(faces == numbers(&after("faces")));
    for (array, runs) in [("origin", "origin_runs"), ("region", "region_runs")] {
        let size = if array == "origin" { 1 } else { 2 };
        let whole: Vec<u32> = after(array).chunks(size).map(|b| b[0].into()).collect();
        let runs = numbers(&delta(runs));
        let value = |face: usize| {
            let run = runs.chunks(2).take_while(|r| r[0] as usize <= face);
            run.last().unwrap()[1]
        };
        assert!((0..whole.len()).all(|f| whole[f] == value(f)), "{array}");
    }
}

#[test]
fn only_changes_of_a_mesh_are_sent() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    served.step(&fill(1));
    assert_delta(&served, 0, 1);
    assert_delta(&served, 1, 0);
    let mask = in_ball(&served, [0.0, 0.0, -1.0], 0.5);
    served.step(&json!({ "kind": "restore", "mask": mask, "params": { "keep_shape": 0.5 } }));
    assert_delta(&served, 1, 2);
    let (header, _) = served.arrays("api/mesh/1?from=2");
    assert_eq!(header["from"], Value::Null, "what was cut out is sent");
    let (_, array) = served.arrays("api/mesh/2");
    let origins = array("origin");
    assert!(
        [0, 1, 2].iter().all(|o| origins.contains(o)),
        "of the file, of the step, of the one before"
    );
}

#[test]
fn steps_can_be_undone_and_redone() {
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
    let post = |name: &str, body: Value| served.post(&format!("api/{name}"), &body);
    assert_eq!(post("undo", json!({})).json()["current"], 0);
    assert_eq!(post("undo", json!({})).status, 409);
    assert_eq!(served.state()["holes"].as_array().unwrap().len(), holes);
    assert_eq!(post("redo", json!({})).json()["current"], 1);
    assert_eq!(post("goto", json!({ "id": 0 })).json()["current"], 0);
    assert_eq!(post("goto", json!({ "id": 5 })).status, 404);
    let state = served.step(&fill(2));
    let states = state["states"].as_array().unwrap().iter();
    let ids: Vec<&Value> = states.map(|s| &s["id"]).collect();
    assert_eq!(ids, [0, 2]);
    assert_eq!(served.get("api/mesh/1").status, 404);
    let mask = in_ball(&served, [0.0, 0.0, -1.0], 0.5);
    let state =
        served.step(&json!({ "kind": "restore", "mask": mask, "params": { "keep_shape": 0.5 } }));
    assert_eq!(
        state["states"][2]["command"],
        json!(["restore", "--keep-shape", "0.5"])
    );
}

#[test]
fn the_summary_of_a_repair_is_its_verdict() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let state = served.step(&json!({ "kind": "repair", "params": { "skip": ["holes"] } }));
    assert_eq!(
        state["states"][1]["command"],
        json!(["repair", "--skip", "holes"])
    );
    let summary = state["states"][1]["summary"].as_str().unwrap();
    assert!(
        summary.starts_with("watertight and printable: no"),
        "{summary}"
    );
}

#[test]
fn previews_are_not_part_of_the_history_until_adopted() {
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

/// Two halves of a ball whose borders face each other across a gap, so that a fill of all holes joins them.
fn halves(desk: &Desk) -> isomend::Mesh {
    let mut mesh = cut(&sphere(8), |p| p.z.abs() < 0.12);
    for p in &mut mesh.positions {
        *p = p.as_vec3().as_dvec3();
    }
    desk.save("halves.ply", &mesh, Format::Ply);
    mesh
}

#[test]
fn an_unedited_mesh_is_saved_unchanged() {
    let desk = Desk::new();
    let mesh = halves(&desk);
    let served = Served::new(&desk, &["halves.ply"]);
    served.save("mesh", "copy.ply");
    let same =
        fs::read(desk.path("halves.ply")).unwrap() == fs::read(desk.path("copy.ply")).unwrap();
    assert!(same, "the copy has other bytes");
    for name in ["copy.obj", "copy.glb"] {
        served.save("mesh", name);
        let saved = read_path(&desk.path(name), None).unwrap().mesh;
        assert_eq!(saved, mesh, "{name}");
    }
    let shell = served.get("api/recipe").json()["shell"].to_string();
    assert!(
        shell.contains("isomend convert halves.ply -o copy.glb"),
        "{shell}"
    );
}

#[test]
fn borders_that_are_kept_open_stay_open() {
    let desk = Desk::new();
    let mesh = halves(&desk);
    let served = Served::new(&desk, &["halves.ply"]);
    let filled = |params: Value| {
        served.step(&json!({ "kind": "fill", "params": params }));
        let state = served.state();
        let faces = state["states"][1]["faces"].as_u64().unwrap() as usize;
        served.post("api/undo", &json!({}));
        (faces, state["holes"].as_array().unwrap().len())
    };
    assert_eq!(
        filled(json!({})).1,
        0,
        "borders that face each other are joined"
    );
    let (faces, holes) = filled(json!({ "flat": [1], "keep_open": [2] }));
    assert!(
        faces > mesh.faces.len() && holes == 1,
        "{holes} holes are open"
    );
}

#[cfg(unix)]
#[test]
fn unsaved_steps_are_kept_and_resumed() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    served.step(&fill(1));
    let session = desk.session().unwrap();
    let name = session.file_name().unwrap().to_string_lossy().into_owned();
    assert!(name.starts_with("ball.ply-"), "{name}");
    let mask = in_ball(&served, [0.0, 0.0, -1.0], 0.5);
    served.step(&json!({ "kind": "restore", "mask": mask }));
    served.save("mesh", "first.ply");
    assert!(!session.exists(), "all is saved");
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
    fs::write(&session, b"{").unwrap();
    let refused = desk.run(&["view", "ball.ply", "--resume", "--no-browser"]);
    desk::assert_code(&refused, 1);
    assert!(desk::text(&refused.stderr).contains("is not the file of a session"));
}

#[test]
fn steps_of_several_earlier_sessions_are_kept() {
    let desk = Desk::new();
    let nothing = desk.run(&["view", "ball.ply", "--resume", "--no-browser"]);
    desk::assert_code(&nothing, 1);
    let said = desk::text(&nothing.stderr).replace('\n', " ");
    assert!(
        said.contains("no unsaved steps of ball.ply are kept"),
        "{said}"
    );
    for earlier in 0..4 {
        let served = Served::new(&desk, &["ball.ply"]);
        assert_eq!(served.state()["earlier"].is_string(), earlier > 0);
        served.step(&fill(1));
        // The file that was named has another name now.
        assert!(served.state()["earlier"].is_null());
        assert_eq!(served.signalled("-INT").0, Some(0));
        let folder = desk.session().unwrap();
        let files = fs::read_dir(folder.parent().unwrap()).unwrap();
        let names = files.map(|file| file.unwrap().file_name().to_string_lossy().into_owned());
        assert_eq!(
            names.filter(|name| name.contains("ball.ply-")).count(),
            earlier + 1
        );
    }
}

/// The choices on the current mesh: the action for each hole by its number, and the number of marked faces.
fn chosen(served: &Served) -> (Value, u64) {
    let state = served.state();
    (state["choices"].clone(), state["marked"].as_u64().unwrap())
}

#[test]
fn choices_follow_their_rims_through_steps() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let post = |name: &str, body: Value| served.post(&format!("api/{name}"), &body);
    let mask = in_ball(&served, [0.0, 0.0, -1.0], 0.5);
    let holes = json!({ "1": "open", "2": "flat" });
    let answer = post("choices", json!({ "id": 0, "holes": holes, "mask": mask }));
    assert_eq!(answer.status, 200, "{}", answer.json());
    let (actions, marked) = chosen(&served);
    assert_eq!(actions, holes);
    assert!(marked > 0);
    assert_eq!(served.get("api/marks/0").json()["runs"], mask);
    for wrong in [
        json!({ "id": 0, "holes": { "9": "open" } }),
        json!({ "id": 0, "mask": [[0, 99999]] }),
    ] {
        assert_eq!(post("choices", wrong).status, 422);
    }
    assert_eq!(
        post("choices", json!({ "id": 0, "holes": { "1": "eat" } })).status,
        400
    );
    assert_eq!(post("choices", json!({ "id": 9 })).status, 404);
    // Hole 2 is filled, and hole 1 keeps its number. The marked faces are then replaced, and the new ones are the last region.
    served.step(&fill(2));
    assert_eq!(chosen(&served), (json!({ "1": "open" }), marked));
    let mask = served.get("api/marks/1").json()["runs"].clone();
    served.step(&json!({ "kind": "restore", "mask": mask }));
    let (actions, now) = chosen(&served);
    assert_eq!(
        actions,
        json!({ "1": "open" }),
        "its vertices have other numbers"
    );
    let parts = served.arrays("api/mesh/2").1("origin");
    let new = parts.iter().filter(|origin| **origin == 1).count() as u64;
    assert_eq!(now, 0, "no face is marked after the step");
    let region = json!({ "name": "last region", "count": new, "gone": 0 });
    assert_eq!(served.state()["masks"], json!([region]));
    post("undo", json!({}));
    post("undo", json!({}));
    assert_eq!(chosen(&served), (holes, marked));
    post("redo", json!({}));
    post("redo", json!({}));
    assert_eq!(chosen(&served), (json!({ "1": "open" }), 0));
    assert_eq!(served.state()["masked"], true);
}

#[test]
fn chosen_sharp_edges_are_kept_and_continued() {
    let desk = Desk::new();
    desk.save("cube.ply", &open_cube(), Format::Ply);
    let served = Served::new(&desk, &["cube.ply"]);
    let state = served.state();
    let ends = state["crease_ends"].as_array().unwrap().clone();
    assert_eq!((ends.len(), &state["creases"]), (5, &json!([])));
    let of = |ends: &[Value], count: usize| {
        let own = |hole: u64| ends.iter().filter(move |end| end["hole"] == hole);
        let hole = (1..=2).find(|&hole| own(hole).count() == count).unwrap();
        let ids: Vec<Value> = own(hole).take(2).map(|end| end["id"].clone()).collect();
        (hole as usize, json!(ids))
    };
    let (_, pair) = of(&ends, 2);
    let (corner, other) = of(&ends, 3);
    let choose = |pairs: Value| served.post("api/choices", &json!({ "id": 0, "creases": pairs }));
    assert_eq!(choose(json!([pair, other])).status, 200);
    assert_eq!(served.state()["creases"], json!([pair, other]));
    assert_eq!(choose(json!([[1, 9]])).status, 422);
    assert_eq!(choose(json!([[1]])).status, 400);
    // One hole is filled with its edge; the choice for the other hole stays, with the new numbers of its ends.
    let params = json!({ "holes": [corner], "crease": [] });
    served.step(&json!({ "kind": "fill", "params": params }));
    let state = served.state();
    assert_eq!(state["crease_ends"].as_array().unwrap().len(), 2);
    assert_eq!(state["creases"], json!([[1, 2]]));
    served.step(&json!({ "kind": "fill", "params": { "holes": [1], "crease": [[1, 2]] } }));
    let state = served.state();
    let last = state["states"].as_array().unwrap().last().unwrap().clone();
    assert_eq!(last["report"]["regions"][0]["closed_by"], "sides");
    let command = last["command"].to_string();
    assert!(
        command.contains("--crease") && command.contains("1+2"),
        "{command}"
    );
    served.post("api/undo", &json!({}));
    served.post("api/undo", &json!({}));
    assert_eq!(served.state()["creases"], json!([pair, other]));
}

#[test]
fn holes_that_get_other_numbers_keep_their_choices() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    served.post("api/choices", &json!({ "id": 0, "holes": { "2": "open" } }));
    let step = json!({ "kind": "fill", "params": { "keep_open": [2] }, "preview": true });
    served.post("api/step", &step);
    let state = served.wait(|s| s["busy"].is_null());
    assert_eq!(state["states"].as_array().unwrap().len(), 2);
    // A choice made during a preview applies when the preview is adopted.
    served.post("api/choices", &json!({ "id": 0, "holes": { "2": "flat" } }));
    served.post("api/adopt", &json!({ "id": 1 }));
    assert_eq!(
        chosen(&served).0,
        json!({ "1": "flat" }),
        "hole 2 is hole 1 now"
    );
}

#[cfg(unix)]
#[test]
fn choices_are_kept_for_a_resumed_session() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let mask = in_ball(&served, [0.0, 0.0, -1.0], 0.5);
    served.post(
        "api/choices",
        &json!({ "id": 0, "holes": { "1": "open" }, "mask": mask }),
    );
    let before = chosen(&served);
    let (_, said) = served.signalled("-INT");
    assert!(said.contains("--resume"), "choices without a step: {said}");
    let served = Served::new(&desk, &["--resume", "ball.ply"]);
    served.wait(|s| s["busy"].is_null());
    assert_eq!(chosen(&served), before);
    served.step(&fill(2));
    served.post("api/choices", &json!({ "id": 1, "holes": { "1": "flat" } }));
    let after = chosen(&served);
    served.signalled("-INT");
    let served = Served::new(&desk, &["--resume", "ball.ply"]);
    served.wait(|s| s["busy"].is_null() && s["current"] == 1);
    assert_eq!(chosen(&served), after);
    served.post("api/undo", &json!({}));
    assert_eq!(chosen(&served), before);
}

#[test]
fn faces_keep_their_origin_through_a_repair() {
    let desk = Desk::new();
    // A duplicate vertex and a duplicate face at the beginning: a repair changes all other numbers, as in real scans.
    let mut mesh = desk::ball();
    let faces = mesh.faces.len();
    let first = mesh.positions[0];
    mesh.positions.insert(0, first);
    for face in &mut mesh.faces {
        *face = face.map(|v| v + 1);
    }
    mesh.faces.insert(0, mesh.faces[9]);
    desk.save("twice.ply", &mesh, Format::Ply);
    let served = Served::new(&desk, &["twice.ply"]);
    served.step(&json!({ "kind": "repair", "params": { "skip": ["holes"] } }));
    let origins = served.arrays("api/mesh/1").1("origin");
    assert_eq!(origins.len(), faces);
    assert!(origins.iter().all(|origin| *origin == 0), "of the file");
    served.step(&fill(1));
    let origins = served.arrays("api/mesh/2").1("origin");
    let of_file = origins.iter().filter(|origin| **origin == 0).count();
    assert_eq!(of_file, faces);
    assert!(origins[faces..].iter().all(|origin| *origin == 1));
}

/// Two balls that share a vertex: the repair moves the faces round it to a new vertex nearby, so that no face of the input has the same
/// positions.
#[test]
fn faces_whose_corners_a_repair_moves_apart_keep_their_origin() {
    let desk = Desk::new();
    let ball = sphere(6);
    let top = (0..ball.positions.len())
        .max_by(|v, w| ball.positions[*v].z.total_cmp(&ball.positions[*w].z));
    let top = top.unwrap();
    let first = ball.positions.len() as u32;
    let mut mesh = ball.clone();
    let other = ball
        .positions
        .iter()
        .map(|p| glam::DVec3::new(p.x, p.y, 2.0 * ball.positions[top].z - p.z));
    mesh.positions.extend(other);
    let corner = |v: u32| if v as usize == top { v } else { first + v };
    mesh.faces.extend(
        ball.faces
            .iter()
            .map(|[a, b, c]| [a, c, b].map(|v| corner(*v))),
    );
    for (name, format) in [("pinched.ply", Format::Ply), ("pinched.obj", Format::Obj)] {
        desk.save(name, &mesh, format);
        let served = Served::new(&desk, &[name]);
        served.step(&json!({ "kind": "repair", "params": {} }));
        let (said, arrays) = served.arrays("api/mesh/1");
        let origins = arrays("origin");
        assert_eq!(origins.len(), mesh.faces.len(), "{said}");
        assert!(origins.iter().all(|origin| *origin == 0), "{origins:?}");
    }
}
