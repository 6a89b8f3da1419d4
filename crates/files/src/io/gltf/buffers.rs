//! Loads the buffers of a glTF file (binary chunk, data URIs, side files) within a memory limit.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf_json::Root;
use gltf_json::buffer::View;

use super::super::budget::Budget;
use super::super::{Format, IoError, Location, Resolve};

/// Memory limit of a scene: `LEAST` bytes plus `TIMES` the size of its file and buffers. A mesh that is used once takes
/// 6 to 12 times its size.
const LEAST: usize = 80 << 20;
const TIMES: usize = 32;
/// The part of the limit that decoded buffers add: this times their size. Decoding allows them to take 32 times the file's size, so that
/// [`TIMES`] again would allow a small file 1024 times its size.
const DECODED_TIMES: usize = 12;
/// What takes the memory, and what to do where it takes too much.
const SCENE: (&str, &str) = (
    "scene",
    "save the parts of the scene to be repaired as separate files",
);

/// Loads each buffer on first use, so that buffers that hold only images are not loaded while triangles are read.
pub(super) struct Buffers<'a> {
    pub(super) root: &'a Root,
    pub(super) format: Format,
    binary: Option<&'a [u8]>,
    resolve: &'a Resolve<'a>,
    /// The memory that the scene may still take.
    pub(super) budget: Budget,
    loaded: Vec<Option<Arc<Vec<u8>>>>,
    /// The files read so far by name, with the number of bytes requested.
    files: HashMap<String, (u64, Arc<Vec<u8>>)>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(
        root: &'a Root,
        format: Format,
        binary: Option<&'a [u8]>,
        size: usize,
        resolve: &'a Resolve<'a>,
    ) -> Self {
        Self {
            root,
            format,
            binary,
            resolve,
            budget: Budget::new(format, SCENE, LEAST, [TIMES, size]),
            loaded: vec![None; root.buffers.len()],
            files: HashMap::new(),
        }
    }

    /// The same with buffers whose contents are known.
    pub(super) fn with(mut self, known: &BTreeMap<usize, Arc<Vec<u8>>>) -> Self {
        for (index, bytes) in known {
            self.budget.allow(DECODED_TIMES, bytes.len());
            if let Some(loaded) = self.loaded.get_mut(*index) {
                *loaded = Some(Arc::clone(bytes));
            }
        }
        self
    }

    /// Whether the file says where the bytes of a buffer are.
    pub(super) fn has_data(&self, index: usize) -> bool {
        let buffer = self.root.buffers.get(index);
        buffer.is_some_and(|b| b.uri.is_some() || (index == 0 && self.binary.is_some()))
    }

    /// The bytes of a buffer view; an error if they are not all in its buffer.
    pub(super) fn view(&mut self, index: usize) -> Result<(&View, &[u8]), IoError> {
        let fault = |what: String| {
            IoError::malformed(self.format, Location::Item("buffer view", index), what)
        };
        let root = self.root;
        let Some(view) = root.buffer_views.get(index) else {
            return Err(fault(format!(
                "the file has only {} buffer views",
                root.buffer_views.len()
            )));
        };
        let start = view.byte_offset.unwrap_or_default().0;
        let (length, place) = (view.byte_length.0, Location::Item("buffer view", index));
        let format = self.format;
        let bytes = self.bytes(view.buffer.value())?;
        let end = start
            .checked_add(length)
            .and_then(|end| usize::try_from(end).ok());
        match end.and_then(|end| bytes.get(start as usize..end)) {
            Some(part) => Ok((view, part)),
            None => {
                let what = format!(
                    "{length} bytes from byte {start} are beyond the {} bytes of the buffer",
                    bytes.len()
                );
                Err(IoError::malformed(format, place, what))
            }
        }
    }

    /// Charges memory before it is allocated. Many nodes with the same mesh, or accessors with a count but no data,
    /// could make a small file very large in memory.
    pub(super) fn spend(&mut self, bytes: usize) -> Result<(), IoError> {
        self.budget.spend(bytes)
    }

    /// All buffers. Buffers that cannot be loaded are `None`; they hold no triangles.
    pub(super) fn all(mut self) -> Vec<Option<Arc<Vec<u8>>>> {
        for index in 0..self.root.buffers.len() {
            let binary = self.bytes(index).ok().map(<[u8]>::to_vec);
            if self.loaded[index].is_none() {
                self.loaded[index] = binary.map(Arc::new);
            }
        }
        self.loaded
    }

    /// All bytes of a buffer.
    pub(super) fn bytes(&mut self, index: usize) -> Result<&[u8], IoError> {
        let fault =
            |what: String| IoError::malformed(self.format, Location::Item("buffer", index), what);
        let Some(buffer) = self.root.buffers.get(index) else {
            return Err(fault(format!(
                "the file has only {} buffers",
                self.root.buffers.len()
            )));
        };
        let Some(uri) = &buffer.uri else {
            if self.loaded[index].is_some() {
                return Ok(self.loaded[index].as_ref().map_or(&[], |b| b.as_slice()));
            }
            return match self.binary {
                Some(binary) if index == 0 => Ok(binary),
                _ => Err(fault("it has neither a URI nor a binary chunk".to_string())),
            };
        };
        if self.loaded[index].is_none() {
            let length = buffer.byte_length.0;
            let bytes = match uri.strip_prefix("data:") {
                Some(data) => Arc::new(
                    decode_data_uri(data)
                        .ok_or_else(|| fault("its data URI is not base64".to_string()))?,
                ),
                None => self.file(uri, length)?,
            };
            if (bytes.len() as u64) < length {
                let what = format!("it claims {length} bytes, but has {}", bytes.len());
                return Err(IoError::malformed(
                    self.format,
                    Location::Item("buffer", index),
                    what,
                ));
            }
            self.loaded[index] = Some(bytes);
        }
        Ok(self.loaded[index]
            .as_ref()
            .map_or(&[], |bytes| bytes.as_slice()))
    }

    /// The first `length` bytes of a side file. A file is read once for all buffers that need no more bytes.
    fn file(&mut self, uri: &str, length: u64) -> Result<Arc<Vec<u8>>, IoError> {
        let known = self.files.get(uri);
        if let Some((_, bytes)) = known.filter(|(wanted, _)| *wanted >= length) {
            return Ok(Arc::clone(bytes));
        }
        let bytes = Arc::new((self.resolve)(&percent_decoded(uri), length)?);
        self.budget.allow(TIMES, bytes.len());
        self.files
            .insert(uri.to_owned(), (length, Arc::clone(&bytes)));
        Ok(bytes)
    }
}

pub(super) fn decode_data_uri(data: &str) -> Option<Vec<u8>> {
    let (kind, payload) = data.split_once(',')?;
    kind.ends_with(";base64").then_some(())?;
    let config =
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    GeneralPurpose::new(&STANDARD, config)
        .decode(payload.trim_end())
        .ok()
}

/// A path as a relative reference (RFC 3986).
pub(super) fn percent_encoded(path: &str) -> String {
    let mut out = String::with_capacity(path.len());
    for byte in path.bytes() {
        match byte {
            b'-' | b'.' | b'_' | b'~' | b'/' => out.push(char::from(byte)),
            byte if byte.is_ascii_alphanumeric() => out.push(char::from(byte)),
            byte => out += &format!("%{byte:02X}"),
        }
    }
    out
}

/// Decodes percent-encoded bytes such as `%20`.
pub(super) fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((first, tail)) = rest.split_first() {
        let hex = tail.get(..2).and_then(|two| std::str::from_utf8(two).ok());
        let code = hex
            .filter(|h| h.bytes().all(|b| b.is_ascii_hexdigit()))
            .and_then(|h| u8::from_str_radix(h, 16).ok());
        match (first, code) {
            (b'%', Some(code)) => {
                bytes.push(code);
                rest = &tail[2..];
            }
            _ => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).unwrap_or_else(|_| uri.to_string())
}
