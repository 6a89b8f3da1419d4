//! The new faces as a separate mesh: one component for each hole, with the numbers of the holes and the expected errors.

use std::collections::BTreeMap;

use super::components::Component;
use super::mark::has_face_colours;
use crate::io::Format;
use isomend_core::mesh::attributes::{
    Attribute, EXPECTED_ERROR_NAME, HOLE_NAME, LabelKind, Labels, PATCH_NAME, Role, Scalar,
};
use isomend_core::mesh::{Attributes, FaceOrigin, Mesh, Model, Origins};

/// Stored in place of an unknown expected error.
const UNKNOWN: f64 = -1.0;

/// The mended mesh that the patches are taken from.
pub(in crate::job) struct Whole<'a> {
    pub(in crate::job) mesh: &'a Mesh,
    pub(in crate::job) attributes: &'a Attributes,
    /// The first `kept` vertices are the input's.
    pub(in crate::job) kept: usize,
    /// The expected errors of the new vertices, which follow the input's.
    pub(in crate::job) expected_error: &'a [Option<f64>],
}

impl Whole<'_> {
    /// The faces of the components as a separate model, component after component; no two components share a vertex. Hole numbers and
    /// expected errors are stored where `format` has a place for them: at faces and vertices (PLY, VTK), at vertices (glTF), or hole
    /// numbers only, as groups (OBJ).
    pub(in crate::job) fn patches(&self, components: &[Component], format: Format) -> Model {
        let mut origins = Origins::default();
        let mut mesh = Mesh::default();
        let mut holes = Vec::new();
        for component in components {
            let mut number: BTreeMap<u32, u32> = BTreeMap::new();
            for &f in &component.faces {
                let face = self.mesh.faces[f as usize].map(|v| {
                    *number.entry(v).or_insert_with(|| {
                        mesh.positions.push(self.mesh.positions[v as usize]);
                        origins.vertices.push(v);
                        (origins.vertices.len() - 1) as u32
                    })
                });
                mesh.faces.push(face);
                origins.faces.push(FaceOrigin::same(f));
                holes.push(component.hole());
            }
        }
        let none = vec![false; self.mesh.faces.len()];
        let mut attributes = self.attributes.derived(&origins, &none);
        attributes.kept_of_file = None;
        attributes.copies = Vec::new();
        // All faces belong to patches, so the column that marks patches is useless; expected errors are added below.
        attributes.face.retain(|a| a.name != PATCH_NAME);
        attributes.vertex.retain(|a| a.name != EXPECTED_ERROR_NAME);
        if !has_face_colours(format) {
            attributes.face.retain(|a| a.role != Role::Colour);
        }
        attributes.labels.retain(|l| l.kind != LabelKind::Group);
        match format {
            _ if has_columns(format) => {
                attributes.face.push(numbers(holes.iter().copied()));
                attributes.vertex.push(self.errors(&origins));
            }
            Format::Gltf | Format::Glb => {
                let mut of_vertex = vec![0; mesh.positions.len()];
                for (face, hole) in mesh.faces.iter().zip(&holes) {
                    face.iter().for_each(|v| of_vertex[*v as usize] = *hole);
                }
                attributes.vertex.push(numbers(of_vertex.into_iter()));
                attributes.vertex.push(self.errors(&origins));
            }
            Format::Obj => {
                let mut groups = Labels::new(LabelKind::Group);
                let group = |hole: &usize| groups.place(&format!("{HOLE_NAME}_{hole}"));
                groups.of_face = holes.iter().map(group).collect();
                attributes.labels.push(groups);
            }
            _ => {}
        }
        Model {
            mesh,
            attributes,
            notes: Vec::new(),
        }
    }

    /// The expected errors of the vertices: 0 at rims, negative where unknown.
    fn errors(&self, origins: &Origins) -> Attribute {
        let mut errors = Attribute::new(EXPECTED_ERROR_NAME, Role::Other, Scalar::F32, 1);
        for &v in &origins.vertices {
            let own = (v as usize).checked_sub(self.kept);
            let error = match own.and_then(|i| self.expected_error.get(i)) {
                None if own.is_some() && self.expected_error.is_empty() => UNKNOWN,
                None => 0.0,
                Some(error) => error.unwrap_or(UNKNOWN),
            };
            errors.push(Some(&[error]));
        }
        errors
    }
}

/// Hole numbers as an attribute.
fn numbers(holes: impl Iterator<Item = usize>) -> Attribute {
    let mut numbers = Attribute::new(HOLE_NAME, Role::Other, Scalar::I32, 1);
    holes.for_each(|hole| numbers.push(Some(&[hole as f64])));
    numbers
}

/// Whether files of a format hold named numbers of vertices and of faces.
pub(in crate::job) fn has_columns(format: Format) -> bool {
    matches!(
        format,
        Format::Ply | Format::Vtk | Format::Vtp | Format::Usda | Format::Usdz
    )
}
