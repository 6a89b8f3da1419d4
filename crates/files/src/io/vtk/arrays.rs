//! Point and cell data arrays of VTK files, and their conversion to attributes.

use std::collections::{BTreeMap, HashSet};

use super::super::mesh_builder::{CutFrom, MeshBuilder};
use super::super::{IoError, Loaded};
use super::scalar::Scalar;
use isomend_core::mesh::attributes::{Active, Attribute, Role};

/// The data arrays collected while a file is read.
#[derive(Default)]
pub(super) struct Arrays {
    /// Point data.
    pub(super) point: Vec<Attribute>,
    /// Cell data, in the order of the file's cells.
    pub(super) cell: Vec<Attribute>,
    /// For each face added, the index of its cell, counted over all kinds of cells.
    pub(super) cell_of_face: Vec<u32>,
    /// The number of cells, including skipped points and lines.
    pub(super) cells: usize,
    /// Remarks for the user.
    pub(super) notes: Vec<String>,
    /// The names in use: of cell data, of point data.
    pub(super) names: [HashSet<String>; 2],
}

/// A data array of a file that is read or written.
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
            // VTK displays such bytes as colours.
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
    /// Adds an array. An array without a value for each point or cell is left out, with a remark.
    pub(super) fn add(&mut self, array: Array, of_points: bool, count: usize) {
        let fits =
            array.components > 0 && array.values.len() == count.saturating_mul(array.components);
        if !fits {
            self.left_out(
                &array.name,
                "it does not have one value for each point or cell",
            );
            return;
        }
        let list = if of_points {
            &mut self.point
        } else {
            &mut self.cell
        };
        let mut attribute = array.attribute(of_points);
        // If several arrays are active for a use, VTK takes the first.
        if list.iter().any(|a| a.active == attribute.active) {
            attribute.active = Some(Active::Plain);
        }
        if !self.names[usize::from(of_points)].insert(attribute.name.clone()) {
            self.left_out(&attribute.name, "another array has the same name");
            return;
        }
        list.push(attribute);
    }

    /// Adds the remark that an array is left out.
    pub(super) fn left_out(&mut self, name: &str, why: &str) {
        self.notes
            .push(format!("the array '{name}' is left out: {why}"));
    }

    /// Records `cell` as the origin of the faces that were added last.
    pub(super) fn set_origin(&mut self, surface: &MeshBuilder, cell: usize) {
        self.cell_of_face.resize(surface.face_count(), cell as u32);
    }

    /// Appends the arrays of another VTK piece, whose points and cells follow. Arrays that not all pieces have are left
    /// out.
    pub(super) fn append(&mut self, mut piece: Arrays, first: bool) {
        self.notes.append(&mut piece.notes);
        self.cell_of_face.append(&mut piece.cell_of_face);
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

    /// Finishes the surface with its attributes.
    pub(super) fn finish(mut self, mut surface: MeshBuilder) -> Result<Loaded, IoError> {
        surface.notes.append(&mut self.notes);
        let mut cut = (!self.cell.is_empty()).then(|| CutFrom::identity(0));
        let mut loaded = surface.finish_with(&mut cut)?;
        if let Some(cut) = cut {
            let cell_of_face = cut
                .face
                .iter()
                .map(|f| self.cell_of_face[*f as usize] as usize);
            let cell_of_face: Vec<usize> = cell_of_face.collect();
            loaded.attributes.face = self
                .cell
                .iter()
                .map(|a| a.selected(cell_of_face.iter().copied()))
                .collect();
        }
        loaded.attributes.vertex = self.point;
        Ok(loaded)
    }
}
