//! The expected errors of a mesh's vertices, kept beside the mesh, since not every format of intermediate files can store them.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::delta::KeptNumbers;
use isomend_core::mesh::attributes::EXPECTED_ERROR_NAME;
use isomend_files::io::Loaded;
use isomend_files::job::Mended;

/// The expected errors of the vertices of a mesh, in its units: 0 for original vertices, NaN where unknown. Empty if all are unknown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors(pub Vec<f32>);

impl Errors {
    /// The expected errors stored in a file; empty if it has none.
    pub fn read(loaded: &Loaded) -> Self {
        let attributes = &loaded.attributes.vertex;
        let Some(own) = attributes.iter().find(|a| a.name == EXPECTED_ERROR_NAME) else {
            return Self::default();
        };
        let error = |v: usize| match own.get(v).map(|x| x[0]) {
            // Files store -1 for unknown.
            Some(x) if x >= 0.0 => x as f32,
            _ => f32::NAN,
        };
        Self((0..loaded.mesh.positions.len()).map(error).collect())
    }

    /// The expected errors after a step: `old` is the mesh before it, `new` its result as read back from the intermediate file.
    pub fn next(&self, step: &Mended, old: &Loaded, new: &Loaded) -> Self {
        let read = Self::read(new);
        if !read.0.is_empty() {
            return read;
        }
        // Kept vertices keep their errors.
        let positions = &new.mesh.positions;
        let mut errors = vec![0.0; positions.len()];
        if !self.0.is_empty() {
            let numbers = KeptNumbers::by_position(&old.mesh, &new.mesh).vertices;
            for (error, number) in self.0.iter().zip(numbers) {
                if let Some(slot) = number.and_then(|v| errors.get_mut(v as usize)) {
                    *slot = *error;
                }
            }
        }
        let first = step.kept_size()[0].min(step.positions().len());
        let (kept, made) = step.positions().split_at(first);
        let estimated = step
            .expected_error()
            .iter()
            .map(|s| s.map_or(f32::NAN, |s| s as f32));
        let estimated = estimated.chain(std::iter::repeat(f32::NAN));
        // New vertices take the step's estimates. They are matched by position, since not every format keeps the order, and in single
        // precision, since some formats store 32-bit floats. Vertices that are neither kept nor new are copies at texture seams.
        let key = |p: &DVec3| p.as_vec3().to_array().map(f32::to_bits);
        let kept: HashSet<_> = kept.iter().map(key).collect();
        let made: HashMap<_, f32> = made.iter().map(key).zip(estimated).collect();
        for (slot, p) in errors.iter_mut().zip(positions) {
            let key = key(p);
            if let Some(error) = made.get(&key).filter(|_| !kept.contains(&key)) {
                *slot = *error;
            }
        }
        Self(errors)
    }

    /// Whether the error of any vertex is known.
    pub fn is_known(&self) -> bool {
        self.0.iter().any(|error| *error > 0.0)
    }

    /// The largest positive error after leaving out the fraction `outliers` of the highest ones.
    pub fn high(&self, outliers: f64) -> f32 {
        let known = self.0.iter().copied().filter(|error| *error > 0.0);
        let mut known: Vec<f32> = known.collect();
        known.sort_unstable_by(f32::total_cmp);
        let at = (known.len() as f64 * (1.0 - outliers)) as usize;
        known.get(at).or(known.last()).copied().unwrap_or(0.0)
    }
}
