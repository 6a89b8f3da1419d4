//! `KHR_draco_mesh_compression`: primitives that are compressed are decoded on reading, and the document continues without the extension.

mod stream;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use gltf_json::Value;
use serde::Deserialize;
use serde_json::json;

use super::super::{Format, IoError, Location};
use super::accessor::component;
use super::buffers::Buffers;
use super::rewritten::{Decoded, Rewritten, parsed, rewritten, taken};
use stream::Stream;

/// The extension.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";

/// What the extension says of a primitive.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct CompressedPrimitive {
    buffer_view: usize,
    /// The unique identifiers of the attributes in the stream, by the names of the attributes.
    attributes: BTreeMap<String, u32>,
}

/// What an accessor holds: the view of a stream, and the identifier of an attribute in it, or `None` for the indices.
type Content = (usize, Option<u32>);

/// Decodes all compressed primitives; `None` if the file has none.
pub(super) fn decompressed(
    json: &[u8],
    buffers: &mut Buffers<'_>,
) -> Result<Option<(Rewritten, Decoded)>, IoError> {
    let Some(mut file) = parsed(json, DRACO, buffers)? else {
        return Ok(None);
    };
    let required = file.get("extensionsRequired").and_then(Value::as_array);
    let is_required = required.is_some_and(|names| names.iter().any(|name| name == DRACO));
    let mut unpacking = Unpacking {
        accessors: list(&mut file, "accessors"),
        views: list(&mut file, "bufferViews"),
        buffer: buffers.root.buffers.len(),
        data: Vec::new(),
        contents: BTreeMap::new(),
        streams: BTreeSet::new(),
        counted: BTreeSet::new(),
        last: None,
        buffers,
    };
    let meshes = file.get_mut("meshes").and_then(Value::as_array_mut);
    for (index, mesh) in meshes.into_iter().flatten().enumerate() {
        let primitives = mesh.get_mut("primitives").and_then(Value::as_array_mut);
        for primitive in primitives.into_iter().flatten() {
            if let Some(extension) = taken(primitive, DRACO)
                && (is_required || !unpacking.has_data(primitive))
            {
                unpacking.primitive(index, primitive, extension)?;
            }
        }
    }
    let format = unpacking.buffers.format;
    let decoded = unpacking.finish(&mut file);
    Ok(Some((rewritten(file, DRACO, format)?, decoded)))
}

/// Takes a list out of the file; an empty one if there is none.
fn list(file: &mut Value, name: &str) -> Vec<Value> {
    match file.get_mut(name).map(Value::take) {
        Some(Value::Array(items)) => items,
        _ => Vec::new(),
    }
}

/// The part of the memory limit that a buffer with streams adds: this times its size. A smooth surface of two million triangles takes 0.2
/// bytes for each triangle in a stream, and 18 bytes decoded.
const TIMES: usize = 128;

struct Unpacking<'r, 'b> {
    buffers: &'r mut Buffers<'b>,
    accessors: Vec<Value>,
    views: Vec<Value>,
    /// The number of the new buffer, and its bytes: the decoded values of all primitives.
    buffer: usize,
    data: Vec<u8>,
    /// The contents of the accessors that refer to decoded values.
    contents: BTreeMap<usize, Content>,
    /// The views of the streams that were decoded.
    streams: BTreeSet<usize>,
    /// The sources of buffers whose size has raised the memory limit, by their URIs.
    counted: BTreeSet<Option<&'b str>>,
    /// The last stream that was decoded, by the number of its view: primitives that share one follow each other.
    last: Option<(usize, Stream)>,
}

impl Unpacking<'_, '_> {
    /// Whether the accessors of a primitive have values of their own, for programs that do not know the extension.
    fn has_data(&self, primitive: &Value) -> bool {
        let attributes = primitive.get("attributes").and_then(Value::as_object);
        let attributes = attributes.into_iter().flat_map(|all| all.values());
        let mut used = attributes.chain(primitive.get("indices")).peekable();
        used.peek().is_some()
            && used.all(|number| {
                let accessor = self
                    .accessors
                    .get(number.as_u64().unwrap_or(u64::MAX) as usize);
                accessor.is_some_and(|accessor| accessor.get("bufferView").is_some())
            })
    }

    /// Decodes a primitive and refers its accessors to the decoded values.
    fn primitive(
        &mut self,
        mesh: usize,
        primitive: &mut Value,
        extension: Value,
    ) -> Result<(), IoError> {
        let compressed: CompressedPrimitive = serde_json::from_value(extension).map_err(|e| {
            let what = format!("the {DRACO} of a primitive is damaged: {e}");
            fault(self.buffers.format, mesh, what)
        })?;
        let view = compressed.buffer_view;
        let stream = match self.last.take() {
            Some((last, stream)) if last == view => stream,
            _ => self.decoded(mesh, view)?,
        };
        let indices = primitive.get("indices").and_then(Value::as_u64);
        let indices = self.accessor(mesh, indices, (view, None), &stream)?;
        primitive["indices"] = json!(indices);
        // The triangles of a stream are separate, whatever they were before.
        primitive["mode"] = json!(4);
        let named = primitive
            .get_mut("attributes")
            .and_then(Value::as_object_mut);
        for (name, number) in named.into_iter().flatten() {
            if let Some(id) = compressed.attributes.get(name) {
                let content = (view, Some(*id));
                *number = json!(self.accessor(mesh, number.as_u64(), content, &stream)?);
            }
        }
        self.last = Some((view, stream));
        Ok(())
    }

    /// Decodes the stream of a view.
    fn decoded(&mut self, mesh: usize, view: usize) -> Result<Stream, IoError> {
        let (format, root) = (self.buffers.format, self.buffers.root);
        let (place, bytes) = self.buffers.view(view)?;
        let (holder, compressed) = (place.buffer.value(), bytes.to_vec());
        let size = self.buffers.bytes(holder)?.len();
        let source = root.buffers.get(holder).and_then(|b| b.uri.as_deref());
        if self.counted.insert(source) {
            self.buffers.budget.allow(TIMES, size);
        }
        let most = self.buffers.budget.left();
        let stream = Stream::decoded(&compressed, most)
            .map_err(|what| fault(format, mesh, format!("the {DRACO} of a primitive {what}")))?;
        self.buffers.spend(stream.memory())?;
        self.streams.insert(view);
        Ok(stream)
    }

    /// The accessor of a content: the one that the primitive names, or a copy if that one has another content already.
    fn accessor(
        &mut self,
        mesh: usize,
        named: Option<u64>,
        content: Content,
        stream: &Stream,
    ) -> Result<usize, IoError> {
        let format = self.buffers.format;
        let number = match named.map(usize::try_from) {
            None => {
                self.accessors.push(json!({ "type": "SCALAR" }));
                self.accessors.len() - 1
            }
            Some(Ok(number)) if number < self.accessors.len() => number,
            _ => {
                let what = "a primitive refers to an accessor that does not exist".to_owned();
                return Err(fault(format, mesh, what));
            }
        };
        let number = match self.contents.get(&number) {
            Some(known) if *known == content => return Ok(number),
            Some(_) => {
                self.accessors.push(self.accessors[number].clone());
                self.accessors.len() - 1
            }
            None => number,
        };
        self.contents.insert(number, content);
        self.fill(number, content, stream)
            .map_err(|error| match error {
                Unfit::Memory(error) => *error,
                Unfit::Stream(what) => {
                    fault(format, mesh, format!("the {DRACO} of a primitive {what}"))
                }
            })?;
        Ok(number)
    }

    /// Adds a view of the new buffer; returns its number.
    fn add_view(&mut self, content: Content, view: Value) -> usize {
        // The view of the stream is not needed any more, and becomes the view of its indices.
        match content {
            (stream, None)
                if self.views[stream]
                    .get("buffer")
                    .is_some_and(|b| *b != view["buffer"]) =>
            {
                self.views[stream] = view;
                stream
            }
            _ => {
                self.views.push(view);
                self.views.len() - 1
            }
        }
    }

    /// Appends the values of a content to the new buffer and refers an accessor to them.
    fn fill(&mut self, number: usize, content: Content, stream: &Stream) -> Result<(), Unfit> {
        let accessor = &mut self.accessors[number];
        let mut bounds = None;
        let (values, stride, count) = match content.1 {
            None => {
                let (values, kind) = stream.indices();
                accessor["componentType"] = json!(kind);
                (values, None, stream.corners())
            }
            Some(id) => {
                let scalar = accessor.get("componentType").and_then(component);
                let scalar = scalar.ok_or("has an accessor of an unknown component type")?;
                let kind = accessor.get("type").and_then(Value::as_str);
                let components = match kind {
                    Some("SCALAR") => 1,
                    Some("VEC2") => 2,
                    Some("VEC3") => 3,
                    Some("VEC4") => 4,
                    _ => return Err("has an accessor of an unknown type".into()),
                };
                let values = stream.values(id, scalar, components)?;
                bounds = accessor
                    .get("min")
                    .is_some()
                    .then_some((scalar, components));
                let stride = components * scalar.size();
                let padded = stride.next_multiple_of(4);
                (values, (padded > stride).then_some(padded), stream.points())
            }
        };
        self.buffers.spend(values.len()).map_err(Box::new)?;
        if let Some((scalar, components)) = bounds {
            let padded = stride.unwrap_or(components * scalar.size());
            let [min, max] = stream::bounds(&values, scalar, components, padded);
            (accessor["min"], accessor["max"]) = (json!(min), json!(max));
        }
        accessor["count"] = json!(count);
        if let Some(accessor) = accessor.as_object_mut() {
            accessor.remove("byteOffset");
            accessor.remove("sparse");
        }
        let mut view = json!({ "buffer": self.buffer, "byteOffset": self.data.len(), "byteLength": values.len() });
        if let Some(stride) = stride {
            view["byteStride"] = json!(stride);
        }
        let view = self.add_view(content, view);
        self.accessors[number]["bufferView"] = json!(view);
        self.data.extend(values);
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        Ok(())
    }
}

impl Unpacking<'_, '_> {
    /// Puts the lists back into the file, with the new buffer; returns the contents of buffers that are new or changed.
    fn finish(self, file: &mut Value) -> Decoded {
        let Self {
            buffers,
            accessors,
            mut views,
            buffer,
            data,
            streams,
            ..
        } = self;
        let root = buffers.root;
        let holders = streams
            .iter()
            .filter_map(|view| root.buffer_views.get(*view));
        let holders: BTreeSet<usize> = holders.map(|view| view.buffer.value()).collect();
        let mut decoded = Decoded::new();
        for holder in holders {
            if let Ok(bytes) = buffers.bytes(holder)
                && let Some(rest) = used_bytes(bytes, holder, &mut views)
            {
                decoded.insert(holder, rest);
            }
        }
        if let Some(all) = file.get_mut("buffers").and_then(Value::as_array_mut)
            && !data.is_empty()
        {
            all.push(json!({ "byteLength": data.len() }));
            decoded.insert(buffer, data);
        }
        file["accessors"] = Value::Array(accessors);
        file["bufferViews"] = Value::Array(views);
        decoded
    }
}

/// The bytes of a buffer that views still use, without its streams; the views are moved. `None` if a view is beyond the buffer.
fn used_bytes(bytes: &[u8], buffer: usize, views: &mut [Value]) -> Option<Vec<u8>> {
    let number = |view: &Value, name: &str| view.get(name).and_then(Value::as_u64).unwrap_or(0);
    let is_here = |view: &&mut Value| number(view, "buffer") == buffer as u64;
    let mut spans: Vec<(u64, u64)> = Vec::new();
    for view in views.iter_mut().filter(is_here) {
        let start = number(view, "byteOffset");
        let end = start.checked_add(number(view, "byteLength"))?;
        if end > bytes.len() as u64 {
            return None;
        }
        // Whole words, so that the alignment of the values stays.
        spans.push((
            start / 4 * 4,
            end.next_multiple_of(4).min(bytes.len() as u64),
        ));
    }
    spans.sort_unstable();
    // Pairs of an offset before and an offset after.
    let mut moves: Vec<(u64, u64)> = Vec::new();
    let (mut used, mut reached) = (Vec::new(), 0);
    for (start, end) in spans {
        if start > reached || moves.is_empty() {
            used.resize(used.len().next_multiple_of(4), 0);
            moves.push((start, used.len() as u64));
            reached = start;
        }
        used.extend_from_slice(bytes.get(reached as usize..end.max(reached) as usize)?);
        reached = reached.max(end);
    }
    for view in views.iter_mut().filter(is_here) {
        let start = number(view, "byteOffset");
        let next = moves.partition_point(|(before, _)| *before <= start);
        let (before, after) = moves[next.checked_sub(1)?];
        view["byteOffset"] = json!(start - before + after);
    }
    Some(used)
}

/// Why an accessor cannot refer to a stream.
enum Unfit {
    Memory(Box<IoError>),
    Stream(String),
}

impl From<Box<IoError>> for Unfit {
    fn from(error: Box<IoError>) -> Self {
        Self::Memory(error)
    }
}

impl From<String> for Unfit {
    fn from(what: String) -> Self {
        Self::Stream(what)
    }
}

impl From<&str> for Unfit {
    fn from(what: &str) -> Self {
        Self::Stream(what.to_owned())
    }
}

fn fault(format: Format, mesh: usize, what: String) -> IoError {
    IoError::malformed(format, Location::Item("mesh", mesh), what)
}
