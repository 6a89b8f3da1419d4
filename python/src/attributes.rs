//! Attributes of vertices, faces and face corners: conversion from and to numpy arrays.

use isomend::{Attribute, CornerAttribute, EXPECTED_ERROR_NAME, PATCH_NAME, Role, Scalar};
use isomend_core::mesh::attributes::NONE;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::errors::Failure;

/// numpy's names of the number types that attributes can have.
const SCALARS: [(&str, Scalar); 10] = [
    ("int8", Scalar::I8),
    ("uint8", Scalar::U8),
    ("int16", Scalar::I16),
    ("uint16", Scalar::U16),
    ("int32", Scalar::I32),
    ("uint32", Scalar::U32),
    ("int64", Scalar::I64),
    ("uint64", Scalar::U64),
    ("float32", Scalar::F32),
    ("float64", Scalar::F64),
];

/// An attribute from Python: name, role, numpy's name of the type, number of components, values of all components.
#[derive(FromPyObject)]
pub struct Given<'py>(String, String, String, usize, PyReadonlyArray1<'py, f64>);

impl Given<'_> {
    /// The attribute of the library; a `ParameterError` if the type is not supported.
    pub fn attribute(&self) -> Result<Attribute, Failure> {
        let Self(name, role, scalar, components, values) = self;
        let role = match role.as_str() {
            "normal" => Role::Normal,
            "colour" => Role::Colour,
            "uv" => Role::Uv(0),
            _ => Role::Other,
        };
        let found = SCALARS.iter().find(|(name, _)| name == scalar);
        let Some(&(_, scalar)) = found else {
            let what =
                format!("the values '{name}' have the type {scalar}, which is not supported");
            return Err(Failure::parameter(what));
        };
        let mut attribute = Attribute::new(name, role, scalar, *components);
        attribute.values = values.as_array().iter().copied().collect();
        Ok(attribute)
    }
}

fn name_of(scalar: Scalar) -> &'static str {
    let found = SCALARS.iter().find(|(_, s)| *s == scalar);
    found.map_or("float64", |(name, _)| name)
}

/// An attribute for Python: name, numpy's name of the type, number of components, values of all components, and for each element
/// whether its values are missing; no array of marks if none are missing.
type Taken<'py> = (
    String,
    &'static str,
    usize,
    Bound<'py, PyArray1<f64>>,
    Option<Bound<'py, PyArray1<bool>>>,
);

fn taken<'py>(py: Python<'py>, a: &Attribute) -> Taken<'py> {
    let missing = (!a.missing.is_empty()).then(|| PyArray1::from_slice(py, &a.missing));
    (
        a.name.clone(),
        name_of(a.scalar),
        a.components,
        PyArray1::from_slice(py, &a.values),
        missing,
    )
}

/// The attributes as a list, without the patch marks and expected errors of earlier runs.
pub fn list<'py>(py: Python<'py>, all: &[Attribute]) -> PyResult<Bound<'py, PyList>> {
    listed(py, all, |a| {
        a.name != PATCH_NAME && a.name != EXPECTED_ERROR_NAME
    })
}

/// The attributes as a list, without the patch marks of earlier runs. Expected errors that come with a file or with patches alone
/// are included.
pub fn list_with_errors<'py>(py: Python<'py>, all: &[Attribute]) -> PyResult<Bound<'py, PyList>> {
    listed(py, all, |a| a.name != PATCH_NAME)
}

fn listed<'py>(
    py: Python<'py>,
    all: &[Attribute],
    own: impl Fn(&&Attribute) -> bool,
) -> PyResult<Bound<'py, PyList>> {
    PyList::new(
        py,
        all.iter()
            .filter(own)
            .map(|a| taken(py, a))
            .collect::<Vec<_>>(),
    )
}

/// The attributes of face corners as a list, with one value for each corner.
pub fn corner_list<'py>(py: Python<'py>, all: &[CornerAttribute]) -> PyResult<Bound<'py, PyList>> {
    let corners = |a: &CornerAttribute| {
        let places = a.corners.iter().flatten();
        let at = |&place: &u32| {
            if place == NONE {
                usize::MAX
            } else {
                place as usize
            }
        };
        let mut spread = Attribute {
            values: Vec::new(),
            missing: Vec::new(),
            ..a.pool.clone()
        };
        for place in places.map(at) {
            spread.push(a.pool.get(place));
        }
        taken(py, &spread)
    };
    PyList::new(py, all.iter().map(corners).collect::<Vec<_>>())
}
