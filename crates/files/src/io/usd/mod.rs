//! Reads and writes USD (Universal Scene Description): text (`.usda`), binary (`.usdc`, read only) and packages (`.usdz`).
//!
//! All meshes of the stage are read with the transforms of their parents. Sublayers, classes, variants, references and payloads are composed
//! by their strength, within the file, a package, or the folder of the file and below. Subdivision surfaces are read as their control meshes. Text is written, with one mesh for
//! each object.

mod attributes;
mod binary;
mod compose;
#[cfg(test)]
mod compose_tests;
mod document;
#[cfg(test)]
mod fault_tests;
mod layer;
mod layers;
mod mesh;
mod package;
mod places;
mod prim;
mod primvar;
mod scene;
mod stage;
#[cfg(test)]
mod tests;
mod text;
mod transforms;
#[cfg(test)]
mod value_tests;
mod write;
mod write_values;

pub(crate) use document::UsdDocument;
pub(super) use package::is_package;

use super::budget::Budget;
use super::{Contents, FileDocument, Format, IoError, Loaded, Resolve, Written};
use layers::Layers;

/// Memory limit of a stage: `LEAST` bytes plus `TIMES` the size of its files.
const LEAST: usize = 80 << 20;
const TIMES: usize = 64;

/// What takes the memory, and what to do where it takes too much.
const STAGE: (&str, &str) = (
    "stage",
    "save the parts of the stage to be repaired as separate files",
);

/// Whether bytes begin as a text or binary layer does.
pub(super) fn is_layer(bytes: &[u8]) -> bool {
    bytes.starts_with(binary::MAGIC) || super::text::strip_bom(bytes).starts_with(b"#usda")
}

/// Reads all meshes of a stage into one mesh.
pub(super) fn read(bytes: &[u8], format: Format, resolve: &Resolve<'_>) -> Result<Loaded, IoError> {
    let mut budget = Budget::new(format, STAGE, LEAST, [TIMES, bytes.len()]);
    let package = match format {
        Format::Usdz => Some(package::Package::open(bytes, &mut budget)?),
        _ => None,
    };
    let mut layers = Layers::new(package, resolve, budget);
    let root = layers.root(bytes)?;
    let scene = scene::read(&root, &mut layers)?;
    let document = UsdDocument::new(&root, &scene, &layers);
    let mut loaded = scene.finish(&mut layers)?;
    loaded.attributes.unit = document.unit();
    loaded.notes.extend(document.unit_note());
    loaded.notes.extend(layers.notes());
    loaded.document = Some(FileDocument::of_usd(document));
    Ok(loaded)
}

/// Writes a mesh as text, or as a package with one text.
pub(super) fn write(model: &Contents<'_>, format: Format) -> Result<Written, IoError> {
    let written = write::write(model, format)?;
    match format {
        Format::Usdz => package::packed(written),
        _ => Ok(written),
    }
}
