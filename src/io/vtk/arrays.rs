//! Arrays of point and cell data, and how they become attributes.

use std::collections::{BTreeMap, HashSet};

use super::super::mesh_builder::{CutFrom, MeshBuilder};
use super::super::{IoError, Loaded};
use super::scalar::Scalar;
use crate::mesh::attributes::{Active, Attribute, Role};

/// The arrays of a file under construction.
#[derive(Default)]
pub(super) struct Arrays {
    /// Of points.
    pub(super) point: Vec<Attribute>,
    /// Of cells, in the file's order.
    pub(super) cell: Vec<Attribute>,
    /// For each face that was added the cell that it came from, over all kinds of cells.
    pub(super) rows: Vec<u32>,
    /// How many cells there are, those passed over included.
    pub(super) cells: usize,
    /// Remarks for the user.
    pub(super) notes: Vec<String>,
    /// The names of the arrays of cells and of points.
    pub(super) names: [HashSet<String>; 2],
}

/// One array as it stands in a file.
pub(super) struct Array {
    pub(super) name: String,
    pub(super) scalar: Scalar,
    pub(super) components: usize,
    pub(super) values: Vec<f64>,
    pub(super) use_: Active,
}

impl Array {
    fn attribute(self, of_points: bool) -> Attribute {
        let role = match (self.use_, self.scalar, self.components) {
            (Active::Normals, _, 3) if of_points => Role::Normal,
            (Active::TextureCoordinates, _, 2) if of_points => Role::Uv(0),
            // VTK shows such bytes as colours.
            (Active::Scalars | Active::Plain, Scalar::U8, 3 | 4) => Role::Colour,
            _ => Role::Other,
        };
        Attribute {
            values: self.values,
            active: Some(self.use_),
            ..Attribute::new(&self.name, role, self.scalar, self.components)
        }
    }
}

impl Arrays {
    /// Adds an array, which must have a value for each point or cell; one that has not is left out with a remark.
    pub(super) fn add(&mut self, array: Array, of_points: bool, count: usize) {
        let fits =
            array.components > 0 && array.values.len() == count.saturating_mul(array.components);
        if !fits {
            self.left_out(&array.name, "it has not one value for each point or cell");
            return;
        }
        let list = if of_points {
            &mut self.point
        } else {
            &mut self.cell
        };
        let mut attribute = array.attribute(of_points);
        // Of several arrays for a use the first is the one that VTK uses.
        if list.iter().any(|a| a.active == attribute.active) {
            attribute.active = Some(Active::Plain);
        }
        if !self.names[usize::from(of_points)].insert(attribute.name.clone()) {
            self.left_out(&attribute.name, "there is one of that name already");
            return;
        }
        list.push(attribute);
    }

    /// Says that an array is left out.
    pub(super) fn left_out(&mut self, name: &str, why: &str) {
        self.notes
            .push(format!("the array '{name}' is left out: {why}"));
    }

    /// Says of the faces that were added last from which cell they came.
    pub(super) fn came_from(&mut self, surface: &MeshBuilder, cell: usize) {
        self.rows.resize(surface.face_count(), cell as u32);
    }

    /// Appends the arrays of another piece, whose points and cells come after these. Arrays that only one of them has are
    /// left out.
    pub(super) fn append(&mut self, mut piece: Arrays, first: bool) {
        self.notes.append(&mut piece.notes);
        self.rows.append(&mut piece.rows);
        self.cells += piece.cells;
        if first {
            (self.point, self.cell) = (piece.point, piece.cell);
            return;
        }
        let mut notes = Vec::new();
        for (all, new) in [(&mut self.point, piece.point), (&mut self.cell, piece.cell)] {
            let mut new: BTreeMap<String, Attribute> =
                new.into_iter().map(|a| (a.name.clone(), a)).collect();
            all.retain_mut(|a| {
                let same = |b: &Attribute| a.scalar == b.scalar && a.components == b.components;
                match new.remove(&a.name) {
                    Some(b) if same(&b) => {
                        a.values.extend_from_slice(&b.values);
                        true
                    }
                    _ => {
                        notes.push(a.name.clone());
                        false
                    }
                }
            });
            notes.extend(new.into_keys());
        }
        for name in notes {
            self.left_out(&name, "not all pieces have it");
        }
    }

    /// Finishes a surface together with its arrays.
    pub(super) fn finish(mut self, mut surface: MeshBuilder) -> Result<Loaded, IoError> {
        surface.notes.append(&mut self.notes);
        let mut cut = (!self.cell.is_empty()).then(|| CutFrom::identity(0));
        let mut loaded = surface.finish_with(&mut cut)?;
        if let Some(cut) = cut {
            let rows = cut.face.iter().map(|f| self.rows[*f as usize] as usize);
            let rows: Vec<usize> = rows.collect();
            loaded.attributes.face = self
                .cell
                .iter()
                .map(|a| a.selected(rows.iter().copied()))
                .collect();
        }
        loaded.attributes.vertex = self.point;
        Ok(loaded)
    }
}
