//! Partial factorisation of a dense symmetric matrix (frontal matrix).

use crate::cancel::Cancel;

/// Eliminated columns that are subtracted from later columns in one pass, so that each later column is read and written once for
/// all of them.
const PANEL: usize = 4;

/// The lower triangle of a dense symmetric matrix, by columns.
#[derive(Default)]
pub(super) struct Front {
    entries: Vec<f64>,
    size: usize,
}

impl Front {
    /// Resets it to a zero matrix of a size.
    pub(super) fn reset(&mut self, size: usize) {
        self.size = size;
        self.entries.clear();
        self.entries.resize(size * size, 0.0);
    }

    /// A column from its diagonal on.
    pub(super) fn column(&self, j: usize) -> &[f64] {
        &self.entries[j * self.size + j..(j + 1) * self.size]
    }

    /// A whole column; entry `j` is its diagonal.
    pub(super) fn column_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.entries[j * self.size..(j + 1) * self.size]
    }

    /// Eliminates the first `columns` columns. They become columns of `L`, with `D` in place of its unit diagonal; the others
    /// become the update matrix. Returns false if a pivot is zero or not finite, or the token is set.
    pub(super) fn eliminate(&mut self, columns: usize, cancel: &Cancel) -> bool {
        let mut done = 0;
        while done < columns {
            if cancel.is_cancelled() {
                return false;
            }
            let end = (done + PANEL).min(columns);
            for j in done..end {
                self.subtract(done..j, j);
                let column = &mut self.entries[j * self.size + j..(j + 1) * self.size];
                let Some((pivot, below)) = column.split_first_mut() else {
                    return false;
                };
                if *pivot == 0.0 || !pivot.is_finite() {
                    return false;
                }
                below.iter_mut().for_each(|v| *v /= *pivot);
            }
            for j in end..self.size {
                self.subtract(done..end, j);
            }
            done = end;
        }
        true
    }

    /// Subtracts the contributions of eliminated columns from column `j`.
    fn subtract(&mut self, panel: std::ops::Range<usize>, j: usize) {
        let size = self.size;
        let (before, rest) = self.entries.split_at_mut(j * size);
        let target = &mut rest[j..size];
        let source = |p: usize| {
            let column = &before[p * size..(p + 1) * size];
            (&column[j..], column[j] * column[p])
        };
        if panel.len() == PANEL {
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| source(panel.start + i));
            let sources = a.0.iter().zip(b.0).zip(c.0.iter().zip(d.0));
            for (t, ((x, y), (z, w))) in target.iter_mut().zip(sources) {
                *t -= (x * a.1 + y * b.1) + (z * c.1 + w * d.1);
            }
            return;
        }
        for p in panel {
            let (column, weight) = source(p);
            for (t, x) in target.iter_mut().zip(column) {
                *t -= x * weight;
            }
        }
    }
}
