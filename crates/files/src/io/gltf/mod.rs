//! Reads and writes glTF 2.0, as JSON (.gltf) or binary (.glb).

mod accessor;
mod base_colour;
mod buffers;
mod build;
mod document;
mod draco;
mod instances;
mod joined;
mod materials;
mod meshopt;
mod morph;
mod patch;
mod patch_materials;
mod rewritten;
mod scene;
mod values;
mod write;

pub(crate) use base_colour::{BaseImage, Wrapping};
use std::collections::BTreeMap;
use std::sync::Arc;

use buffers::Buffers;
pub(crate) use document::GltfDocument;
pub use document::Image;
use draco::DRACO;
use instances::INSTANCING;
pub(super) use materials::all_turned;
use meshopt::MESHOPT;

use gltf_json::{Root, Value};
use rewritten::{Decoded, Rewritten};

use super::{Contents, FileDocument, Format, IoError, Loaded, Location, Resolve, Written, text};

/// Reads all triangles of the default scene of a glTF or GLB file into one mesh.
pub(super) fn read(bytes: &[u8], format: Format, resolve: &Resolve<'_>) -> Result<Loaded, IoError> {
    let (json, binary) = if bytes.starts_with(b"glTF") {
        let chunks = split_glb(bytes)?;
        (chunks.json, chunks.binary)
    } else {
        (text::strip_bom(bytes), None)
    };
    let root = Root::from_slice(json).map_err(|error| {
        let what = format!("the JSON part does not fit glTF 2.0: {error}");
        let other = other_version(json, format);
        other.unwrap_or_else(|| IoError::malformed(format, Location::File, what))
    })?;
    if !root.asset.version.starts_with("2.")
        && let Some(error) = other_version(json, format)
    {
        return Err(error);
    }
    check_extensions(&root, format)?;
    let size = bytes.len();
    let source = Source {
        format,
        binary,
        size,
        resolve,
    };
    let unpacked = decompressed(json, &root, &source)?;
    let (json, root) = match &unpacked.file {
        Some(file) => (&file.json[..], &file.root),
        None => (json, &root),
    };
    let mut buffers = source.buffers(root).with(&unpacked.contents);
    let (expanded, instances) = instances::expanded(json, &mut buffers)?.unzip();
    let (json, root) = match &expanded {
        Some(expanded) => (&expanded.json[..], &expanded.root),
        None => (json, root),
    };
    let scene = scene::read(root, &mut buffers)?;
    let mut loaded = scene.surface.finish()?;
    if let Some(count) = instances.filter(|n| *n > 0) {
        let note = format!("instances of {INSTANCING}, each of which is a node here: {count}");
        loaded.notes.push(note);
    }
    for name in unpacked.extensions {
        let note = format!("the file is compressed by {name}; glTF is written uncompressed");
        loaded.notes.push(note);
    }
    let names = root.materials.iter().enumerate();
    let materials = names
        .map(|(i, m)| m.name.clone().unwrap_or_else(|| format!("material_{i}")))
        .collect();
    let (vertices, faces) = (loaded.mesh.positions.len(), loaded.mesh.faces.len());
    loaded.attributes = values::attributes(
        scene.values,
        &scene.blocks,
        &scene.parts,
        [vertices, faces],
        materials,
    );
    let document = GltfDocument::new(json, buffers.all(), scene.blocks, scene.parts);
    loaded.document = document.map(FileDocument::of_gltf);
    Ok(loaded)
}

/// Where the buffers of a file are.
struct Source<'s> {
    format: Format,
    binary: Option<&'s [u8]>,
    /// The size of the file in bytes.
    size: usize,
    resolve: &'s Resolve<'s>,
}

impl<'s> Source<'s> {
    fn buffers<'r>(&self, root: &'r Root) -> Buffers<'r>
    where
        's: 'r,
    {
        Buffers::new(root, self.format, self.binary, self.size, self.resolve)
    }
}

/// A file without compression.
struct Unpacked {
    /// Its JSON; `None` if it was not compressed.
    file: Option<Rewritten>,
    /// The contents of buffers by their numbers.
    contents: BTreeMap<usize, Arc<Vec<u8>>>,
    /// The extensions that it was compressed by.
    extensions: Vec<&'static str>,
}

/// Decodes what one extension compressed; `None` if nothing is.
type Decode = fn(&[u8], &mut Buffers<'_>) -> Result<Option<(Rewritten, Decoded)>, IoError>;

/// The extensions that compress, in the order in which they are undone.
const COMPRESSIONS: [(&str, Decode); 2] = [
    (MESHOPT, meshopt::decompressed),
    (DRACO, draco::decompressed),
];

/// Decodes what extensions compressed.
fn decompressed(json: &[u8], root: &Root, source: &Source<'_>) -> Result<Unpacked, IoError> {
    let mut unpacked = Unpacked {
        file: None,
        contents: BTreeMap::new(),
        extensions: Vec::new(),
    };
    for (name, decode) in COMPRESSIONS {
        let (json, root) = match &unpacked.file {
            Some(file) => (&file.json[..], &file.root),
            None => (json, root),
        };
        let mut buffers = source.buffers(root).with(&unpacked.contents);
        if let Some((file, contents)) = decode(json, &mut buffers)? {
            let contents = contents.into_iter();
            let contents = contents.map(|(index, bytes)| (index, Arc::new(bytes)));
            unpacked.contents.extend(contents);
            unpacked.file = Some(file);
            unpacked.extensions.push(name);
        }
    }
    Ok(unpacked)
}

/// The error for JSON of another version than 2: of one that the asset names, or of version 1, whose lists are objects.
fn other_version(json: &[u8], format: Format) -> Option<IoError> {
    let value: Value = serde_json::from_slice(json).ok()?;
    let named = value
        .pointer("/asset/version")
        .map(|version| match version {
            Value::String(version) => version.clone(),
            other => other.to_string(),
        });
    let version = match named {
        Some(version) if !version.starts_with('2') => version,
        None if value.get("meshes").is_some_and(Value::is_object) => "1.0".to_owned(),
        _ => return None,
    };
    Some(other_than_two(format, &version))
}

/// The error for a version of the format that is not read.
fn other_than_two(format: Format, version: &str) -> IoError {
    IoError::Unsupported {
        format,
        what: format!("glTF version {version} is not read"),
        advice: "convert the file to glTF 2.0",
    }
}

/// Writes a mesh into the document that it came from, or else into a new document.
pub(super) fn write(model: &Contents<'_>, format: Format) -> Result<Written, IoError> {
    let document = model.document.and_then(FileDocument::gltf);
    match document.filter(|document| document.fits(model)) {
        Some(document) => patch::write(document, model, format),
        None => write::write(model, format),
    }
}

struct Chunks<'a> {
    json: &'a [u8],
    binary: Option<&'a [u8]>,
}

/// Splits a GLB file into its chunks. Chunks of other types are skipped, as the format requires.
fn split_glb(bytes: &[u8]) -> Result<Chunks<'_>, IoError> {
    let fault = |at: usize, what: String| IoError::malformed(Format::Glb, Location::Byte(at), what);
    let word = |at: usize| {
        let bytes = bytes.get(at..)?.first_chunk::<4>()?;
        Some(u32::from_le_bytes(*bytes))
    };
    let short = |at: usize| fault(at, "the file ends inside a header".to_string());
    let version = word(4).ok_or_else(|| short(4))?;
    if version != 2 {
        return Err(other_than_two(Format::Glb, &version.to_string()));
    }
    let length = word(8).ok_or_else(|| short(8))? as usize;
    if length > bytes.len() {
        return Err(fault(
            8,
            format!(
                "the header claims {length} bytes, but the file has {}",
                bytes.len()
            ),
        ));
    }
    let mut chunks = Chunks {
        json: &[],
        binary: None,
    };
    let mut at = 12;
    while at < length {
        let size = word(at).ok_or_else(|| short(at))? as usize;
        let kind = word(at + 4).ok_or_else(|| short(at))?.to_le_bytes();
        let Some(data) = bytes.get(at + 8..).and_then(|rest| rest.get(..size)) else {
            return Err(fault(
                at,
                format!(
                    "a chunk claims {size} bytes, but {} are left",
                    bytes.len().saturating_sub(at + 8)
                ),
            ));
        };
        match &kind {
            b"JSON" if chunks.json.is_empty() => chunks.json = data,
            b"BIN\0" if chunks.binary.is_none() => chunks.binary = Some(data),
            _ => {}
        }
        at += 8 + size.next_multiple_of(4);
    }
    if chunks.json.is_empty() {
        return Err(fault(12, "there is no JSON chunk".to_string()));
    }
    Ok(chunks)
}

/// Prefixes of extensions that may be required: they do not change where the triangles are, or are read.
const HARMLESS: [&str; 12] = [
    "KHR_mesh_quantization",
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_animation_",
    "KHR_xmp",
    "EXT_texture_",
    "EXT_lights_",
    "MSFT_texture_",
    DRACO,
    INSTANCING,
    MESHOPT,
];

fn check_extensions(root: &Root, format: Format) -> Result<(), IoError> {
    match root
        .extensions_required
        .iter()
        .find(|name| !HARMLESS.iter().any(|known| name.starts_with(known)))
    {
        Some(name) => Err(unsupported_extension(format, name)),
        None => Ok(()),
    }
}

/// The error for an unsupported extension, by name.
fn unsupported_extension(format: Format, name: &str) -> IoError {
    let compression = name.contains("draco") || name.contains("meshopt");
    let (kind, advice) = if compression {
        (
            "compressed with",
            "decompress it first, for example with 'gltf-transform copy' or by saving it from Blender",
        )
    } else {
        ("encoded with", "save the file without this extension")
    };
    IoError::Unsupported {
        format,
        what: format!("the mesh is {kind} {name}, which is not supported"),
        advice,
    }
}

#[cfg(test)]
mod instance_tests;
#[cfg(test)]
mod joined_tests;
#[cfg(test)]
mod tests;
