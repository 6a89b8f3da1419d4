//! Meshes with their attributes, from arrays and files.

use std::path::PathBuf;
use std::sync::Arc;

use isomend::Attributes;
use isomend::Mesh;
use isomend::io::Loaded;
use isomend::job::{Place, Source, Work};
use isomend::volume::signed_distances;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList};

use crate::arrays;
use crate::attributes::{self, Given};
use crate::drawings::drawings;
use crate::errors::Failure;
use crate::inspection::Found;
use crate::mended::Mended;
use crate::packed::{json_of, packed, unpacked};
use crate::spec::{format, output, spec, work};
use crate::worker;

/// The name, in messages, of a mesh that was not read from a file.
const NO_FILE: &str = "the mesh";

/// A mesh with its attributes, format, remarks and, if it was read from a glTF file, the rest of that file.
#[pyclass(frozen, module = "isomend._isomend")]
pub struct Model {
    loaded: Arc<Loaded>,
    source: Place,
}

impl Model {
    /// A mesh with attributes that was not read from a file.
    fn made(mesh: Mesh, attributes: Attributes) -> Self {
        Self {
            loaded: Arc::new(Loaded::in_memory(mesh, attributes)),
            source: Place::memory(NO_FILE),
        }
    }

    /// A mesh with attributes, from the library's type.
    pub fn of_model(model: isomend::Model) -> Self {
        Self::made(model.mesh, model.attributes)
    }

    /// A mesh without attributes.
    pub fn of_mesh(mesh: Mesh) -> Self {
        Self::made(mesh, Attributes::default())
    }

    /// The mesh with its attributes.
    pub fn loaded(&self) -> &Arc<Loaded> {
        &self.loaded
    }

    /// Where the mesh came from.
    pub fn source(&self) -> &Place {
        &self.source
    }
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
        Ok(Self::made(mesh, attributes))
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
            loaded,
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
            loaded,
            source: place,
        })
    }

    /// A mended mesh as the input of further work.
    #[staticmethod]
    fn of(py: Python<'_>, mended: &Mended) -> PyResult<Self> {
        Ok(Self {
            loaded: Arc::new(mended.loaded(py)?),
            source: mended.source().clone(),
        })
    }

    /// The patches of a mended mesh as a mesh of their own.
    #[staticmethod]
    fn patches_of(py: Python<'_>, mended: &Mended) -> PyResult<Self> {
        let made = mended.made();
        worker::run(py, None, None, move |_| Ok(Self::of_model(made.patches())))
    }

    /// The missing piece: the solid between the faces that a restoration cut out and its patches.
    #[staticmethod]
    fn piece_of(py: Python<'_>, mended: &Mended) -> PyResult<Self> {
        let made = mended.made();
        worker::run(py, None, None, move |control| {
            Ok(Self::of_model(made.piece(control)?))
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
        attributes::list_with_errors(py, &self.loaded.attributes.vertex)
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

    /// Inspects the mesh: holes, defects, crease ends.
    fn inspect(&self, py: Python<'_>) -> PyResult<Found> {
        let loaded = self.loaded.clone();
        let place = self.source.clone();
        worker::run(py, None, None, move |control| {
            Found::new(loaded, place, control)
        })
    }

    /// What the work would do (a dry run), as JSON.
    fn plan(&self, py: Python<'_>, json: &str) -> PyResult<String> {
        let spec = spec(&self.source, work(json)?);
        let loaded = self.loaded.clone();
        worker::run(py, None, None, move |_| {
            spec.work.check()?;
            let planned = spec.with(loaded).plan()?;
            json_of(&planned.document())
        })
    }

    /// Does the work that the JSON describes, such as `{"fill": {}}`.
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
            let mended = spec.with(loaded).mend(control)?;
            Ok(Mended::new(mended.into_owned().judged()?))
        })
    }

    /// The mesh as bytes, for pickling.
    fn packed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let (loaded, source) = (self.loaded.clone(), self.source.clone());
        let bytes = worker::run(py, None, None, move |_| packed(&(&*loaded, source)))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// A mesh from the bytes of `packed`.
    #[staticmethod]
    fn unpacked(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        let bytes = bytes.to_vec();
        let read = move |_: &isomend::Control| unpacked::<(Loaded, Place)>(&bytes, "mesh");
        let (loaded, source) = worker::run(py, None, None, read)?;
        Ok(Self {
            loaded: Arc::new(loaded),
            source,
        })
    }

    /// Writes the mesh unchanged, and its page and picture if they have paths. Returns remarks, and the bytes of the mesh if `path` is
    /// none.
    #[pyo3(signature = (path, to, ascii, page, picture))]
    fn write<'py>(
        &self,
        py: Python<'py>,
        path: Option<PathBuf>,
        to: Option<&str>,
        ascii: bool,
        page: Option<PathBuf>,
        picture: Option<PathBuf>,
    ) -> PyResult<(Vec<String>, Bound<'py, PyBytes>)> {
        let output = output(path, to, ascii)?;
        let drawings = drawings("convert", page, picture, &self.source, &output)?;
        let spec = spec(&self.source, Work::Copy);
        let loaded = self.loaded.clone();
        let (notes, bytes) = worker::run(py, None, None, move |control| {
            let copied = spec.with(loaded).mend(control)?;
            let result = copied.drawn(drawings).to(output).write()?;
            Ok((result.notes_written().to_vec(), result.bytes))
        })?;
        Ok((notes, PyBytes::new(py, &bytes)))
    }
}

/// Signed distances of points (k, 3) from a mesh, negative inside.
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
