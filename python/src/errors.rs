//! Conversion of the library's errors to the Python package's exceptions.

use std::error::Error;
use std::path::PathBuf;

use isomend::compare::CompareError;
use isomend::io::IoError;
use isomend::job::{JobError, with_causes};
use isomend::volume::VolumeError;
use isomend::{FairError, FillError, RestoreError, VolumeSurfaceError};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyType;

/// Why a call failed: the name of the exception class in `isomend._errors`, and the message.
#[derive(Debug)]
pub struct Failure {
    exception: &'static str,
    message: String,
    /// The file that could not be used, and the system's error number if it gave one.
    file: Option<(PathBuf, Option<i32>)>,
}

impl Failure {
    /// A failure that raises this exception with this message.
    pub fn new(exception: &'static str, message: impl Into<String>) -> Self {
        Self {
            exception,
            message: message.into(),
            file: None,
        }
    }

    /// A `ParameterError`.
    pub fn parameter(message: impl Into<String>) -> Self {
        Self::new("ParameterError", message)
    }

    fn of(exception: &'static str, error: &dyn Error) -> Self {
        Self::new(exception, with_causes(error))
    }
}

/// The file of an error, and the system's error number if it gave one.
fn file_of(error: &IoError) -> Option<(PathBuf, Option<i32>)> {
    match error {
        IoError::Read { path, cause } | IoError::Write { path, cause } => {
            Some((path.clone(), cause.raw_os_error()))
        }
        IoError::InFile { path, error } => {
            let number = file_of(error).and_then(|(_, number)| number);
            Some((path.clone(), number))
        }
        _ => None,
    }
}

/// The file of a job's error, and the system's error number that says the same.
fn file_of_job(error: &JobError) -> Option<(PathBuf, Option<i32>)> {
    // Numbers of POSIX, the same on all systems: no such file or folder; is a folder.
    const ENOENT: i32 = 2;
    const EISDIR: i32 = 21;
    match error {
        JobError::Io(error) => file_of(error),
        JobError::IsFolder { path } => Some((path.clone(), Some(EISDIR))),
        JobError::Unwritable { path, .. } => {
            let number = match path.is_dir() {
                true => EISDIR,
                false => ENOENT,
            };
            Some((path.clone(), Some(number)))
        }
        _ => None,
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        Python::attach(|py| {
            let class = || -> PyResult<Bound<'_, PyType>> {
                let errors = py.import("isomend._errors")?;
                Ok(errors.getattr(failure.exception)?.cast_into()?)
            };
            match class() {
                Ok(class) => {
                    let error = PyErr::from_type(class, failure.message.clone());
                    if let Some((path, number)) = &failure.file {
                        // As Python's own errors have them; the message stays.
                        let value = error.value(py);
                        let _ = value.setattr("filename", path.display().to_string());
                        let _ = value.setattr("errno", *number);
                    }
                    error
                }
                Err(_) => PyRuntimeError::new_err(failure.message.clone()),
            }
        })
    }
}

fn fill_exception(error: &FillError) -> &'static str {
    match error {
        FillError::Mesh(_) => "MeshError",
        FillError::NoSuchHole { .. } => "HoleIdError",
        FillError::Cancelled => "Cancelled",
        _ => "ParameterError",
    }
}

fn restore_exception(error: &RestoreError) -> &'static str {
    match error {
        RestoreError::Fill(error) => fill_exception(error),
        RestoreError::NothingMarked => "EmptyMaskError",
        _ => "ParameterError",
    }
}

fn fair_exception(error: &FairError) -> &'static str {
    match error {
        FairError::Restore(error) => restore_exception(error),
        FairError::NoSurface => "MeshError",
        _ => "ParameterError",
    }
}

impl From<FillError> for Failure {
    fn from(error: FillError) -> Self {
        Self::of(fill_exception(&error), &error)
    }
}

fn volume_exception(error: &VolumeError) -> &'static str {
    match error {
        VolumeError::Mesh(_) | VolumeError::NoSurface => "MeshError",
        _ => "ParameterError",
    }
}

fn compare_exception(error: &CompareError) -> &'static str {
    match error {
        CompareError::Empty { .. } => "MeshError",
        _ => "ParameterError",
    }
}

impl From<VolumeError> for Failure {
    fn from(error: VolumeError) -> Self {
        Self::of(volume_exception(&error), &error)
    }
}

impl From<VolumeSurfaceError> for Failure {
    fn from(error: VolumeSurfaceError) -> Self {
        Self::of("ParameterError", &error)
    }
}

impl From<IoError> for Failure {
    fn from(error: IoError) -> Self {
        Self {
            file: file_of(&error),
            ..Self::of("FileError", &error)
        }
    }
}

impl From<JobError> for Failure {
    fn from(error: JobError) -> Self {
        let exception = match &error {
            JobError::Fill(error)
            | JobError::Inspect { error, .. }
            | JobError::MaskMesh { error, .. } => fill_exception(error),
            JobError::Restore(error) => restore_exception(error),
            JobError::Fair(error) | JobError::FairObject { error, .. } => fair_exception(error),
            JobError::Measure { error, .. } => volume_exception(error),
            JobError::Compare { error, .. } => compare_exception(error),
            JobError::NothingMarked { .. } | JobError::NoMask | JobError::EmptyMask => {
                "EmptyMaskError"
            }
            JobError::Io(_)
            | JobError::Bytes { .. }
            | JobError::IsFolder { .. }
            | JobError::Unwritable { .. } => "FileError",
            JobError::TooManyVertices { .. } => "MeshError",
            _ => "ParameterError",
        };
        Self {
            file: file_of_job(&error),
            ..Self::of(exception, &error)
        }
    }
}
