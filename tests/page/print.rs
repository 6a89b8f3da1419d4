//! `isomend view`: wall thickness and components for the print check.

use crate::desk::Desk;
use crate::served::Served;
use crate::shapes::{joined, moved, sheet, sphere};
use glam::DVec3;
use isomend::Mesh;
use isomend::io::Format;
use serde_json::json;

/// The 32-bit numbers of an array.
fn words(bytes: &[u8]) -> Vec<u32> {
    let word = |b: &[u8]| u32::from_le_bytes(b.try_into().unwrap());
    bytes.chunks_exact(4).map(word).collect()
}

/// A ball with radius 1, and a small one of half its thickness beside it.
fn balls() -> Mesh {
    let ball = sphere(12);
    joined(&ball, &moved(&ball, 0.5, DVec3::new(3.0, 0.0, 0.0)))
}

#[test]
fn thickness_is_sent_part_by_part() {
    let desk = Desk::new();
    let mesh = balls();
    desk.save("balls.ply", &mesh, Format::Ply);
    let served = Served::new(&desk, &["balls.ply"]);
    // The first answer only prepares the mesh.
    let (header, none) = served.arrays("api/walls/0?known=0");
    assert_eq!(header["faces"], json!(mesh.faces.len()));
    assert!(none("values").is_empty());
    let (_, all) = served.arrays("api/walls/0?known=0");
    let values: Vec<f32> = words(&all("values"))
        .into_iter()
        .map(f32::from_bits)
        .collect();
    assert_eq!(values.len(), mesh.faces.len());
    let (large, small) = values.split_at(values.len() / 2);
    for (own, thickness) in [(large, 2.0), (small, 1.0)] {
        assert!(
            own.iter().all(|t| (t / thickness - 1.0).abs() < 0.1),
            "{own:?}"
        );
    }
    let (_, rest) = served.arrays(&format!("api/walls/0?known={}", values.len() - 2));
    assert_eq!(
        words(&rest("values")),
        words(&all("values"))[values.len() - 2..]
    );
    let (_, beyond) = served.arrays(&format!("api/walls/0?known={}", u32::MAX));
    assert!(beyond("values").is_empty());
    for (path, status) in [
        ("walls/7?known=0", 404),
        ("walls/0", 400),
        ("walls/0?known=-1", 400),
        ("components/7", 404),
    ] {
        assert_eq!(served.get(&format!("api/{path}")).status, status, "{path}");
    }
}

#[test]
fn small_components_are_told_and_deleted() {
    let desk = Desk::new();
    desk.save("balls.ply", &balls(), Format::Ply);
    let served = Served::new(&desk, &["balls.ply"]);
    let (_, found) = served.arrays("api/components/0");
    let faces = words(&found("faces"));
    assert_eq!(faces, [faces[0]; 2]);
    let of_faces = words(&found("of_faces"));
    assert_eq!(
        of_faces.iter().filter(|c| **c == 1).count(),
        faces[1] as usize
    );
    let areas: Vec<f32> = words(&found("areas"))
        .into_iter()
        .map(f32::from_bits)
        .collect();
    assert!((areas[1] / areas[0] - 0.25).abs() < 1e-3, "{areas:?}");
    let skip = [
        "duplicates",
        "orientation",
        "non-manifold",
        "intersections",
        "holes",
    ];
    let step = json!({ "kind": "repair", "params": { "debris": 0.3, "skip": skip } });
    served.step(&step);
    let (_, rest) = served.arrays("api/components/1");
    assert_eq!(words(&rest("faces")), faces[..1]);
    let command = served.state()["states"][1]["command"].to_string();
    assert!(
        command.contains("--debris") && command.contains("--skip"),
        "{command}"
    );
}

#[test]
fn thickness_of_two_states_is_measured_in_turns() {
    let desk = Desk::new();
    desk.save("balls.ply", &balls(), Format::Ply);
    let served = Served::new(&desk, &["balls.ply"]);
    served.step(&json!({ "kind": "repair", "params": { "debris": 0.3 } }));
    let mut all = [Vec::<f32>::new(), Vec::new()];
    // The first request of each state prepares it, which takes the memory of the other one's preparation.
    for _ in 0..2 {
        for (id, values) in all.iter_mut().enumerate() {
            let (_, part) = served.arrays(&format!("api/walls/{id}?known={}", values.len()));
            values.extend(words(&part("values")).into_iter().map(f32::from_bits));
        }
    }
    let [before, after] = all;
    assert_eq!(before.len(), balls().faces.len());
    assert_eq!(after.len(), before.len() / 2);
    for (x, y) in after.iter().zip(&before) {
        assert!((x - y).abs() < 1e-4, "{x} after the step, {y} before");
    }
}

#[test]
fn the_check_has_the_verdict_of_the_repair_that_made_the_walls() {
    let desk = Desk::new();
    // Two bent sheets so near to each other that the shell of one has no room for thick walls.
    let mut upper = sheet(12);
    for p in &mut upper.positions {
        p.z = 0.3 * (1.5 * p.x).sin() * p.y.cos();
    }
    let lower = moved(&upper, 1.0, DVec3::new(0.0, 0.0, -0.04));
    desk.save("sheets.ply", &joined(&upper, &lower), Format::Ply);
    let served = Served::new(&desk, &["sheets.ply"]);
    let params = json!({ "borders": true });
    served.step(&json!({ "kind": "repair", "params": params }));
    let check = served.get("api/check/1").json();
    assert_eq!(check["sound"], false, "{check}");
    let reasons = check["reasons"].to_string();
    assert!(reasons.contains("walls that the repair made"), "{reasons}");
    let kinds = check["defects"].as_array().unwrap().iter();
    assert!(kinds.map(|d| &d["kind"]).any(|kind| kind == "thin_wall"));
    // By another minimum wall the mesh is judged for itself.
    let own = served.get("api/check/1?min_wall=1e-9").json();
    assert_eq!(own["sound"], true, "{own}");
}
