//! Signed distance volumes of mesh files.

use glam::DVec3;
use serde::Serialize;

use super::output::write_bytes;
use super::{Document, FileInfo, JobError, Place, Source};
use crate::grid::Volume;
use crate::io::{IoError, Loaded, Precision, volume_to_bytes};
use crate::volume::{Measured, MeasuredSeconds, VolumeParams, measure_volume};

/// The name of the array of a signed distance in a volume file.
pub const DISTANCE: &str = "distance";

/// The signed distance volume of a mesh file.
#[non_exhaustive]
pub struct MeasuredFile {
    input: FileInfo,
    /// The volume and what it took.
    pub measured: Measured,
}

/// Measures the signed distance of a mesh that was read.
///
/// # Errors
/// [`JobError::Measure`] when the mesh or the parameters make no sense, or the volume would be too large.
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

/// Writes a volume as VTI: its bytes, where they are the caller's.
///
/// # Errors
/// When a value is not finite or too large for its type, or the file cannot be written.
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

/// What the files of a volume took, in seconds of the clock.
#[derive(Clone, Copy, Debug, Serialize)]
#[non_exhaustive]
pub struct VolumeSeconds {
    /// Reading the mesh.
    pub reading: f64,
    /// Writing the volume.
    pub writing: f64,
    /// In all, with the measuring.
    pub total: f64,
}

#[derive(Serialize)]
struct Body<'a> {
    input: &'a FileInfo,
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<String>,
    array: &'static str,
    dims: [usize; 3],
    origin: DVec3,
    voxel: f64,
    range: [f64; 2],
    /// Nodes whose distance is not cut off.
    measured: usize,
    seconds: Seconds,
}

#[derive(Serialize)]
struct Seconds {
    #[serde(flatten)]
    measuring: MeasuredSeconds,
    #[serde(flatten)]
    files: Option<VolumeSeconds>,
}

impl MeasuredFile {
    /// The document. `written` is where the volume went and what its files took; none where it was not written.
    pub fn document(&self, written: Option<(&Place, VolumeSeconds)>) -> Document<impl Serialize> {
        let volume = &self.measured.volume;
        let body = Body {
            input: &self.input,
            output: written.map(|(place, _)| super::documents::shown(place)),
            array: DISTANCE,
            dims: volume.dims,
            origin: volume.origin,
            voxel: volume.spacing.x,
            range: volume.range(),
            measured: self.measured.nodes,
            seconds: Seconds {
                measuring: self.measured.seconds,
                files: written.map(|(_, seconds)| seconds),
            },
        };
        Document::new("sdf", body)
    }
}
