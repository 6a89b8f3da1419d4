//! The page of `--report` and the picture of `--picture`: complete, safe, bounded in size, the same for any number of threads.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use isomend::io::{Format, Precision, WriteOptions, to_bytes};
use isomend::report::picture::{picture, picture_of_one};
use isomend::report::scene::{Scene, SceneChange, Side};
use isomend::{FillParams, Mesh, fill};
use serde_json::Value;
use tempfile::TempDir;

use crate::shapes::{cut, polar, sphere};

/// A sphere with a wide hole, number 1, and a narrow one, number 2.
fn ball() -> Mesh {
    cut(&sphere(12), |c| polar(c) < 40.0 || polar(c) > 160.0)
}

/// A temporary folder that holds the ball in a file of the given name.
struct Desk {
    folder: TempDir,
    name: &'static str,
}

impl Desk {
    fn new(name: &'static str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let options = WriteOptions {
            precision: Precision::F32,
            ascii: false,
        };
        let bytes = to_bytes(&ball(), Format::Ply, &options).unwrap().bytes;
        fs::write(folder.path().join(name), bytes).unwrap();
        Self { folder, name }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, command: &str, more: &[&str]) -> Output {
        let mut isomend = Command::cargo_bin("isomend").unwrap();
        isomend.current_dir(self.folder.path());
        isomend.args([command, self.name, "-o", "out.ply", "-q"]);
        isomend.args(more).output().unwrap()
    }

    fn done(&self, command: &str, more: &[&str]) {
        let output = self.run(command, more);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
    }

    fn page(&self, command: &str, more: &[&str]) -> String {
        self.done(command, &[&["--report", "out.html"], more].concat());
        fs::read_to_string(self.path("out.html")).unwrap()
    }
}

/// The text of a script element of a page.
fn script<'a>(page: &'a str, id: &str) -> &'a str {
    let start = page.find(&format!("id=\"{id}\">")).unwrap();
    let text = &page[start..];
    let start = text.find('>').unwrap() + 1;
    &text[start..text.find("</script>").unwrap()]
}

fn data(page: &str) -> Value {
    serde_json::from_str(script(page, "data")).unwrap()
}

/// The arrays that the page's script unpacks.
fn arrays(page: &str) -> Vec<Vec<i64>> {
    let packed = STANDARD.decode(script(page, "geometry").trim()).unwrap();
    let mut bytes = Vec::new();
    flate2::read::ZlibDecoder::new(&packed[..])
        .read_to_end(&mut bytes)
        .unwrap();
    let mut bytes = bytes.into_iter().peekable();
    let mut arrays = Vec::new();
    while bytes.peek().is_some() {
        let mut whole = || {
            let (mut value, mut shift) = (0u64, 0);
            loop {
                let byte = bytes.next().unwrap();
                value |= u64::from(byte & 127) << shift;
                shift += 7;
                if byte < 128 {
                    return value as i64;
                }
            }
        };
        let (length, stride) = (whole() as usize, whole() as usize);
        let mut values: Vec<i64> = Vec::with_capacity(length);
        for i in 0..length {
            let zigzag = whole();
            let difference = (zigzag >> 1) ^ -(zigzag & 1);
            values.push(difference + if i >= stride { values[i - stride] } else { 0 });
        }
        arrays.push(values);
    }
    arrays
}

struct Picture {
    width: usize,
    pixels: Vec<u8>,
}

impl Picture {
    fn new(bytes: &[u8]) -> Self {
        let decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        Self {
            width: info.width as usize,
            pixels,
        }
    }

    fn read(path: &Path) -> Self {
        Self::new(&fs::read(path).unwrap())
    }

    /// Number of orange pixels (patches) in the left and in the right half.
    fn orange(&self) -> [usize; 2] {
        self.count(|[r, g, b]| r - b > 70 && r - g > 40)
    }

    /// Number of blue pixels (rims and hole numbers) in the left and in the right half.
    fn blue(&self) -> [usize; 2] {
        self.count(|[r, g, b]| b - r > 70 && b - g > 30)
    }

    fn count(&self, belongs: impl Fn([i32; 3]) -> bool) -> [usize; 2] {
        let mut counts = [0; 2];
        for (i, rgb) in self.pixels.chunks(3).enumerate() {
            if belongs([rgb[0], rgb[1], rgb[2]].map(i32::from)) {
                counts[usize::from(i % self.width > self.width / 2)] += 1;
            }
        }
        counts
    }
}

#[test]
fn the_page_loads_no_other_file() {
    let page = Desk::new("ball.ply").page("fill", &[]);
    for outside in [
        "http:",
        "https:",
        "src=",
        "@import",
        "url(",
        "<link rel=\"style",
        "fetch(",
    ] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.contains("default-src 'none'"));
    assert!(page.contains("isomend fill ball.ply -o out.ply -q --report out.html"));
    assert!(page.contains(concat!("version ", env!("CARGO_PKG_VERSION"))));
    assert_eq!(page.matches("<polyline class=\"line\"").count() % 2, 0);
    assert!(page.contains("Energy before each step") && page.contains("Residual"));
}

#[test]
fn the_page_holds_both_meshes() {
    let desk = Desk::new("ball.ply");
    let page = desk.page("fill", &[]);
    let (data, arrays) = (data(&page), arrays(&page));
    let scene = &data["scene"];
    let (kept, new) = (
        scene["kept"].as_u64().unwrap(),
        scene["new"].as_u64().unwrap(),
    );
    assert_eq!(kept as usize, ball().faces.len());
    assert!(new > 20);
    assert_eq!(arrays.len(), 9);
    assert!(arrays[4].iter().any(|&error| error > 0) && scene["error"].as_f64() > Some(0.0));
    assert_eq!(arrays[5].len() as u64, 3 * (kept + new));
    assert_eq!(arrays[6].len() as u64, new);
    let step = scene["step"].as_f64().unwrap();
    let radius = scene["radius"].as_f64().unwrap();
    for corner in arrays[0].chunks(3) {
        // The origin is the middle of the bounding box, which is near the ball's centre.
        let p =
            DVec3::from_slice(&[corner[0], corner[1], corner[2]].map(|x| x as f64 * step - radius));
        assert!((p.length() - 1.0).abs() < 0.03, "{p}");
    }
    let holes = data["holes"].as_array().unwrap();
    assert_eq!(holes.len(), 2);
    for hole in holes {
        assert_eq!(hole["open"], false);
        assert!(page.contains(&format!("data-hole=\"{}\"", hole["id"])));
        let region = hole["region"].as_i64().unwrap();
        assert!(arrays[6].contains(&region));
    }
    assert_eq!(arrays[8].len(), 2);
}

#[test]
fn the_page_of_a_restoration_holds_the_removed_faces() {
    let desk = Desk::new("ball.ply");
    let page = desk.page("restore", &["--ball", "1,0,0,0.4", "--picture", "out.png"]);
    let (data, arrays) = (data(&page), arrays(&page));
    let scene = &data["scene"];
    let shared = scene["kept"].as_u64().unwrap() + scene["new"].as_u64().unwrap();
    let gone = arrays[5].len() as u64 / 3 - shared;
    assert!(gone > 10);
    assert_eq!(
        scene["kept"].as_u64().unwrap() + gone,
        ball().faces.len() as u64
    );
    assert!(page.contains("faces cut out"));
    let [left, right] = Picture::read(&desk.path("out.png")).orange();
    assert!(left == 0 && right > 2000, "{left} {right}");
}

#[cfg(unix)]
#[test]
fn file_names_are_escaped_in_the_page() {
    let name = "<img onerror='x' \"a\">{{data}} & <!-- .ply";
    let desk = Desk::new(name);
    let page = desk.page("fill", &[]);
    assert!(!page.contains("<img") && !page.contains("<!--"));
    assert!(
        page.contains("&lt;img onerror=&#39;x&#39; &quot;a&quot;&gt;{{data}} &amp; &lt;!-- .ply")
    );
    assert_eq!(page.matches("<script").count(), 3);
    assert_eq!(page.matches("</script").count(), 3);
    data(&page);
}

#[test]
fn threads_change_neither_page_nor_picture() {
    let desk = Desk::new("ball.ply");
    let mut seen = Vec::new();
    for threads in ["1", "3"] {
        let more = ["--threads", threads, "--picture", "out.png"];
        let page = desk.page("fill", &more);
        let parts = [script(&page, "data"), script(&page, "geometry")].map(str::to_owned);
        let plots: String = page.lines().filter(|l| l.contains("<svg")).collect();
        seen.push((parts, plots, fs::read(desk.path("out.png")).unwrap()));
    }
    assert!(seen[0] == seen[1]);
}

#[test]
fn the_picture_shows_patches_on_the_right() {
    let desk = Desk::new("ball.ply");
    desk.done("fill", &["--picture", "out.png"]);
    let picture = Picture::read(&desk.path("out.png"));
    let [left, right] = picture.orange();
    let pixels = picture.pixels.len() / 3;
    assert_eq!(left, 0);
    assert!(right > pixels / 20, "{right} of {pixels}");
}

#[test]
fn visible_holes_are_outlined_and_numbered() {
    let desk = Desk::new("ball.ply");
    desk.done("fill", &["--picture", "out.png"]);
    let [left, right] = Picture::read(&desk.path("out.png")).blue();
    assert!(left > 500 && right > 500, "{left} {right}");
    // The view from the hole, and from behind, where the sphere hides rim and number.
    let mesh = cut(&sphere(12), |c| polar(c) < 40.0);
    let found = isomend::inspect(&mesh).unwrap();
    let rim: Vec<DVec3> = found.holes[0]
        .rim
        .iter()
        .map(|&v| mesh.positions[v as usize])
        .collect();
    let blue = |rims: Vec<Vec<DVec3>>| {
        let change = SceneChange {
            before: &mesh,
            after: &mesh,
            kept: mesh.faces.len(),
            gone: vec![false; mesh.faces.len()],
            patches: Vec::new(),
            rims,
            errors: &[],
        };
        let drawn = picture_of_one(&Scene::new(&change, usize::MAX)).unwrap();
        Picture::new(&drawn).blue()
    };
    let [front, back] = blue(vec![rim.clone()]);
    assert!(front > 500 && back == 0, "{front} {back}");
    // The number of a second hole at the same place is hidden by the first one; a small hole beside it shows its own number.
    let twice = blue(vec![rim.clone(), rim.clone()]);
    assert_eq!(twice, [front, back]);
    let small: Vec<DVec3> = rim
        .iter()
        .map(|p| (*p * 0.1 + DVec3::new(0.35, 0.0, 0.0)).with_z(p.z))
        .collect();
    let [both, _] = blue(vec![rim, small]);
    assert!(both > front + 100, "{both} after {front}");
}

#[test]
fn names_of_pages_and_pictures_are_checked_before_the_fill() {
    let desk = Desk::new("ball.ply");
    let cases: [(&[&str], &str, i32); 7] = [
        (&["--report", "no/out.html"], "no folder", 1),
        (&["--picture", "no/out.png"], "no folder", 1),
        (&["--report", "out.txt"], ".html", 2),
        (&["--picture", "out.jpg"], ".png", 2),
        (&["--report", "-"], ".html", 2),
        (&["--report", "a.html", "--json", "a.html"], "--json too", 2),
        (
            &["--picture", "b.png", "--json", "./b.png"],
            "--json too",
            2,
        ),
    ];
    for (more, message, code) in cases {
        let output = desk.run("fill", more);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{more:?}");
        assert!(said.contains(message), "{more:?}: {said}");
        assert!(!desk.path("out.ply").exists(), "{more:?}");
    }
}

#[test]
fn the_picture_cannot_overwrite_the_mesh() {
    let desk = Desk::new("ball.ply");
    let mut isomend = Command::cargo_bin("isomend").unwrap();
    isomend.current_dir(desk.folder.path());
    let arguments = [
        "fill",
        "ball.ply",
        "-o",
        "a.png",
        "--to",
        "ply",
        "--picture",
        "a.png",
    ];
    let output = isomend.args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("is the file of the mesh"));
    assert!(!desk.path("a.png").exists());
}

fn scene_of(mesh: &Mesh, limit: usize) -> (Scene, usize) {
    scene_with(mesh, limit, |error| error)
}

/// The scene of a fill whose expected errors are changed by a function.
fn scene_with(
    mesh: &Mesh,
    limit: usize,
    changed: impl Fn(Option<f64>) -> Option<f64>,
) -> (Scene, usize) {
    let filled = fill(mesh, &FillParams::default()).unwrap();
    let errors: Vec<Option<f64>> = filled.expected_error.iter().map(|e| changed(*e)).collect();
    let rims = filled.report.holes.iter().map(|h| {
        let rim = h.hole.rim.iter();
        rim.map(|&v| mesh.positions[v as usize]).collect()
    });
    let change = SceneChange {
        before: mesh,
        after: &filled.mesh,
        kept: mesh.faces.len(),
        gone: vec![false; mesh.faces.len()],
        patches: filled.report.regions.iter().map(|r| r.new_faces).collect(),
        rims: rims.collect(),
        errors: &errors,
    };
    let new = filled.mesh.faces.len() - mesh.faces.len();
    (Scene::new(&change, limit), new)
}

#[test]
fn large_meshes_are_drawn_coarser_far_from_the_patches() {
    let mesh = cut(&sphere(60), |c| polar(c) < 7.0);
    let (scene, new) = scene_of(&mesh, 12_000);
    assert!(scene.all_faces > 60_000);
    assert!(scene.faces.len() <= 12_000 && scene.faces.len() > 4000);
    assert_eq!(scene.regions.len(), new);
    let (tiny, _) = scene_of(&mesh, 40);
    assert!(tiny.faces.len() <= 40);
    Picture::new(&picture(&tiny).unwrap());
}

#[test]
fn only_new_vertices_have_expected_errors_above_zero() {
    let (scene, _) = scene_of(&ball(), usize::MAX);
    let new = scene.kept..scene.kept + scene.regions.len();
    let (mut known, mut expected) = (0, 0);
    for &v in scene.faces[..scene.kept].iter().flatten() {
        known += usize::from(scene.error[v as usize] == 0.0);
    }
    for &v in scene.faces[new.clone()].iter().flatten() {
        expected += usize::from(scene.error[v as usize] > 0.0);
    }
    assert_eq!(known, 3 * scene.kept);
    assert!(
        expected > new.len(),
        "{expected} of {} corners",
        3 * new.len()
    );
    // An unknown error is not drawn as zero.
    let (scene, _) = scene_with(&ball(), usize::MAX, |_| None);
    let unknown = |faces: &[[u32; 3]]| {
        let corners = faces.iter().flatten();
        corners
            .filter(|v| scene.error[**v as usize].is_nan())
            .count()
    };
    assert_eq!(unknown(&scene.faces[..scene.kept]), 0);
    assert!(unknown(&scene.faces[new.clone()]) > new.len());
}

#[test]
fn curvature_and_distance_of_a_filled_sphere_are_correct() {
    let (scene, _) = scene_of(&ball(), usize::MAX);
    let inner = scene
        .side(Side::After)
        .flat_map(|f| scene.faces[f as usize]);
    for v in inner {
        let h = scene.curvature[v as usize];
        assert!(
            (h - 2.0).abs() < 0.25,
            "{h} at {}",
            scene.positions[v as usize]
        );
        assert!(scene.normals[v as usize].dot(scene.positions[v as usize]) > 0.9);
    }
    let far = scene.distance.iter().copied().fold(0.0, f32::max);
    // The farthest vertex is at the middle of the wide patch, 40 degrees from its rim.
    assert!((far - 2.0 * 20f32.to_radians().sin()).abs() < 0.1, "{far}");
}

#[test]
fn empty_and_degenerate_meshes_are_drawn_without_failure() {
    let empty = Mesh::default();
    let change = SceneChange {
        before: &empty,
        after: &empty,
        kept: 0,
        gone: Vec::new(),
        patches: vec![3],
        rims: vec![Vec::new()],
        errors: &[],
    };
    let scene = Scene::new(&change, 10);
    Picture::new(&picture(&scene).unwrap());
    let flat = Mesh::new(vec![DVec3::splat(1e300); 3], vec![[0, 1, 2]]);
    let change = SceneChange {
        before: &flat,
        after: &flat,
        kept: 1,
        gone: vec![false],
        patches: Vec::new(),
        rims: Vec::new(),
        errors: &[],
    };
    Picture::new(&picture(&Scene::new(&change, 10)).unwrap());
}
