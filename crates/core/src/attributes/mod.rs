//! Continues the attributes of a mesh on its patches: colours, normals, texture coordinates, materials, groups.
//!
//! Attributes of the input's vertices, faces and corners are unchanged. On patches, values are interpolated
//! harmonically from the rim. Normals follow the patch's shape, corrected to match the given normals at the rim.
//! Integers that are not colours, for example a scan number, are copied from the nearest rim vertex. Texture
//! coordinates are interpolated if the whole rim is in one chart; otherwise the patch has none, and a separate
//! material.

mod charts;
mod field;
mod harmonic;
mod rim;
#[cfg(test)]
mod tests;
mod unwanted;
mod vertices;

use std::collections::BTreeMap;

use glam::DVec3;

use crate::mesh::attributes::{
    Attribute, CornerAttribute, EXPECTED_ERROR_NAME, LabelKind, Labels, NONE, PATCH_NAME, Role,
    Scalar,
};
use crate::mesh::{Attributes, Bodies, FaceOrigin, Mesh, Model, area_vector};
pub use field::FieldSource;
pub use harmonic::Laplacian;
pub use rim::{Patches, Slot};
pub use unwanted::UnwantedColour;

use field::Field;

/// The beginning of the remark on patches without texture coordinates.
pub const SEAM_NOTE: &str =
    "patches without texture coordinates, because their rims cross seams of the texture";
/// Stored in place of an unknown expected error.
const UNKNOWN: f64 = -1.0;
/// The lengths that 32-bit floats hold with full precision.
const SINGLE: std::ops::Range<f64> = 1e-30..1e38;

/// Extends the attributes of a mesh to the patches that fill its holes.
///
/// `filled` begins with the vertices and faces of `original`; the others are new. In the result, corners of patches at
/// the rim may use another vertex at the same position: the one that the input's faces use there or, where these use
/// several with different values, a copy after all other vertices. The notes say what could not be continued.
pub fn transfer(original: &Mesh, attributes: &Attributes, filled: Mesh) -> Model {
    transfer_without(original, attributes, filled, &[])
}

/// As [`transfer`], but vertex colours that are unwanted are not continued from the rims: the colours behind them are.
pub fn transfer_without(
    original: &Mesh,
    attributes: &Attributes,
    filled: Mesh,
    unwanted: &[UnwantedColour],
) -> Model {
    let new_faces = filled.faces.len() - original.faces.len();
    let mut out = Model {
        mesh: filled,
        attributes: attributes.clone(),
        notes: Vec::new(),
    };
    if !attributes.is_empty() && new_faces > 0 {
        Transfer::new(original, attributes, &out.mesh, unwanted).finish(&mut out);
    }
    mark_patches(&mut out.attributes, original.faces.len(), new_faces);
    if let Some(of) = &mut out.attributes.file_faces {
        of.resize(original.faces.len() + new_faces, FaceOrigin::NEW);
    }
    out
}

impl Model {
    /// Stores the expected errors of the patches' vertices, which follow the `kept` vertices of the input, as the
    /// vertex attribute [`EXPECTED_ERROR_NAME`] in units of length. Input vertices keep the errors of an earlier run, or get 0.
    /// Vertices without a known error get −1. Adds nothing if no error is known, from this run or an earlier one. An
    /// empty `expected_error`, as for a faired surface, means that no error is known for the new vertices.
    pub fn set_expected_errors(&mut self, kept: usize, expected_error: &[Option<f64>]) {
        let own = |a: &Attribute| a.name == EXPECTED_ERROR_NAME && a.components == 1;
        let place = self.attributes.vertex.iter().position(own);
        if expected_error.iter().all(Option::is_none) && place.is_none() {
            return;
        }
        let largest = expected_error.iter().flatten().copied().fold(0.0, f64::max);
        // Very small or large lengths need 64-bit floats.
        let scalar = match SINGLE.contains(&largest) {
            true => Scalar::F32,
            false => Scalar::F64,
        };
        let all = &mut self.attributes.vertex;
        let mut errors = match place {
            Some(place) => all.remove(place),
            None => Attribute::new(EXPECTED_ERROR_NAME, Role::Other, scalar, 1),
        };
        let earlier = std::mem::take(&mut errors.values);
        let count = self.mesh.positions.len();
        errors.values.reserve_exact(count);
        for v in 0..count {
            let value = match v.checked_sub(kept).map(|i| expected_error.get(i)) {
                None => earlier.get(v).copied().unwrap_or(0.0),
                Some(Some(error)) => error.unwrap_or(UNKNOWN),
                Some(None) if expected_error.is_empty() => UNKNOWN,
                // Copies of rim vertices.
                Some(None) => 0.0,
            };
            errors.push(Some(&[value]));
        }
        errors.missing = Vec::new();
        self.attributes.vertex.push(errors);
    }
}

/// Marks the `new` faces after the first `kept`, and keeps the marks of an earlier run.
fn mark_patches(attributes: &mut Attributes, kept: usize, new: usize) {
    let found = attributes
        .face
        .iter()
        .position(|a| a.name == PATCH_NAME && a.components == 1);
    let at = found.unwrap_or_else(|| {
        let marks = Attribute::new(PATCH_NAME, Role::Other, Scalar::U8, 1);
        attributes.face.push(marks);
        attributes.face.len() - 1
    });
    let marks = &mut attributes.face[at];
    marks.values.truncate(kept);
    let missing = kept + new - marks.values.len();
    marks.values.reserve_exact(missing);
    marks.values.resize(kept, 0.0);
    marks.missing.truncate(kept);
    for _ in 0..new {
        marks.push(Some(&[1.0]));
    }
}

/// The data needed to continue attributes on patches.
struct Transfer<'a> {
    original: &'a Mesh,
    before: &'a Attributes,
    patches: Patches,
    laplacian: Laplacian,
    /// Normals of the filled mesh's shape at the slots.
    normals: Vec<DVec3>,
    /// Whether the rim of a patch is in several charts.
    has_seam_at_rim: Vec<bool>,
    /// Colours that are not continued.
    unwanted: &'a [UnwantedColour],
}

impl<'a> Transfer<'a> {
    fn new(
        original: &'a Mesh,
        before: &'a Attributes,
        filled: &Mesh,
        unwanted: &'a [UnwantedColour],
    ) -> Self {
        let bodies = Bodies::new(original, before);
        let patches = Patches::new(original, filled, bodies.as_ref());
        let points: Vec<DVec3> = patches
            .slots
            .iter()
            .map(|s| filled.positions[s.vertex as usize])
            .collect();
        let laplacian = Laplacian::new(&points, &patches.faces);
        let normals = shape_normals(&patches, &points, original);
        let has_seam_at_rim = vec![false; patches.rim_faces.len()];
        let mut transfer = Self {
            original,
            before,
            patches,
            laplacian,
            normals,
            has_seam_at_rim,
            unwanted,
        };
        transfer.find_seams_at_rims();
        transfer
    }

    /// Finds the patches whose rim is not in a single chart, for any set of texture coordinates at the rim.
    fn find_seams_at_rims(&mut self) {
        let vertex = self.before.vertex.iter().map(FieldSource::Vertex);
        let sources = vertex.chain(self.before.corner.iter().map(FieldSource::Corner));
        let materials = self.before.labels_of(LabelKind::Material);
        for source in sources.filter(|s| matches!(s.attribute().role, Role::Uv(_))) {
            let field = Field::at_rim(self.original, &self.patches, &source);
            let chart = charts::charts(self.original, &self.patches.weld, &source, materials);
            let mut some = vec![false; self.has_seam_at_rim.len()];
            for (s, slot) in self.patches.slots.iter().enumerate() {
                let patch = slot.patch as usize;
                some[patch] |= field.get(s).is_some();
                self.has_seam_at_rim[patch] |= !field.is_single(s);
            }
            for (patch, faces) in self.patches.rim_faces.iter().enumerate() {
                let one_chart = faces
                    .windows(2)
                    .all(|f| chart[f[0] as usize] == chart[f[1] as usize]);
                self.has_seam_at_rim[patch] |= some[patch] && !one_chart;
            }
        }
    }

    /// The values of an attribute at all slots.
    fn field(&self, source: &FieldSource<'_>) -> Field {
        let mut field = Field::at_rim(self.original, &self.patches, source);
        let instead = unwanted::instead(self, source, &field);
        let (laplacian, normals) = (&self.laplacian, &self.normals);
        field.spread(&self.patches, laplacian, source, normals, &instead);
        if matches!(source.attribute().role, Role::Uv(_)) {
            for (s, slot) in self.patches.slots.iter().enumerate() {
                if self.has_seam_at_rim[slot.patch as usize] {
                    field.clear(s);
                }
            }
        }
        field
    }

    fn finish(&self, out: &mut Model) {
        let face = self.before.face.iter().filter(|a| a.name != PATCH_NAME);
        out.attributes.face = face.map(|a| self.face_attribute(a)).collect();
        out.attributes.corner = self
            .before
            .corner
            .iter()
            .map(|a| self.corner_attribute(a))
            .collect();
        out.attributes.labels = self.labels();
        let marks = self.before.face.iter().filter(|a| a.name == PATCH_NAME);
        out.attributes.face.extend(marks.cloned());
        vertices::finish(self, out);
        let without = self.has_seam_at_rim.iter().filter(|c| **c).count();
        if without > 0 {
            out.notes.push(format!(
                "{SEAM_NOTE}: {without} of {}",
                self.has_seam_at_rim.len()
            ));
        }
    }

    fn face_attribute(&self, before: &Attribute) -> Attribute {
        let mut after = before.clone();
        let source = FieldSource::Face(before);
        let (field, blends) = (self.field(&source), source.blends());
        for slots in &self.patches.faces {
            let values: Vec<&[f64]> = slots
                .iter()
                .filter_map(|&s| field.get(s as usize))
                .collect();
            let mean: Option<Vec<f64>> = values.first().map(|first| {
                let mean =
                    |c: usize| values.iter().map(|v| v[c]).sum::<f64>() / values.len() as f64;
                match blends {
                    true => (0..before.components).map(mean).collect(),
                    false => first.to_vec(),
                }
            });
            after.push(mean.as_deref());
        }
        after
    }

    fn corner_attribute(&self, before: &CornerAttribute) -> CornerAttribute {
        let mut after = before.clone();
        let field = self.field(&FieldSource::Corner(before));
        let mut places = vec![NONE; self.patches.slots.len()];
        for (s, slot) in self.patches.slots.iter().enumerate() {
            let Some(value) = field.get(s) else { continue };
            let at_rim = slot.rim.first().filter(|_| field.is_single(s));
            places[s] = match at_rim {
                Some(&(f, k)) => before.corners[f as usize][usize::from(k)],
                None => {
                    after.pool.push(Some(value));
                    after.pool.len() as u32 - 1
                }
            };
        }
        let new = self.patches.faces.iter();
        after
            .corners
            .extend(new.map(|f| f.map(|s| places[s as usize])));
        after
    }

    fn labels(&self) -> Vec<Labels> {
        let mut all = self.before.labels.clone();
        let has_materials = all.iter().any(|l| l.kind == LabelKind::Material);
        if !has_materials && !self.before.libraries.is_empty() {
            let mut materials = Labels::new(LabelKind::Material);
            materials.of_face = vec![NONE; self.original.faces.len()];
            all.push(materials);
        }
        for labels in &mut all {
            let of_patch: Vec<u32> = (0..self.has_seam_at_rim.len())
                .map(|patch| match labels.kind {
                    LabelKind::Group => labels.place(PATCH_NAME),
                    LabelKind::Material if self.has_seam_at_rim[patch] => labels.place(PATCH_NAME),
                    _ => most_frequent(self.patches.rim_faces[patch].iter(), labels),
                })
                .collect();
            let new = self.patches.of_face.iter();
            labels.of_face.extend(new.map(|p| of_patch[*p as usize]));
        }
        all
    }
}

/// The label of most faces; the smallest index among equals.
fn most_frequent<'a>(faces: impl Iterator<Item = &'a u32>, labels: &Labels) -> u32 {
    let mut count: BTreeMap<u32, usize> = BTreeMap::new();
    for face in faces {
        *count.entry(labels.of_face[*face as usize]).or_default() += 1;
    }
    let most = count
        .iter()
        .max_by_key(|(label, n)| (**n, u32::MAX - **label));
    most.map_or(NONE, |(label, _)| *label)
}

/// Unit normals at the slots: area-weighted mean over the new faces and the input's faces at the rim edges.
fn shape_normals(patches: &Patches, points: &[DVec3], original: &Mesh) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; points.len()];
    for face in &patches.faces {
        let normal = area_vector(face.map(|s| points[s as usize]));
        face.iter().for_each(|&s| normals[s as usize] += normal);
    }
    for (s, slot) in patches.slots.iter().enumerate() {
        for &(f, _) in &slot.rim {
            normals[s] += area_vector(original.corners(f));
        }
    }
    normals.iter().map(|n| n.normalize_or(DVec3::Z)).collect()
}
