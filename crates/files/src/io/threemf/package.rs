//! Opens a 3MF package: finds and unpacks its model parts within memory limits.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Read, Write};
use std::ops::Range;

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
/// Bytes of a part in which its XML declaration must end.
const LONGEST_DECLARATION: usize = 256;
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

/// The first of the names for a remark, cut to a length, and the number of the others.
pub(super) fn listed(names: &[impl AsRef<str>]) -> String {
    let more = names.len().saturating_sub(MOST_LISTED);
    let first = names[..names.len() - more].iter();
    let first: Vec<String> = first
        .map(|name| name.as_ref().chars().take(LONGEST_NAME).collect())
        .collect();
    match more {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}

/// A text of a part.
struct Decoded {
    text: String,
    /// Whether it says the same as the bytes: nothing was replaced since it is not valid.
    is_exact: bool,
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
        // Files of volumes say the same, so that one is enough.
        let volumes = VOLUMES.into_iter().find(|name| self.has(name));
        let files = volumes.into_iter().chain([PARTS]);
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
        let others: Vec<&str> = others.filter(|name| *name != CONTENT_TYPES).collect();
        let mut rest = Vec::new();
        if parts().any(|part| part.has_metadata) {
            rest.push("metadata of the model".to_owned());
        }
        if !others.is_empty() {
            rest.push(format!("the parts {}", listed(&others)));
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
        let relationships = self.unpacked(index)?.text;
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

    /// Whether there is a part of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.index(name).is_some()
    }

    /// The text of a part. Bytes that are no text are replaced.
    fn text(&mut self, name: &str) -> Result<String, IoError> {
        Ok(self.decoded(name)?.text)
    }

    /// The text of a part, if all its bytes are text.
    pub(super) fn exact_text(&mut self, name: &str) -> Result<Option<String>, IoError> {
        let decoded = self.decoded(name)?;
        Ok(Some(decoded.text).filter(|_| decoded.is_exact))
    }

    fn decoded(&mut self, name: &str) -> Result<Decoded, IoError> {
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

    fn unpacked(&mut self, index: usize) -> Result<Decoded, IoError> {
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
        Ok(decoded(bytes))
    }
}

/// The text of a part. UTF-8 text, which needs no decoding, is not copied. Text of another encoding declares itself as UTF-8 afterwards.
fn decoded(mut bytes: Vec<u8>) -> Decoded {
    if let Cow::Owned(wide) = text::decode(&bytes) {
        return Decoded::as_utf8(String::from_utf8(wide).unwrap_or_default());
    }
    bytes.drain(..bytes.len() - text::strip_bom(&bytes).len());
    let bytes = match String::from_utf8(bytes) {
        Ok(text) => {
            return Decoded {
                text,
                is_exact: true,
            };
        }
        Err(error) => error.into_bytes(),
    };
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(LONGEST_DECLARATION)]);
    let encoding = encoding(&head).map(|range| head[range].to_ascii_lowercase());
    match encoding.as_deref() {
        // Each byte is the code point of its character.
        Some("iso-8859-1") => Decoded::as_utf8(bytes.into_iter().map(char::from).collect()),
        _ => Decoded {
            text: String::from_utf8_lossy(&bytes).into_owned(),
            is_exact: false,
        },
    }
}

impl Decoded {
    /// A text of another encoding, with UTF-8 in its declaration.
    fn as_utf8(mut text: String) -> Self {
        if let Some(range) = encoding(&text) {
            text.replace_range(range, "UTF-8");
        }
        Self {
            text,
            is_exact: true,
        }
    }
}

/// Where the XML declaration of a text names its encoding.
fn encoding(text: &str) -> Option<Range<usize>> {
    let end = text.find("?>").filter(|_| text.starts_with("<?xml"))?;
    let word = "encoding";
    let after = text[..end].find(word)? + word.len();
    let quote = after + text[after..end].find(['"', '\''])?;
    let from = quote + 1;
    let length = text[from..end].find(&text[quote..from])?;
    Some(from..from + length)
}
