//! Projects of slicers in 3MF files: paint follows its triangles, settings stay true, and all else is written back byte for byte.

use std::fs;

use glam::DVec3;
use isomend::Mesh;

use crate::desk::{Desk, assert_code, text};
use crate::packages::{PARTS, VOLUMES, bambu, holed, prusa, repacked, unpacked};
use crate::shapes::{cube, joined, moved, sphere};

pub fn part(desk: &Desk, name: &str, part: &str) -> String {
    text(&unpacked(desk, name)[part])
}

/// The value of an attribute in an element's text.
fn value<'t>(element: &'t str, name: &str) -> Option<&'t str> {
    let start = element.find(&format!(" {name}=\""))? + name.len() + 3;
    element[start..].split('"').next()
}

/// For each triangle of an object of a model, the texts of its corners and of its other attributes.
pub fn triangles(model: &str, object: u32) -> Vec<([String; 3], String)> {
    let own = model
        .split("<object id=\"")
        .find(|t| t.starts_with(&format!("{object}\"")));
    let own = own.unwrap().split("</object>").next().unwrap();
    let elements = |name: &str| -> Vec<String> {
        let tag = format!("<{name} ");
        let all = own.split(&tag).skip(1);
        all.map(|t| " ".to_owned() + t.split("/>").next().unwrap())
            .collect()
    };
    let points = elements("vertex");
    let corner =
        |t: &str, name: &str| points[value(t, name).unwrap().parse::<usize>().unwrap()].clone();
    let whole = elements("triangle").into_iter().map(|t| {
        let corners = ["v1", "v2", "v3"].map(|name| corner(&t, name));
        let rest = t.split("\" ").filter(|word| !word.trim().starts_with('v'));
        (corners, rest.collect::<Vec<_>>().join(" ").replace('"', ""))
    });
    whole.collect()
}

/// Asserts that a model begins with the triangles of another, part by part; returns the attributes of those that are new.
fn new_triangles(before: &[([String; 3], String)], after: &[([String; 3], String)]) -> Vec<String> {
    let mut old = before.iter().peekable();
    let mut new = Vec::new();
    for triangle in after {
        match old.next_if(|old| *old == triangle) {
            Some(_) => {}
            None => new.push(triangle.1.clone()),
        }
    }
    assert!(old.next().is_none(), "a triangle was changed or lost");
    new
}

/// The ranges of the volumes, and the number of triangles that they cover.
pub fn ranges(config: &str) -> Vec<[usize; 2]> {
    let all = config.split("<volume ").skip(1);
    let number =
        |text: &str, name: &str| value(&format!(" {text}"), name).unwrap().parse().unwrap();
    all.map(|t| [number(t, "firstid"), number(t, "lastid")])
        .collect()
}

/// The names of the parts that two packages have in different forms. Both have the same parts.
fn changed(desk: &Desk, [before, after]: [&str; 2]) -> Vec<String> {
    let (before, after) = (unpacked(desk, before), unpacked(desk, after));
    assert!(before.keys().eq(after.keys()));
    let all = before
        .into_iter()
        .filter(|(name, bytes)| after[name] != *bytes);
    all.map(|(name, _)| name).collect()
}

#[test]
fn a_project_without_changes_is_the_same_file() {
    let desk = Desk::new();
    prusa(
        &desk,
        "a.3mf",
        &[("ball", moved(&sphere(4), 3.0, DVec3::ZERO))],
        true,
    );
    bambu(&desk, "b.3mf");
    for (command, name) in [
        ("convert", "a.3mf"),
        ("convert", "b.3mf"),
        ("fill", "a.3mf"),
        ("repair", "a.3mf"),
    ] {
        assert_code(&desk.run(&[command, name, "-o", "out.3mf"]), 0);
        assert_eq!(
            fs::read(desk.path("out.3mf")).unwrap(),
            fs::read(desk.path(name)).unwrap(),
            "{command} {name}"
        );
    }
    // Another unit changes one word.
    assert_code(
        &desk.run(&["convert", "b.3mf", "-o", "out.3mf", "--unit", "in"]),
        0,
    );
    let [before, after] = ["b.3mf", "out.3mf"].map(|name| part(&desk, name, "3D/3dmodel.model"));
    assert_eq!(after, before.replacen("millimeter", "inch", 1));
}

#[test]
fn paint_and_volumes_of_prusaslicer_follow_their_triangles() {
    let desk = Desk::new();
    let volumes = [
        ("ball", holed(5.0, DVec3::ZERO)),
        ("knob", holed(2.0, DVec3::new(9.0, 0.0, 0.0))),
    ];
    prusa(&desk, "in.3mf", &volumes, true);
    let sizes = [volumes[0].1.faces.len(), volumes[1].1.faces.len()];
    let before = triangles(&part(&desk, "in.3mf", "3D/3dmodel.model"), 1);
    assert_code(&desk.run(&["inspect", "in.3mf", "--json", "seen.json"]), 0);
    let holes = desk.json("seen.json")["holes"].to_string();
    assert!(
        ["Body/ball", "Body/knob"]
            .iter()
            .all(|name| holes.contains(name)),
        "{holes}"
    );
    for command in ["fill", "repair"] {
        let done = desk.run(&[command, "in.3mf", "-o", "out.3mf"]);
        assert_code(&done, 0);
        assert!(
            !text(&done.stderr).contains("left out"),
            "{}",
            text(&done.stderr)
        );
        assert_eq!(
            changed(&desk, ["in.3mf", "out.3mf"]),
            ["3D/3dmodel.model", VOLUMES]
        );
        let model = part(&desk, "out.3mf", "3D/3dmodel.model");
        let after = triangles(&model, 1);
        let new = new_triangles(&before, &after);
        assert!(
            new.len() > 20 && new.iter().all(String::is_empty),
            "{new:?}"
        );
        // The volumes cover all triangles, in each first the triangles of the file.
        let [ball, knob] = ranges(&part(&desk, "out.3mf", VOLUMES))[..] else {
            panic!("two volumes");
        };
        assert_eq!(
            [ball[0], ball[1] + 1, knob[1] + 1],
            [0, knob[0], after.len()]
        );
        assert_eq!(after[..sizes[0]], before[..sizes[0]]);
        assert_eq!(after[knob[0]..][..sizes[1]], before[sizes[0]..]);
        assert!(model.contains("printable=\"0\"") && model.contains("<component objectid=\"1\"/>"));
        assert_code(&desk.run(&["check", "out.3mf"]), 0);
    }
    let done = desk.run(&["fill", "in.3mf", "-o", "one.3mf", "--threads", "1"]);
    assert_code(&done, 0);
    assert_code(&desk.run(&["fill", "in.3mf", "-o", "out.3mf"]), 0);
    assert_eq!(
        fs::read(desk.path("one.3mf")).unwrap(),
        fs::read(desk.path("out.3mf")).unwrap()
    );
    // Filled again, nothing changes.
    assert_code(&desk.run(&["fill", "out.3mf", "-o", "again.3mf"]), 0);
    assert_eq!(changed(&desk, ["out.3mf", "again.3mf"]), [""; 0]);
}

#[test]
fn patches_can_be_painted_as_their_neighbours() {
    let desk = Desk::new();
    bambu(&desk, "in.3mf");
    let done = desk.run(&["fill", "in.3mf", "-o", "out.3mf", "--paint", "continue"]);
    assert_code(&done, 0);
    assert!(text(&done.stderr).contains("slice it again"));
    assert_eq!(
        changed(&desk, ["in.3mf", "out.3mf"]),
        ["3D/Objects/object_1.model", PARTS]
    );
    let [before, after] =
        ["in.3mf", "out.3mf"].map(|name| part(&desk, name, "3D/Objects/object_1.model"));
    let config = part(&desk, "out.3mf", PARTS);
    let mut total = 0;
    for id in [1, 2] {
        let after = triangles(&after, id);
        let new = new_triangles(&triangles(&before, id), &after);
        let painted = new
            .iter()
            .filter(|paint| paint.contains("paint_color=8"))
            .count();
        // Paint that is a tree of parts is not continued.
        assert!(0 < painted && painted < new.len(), "{new:?}");
        assert!(
            new.iter()
                .all(|paint| !paint.contains("4C3") && !paint.contains("face_property"))
        );
        let stat = config.split(&format!("<part id=\"{id}\"")).nth(1).unwrap();
        assert_eq!(value(stat, "face_count").unwrap(), after.len().to_string());
        total += after.len();
    }
    assert!(config.contains(&format!("<metadata face_count=\"{total}\"/>")));
    assert_eq!(config.matches("key=\"plater_id\"").count(), 1);
    assert!(after.contains("p:UUID=\"00010002-81cb\" type=\"other\""));
    assert_code(&desk.run(&["check", "out.3mf"]), 0);
}

#[test]
fn divided_and_turned_triangles_keep_paint_of_the_whole_triangle() {
    let desk = Desk::new();
    let shift = DVec3::new(1.3, 1.4, 1.6);
    let mut mess = joined(
        &moved(&cube(2), 1.0, DVec3::ZERO),
        &moved(&cube(2), 1.0, shift),
    );
    mess.faces[3].swap(1, 2);
    prusa(
        &desk,
        "in.3mf",
        &[
            ("mess", mess.clone()),
            ("ball", moved(&sphere(3), 1.0, DVec3::new(9.0, 0.0, 0.0))),
        ],
        false,
    );
    let done = desk.run(&["repair", "in.3mf", "-o", "out.3mf"]);
    assert_code(&done, 0);
    assert!(
        text(&done.stderr).contains("were divided or turned and lost paint"),
        "{}",
        text(&done.stderr)
    );
    let [before, after] =
        ["in.3mf", "out.3mf"].map(|name| triangles(&part(&desk, name, "3D/3dmodel.model"), 1));
    let [first, ball] = ranges(&part(&desk, "out.3mf", VOLUMES))[..] else {
        panic!("two volumes");
    };
    assert_eq!(after[ball[0]..], before[mess.faces.len()..]);
    assert_eq!(ball[1] + 1, after.len());
    // A triangle with corners that the file does not have is a part of one.
    let known: Vec<&String> = before.iter().flat_map(|(corners, _)| corners).collect();
    let is_old = |(corners, _): &&([String; 3], String)| corners.iter().all(|c| known.contains(&c));
    let (whole, parts): (Vec<_>, Vec<_>) = after[..=first[1]].iter().partition(is_old);
    assert!(!parts.is_empty());
    assert!(parts.iter().all(|(_, paint)| !paint.contains("4C3")));
    assert!(
        parts
            .iter()
            .any(|(_, paint)| paint.contains("custom_supports=4"))
    );
    assert!(whole.iter().any(|(_, paint)| paint.contains("4C3")));
    // The turned triangle keeps the second corner of the other orientation, and its paint only if it is of the whole.
    let turned = &before[3];
    let [a, b, c] = turned.0.clone();
    let found = whole.iter().find(|(corners, _)| {
        (0..3).any(|k| {
            let mut back = [a.clone(), c.clone(), b.clone()];
            back.rotate_left(k);
            *corners == back
        })
    });
    assert!(found.is_some());
}

#[test]
fn a_restored_region_leaves_the_other_paint() {
    let desk = Desk::new();
    prusa(
        &desk,
        "in.3mf",
        &[("ball", moved(&sphere(6), 5.0, DVec3::ZERO))],
        false,
    );
    let before = triangles(&part(&desk, "in.3mf", "3D/3dmodel.model"), 1);
    let ball = "125.25,105.1,10,2.5";
    for command in ["restore", "fair"] {
        assert_code(
            &desk.run(&[command, "in.3mf", "-o", "out.3mf", "--ball", ball]),
            0,
        );
        assert_eq!(
            changed(&desk, ["in.3mf", "out.3mf"]),
            ["3D/3dmodel.model", VOLUMES],
            "{command}"
        );
        let after = triangles(&part(&desk, "out.3mf", "3D/3dmodel.model"), 1);
        let kept: Vec<_> = before.iter().filter(|t| after.contains(t)).collect();
        assert!(kept.len() > before.len() / 2 && kept.len() < before.len());
        assert!(after.iter().zip(&kept).all(|(new, old)| new == *old));
        assert!(
            after[kept.len()..]
                .iter()
                .all(|(_, paint)| paint.is_empty())
        );
        assert_eq!(
            ranges(&part(&desk, "out.3mf", VOLUMES)),
            [[0, after.len() - 1]]
        );
    }
}

#[test]
fn a_project_that_is_faired_as_a_whole_keeps_its_settings_and_names_the_paint() {
    let desk = Desk::new();
    let ball = moved(&sphere(4), 3.0, DVec3::ZERO);
    prusa(&desk, "in.3mf", &[("ball", ball)], false);
    let done = desk.run(&["fair", "in.3mf", "-o", "out.3mf"]);
    assert_code(&done, 0);
    let said = text(&done.stderr);
    assert!(
        said.contains("has no attributes: custom_seam, custom_supports, mmu_segmentation of"),
        "{said}"
    );
    let both = ["in.3mf", "out.3mf"];
    assert_eq!(changed(&desk, both), ["3D/3dmodel.model", VOLUMES]);
    let after = triangles(&part(&desk, "out.3mf", "3D/3dmodel.model"), 1);
    assert!(after.iter().all(|(_, paint)| paint.is_empty()));
    let ranges = ranges(&part(&desk, "out.3mf", VOLUMES));
    assert_eq!(ranges, [[0, after.len() - 1]]);
}

#[test]
fn an_object_placed_twice_is_mended_once() {
    let desk = Desk::new();
    prusa(&desk, "in.3mf", &[("ball", holed(5.0, DVec3::ZERO))], true);
    let done = desk.run(&["fill", "in.3mf", "-o", "out.3mf", "--holes", "1"]);
    assert_code(&done, 0);
    assert!(
        text(&done.stderr).contains("share a mesh came out differently"),
        "{}",
        text(&done.stderr)
    );
    assert_code(&desk.run(&["check", "out.3mf"]), 0);
    for paint in [&[][..], &["--paint", "continue"]] {
        let done = desk.run(&[&["fill", "in.3mf", "-o", "out.3mf"], paint].concat());
        assert_code(&done, 0);
        assert!(!text(&done.stderr).contains("differently"), "{paint:?}");
    }
}

#[test]
fn other_formats_name_what_they_leave_out() {
    let desk = Desk::new();
    bambu(&desk, "in.3mf");
    for name in ["out.stl", "out.ply", "out.glb"] {
        let done = desk.run(&["convert", "in.3mf", "-o", name]);
        assert_code(&done, 0);
        let said = text(&done.stderr);
        let notes: Vec<&str> = said
            .lines()
            .filter(|line| line.contains("has no place for it: "))
            .collect();
        assert_eq!(notes.len(), 1, "{said}");
        for word in [
            "paint_color",
            "paint_supports",
            "face_property",
            "Metadata/plate_1.png",
        ] {
            assert!(notes[0].contains(word), "{said}");
        }
    }
}

#[test]
fn paint_is_continued_where_vertices_are_doubled() {
    let desk = Desk::new();
    let ball = holed(5.0, DVec3::ZERO);
    let corners = ball.faces.iter().flatten();
    let positions = corners.map(|v| ball.positions[*v as usize]).collect();
    let count = ball.faces.len() as u32;
    let faces = (0..count).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    prusa(
        &desk,
        "in.3mf",
        &[("ball", Mesh::new(positions, faces))],
        false,
    );
    let done = desk.run(&["fill", "in.3mf", "-o", "out.3mf", "--paint", "continue"]);
    assert_code(&done, 0);
    let [before, after] =
        ["in.3mf", "out.3mf"].map(|name| triangles(&part(&desk, name, "3D/3dmodel.model"), 1));
    let new = new_triangles(&before, &after);
    let is_painted = |paint: &&String| paint.contains("custom_supports=4");
    assert!(new.iter().any(|paint| is_painted(&paint)), "{new:?}");
    assert!(!text(&done.stderr).contains("patches without paint"));
}

#[test]
fn divided_triangles_keep_their_colour_beside_marks_of_another() {
    let desk = Desk::new();
    let shift = DVec3::new(1.3, 1.4, 1.6);
    let both = joined(
        &moved(&cube(2), 1.0, DVec3::ZERO),
        &moved(&cube(2), 1.0, shift),
    );
    prusa(&desk, "plain.3mf", &[("both", both)], false);
    let mut parts = unpacked(&desk, "plain.3mf");
    let colours = " xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\">";
    let group = "<resources><m:colorgroup id=\"9\"><m:color color=\"#00FF00\"/></m:colorgroup>";
    let model = text(&parts["3D/3dmodel.model"])
        .replacen("2017/06\">", &format!("2017/06\"{colours}"), 1)
        .replacen("<resources>", group, 1)
        .replace("supports=\"4\"", "supports=\"4\" pid=\"9\" p1=\"0\"");
    parts.insert("3D/3dmodel.model".to_owned(), model.into_bytes());
    repacked(&desk, "in.3mf", &parts);
    let mark = "colour=ff8000";
    assert_code(
        &desk.run(&["repair", "in.3mf", "-o", "out.3mf", "--mark", mark]),
        0,
    );
    let coloured = ["in.3mf", "out.3mf"].map(|name| {
        let all = triangles(&part(&desk, name, "3D/3dmodel.model"), 1);
        let own = all.into_iter().map(|(_, rest)| rest);
        own.filter(|rest| rest.contains("supports=4"))
            .collect::<Vec<String>>()
    });
    assert!(coloured[1].len() > coloured[0].len());
    assert!(
        coloured[1].iter().all(|rest| rest.contains("pid=9 p1=0")),
        "{coloured:?}"
    );
}
