//! Marked faces on the page of `isomend view`: named masks across steps, undo and redo; steps that leave the mask as it is.

use serde_json::{Value, json};

use crate::desk::Desk;
use crate::served::{Served, in_ball};

/// The number of faces in ranges.
fn count(runs: &Value) -> u64 {
    let runs = runs.as_array().unwrap().iter();
    runs.map(|run| run[1].as_u64().unwrap() - run[0].as_u64().unwrap())
        .sum()
}

fn marks(served: &Served, id: u64) -> Value {
    served.get(&format!("api/marks/{id}")).json()["runs"].clone()
}

fn named(served: &Served, id: u64, name: &str) -> Value {
    served.get(&format!("api/masks/{id}?name={name}")).json()["runs"].clone()
}

#[track_caller]
fn keep(served: &Served, id: u64, name: &str, mask: &Value) {
    let wanted = json!({ "id": id, "name": name, "mask": mask });
    let answer = served.post("api/mask/keep", &wanted);
    assert_eq!(answer.status, 200, "{}", answer.json());
}

#[track_caller]
fn row(served: &Served, name: &str) -> Value {
    let state = served.state();
    let rows = state["masks"].as_array().unwrap().iter();
    let mut rows = rows.filter(|row| row["name"] == name);
    let found = rows.next().unwrap_or(&Value::Null).clone();
    assert!(rows.next().is_none(), "two masks have the name {name}");
    found
}

#[test]
fn named_masks_are_carried_over_steps_and_come_back_with_undo() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let wide = in_ball(&served, [0.0, 0.0, -1.0], 0.8);
    let narrow = in_ball(&served, [0.0, 0.0, -1.0], 0.4);
    let apart = in_ball(&served, [0.0, -1.0, 0.0], 0.4);
    keep(&served, 0, "wide", &wide);
    keep(&served, 0, "apart", &apart);
    let whole = json!({ "name": "wide", "count": count(&wide), "gone": 0 });
    assert_eq!(row(&served, "wide"), whole);
    // A fill keeps all faces.
    served.step(&json!({ "kind": "fill", "params": { "holes": [2] } }));
    assert_eq!(row(&served, "wide"), whole);
    assert_eq!(named(&served, 1, "wide"), wide);
    // A restoration replaces some; the list says how many are gone.
    served.step(&json!({ "kind": "restore", "mask": narrow }));
    let now = row(&served, "wide");
    let (left, gone) = (
        now["count"].as_u64().unwrap(),
        now["gone"].as_u64().unwrap(),
    );
    assert!(
        gone >= count(&narrow) && left + gone == count(&wide),
        "{now}"
    );
    assert_eq!(row(&served, "apart")["gone"], 0);
    // A mask that is stored after the step is there before it too.
    let late = in_ball(&served, [-1.0, 0.0, 0.0], 0.4);
    keep(&served, 2, "late", &late);
    served.post("api/undo", &json!({}));
    assert_eq!(row(&served, "wide"), whole);
    assert_eq!(named(&served, 1, "wide"), wide);
    assert_eq!(row(&served, "late")["count"], count(&late));
    served.post("api/redo", &json!({}));
    assert_eq!(row(&served, "wide"), now);
    assert_eq!(named(&served, 2, "late"), late);
    // A mask that is dropped does not come back.
    let dropped = served.post("api/mask/drop", &json!({ "name": "wide" }));
    assert_eq!(dropped.status, 200);
    for way in ["undo", "undo", "redo"] {
        served.post(&format!("api/{way}"), &json!({}));
        assert!(row(&served, "wide").is_null());
    }
}

#[test]
fn wrong_masks_are_refused() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    for (wanted, status) in [
        (json!({ "id": 0, "name": "", "mask": [[0, 1]] }), 422),
        (json!({ "id": 0, "name": "a\nb", "mask": [[0, 1]] }), 422),
        (json!({ "id": 0, "name": "a", "mask": [] }), 422),
        (
            json!({ "id": 0, "name": "a", "mask": [[0, 1_000_000]] }),
            422,
        ),
        (json!({ "id": 9, "name": "a", "mask": [[0, 1]] }), 404),
    ] {
        let answer = served.post("api/mask/keep", &wanted);
        assert_eq!(answer.status, status, "{wanted}: {}", answer.json());
    }
    let dropped = served.post("api/mask/drop", &json!({ "name": "a" }));
    assert_eq!(dropped.status, 404);
    assert_eq!(served.get("api/masks/0?name=a").status, 404);
    assert_eq!(served.state()["masks"], json!([]));
}

#[test]
fn a_step_with_faces_of_its_own_leaves_the_mask() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let mask = in_ball(&served, [0.0, 0.0, -1.0], 0.6);
    let stroke = in_ball(&served, [0.0, -0.5, -0.85], 0.4);
    let apart = in_ball(&served, [0.0, -1.0, 0.2], 0.3);
    let choice = served.post("api/choices", &json!({ "id": 0, "mask": mask }));
    assert_eq!(choice.status, 200);
    keep(&served, 0, "kept", &mask);
    keep(&served, 0, "apart", &apart);
    let params = json!({ "extent": { "strength": 0.5 } });
    let smooth = json!({ "kind": "fair", "params": params, "mask": stroke, "keep_marks": true });
    let state = served.step(&smooth);
    assert_eq!(state["states"][1]["command"][0], "fair");
    // The mask covers the faces that replace marked ones, and no others of the stroke.
    let now = marks(&served, 1);
    let ratio = count(&now) as f64 / count(&mask) as f64;
    assert!((0.8..1.25).contains(&ratio), "{ratio}");
    assert_eq!(now, named(&served, 1, "kept"));
    assert_eq!(row(&served, "kept")["gone"], 0);
    let origins = served.arrays("api/mesh/1").1("origin");
    let is_marked = |face: usize| {
        let mut runs = now.as_array().unwrap().iter();
        let end = |run: &Value, k: usize| run[k].as_u64().unwrap() as usize;
        runs.any(|run| end(run, 0) <= face && face < end(run, 1))
    };
    let new: Vec<usize> = (0..origins.len()).filter(|f| origins[*f] == 1).collect();
    let marked = new.iter().filter(|face| is_marked(**face)).count();
    assert!(0 < marked && marked < new.len(), "{marked}");
    served.post("api/undo", &json!({}));
    assert_eq!(marks(&served, 0), mask);
    assert_eq!(named(&served, 0, "kept"), mask);
    // The recipe repeats the step.
    served.post("api/redo", &json!({}));
    served.save("mesh", "saved.ply");
    served.save("recipe", "saved.sh");
    let script = std::fs::read_to_string(desk.path("saved.sh")).unwrap();
    assert!(
        script.contains("isomend fair") && script.contains("--strength 0.5"),
        "{script}"
    );
    // Without the switch, the mask is the region of the step.
    served.post("api/undo", &json!({}));
    served.step(&json!({ "kind": "fair", "params": params, "mask": stroke }));
    assert_eq!(marks(&served, 2), json!([]));
    assert!(count(&named(&served, 2, "last%20region")) > 0);
}

#[cfg(unix)]
#[test]
fn named_masks_are_resumed() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let mask = in_ball(&served, [0.0, 0.0, -1.0], 0.6);
    keep(&served, 0, "chin", &mask);
    served.step(&json!({ "kind": "fill", "params": { "holes": [1] } }));
    served.signalled("-INT");
    let served = Served::new(&desk, &["ball.ply", "--resume"]);
    served.wait(|state| state["current"] == 1 && state["busy"].is_null());
    assert_eq!(named(&served, 1, "chin"), mask);
    assert_eq!(named(&served, 0, "chin"), mask);
}
