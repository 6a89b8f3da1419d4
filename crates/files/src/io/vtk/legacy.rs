//! Reads VTK legacy files, text and binary, of versions 1 to 5.1.

use super::super::mesh_builder::MeshBuilder;
use super::super::{Format, IoError, Loaded, Location, text};
use super::arrays::Arrays;
use super::cells::{Cells, add_points};
use super::scalar::{Scalar, VtkScalar};

/// Reads the faces of poly data, or of an unstructured grid of faces.
pub(in super::super) fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    let mut reader = Reader::open(bytes)?;
    let dataset = reader.word("the kind of data set")?.to_ascii_uppercase();
    match &dataset[..] {
        b"POLYDATA" | b"UNSTRUCTURED_GRID" => {}
        other => {
            return Err(IoError::Unsupported {
                format: Format::Vtk,
                what: format!(
                    "the file holds {}, not a surface",
                    String::from_utf8_lossy(other)
                ),
                advice: "extract a surface first and save it as POLYDATA",
            });
        }
    }
    let mut grid = None;
    while let Some(keyword) = reader.keyword() {
        match &keyword.to_ascii_uppercase()[..] {
            b"POINTS" => reader.points()?,
            b"VERTICES" => reader.primitives(Kind::Points)?,
            b"LINES" => reader.primitives(Kind::Lines)?,
            b"POLYGONS" => reader.primitives(Kind::Polygons)?,
            b"TRIANGLE_STRIPS" => reader.primitives(Kind::Strips)?,
            b"CELLS" => grid = Some(reader.cells("cell")?),
            b"CELL_TYPES" => {
                let count = reader.count("cell types")?;
                reader.end_line();
                let types = reader.numbers(count, Scalar::I32, "cell types")?;
                let cells = grid.take().unwrap_or_default();
                cells.add_typed(Format::Vtk, &types, &mut reader.surface, &mut reader.arrays)?;
            }
            b"FIELD" => reader.skip_field()?,
            b"METADATA" => reader.skip_metadata(),
            word @ (b"POINT_DATA" | b"CELL_DATA") => {
                reader.data(word == b"POINT_DATA");
                break;
            }
            _ => {
                return Err(reader.fault(format!(
                    "{} is not a supported section of a surface",
                    text::shown(keyword)
                )));
            }
        }
    }
    reader.finish()
}

/// The kinds of cells, in the order in which cell data list them.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Points,
    Lines,
    Polygons,
    Strips,
}

pub(super) struct Reader<'a> {
    pub(super) tokens: text::Tokens<'a>,
    pub(super) bytes: &'a [u8],
    pub(super) binary: bool,
    /// Whether cells are stored as offsets and connectivity (version 5 and later).
    offsets: bool,
    surface: MeshBuilder,
    /// The point and cell data arrays.
    pub(super) arrays: Arrays,
    /// The kind of the cells read last.
    kind: Kind,
    /// Whether the kinds of cells came in the order of [`Kind`].
    ordered: bool,
}

impl<'a> Reader<'a> {
    /// Parses the header, up to the kind of data set.
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, IoError> {
        let mut tokens = text::Tokens::new(bytes, 0);
        let first = tokens.rest_of_line();
        let at_version = text::find(first, b"Version ").map(|at| at + 8);
        let Some(major) = at_version.and_then(|at| text::number(first[at..].trim_ascii())) else {
            let what = "the first line is not '# vtk DataFile Version' with a number";
            return Err(IoError::malformed(Format::Vtk, Location::Line(1), what));
        };
        tokens.rest_of_line();
        let surface = MeshBuilder::new(Format::Vtk);
        let mut reader = Reader {
            tokens,
            bytes,
            binary: false,
            offsets: major >= 5.0,
            surface,
            arrays: Arrays::default(),
            kind: Kind::Points,
            ordered: true,
        };
        let encoding = reader.word("ASCII or BINARY")?;
        reader.binary = encoding.eq_ignore_ascii_case(b"BINARY");
        if !reader.binary && !encoding.eq_ignore_ascii_case(b"ASCII") {
            return Err(reader.fault(format!(
                "{} was found instead of ASCII or BINARY",
                text::shown(encoding)
            )));
        }
        let dataset = reader.word("DATASET")?;
        if !dataset.eq_ignore_ascii_case(b"DATASET") {
            return Err(reader.fault(format!(
                "{} was found instead of DATASET",
                text::shown(dataset)
            )));
        }
        Ok(reader)
    }

    pub(super) fn keyword(&mut self) -> Option<&'a [u8]> {
        self.tokens.next()
    }

    pub(super) fn word(&mut self, what: &str) -> Result<&'a [u8], IoError> {
        self.tokens
            .next()
            .ok_or_else(|| self.fault(format!("the file ends before {what}")))
    }

    pub(super) fn count(&mut self, of: &str) -> Result<usize, IoError> {
        let word = self.word(&format!("the count of {of}"))?;
        text::integer(word)
            .and_then(|count| usize::try_from(count).ok())
            .ok_or_else(|| self.fault(format!("{} is not a count of {of}", text::shown(word))))
    }

    pub(super) fn scalar(&mut self) -> Result<Scalar, IoError> {
        let word = self.word("a data type")?;
        Scalar::from_legacy(word)
            .ok_or_else(|| self.fault(format!("{} is not a data type", text::shown(word))))
    }

    /// Moves to the data after a keyword line.
    pub(super) fn end_line(&mut self) {
        if self.binary {
            self.tokens.rest_of_line();
        }
    }

    fn points(&mut self) -> Result<(), IoError> {
        let count = self.count("points")?;
        let scalar = self.scalar()?;
        self.end_line();
        let Some(values) = count.checked_mul(3) else {
            return Err(self.fault(format!("{count} points are more than the file can hold")));
        };
        let values = self.numbers(values, scalar, "coordinates")?;
        add_points(&mut self.surface, &values);
        Ok(())
    }

    /// Reads `count` numbers, after checking that the rest of the file has room for them.
    pub(super) fn numbers(
        &mut self,
        count: usize,
        scalar: Scalar,
        what: &str,
    ) -> Result<Vec<f64>, IoError> {
        let least = if self.binary { scalar.size() } else { 2 };
        let room = (self.tokens.left() + usize::from(!self.binary)) / least;
        if count > room {
            return Err(self.fault(format!(
                "{count} {what} are claimed, but the file has room for {room} at most"
            )));
        }
        if self.binary {
            let start = self.tokens.offset();
            let end = start + count * scalar.size();
            self.tokens = text::Tokens::new(self.bytes, end);
            return Ok(scalar.decode_all(&self.bytes[start..end], true));
        }
        let mut values = Vec::with_capacity(count);
        for index in 0..count {
            let Some(token) = self.tokens.next() else {
                return Err(self.fault(format!("the file ends after {index} of {count} {what}")));
            };
            match scalar.parse(token) {
                Some(value) => values.push(value),
                None => return Err(self.fault(format!("{} is not a number", text::shown(token)))),
            }
        }
        Ok(values)
    }

    fn cells(&mut self, kind: &'static str) -> Result<Cells, IoError> {
        let count = self.count("cells")?;
        let size = self.count("cell corners")?;
        self.end_line();
        if !self.offsets {
            let records = self.numbers(size, Scalar::I32, "cell corners")?;
            return Cells::from_records(Format::Vtk, kind, count, &records);
        }
        let offsets = self.named_array(b"OFFSETS", count)?;
        let corners = self.named_array(b"CONNECTIVITY", size)?;
        let cells = Cells::from_offsets(Format::Vtk, kind, corners, &offsets)?;
        Ok(cells.without_leading_zero(count.saturating_sub(1)))
    }

    fn named_array(&mut self, name: &[u8], count: usize) -> Result<Vec<f64>, IoError> {
        let shown = String::from_utf8_lossy(name).into_owned();
        let word = self.word(&shown)?;
        if word != name {
            return Err(self.fault(format!(
                "{} was found instead of {shown}",
                text::shown(word)
            )));
        }
        let scalar = self.scalar()?;
        self.end_line();
        self.numbers(count, scalar, &shown)
    }

    pub(super) fn skip_field(&mut self) -> Result<(), IoError> {
        self.word("the name of the field")?;
        for _ in 0..self.count("arrays")? {
            self.word("the name of an array")?;
            let components = self.count("components")?;
            let tuples = self.count("tuples")?;
            let kind = self.word("a data type")?;
            self.end_line();
            let Some(scalar) = Scalar::from_legacy(kind) else {
                let what = format!(
                    "a field of type {} comes before the surface",
                    text::shown(kind)
                );
                return Err(self.fault(what));
            };
            self.numbers(components.saturating_mul(tuples), scalar, "field values")?;
        }
        Ok(())
    }

    /// Skips lines up to an empty line.
    pub(super) fn skip_metadata(&mut self) {
        self.tokens.rest_of_line();
        while self.tokens.left() > 0 && !self.tokens.rest_of_line().is_empty() {}
    }

    pub(super) fn point_count(&self) -> usize {
        self.surface.positions.len()
    }

    /// Reads the cells of a kind.
    fn primitives(&mut self, kind: Kind) -> Result<(), IoError> {
        self.ordered &= kind >= self.kind;
        self.kind = kind;
        let name = match kind {
            Kind::Points | Kind::Lines => "line",
            Kind::Polygons => "polygon",
            Kind::Strips => "triangle strip",
        };
        let cells = self.cells(name)?;
        let (surface, arrays) = (&mut self.surface, &mut self.arrays);
        match kind {
            Kind::Points | Kind::Lines => {
                surface.skipped += cells.len();
                arrays.cells += cells.len();
                Ok(())
            }
            Kind::Polygons => cells.add_polygons(Format::Vtk, 0, surface, arrays),
            Kind::Strips => cells.add_strips(Format::Vtk, 0, surface, arrays),
        }
    }

    fn finish(mut self) -> Result<Loaded, IoError> {
        if !self.ordered && !self.arrays.cell.is_empty() {
            self.arrays.cell.clear();
            let note = "cell data are left out, because the kinds of cells are not in VTK's order";
            self.surface.notes.push(note.to_owned());
        }
        self.arrays.finish(self.surface)
    }

    pub(super) fn fault(&self, what: String) -> IoError {
        let place = if self.binary {
            Location::Byte(self.tokens.offset())
        } else {
            Location::Line(self.tokens.line())
        };
        IoError::malformed(Format::Vtk, place, what)
    }
}
