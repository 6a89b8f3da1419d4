//! 3MF (3D Manufacturing Format): a package (ZIP) of models in XML, with units, objects, transforms and colours.
//!
//! Read are the objects of the build with their components, also those in other parts of the package (production extension); colours of
//! triangles (material extension) and base materials. Coordinates are those of the build in the unit of the package's main model. Textures,
//! beams, slices and the like are passed over.

mod build;
mod model;
mod package;
#[cfg(test)]
mod tests;
mod values;
mod write;

use super::{Format, IoError, Loaded, Location, text};

pub(super) use write::write;

/// Reads the build of a package.
pub(super) fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    let mut package = package::Package::open(bytes)?;
    let parts = package.models()?;
    build::build(parts, bytes.len())
}

/// Whether a ZIP archive has a 3MF model in it: the name of the part stands in the archive as it is.
pub(super) fn is_package(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04") && text::find(bytes, b".model").is_some()
}

fn fault(what: impl Into<String>) -> IoError {
    IoError::malformed(Format::ThreeMf, Location::File, what)
}
