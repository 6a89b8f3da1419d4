//! `isomend view`: steps with a counterpart, with grain, and with texels; their recipes give the same bytes.

use std::fs;
use std::path::Path;

use glam::DVec3;
use isomend::Mesh;
use isomend::io::Format;
use serde_json::{Value, json};

use crate::desk::{Desk, assert_code, ball};
use crate::recipes::{input_with_materials, run_shell};
use crate::served::{Served, in_ball};
use crate::shapes::{cut, sphere};

/// The bump beside which the body is cut.
const BUMP: DVec3 = DVec3::new(0.69, 0.4, 0.6);

/// An ellipsoid with a pair of bumps on both sides of x = 0, and one elsewhere; its coordinates are exact in 32-bit floats.
fn body() -> Mesh {
    let bumps = [
        (BUMP, 0.15),
        (BUMP * DVec3::new(-1.0, 1.0, 1.0), 0.15),
        (DVec3::new(0.0, 0.1, 1.0), 0.1),
        (DVec3::new(-0.78, -0.6, -0.2), 0.25),
    ];
    let mut mesh = sphere(24);
    for p in &mut mesh.positions {
        let height =
            |(at, height): &(DVec3, f64)| height * (-(p.distance(*at) / 0.16).powi(2)).exp();
        let all: f64 = bumps.iter().map(height).sum();
        *p = (*p * DVec3::new(1.0, 1.3, 0.9) + *p * all)
            .as_vec3()
            .as_dvec3();
    }
    mesh
}

/// `bust.ply`: the body with a hole at a bump; `cast.ply`: the whole body, shifted.
fn bust() -> Desk {
    let desk = Desk::new();
    let whole = body();
    let hole = cut(&whole, |p| {
        (p / DVec3::new(1.0, 1.3, 0.9))
            .normalize()
            .distance(BUMP.normalize())
            < 0.3
    });
    desk.save("bust.ply", &hole, Format::Ply);
    let mut cast = whole;
    for p in &mut cast.positions {
        *p += DVec3::new(0.125, 0.0, 0.0);
    }
    desk.save("cast.ply", &cast, Format::Ply);
    desk
}

fn fill(params: Value) -> Value {
    json!({ "kind": "fill", "params": params })
}

/// Saves the current mesh and its recipe, runs the recipe, and asserts that it gives the same bytes; returns the script.
fn repeated(served: &Served, output: &str, script: &str) -> String {
    let desk = served.desk;
    served.save("mesh", output);
    let made = fs::read(desk.path(output)).unwrap();
    served.save("recipe", script);
    let text = fs::read_to_string(desk.path(script)).unwrap();
    fs::remove_file(desk.path(output)).unwrap();
    run_shell(desk, script);
    assert!(fs::read(desk.path(output)).unwrap() == made, "{text}");
    text
}

#[test]
#[cfg(unix)]
fn a_hole_is_filled_after_the_other_side() {
    let desk = bust();
    for (like, grain) in [("mirror", false), ("mirror:0,0.5,0,1,0.001,0", true)] {
        let [output, script] = ["ply", "sh"].map(|end| format!("grain_{grain}.{end}"));
        let served = Served::new(&desk, &["bust.ply"]);
        let state = served.step(&fill(json!({ "like": like, "grain": grain })));
        let report = &state["states"][1]["report"];
        let found = &report["regions"][0]["counterpart"];
        assert_eq!(
            (&found["used"], &found["kind"]),
            (&json!(true), &json!("mirror"))
        );
        assert!(
            found["plane"][1][0].as_f64().unwrap().abs() > 0.999,
            "{found}"
        );
        let script = repeated(&served, &output, &script);
        assert!(
            script.contains(&format!(" --like {}", &like[..6])),
            "{script}"
        );
        assert_eq!(script.contains(" --grain"), grain, "{script}");
        // The command line with the option as it was typed.
        let made = fs::read(desk.path(&output)).unwrap();
        let grain: &[&str] = if grain { &["--grain"] } else { &[] };
        let typed = ["fill", "bust.ply", "-o", "typed.ply", "--like", like];
        assert_code(&desk.run(&[&typed, grain].concat()), 0);
        assert!(fs::read(desk.path("typed.ply")).unwrap() == made, "{like}");
    }
}

#[test]
#[cfg(unix)]
fn a_template_is_read_from_the_folder() {
    let desk = bust();
    fs::create_dir(desk.path("sub")).unwrap();
    fs::rename(desk.path("cast.ply"), desk.path("mirror cast.ply")).unwrap();
    let served = Served::new(&desk, &["bust.ply"]);
    let step = fill(json!({ "like": "./mirror cast.ply" }));
    let state = served.step(&step);
    let row = &state["states"][1];
    let found = &row["report"]["regions"][0]["counterpart"];
    assert_eq!(
        (&found["used"], &found["kind"]),
        (&json!(true), &json!("template"))
    );
    let shown = json!(["fill", "--like", "./mirror cast.ply"]);
    assert_eq!(row["command"], shown, "no path of this machine");
    let script = repeated(&served, "out.ply", "again.sh");
    assert!(script.contains("--like './mirror cast.ply'"), "{script}");
    let script = repeated(&served, "other.ply", "sub/again.sh");
    assert!(script.contains("--like '../mirror cast.ply'"), "{script}");
    // The template is not overwritten while a step uses it.
    for (kind, path) in [("mesh", "mirror cast.ply"), ("mesh", "./mirror cast.ply")] {
        let sent = json!({ "kind": kind, "path": path, "overwrite": true });
        let answer = served.post("api/save", &sent);
        assert_eq!(answer.status, 409, "{}", answer.json());
    }
    // A step that was not saved is repeated.
    let first = Served::new(&desk, &["bust.ply", "--port", "0"]);
    first.step(&step);
    drop(first);
    let again = Served::new(&desk, &["bust.ply", "--resume"]);
    let state = again.wait(|s| s["busy"].is_null() && s["current"] == 1);
    assert_eq!(state["states"][1]["command"], shown);
}

#[test]
fn a_template_outside_of_the_folder_is_refused() {
    let desk = bust();
    fs::create_dir(desk.path("root")).unwrap();
    fs::copy(desk.path("bust.ply"), desk.path("root/bust.ply")).unwrap();
    desk.text("root/text.ply", "no mesh");
    #[cfg(unix)]
    std::os::unix::fs::symlink("../cast.ply", desk.path("root/link.ply")).unwrap();
    let served = Served::new(&desk, &["root/bust.ply"]);
    let whole = desk.path("cast.ply").display().to_string();
    for (file, status) in [
        ("../cast.ply", 403),
        (&whole[..], 403),
        ("/etc/passwd", 403),
        ("none.ply", 404),
        ("", 422),
        #[cfg(unix)]
        ("link.ply", 403),
    ] {
        for step in [
            fill(json!({ "like": file })),
            json!({ "kind": "restore", "mask": [[0, 9]], "params": { "fill": { "like": file } } }),
            json!({ "kind": "repair", "params": { "fill": { "like": file } } }),
        ] {
            let answer = served.post("api/step", &step);
            assert_eq!(answer.status, status, "{file}: {}", answer.json());
        }
    }
    // A file that is no mesh fails the run, and the mesh stays.
    let answer = served.post("api/step", &fill(json!({ "like": "text.ply" })));
    assert_eq!(answer.status, 202);
    let state = served.wait(|s| s["busy"].is_null());
    assert_eq!(state["current"], 0);
    // A stored session does not lead out of the folder either.
    served.step(&fill(json!({ "like": "mirror" })));
    drop(served);
    let session = desk.session().unwrap();
    let text = fs::read_to_string(&session).unwrap();
    assert!(text.contains("\"like\":\"mirror\""), "{text}");
    let other = json!(whole).to_string();
    fs::write(
        &session,
        text.replace("\"like\":\"mirror\"", &format!("\"like\":{other}")),
    )
    .unwrap();
    let again = Served::new(&desk, &["root/bust.ply", "--resume"]);
    let state = again.wait(|s| s["busy"].is_null());
    assert_eq!(state["current"], 0, "{state}");
}

#[test]
fn a_wrong_plane_or_combination_is_refused() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    for params in [
        json!({ "like": "mirror:0,0,0,0,0,0" }),
        json!({ "like": "mirror:1,2,3" }),
        json!({ "like": "mirror", "finish": "none" }),
        json!({ "grain": true, "finish": "none" }),
    ] {
        let answer = served.post("api/step", &fill(params.clone()));
        assert_eq!(answer.status, 422, "{params}: {}", answer.json());
    }
    let faired =
        json!({ "kind": "fair", "no_texture": true, "params": { "extent": { "strength": 0.4 } } });
    let answer = served.post("api/step", &faired);
    assert_eq!(
        (answer.status, &answer.json()["where"]),
        (422, &json!("no_texture"))
    );
}

#[test]
fn any_given_plane_can_be_written_as_a_command() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    for i in 0..40 {
        let [x, y, z] = [0.37, 0.61, 0.83].map(|k| f64::sin(f64::from(i) * k + k));
        let like = format!("mirror:0.1,0.2,0.3,{x:.6},{y:.6},{z:.6}");
        let step = json!({ "kind": "fill", "params": { "like": like, "holes": [9] } });
        let answer = served.post("api/step", &step);
        assert_eq!(answer.status, 202, "{like}: {}", answer.json());
        served.wait(|s| s["busy"].is_null());
    }
}

/// `dressed.obj`: the ball in two charts on an image, and the same as glTF.
fn dressed() -> Desk {
    let desk = Desk::new();
    assert_eq!(input_with_materials(&desk), "dressed.obj");
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 32, 32);
    encoder.set_color(png::ColorType::Rgb);
    let data: Vec<u8> = (0..3 * 32 * 32).map(|i| (i * 7 % 251) as u8).collect();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&data).unwrap();
    writer.finish().unwrap();
    fs::write(desk.path("skin.png"), bytes).unwrap();
    for name in ["dressed.glb", "dressed.gltf"] {
        assert_code(&desk.run(&["convert", "dressed.obj", "-o", name]), 0);
    }
    desk
}

/// Whether a saved mesh has a page of texels: in a file of its own, or in the mesh.
fn has_texels(desk: &Desk, output: &str) -> bool {
    let bytes = fs::read(desk.path(output)).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    let own = Path::new(output)
        .file_stem()
        .unwrap()
        .to_string_lossy()
        .into_owned()
        + "_isomend";
    let beside = desk.path(&format!("{own}.png")).exists();
    text.contains(&own) && (beside || output.ends_with("glb"))
}

#[test]
#[cfg(unix)]
fn the_recipe_of_a_session_with_texels_gives_the_same_files() {
    for (input, output) in [
        ("dressed.obj", "out.obj"),
        ("dressed.glb", "out.glb"),
        ("dressed.gltf", "out.gltf"),
        ("dressed.obj", "out.glb"),
    ] {
        let desk = dressed();
        let served = Served::new(&desk, &[input]);
        let state = served.step(&fill(json!({ "holes": [1] })));
        assert!(!state["texture"].is_null());
        let mask = in_ball(&served, [0.0, 1.0, 0.0], 0.4);
        served.step(&json!({ "kind": "restore", "mask": mask }));
        served.save("mesh", output);
        assert!(has_texels(&desk, output), "{input} {output}");
        served.save("recipe", "again.sh");
        let script = fs::read_to_string(desk.path("again.sh")).unwrap();
        assert_eq!(
            script.contains("--no-texture"),
            input.ends_with("obj"),
            "{script}"
        );
        let files = desk.files();
        let read = || files.iter().map(|name| fs::read(desk.path(name)).unwrap());
        let made: Vec<Vec<u8>> = read().collect();
        let new = |name: &&String| name.starts_with("out");
        files
            .iter()
            .filter(new)
            .for_each(|name| fs::remove_file(desk.path(name)).unwrap());
        run_shell(&desk, "again.sh");
        // The material of plain patches beside an intermediate OBJ file.
        if !files.contains(&"isomend_patch.mtl".to_owned()) {
            let _ = fs::remove_file(desk.path("isomend_patch.mtl"));
        }
        assert_eq!(desk.files(), files, "{script}");
        for ((name, made), now) in files.iter().zip(&made).zip(read()) {
            assert!(now == *made, "{input} {output} {name}: {script}");
        }
    }
}

#[test]
fn texels_are_left_out_on_request() {
    let desk = dressed();
    let served = Served::new(&desk, &["dressed.obj"]);
    let mut step = fill(json!({ "holes": [1] }));
    step["no_texture"] = json!(true);
    let state = served.step(&step);
    assert_eq!(
        state["states"][1]["command"],
        json!(["fill", "--holes", "1", "--no-texture"])
    );
    served.save("mesh", "out.obj");
    assert!(!has_texels(&desk, "out.obj"));
    assert_code(
        &desk.run(&[
            "fill",
            "dressed.obj",
            "-o",
            "typed.obj",
            "--holes",
            "1",
            "--no-texture",
        ]),
        0,
    );
    assert!(fs::read(desk.path("typed.obj")).unwrap() == fs::read(desk.path("out.obj")).unwrap());
    // A resumed session keeps the choice.
    served.step(&json!({ "kind": "fill", "params": { "holes": [1] }, "no_texture": true }));
    drop(served);
    let again = Served::new(&desk, &["dressed.obj", "--resume"]);
    let state = again.wait(|s| s["busy"].is_null() && s["current"] == 2);
    assert_eq!(
        state["states"][2]["command"],
        json!(["fill", "--holes", "1", "--no-texture"])
    );
}

#[test]
fn a_download_has_the_texels_or_is_refused() {
    let desk = dressed();
    for input in ["dressed.obj", "dressed.glb"] {
        let served = Served::new(&desk, &[input]);
        served.step(&fill(json!({ "holes": [1] })));
        let answer = served.get("api/download/1?format=obj");
        if input.ends_with("obj") {
            let said = answer.json()["error"].to_string();
            assert!(
                answer.status == 422 && said.contains("save it in the folder"),
                "{said}"
            );
        }
        let answer = served.get("api/download/1?format=glb");
        assert_eq!(answer.status, 200);
        served.save("mesh", "dressed_mended.glb");
        assert!(has_texels(&desk, "dressed_mended.glb"));
        assert!(
            answer.body == fs::read(desk.path("dressed_mended.glb")).unwrap(),
            "{input}"
        );
        fs::remove_file(desk.path("dressed_mended.glb")).unwrap();
    }
}

#[test]
fn saving_says_which_patches_have_no_texels() {
    let desk = dressed();
    let served = Served::new(&desk, &["dressed.obj"]);
    served.step(&fill(json!({ "holes": [1] })));
    let saved = served.save("mesh", "one.obj");
    assert!(
        saved["notes"].to_string().contains("one_isomend.png"),
        "{saved}"
    );
    served.step(&fill(json!({ "holes": [1] })));
    let saved = served.save("mesh", "two.obj");
    assert!(
        saved["notes"].to_string().contains("earlier steps"),
        "{saved}"
    );
    // The ball itself has no texture, so that nothing is said.
    desk.save("plain.obj", &ball(), Format::Obj);
    let served = Served::new(&desk, &["plain.obj"]);
    served.step(&fill(json!({ "holes": [1] })));
    served.step(&fill(json!({ "holes": [1] })));
    assert!(
        !served.save("mesh", "three.obj")["notes"]
            .to_string()
            .contains("earlier steps")
    );
}
