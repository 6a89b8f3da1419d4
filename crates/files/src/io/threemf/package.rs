//! Opens a 3MF package: finds and unpacks its model parts within memory limits.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Read, Write};
use std::string::FromUtf8Error;

use quick_xml::events::Event;
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::super::{IoError, text};
use super::fault;
use super::model::{Part, parse, part_name};
use super::settings::{PARTS, Settings, VOLUMES};

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
/// The part with the types of the others.
const CONTENT_TYPES: &str = "[Content_Types].xml";
/// Characters of a part's name that a remark repeats.
const LONGEST_NAME: usize = 100;
/// Most parts that a remark names.
const MOST_LISTED: usize = 4;
/// The usual part name of the main model, for packages without relationships.
const USUAL: &str = "3D/3dmodel.model";

/// The models of a package by part name (lower case), the name of the main model, and what slicers note about its objects.
pub(super) struct Models {
    pub(super) parts: BTreeMap<String, Part>,
    pub(super) main: String,
    pub(super) settings: Settings,
}

impl Models {
    /// The attributes of triangles that are not read, in words.
    pub(super) fn marks(&self) -> Option<String> {
        let all = self.parts.values().flat_map(|part| &part.marks);
        let all: BTreeSet<&str> = all.map(|mark| &mark[..]).collect();
        let all: Vec<&str> = all.into_iter().collect();
        (!all.is_empty()).then(|| format!("{} of triangles", all.join(", ")))
    }
}

/// The options of a part that is written: compressed, with a constant time stamp, so that the same mesh gives the same bytes.
pub(super) fn options(text: &str) -> SimpleFileOptions {
    SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        // Parts of 4 GB or more need ZIP64.
        .large_file(text.len() >= u32::MAX as usize)
}

/// A package being read.
pub(super) struct Package<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    /// The name of each part in the archive.
    names: Vec<String>,
    /// The index of each part in the archive, by lower-case name.
    index: BTreeMap<String, usize>,
    /// Bytes that may still be unpacked.
    left: u64,
}

impl<'a> Package<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, IoError> {
        let archive = ZipArchive::new(Cursor::new(bytes))
            .map_err(|error| fault(format!("the ZIP archive is damaged ({error})")))?;
        let (mut names, mut index) = (Vec::new(), BTreeMap::new());
        for place in 0..archive.len() {
            let name = archive.name_for_index(place).and_then(Result::ok);
            let name = name.map(|name| name.to_string()).unwrap_or_default();
            if !name.is_empty() {
                // If two parts have the same name, the first is used.
                index.entry(part_name(&name)).or_insert(place);
            }
            names.push(name);
        }
        let times = ALLOWANCE_TIMES.saturating_mul(bytes.len() as u64);
        Ok(Self {
            archive,
            names,
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
        let files = [VOLUMES, PARTS].into_iter();
        let files: Vec<String> = files.filter_map(|name| self.text(name).ok()).collect();
        Ok(Models {
            parts,
            main,
            settings: Settings::new(&files),
        })
    }

    /// What the package holds besides objects and their properties, in words: metadata, other parts.
    pub(super) fn rest(&self, models: &Models) -> Vec<String> {
        let parts = || models.parts.values();
        let own = |name: &str| {
            models.parts.contains_key(name) || name.ends_with(".rels") || name.ends_with('/')
        };
        let others = self.names().filter(|name| !own(&part_name(name)));
        let others = others.filter(|name| *name != CONTENT_TYPES);
        let others: Vec<String> = others
            .map(|name| name.chars().take(LONGEST_NAME).collect())
            .collect();
        let mut rest = Vec::new();
        if parts().any(|part| part.has_metadata) {
            rest.push("metadata of the model".to_owned());
        }
        if !others.is_empty() {
            let more = others.len().saturating_sub(MOST_LISTED);
            let mut listed = others[..others.len() - more].join(", ");
            if more > 0 {
                listed += &format!(" and {more} more");
            }
            rest.push(format!("the parts {listed}"));
        }
        rest
    }

    /// The names of its parts, in the order of the archive.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(|name| &name[..])
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

    /// The text of a part.
    pub(super) fn text(&mut self, name: &str) -> Result<String, IoError> {
        let index = self.index(name);
        let index = index.ok_or_else(|| fault(format!("there is no part '{name}' in it")))?;
        self.unpacked(index)
    }

    /// Writes the package with other texts for some parts, by their names as compared. All other parts are copied as they are.
    pub(super) fn copied(&mut self, texts: &BTreeMap<String, String>) -> Result<Vec<u8>, ZipError> {
        let mut out = ZipWriter::new(Cursor::new(Vec::new()));
        for place in 0..self.archive.len() {
            let name = &self.names[place];
            let key = part_name(name);
            let own = self.index.get(&key) == Some(&place);
            match texts.get(&key).filter(|_| own) {
                Some(text) => {
                    out.start_file(name.as_str(), options(text))?;
                    out.write_all(text.as_bytes())?;
                }
                None => out.raw_copy_file(self.archive.by_index_raw(place)?)?,
            }
        }
        Ok(out.finish()?.into_inner())
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
