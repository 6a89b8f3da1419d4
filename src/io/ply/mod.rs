//! Stanford PLY.

mod body;
mod header;

use std::io::Write;

use super::{Format, IoError, Loaded, Precision, WriteOptions, Written, rounded};
use crate::mesh::Mesh;

/// Reads a mesh from PLY, text or binary of either byte order.
pub(super) fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    let header = header::parse(bytes)?;
    body::read(bytes, &header)?.finish()
}

/// Writes the smallest header that holds positions and triangles.
pub(super) fn write(mesh: &Mesh, options: &WriteOptions) -> Result<Written, IoError> {
    if i32::try_from(mesh.positions.len()).is_err() {
        return Err(IoError::NotWritable {
            format: Format::Ply,
            what: format!(
                "{} vertices are more than its 32-bit indices can name",
                mesh.positions.len()
            ),
            advice: "split the mesh into smaller ones",
        });
    }
    let mut bytes = header_text(mesh, options).into_bytes();
    bytes.reserve(mesh.positions.len() * 24 + mesh.faces.len() * 13);
    let notes = match options.precision {
        Precision::F32 => {
            let (points, notes) = rounded(mesh, Format::Ply)?;
            write_points(&mut bytes, &points, options.ascii, f32::to_le_bytes);
            notes
        }
        Precision::F64 => {
            let points: Vec<[f64; 3]> = mesh.positions.iter().map(|p| p.to_array()).collect();
            write_points(&mut bytes, &points, options.ascii, f64::to_le_bytes);
            Vec::new()
        }
    };
    write_faces(&mut bytes, mesh, options.ascii);
    Ok(Written { bytes, notes })
}

fn header_text(mesh: &Mesh, options: &WriteOptions) -> String {
    let encoding = if options.ascii {
        "ascii"
    } else {
        "binary_little_endian"
    };
    let scalar = match options.precision {
        Precision::F32 => "float",
        Precision::F64 => "double",
    };
    format!(
        "ply\nformat {encoding} 1.0\nelement vertex {}\nproperty {scalar} x\nproperty {scalar} y\nproperty {scalar} z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.faces.len(),
    )
}

fn write_points<T: Copy + std::fmt::Display, const N: usize>(
    bytes: &mut Vec<u8>,
    points: &[[T; 3]],
    ascii: bool,
    encode: impl Fn(T) -> [u8; N],
) {
    for [x, y, z] in points {
        if ascii {
            // Writing to a vector does not fail.
            let _ = writeln!(bytes, "{x} {y} {z}");
        } else {
            for value in [*x, *y, *z] {
                bytes.extend_from_slice(&encode(value));
            }
        }
    }
}

fn write_faces(bytes: &mut Vec<u8>, mesh: &Mesh, ascii: bool) {
    for [a, b, c] in &mesh.faces {
        if ascii {
            let _ = writeln!(bytes, "3 {a} {b} {c}");
        } else {
            let mut row = [3u8; 13];
            row[1..5].copy_from_slice(&a.to_le_bytes());
            row[5..9].copy_from_slice(&b.to_le_bytes());
            row[9..].copy_from_slice(&c.to_le_bytes());
            bytes.extend_from_slice(&row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::*;
    use super::super::to_bytes;
    use super::*;

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
}
