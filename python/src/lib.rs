//! The Python extension module `isomend._isomend`: jobs of the library on arrays and files, each in its own threads. The package
//! around it is the interface for Python programs, with names, defaults and documentation.

mod arrays;
mod attributes;
mod checked;
mod compared;
mod drawings;
mod errors;
mod inspection;
mod logging;
mod mended;
mod model;
mod packed;
mod remarks;
mod spec;
mod volume;
mod worker;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line; returns its exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| isomend::command_line(arguments.into_iter()).code())
}

/// The parameters of all commands as JSON: for each its name, path, kind, bounds, default and description.
#[pyfunction]
fn parameters() -> PyResult<String> {
    Ok(packed::json_of(&isomend::parameters::document())?)
}

/// What takes the place of a former parameter of a command; none for any other name.
#[pyfunction]
fn in_place_of(command: &str, name: &str) -> Option<&'static str> {
    let mut tables = isomend::parameters::Table::ALL.into_iter();
    tables
        .find(|table| table.command == command)?
        .in_place_of(name)
}

#[pymodule]
fn _isomend(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<model::Model>()?;
    module.add_class::<inspection::Found>()?;
    module.add_class::<mended::Mended>()?;
    module.add_class::<checked::Checked>()?;
    module.add_class::<volume::Volume>()?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_function(wrap_pyfunction!(parameters, module)?)?;
    module.add_function(wrap_pyfunction!(in_place_of, module)?)?;
    module.add_function(wrap_pyfunction!(checked::check, module)?)?;
    module.add_function(wrap_pyfunction!(checked::defect_kinds, module)?)?;
    module.add_function(wrap_pyfunction!(compared::compare, module)?)?;
    module.add_function(wrap_pyfunction!(volume::sdf, module)?)?;
    module.add_function(wrap_pyfunction!(inspection::solve_task, module)?)?;
    module.add_function(wrap_pyfunction!(inspection::is_cramped, module)?)?;
    module.add_function(wrap_pyfunction!(model::signed_distance, module)?)?;
    Ok(())
}
