//! `isomend repair --solid` on the command line: what the report and the JSON document say.

use crate::desk::{Desk, assert_code, text};
use glam::DVec3;
use isomend::io::Format;
use isomend::{Mesh, Volume, level_surface};

/// The two skins of a ball, joined through two pinholes.
fn double_skinned_ball() -> Mesh {
    let (nodes, h) = (40, 0.06);
    let at = |i: usize| (i as f64 - 19.5) * h;
    let mut values = Vec::new();
    for k in 0..nodes {
        for j in 0..nodes {
            for i in 0..nodes {
                let p = DVec3::new(at(i), at(j), at(k));
                let pinholes = [DVec3::X, DVec3::Y].map(|axis| 3.2 * h - p.distance(0.9 * axis));
                let skin = (p.length() - 0.9).abs();
                values.push(skin.max(pinholes[0]).max(pinholes[1]));
            }
        }
    }
    let volume = Volume {
        dims: [nodes; 3],
        origin: DVec3::splat(at(0)),
        spacing: DVec3::splat(h),
        values,
    };
    level_surface(&volume, 1.1 * h, false).unwrap()
}

#[test]
fn the_report_names_inner_skins_and_pinholes() {
    let desk = Desk::new();
    desk.save("in.ply", &double_skinned_ball(), Format::Ply);
    let arguments = [
        "repair", "in.ply", "-o", "out.ply", "--solid", "--json", "out.json",
    ];
    let done = desk.run(&arguments);
    assert_code(&done, 0);
    let said = text(&done.stderr);
    assert!(said.contains("1 inner skin removed, "), "{said}");
    assert!(
        said.contains(" behind the outer skin: 2 pinholes closed"),
        "{said}"
    );
    // The result has no inner skin any more, which is said too.
    let again = desk.run(&["repair", "out.ply", "-o", "again.ply", "--solid"]);
    assert_code(&again, 0);
    let said = text(&again.stderr);
    assert!(said.contains("no inner skin was found"), "{said}");
    let steps = &desk.json("out.json")["steps"];
    assert_eq!(steps["inner_skins"], 1);
    assert_eq!(steps["pinholes"], 2);
    assert!(steps["inner_skin_faces"].as_u64().unwrap() > 3000);
    let thickness = steps["skin_thickness"].as_f64().unwrap();
    assert!((thickness / (2.2 * 0.06) - 1.0).abs() < 0.05, "{thickness}");
}
