//! Reads VTK legacy files of structured points as a volume.

use glam::DVec3;

use super::super::{Format, IoError, text};
use super::image::{check_geometry, choose};
use super::legacy::Reader;
use super::scalar::Scalar;
use isomend_core::grid::Volume;

/// Reads a point data array as a volume.
pub(in super::super) fn read(bytes: &[u8], wanted: Option<&str>) -> Result<Volume, IoError> {
    let mut reader = Reader::open(bytes)?;
    let dataset = reader.word("the kind of data set")?.to_ascii_uppercase();
    if dataset != b"STRUCTURED_POINTS" {
        return Err(IoError::Unsupported {
            format: Format::Vtk,
            what: format!(
                "the file holds {}, not a volume",
                String::from_utf8_lossy(&dataset)
            ),
            advice: "sample it on a regular lattice first and save it as STRUCTURED_POINTS",
        });
    }
    let mut image = Image::default();
    while let Some(keyword) = reader.keyword() {
        image.section(&mut reader, &keyword.to_ascii_uppercase())?;
    }
    image
        .finish(wanted)
        .map_err(|error| error.of_format(Format::Vtk))
}

#[derive(Default)]
struct Image {
    dims: Option<[usize; 3]>,
    origin: [f64; 3],
    spacing: Option<[f64; 3]>,
    /// Whether the arrays being read belong to nodes, not to cells.
    of_points: bool,
    of_cells: bool,
    arrays: Vec<(String, Vec<f64>)>,
}

impl Image {
    fn section(&mut self, reader: &mut Reader<'_>, keyword: &[u8]) -> Result<(), IoError> {
        match keyword {
            b"DIMENSIONS" => {
                let mut dims = [0; 3];
                for count in &mut dims {
                    *count = reader.count("nodes")?;
                }
                self.dims = Some(dims);
            }
            b"ORIGIN" => self.origin = triple(reader, "the origin")?,
            b"SPACING" | b"ASPECT_RATIO" => {
                self.spacing = Some(triple(reader, "the spacing")?);
            }
            b"POINT_DATA" => {
                reader.count("nodes")?;
                self.of_points = true;
            }
            b"CELL_DATA" => {
                reader.count("cells")?;
                self.of_points = false;
                self.of_cells = true;
            }
            b"SCALARS" => self.scalars(reader)?,
            b"LOOKUP_TABLE" => {
                reader.word("the name of a table")?;
                let size = reader.count("colours")?;
                reader.end_line();
                reader.numbers(size.saturating_mul(4), Scalar::U8, "colours")?;
            }
            b"FIELD" => self.field(reader)?,
            b"VECTORS" | b"NORMALS" => {
                reader.word("the name of an array")?;
                let scalar = reader.scalar()?;
                reader.end_line();
                let count = self.items(reader)?.saturating_mul(3);
                reader.numbers(count, scalar, "vectors")?;
            }
            b"METADATA" => reader.skip_metadata(),
            _ => {
                let what = format!(
                    "{} is not a supported section of a volume",
                    text::shown(keyword)
                );
                return Err(reader.fault(what));
            }
        }
        Ok(())
    }

    /// The number of nodes or cells that an array must have values for.
    fn items(&self, reader: &Reader<'_>) -> Result<usize, IoError> {
        let Some(dims) = self.dims else {
            return Err(reader.fault("the values come before the dimensions".to_owned()));
        };
        let less = usize::from(!self.of_points);
        let product = dims
            .iter()
            .try_fold(1usize, |n, d| n.checked_mul(d.saturating_sub(less).max(1)));
        product.ok_or_else(|| reader.fault("there are too many nodes".to_owned()))
    }

    fn scalars(&mut self, reader: &mut Reader<'_>) -> Result<(), IoError> {
        let name = String::from_utf8_lossy(reader.word("the name of an array")?).into_owned();
        let scalar = reader.scalar()?;
        let components = reader.components_and_table();
        reader.end_line();
        let count = self.items(reader)?.saturating_mul(components);
        let values = reader.numbers(count, scalar, "values")?;
        if self.of_points && components == 1 {
            self.arrays.push((name, values));
        }
        Ok(())
    }

    fn field(&mut self, reader: &mut Reader<'_>) -> Result<(), IoError> {
        reader.word("the name of the field")?;
        for _ in 0..reader.count("arrays")? {
            let name = String::from_utf8_lossy(reader.word("the name of an array")?).into_owned();
            let components = reader.count("components")?;
            let tuples = reader.count("tuples")?;
            let scalar = reader.scalar()?;
            reader.end_line();
            let values =
                reader.numbers(components.saturating_mul(tuples), scalar, "field values")?;
            if self.of_points && components == 1 {
                self.arrays.push((name, values));
            }
        }
        Ok(())
    }

    fn finish(mut self, wanted: Option<&str>) -> Result<Volume, IoError> {
        let fault =
            |what: String| IoError::malformed(Format::Vtk, super::super::Location::File, what);
        let dims = self
            .dims
            .ok_or_else(|| fault("the volume has no dimensions".to_owned()))?;
        let names: Vec<String> = self.arrays.iter().map(|a| a.0.clone()).collect();
        let place = choose(&names, wanted, self.of_cells)?;
        let (_, values) = self.arrays.swap_remove(place);
        let total = dims[0]
            .checked_mul(dims[1])
            .and_then(|n| n.checked_mul(dims[2]));
        if total != Some(values.len()) || values.is_empty() {
            let what = format!("there are {} values for {dims:?} nodes", values.len());
            return Err(fault(what));
        }
        let origin = DVec3::from_array(self.origin);
        let spacing = DVec3::from_array(self.spacing.unwrap_or([1.0; 3]));
        check_geometry(origin, spacing).map_err(fault)?;
        Ok(Volume {
            dims,
            origin,
            spacing,
            values,
        })
    }
}

fn triple(reader: &mut Reader<'_>, what: &str) -> Result<[f64; 3], IoError> {
    let mut values = [0.0; 3];
    for value in &mut values {
        let word = reader.word(what)?;
        *value = text::number(word)
            .ok_or_else(|| reader.fault(format!("{} is not a number", text::shown(word))))?;
    }
    Ok(values)
}
