//! `EXT_meshopt_compression`: buffer views that are compressed are decoded on reading, and the document continues without the extension.

mod attributes;
mod filters;
mod indices;
#[cfg(test)]
mod limit_tests;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::collections::btree_map::Entry;

use gltf_json::Value;
use serde::Deserialize;

use super::super::{IoError, Location};
use super::buffers::Buffers;
use super::rewritten::{Decoded, Rewritten, parsed, rewritten, taken};

/// The extension.
pub(super) const MESHOPT: &str = "EXT_meshopt_compression";

/// A compressed view, as the extension describes it.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct CompressedView {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: usize,
    count: usize,
    mode: Mode,
    #[serde(default)]
    filter: Filter,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
}

/// Decodes all compressed views; `None` if the file has none.
pub(super) fn decompressed(
    json: &[u8],
    buffers: &mut Buffers<'_>,
) -> Result<Option<(Rewritten, Decoded)>, IoError> {
    let Some(mut file) = parsed(json, MESHOPT, buffers)? else {
        return Ok(None);
    };
    let format = buffers.format;
    let mut made = Decoded::new();
    let fallbacks = fallbacks(&mut file);
    // Numbers of the buffers with compressed bytes, and of those whose own data views use.
    let (mut packed, mut plain) = (BTreeSet::new(), BTreeSet::new());
    let views = file.get_mut("bufferViews").and_then(Value::as_array_mut);
    for (index, view) in views.into_iter().flatten().enumerate() {
        match taken(view, MESHOPT) {
            Some(extension) => {
                let fault = |what: String| {
                    IoError::malformed(format, Location::Item("buffer view", index), what)
                };
                let compressed: CompressedView = serde_json::from_value(extension)
                    .map_err(|error| fault(format!("its {MESHOPT} is damaged: {error}")))?;
                packed.insert(compressed.buffer);
                let target = number(view, "buffer");
                let has_data =
                    |target: &usize| !fallbacks.contains(target) && buffers.has_data(*target);
                match target.filter(has_data) {
                    Some(target) => _ = plain.insert(target),
                    None => fill(view, &compressed, buffers, &mut made, &fault)?,
                }
            }
            None => _ = plain.insert(number(view, "buffer").unwrap_or(usize::MAX)),
        }
    }
    for unused in packed.difference(&plain) {
        made.entry(*unused).or_default();
    }
    Ok(Some((rewritten(file, MESHOPT, format)?, made)))
}

/// Removes the extension from the buffers; returns the numbers of those that it marks as without data, or with data that need not be
/// loaded.
fn fallbacks(file: &mut Value) -> BTreeSet<usize> {
    let all = file.get_mut("buffers").and_then(Value::as_array_mut);
    let all = all.into_iter().flatten().enumerate();
    let marked = |(index, buffer): (usize, &mut Value)| {
        let extension = taken(buffer, MESHOPT)?;
        (extension.get("fallback") == Some(&Value::Bool(true))).then_some(index)
    };
    all.filter_map(marked).collect()
}

/// Decodes a view into the buffer that it refers to.
fn fill(
    view: &Value,
    compressed: &CompressedView,
    buffers: &mut Buffers<'_>,
    made: &mut Decoded,
    fault: &dyn Fn(String) -> IoError,
) -> Result<(), IoError> {
    let Some(target) = number(view, "buffer") else {
        return Err(fault("it names no buffer".to_owned()));
    };
    compressed
        .check(view)
        .map_err(|what| fault(format!("its {MESHOPT} {what}")))?;
    let offset = number(view, "byteOffset").unwrap_or(0);
    let length = compressed.count * compressed.byte_stride;
    // Reading a side file raises the memory limit, so that it comes first.
    buffers.bytes(compressed.buffer)?;
    // Every view takes memory and time, also where several are decoded into the same bytes.
    buffers.spend(length)?;
    if let Entry::Vacant(unmade) = made.entry(target) {
        let known = buffers.root.buffers.get(target);
        let size = known.and_then(|buffer| usize::try_from(buffer.byte_length.0).ok());
        let size = size.ok_or_else(|| fault(format!("there is no buffer {target}")))?;
        buffers.spend(size)?;
        unmade.insert(vec![0; size]);
    }
    let range = offset.checked_add(length).map(|end| offset..end);
    let place = made.get_mut(&target).zip(range);
    let Some(place) = place.and_then(|(bytes, range)| bytes.get_mut(range)) else {
        return Err(fault(format!(
            "{length} bytes from byte {offset} are beyond buffer {target}"
        )));
    };
    let source = buffers.bytes(compressed.buffer)?;
    let end = compressed.byte_offset.checked_add(compressed.byte_length);
    let Some(source) = end.and_then(|end| source.get(compressed.byte_offset..end)) else {
        let what = format!(
            "its compressed bytes are beyond buffer {}",
            compressed.buffer
        );
        return Err(fault(what));
    };
    let decoded = compressed.decoded(source);
    let decoded = decoded.ok_or_else(|| fault("its compressed bytes are damaged".to_owned()))?;
    place.copy_from_slice(&decoded);
    Ok(())
}

impl CompressedView {
    /// The conditions that the extension states.
    fn check(&self, view: &Value) -> Result<(), &'static str> {
        let stride = self.byte_stride;
        let fits = match self.mode {
            Mode::Attributes => stride.is_multiple_of(4) && (4..=256).contains(&stride),
            Mode::Triangles => self.count.is_multiple_of(3) && matches!(stride, 2 | 4),
            Mode::Indices => matches!(stride, 2 | 4),
        };
        let filter_fits = match self.filter {
            Filter::None => true,
            Filter::Octahedral => self.mode == Mode::Attributes && matches!(stride, 4 | 8),
            Filter::Quaternion => self.mode == Mode::Attributes && stride == 8,
            Filter::Exponential => self.mode == Mode::Attributes,
        };
        if !fits {
            return Err("has a stride or a count that its mode does not allow");
        }
        if !filter_fits {
            return Err("has a filter that its mode or its stride does not allow");
        }
        let length = self.count.checked_mul(stride);
        match length.is_some() && length == number(view, "byteLength") {
            true => Ok(()),
            false => Err("has another size than the buffer view"),
        }
    }

    /// The decoded bytes; `None` for a damaged stream.
    fn decoded(&self, source: &[u8]) -> Option<Vec<u8>> {
        let indices = match self.mode {
            Mode::Attributes => {
                let mut bytes = attributes::decoded(source, self.count, self.byte_stride)?;
                filters::apply(self.filter, self.byte_stride, &mut bytes);
                return Some(bytes);
            }
            Mode::Triangles => indices::triangles(source, self.count)?,
            Mode::Indices => indices::sequence(source, self.count)?,
        };
        let bytes = indices.iter().flat_map(|index| {
            let bytes = index.to_le_bytes();
            bytes.into_iter().take(self.byte_stride)
        });
        Some(bytes.collect())
    }
}

fn number(item: &Value, name: &str) -> Option<usize> {
    let value = item.get(name)?.as_u64()?;
    usize::try_from(value).ok()
}
