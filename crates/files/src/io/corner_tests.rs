//! Corner attributes (texture seams, hard normals) are carried from every format that has them to every other.

use glam::DVec3;

use super::samples::read_alone;
use super::{Contents, Format, Loaded, Precision, WriteOptions, model_to_bytes};
use isomend_core::mesh::attributes::{Attribute, NONE, PATCH_NAME, Role, Scalar};

/// A roof of two squares with a texture seam along the ridge, and a vertex that no face uses.
const SEAMS: &str = "v 0 0 0\nv 1 0 1\nv 1 1 1\nv 0 1 0\nv 2 0 0\nv 2 1 0\nv 7 7 7\nvt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\n\
    vt 0.625 0\nvt 1 0\nvt 1 1\nvt 0.625 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\nf 2/5 5/6 6/7\nf 2/5 6/7 3/8\n";

/// The same text with different normals on both sides of the ridge.
fn with_normals(text: &str) -> String {
    let mut out = text.replace("\nf ", "\nvn -0.6 0 0.8\nvn 0.6 0 0.8\nf ");
    for line in text.lines().filter(|line| line.starts_with("f ")) {
        let normal = if line.contains("/1") || line.contains("2/2") {
            1
        } else {
            2
        };
        let words = line.split(' ').skip(1);
        let words: Vec<String> = words
            .map(|w| match w.contains('/') {
                true => format!("{w}/{normal}"),
                false => format!("{w}//{normal}"),
            })
            .collect();
        out = out.replace(line, &format!("f {}", words.join(" ")));
    }
    out
}

/// A file of each format that stores values per corner, or that splits vertices where their values differ.
fn samples() -> Vec<(String, Loaded)> {
    let only_normals = SEAMS.lines().filter(|line| !line.starts_with("vt"));
    let only_normals: Vec<String> = only_normals
        .map(|line| match line.strip_prefix("f ") {
            Some(rest) => {
                let words = rest.split(' ').map(|w| w.split('/').next().unwrap());
                format!("f {}", words.collect::<Vec<_>>().join(" "))
            }
            None => line.to_owned(),
        })
        .collect();
    let texts = [
        ("seams", SEAMS.to_owned()),
        ("seams and normals", with_normals(SEAMS)),
        ("normals", hard(&(only_normals.join("\n") + "\n"))),
        // Only some corners have a value.
        ("some", SEAMS.replace("f 2/5 6/7 3/8", "f 2 6/7 3")),
    ];
    let mut samples: Vec<(String, Loaded)> = texts
        .into_iter()
        .map(|(name, text)| {
            let loaded = read_alone(text.as_bytes(), Format::Obj).unwrap();
            assert!(loaded.notes.is_empty(), "{name}: {:?}", loaded.notes);
            (name.to_owned(), loaded)
        })
        .collect();
    for format in [Format::Ply, Format::Glb, Format::Gltf] {
        for i in 0..4 {
            let (name, loaded) = &samples[i];
            let bytes = write(loaded, format).0;
            let again = read_alone(&bytes, format).unwrap();
            samples.push((format!("{name} from {format}"), again));
        }
    }
    samples
}

/// Normals without texture coordinates: the first two faces have one normal, the others another.
fn hard(text: &str) -> String {
    let mut number = 0;
    let lines = text.lines().map(|line| match line.strip_prefix("f ") {
        Some(rest) => {
            number += 1;
            let normal = if number <= 2 { 1 } else { 2 };
            let words = rest.split(' ').map(|w| format!("{w}//{normal}"));
            format!("f {}\n", words.collect::<Vec<_>>().join(" "))
        }
        None => format!("{line}\n"),
    });
    let lines: String = lines.collect();
    lines.replacen("\nf ", "\nvn -0.6 0 0.8\nvn 0.6 0 0.8\nf ", 1)
}

fn write(loaded: &Loaded, format: Format) -> (Vec<u8>, Vec<String>) {
    let model = Contents {
        mesh: &loaded.mesh,
        attributes: &loaded.attributes,
        document: loaded.document.as_ref(),
    };
    let options = WriteOptions {
        precision: Precision::F32,
        ascii: false,
    };
    let written = model_to_bytes(&model, format, &options).unwrap();
    (written.bytes, written.notes)
}

/// The position of each face corner and its value of a role, in single precision.
fn corners(loaded: &Loaded, role: Role) -> Vec<(DVec3, Option<Vec<f32>>)> {
    let all = &loaded.attributes;
    let floats =
        |a: &Attribute, value: &[f64]| value.iter().map(|v| (v / a.unit()) as f32).collect();
    let mut out = Vec::new();
    for (f, face) in loaded.mesh.faces.iter().enumerate() {
        for (k, vertex) in face.iter().enumerate() {
            let corner = all.corner.iter().find(|c| c.pool.role == role);
            let value = match (corner, all.vertex_role(role)) {
                (Some(c), _) => c.get(f, k).map(|v| floats(&c.pool, v)),
                (None, Some(a)) => a.get(*vertex as usize).map(|v| floats(a, v)),
                (None, None) => None,
            };
            out.push((loaded.mesh.positions[*vertex as usize], value));
        }
    }
    out
}

fn differ(loaded: &Loaded, role: Role) -> bool {
    let corner = loaded
        .attributes
        .corner
        .iter()
        .find(|c| c.pool.role == role);
    corner.is_some_and(|c| c.per_vertex(&loaded.mesh).is_none())
}

#[test]
fn seams_and_hard_normals_go_to_every_format_or_are_said_to_be_left_out() {
    for (name, loaded) in samples() {
        for format in Format::ALL {
            let (bytes, notes) = write(&loaded, format);
            let again = read_alone(&bytes, format).unwrap();
            assert_eq!(again.mesh.faces.len(), 4, "{name} to {format}");
            let notes = notes.join("\n");
            for (role, word) in [
                (Role::Uv(0), "texture coordinates"),
                (Role::Normal, "normals"),
            ] {
                let (mut before, after) = (corners(&loaded, role), corners(&again, role));
                let splits = matches!(format, Format::Gltf | Format::Glb);
                let is_of_gltf = loaded.document.as_ref().is_some_and(|d| d.gltf().is_some());
                if splits != is_of_gltf && role == Role::Uv(0) {
                    // glTF counts the second coordinate from the top of the image.
                    let values = before.iter_mut().filter_map(|(_, value)| value.as_mut());
                    values.for_each(|value| value[1] = 1.0 - value[1]);
                }
                if before == after {
                    continue;
                }
                let places = |list: &[(DVec3, Option<Vec<f32>>)]| -> Vec<DVec3> {
                    list.iter().map(|(p, _)| *p).collect()
                };
                assert_eq!(places(&before), places(&after), "{name} to {format}");
                // In glTF all vertices of a primitive have a value or none has. VTK fills gaps with zeros.
                let gaps = before.iter().any(|(_, v)| v.is_none());
                if gaps && (splits || !differ(&loaded, role)) {
                    continue;
                }
                // All corners of a PLY face have a value or none has.
                if format == Format::Ply && !notes.contains(word) {
                    let faces = before.chunks(3).zip(after.chunks(3));
                    let mut whole = faces.filter(|(b, _)| b.iter().all(|(_, v)| v.is_some()));
                    assert!(gaps && whole.all(|(b, a)| a == b), "{name}: {word}");
                    continue;
                }
                assert!(
                    notes.contains(word),
                    "{name} to {format}: {word}: '{notes}'\n{before:?}\n{after:?}"
                );
                assert!(!splits, "{name} to {format}: {word}");
            }
        }
    }
}

#[test]
fn corners_of_a_patch_in_obj_all_have_a_value_or_none() {
    let loaded = read_alone(SEAMS.as_bytes(), Format::Obj).unwrap();
    let mut attributes = loaded.attributes.clone();
    let mut marks = Attribute::new(PATCH_NAME, Role::Other, Scalar::U8, 1);
    (0..4).for_each(|f| marks.push(Some(&[f64::from(u8::from(f == 3))])));
    attributes.face.push(marks);
    // Without a value at one corner of a face of the input and of a patch.
    for f in [2, 3] {
        attributes.corner[0].corners[f][1] = NONE;
    }
    let model = Contents {
        mesh: &loaded.mesh,
        attributes: &attributes,
        document: None,
    };
    let written = model_to_bytes(&model, Format::Obj, &WriteOptions::default()).unwrap();
    let text = String::from_utf8(written.bytes).unwrap();
    let faces: Vec<&str> = text.lines().filter(|line| line.starts_with("f ")).collect();
    assert_eq!(faces[2..], ["f 2/5 5 6/7", "f 2 6 3"]);
}
