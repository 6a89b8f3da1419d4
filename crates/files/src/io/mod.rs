//! Reading and writing mesh and volume files: OBJ, PLY, STL, glTF/GLB, VTK legacy, VTP, OFF, 3MF, USD and VTI.
//!
//! Each format has one module that turns bytes into a [`Mesh`] and back. Volumes are written as VTI and read from VTI
//! and VTK legacy. Only the functions of paths, such as [`read_path`] and [`write_path`], use the file system.
//! Coordinates are `f64` in memory. Indexed formats keep the vertex order of the file, including unreferenced and
//! duplicate vertices. The corners of an STL file are welded where their coordinates are equal. Faces of more than
//! three corners, also concave ones, are triangulated.
//!
//! Counts claimed by a file are checked against its size before memory is allocated. A damaged file gives an
//! [`IoError`] that says where the fault is.
//!
//! ```
//! use isomend::io::{Format, Precision, WriteOptions, read_bytes, to_bytes};
//!
//! let text = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let loaded = read_bytes(text, Format::Obj, &isomend::io::no_side_files)?;
//! assert_eq!(loaded.mesh.faces.len(), 2);
//! let options = WriteOptions { precision: Precision::of(&loaded.mesh), ascii: false };
//! let ply = to_bytes(&loaded.mesh, Format::Ply, &options)?;
//! assert!(ply.bytes.starts_with(b"ply"));
//! # Ok::<(), isomend::io::IoError>(())
//! ```

mod binary;
mod budget;
#[cfg(test)]
mod corner_tests;
mod detect;
mod document;
mod error;
mod files;
mod format;
mod gltf;
mod interpolate;
mod lost;
mod mesh_builder;
mod obj;
mod off;
mod paths;
mod ply;
mod precision;
mod save;
mod stl;
mod text;
mod threemf;
mod usd;
mod vtk;

pub(crate) use self::gltf::GltfDocument;
pub use self::gltf::Image;
pub(crate) use self::threemf::BESIDE;
pub use document::FileDocument;
pub use error::{IoError, Location};
pub use files::{
    read_path, read_text, read_volume_path, write_model, write_path, write_volume_path,
};
pub use format::Format;
pub use precision::{Precision, WriteOptions};
pub(crate) use {
    self::gltf::{BaseImage, Wrapping},
    files::read_as,
    save::Staged,
};
pub use {
    files::{beside, bytes_of, read_stream},
    paths::canonical,
    save::{
        Abandoned, abandon_unfinished, read_plain, replace_file, replace_unlinked, write_new,
        written_files,
    },
};

use serde::{Deserialize, Serialize};

use isomend_core::grid::Volume;
use isomend_core::mesh::{Attributes, Bodies, Mesh, Model, Origins, significant};

/// A mesh read from a file, with its attributes, its format and remarks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Loaded {
    /// The mesh.
    pub mesh: Mesh,
    /// The format it was read from.
    pub format: Format,
    /// Whether every coordinate is exactly a 32-bit float, so that writing 32-bit floats loses nothing.
    pub f32_exact: bool,
    /// Data other than the shape: colours, texture coordinates, materials and so on.
    pub attributes: Attributes,
    /// The rest of a glTF or 3MF file, kept so that the same format can be written again.
    pub document: Option<FileDocument>,
    /// Remarks for the user, one sentence each, such as how many faces are degenerate.
    pub notes: Vec<String>,
}

impl Loaded {
    /// A mesh with attributes that was not read from a file; it counts as PLY.
    pub fn in_memory(mesh: Mesh, attributes: Attributes) -> Self {
        Self {
            f32_exact: Precision::of(&mesh) == Precision::F32,
            mesh,
            format: Format::Ply,
            attributes,
            document: None,
            notes: Vec::new(),
        }
    }

    /// The result of removing faces: `mesh`, with the attributes of the marked vertices and faces.
    #[must_use]
    pub fn restricted(&self, mesh: Mesh, [vertices, faces]: [&[bool]; 2]) -> Self {
        let attributes = self.attributes.with_faces(faces);
        self.with(mesh, attributes.with_vertices(vertices))
    }

    /// The result of an operation: `mesh`, with attributes taken from this input by `origins`. `kept` marks the faces
    /// of the input that are unchanged.
    #[must_use]
    pub fn derived(&self, mesh: Mesh, origins: &Origins, kept: &[bool]) -> Self {
        let mut attributes = self.attributes.derived(origins, kept);
        let before = (&self.attributes, &self.mesh);
        interpolate::interpolate(&mut attributes, &mesh, origins, before);
        self.with(mesh, attributes)
    }

    /// The bodies of a 3MF file: its objects and their parts, if there are several. In other formats objects and groups name
    /// faces of one mesh.
    pub(crate) fn bodies(&self) -> Option<Bodies> {
        Bodies::new(&self.mesh, &self.attributes)
    }

    /// Another mesh with its attributes; format, document and remarks come from this file.
    fn with(&self, mesh: Mesh, attributes: Attributes) -> Self {
        Self {
            mesh,
            attributes,
            format: self.format,
            f32_exact: self.f32_exact,
            document: self.document.clone(),
            notes: self.notes.clone(),
        }
    }
}

impl From<Loaded> for Model {
    fn from(loaded: Loaded) -> Self {
        Self {
            mesh: loaded.mesh,
            attributes: loaded.attributes,
            notes: loaded.notes,
        }
    }
}

/// A mesh with everything that is written in addition to its shape.
#[derive(Clone, Copy, Debug)]
pub struct Contents<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Data other than the shape.
    pub attributes: &'a Attributes,
    /// The rest of the file that the mesh came from; used when the same format is written. glTF: the first vertices and faces of the
    /// mesh must be the file's, apart from faces that [`Attributes::with_faces`] removed. 3MF: [`Attributes::file_faces`] says which
    /// faces are the file's.
    pub document: Option<&'a FileDocument>,
}

/// A mesh as the bytes of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Written {
    /// The content of the file.
    pub bytes: Vec<u8>,
    /// Remarks for the user, such as that coordinates were rounded.
    pub notes: Vec<String>,
}

/// Loads a file that another file names, for example the buffer of a glTF file or the materials of an OBJ file.
/// Arguments: the name as the file gives it, and the most bytes needed from the file's beginning.
pub type Resolve<'a> = dyn Fn(&str, u64) -> Result<Vec<u8>, IoError> + 'a;

/// A [`Resolve`] for bytes without side files: it refuses every name.
///
/// # Errors
/// Always.
pub fn no_side_files(name: &str, _: u64) -> Result<Vec<u8>, IoError> {
    Err(IoError::Unsupported {
        format: Format::Gltf,
        what: format!("'{name}' is outside the file"),
        advice: "read the mesh from its path, or save it as GLB",
    })
}

/// Reads a mesh from the bytes of a file of a known format.
///
/// `resolve` loads what the file refers to by name: the buffers of a glTF file; the material files and the first bytes
/// of the images of an OBJ file; the layers of a USD stage. The files of OBJ and USD may be missing.
///
/// # Errors
/// When the bytes are damaged, hold no faces, or hold only degenerate ones.
pub fn read_bytes(bytes: &[u8], format: Format, resolve: &Resolve<'_>) -> Result<Loaded, IoError> {
    if bytes.is_empty() {
        return Err(IoError::malformed(
            format,
            Location::File,
            "the file is empty",
        ));
    }
    match format {
        Format::Obj => obj::read(bytes, resolve),
        Format::Ply => ply::read(bytes),
        Format::Stl => stl::read(bytes),
        Format::Gltf | Format::Glb => gltf::read(bytes, format, resolve),
        Format::Vtk => vtk::read_legacy(bytes),
        Format::Vtp => vtk::read_xml(bytes),
        Format::Off => off::read(bytes),
        Format::ThreeMf => threemf::read(bytes),
        Format::Usda | Format::Usdz => usd::read(bytes, format, resolve),
        Format::Vti => Err(no_mesh()),
    }
}

/// Writes a mesh to bytes, without attributes.
///
/// # Errors
/// When a face names a vertex that does not exist, or a coordinate is not finite or too large for the format.
pub fn to_bytes(mesh: &Mesh, format: Format, options: &WriteOptions) -> Result<Written, IoError> {
    let attributes = &Attributes::default();
    let model = Contents {
        mesh,
        attributes,
        document: None,
    };
    model_to_bytes(&model, format, options)
}

/// Writes a mesh and its attributes to bytes. The remarks name attributes that the format cannot hold; these are left
/// out.
///
/// # Errors
/// As [`to_bytes`].
pub fn model_to_bytes(
    model: &Contents<'_>,
    format: Format,
    options: &WriteOptions,
) -> Result<Written, IoError> {
    check(model.mesh, format)?;
    let turned = gltf::all_turned(model, format);
    let attributes = turned.as_ref().unwrap_or(model.attributes);
    let model = &Contents {
        attributes,
        ..*model
    };
    let written = match format {
        Format::Obj => Ok(obj::write(model)),
        Format::Ply => ply::write(model, options),
        Format::Stl => stl::write(model.mesh, options).map(|w| lost::all(w, model, format)),
        Format::Gltf | Format::Glb => gltf::write(model, format),
        Format::Vtk => vtk::write_legacy(model, options),
        Format::Vtp => vtk::write_xml(model, options),
        Format::Off => Ok(off::write(model)),
        Format::ThreeMf => threemf::write(model),
        Format::Usda | Format::Usdz => usd::write(model, format),
        Format::Vti => Err(no_mesh()),
    };
    let rest = model.document.map(|own| own.rest_beside(format));
    let mut written = written?;
    lost::note_rest(&mut written, &rest.unwrap_or_default(), format);
    Ok(written)
}

/// The error for a volume file where a mesh is expected.
fn no_mesh() -> IoError {
    IoError::Unsupported {
        format: Format::Vti,
        what: "it holds volumes, not meshes".to_owned(),
        advice: "'isomend surface' and 'isomend sdf' turn one into the other",
    }
}

/// Reads a volume from the bytes of a VTI file or of a VTK legacy file of structured points.
///
/// `array` names the scalar array to read if the file has several.
///
/// # Errors
/// When the bytes are damaged, hold no volume or no array of that name, or hold several arrays and `array` is `None`.
pub fn read_volume_bytes(bytes: &[u8], array: Option<&str>) -> Result<Volume, IoError> {
    detect::refuse_mesh(bytes)?;
    if text::skip_blank(bytes).starts_with(b"#") {
        vtk::read_image_legacy(bytes, array)
    } else {
        vtk::read_image_xml(bytes, array)
    }
}

/// Writes a volume as the bytes of a VTI file, compressed with zlib.
///
/// # Errors
/// When a value is not finite or too large for 32-bit floats, or the counts do not fit.
pub fn volume_to_bytes(
    volume: &Volume,
    name: &str,
    precision: Precision,
) -> Result<Vec<u8>, IoError> {
    vtk::write_image(volume, name, precision)
}

fn check(mesh: &Mesh, format: Format) -> Result<(), IoError> {
    let refuse = |what| {
        Err(IoError::NotWritable {
            format,
            what,
            advice: "repair the mesh before writing it",
        })
    };
    let count = mesh.positions.len();
    if let Some(face) = mesh
        .faces
        .iter()
        .position(|f| f.iter().any(|i| *i as usize >= count))
    {
        return refuse(format!(
            "face {face} uses a vertex beyond the last of {count}"
        ));
    }
    match mesh.positions.iter().position(|p| !p.is_finite()) {
        Some(vertex) => refuse(format!("vertex {vertex} is not finite")),
        None => Ok(()),
    }
}

/// The smallest and the largest coordinates of some points; infinite where there are none.
fn extent(points: &[[f32; 3]]) -> [[f32; 3]; 2] {
    let start = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    points.iter().fold(start, |[mut low, mut high], p| {
        for axis in 0..3 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
        }
        [low, high]
    })
}

/// Coordinates as 32-bit floats, with a remark if any of them changed.
fn rounded(mesh: &Mesh, format: Format) -> Result<(Vec<[f32; 3]>, Vec<String>), IoError> {
    let mut largest = 0.0f64;
    let mut points = Vec::with_capacity(mesh.positions.len());
    for (vertex, position) in mesh.positions.iter().enumerate() {
        let point = position.as_vec3();
        if !point.is_finite() {
            return Err(IoError::NotWritable {
                format,
                what: format!(
                    "the coordinates {:?} of vertex {vertex} are too large for 32-bit floats",
                    position.to_array()
                ),
                advice: "write OBJ, or PLY in double precision",
            });
        }
        largest = largest.max((point.as_dvec3() - position).abs().max_element());
        points.push(point.to_array());
    }
    let note = (largest > 0.0).then(|| {
        format!(
            "positions were rounded to 32-bit floats, by up to {}",
            significant(largest, 2)
        )
    });
    Ok((points, note.into_iter().collect()))
}

#[cfg(test)]
pub(crate) mod samples {
    //! Meshes and checks shared by the formats' tests.

    use glam::DVec3;

    use super::*;

    /// A tetrahedron without its last face, and a vertex that no face uses.
    pub(crate) fn open_tetrahedron() -> Mesh {
        let positions = vec![
            DVec3::ZERO,
            DVec3::X,
            DVec3::Y,
            DVec3::new(0.25, 0.25, -1.5),
            DVec3::new(-0.0, 9.0, 1e-3f32.into()),
        ];
        Mesh::new(positions, vec![[0, 1, 2], [0, 3, 1], [1, 3, 2]])
    }

    /// [`open_tetrahedron`] with coordinates that 32-bit floats cannot hold.
    pub(crate) fn fine_tetrahedron() -> Mesh {
        let mut mesh = open_tetrahedron();
        for p in &mut mesh.positions {
            *p = *p / 3.0 + DVec3::new(1e6, -0.1, 1.0 / 7.0);
        }
        mesh
    }

    /// Reads bytes that have no side files.
    pub(crate) fn read_alone(bytes: &[u8], format: Format) -> Result<Loaded, IoError> {
        read_bytes(bytes, format, &no_side_files)
    }

    /// The message of the error that reading gives.
    pub(crate) fn refusal(bytes: &[u8], format: Format) -> String {
        match read_alone(bytes, format) {
            Ok(loaded) => panic!("read as {:?}", loaded.mesh),
            Err(error) => error.to_string(),
        }
    }

    /// Writes and reads back; the mesh must be bitwise the same and without remarks.
    pub(crate) fn assert_round_trip(mesh: &Mesh, format: Format, options: WriteOptions) {
        let written = to_bytes(mesh, format, &options).unwrap();
        assert_eq!(written.notes, Vec::<String>::new());
        let loaded = read_alone(&written.bytes, format).unwrap();
        let bits = |m: &Mesh| {
            m.positions
                .iter()
                .flat_map(|p| p.to_array().map(f64::to_bits))
                .collect::<Vec<_>>()
        };
        assert_eq!(bits(&loaded.mesh), bits(mesh), "{format} {options:?}");
        assert_eq!(loaded.mesh.faces, mesh.faces);
        assert_eq!(loaded.f32_exact, Precision::of(mesh) == Precision::F32);
    }

    /// Damages a written file, as text and as binary.
    pub(crate) fn assert_damage_is_survived(format: Format) {
        for ascii in [false, true] {
            let options = WriteOptions {
                ascii,
                precision: Precision::F32,
            };
            let written = to_bytes(&open_tetrahedron(), format, &options).unwrap();
            assert_survives_damage(&written.bytes, format);
        }
    }

    /// Truncates a file at every length and replaces each byte in turn. Any result is accepted, but no panic.
    pub(crate) fn assert_survives_damage(bytes: &[u8], format: Format) {
        for length in 0..bytes.len() {
            let _ = read_alone(&bytes[..length], format);
        }
        for at in 0..bytes.len() {
            for value in [0u8, 0x7f, 0x80, 0xff, b'-', b'9', b' '] {
                let mut damaged = bytes.to_vec();
                damaged[at] = value;
                let _ = read_alone(&damaged, format);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn a_mesh_with_a_wrong_index_or_coordinate_is_not_written() {
        let mut mesh = samples::open_tetrahedron();
        mesh.faces[1][2] = 5;
        let write = |mesh: &Mesh| {
            to_bytes(mesh, Format::Ply, &WriteOptions::default())
                .unwrap_err()
                .to_string()
        };
        assert!(write(&mesh).contains("face 1"));
        mesh.faces[1][2] = 4;
        mesh.positions[3] = DVec3::NAN;
        assert!(write(&mesh).contains("vertex 3"));
        mesh.positions[3] = DVec3::splat(1e300);
        assert!(write(&mesh).contains("too large"));
    }

    #[test]
    fn rounding_is_noted_only_when_it_changes_something() {
        let options = WriteOptions::default();
        assert_eq!(
            to_bytes(&samples::fine_tetrahedron(), Format::Stl, &options)
                .unwrap()
                .notes
                .len(),
            1
        );
        assert!(
            to_bytes(&samples::open_tetrahedron(), Format::Stl, &options)
                .unwrap()
                .notes
                .is_empty()
        );
    }
}
