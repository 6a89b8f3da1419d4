//! Reads and writes OFF (Geomview's object file format), text.
//!
//! Vertices may have normals (`NOFF`), colours (`COFF`) and texture coordinates (`STOFF`); faces may have colours after
//! their corners. Binary OFF and OFF of other than three dimensions are refused, with their name in the message.

use std::io::Write;

use glam::DVec3;

use super::mesh_builder::{CutFrom, MeshBuilder, not_finite};
use super::{Contents, Format, IoError, Loaded, Location, Written, lost, text};
use isomend_core::mesh::attributes::{Attribute, Role, Scalar};

/// Bytes. Lower bound of the text of a vertex or face: three numbers of one digit, each with a blank or newline. The
/// last line may lack its newline, therefore `header` allows one item more.
const LEAST_BYTES: usize = 6;

/// The vertex data that the first word of a file announces: `[ST][C][N]OFF`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Kind {
    normals: bool,
    colours: bool,
    uv: bool,
}

impl Kind {
    /// Parses the first word of a file.
    fn of(word: &[u8]) -> Option<Self> {
        let mut rest = word.strip_suffix(b"OFF")?;
        let mut kind = Self::default();
        for (letters, is_there) in [
            (&b"ST"[..], &mut kind.uv),
            (b"C", &mut kind.colours),
            (b"N", &mut kind.normals),
        ] {
            if let Some(after) = rest.strip_prefix(letters) {
                *is_there = true;
                rest = after;
            }
        }
        rest.is_empty().then_some(kind)
    }
}

/// Splits the number of vertices off the first word of a file: some programs write `OFF8 6 12` without a blank.
fn split_count(word: &[u8]) -> (&[u8], &[u8]) {
    let digits = word.iter().rev().take_while(|b| b.is_ascii_digit()).count();
    word.split_at(word.len() - digits)
}

/// Whether a word begins an OFF file, of a supported kind or not.
pub(super) fn is_first_word(word: &[u8]) -> bool {
    let other: [&[u8]; 3] = [b"4OFF", b"nOFF", b"4nOFF"];
    let (word, _) = split_count(word);
    Kind::of(word).is_some() || other.contains(&word)
}

/// Iterates over lines that are not empty, without comments.
struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    fn next_line(&mut self) -> Option<&'a [u8]> {
        while !self.rest.is_empty() {
            let end = memchr::memchr2(b'\n', b'\r', self.rest).unwrap_or(self.rest.len());
            let line = &self.rest[..end];
            let both = self.rest[end..].starts_with(b"\r\n");
            self.rest = self.rest.get(end + 1 + usize::from(both)..).unwrap_or(&[]);
            self.number += 1;
            let content = memchr::memchr(b'#', line).map_or(line, |at| &line[..at]);
            if !content.trim_ascii().is_empty() {
                return Some(content.trim_ascii());
            }
        }
        None
    }

    /// The next line; an error that names `what` at the end of the file.
    fn wanted(&mut self, what: &str) -> Result<&'a [u8], IoError> {
        self.next_line()
            .ok_or_else(|| self.fault(format!("the file ends where {what} should be")))
    }

    fn fault(&self, what: String) -> IoError {
        IoError::malformed(Format::Off, Location::Line(self.number.max(1)), what)
    }

    /// Parses the numbers of a line.
    fn numbers(&self, line: &[u8], into: &mut Vec<f64>) -> Result<(), IoError> {
        into.clear();
        for token in text::Tokens::new(line, 0) {
            let number = text::number(token);
            into.push(
                number
                    .ok_or_else(|| self.fault(format!("{} is not a number", text::shown(token))))?,
            );
        }
        Ok(())
    }
}

/// Reads a mesh from OFF.
pub(super) fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    let decoded = text::decode(bytes);
    let mut lines = Lines {
        rest: &decoded,
        number: 0,
    };
    let (kind, [vertices, faces]) = header(&mut lines)?;
    let mut surface = MeshBuilder::new(Format::Off);
    let mut columns = VertexColumns::default();
    let mut numbers = Vec::new();
    for _ in 0..vertices {
        let line = lines.wanted("a vertex")?;
        lines.numbers(line, &mut numbers)?;
        let [x, y, z, rest @ ..] = &numbers[..] else {
            let what = format!("a vertex of {} numbers, where 3 are needed", numbers.len());
            return Err(lines.fault(what));
        };
        let point = DVec3::new(*x, *y, *z);
        if !point.is_finite() {
            return Err(not_finite(Format::Off, Location::Line(lines.number), point));
        }
        surface.positions.push(point);
        columns.take(kind, rest, line);
    }
    let mut colours = Colours::default();
    let mut corners = Vec::new();
    for _ in 0..faces {
        let line = lines.wanted("a face")?;
        let mut tokens = text::Tokens::new(line, 0);
        read_corners(&lines, &mut tokens, &mut corners)?;
        if (1..3).contains(&corners.len()) {
            surface.omitted.push(lines.number);
            continue;
        }
        surface.push_face(&corners)?;
        colours.push(&tokens.take(5).collect::<Vec<_>>());
    }
    let mut cut = Some(CutFrom::identity(0));
    let mut loaded = surface.finish_with(&mut cut)?;
    columns.finish(kind, &mut loaded);
    let of_face = cut.map(|cut| cut.face).unwrap_or_default();
    face_colours(&colours.scaled(), &of_face, &mut loaded);
    Ok(loaded)
}

/// Parses the kind of the file and the counts of its vertices and faces.
fn header(lines: &mut Lines<'_>) -> Result<(Kind, [usize; 2]), IoError> {
    let first = lines.wanted("the first line")?;
    let (word, _) = split_count(text::Tokens::new(first, 0).next().unwrap_or_default());
    let Some(kind) = Kind::of(word) else {
        return Err(match is_first_word(word) {
            true => unsupported("a mesh of other than three dimensions"),
            false => lines.fault(format!(
                "the file begins with {} instead of 'OFF'",
                text::shown(word)
            )),
        });
    };
    let mut rest = first[word.len()..].trim_ascii();
    if rest.starts_with(b"BINARY") {
        return Err(unsupported("its binary form"));
    }
    if rest.is_empty() {
        rest = lines.wanted("the numbers of vertices and faces")?;
    }
    let mut counts = [0; 2];
    let mut tokens = text::Tokens::new(rest, 0);
    for (count, what) in counts.iter_mut().zip(["vertices", "faces"]) {
        let number = tokens.next().and_then(text::integer);
        let number = number.and_then(|n| usize::try_from(n).ok());
        *count = number.ok_or_else(|| lines.fault(format!("the number of {what} is missing")))?;
        let room = lines.rest.len() / LEAST_BYTES + 1;
        if *count > room {
            let what =
                format!("{count} {what} are claimed, but the file has room for {room} at most");
            return Err(lines.fault(what));
        }
    }
    Ok((kind, counts))
}

fn unsupported(what: &str) -> IoError {
    IoError::Unsupported {
        format: Format::Off,
        what: format!("{what} is not read"),
        advice: "save it as text in three dimensions",
    }
}

fn read_corners(
    lines: &Lines<'_>,
    tokens: &mut text::Tokens<'_>,
    corners: &mut Vec<u32>,
) -> Result<(), IoError> {
    corners.clear();
    let count = tokens.next().and_then(text::integer);
    let count = count.filter(|n| *n >= 0);
    let count =
        count.ok_or_else(|| lines.fault("a face without a number of corners".to_owned()))?;
    for _ in 0..count {
        let Some(token) = tokens.next() else {
            let what = format!("a face of {count} corners has only {}", corners.len());
            return Err(lines.fault(what));
        };
        let index = text::integer(token).and_then(|i| u32::try_from(i).ok());
        corners.push(
            index.ok_or_else(|| {
                lines.fault(format!("{} is not a vertex index", text::shown(token)))
            })?,
        );
    }
    match count {
        0 => Err(lines.fault("a face of 0 corners, where at least 3 are needed".to_owned())),
        _ => Ok(()),
    }
}

/// The colours of all vertices or of all faces: integers from 0 to 255, or floats from 0 to 1.
#[derive(Default)]
struct Colours {
    /// The numbers of each colour as the file gives them.
    values: Vec<Option<Vec<f64>>>,
    /// Whether any number is written with a decimal point or an exponent.
    has_fractions: bool,
}

impl Colours {
    /// Adds the words of a colour, or `None` if they are not three or four finite numbers.
    fn push(&mut self, words: &[&[u8]]) {
        let number = |word: &&[u8]| text::number(word).filter(|x| x.is_finite());
        let is_colour = (3..=4).contains(&words.len());
        let colour: Option<Vec<f64>> = is_colour
            .then(|| words.iter().map(number).collect())
            .flatten();
        let is_fraction = |word: &&[u8]| word.iter().any(|b| matches!(b, b'.' | b'e' | b'E'));
        self.has_fractions |= colour.is_some() && words.iter().any(is_fraction);
        self.values.push(colour);
    }

    /// The colours scaled to 0..255. They are taken as floats from 0 to 1 if any number has a fraction or none is above
    /// 1.
    fn scaled(mut self) -> Vec<Option<Vec<f64>>> {
        let is_above = self.values.iter().flatten().flatten().any(|x| *x > 1.0);
        let unit = if self.has_fractions || !is_above {
            255.0
        } else {
            1.0
        };
        for x in self.values.iter_mut().flatten().flatten() {
            *x = (unit * *x).clamp(0.0, 255.0);
        }
        self.values
    }
}

/// Vertex values after the coordinates.
#[derive(Default)]
struct VertexColumns {
    normals: Vec<Option<Vec<f64>>>,
    colours: Colours,
    uv: Vec<Option<Vec<f64>>>,
}

impl VertexColumns {
    /// Adds the numbers of a vertex after its coordinates: normal, colour and texture coordinates, as `kind` announces
    /// them.
    fn take(&mut self, kind: Kind, mut rest: &[f64], line: &[u8]) {
        let mut split = |count: usize| {
            let (own, after) = rest.split_at(count.min(rest.len()));
            rest = after;
            Some(own.to_vec()).filter(|own| own.len() == count)
        };
        let normal = kind.normals.then(|| split(3)).flatten();
        let before = 3 + if kind.normals { 3 } else { 0 };
        let behind = if kind.uv { 2 } else { 0 };
        let words: Vec<&[u8]> = text::Tokens::new(line, 0).collect();
        if kind.colours {
            let own = words.get(before..words.len().saturating_sub(behind));
            self.colours.push(own.unwrap_or_default());
        }
        let uv = words.len().checked_sub(2).map(|at| &words[at..]);
        let uv = uv.map(|uv| uv.iter().filter_map(|w| text::number(w)).collect());
        self.normals.push(normal);
        self.uv
            .push(uv.filter(|uv: &Vec<f64>| kind.uv && uv.len() == 2));
    }

    fn finish(self, kind: Kind, loaded: &mut Loaded) {
        let all = [
            (
                kind.normals,
                "normal",
                Role::Normal,
                Scalar::F64,
                self.normals,
            ),
            (
                kind.colours,
                "colour",
                Role::Colour,
                Scalar::U8,
                self.colours.scaled(),
            ),
            (kind.uv, "texture", Role::Uv(0), Scalar::F64, self.uv),
        ];
        for (_, name, role, scalar, values) in all.into_iter().filter(|column| column.0) {
            let attribute = attribute(name, role, scalar, values.iter());
            loaded.attributes.vertex.extend(attribute);
        }
    }
}

/// Makes an attribute with as many components as the longest value; missing values stay missing. `None` if all are
/// missing.
fn attribute<'a>(
    name: &str,
    role: Role,
    scalar: Scalar,
    values: impl Iterator<Item = &'a Option<Vec<f64>>> + Clone,
) -> Option<Attribute> {
    let components = values.clone().flatten().map(Vec::len).max()?;
    let mut out = Attribute::new(name, role, scalar, components);
    for value in values {
        // If some colours have an alpha and this has none, it is opaque.
        let whole = value.as_ref().map(|v| {
            let mut v = v.clone();
            v.resize(components, 255.0);
            v
        });
        out.push(whole.as_deref());
    }
    Some(out)
}

/// Gives each triangle the colour of the face that it comes from.
fn face_colours(colours: &[Option<Vec<f64>>], of_face: &[u32], loaded: &mut Loaded) {
    let of_triangles = of_face.iter().map(|f| &colours[*f as usize]);
    let found = attribute("colour", Role::Colour, Scalar::U8, of_triangles);
    loaded.attributes.face.extend(found);
}

/// Writes a mesh as OFF, with vertex normals, vertex colours and face colours. Decimals are the shortest that give the
/// same floats when read.
pub(super) fn write(model: &Contents<'_>) -> Written {
    let all = model.with_vertex_values(|_| true);
    let (mesh, all) = (model.mesh, &*all);
    let whole = |role: Role, components: std::ops::RangeInclusive<usize>| {
        let found = all.vertex_role(role);
        found.filter(|a| a.missing.is_empty() && components.contains(&a.components))
    };
    let normals = whole(Role::Normal, 3..=3);
    let colours = whole(Role::Colour, 3..=4);
    let of_faces = all
        .face
        .iter()
        .find(|a| a.role == Role::Colour && (3..=4).contains(&a.components));
    let mut bytes = Vec::with_capacity(mesh.positions.len() * 40 + mesh.faces.len() * 24);
    let c = if colours.is_some() { "C" } else { "" };
    let n = if normals.is_some() { "N" } else { "" };
    // Writing to a vector does not fail.
    let _ = writeln!(bytes, "{c}{n}OFF");
    let _ = writeln!(bytes, "{} {} 0", mesh.positions.len(), mesh.faces.len());
    for (v, p) in mesh.positions.iter().enumerate() {
        let _ = write!(bytes, "{} {} {}", p.x, p.y, p.z);
        for normal in normals.and_then(|a| a.get(v)).into_iter().flatten() {
            let _ = write!(bytes, " {normal}");
        }
        if let Some(attribute) = colours {
            write_colour(&mut bytes, attribute, v, 4);
        }
        bytes.push(b'\n');
    }
    for (f, [a, b, c]) in mesh.faces.iter().enumerate() {
        let _ = write!(bytes, "3 {a} {b} {c}");
        if let Some(attribute) = of_faces {
            write_colour(&mut bytes, attribute, f, attribute.components);
        }
        bytes.push(b'\n');
    }
    let held = |a: &Attribute| {
        let is = |b: Option<&Attribute>| b.is_some_and(|b| std::ptr::eq(a, b));
        is(normals) || is(colours) || is(of_faces)
    };
    let listed = all.listed_where(|a| !held(a), |_| true);
    Written {
        bytes,
        notes: lost::note(&listed, Format::Off).into_iter().collect(),
    }
}

/// Writes the colour of an item as `components` integers from 0 to 255; nothing if the item has no colour.
fn write_colour(bytes: &mut Vec<u8>, colours: &Attribute, item: usize, components: usize) {
    let unit = colours.unit();
    let Some(value) = colours.get(item) else {
        return;
    };
    for k in 0..components {
        let part = value.get(k).map_or(1.0, |x| x / unit);
        let _ = write!(bytes, " {}", (255.0 * part).round().clamp(0.0, 255.0));
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::*;
    use super::super::{WriteOptions, model_to_bytes, to_bytes};
    use super::*;
    use isomend_core::mesh::Attributes;

    #[test]
    fn round_trip_is_exact() {
        for mesh in [open_tetrahedron(), fine_tetrahedron()] {
            assert_round_trip(&mesh, Format::Off, WriteOptions::default());
        }
        assert_damage_is_survived(Format::Off);
    }

    #[test]
    fn polygons_comments_and_counts_on_the_first_line_are_read() {
        let body = "1 0 # counts\n\n0 0 0\n1 0 0\r\n1 1 0 # a corner\n0 1 0\n4 0 1 2 3 255 128 0\n";
        for first in ["OFF 4 ", "OFF4 "] {
            let loaded = read_alone(format!("{first}{body}").as_bytes(), Format::Off).unwrap();
            assert_eq!(loaded.mesh.faces.len(), 2);
            let colours = &loaded.attributes.face[0];
            assert_eq!(colours.get(1), Some(&[255.0, 128.0, 0.0][..]));
        }
    }

    #[test]
    fn colours_and_normals_come_back() {
        let text = b"CNOFF\n3 1 0\n0 0 0 0 0 1 255 0 0 255\n1 0 0 0 0 1 0 255 0 255\n0 1 0 0 0 1 0 0 255 128\n3 0 1 2\n";
        let loaded = read_alone(text, Format::Off).unwrap();
        let model = Contents {
            mesh: &loaded.mesh,
            attributes: &loaded.attributes,
            document: None,
        };
        let written = model_to_bytes(&model, Format::Off, &WriteOptions::default()).unwrap();
        assert!(written.notes.is_empty());
        let again = read_alone(&written.bytes, Format::Off).unwrap();
        assert_eq!(again.attributes, loaded.attributes);
        assert_eq!(loaded.attributes.vertex.len(), 2);
        let floats =
            b"COFF\n3 1 0\n0 0 0 1 0 0\n1 0 0 0 0.5 0\n0 1 0 0 0 1.0\n3 0 1 2 0.5 0.5 1.0\n";
        let loaded = read_alone(floats, Format::Off).unwrap();
        let colours = loaded.attributes.vertex_role(Role::Colour).unwrap();
        assert_eq!(colours.get(1), Some(&[0.0, 128.0, 0.0][..]));
    }

    #[test]
    fn colours_of_a_file_are_whole_or_floats_together() {
        let colours = |vertices: [&str; 3], faces: [&str; 2]| {
            let [a, b, c] = vertices;
            let [f, g] = faces;
            let text =
                format!("COFF\n3 2 0\n0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2 {f}\n3 2 1 0 {g}");
            let all = read_alone(text.as_bytes(), Format::Off).unwrap().attributes;
            let vertex = all.vertex_role(Role::Colour).unwrap().clone();
            (vertex, all.face[0].clone())
        };
        // One colour with a fraction makes all of them floats; small integers count as 0..255 if another is above 1.
        let (vertex, face) = colours(["1 0 0", "0 0.5 0", "1 1 1"], ["255 0 0", "1 1 0"]);
        assert_eq!(vertex.get(0), Some(&[255.0, 0.0, 0.0][..]));
        assert_eq!(vertex.get(2), Some(&[255.0, 255.0, 255.0][..]));
        assert_eq!(face.get(1), Some(&[1.0, 1.0, 0.0][..]));
        // Without a number above 1 they are floats.
        let (vertex, face) = colours(["1 0 0", "0 0 nan", "0 0 1e999"], ["1 0 0", "1e-1 0 0"]);
        assert_eq!(vertex.get(0), Some(&[255.0, 0.0, 0.0][..]));
        assert_eq!(vertex.get(1), None);
        assert_eq!(vertex.get(2), None);
        assert_eq!(face.get(1), Some(&[26.0, 0.0, 0.0][..]));
    }

    #[test]
    fn faults_are_named_with_their_line() {
        for (text, said) in [
            (&b"OFF\n9999999 1 0\n0 0 0\n"[..], "room for"),
            (b"OFF BINARY\n", "binary form"),
            (b"4OFF\n1 1 0\n", "three dimensions"),
            (b"OFF\n3 1 0\n0 0 0\n1 0 x\n", "line 4: 'x' is not a number"),
            (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "vertex 7"),
            (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n", "has only 2"),
            (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n0\n", "at least 3"),
            (
                b"OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
                "the file ends",
            ),
        ] {
            let message = refusal(text, Format::Off);
            assert!(message.contains(said), "{message}");
        }
        let plain = to_bytes(&open_tetrahedron(), Format::Off, &WriteOptions::default());
        assert!(plain.unwrap().bytes.starts_with(b"OFF\n5 3 0\n"));
        assert_eq!(Attributes::default().listed(), "");
    }
}
