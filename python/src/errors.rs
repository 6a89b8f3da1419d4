//! Conversion of the library's errors to the Python package's exceptions.

use std::error::Error;

use isomend::compare::CompareError;
use isomend::io::IoError;
use isomend::job::JobError;
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
}

impl Failure {
    /// A failure that raises this exception with this message.
    pub fn new(exception: &'static str, message: impl Into<String>) -> Self {
        let message = message.into();
        Self { exception, message }
    }

    /// A `ParameterError`.
    pub fn parameter(message: impl Into<String>) -> Self {
        Self::new("ParameterError", message)
    }

    fn of(exception: &'static str, error: &dyn Error) -> Self {
        let mut message = error.to_string();
        let mut source = error.source();
        while let Some(cause) = source {
            message += &format!(": {cause}");
            source = cause.source();
        }
        Self { exception, message }
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
                Ok(class) => PyErr::from_type(class, failure.message.clone()),
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
        Self::of("FileError", &error)
    }
}

impl From<JobError> for Failure {
    fn from(error: JobError) -> Self {
        let exception = match &error {
            JobError::Fill(error)
            | JobError::Inspect { error, .. }
            | JobError::MaskMesh { error, .. } => fill_exception(error),
            JobError::Restore(error) => restore_exception(error),
            JobError::Fair(error) => fair_exception(error),
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
        Self::of(exception, &error)
    }
}
