//! A mended mesh.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use isomend::io::Loaded;
use isomend::job;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList};

use crate::arrays;
use crate::attributes;
use crate::drawings::{call, drawings};
use crate::errors::Failure;
use crate::packed::{json_of, packed, unpacked};
use crate::spec::{deliverables, output};
use crate::worker;

/// A mended mesh.
#[pyclass(frozen, module = "isomend._isomend")]
pub struct Mended {
    mended: Arc<job::Mended<'static>>,
    /// The mesh with what it carries, made when it is first asked for.
    model: OnceLock<isomend::Model>,
    source: job::Place,
}

/// Which vertices and faces were kept, if not all.
type KeptArrays<'py> = Option<(Bound<'py, PyArray1<bool>>, Bound<'py, PyArray1<bool>>)>;

impl Mended {
    /// What a job made.
    pub fn new(mended: job::Mended<'static>) -> Self {
        Self {
            source: mended.source().clone(),
            mended: Arc::new(mended),
            model: OnceLock::new(),
        }
    }

    fn model(&self, py: Python<'_>) -> PyResult<&isomend::Model> {
        if self.model.get().is_none() {
            let mended = self.mended.clone();
            let model = worker::run(py, None, None, move |_| Ok(mended.model()))?;
            // Another thread may have been faster, with the same.
            let _ = self.model.set(model);
        }
        let missing = || Failure::new("IsomendError", "the mesh could not be made").into();
        self.model.get().ok_or_else(missing)
    }

    /// Where its input came from.
    pub fn source(&self) -> &job::Place {
        &self.source
    }

    /// What the job made.
    pub fn made(&self) -> Arc<job::Mended<'static>> {
        self.mended.clone()
    }

    /// It as if it had been read.
    pub fn loaded(&self, py: Python<'_>) -> PyResult<Loaded> {
        let model = self.model(py)?;
        let first = self.mended.first();
        let whole = self.mended.kept_size() == [0, 0];
        Ok(Loaded {
            mesh: model.mesh.clone(),
            format: first.format,
            f32_exact: isomend::io::Precision::of(&model.mesh) == isomend::io::Precision::F32,
            attributes: model.attributes.clone(),
            document: first.document.clone().filter(|_| !whole),
            notes: first.notes.clone(),
        })
    }
}

#[pymethods]
impl Mended {
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let positions = &self.model(py)?.mesh.positions;
        arrays::rows_of_f64(py, positions.iter().map(|p| p.to_array()))
    }

    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        arrays::rows_of_i64(py, self.model(py)?.mesh.faces.iter().copied())
    }

    fn size(&self, py: Python<'_>) -> PyResult<[usize; 2]> {
        let mesh = &self.model(py)?.mesh;
        Ok([mesh.positions.len(), mesh.faces.len()])
    }

    fn point_data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        attributes::list(py, &self.model(py)?.attributes.vertex)
    }

    fn cell_data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        attributes::list(py, &self.model(py)?.attributes.face)
    }

    fn corner_data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        attributes::corner_list(py, &self.model(py)?.attributes.corner)
    }

    fn notes(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let model = self.model(py)?;
        Ok([&self.mended.first().notes[..], &model.notes].concat())
    }

    /// How many of its vertices and faces, from the first on, are the input's.
    fn kept_size(&self) -> [usize; 2] {
        self.mended.kept_size()
    }

    /// For each vertex and each face of the input whether it is kept; none where all or none are.
    fn kept<'py>(&self, py: Python<'py>) -> KeptArrays<'py> {
        let kept = self.mended.kept()?;
        let array = |marks: &[bool]| PyArray1::from_slice(py, marks);
        Some((array(&kept.vertices), array(&kept.faces)))
    }

    /// For each vertex its expected error: 0 for those of the input, NaN where nothing can be said.
    fn expected_error<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let mut expected_error = vec![0.0; self.model(py)?.mesh.positions.len()];
        let own = expected_error.iter_mut().skip(self.mended.kept_size()[0]);
        let made = self.mended.new_vertices();
        let told = self.mended.expected_error().iter().copied();
        let told = told.chain(std::iter::repeat(None)).take(made);
        for (value, told) in own.zip(told) {
            *value = told.unwrap_or(f64::NAN);
        }
        Ok(PyArray1::from_vec(py, expected_error))
    }

    /// The same with this handed on beside it, and reported so.
    fn delivering(
        &self,
        patches: Option<PathBuf>,
        piece: Option<PathBuf>,
        mark: Option<&str>,
        unit: Option<&str>,
        tolerance: Option<f64>,
        texture: bool,
    ) -> PyResult<Self> {
        let mut wanted = deliverables([patches, piece], mark, unit, tolerance)?;
        wanted.no_texture = !texture;
        let mended = (*self.mended).clone().delivering(wanted);
        Ok(Self::new(mended.map_err(Failure::from)?))
    }

    fn document(&self) -> PyResult<String> {
        Ok(json_of(&self.mended.document())?)
    }

    fn flawless(&self) -> bool {
        self.mended.report.flawless()
    }

    fn complete(&self) -> bool {
        self.mended.complete()
    }

    /// All of it as bytes.
    fn packed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mended = self.mended.clone();
        let bytes = worker::run(py, None, None, move |_| packed(&*mended))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The same from its bytes.
    #[staticmethod]
    fn unpacked(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        let bytes = bytes.to_vec();
        worker::run(py, None, None, move |_| {
            let mended: job::Mended = unpacked(&bytes, "result")?;
            Ok(Self::new(mended.into_owned()))
        })
    }

    /// The page of the command.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let mended = self.mended.clone();
        let call = call(mended.command());
        worker::run(py, None, None, move |_| Ok(mended.page(&call)?))
    }

    /// The picture of the command.
    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mended = self.mended.clone();
        let bytes = worker::run(py, None, None, move |_| Ok(mended.picture()?))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Writes it, and where they are wanted its page and its picture; remarks, and the bytes where there is no path.
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
        let mended = self.mended.clone();
        let drawings = drawings(mended.command(), page, picture, &self.source, &output)?;
        let (notes, bytes) = worker::run(py, None, None, move |_| {
            let result = (*mended).clone().drawn(drawings).to(output).write()?;
            Ok((result.notes_written().to_vec(), result.bytes))
        })?;
        Ok((notes, PyBytes::new(py, &bytes)))
    }
}
