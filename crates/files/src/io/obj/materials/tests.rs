//! Tests of materials from OBJ to glTF, and of material files that are missing, damaged or very large.

use super::*;
use crate::io::samples::read_alone;
use crate::io::{Contents, Format, Loaded, WriteOptions, model_to_bytes, read_bytes};

const PNG: &[u8] = b"\x89PNG\r\n\x1a\nmore";
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0.25\nvt 1 1\n";

/// A square of two materials, with the given material files. The second material has no texture coordinates.
fn square(libraries: &str, files: &[(&str, &[u8])]) -> Loaded {
    let text =
        format!("{libraries}{SQUARE}usemtl red wood\nf 1/1 2/2 3/3\nusemtl glass\nf 1 3 4\n");
    let resolve = |name: &str, most: u64| {
        let found = files.iter().find(|f| f.0 == name);
        let (_, bytes) = found.ok_or_else(|| crate::io::no_side_files(name, most).unwrap_err())?;
        Ok(bytes[..bytes.len().min(most as usize)].to_vec())
    };
    read_bytes(text.as_bytes(), Format::Obj, &resolve).unwrap()
}

fn gltf(loaded: &Loaded) -> serde_json::Value {
    let model = Contents {
        mesh: &loaded.mesh,
        attributes: &loaded.attributes,
        document: None,
    };
    let written = model_to_bytes(&model, Format::Gltf, &WriteOptions::default()).unwrap();
    assert!(read_alone(&written.bytes, Format::Gltf).is_ok());
    serde_json::from_slice(&written.bytes).unwrap()
}

#[test]
fn colours_textures_and_finish_reach_gltf() {
    let mtl = b"# made by hand\r\nnewmtl red wood\r\nKd 0.8 0.1 0\r\nNs 30\r\nmap_Kd -s 2 2 -clamp on tex\\my wood.png\r\n\
        newmtl glass\r\nKd 0.5 0.5 0.5\r\nTr 0.75\r\nPr 0.25\r\nPm 1\r\nnewmtl other\r\nKd 1 1 1\r\n";
    let loaded = square(
        "mtllib mats/a.mtl\n",
        &[("mats/a.mtl", mtl), ("mats/tex/my wood.png", PNG)],
    );
    assert_eq!(loaded.notes, [""; 0]);
    assert_eq!(loaded.attributes.materials.len(), 2);
    let json = gltf(&loaded);
    let [wood, glass, plain] = [0, 1, 2].map(|i| json["materials"][i].clone());
    let pbr = |m: &serde_json::Value| m["pbrMetallicRoughness"].clone();
    assert_eq!(wood["name"], "red wood");
    assert_eq!(
        pbr(&wood)["baseColorFactor"],
        serde_json::json!([0.8, 0.1, 0.0, 1.0])
    );
    // 2 / (30 + 2) is a quarter squared; the roughness is the root of the quarter.
    assert_eq!(pbr(&wood)["roughnessFactor"], 0.5);
    assert_eq!(
        (&pbr(&wood)["metallicFactor"], wood.get("alphaMode")),
        (&0.0.into(), None)
    );
    assert_eq!(json["images"][0]["uri"], "mats/tex/my%20wood.png");
    assert_eq!(pbr(&wood)["baseColorTexture"]["index"], 0);
    assert_eq!(
        pbr(&glass)["baseColorFactor"],
        serde_json::json!([0.5, 0.5, 0.5, 0.25])
    );
    assert_eq!(
        (
            &pbr(&glass)["roughnessFactor"],
            &pbr(&glass)["metallicFactor"]
        ),
        (&0.25.into(), &1.0.into())
    );
    assert_eq!(
        (&glass["alphaMode"], &plain),
        (&"BLEND".into(), &serde_json::Value::Null)
    );
    assert_eq!(json["meshes"][0]["primitives"][1]["material"], 1);
}

#[test]
fn a_texture_needs_coordinates_which_gltf_counts_from_the_top() {
    let mtl = b"newmtl red wood\nKd 0 0 0\nmap_Kd a.png\nnewmtl glass\nmap_Kd a.png\n";
    let loaded = square("mtllib a.mtl\n", &[("a.mtl", mtl), ("a.png", PNG)]);
    let json = gltf(&loaded);
    let primitives = &json["meshes"][0]["primitives"];
    let pbr = |i: u64| &json["materials"][i as usize]["pbrMetallicRoughness"];
    let of = |p: usize| pbr(primitives[p]["material"].as_u64().unwrap());
    assert_eq!(json["images"].as_array().unwrap().len(), 1);
    assert!(primitives[0]["attributes"]["TEXCOORD_0"].is_u64());
    assert_eq!(of(0)["baseColorTexture"]["index"], 0);
    assert_eq!(
        of(0)["baseColorFactor"][0],
        1.0,
        "black under a texture is not meant"
    );
    assert!(primitives[1]["attributes"].get("TEXCOORD_0").is_none());
    assert!(of(1).get("baseColorTexture").is_none());
    let bytes = serde_json::to_vec(&json).unwrap();
    let again = read_alone(&bytes, Format::Gltf).unwrap();
    let uv = again
        .attributes
        .vertex_role(isomend_core::mesh::attributes::Role::Uv(0))
        .unwrap();
    assert_eq!(uv.get(1), Some(&[1.0, 0.75][..]));
}

#[test]
fn missing_files_are_named_and_the_rest_read() {
    let mtl: &[u8] = b"newmtl red wood\nKd 1\nKd\nNs x\nd -halo 0.5\nKd nan 0 0\nKd 0.25 0.5 1 \xff\nmap_Kd ../up.png\nmap_Kd\nnewmtl\nKd 1 1 1";
    let loaded = square("mtllib none.mtl a.mtl\nmtllib a.mtl\n", &[("a.mtl", mtl)]);
    let material = &loaded.attributes.materials[0];
    assert_eq!(
        (material.colour, &material.texture),
        (Some([0.25, 0.5, 1.0]), &None)
    );
    let notes = loaded.notes.join("\n");
    for part in [
        "'none.mtl' is outside the file: its materials",
        "'a.mtl' that cannot be read: 7",
        "'../up.png'",
    ] {
        assert!(notes.contains(part), "{part} in {notes}");
    }
    let long = vec![b'#'; MOST_BYTES as usize + 1];
    let loaded = square("mtllib a.mtl\n", &[("a.mtl", &long)]);
    assert!(
        loaded.notes[0].contains("larger than 16 MB"),
        "{:?}",
        loaded.notes
    );
    let tga = ("a.tga", &b"TRUEVISION"[..]);
    let loaded = square(
        "mtllib a.mtl\n",
        &[("a.mtl", b"newmtl glass\nmap_Kd a.tga"), tga],
    );
    assert!(
        loaded.notes[0].contains("neither PNG nor JPEG"),
        "{:?}",
        loaded.notes
    );
    assert_eq!(loaded.attributes.materials[0].texture, None);
}

#[test]
fn many_files_materials_and_faults_stay_within_bounds() {
    let libraries: String = (0..2000).map(|i| format!("mtllib {i}.mtl\n")).collect();
    assert_eq!(square(&libraries, &[]).notes.len(), MOST_FILES);
    let names: Vec<String> = (0..70_000).map(|i| i.to_string()).collect();
    let mtl: String = names
        .iter()
        .map(|n| format!("newmtl {n}\nmap_Kd {n}.png\n"))
        .collect();
    let resolve = |name: &str, most: u64| match name {
        "a.mtl" => Ok(mtl.clone().into_bytes()),
        name => crate::io::no_side_files(name, most),
    };
    let mut notes = Vec::new();
    let found = read(&["a.mtl".to_owned()], &names, &resolve, &mut notes);
    assert_eq!(
        (found.len(), notes.len()),
        (MOST_MATERIALS, MOST_REMARKS + 1)
    );
}

#[test]
fn damage_is_survived() {
    let mtl = b"newmtl a\nKd 1 0 0.5\nNs 3e1\nd 0.5\nTr 0\nPr .5\nPm 1\nmap_Kd -s 1 2 a/b.png\n\xc3\xa9 x\nnewmtl b\nkd 1 1 1\n";
    let names = ["a", "b"].map(str::to_owned);
    let reads = |bytes: &[u8]| {
        let resolve = |_: &str, _: u64| Ok(bytes.to_vec());
        let found = read(&["a.mtl".to_owned()], &names, &resolve, &mut Vec::new());
        let mut numbers = found
            .iter()
            .flat_map(|m| m.colour.into_iter().flatten().chain(m.opacity));
        assert!(numbers.all(|v| (0.0..=1.0).contains(&v)));
        found.len()
    };
    assert_eq!(reads(mtl), 2);
    for at in 0..mtl.len() {
        reads(&mtl[..at]);
        for byte in *b"\n\r \0-/.\\e9\xa0\xff" {
            let mut damaged = mtl.to_vec();
            damaged[at] = byte;
            reads(&damaged);
        }
    }
}

#[test]
fn options_and_paths_of_textures_are_separated() {
    let cases = [
        ("a b.png", "a b.png"),
        ("-s 1 2 3 -o 0.5 a.png", "a.png"),
        ("-mm 0 1 -bm 2 -clamp on 1 a.png", "1 a.png"),
        ("-unknown a.png", "-unknown a.png"),
        ("-s", ""),
    ];
    for (statement, name) in cases {
        assert_eq!(without_options(statement), name);
    }
    assert_eq!(normalised("a/./b/../c.png"), Some("a/c.png".to_owned()));
    for bad in ["..", "a/../../b", "", "a/.."] {
        assert_eq!(normalised(bad), None);
    }
}
