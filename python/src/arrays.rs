//! Meshes as arrays.

use isomend::Mesh;
use isomend::glam::DVec3;
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::errors::Failure;

/// An array of n rows of three numbers.
pub fn rows_of_f64<'py>(
    py: Python<'py>,
    rows: impl ExactSizeIterator<Item = [f64; 3]>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let count = rows.len();
    let flat: Vec<f64> = rows.flatten().collect();
    PyArray1::from_vec(py, flat).reshape([count, 3])
}

/// An array of n rows of three vertex numbers.
pub fn rows_of_i64<'py>(
    py: Python<'py>,
    rows: impl ExactSizeIterator<Item = [u32; 3]>,
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let count = rows.len();
    let flat: Vec<i64> = rows.flatten().map(i64::from).collect();
    PyArray1::from_vec(py, flat).reshape([count, 3])
}

/// Points from rows of three coordinates.
pub fn points(rows: &ArrayView2<'_, f64>) -> Result<Vec<DVec3>, Failure> {
    if rows.ncols() != 3 {
        let what = format!("rows of {} numbers, where 3 are needed", rows.ncols());
        return Err(Failure::new("MeshError", what));
    }
    let point = |r: ArrayView1<'_, f64>| DVec3::new(r[0], r[1], r[2]);
    Ok(rows.rows().into_iter().map(point).collect())
}

/// A mesh from rows of coordinates and rows of vertex numbers.
pub fn mesh(vertices: &ArrayView2<'_, f64>, faces: &ArrayView2<'_, i64>) -> Result<Mesh, Failure> {
    let positions = points(vertices)?;
    if positions.len() >= (u32::MAX / 4) as usize {
        return Err(Failure::new("MeshError", "there are too many vertices"));
    }
    if faces.ncols() != 3 {
        let what = format!("faces of {} corners, where 3 are needed", faces.ncols());
        return Err(Failure::new("MeshError", what));
    }
    let count = positions.len();
    let mut out = Vec::with_capacity(faces.nrows());
    for (number, face) in faces.rows().into_iter().enumerate() {
        let mut corners = [0; 3];
        for (corner, vertex) in corners.iter_mut().zip(face) {
            *corner = u32::try_from(*vertex)
                .ok()
                .filter(|v| (*v as usize) < count)
                .ok_or_else(|| {
                    let what = format!(
                        "face {number} refers to vertex {vertex}, but there are only {count} vertices, numbered from 0"
                    );
                    Failure::new("MeshError", what)
                })?;
        }
        out.push(corners);
    }
    Ok(Mesh::new(positions, out))
}
