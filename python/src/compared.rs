//! The comparison of two meshes.

use isomend::job::{self, Source};
use pyo3::prelude::*;

use crate::model::Model;
use crate::packed::json_of;
use crate::worker;

/// Compares two meshes; returns the JSON document of `isomend compare`.
#[pyfunction]
#[pyo3(signature = (a, b, samples, threads))]
pub fn compare(
    py: Python<'_>,
    a: &Model,
    b: &Model,
    samples: usize,
    threads: Option<usize>,
) -> PyResult<String> {
    let sources = [a, b].map(|model| Source::from(model.source().clone()));
    let loaded = [a, b].map(|model| model.loaded().clone());
    worker::run(py, threads, None, move |_| {
        let [first, second] = &sources;
        let [a, b] = &loaded;
        let compared = job::compare([(first, a), (second, b)], samples, None)?;
        json_of(&compared.document())
    })
}
