//! Writes PLY with attributes of vertices and faces and with texture coordinates of corners.

use std::fmt::Write as _;
use std::io::Write as _;

use super::super::binary::BinaryNumber;
use super::super::{
    Contents, Format, IoError, Precision, WriteOptions, Written, lost, rounded, text,
};
use super::NO_UV;
use isomend_core::mesh::attributes::{Attribute, Attributes, CornerAttribute, Role, Scalar};

/// Writes positions, triangles and attributes.
pub(in super::super) fn write(
    model: &Contents<'_>,
    options: &WriteOptions,
) -> Result<Written, IoError> {
    let mesh = model.mesh;
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
    // Texture coordinates are lists at the faces.
    let attributes = model.with_vertex_values(|c| c.pool.role != Role::Uv(0));
    let tables = Tables::new(&attributes);
    let mut bytes = tables.header(model, options).into_bytes();
    let row = |columns: &[Column<'_>]| columns.iter().map(|c| c.scalar.size()).sum::<usize>();
    bytes.reserve(
        mesh.positions.len() * (24 + row(&tables.vertex))
            + mesh.faces.len() * (13 + row(&tables.face)),
    );
    let notes = match options.precision {
        Precision::F32 => {
            let (points, notes) = rounded(mesh, Format::Ply)?;
            tables.points(&mut bytes, &points, options.ascii, f32::to_le_bytes);
            notes
        }
        Precision::F64 => {
            let points: Vec<[f64; 3]> = mesh.positions.iter().map(|p| p.to_array()).collect();
            tables.points(&mut bytes, &points, options.ascii, f64::to_le_bytes);
            Vec::new()
        }
    };
    tables.faces(&mut bytes, &mesh.faces, options.ascii);
    let notes = notes.into_iter().chain(tables.notes).collect();
    Ok(Written { bytes, notes })
}

/// A scalar property: one component of an attribute.
struct Column<'a> {
    name: String,
    scalar: Scalar,
    attribute: &'a Attribute,
    component: usize,
    /// Factor by which values are multiplied before rounding to `scalar`.
    factor: f64,
}

impl Column<'_> {
    fn write(&self, bytes: &mut Vec<u8>, item: usize, ascii: bool) {
        let at = item * self.attribute.components + self.component;
        let mut value = self.attribute.values[at];
        if self.factor != 1.0 {
            value = self.scalar.nearest(value * self.factor);
        }
        if ascii {
            // Writing to a vector does not fail.
            let _ = match self.scalar {
                Scalar::F32 => write!(bytes, " {}", value as f32),
                _ => write!(bytes, " {value}"),
            };
            return;
        }
        // PLY has no integers of 64 bits.
        match self.scalar {
            Scalar::I64 | Scalar::U64 => Scalar::F64.put(value, bytes),
            scalar => scalar.put(value, bytes),
        }
    }

    fn property(&self) -> String {
        let scalar = match self.scalar {
            Scalar::I8 => "char",
            Scalar::U8 => "uchar",
            Scalar::I16 => "short",
            Scalar::U16 => "ushort",
            Scalar::I32 => "int",
            Scalar::U32 => "uint",
            Scalar::F32 => "float",
            Scalar::I64 | Scalar::U64 | Scalar::F64 => "double",
        };
        format!("property {scalar} {}\n", self.name)
    }
}

/// The properties of an attribute. An attribute from a PLY file keeps its names and types. Others get the usual names;
/// their colours become bytes.
fn columns(attribute: &Attribute) -> Vec<Column<'_>> {
    let from_ply = attribute.fields.len() == attribute.components;
    let bytes = attribute.role == Role::Colour && !from_ply;
    let unit = attribute.unit();
    let (scalar, factor) = match (bytes, attribute.scalar) {
        (true, _) => (Scalar::U8, 255.0 / unit),
        (false, Scalar::I64 | Scalar::U64) => (Scalar::F64, 1.0),
        (false, _) if unit != 1.0 && !from_ply => (Scalar::F32, 1.0 / unit),
        (false, scalar) => (scalar, 1.0),
    };
    (0..attribute.components)
        .map(|component| Column {
            name: if from_ply {
                attribute.fields[component].clone()
            } else {
                usual_name(attribute, component)
            },
            scalar,
            attribute,
            component,
            factor,
        })
        .collect()
}

fn usual_name(attribute: &Attribute, component: usize) -> String {
    let pick = |names: [&str; 4]| names[component.min(3)].to_owned();
    match attribute.role {
        Role::Normal => pick(["nx", "ny", "nz", "nw"]),
        Role::Colour => pick(["red", "green", "blue", "alpha"]),
        Role::Uv(0) => pick(["s", "t", "p", "q"]),
        Role::Uv(set) => pick(["s", "t", "p", "q"]) + &set.to_string(),
        Role::Tangent => pick(["tx", "ty", "tz", "tw"]),
        Role::Other => {
            let word = |c: char| if c.is_ascii_graphic() { c } else { '_' };
            let name: String = attribute.name.chars().map(word).collect();
            if name.is_empty() && attribute.components == 1 {
                "unnamed".to_owned()
            } else if attribute.components == 1 {
                name
            } else {
                format!("{name}_{component}")
            }
        }
    }
}

/// The columns of attributes, with names that are not in use yet.
fn distinct<'a>(attributes: &'a [Attribute], taken: &[&str]) -> Vec<Column<'a>> {
    let mut names = text::Distinct::default();
    for name in taken {
        names.take(name);
    }
    let mut columns: Vec<Column<'a>> = attributes.iter().flat_map(columns).collect();
    for column in &mut columns {
        column.name = names.name(std::mem::take(&mut column.name));
    }
    columns
}

/// The columns of the vertex and the face table.
struct Tables<'a> {
    vertex: Vec<Column<'a>>,
    face: Vec<Column<'a>>,
    uv: Option<&'a CornerAttribute>,
    /// Remarks on attributes that are left out.
    notes: Vec<String>,
}

impl<'a> Tables<'a> {
    fn new(all: &'a Attributes) -> Self {
        let uv = all.corner.iter().find(|c| c.pool.role == Role::Uv(0));
        let vertex = distinct(&all.vertex, &["x", "y", "z"]);
        let face = distinct(&all.face, &["vertex_indices", "texcoord"]);
        let held = |a: &Attribute| {
            let corner = all.corner.iter().any(|c| std::ptr::eq(&c.pool, a));
            !corner || uv.is_some_and(|uv| std::ptr::eq(&uv.pool, a))
        };
        let listed = all.listed_where(|a| !held(a), |_| true);
        Self {
            vertex,
            face,
            uv,
            notes: lost::note(&listed, Format::Ply).into_iter().collect(),
        }
    }

    fn header(&self, model: &Contents<'_>, options: &WriteOptions) -> String {
        let encoding = if options.ascii {
            "ascii"
        } else {
            "binary_little_endian"
        };
        let scalar = match options.precision {
            Precision::F32 => "float",
            Precision::F64 => "double",
        };
        let mut text = format!("ply\nformat {encoding} 1.0\n");
        // Writing to a string does not fail.
        for texture in &model.attributes.textures {
            let _ = writeln!(text, "comment TextureFile {texture}");
        }
        let _ = writeln!(text, "element vertex {}", model.mesh.positions.len());
        for axis in ["x", "y", "z"] {
            let _ = writeln!(text, "property {scalar} {axis}");
        }
        text.extend(self.vertex.iter().map(Column::property));
        let _ = writeln!(text, "element face {}", model.mesh.faces.len());
        text.push_str("property list uchar int vertex_indices\n");
        text.extend(self.face.iter().map(Column::property));
        if let Some(uv) = self.uv {
            let double = uv.pool.scalar == Scalar::F64 && uv.pool.name == "texcoord";
            let scalar = if double { "double" } else { "float" };
            let _ = writeln!(text, "property list uchar {scalar} texcoord");
        }
        text + "end_header\n"
    }

    fn points<T: Copy + std::fmt::Display, const N: usize>(
        &self,
        bytes: &mut Vec<u8>,
        points: &[[T; 3]],
        ascii: bool,
        encode: impl Fn(T) -> [u8; N],
    ) {
        for (v, [x, y, z]) in points.iter().enumerate() {
            if ascii {
                let _ = write!(bytes, "{x} {y} {z}");
            } else {
                for value in [*x, *y, *z] {
                    bytes.extend_from_slice(&encode(value));
                }
            }
            for column in &self.vertex {
                column.write(bytes, v, ascii);
            }
            if ascii {
                bytes.push(b'\n');
            }
        }
    }

    fn faces(&self, bytes: &mut Vec<u8>, faces: &[[u32; 3]], ascii: bool) {
        for (f, [a, b, c]) in faces.iter().enumerate() {
            if ascii {
                let _ = write!(bytes, "3 {a} {b} {c}");
            } else {
                let mut row = [3u8; 13];
                row[1..5].copy_from_slice(&a.to_le_bytes());
                row[5..9].copy_from_slice(&b.to_le_bytes());
                row[9..].copy_from_slice(&c.to_le_bytes());
                bytes.extend_from_slice(&row);
            }
            for column in &self.face {
                column.write(bytes, f, ascii);
            }
            if let Some(uv) = self.uv {
                write_uv(bytes, uv, f, ascii);
            }
            if ascii {
                bytes.push(b'\n');
            }
        }
    }
}

/// Writes the texture coordinates of a face's corners: six numbers for every face, since other programs read no lists of different
/// lengths. If a corner has none, they are [`NO_UV`].
fn write_uv(bytes: &mut Vec<u8>, uv: &CornerAttribute, face: usize, ascii: bool) {
    let corners = [0, 1, 2].map(|k| uv.get(face, k));
    let double = uv.pool.scalar == Scalar::F64 && uv.pool.name == "texcoord";
    if ascii {
        bytes.extend_from_slice(b" 6");
    } else {
        bytes.push(6);
    }
    let values = match corners {
        [Some(a), Some(b), Some(c)] => [a[0], a[1], b[0], b[1], c[0], c[1]],
        _ => [NO_UV; 6],
    };
    for value in values {
        let _ = match (ascii, double) {
            (true, true) => write!(bytes, " {value}"),
            (true, false) => write!(bytes, " {}", value as f32),
            (false, true) => bytes.write_all(&value.to_le_bytes()),
            (false, false) => bytes.write_all(&(value as f32).to_le_bytes()),
        };
    }
}
