//! Reads point and cell data of VTK legacy files.

use super::super::{IoError, text};
use super::arrays::Array;
use super::legacy::Reader;
use super::scalar::Scalar;
use isomend_core::mesh::attributes::Active;

impl Reader<'_> {
    /// Reads all arrays from the first `POINT_DATA` or `CELL_DATA` on. At the first fault it stops with a remark; the
    /// surface has been read before.
    pub(super) fn data(&mut self, of_points: bool) {
        if let Err(error) = self.sections(of_points) {
            let note = format!("the remaining point and cell data are left out: {error}");
            self.arrays.notes.push(note);
        }
    }

    fn sections(&mut self, mut of_points: bool) -> Result<(), IoError> {
        let mut count = self.count("values")?;
        while let Some(keyword) = self.keyword() {
            match &keyword.to_ascii_uppercase()[..] {
                b"POINT_DATA" | b"CELL_DATA" => {
                    of_points = keyword.eq_ignore_ascii_case(b"POINT_DATA");
                    count = self.count("values")?;
                }
                b"LOOKUP_TABLE" => {
                    self.word("the name of a table")?;
                    let size = self.count("colours")?;
                    self.end_line();
                    let scalar = if self.binary { Scalar::U8 } else { Scalar::F32 };
                    self.numbers(size.saturating_mul(4), scalar, "colours")?;
                }
                b"METADATA" => self.skip_metadata(),
                b"FIELD" => self.field(of_points, count)?,
                _ => {
                    let array = self.array(keyword, count)?;
                    self.add(array, of_points, count);
                }
            }
        }
        Ok(())
    }

    /// Reads an array that is introduced by its own keyword.
    fn array(&mut self, keyword: &[u8], count: usize) -> Result<Array, IoError> {
        let (use_, components) = match &keyword.to_ascii_uppercase()[..] {
            b"COLOR_SCALARS" => return self.colours(count),
            b"SCALARS" => (Active::Scalars, 1),
            b"VECTORS" => (Active::Vectors, 3),
            b"NORMALS" => (Active::Normals, 3),
            b"TEXTURE_COORDINATES" => (Active::TextureCoordinates, 0),
            b"TENSORS" => (Active::Tensors, 9),
            b"TENSORS6" => (Active::Plain, 6),
            b"GLOBAL_IDS" | b"PEDIGREE_IDS" | b"EDGE_FLAGS" => (Active::Plain, 1),
            _ => {
                let what = format!("{} is not a kind of array", text::shown(keyword));
                return Err(self.fault(what));
            }
        };
        let name = self.name()?;
        let components = match use_ {
            Active::TextureCoordinates => self.count("components")?,
            _ => components,
        };
        let scalar = self.scalar()?;
        let components = match use_ {
            Active::Scalars => self.components_and_table(),
            _ => components,
        };
        self.end_line();
        let values = self.numbers(count.saturating_mul(components), scalar, "values")?;
        Ok(Array {
            name,
            scalar,
            components,
            values,
            use_,
        })
    }

    /// Parses the optional parts after the type of scalars: the number of components and the name of a lookup table.
    pub(super) fn components_and_table(&mut self) -> usize {
        let mut components = 1;
        let mut ahead = self.tokens.clone();
        if let Some(count) = ahead.next().and_then(text::integer) {
            let mut behind = ahead.clone();
            // Without a lookup table, the next word may already be a value.
            let table = behind
                .next()
                .is_some_and(|w| w.eq_ignore_ascii_case(b"LOOKUP_TABLE"));
            let same_line = !self.bytes[self.tokens.offset()..ahead.offset()].contains(&b'\n');
            if table || same_line {
                components = usize::try_from(count).unwrap_or(1);
                self.tokens = ahead;
            }
        }
        let mut ahead = self.tokens.clone();
        if ahead
            .next()
            .is_some_and(|w| w.eq_ignore_ascii_case(b"LOOKUP_TABLE"))
        {
            ahead.next();
            self.tokens = ahead;
        }
        components
    }

    /// Reads colours: bytes in binary files, fractions of 1 in text.
    fn colours(&mut self, count: usize) -> Result<Array, IoError> {
        let name = self.name()?;
        let components = self.count("components")?;
        self.end_line();
        let scalar = if self.binary { Scalar::U8 } else { Scalar::F32 };
        let mut values = self.numbers(count.saturating_mul(components), scalar, "colours")?;
        if !self.binary {
            values
                .iter_mut()
                .for_each(|v| *v = Scalar::U8.nearest(255.0 * *v));
        }
        Ok(Array {
            name,
            scalar: Scalar::U8,
            components,
            values,
            use_: Active::Scalars,
        })
    }

    fn field(&mut self, of_points: bool, count: usize) -> Result<(), IoError> {
        self.word("the name of the field")?;
        let mut left = self.count("arrays")?;
        while left > 0 {
            let word = self.word("the name of an array")?;
            // Metadata of an array follow the array.
            if word == b"METADATA" {
                self.skip_metadata();
                continue;
            }
            left -= 1;
            let name = decoded(word);
            let components = self.count("components")?;
            let tuples = self.count("tuples")?;
            let scalar = self.scalar()?;
            self.end_line();
            let values = self.numbers(components.saturating_mul(tuples), scalar, "field values")?;
            let array = Array {
                name,
                scalar,
                components,
                values,
                use_: Active::Plain,
            };
            self.add(array, of_points, count);
        }
        Ok(())
    }

    /// Adds an array if its section's count is the number of points or cells.
    fn add(&mut self, array: Array, of_points: bool, count: usize) {
        let wanted = if of_points {
            self.point_count()
        } else {
            self.arrays.cells
        };
        if count == wanted {
            self.arrays.add(array, of_points, count);
        } else {
            let what = if of_points { "points" } else { "cells" };
            self.arrays.left_out(
                &array.name,
                &format!("it is for {count} {what}, not {wanted}"),
            );
        }
    }

    fn name(&mut self) -> Result<String, IoError> {
        Ok(decoded(self.word("the name of an array")?))
    }
}

/// Decodes a name in which `%` and two hexadecimal digits give a byte.
fn decoded(name: &[u8]) -> String {
    let mut bytes = Vec::with_capacity(name.len());
    let mut rest = name;
    while let [first, tail @ ..] = rest {
        let code = tail.get(..2).filter(|_| *first == b'%');
        let code =
            code.and_then(|digits| u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok());
        bytes.push(code.unwrap_or(*first));
        rest = if code.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
