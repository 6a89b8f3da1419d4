//! The functions that the fuzz targets and the mutation run share: each takes any bytes, and panics where isomend does
//! not keep what it promises. `docs/fuzzing.md` says how to run them.

mod cli;
mod draco;
mod files;
mod fill;
mod mask;
mod meshopt;
mod options;
mod shapes;
mod work;

pub use draco::draco;
pub use files::{gltf, obj, off, ply, rewrite, stl, threemf, usd, vtk, vtk_xml};
pub use fill::{as_obj, fill};
pub use mask::mask;
pub use meshopt::meshopt;
pub use options::toml;
pub use work::work;

/// A function that takes any bytes.
pub type Target = fn(&[u8]);

/// The functions by the names of their targets.
pub const TARGETS: [(&str, Target); 16] = [
    ("obj", obj),
    ("ply", ply),
    ("stl", stl),
    ("gltf", gltf),
    ("meshopt", meshopt),
    ("draco", draco),
    ("vtk", vtk),
    ("vtk_xml", vtk_xml),
    ("off", off),
    ("threemf", threemf),
    ("usd", usd),
    ("rewrite", rewrite),
    ("fill", fill),
    ("work", work),
    ("mask", mask),
    ("toml", toml),
];
