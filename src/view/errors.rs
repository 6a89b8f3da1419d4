//! The expected errors of a mesh's vertices, kept beside the mesh: not every format of the files between two steps holds them.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::delta::Numbers;
use crate::io::Loaded;
use crate::job::Mended;
use crate::mesh::attributes::SIGMA_NAME;

/// The expected errors of the vertices of a mesh: 0 where nothing was made anew, not a number where nothing is known. Empty where
/// nothing is known of any.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors(pub Vec<f32>);

impl Errors {
    /// Those that the file holds.
    pub fn read(loaded: &Loaded) -> Self {
        let attributes = &loaded.attributes.vertex;
        let Some(own) = attributes.iter().find(|a| a.name == SIGMA_NAME) else {
            return Self::default();
        };
        let error = |v: usize| match own.get(v).map(|x| x[0]) {
            // The file says -1 where nothing is known.
            Some(x) if x >= 0.0 => x as f32,
            _ => f32::NAN,
        };
        Self((0..loaded.mesh.positions.len()).map(error).collect())
    }

    /// Those of a mesh that a step made of another one, as it was read again.
    pub fn next(&self, step: &Mended, old: &Loaded, new: &Loaded) -> Self {
        let read = Self::read(new);
        if !read.0.is_empty() {
            return read;
        }
        let positions = &new.mesh.positions;
        let mut errors = vec![0.0; positions.len()];
        if !self.0.is_empty() {
            let numbers = Numbers::by_position(&old.mesh, &new.mesh).vertices;
            for (error, number) in self.0.iter().zip(numbers) {
                if let Some(slot) = number.and_then(|v| errors.get_mut(v as usize)) {
                    *slot = *error;
                }
            }
        }
        let first = step.kept_size()[0].min(step.positions().len());
        let (kept, made) = step.positions().split_at(first);
        let told = step
            .expected_error()
            .iter()
            .map(|s| s.map_or(f32::NAN, |s| s as f32));
        let told = told.chain(std::iter::repeat(f32::NAN));
        // By their places, since not every format keeps the order; as they are rounded by those that have 32-bit floats. Vertices
        // that are neither kept nor made are copies of others, at seams of the texture.
        let place = |p: &DVec3| p.as_vec3().to_array().map(f32::to_bits);
        let kept: HashSet<_> = kept.iter().map(place).collect();
        let made: HashMap<_, f32> = made.iter().map(place).zip(told).collect();
        for (slot, p) in errors.iter_mut().zip(positions) {
            let place = place(p);
            if let Some(error) = made.get(&place).filter(|_| !kept.contains(&place)) {
                *slot = *error;
            }
        }
        Self(errors)
    }

    /// Whether the error of any vertex is known.
    pub fn is_known(&self) -> bool {
        self.0.iter().any(|error| *error > 0.0)
    }

    /// The largest of all but the highest few percent.
    pub fn high(&self, outliers: f64) -> f32 {
        let known = self.0.iter().copied().filter(|error| *error > 0.0);
        let mut known: Vec<f32> = known.collect();
        known.sort_unstable_by(f32::total_cmp);
        let at = (known.len() as f64 * (1.0 - outliers)) as usize;
        known.get(at).or(known.last()).copied().unwrap_or(0.0)
    }
}
