//! Objects of 3MF files and their parts: each is checked, filled, restored and repaired by itself, and keeps its name.

use std::fs;
use std::process::Output;

use glam::DVec3;
use isomend::io::{Contents, Format, Loaded, WriteOptions, model_to_bytes, read_path};
use isomend::{Attributes, LabelKind, Labels, Mesh};

use crate::desk::{Desk, assert_code, text};
use crate::shapes::{cube, cut, slab, sphere};

fn moved(mut mesh: Mesh, by: DVec3) -> Mesh {
    mesh.positions.iter_mut().for_each(|p| *p += by);
    mesh
}

/// A box of 2 by 2 by 1 around a point, with a hole round each of the places.
pub fn holed(centre: DVec3, places: &[DVec3]) -> Mesh {
    let whole = moved(slab(4), centre);
    cut(&whole, |p| places.iter().any(|q| p.distance(*q) < 0.4))
}

fn both(a: &Mesh, b: &Mesh) -> Mesh {
    let mut all = a.clone();
    all.positions.extend(&b.positions);
    let first = a.positions.len() as u32;
    all.faces
        .extend(b.faces.iter().map(|f| f.map(|v| v + first)));
    all
}

/// Writes a 3MF file with bodies that have the names of an object and of a part.
pub fn save(desk: &Desk, name: &str, bodies: &[(&str, &str, Mesh)]) {
    let mut mesh = Mesh::default();
    let mut labels = [LabelKind::Object, LabelKind::Part].map(Labels::new);
    for (object, part, own) in bodies {
        mesh = both(&mesh, own);
        for (labels, name) in labels.iter_mut().zip([object, part]) {
            let place = labels.place(name);
            labels.of_face.resize(mesh.faces.len(), place);
        }
    }
    let attributes = Attributes {
        labels: labels.to_vec(),
        ..Attributes::default()
    };
    let contents = Contents {
        mesh: &mesh,
        attributes: &attributes,
        document: None,
    };
    let written = model_to_bytes(&contents, Format::ThreeMf, &WriteOptions::default());
    fs::write(desk.path(name), written.unwrap().bytes).unwrap();
}

fn loaded(desk: &Desk, name: &str) -> Loaded {
    read_path(&desk.path(name), None).unwrap()
}

/// For each object and part its name and its mesh, in the order of the file.
fn bodies(loaded: &Loaded) -> Vec<(String, Mesh)> {
    let labels = [LabelKind::Object, LabelKind::Part].map(|k| loaded.attributes.labels_of(k));
    let mut all: Vec<(String, Mesh)> = Vec::new();
    for (f, face) in loaded.mesh.faces.iter().enumerate() {
        let own = labels.iter().filter_map(|l| l.as_ref()?.get(f));
        let name = own.collect::<Vec<_>>().join("/");
        if all.last().is_none_or(|(last, _)| *last != name) {
            all.push((name, Mesh::default()));
        }
        let mesh = &mut all.last_mut().unwrap().1;
        let corners = face.map(|v| {
            mesh.positions.push(loaded.mesh.positions[v as usize]);
            mesh.positions.len() as u32 - 1
        });
        mesh.faces.push(corners);
    }
    all
}

fn first_line(done: &Output) -> String {
    text(&done.stdout)
        .lines()
        .next()
        .unwrap_or_default()
        .to_owned()
}

const RIGHT: DVec3 = DVec3::new(2.0, 0.0, 0.0);

#[test]
fn sound_objects_that_touch_are_sound_and_stay_as_they_are() {
    let desk = Desk::new();
    let (left, right) = (slab(2), moved(slab(2), RIGHT));
    let items = [("left", "", left.clone()), ("right", "", right.clone())];
    let parts = [("pair", "left", left), ("pair", "right", right)];
    for (name, bodies_in) in [("items.3mf", items), ("parts.3mf", parts)] {
        save(&desk, name, &bodies_in);
        let done = desk.run(&[
            "check",
            name,
            "--json",
            "check.json",
            "--report",
            "check.html",
        ]);
        assert_code(&done, 0);
        assert_eq!(
            desk.json("check.json")["objects"].as_array().unwrap().len(),
            2
        );
        let page = fs::read_to_string(desk.path("check.html")).unwrap();
        assert!(page.contains("2, each checked by itself"));
        assert_code(&desk.run(&["repair", name, "-o", "out.3mf"]), 0);
        assert_eq!(
            bodies(&loaded(&desk, "out.3mf")),
            bodies(&loaded(&desk, name))
        );
        assert_eq!(loaded(&desk, "out.3mf").mesh, loaded(&desk, name).mesh);
        // Another format holds one mesh, in which the boxes touch: a repair joins them.
        assert_code(&desk.run(&["convert", name, "-o", "one.ply"]), 0);
        assert_code(&desk.run(&["check", "one.ply"]), 3);
        let done = desk.run(&["repair", name, "-o", "one.stl"]);
        assert_code(&done, 0);
        assert!(text(&done.stderr).contains("the 2 objects were treated as one mesh"));
    }
    let names = |name: &str| -> Vec<String> {
        let all = bodies(&loaded(&desk, name)).into_iter();
        all.map(|(name, _)| name).collect()
    };
    assert_eq!(names("items.3mf"), ["left", "right"]);
    assert_eq!(names("parts.3mf"), ["pair/left", "pair/right"]);
}

#[test]
fn a_fault_is_reported_with_its_object_and_mended_there_alone() {
    let desk = Desk::new();
    let touch = DVec3::new(1.0, 0.0, 0.0);
    let mess = both(&slab(2), &moved(slab(2), DVec3::new(0.3, 0.4, 0.55)));
    let sound = moved(slab(3), DVec3::new(0.0, 2.0, 0.0));
    let items = [
        ("tray", "lid", holed(DVec3::ZERO, &[touch])),
        ("tray", "box", holed(RIGHT, &[touch])),
        ("sound", "", sound),
        ("mess", "", moved(mess, DVec3::new(0.0, -2.0, 0.0))),
    ];
    save(&desk, "in.3mf", &items);
    let before = bodies(&loaded(&desk, "in.3mf"));
    let done = desk.run(&["check", "in.3mf", "--json", "check.json"]);
    assert_code(&done, 3);
    let said = first_line(&done);
    for reason in [
        "tray/lid: 1 hole is open",
        "tray/box: 1 hole is open",
        "mess: ",
    ] {
        assert!(said.contains(reason), "{said}");
    }
    assert!(!said.contains("sound:"), "{said}");
    let sound = |name: &str| -> Vec<bool> {
        let document = desk.json(name);
        let rows = document["objects"].as_array().unwrap().iter();
        rows.map(|row| row["sound"].as_bool().unwrap()).collect()
    };
    assert_eq!(sound("check.json"), [false, false, true, false]);

    // The rims of lid and box coincide; each gets a patch of its own, and the faces of the input stay.
    assert_code(&desk.run(&["fill", "in.3mf", "-o", "filled.3mf"]), 0);
    let filled = bodies(&loaded(&desk, "filled.3mf"));
    assert_eq!(filled.len(), 4);
    for ((name, old), (same, new)) in before.iter().zip(&filled) {
        assert_eq!(name, same);
        assert_eq!(new.positions[..old.positions.len()], old.positions);
        assert_eq!(
            new.faces.len() > old.faces.len(),
            name.starts_with("tray"),
            "{name}"
        );
    }
    let done = desk.run(&["check", "filled.3mf"]);
    assert!(!first_line(&done).contains("tray"), "{}", first_line(&done));

    let done = desk.run(&["repair", "in.3mf", "-o", "out.3mf", "--json", "out.json"]);
    assert_code(&done, 0);
    assert_code(&desk.run(&["check", "out.3mf"]), 0);
    let after = bodies(&loaded(&desk, "out.3mf"));
    let names = |all: &[(String, Mesh)]| -> Vec<String> {
        all.iter().map(|(name, _)| name.clone()).collect()
    };
    assert_eq!(names(&after), names(&before));
    assert_eq!(after[2], before[2]);
    assert_eq!(after[0].1.faces.len(), filled[0].1.faces.len());
    // The same bytes with any number of threads.
    let again = desk.run(&["repair", "in.3mf", "-o", "again.3mf", "--threads", "1"]);
    assert_code(&again, 0);
    let bytes = |name: &str| fs::read(desk.path(name)).unwrap();
    assert_eq!(bytes("again.3mf"), bytes("out.3mf"));
}

#[test]
fn holes_have_one_numbering_and_a_restoration_changes_its_object_alone() {
    let desk = Desk::new();
    let touch = DVec3::new(1.0, 0.0, 0.0);
    let top = DVec3::new(2.0, 0.0, 0.5);
    let items = [
        ("left", "", holed(DVec3::ZERO, &[touch])),
        ("right", "", holed(RIGHT, &[touch, top])),
    ];
    save(&desk, "in.3mf", &items);
    assert_code(&desk.run(&["inspect", "in.3mf", "--json", "seen.json"]), 0);
    let holes = desk.json("seen.json")["holes"].as_array().unwrap().clone();
    assert_eq!(holes.len(), 3);
    let at_top = |hole: &&serde_json::Value| hole["centre"][2].as_f64().unwrap() > 0.4;
    let number = holes.iter().find(at_top).unwrap()["id"].to_string();
    let done = desk.run(&[
        "fill", "in.3mf", "-o", "out.3mf", "--holes", &number, "--json", "out.json",
    ]);
    assert_code(&done, 0);
    let filled: Vec<String> = desk.json("out.json")["holes"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|hole| hole["region"] != 0)
        .map(|hole| hole["id"].to_string())
        .collect();
    assert_eq!(filled, [number]);
    assert_code(&desk.run(&["check", "out.3mf"]), 3);
    let bridge = desk.run(&["fill", "in.3mf", "-o", "out.3mf", "--bridge", "1+2+3"]);
    assert_ne!(bridge.status.code(), Some(0));
    assert!(text(&bridge.stderr).contains("different objects"));

    // A mask on the top of the left box, which touches the right one.
    let ball = ["--ball", "0,0,0.5,0.5"];
    let done = desk.run(&[&["restore", "in.3mf", "-o", "new.3mf"][..], &ball].concat());
    assert_code(&done, 0);
    let (before, after) = (loaded(&desk, "in.3mf"), loaded(&desk, "new.3mf"));
    let [before, after] = [bodies(&before), bodies(&after)];
    assert_eq!(after[1], before[1]);
    assert_ne!(after[0], before[0]);
    assert_eq!(after[0].0, "left");
}

#[test]
fn rows_of_a_fill_name_the_object_of_their_hole() {
    let desk = Desk::new();
    let up = DVec3::new(0.0, 0.0, 0.5);
    let items = [
        ("lid", "", holed(DVec3::ZERO, &[up])),
        ("box", "", holed(3.0 * RIGHT, &[3.0 * RIGHT + up])),
    ];
    save(&desk, "in.3mf", &items);
    let done = desk.run(&["fill", "in.3mf", "-o", "out.3mf", "--json", "fill.json"]);
    assert_code(&done, 0);
    let table = [text(&done.stdout), text(&done.stderr)].concat();
    for name in ["in lid", "in box"] {
        assert!(table.lines().any(|l| l.ends_with(name)), "{table}");
    }
    let names = |document: &serde_json::Value| -> Vec<String> {
        let rows = document["holes"].as_array().unwrap().iter();
        let mut all: Vec<String> = rows
            .map(|row| row["object"].as_str().unwrap_or("none").to_owned())
            .collect();
        all.sort();
        all
    };
    assert_eq!(names(&desk.json("fill.json")), ["box", "lid"]);
    assert_code(&desk.run(&["inspect", "in.3mf", "--json", "found.json"]), 0);
    assert_eq!(names(&desk.json("found.json")), ["box", "lid"]);
    // A file with one body names no object.
    save(&desk, "one.3mf", &items[..1]);
    let done = desk.run(&["fill", "one.3mf", "-o", "out.3mf", "--json", "one.json"]);
    assert_code(&done, 0);
    assert_eq!(names(&desk.json("one.json")), ["none"]);
}

#[test]
fn objects_are_faired_apart_and_keep_their_names() {
    let desk = Desk::new();
    // Boxes that overlap: as one mesh their level set would be one surface.
    let near = DVec3::new(1.9, 0.0, 0.0);
    let closed = [("left", "", slab(4)), ("right", "", moved(slab(4), near))];
    let place = near + DVec3::new(0.0, 0.0, 0.5);
    let open = [("left", "", slab(4)), ("right", "", holed(near, &[place]))];
    for (name, items) in [("closed.3mf", closed), ("open.3mf", open)] {
        save(&desk, name, &items);
        let done = desk.run(&[
            "fair",
            name,
            "-o",
            "out.3mf",
            "--strength",
            "0.45",
            "--json",
            "fair.json",
        ]);
        assert_code(&done, 0);
        // The order stays, also where an object is replaced as a whole.
        let after = bodies(&loaded(&desk, "out.3mf"));
        let names: Vec<&str> = after.iter().map(|(name, _)| &name[..]).collect();
        assert_eq!(names, ["left", "right"], "{name}");
        for ((_, _, before), (_, after)) in items.iter().zip(&after) {
            let ([a, b], [c, d]) = (before.bounds(), after.bounds());
            assert!(a.distance(c) < 0.6 && b.distance(d) < 0.6, "{name}");
        }
        let rows = desk.json("fair.json")["objects"].clone();
        assert_eq!(rows.as_array().unwrap().len(), 2);
        assert_eq!(rows[1]["name"], "right");
    }
}

#[test]
fn objects_keep_their_order_and_reports_and_errors_name_them() {
    let desk = Desk::new();
    // The first object is closed and replaced as a whole; of the other one a part is faired, which keeps its faces.
    let near = DVec3::new(1.9, 0.0, 0.0);
    let place = near + DVec3::new(0.0, 0.0, 0.5);
    let items = [
        ("first", "", slab(4)),
        ("second", "", holed(near, &[place])),
    ];
    save(&desk, "in.3mf", &items);
    let done = desk.run(&["fair", "in.3mf", "-o", "out.3mf", "--strength", "0.45"]);
    assert_code(&done, 0);
    let after = bodies(&loaded(&desk, "out.3mf")).into_iter();
    let names: Vec<String> = after.map(|(name, _)| name).collect();
    assert_eq!(names, ["first", "second"]);
    let done = desk.run(&[
        "fair",
        "in.3mf",
        "-o",
        "no.3mf",
        "--strength",
        "1e-4",
        "--voxel",
        "1e-5",
    ]);
    assert_code(&done, 1);
    let said = text(&done.stderr);
    assert!(said.contains("cannot fair the object first: "), "{said}");
    assert_code(
        &desk.run(&["inspect", "in.3mf", "--report", "holes.html"]),
        0,
    );
    let page = fs::read_to_string(desk.path("holes.html")).unwrap();
    assert!(page.contains("<th class=\"text\">object</th>"));
    assert!(page.contains("<td class=\"text\">second</td>"));
    assert!(page.contains(">in second</span>"));
    desk.save("one.ply", &items[1].2, Format::Ply);
    assert_code(
        &desk.run(&["inspect", "one.ply", "--report", "one.html"]),
        0,
    );
    let page = fs::read_to_string(desk.path("one.html")).unwrap();
    assert!(!page.contains(">object</th>"));
}

#[test]
fn an_object_that_cannot_be_faired_stays_and_is_named() {
    let desk = Desk::new();
    // A box of 12 faces is narrower than eight of its edges.
    let small = ("box", "", moved(cube(1), DVec3::new(6.0, 0.0, 0.0)));
    save(&desk, "in.3mf", &[("ball", "", sphere(6)), small.clone()]);
    let fair = ["fair", "in.3mf", "-o", "out.3mf", "--json", "fair.json"];
    let done = desk.run(&fair);
    // As after a fill that leaves a hole open.
    assert_code(&done, 3);
    let said = text(&done.stderr);
    assert!(
        said.contains("box stays unchanged: the flow stopped at the time 0 "),
        "{said}"
    );
    assert!(!said.contains("a strip along the boundary"), "{said}");
    let report = desk.json("fair.json");
    assert_eq!(
        (&report["complete"], &report["whole"]),
        (&false.into(), &false.into())
    );
    assert_eq!(report["kept_objects"][0]["name"], "box");
    assert_eq!(report["objects"].as_array().unwrap().len(), 1);
    let after = bodies(&loaded(&desk, "out.3mf"));
    let names: Vec<&str> = after.iter().map(|(name, _)| &name[..]).collect();
    assert_eq!(names, ["ball", "box"]);
    let before = bodies(&loaded(&desk, "in.3mf"));
    assert_eq!(after[1], before[1]);
    assert_ne!(after[0], before[0]);
    // A strength below what the box's edges resolve is known before the flow.
    let weak = ["fair", "in.3mf", "--strength", "0.9"];
    let plan = desk.run(&[&weak[..], &["--dry-run"]].concat());
    assert_code(&plan, 0);
    let said = text(&plan.stdout);
    assert!(
        said.contains("box stays unchanged: a strength of 0.9"),
        "{said}"
    );
    // Alone it is an error.
    save(&desk, "alone.3mf", &[small.clone(), ("twin", "", small.2)]);
    let done = desk.run(&["fair", "alone.3mf", "-o", "no.3mf"]);
    assert_code(&done, 1);
    let said = text(&done.stderr);
    assert!(said.contains("cannot fair the object box: "), "{said}");
}

#[test]
fn components_are_numbered_through_all_objects() {
    let desk = Desk::new();
    let whole = |x: f64| holed(x * DVec3::X, &[]);
    let left = both(&whole(0.0), &whole(5.0));
    let items = [
        ("left", "", left),
        ("right", "", both(&whole(10.0), &whole(15.0))),
    ];
    save(&desk, "in.3mf", &items);
    let listed = desk.run(&["inspect", "in.3mf", "-v"]);
    let said = text(&listed.stdout);
    let rows: Vec<&str> = said
        .lines()
        .skip_while(|l| !l.starts_with("component"))
        .collect();
    assert_eq!(rows.len(), 5, "{said}");
    assert!(
        rows[4].starts_with("4 ") && rows[4].ends_with("2 x 2 x 1"),
        "{said}"
    );
    let done = desk.run(&["repair", "in.3mf", "-o", "out.3mf", "--drop", "2,3"]);
    assert_code(&done, 0);
    let said = text(&done.stderr);
    assert!(
        said.contains("2 components removed by their numbers, "),
        "{said}"
    );
    let names = |mesh: &Loaded| {
        bodies(mesh)
            .into_iter()
            .map(|(name, _)| name)
            .collect::<Vec<_>>()
    };
    let out = loaded(&desk, "out.3mf");
    assert_eq!(names(&out), ["left", "right"]);
    let wanted = both(&whole(0.0), &whole(15.0));
    assert_eq!(out.mesh.positions, wanted.positions);
    let done = desk.run(&["repair", "in.3mf", "-o", "no.3mf", "--drop", "5"]);
    assert_code(&done, 1);
    assert!(
        text(&done.stderr)
            .contains("no component 5; the mesh has 4 (`isomend inspect -v` lists them)")
    );
}
