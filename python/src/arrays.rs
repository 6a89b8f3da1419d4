//! Conversion between numpy arrays and meshes: vertex positions, faces and query points.

use isomend::Mesh;
use isomend::glam::DVec3;
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::errors::Failure;

/// An array (n, 3) of coordinates.
pub fn rows_of_f64<'py>(
    py: Python<'py>,
    rows: impl ExactSizeIterator<Item = [f64; 3]>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let count = rows.len();
    let flat: Vec<f64> = rows.flatten().collect();
    PyArray1::from_vec(py, flat).reshape([count, 3])
}

/// An array (n, 3) of vertex indices.
pub fn rows_of_i64<'py>(
    py: Python<'py>,
    rows: impl ExactSizeIterator<Item = [u32; 3]>,
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let count = rows.len();
    let flat: Vec<i64> = rows.flatten().map(i64::from).collect();
    PyArray1::from_vec(py, flat).reshape([count, 3])
}

/// Points from an array (n, 3) of coordinates; a `MeshError` if the rows have another length.
pub fn points(rows: &ArrayView2<'_, f64>) -> Result<Vec<DVec3>, Failure> {
    if rows.ncols() != 3 {
        let what = format!(
            "points have {} coordinates each; 3 are needed",
            rows.ncols()
        );
        return Err(Failure::new("MeshError", what));
    }
    let point = |r: ArrayView1<'_, f64>| DVec3::new(r[0], r[1], r[2]);
    Ok(rows.rows().into_iter().map(point).collect())
}

/// A mesh from vertices (n, 3) and faces (m, 3); a `MeshError` if a shape is wrong or a face refers to a missing vertex.
pub fn mesh(vertices: &ArrayView2<'_, f64>, faces: &ArrayView2<'_, i64>) -> Result<Mesh, Failure> {
    let positions = points(vertices)?;
    if positions.len() >= (u32::MAX / 4) as usize {
        let what = "the mesh has too many vertices; at most 1073741822 are supported";
        return Err(Failure::new("MeshError", what));
    }
    if faces.ncols() != 3 {
        let what = format!("faces have {} corners each; 3 are needed", faces.ncols());
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
                    let there = match count {
                        1 => "is only 1 vertex".to_owned(),
                        n => format!("are only {n} vertices"),
                    };
                    let what = format!(
                        "face {number} refers to vertex {vertex}, but there {there}, numbered from 0"
                    );
                    Failure::new("MeshError", what)
                })?;
        }
        out.push(corners);
    }
    Ok(Mesh::new(positions, out))
}
