//! The JSON documents of all commands have the fields and types of `docs/json.schema.json`, and no others.

use std::collections::BTreeSet;

use glam::DVec3;
use isomend::io::Format;
use serde_json::{Value, json};

use crate::checker::Schema;
use crate::desk::{Desk, text};
use crate::objects::{holed, save};
use crate::shapes::{cube, cut, joined, moved, open_cube, sheet};

/// The commands that are run, with `--json -` added.
const RUNS: [&str; 27] = [
    "fill ball.ply -o a.ply --verbose",
    "fill ball.ply -o b.ply --tolerance 0.1 --unit mm --patches p.ply --grain",
    "fill ball.ply -o c.ply --holes 1 --like mirror",
    "fill cube.ply -o d.ply",
    "fill sheet.ply -o e.ply",
    "fill objects.3mf -o f.3mf",
    "fill ball.ply --dry-run",
    "restore ball.ply -o g.ply --ball 0,0,-1,0.5 --piece q.ply",
    "restore ball.ply --ball 0,0,-1,0.5 --dry-run",
    "fair ball.ply -o h.ply --strength 0.5 --ball 0,0,-1,0.6",
    "fair objects.3mf -o i.3mf --strength 0.45",
    "fair ball.ply --strength 0.5 --ball 0,0,-1,0.6 --dry-run",
    "repair two.ply -o j.ply",
    "repair twice.ply -o k.ply",
    "repair sheet.ply -o l.ply",
    "repair objects.3mf -o m.3mf --unit mm",
    "repair ball.ply --dry-run",
    "convert ball.ply -o n.obj",
    "inspect ball.ply --ball 0,0,-1,0.5 --unit mm",
    "inspect objects.3mf",
    "check two.ply --min-wall 0.3 --thin 0.1",
    "check objects.3mf",
    "compare ball.ply a.ply --unit mm",
    "sdf ball.ply -o o.vti --voxel 0.2",
    "surface o.vti -o p.ply",
    "study table1 --finest 16",
    "fill broken.ply ball.ply -o folder/",
];

/// Meshes of all kinds that the commands need.
fn desk() -> Desk {
    let desk = Desk::new();
    let cubes = [0.0, 0.5].map(|x| moved(&cube(3), 1.0, DVec3::new(x, x / 2.0, x / 3.0)));
    desk.save("two.ply", &joined(&cubes[0], &cubes[1]), Format::Ply);
    desk.save("twice.ply", &joined(&cubes[0], &cubes[0]), Format::Ply);
    desk.save("cube.ply", &open_cube(), Format::Ply);
    let holed_sheet = cut(&sheet(12), |p| p.truncate().length() < 0.3);
    desk.save("sheet.ply", &holed_sheet, Format::Ply);
    desk.text("broken.ply", "ply\nnothing");
    let bodies = [0.0, 5.0].map(|x| {
        let centre = DVec3::X * x;
        holed(centre, &[centre + DVec3::Z * 0.5])
    });
    let [a, b] = bodies;
    save(&desk, "objects.3mf", &[("one", "", a), ("two", "", b)]);
    desk
}

#[test]
fn the_documents_of_all_commands_are_as_the_schema_describes_them() {
    let (desk, schema) = (desk(), Schema::read());
    let mut met = BTreeSet::new();
    for words in RUNS {
        let mut arguments: Vec<&str> = words.split(' ').collect();
        arguments.extend(["--json", "-"]);
        let output = desk.run(&arguments);
        let document: Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|error| panic!("{words}: {error}: {}", text(&output.stderr)));
        let faults = schema.faults(&document);
        assert!(faults.is_empty(), "{words}: {}", faults.join("\n"));
        let each = document.as_array().cloned().unwrap_or(vec![document]);
        for one in &each {
            let fits = |name: &&&str| schema.faults_by(name, one).is_empty();
            let names = schema.documents();
            met.extend(names.iter().filter(fits).map(ToString::to_string));
        }
    }
    let all: BTreeSet<String> = schema.documents().iter().map(ToString::to_string).collect();
    assert_eq!(met, all, "documents of the schema that a command wrote");
}

#[test]
fn the_checker_finds_what_a_schema_does_not_permit() {
    let (desk, schema) = (Desk::new(), Schema::read());
    let output = desk.run(&["inspect", "ball.ply", "--json", "-"]);
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(schema.faults(&document), [""; 0]);
    let changed = |place: &str, value: Value| {
        let mut document = document.clone();
        *document.pointer_mut(place).unwrap() = value;
        schema.faults_by("Inspect", &document).join("; ")
    };
    let faults = changed("/holes/0/edges", json!(2.5));
    assert!(faults.starts_with("/holes/0/edges is 2.5"), "{faults}");
    assert!(changed("/holes/0/normal", json!([0, 0])).contains("minItems"));
    assert!(changed("/holes/1/id", json!(-1)).contains("minimum"));
    assert!(changed("/command", json!("mend")).contains("enum"));
    assert!(changed("/defects", Value::Null).contains("type"));
    let mut without = document.clone();
    without["holes"][0].as_object_mut().unwrap().remove("width");
    without["colour"] = json!("red");
    let faults = schema.faults_by("Inspect", &without);
    assert_eq!(
        faults,
        ["/colour is not described", "/holes/0/width is missing"]
    );
}
