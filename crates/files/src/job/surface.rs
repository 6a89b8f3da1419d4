//! Extracts the surface at a level of a volume file and writes it as a mesh file.

use serde::Serialize;

use super::{Document, FileInfo, JobError, Output, Place, Source};
use crate::io::{Contents, Format, Precision, read_volume_bytes, read_volume_path};
use isomend_core::extract::level_surface;
use isomend_core::grid::Volume;
use isomend_core::mesh::{Attributes, Mesh};

/// The extraction of a level surface from a volume file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfaceSpec {
    /// The volume to read: VTI, or VTK legacy structured points.
    pub source: Source,
    /// The name of the point data array, if the file has several.
    pub array: Option<String>,
    /// The level, in units of the array. Values below it are inside.
    pub level: f64,
    /// Close the surface by planar caps at the faces of the volume's box.
    pub close: bool,
    /// The output for the mesh.
    pub output: Output,
    /// The float type of the coordinates, in formats that have a choice.
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
    /// The bytes of the file, if the output is the caller's memory; else empty.
    pub bytes: Vec<u8>,
}

/// The document of an extracted surface.
#[derive(Serialize)]
struct SurfaceBody<'a> {
    /// The path of the volume.
    input: String,
    /// Numbers of nodes along the axes.
    dims: [usize; 3],
    /// Smallest and largest value.
    range: [f64; 2],
    /// The level of the surface.
    level: f64,
    /// The written file.
    output: FileInfo,
    /// Remarks.
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

    /// Checks output and precision without reading the volume.
    ///
    /// # Errors
    /// As [`Output::check`], and [`JobError::No64Bit`].
    pub fn check(&self) -> Result<(), JobError> {
        self.output.check()?;
        let format = self.output.format;
        match self.precision == Precision::F64 && format.is_single() {
            true => Err(JobError::No64Bit { format }),
            false => Ok(()),
        }
    }

    /// Reads the volume, extracts the surface and writes it.
    ///
    /// # Errors
    /// If the volume cannot be read or has no surface at the level, or if the mesh cannot be written.
    pub fn run(&self) -> Result<SurfaceResult<'_>, JobError> {
        self.check()?;
        let volume = self.volume()?;
        let mesh = level_surface(&volume, self.level, self.close);
        let mut mesh = mesh.map_err(|error| JobError::NoSurface {
            name: self.source.place.name(),
            error,
        })?;
        // Rounded here, without a remark: interpolated positions have no exact values that rounding could lose.
        if self.precision == Precision::F32 && has_floats(&self.output) {
            let rounded = mesh.positions.iter().map(|p| p.as_vec3().as_dvec3());
            mesh.positions = rounded.collect();
        }
        let model = Contents {
            mesh: &mesh,
            attributes: &Attributes::default(),
            document: None,
        };
        let (notes, bytes) = self.output.write(&model, self.precision)?;
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
    /// The JSON document of the extraction.
    pub fn document(&self) -> Document<impl Serialize> {
        let output = &self.spec.output;
        let body = SurfaceBody {
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

/// Whether a file can hold coordinates as 32-bit floats: OBJ, OFF, 3MF and STL as text have decimal numbers only.
fn has_floats(output: &Output) -> bool {
    match output.format {
        Format::Obj | Format::Off | Format::ThreeMf => false,
        Format::Stl => !output.ascii,
        _ => true,
    }
}
