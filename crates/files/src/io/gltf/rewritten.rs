//! Files that are rewritten without an extension before they are read: their JSON as values, and the JSON that takes its place.

use std::collections::BTreeMap;

use gltf_json::{Root, Value};

use super::super::{Format, IoError, Location, text};
use super::buffers::Buffers;

/// A file without an extension: its JSON, as text and as structures.
pub(super) struct Rewritten {
    pub(super) json: Vec<u8>,
    pub(super) root: Root,
}

/// The contents of buffers that were decoded, by the buffers' numbers. Buffers that held compressed data only are empty.
pub(super) type Decoded = BTreeMap<usize, Vec<u8>>;

/// The JSON of a file as values, if it names an extension; `None` if not.
pub(super) fn parsed(
    json: &[u8],
    extension: &str,
    buffers: &mut Buffers<'_>,
) -> Result<Option<Value>, IoError> {
    if text::find(json, extension.as_bytes()).is_none() {
        return Ok(None);
    }
    let format = buffers.format;
    buffers.spend(4 * json.len())?;
    serde_json::from_slice(json)
        .map(Some)
        .map_err(|error| damaged(&error, format))
}

/// The file, whose lists of extensions no longer name this one.
pub(super) fn rewritten(
    mut file: Value,
    extension: &str,
    format: Format,
) -> Result<Rewritten, IoError> {
    for list in ["extensionsUsed", "extensionsRequired"] {
        without(&mut file, list, extension);
    }
    let json = serde_json::to_vec(&file).map_err(|error| damaged(&error, format))?;
    let root = Root::from_slice(&json).map_err(|error| damaged(&error, format))?;
    Ok(Rewritten { json, root })
}

fn damaged(error: &serde_json::Error, format: Format) -> IoError {
    let what = format!("the JSON part is damaged: {error}");
    IoError::malformed(format, Location::File, what)
}

/// Removes an extension from an item of the file, such as a node; returns what it says.
pub(super) fn taken(item: &mut Value, extension: &str) -> Option<Value> {
    let extensions = item.get_mut("extensions")?.as_object_mut()?;
    let content = extensions.remove(extension)?;
    if extensions.is_empty() {
        item.as_object_mut()?.remove("extensions");
    }
    Some(content)
}

/// Removes an extension from a list of the file, and the list if nothing is left.
fn without(file: &mut Value, list: &str, extension: &str) {
    let Some(file) = file.as_object_mut() else {
        return;
    };
    let Some(names) = file.get_mut(list).and_then(Value::as_array_mut) else {
        return;
    };
    names.retain(|name| name != extension);
    if names.is_empty() {
        file.remove(list);
    }
}
