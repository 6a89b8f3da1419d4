//! USD packages (`.usdz`): ZIP archives of layers and textures, stored without compression at multiples of 64 bytes.

use std::collections::BTreeMap;
use std::io::{Cursor, Read, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::super::{Format, IoError, Location, Written};
use super::Budget;

/// The name of the text in a written package.
const LAYER: &str = "mesh.usda";
/// Bytes. The data of each file of a package begin at a multiple of this.
const ALIGNMENT: u16 = 64;
/// Most files of a package.
const MOST: usize = 1 << 16;

/// The layers of a package by their names.
pub(super) struct Package {
    /// The name of the first layer, which is the stage.
    pub(super) first: String,
    pub(super) layers: BTreeMap<String, Vec<u8>>,
    /// The number of other files, for example textures.
    pub(super) others: usize,
}

/// Whether a file of this name is a layer.
fn is_layer(name: &str) -> bool {
    let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
    ["usd", "usda", "usdc"]
        .iter()
        .any(|known| extension.eq_ignore_ascii_case(known))
}

/// Whether a ZIP archive is a package: its first file is a layer. Names stand uncompressed behind a header of 30 bytes.
pub(in super::super) fn is_package(bytes: &[u8]) -> bool {
    let length = bytes
        .get(26..28)
        .map_or(0, |b| usize::from(b[0]) + 256 * usize::from(b[1]));
    let name = bytes
        .get(30..30 + length)
        .and_then(|name| std::str::from_utf8(name).ok());
    bytes.starts_with(b"PK\x03\x04") && name.is_some_and(is_layer)
}

fn fault(what: impl Into<String>) -> IoError {
    IoError::malformed(Format::Usdz, Location::File, what)
}

impl Package {
    /// Unpacks the layers.
    pub(super) fn open(bytes: &[u8], budget: &mut Budget) -> Result<Self, IoError> {
        let damaged =
            |error: zip::result::ZipError| fault(format!("the package is damaged: {error}"));
        let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
        if archive.len() > MOST {
            return Err(fault(format!("the package has more than {MOST} files")));
        }
        let mut package = Self {
            first: String::new(),
            layers: BTreeMap::new(),
            others: 0,
        };
        for index in 0..archive.len() {
            let file = archive.by_index(index).map_err(damaged)?;
            let name = file.name().map_err(damaged)?.into_owned();
            if !is_layer(&name) {
                package.others += usize::from(file.is_file());
                continue;
            }
            let mut layer = Vec::new();
            let most = budget.left() as u64;
            file.take(most)
                .read_to_end(&mut layer)
                .map_err(|error| fault(format!("'{name}' cannot be unpacked: {error}")))?;
            budget.spend(layer.len() + 1)?;
            if package.first.is_empty() {
                package.first.clone_from(&name);
            }
            package.layers.insert(name, layer);
        }
        match package.first.is_empty() {
            true => Err(fault("the package has no layer (.usda, .usdc or .usd)")),
            false => Ok(package),
        }
    }
}

/// A package of a written text.
pub(super) fn packed(mut written: Written) -> Result<Written, IoError> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .with_alignment(ALIGNMENT)
        .large_file(false)
        .last_modified_time(zip::DateTime::default());
    let text = std::mem::take(&mut written.bytes);
    let pack = || -> Result<Vec<u8>, zip::result::ZipError> {
        let mut package = ZipWriter::new(Cursor::new(Vec::with_capacity(text.len() + 512)));
        package.start_file(LAYER, options)?;
        package.write_all(&text)?;
        Ok(package.finish()?.into_inner())
    };
    written.bytes = pack().map_err(|error| IoError::NotWritable {
        format: Format::Usdz,
        what: error.to_string(),
        advice: "write .usda instead",
    })?;
    Ok(written)
}
