//! The surface at a level of a volume, from file to file.

use serde::Serialize;

use super::{Document, FileInfo, JobError, Output, Place, Source};
use crate::extract::level_surface;
use crate::grid::Volume;
use crate::io::{Contents, Format, Precision, read_volume_bytes, read_volume_path};
use crate::mesh::{Attributes, Mesh};

/// A volume file whose surface at a level is written as a mesh.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfaceSpec {
    /// The volume to read: VTI, or VTK legacy structured points.
    pub source: Source,
    /// The point data to take, where there are several arrays.
    pub array: Option<String>,
    /// The level. Inside is where values are below it.
    pub level: f64,
    /// Whether flat caps close the surface at the volume's border.
    pub close: bool,
    /// Where the mesh goes.
    pub output: Output,
    /// The floats of its coordinates, in formats that have a choice.
    pub precision: Precision,
}

/// The surface that was written.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SurfaceResult<'s> {
    spec: &'s SurfaceSpec,
    dims: [usize; 3],
    range: [f64; 2],
    /// The mesh.
    pub mesh: Mesh,
    /// Remarks of the writer.
    pub notes: Vec<String>,
    /// The bytes, where they are the caller's.
    pub bytes: Vec<u8>,
}

#[derive(Serialize)]
struct Body<'a> {
    input: String,
    dims: [usize; 3],
    range: [f64; 2],
    level: f64,
    output: FileInfo,
    notes: &'a [String],
}

impl SurfaceSpec {
    /// The surface at level 0, with 32-bit coordinates.
    pub fn new(source: impl Into<Source>, output: Output) -> Self {
        Self {
            source: source.into(),
            array: None,
            level: 0.0,
            close: false,
            output,
            precision: Precision::F32,
        }
    }

    /// Checks what can be known before the volume is read.
    ///
    /// # Errors
    /// As [`Output::check`], and [`JobError::No64Bit`].
    pub fn check(&self) -> Result<(), JobError> {
        self.output.check()?;
        let format = self.output.format;
        match (self.precision, format) {
            (Precision::F64, Format::Stl | Format::Gltf | Format::Glb) => {
                Err(JobError::No64Bit { format })
            }
            _ => Ok(()),
        }
    }

    /// Reads, extracts and writes.
    ///
    /// # Errors
    /// When the volume cannot be read or has no surface at the level, or the mesh cannot be written.
    pub fn run(&self) -> Result<SurfaceResult<'_>, JobError> {
        self.check()?;
        let volume = self.volume()?;
        let mesh = level_surface(&volume, self.level, self.close);
        let mesh = mesh.map_err(|error| JobError::NoSurface {
            name: self.source.place.name(),
            error,
        })?;
        let model = Contents {
            mesh: &mesh,
            attributes: &Attributes::default(),
            document: None,
        };
        let (mut notes, bytes) = self.output.write(&model, self.precision)?;
        // Positions between nodes have no exact value that rounding could lose.
        notes.retain(|note| !note.starts_with("positions were rounded"));
        Ok(SurfaceResult {
            spec: self,
            dims: volume.dims,
            range: volume.range(),
            mesh,
            notes,
            bytes,
        })
    }

    fn volume(&self) -> Result<Volume, JobError> {
        let array = self.array.as_deref();
        match &self.source.place {
            Place::File(path) => Ok(read_volume_path(path, array)?),
            Place::Memory { name, .. } => {
                let volume = read_volume_bytes(&self.source.bytes, array);
                volume.map_err(|error| JobError::Bytes {
                    name: name.clone(),
                    error,
                })
            }
        }
    }
}

impl SurfaceResult<'_> {
    /// The document.
    pub fn document(&self) -> Document<impl Serialize> {
        let output = &self.spec.output;
        let body = Body {
            input: super::documents::shown(&self.spec.source.place),
            dims: self.dims,
            range: self.range,
            level: self.spec.level,
            output: FileInfo::new(&output.place, output.format, &self.mesh),
            notes: &self.notes,
        };
        Document::new("surface", body)
    }
}
