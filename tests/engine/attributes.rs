//! `isomend fill` keeps attributes, materials, groups and glTF documents of files, and continues attributes over patches.

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

use assert_cmd::Command;
use glam::DVec3;
use isomend::Mesh;
use isomend::io::{
    Contents, Format, Loaded, WriteOptions, model_to_bytes, no_side_files, read_bytes, read_path,
};
use isomend::{Attribute, Attributes, PATCH_NAME, Role, Scalar};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::shapes::{self, cut, polar, sphere};

/// A temporary folder in which the program runs.
struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Fills a file; returns the text on standard error.
    fn fill(&self, input: &str, output: &str) -> String {
        let mut command = Command::cargo_bin("isomend").unwrap();
        command.current_dir(self.0.path());
        let done = command
            .args(["fill", input, "-o", output])
            .output()
            .unwrap();
        let said = String::from_utf8(done.stderr).unwrap();
        assert!(done.status.success(), "{said}");
        said
    }

    fn read(&self, name: &str) -> Loaded {
        read_path(&self.path(name), None).unwrap()
    }
}

/// A unit sphere without its top; its coordinates are exact in 32-bit floats.
fn bowl() -> Mesh {
    let mut mesh = cut(&sphere(8), |p| polar(p) < 35.0);
    for p in &mut mesh.positions {
        *p = p.as_vec3().as_dvec3();
    }
    mesh
}

fn attribute(
    mesh: &Mesh,
    name: &str,
    role: Role,
    scalar: Scalar,
    f: impl Fn(DVec3) -> Vec<f64>,
) -> Attribute {
    let mut out = Attribute::new(name, role, scalar, f(DVec3::X).len());
    mesh.positions.iter().for_each(|p| out.push(Some(&f(*p))));
    out
}

fn red_to_green(p: DVec3) -> Vec<f64> {
    vec![127.0 + 100.0 * p.x, 127.0 - 100.0 * p.x, 9.0]
}

fn dressed(mesh: &Mesh) -> Attributes {
    Attributes {
        vertex: vec![
            attribute(mesh, "colour", Role::Colour, Scalar::U8, red_to_green),
            attribute(mesh, "normal", Role::Normal, Scalar::F32, |p| {
                p.normalize().to_array().to_vec()
            }),
            attribute(mesh, "uv", Role::Uv(0), Scalar::F32, |p| vec![p.x, p.y]),
            attribute(mesh, "scan", Role::Other, Scalar::I16, |p| {
                vec![if p.x < 0.0 { -1.0 } else { 7.0 }]
            }),
        ],
        ..Attributes::default()
    }
}

fn save(desk: &Desk, name: &str, format: Format, mesh: &Mesh, attributes: &Attributes) {
    let model = Contents {
        mesh,
        attributes,
        document: None,
    };
    let written = model_to_bytes(&model, format, &WriteOptions::default()).unwrap();
    fs::write(desk.path(name), written.bytes).unwrap();
}

/// Colours, normals and texture coordinates of the patch follow the functions of the position that the input has.
fn assert_continued(loaded: &Loaded, before: usize) {
    // glTF measures the second texture coordinate from the other side of the image.
    let is_gltf = matches!(loaded.format, Format::Gltf | Format::Glb);
    let second = |y: f64| if is_gltf { 1.0 - y } else { y };
    let vertex = |role| loaded.attributes.vertex_role(role).unwrap();
    let (colour, normal, uv) = (
        vertex(Role::Colour),
        vertex(Role::Normal),
        vertex(Role::Uv(0)),
    );
    let unit = colour.unit();
    assert!(loaded.mesh.positions.len() > before + 10);
    for (v, p) in loaded.mesh.positions.iter().enumerate().skip(before) {
        let got = colour.get(v).unwrap();
        for (got, wanted) in got.iter().zip(red_to_green(*p)) {
            assert!(
                (got / unit - wanted / 255.0).abs() < 0.05,
                "{got} {wanted} at {p}"
            );
        }
        let n = DVec3::from_slice(normal.get(v).unwrap());
        assert!(
            (n.length() - 1.0).abs() < 1e-4 && n.dot(p.normalize()) > 0.98,
            "{n} at {p}"
        );
        let t = uv.get(v).unwrap();
        assert!(
            (t[0] - p.x).abs() < 0.05 && (t[1] - second(p.y)).abs() < 0.05,
            "{t:?} at {p}"
        );
    }
}

#[test]
fn a_fill_keeps_the_properties_of_a_ply_file() {
    let desk = Desk::new();
    let mesh = bowl();
    save(&desk, "in.ply", Format::Ply, &mesh, &dressed(&mesh));
    let said = desk.fill("in.ply", "out.ply");
    assert!(!said.contains("left out"), "{said}");
    let (before, after) = (desk.read("in.ply"), desk.read("out.ply"));
    let (n, m) = (mesh.positions.len(), mesh.faces.len());
    for (a, b) in before
        .attributes
        .vertex
        .iter()
        .zip(&after.attributes.vertex)
    {
        assert_eq!((&a.fields, a.scalar), (&b.fields, b.scalar));
        assert_eq!(a.values, b.values[..n * a.components], "{}", a.name);
    }
    // The fifth attribute is the expected error of the patch's vertices; the others come from the file.
    assert_eq!(after.attributes.vertex.len(), 5);
    let expected = &after.attributes.vertex[4];
    assert_eq!(expected.name, "isomend_sigma");
    assert!(expected.values[..n].iter().all(|s| *s == 0.0));
    assert!(expected.values[n..].iter().all(|s| *s > 0.0));
    assert_continued(&after, n);
    let scan = &after.attributes.vertex[3].values;
    assert!(scan.iter().all(|s| *s == -1.0 || *s == 7.0));
    for f in 0..after.mesh.faces.len() {
        assert_eq!(after.attributes.is_patch(f), f >= m);
    }
    // The same through GLB and back; colours and texture coordinates take the types of glTF.
    desk.fill("in.ply", "out.glb");
    let glb = desk.read("out.glb");
    assert_eq!(glb.mesh.faces[..m], mesh.faces);
    assert_continued(&glb, n);
    assert!(glb.attributes.is_patch(m) && !glb.attributes.is_patch(m - 1));
    let said = desk.fill("in.ply", "out.stl");
    assert!(
        said.contains("left out") && said.contains("colours"),
        "{said}"
    );
}

#[test]
fn a_fill_keeps_the_arrays_of_vtk_files() {
    let desk = Desk::new();
    let mesh = bowl();
    let mut attributes = dressed(&mesh);
    let mut flow = Attribute::new("flow", Role::Other, Scalar::F64, 3);
    (0..mesh.faces.len()).for_each(|f| flow.push(Some(&[f as f64, 0.5, -1.0])));
    let mut part = Attribute::new("part", Role::Other, Scalar::I64, 1);
    (0..mesh.faces.len()).for_each(|f| part.push(Some(&[(f % 3) as f64])));
    attributes.face = vec![flow, part];
    let (n, m) = (mesh.positions.len(), mesh.faces.len());
    for format in [Format::Vtk, Format::Vtp] {
        let [input, output] = ["in", "out"].map(|name| format!("{name}.{}", format.extension()));
        save(&desk, &input, format, &mesh, &attributes);
        let said = desk.fill(&input, &output);
        assert!(!said.contains("left out"), "{said}");
        let (before, after) = (desk.read(&input).attributes, desk.read(&output));
        let same = |old: &[Attribute], new: &[Attribute], count: usize| {
            for a in old {
                let b = new.iter().find(|b| b.name == a.name).unwrap();
                assert_eq!(
                    (a.scalar, a.components, a.active),
                    (b.scalar, b.components, b.active)
                );
                assert_eq!(a.values, b.values[..count * a.components], "{}", a.name);
            }
        };
        same(&before.vertex, &after.attributes.vertex, n);
        same(&before.face, &after.attributes.face, m);
        assert_eq!((before.vertex.len(), before.face.len()), (4, 2));
        assert_continued(&after, n);
        for f in 0..after.mesh.faces.len() {
            assert_eq!(after.attributes.is_patch(f), f >= m);
        }
        let part = after
            .attributes
            .face
            .iter()
            .find(|a| a.name == "part")
            .unwrap();
        assert!(
            part.values
                .iter()
                .all(|v| (0.0..3.0).contains(v) && v.fract() == 0.0)
        );
        // Restore keeps attributes of faces that it does not cut out; a second run keeps the patch marks of the first.
        let mut command = Command::cargo_bin("isomend").unwrap();
        let mask = [
            "restore",
            &output,
            "-o",
            "again.ply",
            "--ball",
            "0,0,-1,0.3",
            "-q",
        ];
        command
            .current_dir(desk.0.path())
            .args(mask)
            .assert()
            .success();
        let again = desk.read("again.ply");
        let scan = again
            .attributes
            .vertex
            .iter()
            .find(|a| a.name == "scan")
            .unwrap();
        assert_eq!(scan.scalar, Scalar::I16);
        assert!(again.attributes.is_patch(again.mesh.faces.len() - 1));
        let flows = again
            .attributes
            .face
            .iter()
            .filter(|a| a.name.starts_with("flow"))
            .count();
        assert_eq!(flows, 3);
    }
}

/// The bowl as OBJ text, with texture coordinates in two charts that meet where x is `seam`, and two materials.
fn obj(mesh: &Mesh, seam: f64) -> String {
    let mut text = "mtllib bowl.mtl\no bowl\n".to_owned();
    for p in &mesh.positions {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    for shift in [0.0, 5.0] {
        for p in &mesh.positions {
            writeln!(text, "vt {} {}", p.x + shift, p.y).unwrap();
        }
    }
    for p in &mesh.positions {
        writeln!(text, "vn {} {} {}", p.x, p.y, p.z).unwrap();
    }
    let n = mesh.positions.len() as u32;
    for right in [false, true] {
        let side = if right { "right" } else { "left" };
        writeln!(text, "g {side}\nusemtl {side}").unwrap();
        for face in &mesh.faces {
            let x: f64 = face.iter().map(|v| mesh.positions[*v as usize].x).sum();
            if (x > 3.0 * seam) == right {
                let corner = |v: u32| format!(" {0}/{1}/{0}", v + 1, v + 1 + n * u32::from(right));
                writeln!(
                    text,
                    "f{}{}{}",
                    corner(face[0]),
                    corner(face[1]),
                    corner(face[2])
                )
                .unwrap();
            }
        }
    }
    text
}

fn lines<'a>(text: &'a str, word: &str) -> Vec<&'a str> {
    let is = |l: &&str| l.split(' ').next() == Some(word);
    text.lines().filter(is).collect()
}

#[test]
fn colours_and_textures_of_materials_go_from_obj_to_gltf() {
    let desk = Desk::new();
    let mesh = bowl();
    fs::write(desk.path("in.obj"), obj(&mesh, -0.8)).unwrap();
    let mtl = "newmtl left\nKd 1 0 0\nd 0.5\nnewmtl right\nKd 0.5 0.5 0.5\nmap_Kd maps/skin.png\n";
    fs::write(desk.path("bowl.mtl"), mtl).unwrap();
    fs::create_dir(desk.path("maps")).unwrap();
    fs::write(desk.path("maps/skin.png"), b"\x89PNG\r\n\x1a\n").unwrap();
    desk.fill("in.obj", "out.gltf");
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(desk.path("out.gltf")).unwrap()).unwrap();
    let [left, right] = [0, 1].map(|i| &json["materials"][i]["pbrMetallicRoughness"]);
    assert_eq!(
        left["baseColorFactor"],
        serde_json::json!([1.0, 0.0, 0.0, 0.5])
    );
    assert_eq!(right["baseColorTexture"]["index"], 0);
    assert_eq!(json["images"][0]["uri"], "maps/skin.png");
    // The patch has the material of its rim, and its texture.
    let primitives = json["meshes"][0]["primitives"].as_array().unwrap();
    let patch = primitives
        .iter()
        .find(|p| p.get("extras").is_some())
        .unwrap();
    assert_eq!(patch["material"], 1);
    assert!(patch["attributes"]["TEXCOORD_0"].is_u64());
    // Material files outside the folder are not read; only the names of the materials are kept.
    fs::create_dir(desk.path("inner")).unwrap();
    let text = obj(&mesh, -0.8).replace("bowl.mtl", "../bowl.mtl");
    fs::write(desk.path("inner/in.obj"), text).unwrap();
    let said = desk.fill("inner/in.obj", "names.gltf");
    assert!(
        said.contains("'../bowl.mtl' is outside the folder"),
        "{said}"
    );
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(desk.path("names.gltf")).unwrap()).unwrap();
    assert_eq!(json["materials"][0], serde_json::json!({ "name": "left" }));
}

#[test]
fn a_fill_keeps_materials_groups_and_charts_of_an_obj_file() {
    let desk = Desk::new();
    let mesh = bowl();
    for (seam, single) in [(-0.8, true), (0.1, false)] {
        let before = obj(&mesh, seam);
        fs::write(desk.path("in.obj"), &before).unwrap();
        let said = desk.fill("in.obj", "out.obj");
        assert!(
            said.contains("bowl.mtl"),
            "a material file that is not there is named: {said}"
        );
        assert_eq!(
            said.contains("without texture coordinates"),
            !single,
            "{said}"
        );
        let after = fs::read_to_string(desk.path("out.obj")).unwrap();
        for word in ["mtllib", "v", "vt", "vn", "f"] {
            let (old, new) = (lines(&before, word), lines(&after, word));
            assert_eq!(old, new[..old.len()], "{word}");
        }
        let own = if single {
            vec!["usemtl right"]
        } else {
            vec!["usemtl isomend_patch"]
        };
        let wanted = [
            vec!["usemtl left", "usemtl right"],
            own[usize::from(single)..].to_vec(),
        ];
        assert_eq!(lines(&after, "usemtl"), wanted.concat());
        assert_eq!(lines(&after, "g"), ["g left", "g right", "g isomend_patch"]);
        // A new material gets a file that describes it; an existing file stays unchanged.
        let library = desk.path("isomend_patch.mtl");
        let named = lines(&after, "mtllib").contains(&"mtllib isomend_patch.mtl");
        assert_eq!((named, library.exists()), (!single, !single));
        if !single {
            assert!(
                fs::read_to_string(&library)
                    .unwrap()
                    .contains("newmtl isomend_patch")
            );
            fs::write(&library, "mine").unwrap();
            desk.fill("in.obj", "out.obj");
            assert_eq!(fs::read_to_string(&library).unwrap(), "mine");
        }
        let loaded = desk.read("out.obj");
        let uv = &loaded
            .attributes
            .corner
            .iter()
            .find(|c| c.pool.role == Role::Uv(0))
            .unwrap();
        for f in mesh.faces.len()..loaded.mesh.faces.len() {
            for k in 0..3 {
                let p = loaded.mesh.positions[loaded.mesh.faces[f][k] as usize];
                match uv.get(f, k) {
                    Some(t) => assert!(single && (t[0] - 5.0 - p.x).abs() < 0.05, "{t:?} at {p}"),
                    None => assert!(!single),
                }
            }
        }
    }
}

/// The bowl as a glTF document: two nodes with transforms use one mesh, which has a texture in the buffer.
fn document(desk: &Desk, mesh: &Mesh) -> Value {
    save(desk, "plain.gltf", Format::Gltf, mesh, &dressed(mesh));
    let mut root: Value =
        serde_json::from_slice(&fs::read(desk.path("plain.gltf")).unwrap()).unwrap();
    root["nodes"] = json!([
        { "name": "root", "children": [1, 2], "extras": { "made": "by hand", "depth": 0.1 },
          "scale": [0.01, 0.01, 0.01] },
        { "name": "one", "mesh": 0, "rotation": [0.0, 0.6, 0.0, 0.8], "translation": [300.0, 0.5, 0.0] },
        { "name": "two", "mesh": 0, "scale": [-1.0, 2.0, 1.0] },
    ]);
    root["materials"] =
        json!([{ "name": "skin", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    root["textures"] = json!([{ "source": 0, "sampler": 0 }]);
    root["samplers"] = json!([{ "wrapS": 33071 }]);
    root["images"] =
        json!([{ "mimeType": "image/png", "bufferView": 0, "name": "bytes that no one decodes" }]);
    root["meshes"][0]["name"] = json!("bowl");
    root["meshes"][0]["primitives"][0]["material"] = json!(0);
    root
}

/// The JSON part and the binary part of a GLB file.
fn chunks(bytes: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let json = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
    (json, bytes[28 + word(12)..].to_vec())
}

#[test]
fn a_fill_keeps_the_document_of_a_gltf_file() {
    let desk = Desk::new();
    let mesh = bowl();
    let root = document(&desk, &mesh);
    fs::write(desk.path("in.gltf"), serde_json::to_vec(&root).unwrap()).unwrap();
    desk.fill("in.gltf", "out.glb");
    let (after, data) = chunks(&fs::read(desk.path("out.glb")).unwrap());
    for key in [
        "asset",
        "materials",
        "textures",
        "samplers",
        "images",
        "scenes",
        "scene",
    ] {
        assert_eq!(root[key], after[key], "{key}");
    }
    for key in ["bufferViews", "accessors", "meshes"] {
        let old = root[key].as_array().unwrap();
        assert_eq!(
            old[..],
            after[key].as_array().unwrap()[..old.len()],
            "{key}"
        );
    }
    let uri = root["buffers"][0]["uri"].as_str().unwrap();
    let model = read_bytes(
        &serde_json::to_vec(&root).unwrap(),
        Format::Gltf,
        &no_side_files,
    )
    .unwrap();
    assert!(uri.len() / 4 * 3 <= data.len());
    // Nodes keep all their properties and get one more child each.
    assert_eq!(after["nodes"][0], root["nodes"][0]);
    for (node, child) in [(1, 3), (2, 4)] {
        let mut bare = after["nodes"][node].clone();
        assert_eq!(
            bare.as_object_mut().unwrap().remove("children"),
            Some(json!([child]))
        );
        assert_eq!(bare, root["nodes"][node]);
        assert_eq!(after["nodes"][child]["name"], PATCH_NAME);
        let patch = &after["meshes"][after["nodes"][child]["mesh"].as_u64().unwrap() as usize];
        let primitive = &patch["primitives"][0];
        assert_eq!(primitive["material"], 0, "the rim lies in one chart");
        let names: Vec<&String> = primitive["attributes"]
            .as_object()
            .unwrap()
            .keys()
            .collect();
        assert_eq!(
            names,
            ["COLOR_0", "NORMAL", "POSITION", "TEXCOORD_0", "_SCAN"]
        );
        assert_rim_is_exact(&after, &data, primitive, &mesh);
    }
    // The scene is closed, and the patch marks are read back.
    let loaded = desk.read("out.glb");
    assert_eq!(
        shapes::topology(&isomend_core::mesh::welded(&loaded.mesh).0).0,
        0
    );
    let marked = (0..loaded.mesh.faces.len())
        .filter(|f| loaded.attributes.is_patch(*f))
        .count();
    assert_eq!(marked, loaded.mesh.faces.len() - model.mesh.faces.len());
}

/// In the node's coordinates, the patch's rim vertices have exactly the positions of the mesh's vertices.
fn assert_rim_is_exact(root: &Value, data: &[u8], primitive: &Value, mesh: &Mesh) {
    let accessor =
        &root["accessors"][primitive["attributes"]["POSITION"].as_u64().unwrap() as usize];
    let view = &root["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    let length = view["byteLength"].as_u64().unwrap() as usize;
    let numbers: Vec<f64> = data[start..start + length]
        .chunks_exact(4)
        .map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap())))
        .collect();
    let points: Vec<DVec3> = numbers.chunks_exact(3).map(DVec3::from_slice).collect();
    let exact = points.iter().filter(|p| mesh.positions.contains(p)).count();
    let near = |p: &DVec3| mesh.positions.iter().any(|q| q.distance(*p) < 1e-5);
    assert!(exact > 10, "{exact}");
    assert_eq!(exact, points.iter().filter(|p| near(p)).count());
    assert!(points.iter().all(|p| (p.length() - 1.0).abs() < 0.02));
}

#[test]
fn a_second_fill_keeps_the_first_ones_patches() {
    let desk = Desk::new();
    let mesh = cut(&bowl(), |p| polar(-p) < 25.0);
    save(&desk, "in.glb", Format::Glb, &mesh, &dressed(&mesh));
    let mut command = Command::cargo_bin("isomend").unwrap();
    command.current_dir(desk.0.path());
    let first = ["fill", "in.glb", "-o", "one.glb", "--holes", "1", "-q"];
    assert!(command.args(first).output().unwrap().status.success());
    desk.fill("one.glb", "two.glb");
    let (one, two) = (desk.read("one.glb"), desk.read("two.glb"));
    let marked = |l: &Loaded| {
        (0..l.mesh.faces.len())
            .filter(|f| l.attributes.is_patch(*f))
            .count()
    };
    assert_eq!(two.mesh.faces.len() - marked(&two), mesh.faces.len());
    assert!(marked(&two) > marked(&one) && marked(&one) > 0);
    assert_eq!(
        shapes::topology(&isomend_core::mesh::welded(&two.mesh).0).0,
        0
    );
}

#[test]
fn faces_removed_from_one_node_stay_in_other_nodes_with_the_same_mesh() {
    let desk = Desk::new();
    let mesh = bowl();
    let root = document(&desk, &mesh);
    let bytes = serde_json::to_vec(&root).unwrap();
    let loaded = read_bytes(&bytes, Format::Gltf, &no_side_files).unwrap();
    let m = mesh.faces.len();
    assert_eq!(loaded.mesh.faces.len(), 2 * m);
    // Removes a third of the second node's faces, then all of them, then none.
    let marks: [fn(usize, usize) -> bool; 3] =
        [|f, m| f < m || f % 3 > 0, |f, m| f < m, |_, _| true];
    for (round, mark) in marks.into_iter().enumerate() {
        let keep: Vec<bool> = (0..2 * m).map(|f| mark(f, m)).collect();
        let attributes = loaded.attributes.with_faces(&keep);
        let faces = (0..2 * m)
            .filter(|f| keep[*f])
            .map(|f| loaded.mesh.faces[f]);
        let cut = Mesh::new(loaded.mesh.positions.clone(), faces.collect());
        let model = Contents {
            mesh: &cut,
            attributes: &attributes,
            document: loaded.document.as_ref(),
        };
        let options = WriteOptions::default();
        let written = model_to_bytes(&model, Format::Glb, &options).unwrap();
        let (after, _) = chunks(&written.bytes);
        assert_eq!(
            after["meshes"][0], root["meshes"][0],
            "the first node's mesh stays"
        );
        let user = &after["nodes"][2]["mesh"];
        assert_eq!(*user, [json!(1), Value::Null, json!(0)][round]);
        let again = read_bytes(&written.bytes, Format::Glb, &no_side_files).unwrap();
        assert_eq!(again.mesh.faces, cut.faces);
        let n = again.mesh.positions.len();
        assert_eq!(again.mesh.positions, cut.positions[..n]);
    }
}

#[test]
fn attributes_without_a_name_are_kept_by_formats_that_need_one() {
    let vtp = r#"<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian"><PolyData>
        <Piece NumberOfPoints="3" NumberOfPolys="1">
        <PointData><DataArray type="Float64" Name="" format="ascii">1 2 3</DataArray></PointData>
        <Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0</DataArray></Points>
        <Polys><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2</DataArray>
        <DataArray type="Int32" Name="offsets" format="ascii">3</DataArray></Polys></Piece></PolyData></VTKFile>"#;
    let nothing = &no_side_files;
    let loaded = read_bytes(vtp.as_bytes(), Format::Vtp, nothing).unwrap();
    for format in [Format::Ply, Format::Vtk, Format::Vtp] {
        for ascii in [false, true] {
            let options = WriteOptions {
                ascii,
                ..WriteOptions::default()
            };
            let model = Contents {
                mesh: &loaded.mesh,
                attributes: &loaded.attributes,
                document: None,
            };
            let bytes = model_to_bytes(&model, format, &options).unwrap().bytes;
            let again = read_bytes(&bytes, format, nothing).unwrap();
            let values = &again.attributes.vertex;
            assert_eq!(values.len(), 1, "{format}");
            assert_eq!(
                values[0].get(2),
                loaded.attributes.vertex[0].get(2),
                "{format}"
            );
        }
    }
}
