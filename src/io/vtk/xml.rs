//! VTK XML poly data (VTP).

use std::borrow::Cow;

use quick_xml::events::{BytesStart, Event};

use super::super::surface::Surface;
use super::super::{Format, IoError, Loaded, Place, text};
use super::arrays::{self, Arrays};
use super::cells::{Cells, add_points};
use super::payload::{Compressor, Encoding, Source, decode};
use super::scalar::Scalar;
use crate::mesh::attributes::VtkUse;

/// Reads the polygons and strips of all pieces.
pub(in super::super) fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    let (markup, appended) = split_appended(bytes);
    let document = Document::parse(markup, b"PolyData")?;
    let offsets = sorted_offsets(&document.pieces);
    let mut surface = Surface::new(Format::Vtp);
    let mut passed_over = 0;
    let mut all = Arrays::default();
    for (number, piece) in document.pieces.iter().enumerate() {
        let decoder = Decoder {
            encoding: document.encoding,
            appended: appended.as_ref(),
            offsets: &offsets,
        };
        let base = surface.positions.len();
        let others = piece.count(b"NumberOfVerts") + piece.count(b"NumberOfLines");
        let mut arrays = Arrays {
            cells: all.cells + others,
            rows: std::mem::take(&mut all.rows),
            ..Arrays::default()
        };
        add_points(&mut surface, &decoder.points(piece)?);
        decoder.cells(piece, Section::Polys)?.add_polygons(
            Format::Vtp,
            base,
            &mut surface,
            &mut arrays,
        )?;
        decoder.cells(piece, Section::Strips)?.add_strips(
            Format::Vtp,
            base,
            &mut surface,
            &mut arrays,
        )?;
        passed_over += others;
        arrays.cells -= all.cells;
        decoder.data(piece, surface.positions.len() - base, &mut arrays);
        all.append(arrays, number == 0);
    }
    if passed_over > 0 {
        surface
            .notes
            .push(format!("points and lines passed over: {passed_over}"));
    }
    all.finish(surface)
}

/// The part of a piece that an array belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
pub(super) struct Piece<'a> {
    pub(super) attributes: Attributes,
    /// What the elements of point and cell data say: which arrays are the active ones.
    active: Vec<(Section, Attributes)>,
    pub(super) arrays: Vec<Array<'a>>,
}

impl Piece<'_> {
    fn count(&self, name: &[u8]) -> usize {
        attribute(&self.attributes, name)
            .and_then(text::integer)
            .and_then(|count| usize::try_from(count).ok())
            .unwrap_or(0)
    }
}

impl Piece<'_> {
    /// What an array is taken for.
    fn use_of(&self, section: Section, name: &str) -> VtkUse {
        let said = self.active.iter().filter(|(of, _)| *of == section);
        let is = |key: &[u8]| {
            let mut names = said.clone().filter_map(|(_, all)| attribute(all, key));
            names.any(|n| unescaped(n) == name)
        };
        match () {
            () if is(b"Scalars") => VtkUse::Scalars,
            () if is(b"Vectors") => VtkUse::Vectors,
            () if is(b"Normals") => VtkUse::Normals,
            () if is(b"TCoords") => VtkUse::TextureCoordinates,
            () if is(b"Tensors") => VtkUse::Tensors,
            () => VtkUse::Plain,
        }
    }
}

/// A value of the markup as text.
fn unescaped(value: &[u8]) -> String {
    let text = String::from_utf8_lossy(value);
    match quick_xml::escape::unescape(&text) {
        Ok(text) => text.into_owned(),
        Err(_) => text.into_owned(),
    }
}

pub(super) struct Array<'a> {
    pub(super) section: Section,
    pub(super) attributes: Attributes,
    text: Cow<'a, [u8]>,
}

impl Array<'_> {
    fn offset(&self) -> Option<usize> {
        usize::try_from(attribute(&self.attributes, b"offset").and_then(text::integer)?).ok()
    }
}

pub(super) struct Document<'a> {
    pub(super) encoding: Encoding,
    /// What the element of the data set says, such as the extent of image data.
    pub(super) dataset: Attributes,
    pub(super) pieces: Vec<Piece<'a>>,
}

impl<'a> Document<'a> {
    /// Takes the markup of a file whose data set must be of the given kind.
    pub(super) fn parse(markup: &'a [u8], wanted: &[u8]) -> Result<Self, IoError> {
        let mut reader = quick_xml::Reader::from_reader(markup);
        reader.config_mut().check_end_names = false;
        let mut encoding = None;
        let mut dataset = Attributes::new();
        let mut pieces: Vec<Piece<'a>> = Vec::new();
        let mut section = Section::Other;
        // How many elements inside the current array are open, and whether there is one.
        let mut open: Option<usize> = None;
        loop {
            let event = reader.read_event();
            let at = reader.buffer_position() as usize;
            let event = event
                .map_err(|error| fault(Place::Byte(at), format!("the XML is damaged ({error})")))?;
            match event {
                Event::Eof => break,
                Event::Start(_) if open.is_some() => open = open.map(|depth| depth + 1),
                Event::End(_) if open.is_some() => {
                    open = open.and_then(|depth| depth.checked_sub(1))
                }
                Event::Text(content) if open == Some(0) => {
                    if let Some(array) = pieces.last_mut().and_then(|piece| piece.arrays.last_mut())
                    {
                        array.text.to_mut().extend_from_slice(&content);
                    }
                }
                Event::Start(tag) => match tag.local_name().as_ref() {
                    b"VTKFile" => encoding = Some(file_encoding(&tag, wanted)?),
                    name if name == wanted => dataset = attributes(&tag)?,
                    b"Piece" => pieces.push(Piece {
                        attributes: attributes(&tag)?,
                        ..Piece::default()
                    }),
                    b"DataArray" => {
                        push_array(&mut pieces, section, &tag)?;
                        open = Some(0);
                    }
                    _ => section = open_section(&tag, &mut pieces)?,
                },
                Event::Empty(tag) if open.is_none() => match tag.local_name().as_ref() {
                    b"DataArray" => push_array(&mut pieces, section, &tag)?,
                    b"Piece" => pieces.push(Piece {
                        attributes: attributes(&tag)?,
                        ..Piece::default()
                    }),
                    _ => {}
                },
                _ => {}
            }
        }
        match encoding {
            Some(encoding) => Ok(Document {
                encoding,
                dataset,
                pieces,
            }),
            None => Err(fault(
                Place::File,
                "there is no VTKFile element".to_string(),
            )),
        }
    }
}

/// The section that an element opens. Those of data say which of their arrays are the active ones.
fn open_section(tag: &BytesStart<'_>, pieces: &mut [Piece<'_>]) -> Result<Section, IoError> {
    let section = section_named(tag.local_name().as_ref());
    let data = matches!(section, Section::PointData | Section::CellData);
    if let Some(piece) = pieces.last_mut().filter(|_| data) {
        piece.active.push((section, attributes(tag)?));
    }
    Ok(section)
}

fn section_named(name: &[u8]) -> Section {
    match name {
        b"Points" => Section::Points,
        b"Polys" => Section::Polys,
        b"Strips" => Section::Strips,
        b"PointData" => Section::PointData,
        b"CellData" => Section::CellData,
        _ => Section::Other,
    }
}

fn push_array(
    pieces: &mut [Piece<'_>],
    section: Section,
    tag: &BytesStart<'_>,
) -> Result<(), IoError> {
    if let Some(piece) = pieces.last_mut() {
        piece.arrays.push(Array {
            section,
            attributes: attributes(tag)?,
            text: Cow::Borrowed(&[]),
        });
    }
    Ok(())
}

fn attributes(tag: &BytesStart<'_>) -> Result<Attributes, IoError> {
    tag.attributes()
        .map(|attribute| match attribute {
            Ok(attribute) => Ok((
                attribute.key.as_ref().to_vec(),
                attribute.value.into_owned(),
            )),
            Err(error) => Err(fault(Place::File, format!("the XML is damaged ({error})"))),
        })
        .collect()
}

/// Checks that the file holds what is wanted and reads how its arrays are encoded.
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
                return Err(fault(
                    Place::File,
                    format!("the compressor {} is not known", text::shown(name)),
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

/// The data behind the markup, and whether it is base64.
pub(super) struct Appended<'a> {
    data: &'a [u8],
    base64: bool,
}

/// Parts the markup from the appended data, which need not be XML at all.
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

pub(super) fn sorted_offsets(pieces: &[Piece<'_>]) -> Vec<usize> {
    let mut offsets: Vec<usize> = pieces
        .iter()
        .flat_map(|piece| piece.arrays.iter().filter_map(Array::offset))
        .collect();
    offsets.sort_unstable();
    offsets
}

pub(super) struct Decoder<'a> {
    pub(super) encoding: Encoding,
    pub(super) appended: Option<&'a Appended<'a>>,
    pub(super) offsets: &'a [usize],
}

impl Decoder<'_> {
    fn points(&self, piece: &Piece<'_>) -> Result<Vec<f64>, IoError> {
        let wanted = piece.count(b"NumberOfPoints");
        let values = match piece
            .arrays
            .iter()
            .find(|array| array.section == Section::Points)
        {
            Some(array) => self.numbers(array, "points")?,
            None => Vec::new(),
        };
        if Some(values.len()) == wanted.checked_mul(3) {
            return Ok(values);
        }
        let what = format!(
            "a piece claims {wanted} points, but there are {} coordinates",
            values.len()
        );
        Err(fault(Place::File, what))
    }

    fn cells(&self, piece: &Piece<'_>, section: Section) -> Result<Cells, IoError> {
        let (claim, kind) = match section {
            Section::Strips => (&b"NumberOfStrips"[..], "triangle strip"),
            _ => (&b"NumberOfPolys"[..], "polygon"),
        };
        let wanted = piece.count(claim);
        let find = |name: &[u8]| {
            let here = |array: &&Array<'_>| {
                array.section == section && attribute(&array.attributes, b"Name") == Some(name)
            };
            piece.arrays.iter().find(here)
        };
        let cells = match (find(b"connectivity"), find(b"offsets")) {
            (Some(corners), Some(offsets)) => {
                let corners = self.numbers(corners, "connectivity")?;
                let offsets = self.numbers(offsets, "offsets")?;
                Cells::from_offsets(Format::Vtp, kind, corners, &offsets)?
                    .without_leading_zero(wanted)
            }
            _ => Cells::default(),
        };
        if cells.len() == wanted {
            return Ok(cells);
        }
        Err(fault(
            Place::File,
            format!(
                "a piece claims {wanted} {kind}s, but there are {}",
                cells.len()
            ),
        ))
    }

    /// Reads the point and cell data of a piece. What cannot be read is left out with a remark.
    fn data(&self, piece: &Piece<'_>, points: usize, arrays: &mut Arrays) {
        for array in &piece.arrays {
            let count = match array.section {
                Section::PointData => points,
                Section::CellData => arrays.cells,
                _ => continue,
            };
            let name = unescaped(attribute(&array.attributes, b"Name").unwrap_or(b"array"));
            let kind = attribute(&array.attributes, b"type").unwrap_or(b"");
            let components = attribute(&array.attributes, b"NumberOfComponents");
            let components = components.map_or(Some(1), text::integer);
            let components = components.and_then(|n| usize::try_from(n).ok());
            match (Scalar::from_xml(kind), self.numbers(array, &name)) {
                (Some(scalar), Ok(values)) => {
                    let of_points = array.section == Section::PointData;
                    let array = arrays::Array {
                        use_: piece.use_of(array.section, &name),
                        name,
                        scalar,
                        components: components.unwrap_or(0),
                        values,
                    };
                    arrays.add(array, of_points, count);
                }
                (_, Err(error)) => arrays.left_out(&name, &error.to_string()),
                (None, _) => arrays.left_out(&name, "its type is not known"),
            }
        }
    }

    pub(super) fn numbers(&self, array: &Array<'_>, name: &str) -> Result<Vec<f64>, IoError> {
        let fail = |what: String| fault(Place::File, format!("the array of {name}: {what}"));
        let kind = attribute(&array.attributes, b"type").unwrap_or(b"");
        let Some(scalar) = Scalar::from_xml(kind) else {
            return Err(fail(format!("its type {} is not known", text::shown(kind))));
        };
        let source = match attribute(&array.attributes, b"format") {
            Some(b"binary") => Source::Base64(Cow::Borrowed(&array.text[..])),
            Some(b"appended") => self.appended(array).map_err(fail)?,
            _ => Source::Text(Cow::Borrowed(&array.text[..])),
        };
        decode(&source, scalar, &self.encoding).map_err(fail)
    }

    fn appended(&self, array: &Array<'_>) -> Result<Source<'_>, String> {
        let appended = self
            .appended
            .ok_or("its data should be appended, but nothing is")?;
        let offset = array
            .offset()
            .ok_or("it has no offset into the appended data")?;
        let Some(rest) = appended.data.get(offset..) else {
            return Err(format!(
                "its offset {offset} lies beyond the {} appended bytes",
                appended.data.len()
            ));
        };
        if !appended.base64 {
            return Ok(Source::Raw(rest));
        }
        let next = self.offsets[self.offsets.partition_point(|o| *o <= offset)..].first();
        let length = next.map_or(rest.len(), |next| (next - offset).min(rest.len()));
        let text = &rest[..length];
        Ok(Source::Base64(Cow::Borrowed(
            &text[..memchr::memchr(b'<', text).unwrap_or(length)],
        )))
    }
}

fn fault(place: Place, what: String) -> IoError {
    IoError::malformed(Format::Vtp, place, what)
}
