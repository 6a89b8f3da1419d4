//! Reads VTK XML poly data (VTP).

use std::cell::RefCell;
use std::collections::HashMap;

use super::super::mesh_builder::MeshBuilder;
use super::super::{Format, IoError, Loaded, Location, text};
use super::arrays::{self, Arrays};
use super::cells::{Cells, add_points};
use super::markup::{
    Appended, Array, Document, Piece, Section, attribute, sorted_offsets, split_appended, unescaped,
};
use super::payload::{Budget, Encoding, Expected, Source, decode};
use super::scalar::{Scalar, VtkScalar};

/// Memory limit of decoded arrays: this many bytes plus this multiple of the file size. Text and uncompressed arrays
/// take at most eight times their size. Zlib compresses a mesh by 10 to 20, and constant values by 1000.
const ALLOWANCE: [usize; 2] = [32 << 20, 48];

/// Reads the polygons and strips of all pieces.
pub(in super::super) fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    let (markup, appended) = split_appended(bytes);
    let document = Document::parse(markup, "PolyData")?;
    let decoder = Decoder::new(&document, appended.as_ref(), Budget::new(bytes, ALLOWANCE));
    let mut surface = MeshBuilder::new(Format::Vtp);
    let mut all = Arrays::default();
    for (number, piece) in document.pieces.iter().enumerate() {
        let base = surface.positions.len();
        let others = piece.count(b"NumberOfVerts") + piece.count(b"NumberOfLines");
        let mut arrays = Arrays {
            cells: all.cells + others,
            cell_of_face: std::mem::take(&mut all.cell_of_face),
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
        surface.skipped += others;
        arrays.cells -= all.cells;
        decoder.data(piece, surface.positions.len() - base, &mut arrays);
        all.append(arrays, number == 0);
    }
    all.finish(surface)
}

pub(super) struct Decoder<'a> {
    encoding: Encoding,
    appended: Option<&'a Appended<'a>>,
    /// The offsets of the appended arrays, in ascending order.
    offsets: Vec<usize>,
    budget: Budget,
    /// Decoded arrays whose offset several arrays share.
    shared: RefCell<HashMap<(usize, Scalar, Expected), Vec<f64>>>,
}

impl<'a> Decoder<'a> {
    pub(super) fn new(
        document: &Document,
        appended: Option<&'a Appended<'a>>,
        budget: Budget,
    ) -> Self {
        Self {
            encoding: document.encoding,
            appended,
            offsets: sorted_offsets(&document.pieces),
            budget,
            shared: RefCell::default(),
        }
    }

    fn points(&self, piece: &Piece) -> Result<Vec<f64>, IoError> {
        let wanted = piece.count(b"NumberOfPoints");
        let numbers = wanted.saturating_mul(3);
        let array = piece.arrays.iter().find(|a| a.section == Section::Points);
        match array {
            Some(array) => {
                let name = format!("the coordinates of a piece that claims {wanted} points");
                self.numbers(array, &name, Expected::Exactly(numbers))
            }
            None if wanted == 0 => Ok(Vec::new()),
            None => {
                let what = format!("a piece claims {wanted} points, but there are 0 coordinates");
                Err(fault(Location::File, what))
            }
        }
    }

    fn cells(&self, piece: &Piece, section: Section) -> Result<Cells, IoError> {
        // Bytes charged per corner for the faces: a strip gives about one triangle per corner, triangles give one per
        // three corners.
        let (claim, kind, growth) = match section {
            Section::Strips => (&b"NumberOfStrips"[..], "triangle strip", 16),
            _ => (&b"NumberOfPolys"[..], "polygon", 8),
        };
        let wanted = piece.count(claim);
        if wanted == 0 {
            return Ok(Cells::default());
        }
        let find = |name: &[u8]| {
            let here = |array: &&Array| {
                array.section == section && attribute(&array.attributes, b"Name") == Some(name)
            };
            piece.arrays.iter().find(here)
        };
        let cells = match (find(b"connectivity"), find(b"offsets")) {
            (Some(corners), Some(offsets)) => {
                let name = format!("the offsets of a piece that claims {wanted} {kind}s");
                let offsets = self.numbers(offsets, &name, Expected::OrOneMore(wanted))?;
                let count = offsets.last().copied().unwrap_or(0.0) as usize;
                self.budget
                    .take(count.saturating_mul(growth))
                    .map_err(|what| fault(Location::File, what))?;
                let corners = self.numbers(corners, "connectivity", Expected::First(count))?;
                Cells::from_offsets(Format::Vtp, kind, corners, &offsets)?
                    .without_leading_zero(wanted)
            }
            _ => Cells::default(),
        };
        if cells.len() == wanted {
            return Ok(cells);
        }
        Err(fault(
            Location::File,
            format!(
                "a piece claims {wanted} {kind}s, but there are {}",
                cells.len()
            ),
        ))
    }

    /// Reads the point and cell data of a piece. Arrays that cannot be read are left out, with a remark.
    fn data(&self, piece: &Piece, points: usize, arrays: &mut Arrays) {
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
            let components = components.unwrap_or(0);
            let expected = Expected::Exactly(count.saturating_mul(components));
            match (Scalar::from_xml(kind), self.numbers(array, &name, expected)) {
                (Some(scalar), Ok(values)) => {
                    let of_points = array.section == Section::PointData;
                    let array = arrays::Array {
                        use_: piece.use_of(array.section, &name),
                        name,
                        scalar,
                        components,
                        values,
                    };
                    arrays.add(array, of_points, count);
                }
                (_, Err(error)) => arrays.left_out(&name, &error.to_string()),
                (None, _) => arrays.left_out(&name, "its type is not known"),
            }
        }
    }

    /// Decodes the numbers of an array.
    pub(super) fn numbers(
        &self,
        array: &Array,
        name: &str,
        expected: Expected,
    ) -> Result<Vec<f64>, IoError> {
        let fail = |what: String| fault(Location::File, format!("the array of {name}: {what}"));
        let kind = attribute(&array.attributes, b"type").unwrap_or(b"");
        let Some(scalar) = Scalar::from_xml(kind) else {
            return Err(fail(format!("its type {} is not known", text::shown(kind))));
        };
        let decode = |source: Source<'_>| self.decode(&source, scalar, expected);
        match attribute(&array.attributes, b"format") {
            Some(b"binary") => decode(Source::Base64(&array.text)),
            Some(b"appended") => self.appended(array, scalar, expected),
            _ => decode(Source::Text(&array.text)),
        }
        .map_err(fail)
    }

    /// Decodes an appended array, or copies it from an array with the same offset.
    fn appended(
        &self,
        array: &Array,
        scalar: Scalar,
        expected: Expected,
    ) -> Result<Vec<f64>, String> {
        let appended = self
            .appended
            .ok_or("its data should be appended, but nothing is")?;
        let offset = array
            .offset()
            .ok_or("it has no offset into the appended data")?;
        let first = self.offsets.partition_point(|o| *o < offset);
        let behind = self.offsets.partition_point(|o| *o <= offset);
        let key = (offset, scalar, expected);
        if let Some(values) = self.shared.borrow().get(&key) {
            self.budget.take(values.len().saturating_mul(8))?;
            return Ok(values.clone());
        }
        let source = appended.source(offset, self.offsets.get(behind).copied())?;
        let values = self.decode(&source, scalar, expected)?;
        if behind - first > 1 {
            self.budget.take(values.len().saturating_mul(8))?;
            self.shared.borrow_mut().insert(key, values.clone());
        }
        Ok(values)
    }

    fn decode(
        &self,
        source: &Source<'_>,
        scalar: Scalar,
        expected: Expected,
    ) -> Result<Vec<f64>, String> {
        decode(source, scalar, &self.encoding, expected, &self.budget)
    }
}

impl Appended<'_> {
    /// The data from an offset on; base64 ends at the next array.
    fn source(&self, offset: usize, next: Option<usize>) -> Result<Source<'_>, String> {
        let Some(rest) = self.data.get(offset..) else {
            return Err(format!(
                "its offset {offset} is beyond the {} appended bytes",
                self.data.len()
            ));
        };
        if !self.base64 {
            return Ok(Source::Raw(rest));
        }
        let length = next.map_or(rest.len(), |next| (next - offset).min(rest.len()));
        let text = &rest[..length];
        Ok(Source::Base64(
            &text[..memchr::memchr(b'<', text).unwrap_or(length)],
        ))
    }
}

fn fault(place: Location, what: String) -> IoError {
    IoError::malformed(Format::Vtp, place, what)
}
