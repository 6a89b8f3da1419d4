//! Volumes (values on a lattice): signed distances of meshes, level surfaces, VTI files.

use std::path::PathBuf;
use std::sync::Arc;

use isomend::glam::DVec3;
use isomend::io::{Precision, read_volume_bytes, read_volume_path};
use isomend::job::{self, Place, Source};
use isomend::level_surface;
use isomend::volume::VolumeParams;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::Failure;
use crate::model::Model;
use crate::packed::json_of;
use crate::worker;

/// Values on the nodes of a box-shaped lattice.
#[pyclass(frozen, module = "isomend._isomend")]
pub struct Volume {
    volume: Arc<isomend::Volume>,
    /// The JSON document of `isomend sdf`; none if the volume was not measured from a mesh.
    document: Option<String>,
}

/// Measures the signed distance of a mesh on a lattice; the parameters are JSON, such as `{"band": 2.0}`.
#[pyfunction]
#[pyo3(signature = (model, params, threads))]
pub fn sdf(
    py: Python<'_>,
    model: &Model,
    params: &str,
    threads: Option<usize>,
) -> PyResult<Volume> {
    let params: VolumeParams =
        serde_json::from_str(params).map_err(|e| Failure::parameter(e.to_string()))?;
    let (source, loaded) = (Source::from(model.source().clone()), model.loaded().clone());
    worker::run(py, threads, None, move |_| {
        let done = job::measure(&source, &loaded, &params)?;
        let document = Some(json_of(&done.document(None))?);
        let volume = Arc::new(done.measured.volume);
        Ok(Volume { volume, document })
    })
}

#[pymethods]
impl Volume {
    /// A volume from its values, x running fastest.
    #[staticmethod]
    fn from_arrays(
        values: PyReadonlyArray1<'_, f64>,
        dims: [usize; 3],
        origin: [f64; 3],
        spacing: [f64; 3],
    ) -> PyResult<Self> {
        let values: Vec<f64> = values.as_array().iter().copied().collect();
        let nodes = dims
            .iter()
            .try_fold(1usize, |all, n| all.checked_mul(*n))
            .filter(|n| *n == values.len());
        if nodes.is_none() {
            let what = format!(
                "a volume of {dims:?} nodes was given {} values; one for each node is needed",
                values.len()
            );
            return Err(Failure::parameter(what).into());
        }
        let volume = Arc::new(isomend::Volume {
            dims,
            origin: DVec3::from(origin),
            spacing: DVec3::from(spacing),
            values,
        });
        Ok(Self {
            volume,
            document: None,
        })
    }

    /// A volume from a file; `array` names the point data to take if there are several.
    #[staticmethod]
    #[pyo3(signature = (path, array))]
    fn read(py: Python<'_>, path: PathBuf, array: Option<String>) -> PyResult<Self> {
        let read = move |_: &isomend::Control| Ok(read_volume_path(&path, array.as_deref())?);
        Ok(Self {
            volume: Arc::new(worker::run(py, None, None, read)?),
            document: None,
        })
    }

    /// A volume from the bytes of a file.
    #[staticmethod]
    #[pyo3(signature = (bytes, array))]
    fn read_bytes(py: Python<'_>, bytes: &[u8], array: Option<String>) -> PyResult<Self> {
        let bytes = bytes.to_vec();
        let read = move |_: &isomend::Control| Ok(read_volume_bytes(&bytes, array.as_deref())?);
        Ok(Self {
            volume: Arc::new(worker::run(py, None, None, read)?),
            document: None,
        })
    }

    /// The values, x running fastest.
    fn values<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.volume.values)
    }

    fn dims(&self) -> [usize; 3] {
        self.volume.dims
    }

    fn origin(&self) -> [f64; 3] {
        self.volume.origin.to_array()
    }

    fn spacing(&self) -> [f64; 3] {
        self.volume.spacing.to_array()
    }

    fn document(&self) -> Option<&str> {
        self.document.as_deref()
    }

    /// The surface at a level; `close` adds flat caps where it ends at the faces of the lattice.
    fn surface(
        &self,
        py: Python<'_>,
        level: f64,
        close: bool,
        threads: Option<usize>,
    ) -> PyResult<Model> {
        let volume = self.volume.clone();
        worker::run(py, threads, None, move |_| {
            let mesh = level_surface(&volume, level, close)?;
            Ok(Model::of_mesh(mesh))
        })
    }

    /// Writes a VTI file; returns its bytes if there is no path.
    #[pyo3(signature = (path, name, f64))]
    fn write<'py>(
        &self,
        py: Python<'py>,
        path: Option<PathBuf>,
        name: String,
        f64: bool,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let place = path.map_or(Place::memory("bytes"), Place::File);
        place.check_writable().map_err(Failure::from)?;
        let precision = match f64 {
            true => Precision::F64,
            false => Precision::F32,
        };
        let volume = self.volume.clone();
        let bytes = worker::run(py, None, None, move |_| {
            Ok(job::write_volume(&volume, &name, precision, &place)?)
        })?;
        Ok(PyBytes::new(py, &bytes))
    }
}
