//! Reads and writes 3MF (3D Manufacturing Format): a ZIP package of XML models with units, objects, transforms and
//! colours.
//!
//! The reader takes the objects of the build with their components, including those in other parts of the package
//! (production extension), triangle colours (material extension) and base materials. Coordinates are in the build's
//! space and in the unit of the main model. Textures, beams, slices and other extensions are skipped; beams are named.

mod build;
mod document;
mod model;
mod names;
#[cfg(test)]
mod other_tests;
mod package;
mod properties;
mod rewrite;
mod settings;
#[cfg(test)]
mod tests;
mod values;
mod write;

use std::sync::Arc;

use super::{Contents, FileDocument, Format, IoError, Loaded, Location, Written, text};
use isomend_core::mesh::FaceOrigin;

pub(crate) use document::BESIDE;
pub(crate) use document::ThreeMfDocument;

/// Reads the build of a package as one mesh.
pub(super) fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    let mut package = package::Package::open(bytes)?;
    let models = package.models()?;
    let (mut loaded, placements) = build::build(&models, bytes.len())?;
    let faces = 0..loaded.mesh.faces.len() as u32;
    loaded.attributes.file_faces = Some(faces.map(FaceOrigin::same).collect());
    loaded.document = Some(FileDocument::of_three_mf(ThreeMfDocument {
        bytes: Arc::new(bytes.to_vec()),
        unit: models.parts[&models.main].unit,
        placements,
        marks: models.marks(),
        rest: package.rest(&models),
    }));
    Ok(loaded)
}

/// Writes a mesh into the package that it came from, or else into a new one, with a note that says why.
pub(super) fn write(model: &Contents<'_>) -> Result<Written, IoError> {
    let Some(document) = model.document.and_then(FileDocument::three_mf) else {
        return write::write(model);
    };
    match rewrite::rewrite(document, model)? {
        Ok(written) => Ok(written),
        Err(reason) => {
            let mut written = write::write(model)?;
            let lost = document.rest().join(", ");
            if !lost.is_empty() {
                let note =
                    format!("the 3MF file is written anew, because {reason}; left out: {lost}");
                written.notes.push(note);
            }
            Ok(written)
        }
    }
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
