//! Reads and writes Stanford PLY.

mod body;
mod columns;
mod header;
mod write;

use super::mesh_builder::CutFrom;
use super::{IoError, Loaded};
use isomend_core::mesh::Attributes;

pub(super) use write::write;

/// The number that all texture coordinates of a face without them have: zero for other programs, and by its sign another than a zero of a file.
const NO_UV: f64 = -0.0;

/// Reads a mesh from PLY: text or binary, in either byte order.
pub(super) fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    let header = header::parse(bytes)?;
    let body = body::read(bytes, &header)?;
    let triangles_of_strips = header.elements.iter().any(|e| e.name == b"tristrips");
    let with_faces = !body.face.is_empty() && !triangles_of_strips;
    let mut cut = with_faces.then(|| CutFrom::identity(0));
    let mut loaded = body.surface.finish_with(&mut cut)?;
    let mut attributes = Attributes {
        vertex: body.vertex,
        textures: header.textures,
        ..Attributes::default()
    };
    if let Some(cut) = cut {
        let (face, uv) = body.face.cut(&cut);
        attributes.face = face;
        attributes.corner.extend(uv);
    }
    loaded.attributes = attributes;
    Ok(loaded)
}

#[cfg(test)]
mod tests {
    use super::super::samples::*;
    use super::super::{Contents, Format, Precision, WriteOptions, model_to_bytes, to_bytes};
    use super::*;
    use isomend_core::mesh::attributes::{Attribute, CornerAttribute, NONE, Role, Scalar};

    const HEADER: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                          element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    const POINTS: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];

    fn ascii(body: &str) -> Vec<u8> {
        format!("ply\nformat ascii 1.0\n{HEADER}0 0 0 1 0 0\n1 1 0 0 1 0\n{body}").into_bytes()
    }

    #[test]
    fn round_trip_is_exact() {
        for ascii in [false, true] {
            assert_round_trip(
                &open_tetrahedron(),
                Format::Ply,
                WriteOptions {
                    ascii,
                    precision: Precision::F32,
                },
            );
            assert_round_trip(
                &fine_tetrahedron(),
                Format::Ply,
                WriteOptions {
                    ascii,
                    precision: Precision::F64,
                },
            );
        }
    }

    #[test]
    fn numbers_that_the_header_does_not_declare_are_passed_over() {
        let header = HEADER.replace("face 1", "face 2");
        let points = "0 0 0\n1 0 0\n1 1 0 7\n0 1 0\n";
        for faces in [
            "3 0 1 2 255 0 0\n3 0 2 3 255 0 0\n",
            "3 0 1 2 3\n\n3 0 2 3 3",
        ] {
            for end in ["\n", "\r"] {
                let text =
                    format!("ply\nformat ascii 1.0\n{header}{points}{faces}").replace('\n', end);
                let loaded = read(text.as_bytes()).unwrap();
                assert_eq!(loaded.mesh.faces, [[0, 1, 2], [0, 2, 3]]);
                assert!(
                    loaded.notes[0].ends_with("not read: 3"),
                    "{:?}",
                    loaded.notes
                );
            }
        }
        // A line of too few numbers is no line of more.
        let text = format!("ply\nformat ascii 1.0\n{header}{points}3 0 1\n3 0 2 3\n");
        assert!(refusal(text.as_bytes(), Format::Ply).contains("0 corners"));
    }

    #[test]
    fn every_face_has_six_texture_coordinates() {
        let mesh = open_tetrahedron();
        let mut pool = Attribute::new("texcoord", Role::Uv(0), Scalar::F32, 2);
        pool.push(Some(&[0.25, 0.5]));
        pool.push(Some(&[0.0, 0.0]));
        let corners = vec![[0, 1, 0], [0, NONE, 1], [1; 3]];
        let mut attributes = Attributes::default();
        attributes.corner.push(CornerAttribute { pool, corners });
        let model = Contents {
            mesh: &mesh,
            attributes: &attributes,
            document: None,
        };
        for ascii in [false, true] {
            let options = WriteOptions {
                ascii,
                precision: Precision::F32,
            };
            let bytes = model_to_bytes(&model, Format::Ply, &options).unwrap().bytes;
            if ascii {
                let text = String::from_utf8(bytes.clone()).unwrap();
                let faces = text.lines().skip_while(|line| !line.starts_with("3 "));
                assert!(
                    faces.clone().all(|line| line.split(' ').count() == 11),
                    "{text}"
                );
                assert!(text.contains(" 6 -0 -0 -0 -0 -0 -0\n"), "{text}");
            } else {
                assert!(bytes.ends_with(&[0; 24]) && bytes[bytes.len() - 25] == 6);
            }
            let corner = &read(&bytes).unwrap().attributes.corner[0];
            let uv = [0, 1, 2].map(|f| [0, 1, 2].map(|k| corner.get(f, k).map(<[f64]>::to_vec)));
            let [a, zero] = [Some(vec![0.25, 0.5]), Some(vec![0.0, 0.0])];
            assert_eq!(uv[0], [a.clone(), zero.clone(), a]);
            assert_eq!(uv[1], [None, None, None]);
            assert_eq!(uv[2], [zero.clone(), zero.clone(), zero]);
        }
    }

    #[test]
    fn the_binary_header_is_minimal() {
        let bytes = to_bytes(&open_tetrahedron(), Format::Ply, &WriteOptions::default())
            .unwrap()
            .bytes;
        let expected = "ply\nformat binary_little_endian 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
                        property float z\nelement face 3\nproperty list uchar int vertex_indices\nend_header\n";
        assert!(bytes.starts_with(expected.as_bytes()));
        assert_eq!(bytes.len(), expected.len() + 5 * 12 + 3 * 13);
    }

    #[test]
    fn both_byte_orders_and_line_ends_are_read() {
        for (name, order) in [
            ("little", f32::to_le_bytes as fn(f32) -> [u8; 4]),
            ("big", f32::to_be_bytes),
        ] {
            for end in ["\n", "\r\n", "\r"] {
                let header = format!("ply\nformat binary_{name}_endian 1.0\ncomment c\n{HEADER}")
                    .replace('\n', end);
                let mut bytes = header.into_bytes();
                bytes.extend(POINTS.iter().flat_map(|v| order(*v)));
                bytes.push(4);
                let index = |i: u32| {
                    if name == "big" {
                        i.to_be_bytes()
                    } else {
                        i.to_le_bytes()
                    }
                };
                bytes.extend((0..4).flat_map(index));
                let loaded = read(&bytes).unwrap();
                assert_eq!(loaded.mesh.faces, [[0, 1, 2], [0, 2, 3]]);
                assert_eq!(loaded.mesh.positions[2].to_array(), [1.0, 1.0, 0.0]);
            }
        }
    }

    #[test]
    fn other_elements_and_properties_are_passed_over() {
        let text = "ply\nformat ascii 1.0\nobj_info x\nelement camera 1\nproperty float f\nproperty list uchar float l\n\
                    element vertex 3\nproperty list uchar int l\nproperty uchar red\nproperty double z\nproperty float y\n\
                    property float x\nelement empty 4000000000\nelement face 1\nproperty list uchar float uv\n\
                    property int flag\nproperty list uint8 uint32 vertex_index\nelement tail 1\nproperty int i\nend_header\n\
                    0.5 2 1 2\n0 255 0.1 0 0\n2 7 7 255 0 0 1\n1 7 255 0 1 0\n2 .5 .5 9 3 0 1 2\n7\n";
        let loaded = read(text.as_bytes()).unwrap();
        assert_eq!(loaded.mesh.faces, [[0, 1, 2]]);
        assert_eq!(loaded.mesh.positions[0].to_array(), [0.0, 0.0, 0.1]);
        assert!(!loaded.f32_exact);
    }

    #[test]
    fn strips_are_read() {
        let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                    element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                    0 0 0 1 0 0 0 1 0 1 1 0 8 0 1 2 3 -1 0 1 3\n";
        assert_eq!(
            read(text.as_bytes()).unwrap().mesh.faces,
            [[0, 1, 2], [2, 1, 3], [0, 1, 3]]
        );
    }

    #[test]
    fn text_floats_have_the_declared_precision() {
        let loaded = read(&ascii("3 0 1 2").replace_first(b"0 0 0 1", b"0.1 0 0 1")).unwrap();
        assert_eq!(loaded.mesh.positions[0].x, f64::from(0.1f32));
        assert!(loaded.f32_exact);
    }

    trait ReplaceFirst {
        fn replace_first(&self, from: &[u8], to: &[u8]) -> Vec<u8>;
    }

    impl ReplaceFirst for Vec<u8> {
        fn replace_first(&self, from: &[u8], to: &[u8]) -> Vec<u8> {
            let at = memchr::memmem::find(self, from).unwrap();
            [&self[..at], to, &self[at + from.len()..]].concat()
        }
    }

    #[test]
    fn faults_are_named() {
        let cases: [(Vec<u8>, &str); 12] = [
            (ascii("3 0 1 -1"), "face 0: it uses vertex -1"),
            (ascii("3 0 1 4"), "face 0: it uses vertex 4"),
            (ascii("3 0 1 1.5"), "face 0: it uses vertex 1.5"),
            (ascii("2 0 1"), "2 corners"),
            (ascii(""), "ends inside face 0"),
            (ascii("255 0 1"), "list of 255"),
            (ascii("3 0 1 x"), "line 12: 'x' is not a number"),
            (
                ascii("3 0 1 2").replace_first(b"1 1 0", b"1 nan 0"),
                "vertex 2",
            ),
            (
                ascii("").replace_first(b"element face 1", b"element face 0"),
                "no faces",
            ),
            (
                ascii("3 0 1 2").replace_first(b"property float z", b"property float w"),
                "no z",
            ),
            (
                ascii("3 0 1 2").replace_first(b"ascii", b"asciy"),
                "line 2: format 'asciy'",
            ),
            (
                b"ply\nformat ascii 1.0\nelement vertex 3\n".to_vec(),
                "end_header",
            ),
        ];
        for (bytes, expected) in cases {
            let message = refusal(&bytes, Format::Ply);
            assert!(message.contains(expected), "{message}");
        }
        assert!(refusal(b"solid", Format::Ply).contains("does not begin"));
    }

    #[test]
    fn claimed_counts_do_not_allocate() {
        let bytes = to_bytes(&open_tetrahedron(), Format::Ply, &WriteOptions::default())
            .unwrap()
            .bytes;
        for count in [
            "4000000000",
            "18446744073709551615",
            "99999999999999999999999",
        ] {
            for element in ["vertex 5", "face 3"] {
                let (name, _) = element.split_once(' ').unwrap();
                let to = format!("{name} {count}");
                refusal(
                    &bytes.replace_first(element.as_bytes(), to.as_bytes()),
                    Format::Ply,
                );
            }
        }
    }

    #[test]
    fn damage_is_survived() {
        assert_damage_is_survived(Format::Ply);
    }

    const DRESSED: &str = "ply\nformat ascii 1.0\ncomment TextureFile skin of a cat.png\nelement vertex 4\n\
        property float x\nproperty uchar red\nproperty float y\nproperty float z\nproperty uchar green\n\
        property uchar blue\nproperty double quality\nproperty float nx\nproperty float ny\nproperty float nz\n\
        property float s1\nproperty float t1\nproperty short scan\nelement face 2\n\
        property int id\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n\
        property uchar red\nend_header\n\
        0 10 0 0 20 30 0.1 0 0 1 0.5 0.25 -7\n1 11 0 0 21 31 0.2 0 0 1 0 0 8\n1 12 1 0 22 32 0.3 0 0 1 1 0 9\n\
        0 13 1 0 23 33 0.4 0 0 1 1 1 10\n7 4 0 1 2 3 8 0 0 1 0 1 1 0 1 255\n-9 3 0 2 3 0 4\n";

    #[test]
    fn properties_are_grouped_by_what_they_mean() {
        let loaded = read(DRESSED.as_bytes()).unwrap();
        let all = &loaded.attributes;
        let found: Vec<(&str, Role, Scalar, usize)> = all
            .vertex
            .iter()
            .map(|a| (&a.name[..], a.role, a.scalar, a.components))
            .collect();
        assert_eq!(
            found,
            [
                ("colour", Role::Colour, Scalar::U8, 3),
                ("quality", Role::Other, Scalar::F64, 1),
                ("normal", Role::Normal, Scalar::F32, 3),
                ("texture", Role::Uv(1), Scalar::F32, 2),
                ("scan", Role::Other, Scalar::I16, 1),
            ]
        );
        assert_eq!(all.vertex[0].get(2), Some(&[12.0, 22.0, 32.0][..]));
        assert_eq!(all.vertex[1].get(3), Some(&[0.4][..]));
        assert_eq!(all.vertex[4].get(0), Some(&[-7.0][..]));
        assert_eq!(all.textures, ["skin of a cat.png"]);
        // The quad became two triangles.
        assert_eq!(all.face[0].values, [7.0, 7.0, -9.0]);
        assert_eq!(all.face[1].role, Role::Other, "red alone is no colour");
        assert_eq!(all.corner[0].get(1, 2), Some(&[0.0, 1.0][..]));
        assert_eq!(all.corner[0].get(2, 0), None);
    }

    #[test]
    fn attributes_come_back_as_they_were() {
        let loaded = read(DRESSED.as_bytes()).unwrap();
        let model = Contents {
            mesh: &loaded.mesh,
            attributes: &loaded.attributes,
            document: None,
        };
        for ascii in [false, true] {
            let options = WriteOptions {
                ascii,
                precision: Precision::F32,
            };
            let written = model_to_bytes(&model, Format::Ply, &options).unwrap();
            assert!(written.notes.is_empty(), "{:?}", written.notes);
            let again = read(&written.bytes).unwrap();
            assert_eq!(again.mesh, loaded.mesh);
            let (a, b) = (&again.attributes, &loaded.attributes);
            assert_eq!((&a.vertex, &a.face), (&b.vertex, &b.face));
            for (f, k) in (0..3).flat_map(|f| [(f, 0), (f, 1), (f, 2)]) {
                assert_eq!(a.corner[0].get(f, k), b.corner[0].get(f, k));
            }
        }
        assert_survives_damage(DRESSED.as_bytes(), Format::Ply);
    }

    #[test]
    fn attributes_of_other_formats_get_the_usual_names() {
        let mesh = open_tetrahedron();
        let mut colour = Attribute::new("COLOR_0", Role::Colour, Scalar::F32, 4);
        let mut uv = Attribute::new("TEXCOORD_1", Role::Uv(1), Scalar::U16, 2);
        uv.normalized = true;
        for _ in &mesh.positions {
            colour.push(Some(&[1.0, 0.5, 0.0, 1.0]));
            uv.push(Some(&[65535.0, 0.0]));
        }
        let attributes = Attributes {
            vertex: vec![colour, uv],
            ..Attributes::default()
        };
        let model = Contents {
            mesh: &mesh,
            attributes: &attributes,
            document: None,
        };
        let written = model_to_bytes(&model, Format::Ply, &WriteOptions::default()).unwrap();
        let read = read(&written.bytes).unwrap().attributes.vertex;
        assert_eq!(read[0].fields, ["red", "green", "blue", "alpha"]);
        assert_eq!(read[0].get(0), Some(&[255.0, 128.0, 0.0, 255.0][..]));
        assert_eq!(read[1].role, Role::Uv(1));
        assert_eq!(read[1].get(4), Some(&[1.0, 0.0][..]));
    }

    #[test]
    fn many_properties_are_sorted_in_time() {
        let start = std::time::Instant::now();
        let sets: String = (2..40_000)
            .map(|i| format!("property uchar s{i}\n"))
            .collect();
        let same = "property uchar s\n".repeat(20_000);
        let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
        let tail = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
        let values = "1 ".repeat(39_998 + 20_000);
        let rows: String = ["0 0 0", "1 0 0", "0 1 0"]
            .iter()
            .map(|point| format!("{point} {values}\n"))
            .collect();
        let text = format!("{head}{sets}{same}{tail}{rows}3 0 1 2\n");
        let loaded = read(text.as_bytes()).unwrap();
        assert_eq!(loaded.attributes.vertex.len(), 39_998 + 20_000);
        let model = Contents {
            mesh: &loaded.mesh,
            attributes: &loaded.attributes,
            document: None,
        };
        let written = model_to_bytes(&model, Format::Ply, &WriteOptions::default()).unwrap();
        assert!(written.bytes.len() < 2 * text.len());
        assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
    }
}
