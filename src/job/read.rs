//! Reading.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::output::{PATCH_LIBRARY, PATCH_MATERIAL};
use super::{JobError, Place};
use crate::io::{Format, Loaded, beside, no_side_files, read_as, read_bytes, read_path};

/// What is read: a file, or bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// Where it comes from.
    pub place: Place,
    /// The bytes, where it is no file; of a file that has not been written those that it would hold.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bytes: Vec<u8>,
    /// Its format; told from the content, else from the extension, where none is given.
    pub format: Option<Format>,
}

impl Source {
    /// Bytes, with their name in messages.
    pub fn bytes(name: impl Into<String>, bytes: Vec<u8>) -> Self {
        Self {
            place: Place::Bytes(name.into()),
            bytes,
            format: None,
        }
    }

    /// Reads the mesh.
    ///
    /// # Errors
    /// When it cannot be read, its format is not supported, or its content is damaged or holds no surface.
    pub fn read(&self) -> Result<Loaded, JobError> {
        let loaded = match &self.place {
            Place::File(path) if path.is_dir() => {
                let path = path.clone();
                return Err(JobError::IsFolder { path });
            }
            Place::File(path) if self.bytes.is_empty() => read_path(path, self.format)?,
            Place::File(path) => {
                let beside = beside(path);
                // The material of patches is written together with the mesh, unless it is there.
                let resolve = |name: &str, most| match (beside(name, most), name) {
                    (Err(_), PATCH_LIBRARY) => Ok(PATCH_MATERIAL.as_bytes().to_vec()),
                    (found, _) => found,
                };
                read_as(path, &self.bytes, self.format, &resolve)?
            }
            Place::Bytes(name) => {
                let told = match self.format {
                    Some(format) => Ok(format),
                    None => Format::detect(&self.bytes, Path::new("")),
                };
                let read = told.and_then(|f| read_bytes(&self.bytes, f, &no_side_files));
                read.map_err(|error| JobError::Bytes {
                    name: name.clone(),
                    error,
                })?
            }
        };
        let vertices = u32::try_from(loaded.mesh.positions.len());
        match vertices {
            Ok(n) if n < u32::MAX / 4 => Ok(loaded),
            _ => Err(JobError::TooManyVertices {
                name: self.place.name(),
            }),
        }
    }
}

impl<P: Into<Place>> From<P> for Source {
    fn from(place: P) -> Self {
        Self {
            place: place.into(),
            bytes: Vec::new(),
            format: None,
        }
    }
}
