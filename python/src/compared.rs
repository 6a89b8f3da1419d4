//! The comparison of two meshes.

use isomend::compare::{Comparison, Distances};
use isomend::job::{self, Source};
use isomend::report::{counted, length, length_beside};
use pyo3::prelude::*;

use crate::model::Model;
use crate::packed::json_of;
use crate::worker;

/// Compares two meshes; returns the JSON document of `isomend compare`, and a table of the distances in lines.
#[pyfunction]
#[pyo3(signature = (a, b, samples, threads))]
pub fn compare(
    py: Python<'_>,
    a: &Model,
    b: &Model,
    samples: usize,
    threads: Option<usize>,
) -> PyResult<(String, Vec<String>)> {
    let sources = [a, b].map(|model| Source::from(model.source().clone()));
    let loaded = [a, b].map(|model| model.loaded().clone());
    worker::run(py, threads, None, move |_| {
        let [first, second] = &sources;
        let [a, b] = &loaded;
        let compared = job::compare([(first, a), (second, b)], samples, None)?;
        let lines = table(&compared.comparison);
        Ok((json_of(&compared.document())?, lines))
    })
}

/// Sizes of both meshes, their distances in both directions in a table of 54 columns, and what of A is kept in B.
fn table(c: &Comparison) -> Vec<String> {
    let facts = [("A", &c.a), ("B", &c.b)].map(|(name, of)| {
        let vertices = counted(of.vertices, "vertex");
        let faces = counted(of.faces, "face");
        format!("{name}: {vertices}, {faces}, area {}", length(of.area))
    });
    // Lengths far below the size of the meshes are rounding errors.
    let size = c.a.area.sqrt();
    let row = |name: &str, d: &Distances| {
        let [max, rms, mean] = [d.max, d.rms, d.mean].map(|x| length_beside(x, size));
        let angle = format!("{}°", length_beside(d.normal_mean, 180.0));
        format!("{name:>6} {max:>10} {rms:>10} {mean:>10} {angle:>14}")
    };
    let kept = &c.kept;
    let mut lines = facts.to_vec();
    lines.push(format!(
        "{:>6} {:>10} {:>10} {:>10} {:>14}",
        "", "max", "rms", "mean", "mean angle"
    ));
    lines.push(row("A to B", &c.a_to_b));
    lines.push(row("B to A", &c.b_to_a));
    lines.push(format!(
        "kept in B bit for bit: {} of {} and {} of {} of A",
        kept.vertices,
        counted(c.a.vertices, "vertex"),
        kept.faces,
        counted(c.a.faces, "face")
    ));
    lines
}
