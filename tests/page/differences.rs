//! `isomend view`: what a page has of the state and of the rims is not sent again.

use crate::desk::Desk;
use crate::served::Served;
use crate::shapes::{cut, sphere};
use glam::DVec3;
use isomend::Mesh;
use isomend::io::Format;
use serde_json::{Map, Value, json};

/// The lists of the state of which single rows are sent.
const LISTS: [&str; 2] = ["states", "holes"];

/// A sphere with a hole at each point of a spiral over it.
fn with_holes(count: usize) -> Mesh {
    let at = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (sin, cos) = (2.4 * i as f64).sin_cos();
        (1.0 - z * z).sqrt() * DVec3::new(cos, sin, 0.0) + DVec3::new(0.0, 0.0, z)
    };
    let centres: Vec<DVec3> = (0..count).map(at).collect();
    let near = |p: DVec3| centres.iter().any(|c| c.distance(p) < 0.07);
    cut(&sphere(60), near)
}

fn fill(hole: usize) -> Value {
    json!({ "kind": "fill", "params": { "holes": [hole] } })
}

/// A page: the state that it has, and the number of bytes of the last answer.
struct Page {
    has: Value,
    bytes: usize,
}

impl Page {
    fn new(served: &Served) -> Self {
        let answer = served.get("api/state");
        let (has, bytes) = (answer.json(), answer.body.len());
        Self { has, bytes }
    }

    /// Fetches the changes; then the page must have the whole state.
    #[track_caller]
    fn fetch(&mut self, served: &Served) {
        let known = &self.has["revision"];
        let answer = served.get(&format!("api/state?known={known}"));
        self.bytes = answer.body.len();
        let sent = answer.json();
        assert_eq!(&sent["known"], known, "the changes are sent");
        self.has = completed(&self.has, &sent);
        assert_eq!(self.has, served.state());
    }
}

/// The state after changes were sent: unchanged members and rows are taken from the known state.
fn completed(known: &Value, sent: &Value) -> Value {
    let row = |list: &str, index: u64, id: u64| {
        let mut row = known[list][index as usize].clone();
        row["id"] = json!(id);
        row
    };
    let mut all: Map<String, Value> = known.as_object().unwrap().clone();
    for (name, value) in sent.as_object().unwrap() {
        if name == "known" {
            continue;
        }
        let Some(list) = LISTS.iter().find(|list| *list == name) else {
            all.insert(name.clone(), value.clone());
            continue;
        };
        let parts = value.as_array().unwrap().iter();
        let rows = parts.flat_map(|part| match part.as_array() {
            None => vec![part.clone()],
            Some(numbers) => {
                let [first, end, id] = [0, 1, 2].map(|i: usize| numbers[i].as_u64().unwrap());
                (first..end).map(|i| row(list, i, id + i - first)).collect()
            }
        });
        all.insert(name.clone(), rows.collect());
    }
    Value::Object(all)
}

#[test]
fn a_page_gets_only_what_changed() {
    let desk = Desk::new();
    desk.save("holes.ply", &with_holes(60), Format::Ply);
    let served = Served::new(&desk, &["holes.ply"]);
    let mut page = Page::new(&served);
    let whole = page.bytes;
    assert_eq!(page.has["holes"].as_array().unwrap().len(), 60);
    page.fetch(&served);
    assert!(page.bytes < 100, "nothing changed: {} bytes", page.bytes);
    // A second page stays behind by several steps.
    let mut second = Page::new(&served);
    for hole in [3, 50] {
        served.step(&fill(hole));
        page.fetch(&served);
        assert!(page.bytes < whole / 4, "{} of {whole} bytes", page.bytes);
        assert!(page.has["states"].as_array().unwrap().len() > 1);
    }
    let choice = json!({ "id": page.has["current"], "holes": { "7": "open" } });
    assert_eq!(served.post("api/choices", &choice).status, 200);
    second.fetch(&served);
    page.fetch(&served);
    assert!(page.bytes < 300, "a choice: {} bytes", page.bytes);
    assert_eq!(second.has, page.has);
    // A preview is a state beside the history until it is taken.
    let mut preview = fill(1);
    preview["preview"] = json!(true);
    assert_eq!(served.post("api/step", &preview).status, 202);
    let state = served.wait(|s| s["busy"].is_null() && s["states"].as_array().unwrap().len() == 4);
    page.fetch(&served);
    let id = state["states"][3]["id"].clone();
    served.post("api/adopt", &json!({ "id": id }));
    page.fetch(&served);
    assert_eq!(page.has["current"], id);
    for way in ["undo", "undo", "redo"] {
        served.post(&format!("api/{way}"), &json!({}));
        page.fetch(&served);
        assert!(page.bytes < whole / 4, "{way}: {} bytes", page.bytes);
    }
    second.fetch(&served);
}

#[test]
fn a_revision_of_an_earlier_program_gives_the_whole_state() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    served.step(&json!({ "kind": "fill" }));
    let old = served.state()["revision"].clone();
    drop(served);
    let served = Served::new(&desk, &["--resume", "ball.ply"]);
    let state = served.wait(|s| s["busy"].is_null() && s["current"] == 1);
    let answer = served.get(&format!("api/state?known={old}")).json();
    assert_eq!(answer["known"], Value::Null);
    assert_eq!(answer, state);
    assert_eq!(served.get("api/state?known=x").status, 400);
}

#[test]
fn the_report_of_a_step_lists_only_the_holes_that_were_to_be_filled() {
    let desk = Desk::new();
    desk.save("holes.ply", &with_holes(12), Format::Ply);
    let served = Served::new(&desk, &["holes.ply"]);
    let state = served.step(&fill(2));
    let holes = state["states"][1]["report"]["holes"].as_array().unwrap();
    assert_eq!(holes.len(), 1);
    assert_eq!(holes[0]["id"], 2);
    let left = state["holes"].as_array().unwrap();
    assert!(left.len() == 11 && left.iter().all(|hole| hole["outcome"].is_null()));
}

/// The rims of a mesh as their bytes, with the numbers of the holes, as a page puts them together that has other rims.
fn rims(served: &Served, path: &str, known: &[(u32, Vec<u8>)]) -> (usize, Vec<(u32, Vec<u8>)>) {
    let (_, array) = served.arrays(path);
    let numbers = |name: &str| -> Vec<u32> {
        let bytes = array(name);
        let number = |b: &[u8]| u32::from_le_bytes(b.try_into().unwrap());
        bytes.chunks(4).map(number).collect()
    };
    let (points, starts) = (array("points"), numbers("starts"));
    let mut own = starts
        .windows(2)
        .map(|w| points[12 * w[0] as usize..12 * w[1] as usize].to_vec());
    let mut all = Vec::new();
    for part in numbers("parts").chunks(3) {
        if part[1] > part[0] {
            let kept = known[part[0] as usize..part[1] as usize].iter();
            all.extend((part[2]..).zip(kept.map(|(_, rim)| rim.clone())));
        } else {
            all.push((part[2], own.next().unwrap()));
        }
    }
    (points.len(), all)
}

#[test]
fn rims_that_a_page_has_are_not_sent_again() {
    let desk = Desk::new();
    desk.save("holes.ply", &with_holes(12), Format::Ply);
    let served = Served::new(&desk, &["holes.ply"]);
    let (bytes, before) = rims(&served, "api/rims/0", &[]);
    assert!(bytes > 12 * 12 * 10 && before.len() == 12);
    served.step(&fill(2));
    let (bytes, after) = rims(&served, "api/rims/1?from=0", &before);
    assert_eq!(bytes, 0);
    assert_eq!(after, rims(&served, "api/rims/1", &[]).1);
    assert_eq!(after.len(), 11);
    let (bytes, again) = rims(&served, "api/rims/0?from=1", &after);
    assert!(bytes > 0, "the rim of the filled hole");
    assert_eq!(again, before);
}

#[test]
fn the_coarse_version_of_a_mesh_has_its_vertices_and_faces() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let (_, whole) = served.arrays("api/mesh/0");
    let (header, coarse) = served.arrays("api/coarse/0");
    assert_eq!(header["id"], 0);
    let number = |bytes: &[u8], i: usize| {
        u32::from_le_bytes(bytes[4 * i..4 * i + 4].try_into().unwrap()) as usize
    };
    let (positions, vertices) = (whole("positions"), coarse("vertices"));
    for (i, point) in coarse("positions").chunks(12).enumerate() {
        assert_eq!(point, &positions[12 * number(&vertices, i)..][..12]);
    }
    // A mesh with fewer faces than a coarse version keeps nearly all of them.
    let faces = coarse("faces").len() / 12;
    assert_eq!(coarse("numbers").len() / 4, faces);
    assert_eq!(coarse("origin").len(), faces);
    assert!(faces > whole("faces").len() / 12 / 2);
    assert_eq!(served.get("api/coarse/9").status, 404);
}
