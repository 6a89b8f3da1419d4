//! Points and cells in VTK's layouts, and their conversion to faces.

use glam::DVec3;

use super::super::mesh_builder::MeshBuilder;
use super::super::{Format, IoError, Location};
use super::arrays::Arrays;

/// Cells of any number of corners: all corners in sequence, and the end of each cell in that sequence.
#[derive(Default)]
pub(super) struct Cells {
    corners: Vec<f64>,
    ends: Vec<usize>,
}

impl Cells {
    /// Parses `n i₁ … iₙ` records.
    pub(super) fn from_records(
        format: Format,
        kind: &'static str,
        count: usize,
        records: &[f64],
    ) -> Result<Self, IoError> {
        let mut cells = Cells::default();
        let mut rest = records;
        for index in 0..count {
            let cell = rest.split_first().and_then(|(size, tail)| {
                let size = (*size >= 0.0 && size.fract() == 0.0).then_some(*size as usize)?;
                (size <= tail.len()).then(|| tail.split_at(size))
            });
            let Some((corners, tail)) = cell else {
                let what = "its corners do not fit in the size given for all cells";
                return Err(IoError::malformed(
                    format,
                    Location::Item(kind, index),
                    what,
                ));
            };
            cells.corners.extend_from_slice(corners);
            cells.ends.push(cells.corners.len());
            rest = tail;
        }
        Ok(cells)
    }

    /// From the corners and the offsets at which cells end; a leading zero becomes an empty first cell.
    pub(super) fn from_offsets(
        format: Format,
        kind: &'static str,
        corners: Vec<f64>,
        offsets: &[f64],
    ) -> Result<Self, IoError> {
        let mut ends = Vec::with_capacity(offsets.len());
        let mut last = 0;
        for (index, offset) in offsets.iter().enumerate() {
            let end = *offset as usize;
            if end as f64 != *offset || end < last || end > corners.len() {
                let what = format!(
                    "its end {offset} is not between {last} and the {} corners there are",
                    corners.len()
                );
                return Err(IoError::malformed(
                    format,
                    Location::Item(kind, index),
                    what,
                ));
            }
            ends.push(end);
            last = end;
        }
        Ok(Cells { corners, ends })
    }

    /// Removes the empty first cell of a leading zero offset.
    pub(super) fn without_leading_zero(mut self, count: usize) -> Self {
        if self.ends.len() == count + 1 && self.ends.first() == Some(&0) {
            self.ends.remove(0);
        }
        self
    }

    /// The number of cells.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// Calls `add` with each cell and its corners; `base` is added to each corner index.
    pub(super) fn each(
        &self,
        format: Format,
        kind: &'static str,
        base: usize,
        mut add: impl FnMut(usize, &[u32]) -> Result<(), IoError>,
    ) -> Result<(), IoError> {
        let (mut start, mut indices) = (0, Vec::new());
        for (cell, end) in self.ends.iter().enumerate() {
            indices.clear();
            for corner in &self.corners[start..*end] {
                let index = corner + base as f64;
                if *corner < 0.0 || f64::from(index as u32) != index {
                    let what = format!("it uses point {corner}, which is not a valid index");
                    return Err(IoError::malformed(format, Location::Item(kind, cell), what));
                }
                indices.push(index as u32);
            }
            add(cell, &indices)?;
            start = *end;
        }
        Ok(())
    }

    /// Adds the cells as polygons.
    pub(super) fn add_polygons(
        &self,
        format: Format,
        base: usize,
        surface: &mut MeshBuilder,
        arrays: &mut Arrays,
    ) -> Result<(), IoError> {
        let first = arrays.cells;
        arrays.cells += self.len();
        self.each(format, "polygon", base, |cell, corners| {
            surface.push_face(corners)?;
            arrays.set_origin(surface, first + cell);
            Ok(())
        })
    }

    /// Adds the cells as triangle strips.
    pub(super) fn add_strips(
        &self,
        format: Format,
        base: usize,
        surface: &mut MeshBuilder,
        arrays: &mut Arrays,
    ) -> Result<(), IoError> {
        let first = arrays.cells;
        arrays.cells += self.len();
        self.each(format, "triangle strip", base, |cell, corners| {
            surface.push_strip(corners);
            arrays.set_origin(surface, first + cell);
            Ok(())
        })
    }

    /// Adds the cells of an unstructured grid according to their types.
    pub(super) fn add_typed(
        &self,
        format: Format,
        types: &[f64],
        surface: &mut MeshBuilder,
        arrays: &mut Arrays,
    ) -> Result<(), IoError> {
        if types.len() != self.len() {
            let what = format!(
                "there are {} cells, but {} cell types",
                self.len(),
                types.len()
            );
            return Err(IoError::malformed(format, Location::File, what));
        }
        arrays.cells += self.len();
        self.each(format, "cell", 0, |cell, corners| {
            match (types[cell] as i64, corners) {
                (1..=4, _) => surface.skipped += 1,
                (5 | 7 | 9, _) => surface.push_face(corners)?,
                (6, _) => surface.push_strip(corners),
                (8, [a, b, c, d]) => surface.push_face(&[*a, *b, *d, *c])?,
                (other, _) => return Err(solid_cell(format, cell, other)),
            }
            arrays.set_origin(surface, cell);
            Ok(())
        })
    }
}

fn solid_cell(format: Format, cell: usize, type_: i64) -> IoError {
    let name = match type_ {
        10 => "a tetrahedron",
        11 => "a voxel",
        12 => "a hexahedron",
        13 => "a wedge",
        14 => "a pyramid",
        42 => "a polyhedron",
        21..=37 => "a curved cell",
        _ => "not a triangle, quad, polygon or strip",
    };
    IoError::Unsupported {
        format,
        what: format!("cell {cell} is of type {type_}, {name}, and the file is not a surface"),
        advice: "extract its surface first, for example with ParaView's 'Extract Surface'",
    }
}

/// Appends points given as x y z, x y z, …
pub(super) fn add_points(surface: &mut MeshBuilder, values: &[f64]) {
    surface
        .positions
        .extend(values.chunks_exact(3).map(|p| DVec3::new(p[0], p[1], p[2])));
}
