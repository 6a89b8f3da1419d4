//! The result of a fill, repair, restoration or fairing: the mended mesh, its attributes, report, page and picture.

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
use crate::remarks;
use crate::spec::{deliverables, output};
use crate::worker;

/// The result of a job that mends a mesh.
#[pyclass(frozen, module = "isomend._isomend")]
pub struct Mended {
    mended: Arc<job::Mended<'static>>,
    /// The mesh with its attributes, made on first use.
    model: OnceLock<isomend::Model>,
    source: job::Place,
}

/// For each vertex and each face of the input whether it was kept.
type KeptArrays<'py> = Option<(Bound<'py, PyArray1<bool>>, Bound<'py, PyArray1<bool>>)>;

impl Mended {
    /// Wraps a job's result.
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
            // Another thread may have set it meanwhile, to the same value.
            let _ = self.model.set(model);
        }
        let missing = || Failure::new("IsomendError", "the mended mesh could not be built").into();
        self.model.get().ok_or_else(missing)
    }

    /// Where the input came from.
    pub fn source(&self) -> &job::Place {
        &self.source
    }

    /// The job's result.
    pub fn made(&self) -> Arc<job::Mended<'static>> {
        self.mended.clone()
    }

    /// The mended mesh in the form of a mesh that was read, so that it can be mended again.
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
        let remarks = remarks::remarks(&self.mended);
        Ok([&self.mended.first().notes[..], &model.notes, &remarks].concat())
    }

    /// Number of leading vertices and of leading faces that are the input's.
    fn kept_size(&self) -> [usize; 2] {
        self.mended.kept_size()
    }

    /// For each vertex and each face of the input whether it is kept; nothing if all or none are.
    fn kept<'py>(&self, py: Python<'py>) -> KeptArrays<'py> {
        let kept = self.mended.kept()?;
        let array = |marks: &[bool]| PyArray1::from_slice(py, marks);
        Some((array(&kept.vertices), array(&kept.faces)))
    }

    /// For each vertex the expected error in the mesh's units: 0 for vertices of the input, NaN where there is no estimate.
    #[pyo3(name = "sigma")]
    fn expected_error<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let vertices = self.model(py)?.mesh.positions.len();
        Ok(PyArray1::from_vec(
            py,
            self.mended.expected_errors(vertices),
        ))
    }

    /// The same result with further outputs: files of the patches and of the missing piece, marks on patches, the unit and the
    /// tolerance of the report, the clearance of the piece. `looks`: whether patches across seams get texels, and whether patches are
    /// painted as their neighbours.
    fn delivering(
        &self,
        files: [Option<PathBuf>; 2],
        mark: Option<&str>,
        unit: Option<&str>,
        tolerance: Option<f64>,
        looks: [bool; 2],
        clearance: Option<f64>,
    ) -> PyResult<Self> {
        let mut wanted = deliverables(files, mark, unit, tolerance)?;
        let [texture, paint] = looks;
        wanted.clearance = clearance;
        wanted.no_texture = !texture;
        wanted.continue_paint = paint;
        let mended = (*self.mended).clone().delivering(wanted);
        Ok(Self::new(mended.map_err(Failure::from)?))
    }

    fn document(&self) -> PyResult<String> {
        Ok(json_of(&self.mended.document())?)
    }

    /// The outcome in a few words, such as `1 hole closed, 26 left open`.
    fn state(&self) -> String {
        remarks::state(&self.mended)
    }

    /// The text of the result, in lines.
    fn lines(&self) -> Vec<String> {
        remarks::lines(&self.mended)
    }

    /// What a caller is to learn, in lines: remarks on patches and open holes, and holes left open; and whether each is a warning.
    fn messages(&self) -> Vec<(bool, String)> {
        let remarks = remarks::remarks(&self.mended).into_iter();
        let mut messages: Vec<_> = remarks.map(|line| (true, line)).collect();
        messages.extend(remarks::left_open(&self.mended));
        messages
    }

    fn flawless(&self) -> bool {
        self.mended.report.flawless()
    }

    fn complete(&self) -> bool {
        self.mended.complete()
    }

    /// The result as bytes, for pickling.
    fn packed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mended = self.mended.clone();
        let bytes = worker::run(py, None, None, move |_| packed(&*mended))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// A result from the bytes of `packed`.
    #[staticmethod]
    fn unpacked(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        let bytes = bytes.to_vec();
        worker::run(py, None, None, move |_| {
            let mended: job::Mended = unpacked(&bytes, "result")?;
            Ok(Self::new(mended.into_owned()))
        })
    }

    /// The HTML page that the command's `--report` writes.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let mended = self.mended.clone();
        let call = call(mended.command());
        worker::run(py, None, None, move |_| Ok(mended.page(&call)?))
    }

    /// The PNG file that the command's `--picture` writes.
    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mended = self.mended.clone();
        let bytes = worker::run(py, None, None, move |_| Ok(mended.picture()?))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Writes the mesh, and its page and picture if they have paths. Returns remarks, and the bytes of the mesh if `path` is none.
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
