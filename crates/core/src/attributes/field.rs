//! Values of an attribute on the patches: from the input at the rim, continued inside.

use glam::DVec3;

use super::harmonic::Laplacian;
use super::rim::Patches;
use crate::mesh::Mesh;
use crate::mesh::attributes::{Attribute, CornerAttribute, NONE, Role, same_value};

/// Where the values of the input's face corners are stored.
#[derive(Clone, Copy)]
pub enum FieldSource<'a> {
    Vertex(&'a Attribute),
    Corner(&'a CornerAttribute),
    Face(&'a Attribute),
}

impl<'a> FieldSource<'a> {
    /// The value at a corner of a face of the mesh.
    pub fn at(&self, mesh: &Mesh, face: usize, corner: usize) -> Option<&'a [f64]> {
        match self {
            FieldSource::Vertex(a) => a.get(mesh.faces[face][corner] as usize),
            FieldSource::Corner(a) => a.get(face, corner),
            FieldSource::Face(a) => a.get(face),
        }
    }

    /// The attribute, as a pool of values.
    pub fn attribute(&self) -> &'a Attribute {
        match self {
            FieldSource::Vertex(a) | FieldSource::Face(a) => a,
            FieldSource::Corner(a) => &a.pool,
        }
    }

    /// Whether values may be averaged. Integers that are not colours or normalised, such as a scan number, may not.
    pub(super) fn blends(&self) -> bool {
        let a = self.attribute();
        a.scalar.is_float() || a.normalized || a.role != Role::Other
    }
}

/// A slot at the rim and the value to continue from there instead of its own; none if there is none.
pub(super) type Instead = (usize, Option<Vec<f64>>);

/// Values with `components` components at all slots.
pub(super) struct Field {
    components: usize,
    values: Vec<f64>,
    has: Vec<bool>,
    /// Whether all input corners at a rim slot have the same value.
    agrees: Vec<bool>,
}

impl Field {
    /// The value at a slot.
    pub(super) fn get(&self, slot: usize) -> Option<&[f64]> {
        let at = slot * self.components;
        self.has[slot].then(|| &self.values[at..at + self.components])
    }

    /// Whether all input corners at a rim slot have the same value.
    pub(super) fn is_single(&self, slot: usize) -> bool {
        self.agrees[slot]
    }

    /// Removes the value of a slot.
    pub(super) fn clear(&mut self, slot: usize) {
        self.has[slot] = false;
    }

    /// The values at the rim: at each rim slot the mean over its input corners.
    pub(super) fn at_rim(mesh: &Mesh, patches: &Patches, source: &FieldSource<'_>) -> Self {
        let (count, components) = (patches.slots.len(), source.attribute().components);
        let mut field = Self {
            components,
            values: vec![0.0; count * components],
            has: vec![false; count],
            agrees: vec![true; count],
        };
        for (s, slot) in patches.slots.iter().enumerate() {
            let corners = slot.rim.iter();
            let values: Vec<Option<&[f64]>> = corners
                .map(|&(f, k)| source.at(mesh, f as usize, usize::from(k)))
                .collect();
            field.agrees[s] = values.windows(2).all(|pair| same_value(pair[0], pair[1]));
            let there: Vec<&[f64]> = values.iter().flatten().copied().collect();
            if there.is_empty() {
                continue;
            }
            field.has[s] = true;
            let out = &mut field.values[s * components..][..components];
            if field.agrees[s] || !source.blends() {
                out.copy_from_slice(there[0]);
                continue;
            }
            for value in &there {
                for (sum, v) in out.iter_mut().zip(*value) {
                    *sum += v / there.len() as f64;
                }
            }
        }
        field
    }

    /// Continues the values of the rim over the patches.
    ///
    /// NaN is no value to interpolate with: such slots keep it, and the patches are continued from the others. A patch without
    /// any other value gets NaN. At the slots of `instead` other values are continued than the rim keeps.
    pub(super) fn spread(
        &mut self,
        patches: &Patches,
        laplacian: &Laplacian,
        source: &FieldSource<'_>,
        normals: &[DVec3],
        instead: &[Instead],
    ) {
        let at_rim = self.has.clone();
        let rim_values = self.values.clone();
        self.replace(instead);
        let nearest = laplacian.nearest(&self.has);
        let is_number = |s: usize| {
            let at = s * self.components;
            let value = &self.values[at..at + self.components];
            self.has[s] && value.iter().all(|v| !v.is_nan())
        };
        let fixed: Vec<bool> = (0..self.has.len()).map(is_number).collect();
        // Patches with no numbers at their rim take what is there.
        self.copy_from(&nearest, &fixed);
        let near_number = laplacian.nearest(&fixed);
        match source.attribute().role {
            Role::Normal if self.components == 3 => self.spread_normals(laplacian, &fixed, normals),
            _ if source.blends() => laplacian.solve(&fixed, self.components, &mut self.values),
            _ => self.copy_from(&near_number, &fixed),
        }
        for (s, near) in nearest.iter().enumerate() {
            self.has[s] = *near != NONE;
        }
        if source.attribute().role == Role::Tangent && self.components >= 3 {
            self.unit_tangents(&fixed, &near_number);
        }
        // The rim keeps its values.
        let unknown = (0..at_rim.len()).filter(|&s| at_rim[s] && !fixed[s]);
        let unwanted = instead.iter().map(|(s, _)| *s);
        for s in unknown.chain(unwanted) {
            let place = s * self.components..(s + 1) * self.components;
            self.values[place.clone()].copy_from_slice(&rim_values[place]);
            self.has[s] = at_rim[s];
        }
        debug_assert_eq!(self.has.len(), patches.slots.len());
    }

    /// Replaces values at the rim.
    fn replace(&mut self, instead: &[Instead]) {
        for (s, value) in instead {
            self.has[*s] = value.is_some();
            if let Some(value) = value {
                let at = s * self.components;
                self.values[at..at + self.components].copy_from_slice(value);
            }
        }
    }

    fn copy_from(&mut self, nearest: &[u32], fixed: &[bool]) {
        for (s, near) in nearest.iter().enumerate() {
            if !fixed[s] && *near != NONE {
                let from = *near as usize * self.components;
                self.values
                    .copy_within(from..from + self.components, s * self.components);
            }
        }
    }

    /// Normals on the patches: the normals of the patch's shape, plus the difference from the given normals at the rim,
    /// which is interpolated harmonically.
    fn spread_normals(&mut self, laplacian: &Laplacian, fixed: &[bool], normals: &[DVec3]) {
        let at = |values: &[f64], s: usize| DVec3::from_slice(&values[3 * s..]);
        // If the normals of the file point inwards, the normals of the patches do too.
        let agreement: f64 = (0..fixed.len())
            .filter(|&s| fixed[s])
            .map(|s| at(&self.values, s).dot(normals[s]))
            .sum();
        let sign = if agreement < 0.0 { -1.0 } else { 1.0 };
        // The difference at the rim, interpolated over the patches.
        let mut difference = self.values.clone();
        for s in (0..fixed.len()).filter(|&s| fixed[s]) {
            let d = at(&self.values, s) - sign * normals[s];
            difference[3 * s..3 * s + 3].copy_from_slice(&d.to_array());
        }
        laplacian.solve(fixed, 3, &mut difference);
        // Shape normal plus difference, with unit length.
        for s in 0..fixed.len() {
            let bent = if fixed[s] {
                at(&self.values, s)
            } else {
                sign * normals[s] + at(&difference, s)
            };
            let unit = bent.normalize_or(sign * normals[s]);
            // A rim vertex whose corners agree keeps its normal, even if it is not exactly of unit length.
            if !fixed[s] || !self.agrees[s] {
                self.values[3 * s..3 * s + 3].copy_from_slice(&unit.to_array());
            }
        }
    }

    /// Gives new tangents unit length, and the handedness (fourth component) of the nearest rim slot.
    fn unit_tangents(&mut self, fixed: &[bool], nearest: &[u32]) {
        for s in (0..fixed.len()).filter(|&s| !fixed[s] || !self.agrees[s]) {
            let at = s * self.components;
            let unit = DVec3::from_slice(&self.values[at..]).normalize_or(DVec3::X);
            self.values[at..at + 3].copy_from_slice(&unit.to_array());
            if self.components == 4 && nearest[s] != NONE {
                let hand = self.values[nearest[s] as usize * 4 + 3];
                self.values[at + 3] = if hand < 0.0 { -1.0 } else { 1.0 };
            }
        }
    }
}
