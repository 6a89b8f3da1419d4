//! Signed distance volumes of mesh files: measuring, writing as VTI, and the JSON document.

use glam::DVec3;
use serde::Serialize;

use super::staging::write_bytes;
use super::{Document, FileInfo, JobError, Place, Source};
use crate::io::{IoError, Loaded, Precision, volume_to_bytes};
use isomend_core::grid::Volume;
use isomend_core::volume::{Measured, MeasuredSeconds, VolumeParams, measure_volume};

/// The name of the signed distance array in a volume file.
#[doc(hidden)]
pub const DISTANCE: &str = "distance";

/// The signed distance volume of a mesh file.
#[non_exhaustive]
pub struct MeasuredFile {
    input: FileInfo,
    /// The volume, with run times and counts.
    pub measured: Measured,
}

/// Measures the signed distance of a mesh on a grid.
///
/// # Errors
/// [`JobError::Measure`] if the mesh cannot be measured, a parameter is invalid, or the volume would be too large.
pub fn measure(
    source: &Source,
    loaded: &Loaded,
    params: &VolumeParams,
) -> Result<MeasuredFile, JobError> {
    let place = &source.place;
    let measured = measure_volume(&loaded.mesh, params).map_err(|error| JobError::Measure {
        name: place.name(),
        error,
    })?;
    Ok(MeasuredFile {
        input: FileInfo::new(place, loaded.format, &loaded.mesh),
        measured,
    })
}

/// Writes a volume as VTI. Returns the bytes if the place is the caller's memory, else nothing.
///
/// # Errors
/// If a value is not finite or too large for its type, or if the file cannot be written.
pub fn write_volume(
    volume: &Volume,
    name: &str,
    precision: Precision,
    place: &Place,
) -> Result<Vec<u8>, JobError> {
    let in_place = |error: IoError| match place {
        Place::File(path) => JobError::Io(error.in_file(path)),
        Place::Memory { name, .. } => JobError::Bytes {
            name: name.clone(),
            error,
        },
    };
    let bytes = volume_to_bytes(volume, name, precision).map_err(in_place)?;
    match place {
        Place::File(path) => write_bytes(path, &bytes).map(|()| Vec::new()),
        Place::Memory { .. } => Ok(bytes),
    }
}

/// Run times of reading and writing the files of a volume, in seconds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct VolumeSeconds {
    /// Reading the mesh.
    pub reading: f64,
    /// Writing the volume.
    pub writing: f64,
    /// In total, including the measuring.
    pub total: f64,
}

/// The document of a signed distance volume.
#[derive(Serialize)]
struct VolumeBody<'a> {
    /// The input file.
    input: &'a FileInfo,
    /// The path of the written volume.
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<String>,
    /// The name of the array.
    array: &'static str,
    /// Numbers of nodes along the axes.
    dims: [usize; 3],
    /// Position of the first node.
    origin: DVec3,
    /// Distance between nodes.
    voxel: f64,
    /// Smallest and largest value.
    range: [f64; 2],
    /// Number of nodes whose distance is not cut off.
    measured: usize,
    /// Times by stage.
    seconds: VolumeTimesRow,
}

/// Run times of a signed distance volume, in seconds.
#[derive(Serialize)]
struct VolumeTimesRow {
    #[serde(flatten)]
    measuring: MeasuredSeconds,
    #[serde(flatten)]
    files: Option<VolumeSeconds>,
}

impl MeasuredFile {
    /// The JSON document. `written` is the place of the written volume and the run times of the files; `None` if it was not written.
    pub fn document(&self, written: Option<(&Place, VolumeSeconds)>) -> Document<impl Serialize> {
        let volume = &self.measured.volume;
        let body = VolumeBody {
            input: &self.input,
            output: written.map(|(place, _)| super::documents::shown(place)),
            array: DISTANCE,
            dims: volume.dims,
            origin: volume.origin,
            voxel: volume.spacing.x,
            range: volume.range(),
            measured: self.measured.nodes,
            seconds: VolumeTimesRow {
                measuring: self.measured.seconds,
                files: written.map(|(_, seconds)| seconds),
            },
        };
        Document::new("sdf", body)
    }
}
