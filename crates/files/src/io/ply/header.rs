//! Parses the header of a PLY file: its elements and their properties.

use super::super::{Format, IoError, Location, text};
use isomend_core::mesh::attributes::Scalar;

/// The encoding of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

/// The type that a property's type name stands for.
fn scalar(name: &[u8]) -> Option<Scalar> {
    Some(match name {
        b"char" | b"int8" => Scalar::I8,
        b"uchar" | b"uint8" => Scalar::U8,
        b"short" | b"int16" => Scalar::I16,
        b"ushort" | b"uint16" => Scalar::U16,
        b"int" | b"int32" => Scalar::I32,
        b"uint" | b"uint32" => Scalar::U32,
        b"float" | b"float32" => Scalar::F32,
        b"double" | b"float64" => Scalar::F64,
        _ => return None,
    })
}

/// A scalar or a list in each item of an element.
#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: Vec<u8>,
    /// The type of a list's length; `None` for a scalar.
    pub(super) length: Option<Scalar>,
    pub(super) scalar: Scalar,
}

/// A table of the file, for example its vertices.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: Vec<u8>,
    /// The number of items that the file claims.
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

/// The layout of a file.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Texture files named in comments, as MeshLab writes them.
    pub(super) textures: Vec<String>,
    /// The byte offset of the body.
    pub(super) body: usize,
}

/// Parses the header.
pub(super) fn parse(bytes: &[u8]) -> Result<Header, IoError> {
    let start = bytes.len() - text::skip_blank(text::strip_bom(bytes)).len();
    if !bytes[start..].starts_with(b"ply") {
        return Err(IoError::malformed(
            Format::Ply,
            Location::Byte(0),
            "the file does not begin with 'ply'",
        ));
    }
    let end = line_end(&bytes[start..]);
    let (mut at, mut line) = (start, 0);
    let (mut encoding, mut elements) = (None, Vec::<Element>::new());
    let mut textures = Vec::new();
    loop {
        let Some(length) = memchr::memchr(end, &bytes[at..]) else {
            return Err(IoError::malformed(
                Format::Ply,
                Location::File,
                "the header has no 'end_header' line",
            ));
        };
        line += 1;
        let mut words = text::Tokens::new(&bytes[at..at + length], 0);
        at += length + 1;
        match words.next().unwrap_or(b"") {
            b"format" => encoding = Some(parse_encoding(&mut words, line)?),
            b"element" => elements.push(parse_element(&mut words, line)?),
            b"property" => match elements.last_mut() {
                Some(element) => element.properties.push(parse_property(&mut words, line)?),
                None => {
                    return Err(fault(
                        line,
                        "a property comes before the first element".to_string(),
                    ));
                }
            },
            b"end_header" => break,
            b"comment" => textures.extend(texture(words)),
            b"ply" | b"obj_info" | b"" => {}
            word => {
                return Err(fault(
                    line,
                    format!("{} is not a statement of a PLY header", text::shown(word)),
                ));
            }
        }
    }
    match encoding {
        Some(encoding) => Ok(Header {
            encoding,
            elements,
            textures,
            body: at,
        }),
        None => Err(IoError::malformed(
            Format::Ply,
            Location::File,
            "the header has no 'format' line",
        )),
    }
}

/// The texture file that a comment names.
fn texture(mut words: text::Tokens<'_>) -> Option<String> {
    (words.next()? == b"TextureFile").then_some(())?;
    Some(String::from_utf8_lossy(words.rest_of_line()).into_owned())
}

/// The byte that ends a header line, according to the first line.
fn line_end(bytes: &[u8]) -> u8 {
    let first = memchr::memchr2(b'\n', b'\r', bytes).unwrap_or(0);
    match bytes.get(first..first + 2) {
        Some([b'\r', b'\n']) => b'\n',
        Some([b'\r', _]) => b'\r',
        _ => b'\n',
    }
}

fn parse_encoding(words: &mut text::Tokens<'_>, line: usize) -> Result<Encoding, IoError> {
    match words.next().unwrap_or(b"") {
        b"ascii" => Ok(Encoding::Ascii),
        b"binary_little_endian" => Ok(Encoding::Little),
        b"binary_big_endian" => Ok(Encoding::Big),
        word => Err(fault(
            line,
            format!("format {} is not known", text::shown(word)),
        )),
    }
}

fn parse_element(words: &mut text::Tokens<'_>, line: usize) -> Result<Element, IoError> {
    let name = words.next().unwrap_or(b"").to_vec();
    let count = words.next().unwrap_or(b"");
    match text::integer(count).and_then(|count| u64::try_from(count).ok()) {
        Some(count) => Ok(Element {
            name,
            count,
            properties: Vec::new(),
        }),
        None => Err(fault(
            line,
            format!(
                "{} is not a count of {}",
                text::shown(count),
                text::shown(&name)
            ),
        )),
    }
}

fn parse_property(words: &mut text::Tokens<'_>, line: usize) -> Result<Property, IoError> {
    let scalar = |word: &[u8]| {
        scalar(word).ok_or_else(|| {
            fault(
                line,
                format!("{} is not a property type", text::shown(word)),
            )
        })
    };
    let first = words.next().unwrap_or(b"");
    let (length, scalar) = if first == b"list" {
        (
            Some(scalar(words.next().unwrap_or(b""))?),
            scalar(words.next().unwrap_or(b""))?,
        )
    } else {
        (None, scalar(first)?)
    };
    match words.next() {
        Some(name) => Ok(Property {
            name: name.to_vec(),
            length,
            scalar,
        }),
        None => Err(fault(line, "the property has no name".to_string())),
    }
}

fn fault(line: usize, what: String) -> IoError {
    IoError::malformed(Format::Ply, Location::Line(line), what)
}
