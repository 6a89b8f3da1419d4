//! Opens a 3MF package: finds and unpacks its model parts within memory limits.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::string::FromUtf8Error;

use quick_xml::events::Event;
use zip::ZipArchive;

use super::super::{IoError, text};
use super::fault;
use super::model::{Part, parse, part_name};

/// Unpacked size that all parts together may have: the larger of this many bytes and [`ALLOWANCE_TIMES`] times the file
/// size. Mesh XML is compressed by a factor of 5 to 20.
const ALLOWANCE: u64 = 64 << 20;
const ALLOWANCE_TIMES: u64 = 30;
/// Upper bound in bytes of the unpacked size of all parts, for files of any size: models of about 160 million
/// triangles.
const MOST_UNPACKED: u64 = 16 << 30;
/// Upper bound in bytes of the memory of all parsed items: about 200 million triangles, of 28 bytes and half a vertex
/// each.
const MOST_PARSED: u64 = 8 << 30;
/// Most model parts that are read. Slicers write one part per object.
const MOST_PARTS: usize = 10_000;
/// The type of the relationship to the main model.
const MAIN: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
/// The usual part name of the main model, for packages without relationships.
const USUAL: &str = "3D/3dmodel.model";

/// The models of a package by part name (lower case), and the name of the main model.
pub(super) struct Models {
    pub(super) parts: BTreeMap<String, Part>,
    pub(super) main: String,
}

/// A package being read.
pub(super) struct Package<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    /// The index of each part in the archive, by lower-case name.
    index: BTreeMap<String, usize>,
    /// Bytes that may still be unpacked.
    left: u64,
}

impl<'a> Package<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, IoError> {
        let archive = ZipArchive::new(Cursor::new(bytes))
            .map_err(|error| fault(format!("the ZIP archive is damaged ({error})")))?;
        let mut index = BTreeMap::new();
        for place in 0..archive.len() {
            if let Some(Ok(name)) = archive.name_for_index(place) {
                // If two parts have the same name, the first is used.
                index.entry(part_name(&name)).or_insert(place);
            }
        }
        let times = ALLOWANCE_TIMES.saturating_mul(bytes.len() as u64);
        Ok(Self {
            archive,
            index,
            left: ALLOWANCE.max(times).min(MOST_UNPACKED),
        })
    }

    /// Parses the main model and all models that it refers to, directly or through others.
    pub(super) fn models(&mut self) -> Result<Models, IoError> {
        let main = self.main_name()?;
        let mut parts = BTreeMap::new();
        let mut wanted = vec![main.clone()];
        let mut memory = usize::try_from(MOST_PARSED).unwrap_or(usize::MAX / 2);
        while let Some(name) = wanted.pop() {
            if parts.contains_key(&name) {
                continue;
            }
            if parts.len() >= MOST_PARTS {
                return Err(fault(format!(
                    "there are more than {MOST_PARTS} models in it"
                )));
            }
            let part = parse(&self.text(&name)?, &mut memory)?;
            wanted.extend(part.other_parts());
            parts.insert(name, part);
        }
        Ok(Models { parts, main })
    }

    /// Whether its relationships name a main model.
    pub(super) fn names_model(&mut self) -> bool {
        matches!(self.related(), Ok(Some(_)))
    }

    /// The part name of the main model.
    fn main_name(&mut self) -> Result<String, IoError> {
        Ok(self.related()?.unwrap_or_else(|| part_name(USUAL)))
    }

    /// The part name of the main model according to the relationships of the package.
    fn related(&mut self) -> Result<Option<String>, IoError> {
        let Some(index) = self.index("_rels/.rels") else {
            return Ok(None);
        };
        let relationships = self.unpacked(index)?;
        let mut reader = quick_xml::Reader::from_str(&relationships);
        loop {
            let damaged = |e| fault(format!("the XML of its relationships is damaged ({e})"));
            match reader.read_event().map_err(damaged)? {
                Event::Eof => return Ok(None),
                Event::Start(tag) | Event::Empty(tag) => {
                    let value = |name: &str| {
                        let found = tag.try_get_attribute(name).ok().flatten();
                        found.map(|attribute| attribute.value.to_string())
                    };
                    if value("Type").as_deref() == Some(MAIN)
                        && let Some(target) = value("Target")
                    {
                        return Ok(Some(part_name(&target)));
                    }
                }
                _ => {}
            }
        }
    }

    /// The index of a part in the archive. Part names are case-insensitive.
    fn index(&self, name: &str) -> Option<usize> {
        self.index.get(&part_name(name)).copied()
    }

    fn text(&mut self, name: &str) -> Result<String, IoError> {
        let index = self.index(name);
        let index = index.ok_or_else(|| fault(format!("there is no part '{name}' in it")))?;
        self.unpacked(index)
    }

    fn unpacked(&mut self, index: usize) -> Result<String, IoError> {
        let damaged = |what: String| fault(format!("a part of it cannot be unpacked ({what})"));
        let part = self
            .archive
            .by_index(index)
            .map_err(|e| damaged(e.to_string()))?;
        let mut bytes = Vec::new();
        let read = part.take(self.left + 1).read_to_end(&mut bytes);
        read.map_err(|e| damaged(e.to_string()))?;
        self.left = self.left.checked_sub(bytes.len() as u64).ok_or_else(|| {
            fault(format!(
                "its unpacked parts exceed {} MB and {ALLOWANCE_TIMES} times the file, or {} GB, which is more than any mesh needs",
                ALLOWANCE >> 20,
                MOST_UNPACKED >> 30
            ))
        })?;
        // UTF-8 text, which needs no decoding, is not copied.
        if let Cow::Owned(text) = text::decode(&bytes) {
            bytes = text;
        } else if text::strip_bom(&bytes).len() < bytes.len() {
            bytes.drain(..bytes.len() - text::strip_bom(&bytes).len());
        }
        let lossy = |e: FromUtf8Error| String::from_utf8_lossy(e.as_bytes()).into_owned();
        Ok(String::from_utf8(bytes).unwrap_or_else(lossy))
    }
}
