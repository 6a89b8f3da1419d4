//! `isomend view`: what is handed over with a saved mesh, in files, figures and recipes.

use std::fs;
use std::process::Command;

use glam::DVec3;
use serde_json::{Value, json};

use crate::desk::{Desk, assert_code, ball};
use crate::packages::{holed, prusa};
use crate::served::{Served, in_ball};
use crate::shapes::{polar, sphere};
use isomend::io::Format;

/// A closed sphere with a dent at the lower pole, in steps that single precision stores exactly.
fn dented() -> isomend::Mesh {
    let mut mesh = sphere(10);
    for p in &mut mesh.positions {
        let depth = 0.25 * (1.0 - (180.0 - polar(*p)) / 30.0).max(0.0);
        *p = (*p * (1.0 - depth)).as_vec3().as_dvec3();
    }
    mesh
}

/// Serves the dented sphere in a format, with the dent restored.
fn restored<'d>(desk: &'d Desk, format: Format) -> Served<'d> {
    let name = format!("bust.{}", format.extension());
    desk.save(&name, &dented(), format);
    let served = Served::new(desk, &[&name]);
    let mask = in_ball(&served, [0.0, 0.0, -1.0], 0.75);
    served.step(&json!({ "kind": "restore", "mask": mask }));
    served
}

fn save(served: &Served, kind: &str, path: &str, deliver: &Value) -> Value {
    let sent = json!({ "kind": kind, "path": path, "overwrite": true, "deliver": deliver });
    let answer = served.post("api/save", &sent);
    assert_eq!(answer.status, 200, "{}", answer.json());
    answer.json()
}

/// A path with what is handed over as its query parameter.
fn with(path: &str, deliver: &Value) -> String {
    let mut query = String::new();
    for byte in deliver.to_string().bytes() {
        query += &format!("%{byte:02x}");
    }
    let sign = if path.contains('?') { '&' } else { '?' };
    format!("{path}{sign}deliver={query}")
}

/// Runs a shell recipe; returns its exit code.
#[cfg(unix)]
fn run_shell(desk: &Desk, script: &str) -> Option<i32> {
    let program = assert_cmd::cargo::cargo_bin("isomend");
    let folder = program.parent().unwrap().display().to_string();
    let path = format!("{folder}:{}", std::env::var("PATH").unwrap());
    let mut shell = Command::new("sh");
    let done = shell.arg(desk.path(script)).env("PATH", path).output();
    done.unwrap().status.code()
}

#[test]
#[cfg(unix)]
fn the_recipe_writes_the_same_patches_and_piece() {
    let desk = Desk::new();
    // From glTF to PLY a further command converts the mesh; the restoration writes the other files.
    for (format, output) in [
        (Format::Ply, "out.ply"),
        (Format::ThreeMf, "out.3mf"),
        (Format::Glb, "out.ply"),
    ] {
        let served = restored(&desk, format);
        let deliver = json!({ "unit": "cm", "tolerance": 1e-9, "mark": "colour=0a64ff", "patches": true, "piece": true });
        let saved = save(&served, "mesh", output, &deliver);
        let stem = output.split('.').next().unwrap();
        let patches = format!("{stem}_patches.{}", &output[stem.len() + 1..]);
        let is_3mf = output.ends_with("3mf");
        let piece = format!("{stem}_piece.{}", if is_3mf { "3mf" } else { "stl" });
        assert_eq!(saved["patches"], patches, "{saved}");
        assert_eq!(saved["piece"], piece, "{saved}");
        // Nothing is accurate to the billionth of a unit.
        let warnings = saved["warnings"].as_array().unwrap();
        assert!(
            warnings.len() == 1 && warnings[0].as_str().unwrap().contains("cm"),
            "{saved}"
        );
        save(&served, "recipe", "again.sh", &deliver);
        let script = fs::read_to_string(desk.path("again.sh")).unwrap();
        let options = format!(
            "--patches {patches} --piece {piece} --mark colour=0a64ff --tolerance 0.000000001 --unit cm"
        );
        assert!(script.contains(&options), "{script}");
        assert!(script.contains("|| [ $? -eq 3 ]"), "{script}");
        let files = [output, &patches, &piece].map(|name| desk.path(name));
        let wanted = files.clone().map(|file| fs::read(file).unwrap());
        files.iter().for_each(|file| fs::remove_file(file).unwrap());
        assert_eq!(run_shell(&desk, "again.sh"), Some(0), "{script}");
        for (file, wanted) in files.iter().zip(wanted) {
            assert!(fs::read(file).unwrap() == wanted, "{file:?} {script}");
            fs::remove_file(file).unwrap();
        }
        // Without a change of the request the recipe repeats what was saved.
        let again = served.get("api/recipe").json()["shell"].clone();
        assert!(again.as_str().unwrap().contains(&options), "{again}");
    }
}

/// A second save to the same name replaces what the session wrote, but no file of others that is written with it.
#[test]
fn files_of_others_are_not_replaced_with_those_of_the_session() {
    let desk = Desk::new();
    let served = restored(&desk, Format::Ply);
    let save = |patches: bool| {
        let sent = json!({ "kind": "mesh", "path": "out.ply", "deliver": { "patches": patches } });
        served.post("api/save", &sent)
    };
    assert_eq!(save(false).status, 200);
    assert_eq!(save(false).status, 200);
    let other = desk.path("out_patches.ply");
    fs::write(&other, "of another program").unwrap();
    let refused = save(true);
    assert_eq!(refused.status, 409, "{}", refused.json());
    assert_eq!(fs::read(&other).unwrap(), b"of another program");
    fs::remove_file(&other).unwrap();
    assert_eq!(save(true).status, 200);
    assert_eq!(save(true).status, 200);
}

#[test]
fn figures_measure_the_new_surface_by_the_tolerance() {
    let desk = Desk::new();
    let served = restored(&desk, Format::Ply);
    let figures = |deliver: &Value| served.get(&with("api/deliver/1", deliver)).json();
    let plain = figures(&json!({}));
    let invented = &plain["invented"];
    assert!(
        plain["piece"].is_null() && invented["beyond_tolerance"].is_null(),
        "{plain}"
    );
    // A cap of a sphere with an angle of 43 degrees about its pole has 13 % of its area.
    let percent = invented["percent"].as_f64().unwrap();
    assert!((8.0..18.0).contains(&percent), "{plain}");
    let wide = figures(&json!({ "tolerance": 1.0, "piece": true, "unit": "mm" }));
    assert_eq!(wide["piece"], json!({ "made": true, "reason": null }));
    assert_eq!(wide["invented"]["beyond_tolerance"], json!([]));
    assert_eq!(
        wide["invented"]["expected_error"]["within_percent"]
            .as_f64()
            .unwrap()
            .round(),
        100.0
    );
    // Only the vertices of the rim, whose error is 0, are within a billionth.
    let narrow = figures(&json!({ "tolerance": 1e-9 }));
    let within = narrow["invented"]["expected_error"]["within_percent"].as_f64();
    assert!(
        within.unwrap() < 20.0 && narrow["invented"]["beyond_tolerance"] != json!([]),
        "{narrow}"
    );
    // The report has the same figures.
    let report = served.get(&with(
        "api/report/1",
        &json!({ "unit": "mm", "tolerance": 1e-9 }),
    ));
    let text = String::from_utf8(report.body).unwrap();
    assert!(
        text.contains("--tolerance 0.000000001 --unit mm") && text.contains("mm²"),
        "{report_status}",
        report_status = report.status
    );
    // The file itself has none.
    let file = served
        .get(&with("api/deliver/0", &json!({ "tolerance": 1.0 })))
        .json();
    assert!(file["invented"].is_null(), "{file}");
}

#[test]
fn a_piece_that_cannot_be_made_is_refused_with_its_reason() {
    let desk = Desk::new();
    // Turned inside out the dent is a bump: nothing is missing there.
    let mut mesh = dented();
    for p in &mut mesh.positions {
        let depth = p.length() - 1.0;
        *p = (*p * ((1.0 - depth) / p.length())).as_vec3().as_dvec3();
    }
    desk.save("bump.ply", &mesh, Format::Ply);
    let served = Served::new(&desk, &["bump.ply"]);
    let mask = in_ball(&served, [0.0, 0.0, -1.1], 0.75);
    served.step(&json!({ "kind": "restore", "mask": mask }));
    let piece = json!({ "piece": true });
    let figures = served.get(&with("api/deliver/1", &piece)).json();
    let below = "the patch is below the faces that were cut out";
    assert_eq!(figures["piece"]["made"], false);
    assert!(
        figures["piece"]["reason"].as_str().unwrap().contains(below),
        "{figures}"
    );
    let shell = served.get(&with("api/recipe", &piece)).json()["shell"].clone();
    assert!(
        shell
            .as_str()
            .unwrap()
            .trim_end()
            .ends_with("|| [ $? -eq 3 ]"),
        "{shell}"
    );
    // The mesh is saved, and the answer says why the piece is not.
    let saved = save(&served, "mesh", "out.ply", &piece);
    assert!(saved["piece"].is_null(), "{saved}");
    assert!(
        saved["warnings"][0].as_str().unwrap().contains(below),
        "{saved}"
    );
    assert!(desk.path("out.ply").exists() && !desk.path("out_piece.stl").exists());
    let download = served.get(&with("api/download/1?format=ply&file=piece", &piece));
    assert_eq!(download.status, 422);
    assert!(download.json()["error"].as_str().unwrap().contains(below));
}

#[test]
fn downloads_have_the_bytes_of_the_saved_files() {
    let desk = Desk::new();
    let served = restored(&desk, Format::Stl);
    let deliver = json!({ "unit": "mm", "mark": "hatch", "patches": true, "piece": true });
    let saved = save(&served, "mesh", "out.ply", &deliver);
    assert_eq!(saved["warnings"], json!([]));
    for (file, name) in [
        ("mesh", "out.ply"),
        ("patches", "out_patches.ply"),
        ("piece", "out_piece.stl"),
    ] {
        let answer = served.get(&with(
            &format!("api/download/1?format=ply&file={file}"),
            &deliver,
        ));
        assert_eq!(answer.status, 200, "{file}");
        assert!(answer.body == fs::read(desk.path(name)).unwrap(), "{file}");
    }
    // The state has what was saved, so that the page can show it again.
    let kept = json!({ "unit": "mm", "tolerance": null, "mark": "hatch", "paint": null, "patches": true, "piece": true });
    assert_eq!(served.state()["deliver"], kept);
    // A mark changes the mesh.
    save(&served, "mesh", "plain.ply", &json!({}));
    assert!(fs::read(desk.path("plain.ply")).unwrap() != fs::read(desk.path("out.ply")).unwrap());
    assert_eq!(served.state()["deliver"]["mark"], Value::Null);
}

#[test]
fn what_cannot_be_handed_over_is_refused() {
    let desk = Desk::new();
    desk.save("out_patches.ply", &ball(), Format::Ply);
    let served = Served::new(&desk, &["ball.ply"]);
    let refused = |path: &str, deliver: Value, status: u16, words: &str| {
        let sent = json!({ "kind": "mesh", "path": path, "deliver": deliver });
        let answer = served.post("api/save", &sent);
        assert_eq!(answer.status, status, "{deliver} {}", answer.json());
        let error = answer.json()["error"].as_str().unwrap().to_owned();
        assert!(error.contains(words), "{error}");
    };
    let no_patches = "no patches to hand over";
    for deliver in [
        json!({ "mark": "hatch" }),
        json!({ "tolerance": 1.0 }),
        json!({ "piece": true }),
    ] {
        refused("new.ply", deliver, 422, no_patches);
    }
    // A unit needs no patches.
    save(&served, "mesh", "unit.3mf", &json!({ "unit": "cm" }));
    let shell = served.get("api/recipe").json()["shell"].clone();
    assert!(
        shell
            .as_str()
            .unwrap()
            .contains("convert ball.ply -o unit.3mf --unit cm"),
        "{shell}"
    );
    served.step(&json!({ "kind": "fill", "params": { "holes": [2] } }));
    refused("new.ply", json!({ "unit": "parsec" }), 422, "unknown unit");
    refused("new.ply", json!({ "mark": "red" }), 422, "not a mark");
    refused("new.ply", json!({ "tolerance": -1.0 }), 422, "positive");
    refused(
        "new.ply",
        json!({ "piece": true }),
        422,
        "only a restoration",
    );
    refused(
        "new.stl",
        json!({ "mark": "hatch" }),
        422,
        "STL has no colours",
    );
    refused("out.ply", json!({ "patches": true }), 409, "exists already");
    assert!(
        !desk
            .files()
            .iter()
            .any(|f| f.starts_with("new") || f == "out.ply"),
        "{:?}",
        desk.files()
    );
    // A faired mesh has no patches either: its command has no options for them.
    served.step(&json!({ "kind": "fair", "params": { "extent": { "strength": 0.2 } } }));
    refused("new.ply", json!({ "mark": "hatch" }), 422, no_patches);
    assert_eq!(served.get("api/recipe?deliver=nonsense").status, 422);
}

#[test]
fn paint_of_a_slicer_is_continued_on_patches_as_by_the_command() {
    let desk = Desk::new();
    prusa(&desk, "in.3mf", &[("ball", holed(5.0, DVec3::ZERO))], false);
    let served = Served::new(&desk, &["in.3mf"]);
    assert_eq!(served.state()["file"]["painted"], true);
    served.step(&json!({ "kind": "fill" }));
    for (paint, options) in [("none", &[][..]), ("continue", &["--paint", "continue"])] {
        save(&served, "mesh", "out.3mf", &json!({ "paint": paint }));
        let command = [&["fill", "in.3mf", "-o", "wanted.3mf"], options].concat();
        assert_code(&desk.run(&command), 0);
        let [made, wanted] = ["out.3mf", "wanted.3mf"].map(|name| fs::read(desk.path(name)));
        assert!(made.unwrap() == wanted.unwrap(), "{paint}");
        let recipe = served.get("api/recipe").json()["shell"].to_string();
        assert_eq!(recipe.contains("--paint continue"), !options.is_empty());
        let row = &served.state()["deliver"]["paint"];
        assert_eq!(row == "continue", !options.is_empty(), "{row}");
    }
    let plain = Served::new(&desk, &["ball.ply"]);
    assert_eq!(plain.state()["file"]["painted"], false);
}
