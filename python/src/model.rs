//! Meshes with what they carry, from arrays and files.

use std::path::PathBuf;
use std::sync::Arc;

use isomend::io::{Contents, Format, Loaded, Precision};
use isomend::job::{Place, Source};
use isomend::mesh::Attributes;
use isomend::volume::signed_distances;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList};

use crate::arrays;
use crate::attributes::{self, Given};
use crate::errors::Failure;
use crate::found::Found;
use crate::mended::Mended;
use crate::spec::{format, output, spec, work};
use crate::worker;

/// What stands for the path of a mesh that is no file.
const NO_FILE: &str = "";

/// A mesh with what it carries.
#[pyclass(frozen, module = "isomend._isomend")]
pub struct Model {
    loaded: Arc<Loaded>,
    source: Place,
}

#[pymethods]
impl Model {
    /// A mesh from arrays.
    #[staticmethod]
    fn from_arrays(
        vertices: PyReadonlyArray2<'_, f64>,
        faces: PyReadonlyArray2<'_, i64>,
        point_data: Vec<Given<'_>>,
        cell_data: Vec<Given<'_>>,
    ) -> PyResult<Self> {
        let mesh = arrays::mesh(&vertices.as_array(), &faces.as_array())?;
        let given = |all: Vec<Given>| -> Result<Vec<_>, Failure> {
            all.iter().map(Given::attribute).collect()
        };
        let attributes = Attributes {
            vertex: given(point_data)?,
            face: given(cell_data)?,
            ..Attributes::default()
        };
        let loaded = Loaded {
            f32_exact: Precision::of(&mesh) == Precision::F32,
            mesh,
            format: Format::Ply,
            attributes,
            document: None,
            notes: Vec::new(),
        };
        Ok(Self {
            loaded: Arc::new(loaded),
            source: Place::Bytes(NO_FILE.to_owned()),
        })
    }

    /// A mesh from a file.
    #[staticmethod]
    #[pyo3(signature = (path, from_format))]
    fn read(py: Python<'_>, path: PathBuf, from_format: Option<&str>) -> PyResult<Self> {
        let mut source = Source::from(path);
        source.format = format(from_format)?;
        let place = source.place.clone();
        let loaded = worker::run(py, None, None, move |_| Ok(source.read()?))?;
        Ok(Self {
            loaded: Arc::new(loaded),
            source: place,
        })
    }

    /// A mesh from the bytes of a file.
    #[staticmethod]
    fn read_bytes(py: Python<'_>, bytes: &[u8], from_format: Option<&str>) -> PyResult<Self> {
        let mut source = Source::bytes("bytes", bytes.to_vec());
        source.format = format(from_format)?;
        let place = source.place.clone();
        let loaded = worker::run(py, None, None, move |_| Ok(source.read()?))?;
        Ok(Self {
            loaded: Arc::new(loaded),
            source: place,
        })
    }

    /// A mended mesh as one that can be mended again.
    #[staticmethod]
    fn of(py: Python<'_>, mended: &Mended) -> PyResult<Self> {
        Ok(Self {
            loaded: Arc::new(mended.loaded(py)?),
            source: mended.source().clone(),
        })
    }

    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::rows_of_f64(py, self.loaded.mesh.positions.iter().map(|p| p.to_array()))
    }

    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        arrays::rows_of_i64(py, self.loaded.mesh.faces.iter().copied())
    }

    fn size(&self) -> [usize; 2] {
        let mesh = &self.loaded.mesh;
        [mesh.positions.len(), mesh.faces.len()]
    }

    fn point_data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        attributes::list(py, &self.loaded.attributes.vertex)
    }

    fn cell_data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        attributes::list(py, &self.loaded.attributes.face)
    }

    fn corner_data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        attributes::corner_list(py, &self.loaded.attributes.corner)
    }

    fn notes(&self) -> Vec<String> {
        self.loaded.notes.clone()
    }

    /// What the mesh holds.
    fn inspect(&self, py: Python<'_>) -> PyResult<Found> {
        let loaded = self.loaded.clone();
        let place = self.source.clone();
        worker::run(py, None, None, move |_| Found::new(loaded, place))
    }

    /// What the work would do, as JSON.
    fn plan(&self, py: Python<'_>, json: &str) -> PyResult<String> {
        let spec = spec(&self.source, work(json)?);
        let loaded = self.loaded.clone();
        worker::run(py, None, None, move |_| {
            spec.work.check()?;
            let planned = spec.with((*loaded).clone()).plan()?;
            serde_json::to_string(&planned.document())
                .map_err(|error| Failure::new("IsomendError", error.to_string()))
        })
    }

    /// Does the work that the JSON tells.
    #[pyo3(signature = (json, threads, progress))]
    fn mend(
        &self,
        py: Python<'_>,
        json: &str,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Mended> {
        let spec = spec(&self.source, work(json)?);
        let loaded = self.loaded.clone();
        worker::run(py, threads, progress, move |control| {
            spec.work.check()?;
            let mended = spec.with(Arc::unwrap_or_clone(loaded)).mend(control)?;
            Ok(Mended::new(mended.into_owned()))
        })
    }

    /// Writes it as it is; remarks, and the bytes where there is no path.
    #[pyo3(signature = (path, to, ascii))]
    fn write<'py>(
        &self,
        py: Python<'py>,
        path: Option<PathBuf>,
        to: Option<&str>,
        ascii: bool,
    ) -> PyResult<(Vec<String>, Bound<'py, PyBytes>)> {
        let output = output(path, to, ascii)?;
        let loaded = self.loaded.clone();
        let (notes, bytes) = worker::run(py, None, None, move |_| {
            let precision = match loaded.f32_exact {
                true => Precision::F32,
                false => Precision::F64,
            };
            let contents = Contents {
                mesh: &loaded.mesh,
                attributes: &loaded.attributes,
                document: loaded.document.as_ref(),
            };
            Ok(output.write(&contents, precision)?)
        })?;
        Ok((notes, PyBytes::new(py, &bytes)))
    }
}

/// Signed distances of points from a mesh.
#[pyfunction]
#[pyo3(signature = (points, vertices, faces, threads))]
pub fn signed_distance<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let mesh = arrays::mesh(&vertices.as_array(), &faces.as_array())?;
    let points = arrays::points(&points.as_array())?;
    let work = move |_: &isomend::Control| Ok(signed_distances(&mesh, &points)?);
    let distances = worker::run(py, threads, None, work)?;
    Ok(PyArray1::from_vec(py, distances))
}
