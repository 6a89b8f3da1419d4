//! Reads and writes STL, text and binary.
//!
//! STL repeats the coordinates of a vertex in each of its facets. Corners with exactly equal coordinates are welded
//! into one vertex.

use std::io::Write;

use glam::{DVec3, Vec3};

use super::mesh_builder::{MeshBuilder, not_finite};
use super::{Format, IoError, Loaded, Location, Precision, WriteOptions, Written, rounded, text};
use isomend_core::mesh::{Mesh, Welder, area_vector};

/// Bytes: 80 of free text and the 32-bit facet count.
const HEADER: usize = 84;
/// Bytes of a facet: a normal and three corners as 32-bit floats, and two bytes of attributes.
const FACET: usize = 50;

/// Reads a mesh from STL and welds it.
pub(super) fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    if !has_binary_size(bytes) && looks_like_text(bytes) {
        read_text(bytes)
    } else {
        read_binary(bytes)
    }
}

/// Whether the length of the file matches its facet count exactly.
pub(super) fn has_binary_size(bytes: &[u8]) -> bool {
    claimed_facets(bytes)
        .is_some_and(|count| count > 0 && (bytes.len() - HEADER) as u64 == count * FACET as u64)
}

fn claimed_facets(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(80..HEADER)?.first_chunk::<4>()?;
    Some(u64::from(u32::from_le_bytes(*count)))
}

fn looks_like_text(bytes: &[u8]) -> bool {
    let start = text::skip_blank(text::strip_bom(bytes));
    let is_solid = start
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    is_solid && !start[..start.len().min(1024)].contains(&0)
}

fn read_binary(bytes: &[u8]) -> Result<Loaded, IoError> {
    let Some(count) = claimed_facets(bytes) else {
        let what = format!(
            "{} bytes are too few for binary STL, and text STL begins with 'solid'",
            bytes.len()
        );
        return Err(IoError::malformed(Format::Stl, Location::File, what));
    };
    let body = &bytes[HEADER..];
    let room = body.len() / FACET;
    if count > room as u64 {
        let what = format!("the header claims {count} facets, but the file has room for {room}");
        return Err(IoError::malformed(Format::Stl, Location::Byte(80), what));
    }
    let count = count as usize;
    let mut surface = MeshBuilder::new(Format::Stl);
    surface.reserve_faces(count);
    let mut welder = Welder::with_capacity(count / 2 + 2);
    let mut coloured = 0;
    for (facet, record) in body.chunks_exact(FACET).take(count).enumerate() {
        let corner = |i: usize| {
            let axis = |j: usize| {
                let at = 12 + 12 * i + 4 * j;
                f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
            };
            Vec3::new(axis(0), axis(1), axis(2)).as_dvec3()
        };
        coloured += usize::from(record[FACET - 2..] != [0, 0]);
        let corners = [corner(0), corner(1), corner(2)];
        surface.push_triangle(weld(&mut welder, corners, || {
            Location::Item("facet", facet)
        })?);
    }
    if coloured > 0 {
        surface.notes.push(format!(
            "facets with attribute bytes, such as colours, which are not read: {coloured} of {count}"
        ));
    }
    if body.len() > count * FACET {
        surface.notes.push(format!(
            "bytes after the last facet, not read: {}",
            body.len() - count * FACET
        ));
    }
    surface.positions = welder.points;
    surface.finish()
}

fn weld(
    welder: &mut Welder,
    corners: [DVec3; 3],
    place: impl Fn() -> Location,
) -> Result<[u32; 3], IoError> {
    let mut face = [0; 3];
    for (index, corner) in face.iter_mut().zip(corners) {
        *index = vertex(welder, corner, &place)?;
    }
    Ok(face)
}

fn vertex(
    welder: &mut Welder,
    corner: DVec3,
    place: &impl Fn() -> Location,
) -> Result<u32, IoError> {
    if !corner.is_finite() {
        return Err(not_finite(Format::Stl, place(), corner));
    }
    welder.index(corner).ok_or_else(|| {
        IoError::malformed(
            Format::Stl,
            place(),
            "there are more vertices than 32-bit indices can name",
        )
        .advise("split the mesh into smaller files")
    })
}

/// Reads the facets of all solids of a text file. Names of solids and normals are ignored.
fn read_text(bytes: &[u8]) -> Result<Loaded, IoError> {
    let bytes = text::strip_bom(bytes);
    let mut tokens = text::Tokens::new(bytes, 0);
    let mut surface = MeshBuilder::new(Format::Stl);
    let mut welder = Welder::with_capacity(bytes.len() / 400);
    let mut corners = Vec::new();
    while let Some(word) = tokens.next() {
        if word.eq_ignore_ascii_case(b"vertex") {
            let point = read_point(&mut tokens)?;
            corners.push(vertex(&mut welder, point, &|| {
                Location::Line(tokens.line())
            })?);
        } else if word.eq_ignore_ascii_case(b"endfacet") {
            close_facet(&mut surface, &mut corners, &tokens)?;
        } else if word.eq_ignore_ascii_case(b"solid") || word.eq_ignore_ascii_case(b"endsolid") {
            tokens.rest_of_line();
        }
    }
    if !corners.is_empty() {
        return Err(fault(&tokens, "the file ends inside a facet".to_string()));
    }
    surface.positions = welder.points;
    surface.finish()
}

fn close_facet(
    surface: &mut MeshBuilder,
    corners: &mut Vec<u32>,
    tokens: &text::Tokens<'_>,
) -> Result<(), IoError> {
    if corners.len() < 3 {
        return Err(fault(
            tokens,
            format!("a facet of {} vertices, where 3 are needed", corners.len()),
        ));
    }
    surface.push_face(corners)?;
    corners.clear();
    Ok(())
}

fn read_point(tokens: &mut text::Tokens<'_>) -> Result<DVec3, IoError> {
    let mut point = [0.0; 3];
    for coordinate in &mut point {
        *coordinate = match tokens.next() {
            Some(token) => text::number(token).ok_or_else(|| {
                fault(
                    tokens,
                    format!("{} is not a coordinate", text::shown(token)),
                )
            })?,
            None => return Err(fault(tokens, "the file ends inside a vertex".to_string())),
        };
    }
    Ok(DVec3::from_array(point))
}

fn fault(tokens: &text::Tokens<'_>, what: String) -> IoError {
    IoError::malformed(Format::Stl, Location::Line(tokens.line()), what)
}

/// Writes STL. Binary STL always holds 32-bit floats.
pub(super) fn write(mesh: &Mesh, options: &WriteOptions) -> Result<Written, IoError> {
    let Ok(count) = u32::try_from(mesh.faces.len()) else {
        return Err(IoError::NotWritable {
            format: Format::Stl,
            what: format!("{} facets are more than it can count", mesh.faces.len()),
            advice: "write PLY",
        });
    };
    if options.ascii && options.precision == Precision::F64 {
        let points: Vec<[f64; 3]> = mesh.positions.iter().map(|p| p.to_array()).collect();
        return Ok(Written {
            bytes: write_text(mesh, &points),
            notes: Vec::new(),
        });
    }
    let (points, notes) = rounded(mesh, Format::Stl)?;
    let bytes = if options.ascii {
        write_text(mesh, &points)
    } else {
        write_binary(mesh, &points, count)
    };
    Ok(Written { bytes, notes })
}

/// The unit normal of a facet, or zero where it has no area.
fn normal(mesh: &Mesh, face: &[u32; 3]) -> Vec3 {
    let corners = face.map(|i| mesh.positions[i as usize]);
    area_vector(corners).normalize_or_zero().as_vec3()
}

fn write_binary(mesh: &Mesh, points: &[[f32; 3]], count: u32) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER + FACET * mesh.faces.len());
    bytes.resize(80, b' ');
    bytes.extend_from_slice(&count.to_le_bytes());
    for face in &mesh.faces {
        let mut record = [0u8; FACET];
        let corners = face.map(|i| points[i as usize]);
        let values = normal(mesh, face)
            .to_array()
            .into_iter()
            .chain(corners.into_iter().flatten());
        for (slot, value) in record.chunks_exact_mut(4).zip(values) {
            slot.copy_from_slice(&value.to_le_bytes());
        }
        bytes.extend_from_slice(&record);
    }
    bytes
}

fn write_text<T: Copy + std::fmt::Display>(mesh: &Mesh, points: &[[T; 3]]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(200 * mesh.faces.len());
    // Writing to a vector does not fail.
    let _ = writeln!(bytes, "solid mesh");
    for face in &mesh.faces {
        let n = normal(mesh, face);
        let _ = writeln!(bytes, "facet normal {} {} {}\nouter loop", n.x, n.y, n.z);
        for [x, y, z] in face.map(|i| points[i as usize]) {
            let _ = writeln!(bytes, "vertex {x} {y} {z}");
        }
        let _ = writeln!(bytes, "endloop\nendfacet");
    }
    let _ = writeln!(bytes, "endsolid mesh");
    bytes
}

#[cfg(test)]
mod tests {
    use super::super::samples::*;
    use super::super::to_bytes;
    use super::*;

    /// The mesh without the vertex that no facet uses, which STL cannot hold.
    fn facets(mut mesh: Mesh) -> Mesh {
        mesh.positions.truncate(4);
        mesh
    }

    #[test]
    fn round_trip_is_exact() {
        let single = |ascii| WriteOptions {
            ascii,
            precision: Precision::F32,
        };
        assert_round_trip(&facets(open_tetrahedron()), Format::Stl, single(false));
        assert_round_trip(&facets(open_tetrahedron()), Format::Stl, single(true));
        let double = WriteOptions {
            ascii: true,
            precision: Precision::F64,
        };
        assert_round_trip(&facets(fine_tetrahedron()), Format::Stl, double);
    }

    #[test]
    fn zero_and_minus_zero_are_welded() {
        let text = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
                    endsolid\nSOLID facet vertex\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX -0 -0 0\nVERTEX 0 1 0\n\
                    VERTEX -1 0 0\nENDLOOP\nENDFACET\nENDSOLID\n";
        let loaded = read(text.as_bytes()).unwrap();
        assert_eq!(loaded.mesh.faces, [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn text_is_read_with_any_line_ends() {
        let facet = |x: i32| {
            format!(
                "facet normal 0 0 1\nouter loop\nvertex {x} 0 0\nvertex 9 0 0\nvertex 9 9 0\nendloop\nendfacet\n"
            )
        };
        let text = format!("solid a vertex\n{}{}endsolid a\n", facet(0), facet(1));
        for end in ["\n", "\r\n", "\r"] {
            let loaded = read(text.replace('\n', end).as_bytes()).unwrap();
            assert_eq!(loaded.mesh.faces.len(), 2, "{end:?}");
            let bad = text.replace("vertex 1", "vertex one").replace('\n', end);
            assert!(refusal(bad.as_bytes(), Format::Stl).contains("line 11"));
        }
    }

    #[test]
    fn binary_files_may_begin_with_solid() {
        let mut bytes = to_bytes(&open_tetrahedron(), Format::Stl, &WriteOptions::default())
            .unwrap()
            .bytes;
        bytes[..6].copy_from_slice(b"solid ");
        assert_eq!(read(&bytes).unwrap().mesh.faces.len(), 3);
        bytes[20] = 0;
        bytes.push(7);
        assert_eq!(read(&bytes).unwrap().notes.len(), 1);
    }

    #[test]
    fn another_reader_agrees() {
        for ascii in [false, true] {
            let mesh = facets(open_tetrahedron());
            let options = WriteOptions {
                ascii,
                precision: Precision::F32,
            };
            let bytes = to_bytes(&mesh, Format::Stl, &options).unwrap().bytes;
            let other = stl_io::read_stl(&mut std::io::Cursor::new(bytes)).unwrap();
            let faces: Vec<[u32; 3]> = other
                .faces
                .iter()
                .map(|f| f.vertices.map(|i| i as u32))
                .collect();
            assert_eq!((other.vertices.len(), faces), (4, mesh.faces));
        }
    }

    #[test]
    fn faults_are_named() {
        let facet = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n";
        let text = |end: &str| refusal(format!("{facet}{end}").as_bytes(), Format::Stl);
        assert!(text("vertex 0 1").contains("line 6: the file ends inside a vertex"));
        assert!(text("vertex 0 1 x").contains("line 6: 'x'"));
        assert!(text("vertex 0 1 inf").contains("line 6: the coordinates"));
        assert!(text("endloop\nendfacet").contains("line 7: a facet of 2"));
        assert!(text("vertex 0 1 0\nendloop").contains("ends inside a facet"));
        assert!(refusal(b"solid a\nendsolid a\n", Format::Stl).contains("no faces"));
        assert!(refusal(b"nothing", Format::Stl).contains("too few"));
        let bytes = to_bytes(&open_tetrahedron(), Format::Stl, &WriteOptions::default())
            .unwrap()
            .bytes;
        let mut many = bytes.clone();
        many[80..84].fill(0xff);
        assert!(
            refusal(&many, Format::Stl)
                .contains("claims 4294967295 facets, but the file has room for 3")
        );
        let mut infinite = bytes;
        infinite[84 + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(refusal(&infinite, Format::Stl).contains("facet 1"));
    }

    #[test]
    fn damage_is_survived() {
        assert_damage_is_survived(Format::Stl);
    }
}
