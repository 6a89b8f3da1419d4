//! The check of a mesh for defects: the verdict, its JSON document, page and picture.

use std::sync::Arc;

use isomend::Inspection;
use isomend::check::{CheckParams, Defect, DefectKind, Verdict};
use isomend::io::Loaded;
use isomend::job::{self, Drawings, Place, Source, Unchanged};
use isomend::report::verdict_lines;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arrays;
use crate::drawings::call;
use crate::errors::Failure;
use crate::model::Model;
use crate::packed::json_of;
use crate::worker;

/// The verdict of a check, with the mesh that was checked.
#[pyclass(frozen, module = "isomend._isomend")]
pub struct Checked(Arc<Inner>);

struct Inner {
    source: Place,
    loaded: Arc<Loaded>,
    verdict: Verdict,
    document: String,
}

/// All defects of one kind: the kind's name, their number, faces at them (indices), positions (n, 3).
type Row<'py> = (
    String,
    usize,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray2<f64>>,
);

/// Checks a mesh for defects; the parameters are JSON, such as `{"thin": 0.5}`.
#[pyfunction]
#[pyo3(signature = (model, params, threads))]
pub fn check(
    py: Python<'_>,
    model: &Model,
    params: &str,
    threads: Option<usize>,
) -> PyResult<Checked> {
    let params: CheckParams =
        serde_json::from_str(params).map_err(|e| Failure::parameter(e.to_string()))?;
    let (source, loaded) = (model.source().clone(), model.loaded().clone());
    worker::run(py, threads, None, move |control| {
        let read = Source::from(source.clone());
        let drawings = Drawings::default();
        let checked = job::check(&read, &loaded, &params, None, &drawings, control)?;
        let document = json_of(&checked.document())?;
        let verdict = checked.verdict;
        Ok(Checked(Arc::new(Inner {
            source,
            loaded: loaded.clone(),
            verdict,
            document,
        })))
    })
}

/// The identifier of a kind of defect in documents.
fn name(kind: DefectKind) -> String {
    let kind = serde_json::to_value(kind).ok();
    let name = kind.as_ref().and_then(|k| k.as_str());
    name.unwrap_or_default().to_owned()
}

/// The identifiers of all kinds of defects.
#[pyfunction]
pub fn defect_kinds() -> Vec<String> {
    DefectKind::ALL.into_iter().map(name).collect()
}

impl Inner {
    /// Draws the mesh. It is inspected again, as the check does not keep the inspection.
    fn drawn<T>(&self, draw: impl FnOnce(&Unchanged) -> Result<T, Failure>) -> Result<T, Failure> {
        draw(&Unchanged {
            place: &self.source,
            loaded: &self.loaded,
            found: &Inspection::new(&self.loaded.mesh)?,
            crease_ends: &[],
            verdict: Some(&self.verdict),
            unit: None,
        })
    }
}

#[pymethods]
impl Checked {
    fn document(&self) -> &str {
        &self.0.document
    }

    /// The lines that the command prints.
    fn lines(&self) -> Vec<String> {
        let [low, high] = self.0.loaded.mesh.bounds();
        verdict_lines(&self.0.verdict, low.distance(high), None)
    }

    /// One row for each kind of defect found.
    fn defects<'py>(&self, py: Python<'py>) -> PyResult<Vec<Row<'py>>> {
        let row = |d: &Defect| {
            let faces = d.faces.iter().map(|f| i64::from(*f)).collect();
            let places = arrays::rows_of_f64(py, d.places.iter().map(|p| p.to_array()))?;
            Ok((name(d.kind), d.count, PyArray1::from_vec(py, faces), places))
        };
        self.0.verdict.defects.iter().map(row).collect()
    }

    /// The HTML page that `isomend check --report` writes.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let inner = self.0.clone();
        worker::run(py, None, None, move |_| {
            inner.drawn(|drawn| Ok(drawn.page(&call("check"))))
        })
    }

    /// The PNG file that `isomend check --picture` writes.
    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let inner = self.0.clone();
        let bytes = worker::run(py, None, None, move |_| {
            inner.drawn(|drawn| Ok(drawn.picture()?))
        })?;
        Ok(PyBytes::new(py, &bytes))
    }
}
