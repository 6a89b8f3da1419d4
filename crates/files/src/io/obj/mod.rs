//! Reads and writes Wavefront OBJ.
//!
//! Vertices, normals and texture coordinates keep the order of their lines. Line, point and curve elements are skipped.

mod extras;
mod materials;
mod write;

use std::borrow::Cow;

use glam::DVec3;

use super::mesh_builder::{MeshBuilder, not_finite};
use super::{Format, IoError, Loaded, Location, Resolve, text};
use extras::Extras;
use isomend_core::mesh::attributes::LabelKind;

pub(super) use write::write;

/// Reads a mesh from OBJ text in UTF-8 or UTF-16, with the materials from the material files that it names.
pub(super) fn read(bytes: &[u8], resolve: &Resolve<'_>) -> Result<Loaded, IoError> {
    let decoded = text::decode(bytes);
    let mut reader = Reader {
        surface: MeshBuilder::new(Format::Obj),
        corners: Vec::new(),
        forward: None,
        extras: Extras::default(),
    };
    let mut lines = Lines::new(&decoded);
    while let Some((line, content)) = lines.next_line() {
        reader.statement(line, &content)?;
    }
    let mut loaded = reader.finish()?;
    let attributes = &mut loaded.attributes;
    if let Some(labels) = attributes.labels_of(LabelKind::Material) {
        let libraries = &attributes.libraries;
        attributes.materials =
            materials::read(libraries, &labels.names, resolve, &mut loaded.notes);
    }
    Ok(loaded)
}

/// Whether text begins like an OBJ file: only comments and OBJ statements up to the first vertex.
pub(super) fn looks_like_obj(bytes: &[u8]) -> bool {
    const KNOWN: [&[u8]; 8] = [b"mtllib", b"usemtl", b"o", b"g", b"s", b"vn", b"vt", b"f"];
    let start = text::decode(&bytes[..bytes.len().min(4096)]).into_owned();
    for line in start.split(|b| *b == b'\n').take(100) {
        match line.trim_ascii().split(u8::is_ascii_whitespace).next() {
            None | Some(b"") => {}
            Some(b"v") => return true,
            Some(word) if word.starts_with(b"#") || KNOWN.contains(&word) => {}
            Some(_) => return false,
        }
    }
    false
}

/// Iterates over lines, joined at trailing backslashes, with the number of their first line.
struct Lines<'a> {
    rest: &'a [u8],
    line: usize,
    end: u8,
}

impl<'a> Lines<'a> {
    fn new(text: &'a [u8]) -> Self {
        let end = if memchr::memchr(b'\n', text).is_some() {
            b'\n'
        } else {
            b'\r'
        };
        Self {
            rest: text,
            line: 0,
            end,
        }
    }

    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let length = memchr::memchr(self.end, self.rest).unwrap_or(self.rest.len());
        let line = &self.rest[..length];
        self.rest = self.rest.get(length + 1..).unwrap_or(&[]);
        self.line += 1;
        Some(line.trim_ascii())
    }

    fn next_line(&mut self) -> Option<(usize, Cow<'a, [u8]>)> {
        let first = self.physical()?;
        let number = self.line;
        let Some(start) = first.strip_suffix(b"\\") else {
            return Some((number, Cow::Borrowed(first)));
        };
        let mut joined = start.to_vec();
        while let Some(line) = self.physical() {
            joined.push(b' ');
            match line.strip_suffix(b"\\") {
                Some(more) => joined.extend_from_slice(more),
                None => {
                    joined.extend_from_slice(line);
                    break;
                }
            }
        }
        Some((number, Cow::Owned(joined)))
    }
}

struct Reader {
    surface: MeshBuilder,
    corners: Vec<u32>,
    /// The largest vertex index that was used before its vertex was read, and its line.
    forward: Option<(u32, usize)>,
    extras: Extras,
}

impl Reader {
    fn statement(&mut self, line: usize, content: &[u8]) -> Result<(), IoError> {
        match content {
            [b'v', blank, rest @ ..] if blank.is_ascii_whitespace() => self.vertex(line, rest),
            [b'f', blank, rest @ ..] if blank.is_ascii_whitespace() => self.face(line, rest),
            b"f" => self.face(line, b""),
            b"v" => self.vertex(line, b""),
            [b'l' | b'p', blank, ..] if blank.is_ascii_whitespace() => {
                self.surface.skipped += 1;
                Ok(())
            }
            _ => {
                self.extras.statement(content);
                Ok(())
            }
        }
    }

    fn vertex(&mut self, line: usize, rest: &[u8]) -> Result<(), IoError> {
        let mut tokens = text::Tokens::new(rest, 0);
        let mut point = [0.0; 3];
        for (coordinate, axis) in point.iter_mut().zip(["x", "y", "z"]) {
            let token = tokens
                .next()
                .ok_or_else(|| fault(line, format!("the vertex has no {axis} coordinate")))?;
            *coordinate = text::number(token).ok_or_else(|| {
                fault(
                    line,
                    format!(
                        "{} is not a number ({axis} of a vertex)",
                        text::shown(token)
                    ),
                )
            })?;
        }
        let point = DVec3::from_array(point);
        if !point.is_finite() {
            return Err(not_finite(Format::Obj, Location::Line(line), point));
        }
        self.surface.positions.push(point);
        if tokens.left() > 0 {
            self.extras.colour(self.surface.positions.len(), tokens);
        }
        Ok(())
    }

    fn face(&mut self, line: usize, rest: &[u8]) -> Result<(), IoError> {
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        for token in text::Tokens::new(rest, 0) {
            if token.starts_with(b"#") {
                break;
            }
            let place = corners.len();
            corners.push(self.corner(line, token, place)?);
        }
        match corners.len() {
            0 => {
                let what = "a face of 0 corners, where at least 3 are needed".to_owned();
                return Err(fault(line, what));
            }
            1 | 2 => {
                self.surface.omitted.push(line);
                self.extras.face_left_out();
            }
            _ => {
                self.surface.push_face(&corners)?;
                self.extras.face_done(corners.len());
            }
        }
        self.corners = corners;
        Ok(())
    }

    fn corner(&mut self, line: usize, token: &[u8], place: usize) -> Result<u32, IoError> {
        let digits = match token.iter().position(|b| *b == b'/') {
            Some(slash) => {
                self.extras.corner(place, &token[slash + 1..]);
                &token[..slash]
            }
            None => token,
        };
        let count = self.surface.positions.len();
        let Some(index) = text::integer(digits) else {
            return Err(fault(
                line,
                format!("{} is not a vertex index", text::shown(token)),
            ));
        };
        if index == 0 {
            return Err(fault(
                line,
                "vertex index 0, but OBJ counts from 1".to_string(),
            ));
        }
        if index < 0 {
            let back = usize::try_from(index.unsigned_abs())
                .ok()
                .and_then(|back| count.checked_sub(back));
            let found = back.and_then(|index| u32::try_from(index).ok());
            return found.ok_or_else(|| {
                fault(
                    line,
                    format!("index {index} counts back beyond the first of {count} vertices"),
                )
            });
        }
        let Ok(found) = u32::try_from(index - 1) else {
            return Err(fault(line, format!("vertex index {index} is too large")));
        };
        if found as usize >= count && self.forward.is_none_or(|(largest, _)| largest < found) {
            self.forward = Some((found, line));
        }
        Ok(found)
    }

    fn finish(self) -> Result<Loaded, IoError> {
        let count = self.surface.positions.len();
        match self.forward {
            Some((index, line)) if index as usize >= count => Err(fault(
                line,
                format!(
                    "a face uses vertex {}, but the file has only {count}",
                    u64::from(index) + 1
                ),
            )),
            _ => self.extras.finish(self.surface),
        }
    }
}

fn fault(line: usize, what: String) -> IoError {
    IoError::malformed(Format::Obj, Location::Line(line), what)
}

#[cfg(test)]
mod tests {
    use super::super::samples::*;
    use super::super::{Contents, WriteOptions, to_bytes};
    use super::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    fn faces(text: &str) -> Vec<[u32; 3]> {
        read(text.as_bytes()).unwrap().mesh.faces
    }

    fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
        super::read(bytes, &crate::io::no_side_files)
    }

    #[test]
    fn round_trip_is_exact() {
        assert_round_trip(&open_tetrahedron(), Format::Obj, WriteOptions::default());
        assert_round_trip(&fine_tetrahedron(), Format::Obj, WriteOptions::default());
    }

    #[test]
    fn statements_in_all_their_forms() {
        assert_eq!(faces(&format!("{SQUARE}f -4 -3/1 -2//2")), [[0, 1, 2]]);
        assert_eq!(faces(&format!("f 1 2 3 # forward\n{SQUARE}")), [[0, 1, 2]]);
        assert_eq!(
            faces(&format!("{SQUARE}f 1/1/1 2/2/2 \\\r\n 3/3/3 \\\n4\n")),
            [[0, 1, 2], [0, 2, 3]]
        );
        assert_eq!(
            faces(&SQUARE.replace('\n', "\r").replace("v 0 1 0\r", "f 1 2 3\r")),
            [[0, 1, 2]]
        );
        assert_eq!(
            faces("v 0 0 0 1\nv\t1 0 0 0.5 0.5 0.5\nv 0 1 0 1 1 1 1\nvn 0 0 x\nl 1 2\nf  1 2  3"),
            [[0, 1, 2]]
        );
    }

    #[test]
    fn unused_and_repeated_vertices_stay() {
        let loaded = read(b"v 5 5 5\nv 0 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 4 5\n").unwrap();
        assert_eq!(loaded.mesh.positions.len(), 5);
        assert_eq!(loaded.mesh.faces, [[1, 3, 4]]);
    }

    #[test]
    fn utf16_is_decoded() {
        let units = format!("{SQUARE}f 1 2 3\n")
            .encode_utf16()
            .flat_map(u16::to_be_bytes)
            .collect::<Vec<_>>();
        assert_eq!(
            read(&[&[0xfe, 0xff][..], &units].concat())
                .unwrap()
                .mesh
                .faces,
            [[0, 1, 2]]
        );
    }

    #[test]
    fn faces_of_two_corners_are_left_out() {
        for (format, text, line) in [
            (
                Format::Obj,
                format!("{SQUARE}vt 1 0\nf 1/1 2/1\nf 3\nf 1 2 3"),
                SQUARE.lines().count() + 2,
            ),
            (
                Format::Off,
                "OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n1 0\n3 0 1 2".to_owned(),
                6,
            ),
        ] {
            let loaded = read_alone(text.as_bytes(), format).unwrap();
            assert_eq!(loaded.mesh.faces, [[0, 1, 2]]);
            // Nor do their texture coordinates stay.
            let corners = loaded.attributes.corner.iter().flat_map(|a| &a.corners);
            assert!(
                corners
                    .flatten()
                    .all(|place| *place == isomend_core::mesh::attributes::NONE)
            );
            let note =
                format!("faces of one or two corners, left out: 2, the first in line {line}");
            assert!(loaded.notes.contains(&note), "{:?}", loaded.notes);
        }
        let only_edges = read_alone(b"v 0 0 0\nv 1 0 0\nf 1 2", Format::Obj);
        let error = only_edges.unwrap_err().to_string();
        assert!(error.contains("only 1 of one or two"), "{error}");
    }

    #[test]
    fn faults_are_named_with_their_line() {
        let cases = [
            ("f 1 2 5", "line 5: a face uses vertex 5"),
            ("f 1 2 0", "line 5: vertex index 0"),
            ("f 1 2 -5", "line 5: index -5"),
            ("f", "line 5: a face of 0 corners"),
            ("f 1 2 x", "line 5: 'x' is not a vertex index"),
            ("f 1 2 99999999999999999999", "line 5"),
            ("f 1 2 9999999999", "line 5"),
            ("v 1 2", "line 5: the vertex has no z"),
            ("v 1 2 z", "line 5: 'z' is not a number"),
            ("v nan 0 0", "line 5: the coordinates"),
            ("v 1e999 0 0", "line 5: the coordinates"),
        ];
        for (line, expected) in cases {
            let message = refusal(format!("{SQUARE}{line}\nv 2 2 x").as_bytes(), Format::Obj);
            let found = message.contains(expected)
                || message.contains("line 6") && expected.contains("uses vertex");
            assert!(found, "{message}");
        }
        assert!(
            refusal(format!("{SQUARE}f 1 2 5").as_bytes(), Format::Obj)
                .contains("line 5: a face uses vertex 5")
        );
        assert!(refusal(b"# nothing", Format::Obj).contains("no faces"));
        assert!(refusal(b"", Format::Obj).contains("empty"));
    }

    const DRESSED: &str = "mtllib skin.mtl two words.mtl\nv 0 0 0 1 0.25 0\nv 1 0 0 0 0 1\nv 1 1 0 0.1 0.2 0.3\n\
        v 0 1 0\nv 5 5 0 1 1 1\nvt 0 0\nvt 1 0.5\nvt 0.3 1\nvn 0 0 1\nvn 0.6 0 0.8\no thing\ng left arm\nusemtl skin\n\
        s 1\nf 1/1/1 2/2/1 3/3/2 4/1/-1\nusemtl steel\ng right\nf 3 4//2 5/-1\ns off\nf 1//1 2//1 5//2\n";

    #[test]
    fn all_that_faces_and_vertices_carry_is_read() {
        let loaded = read(DRESSED.as_bytes()).unwrap();
        let all = &loaded.attributes;
        assert_eq!(all.libraries, ["skin.mtl two words.mtl"]);
        assert_eq!(all.vertex[0].get(2), Some(&[0.1, 0.2, 0.3][..]));
        assert_eq!(all.vertex[0].get(3), None);
        assert_eq!(loaded.mesh.faces[1], [0, 2, 3]);
        let [uv, normal] = &all.corner[..] else {
            panic!("{:?}", all.corner)
        };
        assert_eq!(uv.corners[1], [0, 2, 0]);
        assert_eq!(uv.get(2, 2), Some(&[0.3, 1.0][..]));
        assert_eq!(uv.get(2, 0), None);
        assert_eq!(normal.get(1, 2), Some(&[0.6, 0.0, 0.8][..]));
        let label = |i: usize, f| all.labels[i].get(f);
        assert_eq!(
            [label(1, 1), label(1, 2)],
            [Some("left arm"), Some("right")]
        );
        assert_eq!([label(2, 0), label(2, 3)], [Some("skin"), Some("steel")]);
        assert_eq!([label(3, 0), label(3, 3)], [Some("1"), Some("off")]);
    }

    #[test]
    fn attributes_come_back_as_they_were() {
        let loaded = read(DRESSED.as_bytes()).unwrap();
        let model = Contents {
            mesh: &loaded.mesh,
            attributes: &loaded.attributes,
            document: None,
        };
        let again = read(&write(&model).bytes).unwrap();
        assert_eq!(again.mesh, loaded.mesh);
        assert_eq!(again.attributes, loaded.attributes);
    }

    #[test]
    fn damaged_attributes_are_left_out_with_a_remark() {
        let text = format!("{SQUARE}vt 0 x\nvt inf 1\nvt 1 1\nf 1/1 2/2 3/3\nf 1/9 3/-7 4/q\n");
        let loaded = read(text.as_bytes()).unwrap();
        let uv = &loaded.attributes.corner[0];
        assert_eq!((uv.get(0, 0), uv.get(0, 1)), (None, None));
        assert_eq!(uv.get(0, 2), Some(&[1.0, 1.0][..]));
        assert_eq!(uv.corners[1], [isomend_core::mesh::attributes::NONE; 3]);
        assert!(loaded.notes[0].ends_with(": 5"), "{:?}", loaded.notes);
        assert_survives_damage(DRESSED.as_bytes(), Format::Obj);
    }

    #[test]
    fn damage_is_survived() {
        let bytes = to_bytes(&open_tetrahedron(), Format::Obj, &WriteOptions::default())
            .unwrap()
            .bytes;
        assert_survives_damage(&bytes, Format::Obj);
    }

    #[test]
    fn another_reader_agrees() {
        let mesh = fine_tetrahedron();
        let options = WriteOptions::default();
        let bytes = to_bytes(&mesh, Format::Obj, &options).unwrap().bytes;
        let options = tobj::LoadOptions {
            triangulate: true,
            ..Default::default()
        };
        let (models, _) =
            tobj::load_obj_buf(&mut &bytes[..], &options, |_| Ok(Default::default())).unwrap();
        assert_eq!(models[0].mesh.indices.len(), 3 * mesh.faces.len());
        assert_eq!(models[0].mesh.positions[0], mesh.positions[0].x as f32);
    }

    #[test]
    fn many_groups_are_distinguished_in_time() {
        let start = std::time::Instant::now();
        let groups: String = (0..200_000).map(|i| format!("g {i}\n")).collect();
        let loaded = read(format!("{SQUARE}{groups}f 1 2 3\ng 7\nf 1 3 4\n").as_bytes()).unwrap();
        let labels = &loaded.attributes.labels[0];
        assert_eq!([labels.get(0), labels.get(1)], [Some("199999"), Some("7")]);
        assert_eq!((labels.names.len(), labels.of_face[1]), (200_000, 7));
        assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
    }
}
