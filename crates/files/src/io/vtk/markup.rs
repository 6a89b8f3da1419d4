//! Parses the markup of VTK XML files: pieces, data arrays, active arrays, encoding.

use std::collections::HashSet;

use quick_xml::events::{BytesStart, Event};

use super::super::{Format, IoError, Location, text};
use super::payload::{Compressor, Encoding};
use super::scalar::Scalar;
use isomend_core::mesh::attributes::Active;

/// The element of a piece that contains an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Section {
    Points,
    Polys,
    Strips,
    PointData,
    CellData,
    Other,
}

pub(super) type Attributes = Vec<(Vec<u8>, Vec<u8>)>;

pub(super) fn attribute<'a>(attributes: &'a Attributes, name: &[u8]) -> Option<&'a [u8]> {
    attributes
        .iter()
        .find(|(key, _)| key == name)
        .map(|(_, value)| &value[..])
}

#[derive(Default)]
pub(super) struct Piece {
    pub(super) attributes: Attributes,
    /// The active arrays that the point and cell data elements name: section, use, name.
    active: HashSet<(Section, &'static str, String)>,
    pub(super) arrays: Vec<Array>,
}

/// The XML attributes that name an active array, and its use.
const USES: [(&str, Active); 5] = [
    ("Scalars", Active::Scalars),
    ("Vectors", Active::Vectors),
    ("Normals", Active::Normals),
    ("TCoords", Active::TextureCoordinates),
    ("Tensors", Active::Tensors),
];

impl Piece {
    fn of(tag: &BytesStart<'_>) -> Result<Self, IoError> {
        Ok(Self {
            attributes: attributes(tag)?,
            ..Self::default()
        })
    }

    pub(super) fn count(&self, name: &[u8]) -> usize {
        attribute(&self.attributes, name)
            .and_then(text::integer)
            .and_then(|count| usize::try_from(count).ok())
            .unwrap_or(0)
    }

    /// The use of an array.
    pub(super) fn use_of(&self, section: Section, name: &str) -> Active {
        let named = |key: &'static str| self.active.contains(&(section, key, name.to_owned()));
        let found = USES.iter().find(|(key, _)| named(key));
        found.map_or(Active::Plain, |(_, use_)| *use_)
    }
}

/// The text of an attribute value, with XML entities decoded.
pub(super) fn unescaped(value: &[u8]) -> String {
    let text = String::from_utf8_lossy(value);
    match quick_xml::escape::unescape(&text) {
        Ok(text) => text.into_owned(),
        Err(_) => text.into_owned(),
    }
}

pub(super) struct Array {
    pub(super) section: Section,
    pub(super) attributes: Attributes,
    pub(super) text: Vec<u8>,
}

impl Array {
    pub(super) fn offset(&self) -> Option<usize> {
        usize::try_from(attribute(&self.attributes, b"offset").and_then(text::integer)?).ok()
    }
}

pub(super) struct Document {
    pub(super) encoding: Encoding,
    /// The attributes of the data set element, for example the extent of image data.
    pub(super) dataset: Attributes,
    pub(super) pieces: Vec<Piece>,
}

impl Document {
    /// Parses the markup of a file whose data set must be of type `wanted`.
    pub(super) fn parse(markup: &[u8], wanted: &str) -> Result<Self, IoError> {
        // Array names in encodings other than UTF-8 do not make a file unreadable.
        let markup = String::from_utf8_lossy(markup);
        let mut reader = quick_xml::Reader::from_str(&markup);
        reader.config_mut().check_end_names = false;
        let mut open = Open {
            wanted,
            encoding: None,
            dataset: Attributes::new(),
            pieces: Vec::new(),
            section: Section::Other,
            array: None,
        };
        loop {
            let event = reader.read_event();
            let at = reader.buffer_position() as usize;
            let damaged = |what: String| fault(Location::Byte(at), what);
            match event.map_err(|e| damaged(format!("the XML is damaged ({e})")))? {
                Event::Eof => break,
                Event::GeneralRef(_) | Event::CData(_) if open.array == Some(0) => {
                    return Err(damaged("there is markup among the numbers".to_owned()));
                }
                event => open.take(event)?,
            }
        }
        match open.encoding {
            Some(encoding) => Ok(Document {
                encoding,
                dataset: open.dataset,
                pieces: open.pieces,
            }),
            None => Err(fault(
                Location::File,
                "there is no VTKFile element".to_string(),
            )),
        }
    }
}

/// The state of a document being parsed.
struct Open<'a> {
    wanted: &'a str,
    encoding: Option<Encoding>,
    dataset: Attributes,
    pieces: Vec<Piece>,
    section: Section,
    /// Within a data array: the number of open child elements.
    array: Option<usize>,
}

impl Open<'_> {
    fn take(&mut self, event: Event<'_>) -> Result<(), IoError> {
        match event {
            Event::Start(_) if self.array.is_some() => {
                self.array = self.array.map(|depth| depth + 1)
            }
            Event::End(_) if self.array.is_some() => {
                self.array = self.array.and_then(|depth| depth.checked_sub(1));
            }
            Event::Text(content) if self.array == Some(0) => {
                if let Some(array) = self.pieces.last_mut().and_then(|p| p.arrays.last_mut()) {
                    array.text.extend_from_slice(content.as_bytes());
                }
            }
            Event::Start(tag) => match tag.local_name().as_ref() {
                "VTKFile" => self.encoding = Some(file_encoding(&tag, self.wanted.as_bytes())?),
                name if name == self.wanted => self.dataset = attributes(&tag)?,
                "Piece" => self.pieces.push(Piece::of(&tag)?),
                "DataArray" => {
                    self.push_array(&tag)?;
                    self.array = Some(0);
                }
                _ => self.open_section(&tag)?,
            },
            Event::Empty(tag) if self.array.is_none() => match tag.local_name().as_ref() {
                "DataArray" => self.push_array(&tag)?,
                "Piece" => self.pieces.push(Piece::of(&tag)?),
                _ => {}
            },
            _ => {}
        }
        Ok(())
    }

    /// Opens a section. Data sections name their active arrays.
    fn open_section(&mut self, tag: &BytesStart<'_>) -> Result<(), IoError> {
        self.section = section_named(tag.local_name().as_ref());
        let data = matches!(self.section, Section::PointData | Section::CellData);
        if let Some(piece) = self.pieces.last_mut().filter(|_| data) {
            let named = attributes(tag)?;
            for (key, _) in USES {
                if let Some(name) = attribute(&named, key.as_bytes()) {
                    piece.active.insert((self.section, key, unescaped(name)));
                }
            }
        }
        Ok(())
    }

    fn push_array(&mut self, tag: &BytesStart<'_>) -> Result<(), IoError> {
        if let Some(piece) = self.pieces.last_mut() {
            piece.arrays.push(Array {
                section: self.section,
                attributes: attributes(tag)?,
                text: Vec::new(),
            });
        }
        Ok(())
    }
}

fn section_named(name: &str) -> Section {
    match name {
        "Points" => Section::Points,
        "Polys" => Section::Polys,
        "Strips" => Section::Strips,
        "PointData" => Section::PointData,
        "CellData" => Section::CellData,
        _ => Section::Other,
    }
}

fn attributes(tag: &BytesStart<'_>) -> Result<Attributes, IoError> {
    tag.attributes()
        .map(|attribute| match attribute {
            Ok(attribute) => Ok((
                attribute.key.as_ref().as_bytes().to_vec(),
                attribute.value.as_bytes().to_vec(),
            )),
            Err(error) => Err(fault(
                Location::File,
                format!("the XML is damaged ({error})"),
            )),
        })
        .collect()
}

/// Checks that the file holds the wanted kind of data, and reads how its arrays are encoded.
fn file_encoding(tag: &BytesStart<'_>, wanted: &[u8]) -> Result<Encoding, IoError> {
    let attributes = attributes(tag)?;
    match attribute(&attributes, b"type") {
        Some(kind) if kind == wanted => {}
        kind if wanted == b"ImageData" => {
            let kind = String::from_utf8_lossy(kind.unwrap_or(b"data of no type"));
            return Err(IoError::Unsupported {
                format: Format::Vti,
                what: format!("the file holds {kind}, not ImageData"),
                advice: "sample it on a regular lattice first, for example with ParaView's 'Resample To Image'",
            });
        }
        kind => {
            return Err(not_a_surface(&String::from_utf8_lossy(
                kind.unwrap_or(b"data of no type"),
            )));
        }
    }
    let compressor = match attribute(&attributes, b"compressor") {
        None | Some(b"") => None,
        Some(name) => match Compressor::parse(name) {
            Some(compressor) => Some(compressor),
            None => {
                let name = text::shown(name);
                return Err(fault(
                    Location::File,
                    format!("the compressor {} is not known", &name),
                ));
            }
        },
    };
    let sizes = if attribute(&attributes, b"header_type") == Some(b"UInt64") {
        Scalar::U64
    } else {
        Scalar::U32
    };
    let big = attribute(&attributes, b"byte_order") == Some(b"BigEndian");
    Ok(Encoding {
        big,
        sizes,
        compressor,
    })
}

fn not_a_surface(kind: &str) -> IoError {
    let advice = match kind {
        "ImageData" => "it is a volume: 'isomend surface' extracts its zero level",
        "PPolyData" | "PUnstructuredGrid" | "PImageData" => {
            "it only names the files of its pieces: merge them into one .vtp"
        }
        _ => {
            "extract its surface first, for example with ParaView's 'Extract Surface', and save it as .vtp"
        }
    };
    IoError::Unsupported {
        format: Format::Vtp,
        what: format!("the file holds {kind}, not PolyData"),
        advice,
    }
}

/// The data after the markup, and whether they are base64.
pub(super) struct Appended<'a> {
    pub(super) data: &'a [u8],
    pub(super) base64: bool,
}

/// Separates the markup from the appended data, which need not be valid XML.
pub(super) fn split_appended(bytes: &[u8]) -> (&[u8], Option<Appended<'_>>) {
    let Some(start) = text::find(bytes, b"<AppendedData") else {
        return (bytes, None);
    };
    let (markup, tail) = bytes.split_at(start);
    let Some(tag_end) = memchr::memchr(b'>', tail) else {
        return (markup, None);
    };
    let (tag, body) = tail.split_at(tag_end);
    let base64 = text::find(tag, b"base64").is_some();
    let data = memchr::memchr(b'_', body).map(|at| &body[at + 1..]);
    (markup, data.map(|data| Appended { data, base64 }))
}

pub(super) fn sorted_offsets(pieces: &[Piece]) -> Vec<usize> {
    let mut offsets: Vec<usize> = pieces
        .iter()
        .flat_map(|piece| piece.arrays.iter().filter_map(Array::offset))
        .collect();
    offsets.sort_unstable();
    offsets
}

fn fault(place: Location, what: String) -> IoError {
    IoError::malformed(Format::Vtp, place, what)
}
