//! Reads and writes 3MF (3D Manufacturing Format): a ZIP package of XML models with units, objects, transforms and
//! colours.
//!
//! The reader takes the objects of the build with their components, including those in other parts of the package
//! (production extension), triangle colours (material extension) and base materials. Coordinates are in the build's
//! space and in the unit of the main model. Textures, beams, slices and other extensions are skipped; beams are named.

mod build;
mod model;
#[cfg(test)]
mod other_tests;
mod package;
#[cfg(test)]
mod tests;
mod values;
mod write;

use super::{Format, IoError, Loaded, Location, text};

pub(super) use write::write;

/// Reads the build of a package as one mesh.
pub(super) fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    let mut package = package::Package::open(bytes)?;
    let parts = package.models()?;
    build::build(parts, bytes.len())
}

/// Whether a ZIP archive contains a 3MF model: a part with the usual ending of its name, or one that the package's relationships
/// name. Part names are stored uncompressed in the archive.
pub(super) fn is_package(bytes: &[u8]) -> bool {
    let is_related =
        || package::Package::open(bytes).is_ok_and(|mut package| package.names_model());
    bytes.starts_with(b"PK\x03\x04")
        && (text::find(bytes, b".model").is_some()
            || text::find(bytes, b"_rels/.rels").is_some() && is_related())
}

fn fault(what: impl Into<String>) -> IoError {
    IoError::malformed(Format::ThreeMf, Location::File, what)
}
