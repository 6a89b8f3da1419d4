//! Reads meshes from files, from bytes, or takes meshes that are in memory.

use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::hash::sha256;
use super::texels::{PATCH_LIBRARY, PATCH_MATERIAL};
use super::{JobError, Place};
use crate::io::{Format, IoError, Loaded, beside, bytes_of, no_side_files, read_as, read_bytes};

/// The source of a mesh: a file, bytes in memory, or a mesh in memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// The file, or the name of the memory in messages.
    pub place: Place,
    /// The bytes, if the source is bytes in memory.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bytes: Vec<u8>,
    /// The mesh, if it is in memory already. It is shared, not copied, and not serialized.
    #[serde(skip)]
    pub mesh: Option<Arc<Loaded>>,
    /// The format. Default: detected from the content, else from the extension.
    pub format: Option<Format>,
}

impl Source {
    /// Bytes in memory, with their name in messages.
    pub fn bytes(name: impl Into<String>, bytes: Vec<u8>) -> Self {
        Self {
            bytes,
            ..Self::from(Place::memory(name))
        }
    }

    /// A mesh in memory, and the place that it came from.
    pub fn mesh(place: impl Into<Place>, mesh: impl Into<Arc<Loaded>>) -> Self {
        Self {
            mesh: Some(mesh.into()),
            ..Self::from(place)
        }
    }

    /// Reads the mesh; a mesh in memory is shared.
    ///
    /// # Errors
    /// If the source cannot be read, its format is not supported, or its content is damaged or contains no surface.
    pub fn read(&self) -> Result<Arc<Loaded>, JobError> {
        Ok(self.read_hashed()?.0)
    }

    /// Reads the mesh, with the SHA-256 of the file or the bytes; a mesh in memory has no hash.
    pub(super) fn read_hashed(&self) -> Result<(Arc<Loaded>, Option<String>), JobError> {
        let mut hash = None;
        let loaded = match (&self.mesh, &self.place) {
            (Some(mesh), _) => mesh.clone(),
            (None, Place::File(path)) if path.is_dir() => {
                let path = path.clone();
                return Err(JobError::IsFolder { path });
            }
            (None, Place::File(path)) => {
                let bytes = bytes_of(path)?;
                hash = Some(sha256(&bytes));
                Arc::new(read_as(path, &bytes, self.format, &beside(path))?)
            }
            (None, Place::Memory { name, folder }) => {
                hash = Some(sha256(&self.bytes));
                let read = self.read_bytes(folder.as_deref());
                Arc::new(read.map_err(|error| JobError::Bytes {
                    name: name.clone(),
                    error,
                })?)
            }
        };
        let vertices = u32::try_from(loaded.mesh.positions.len());
        match vertices {
            Ok(n) if n < u32::MAX / 4 => Ok((loaded, hash)),
            _ => Err(JobError::TooManyVertices {
                name: self.place.name(),
            }),
        }
    }

    fn read_bytes(&self, folder: Option<&Path>) -> Result<Loaded, IoError> {
        let format = match self.format {
            Some(format) => format,
            None => Format::detect(&self.bytes, Path::new(""))?,
        };
        let Some(folder) = folder else {
            return read_bytes(&self.bytes, format, &no_side_files);
        };
        let inside = folder.join("mesh");
        let beside = beside(&inside);
        // The material file of patches need not exist in memory: its content is known.
        let resolve = |name: &str, most| match (beside(name, most), name) {
            (Err(_), PATCH_LIBRARY) => Ok(PATCH_MATERIAL.as_bytes().to_vec()),
            (found, _) => found,
        };
        read_bytes(&self.bytes, format, &resolve)
    }
}

impl<P: Into<Place>> From<P> for Source {
    fn from(place: P) -> Self {
        Self {
            place: place.into(),
            bytes: Vec::new(),
            mesh: None,
            format: None,
        }
    }
}
