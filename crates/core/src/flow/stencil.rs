//! A 27-point stencil: one row of a matrix on the lattice.

use crate::linalg::Real;

/// The 27 entries in nine groups of three, followed by minus their sum.
///
/// Groups are applied four entries wide; the fourth sum belongs to the next group's first entry and is dropped.
#[derive(Clone)]
pub struct Stencil([f32; 28]);

impl Stencil {
    /// The stencil of a row of 27 entries; their sum, which is zero but for rounding, is subtracted at the centre.
    pub fn new(row: &[f64; 27]) -> Self {
        let mut entries = [0.0; 28];
        let mut sum = 0.0;
        for (entry, &v) in entries.iter_mut().zip(row) {
            *entry = v as f32;
            sum += f64::from(*entry);
        }
        entries[27] = -sum as f32;
        Self(entries)
    }

    pub(super) fn entry(&self, k: usize) -> f64 {
        let value = f64::from(self.0[k]);
        if k == 13 {
            value + f64::from(self.0[27])
        } else {
            value
        }
    }

    #[inline]
    pub(super) fn apply<T: Real>(&self, starts: &[u32; 9], own: usize, x: &[T]) -> T {
        let mut sums = [T::ZERO; 4];
        for (c, &start) in starts.iter().enumerate() {
            let near = &x[start as usize..start as usize + 4];
            let group = &self.0[3 * c..3 * c + 4];
            for d in 0..4 {
                sums[d] += T::of(group[d]) * near[d];
            }
        }
        (sums[0] + sums[1]) + (sums[2] + T::of(self.0[27]) * x[own])
    }
}
