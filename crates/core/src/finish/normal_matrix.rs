//! The normal matrix `Jᵀ W J` of Jacobians with one pattern.

use sprs::CsMat;

/// `Jᵀ W J` for sparse Jacobians `J` whose rows keep their columns, and diagonal weights `W`.
pub(super) struct NormalMatrix {
    /// The Jacobian's rows: where each starts, and the column of each entry.
    starts: Vec<usize>,
    columns: Vec<usize>,
    /// For each pair of entries of a row, row by row, the entry of the matrix that its product belongs to.
    places: Vec<u32>,
    matrix: CsMat<f64>,
}

impl NormalMatrix {
    /// The pattern for Jacobians whose rows have entries in these columns, each column at most once in a row.
    pub(super) fn new(rows: &[Vec<usize>], count: usize) -> Self {
        let mut starts = vec![0];
        let mut pairs = vec![0];
        for row in rows {
            starts.push(starts[starts.len() - 1] + row.len());
            pairs.push(pairs[pairs.len() - 1] + row.len().pow(2));
        }
        // Where each column occurs: the row, and the place in it.
        let mut uses: Vec<Vec<(usize, usize)>> = vec![Vec::new(); count];
        for (i, row) in rows.iter().enumerate() {
            (row.iter().enumerate()).for_each(|(k, &column)| uses[column].push((i, k)));
        }
        let mut places = vec![0u32; pairs[rows.len()]];
        let (mut outer, mut inner) = (vec![0], Vec::new());
        let mut at = vec![u32::MAX; count];
        for uses in &uses {
            let first = inner.len();
            for &column in uses.iter().flat_map(|&(i, _)| &rows[i]) {
                if at[column] == u32::MAX {
                    at[column] = 0;
                    inner.push(column);
                }
            }
            inner[first..].sort_unstable();
            for (place, &column) in (first as u32..).zip(&inner[first..]) {
                at[column] = place;
            }
            for &(i, k) in uses {
                let own = pairs[i] + k * rows[i].len();
                for (place, &column) in places[own..].iter_mut().zip(&rows[i]) {
                    *place = at[column];
                }
            }
            inner[first..].iter().for_each(|&j| at[j] = u32::MAX);
            outer.push(inner.len());
        }
        let zeros = vec![0.0; inner.len()];
        Self {
            columns: rows.concat(),
            matrix: CsMat::new((count, count), outer, inner, zeros),
            starts,
            places,
        }
    }

    /// The Jacobian's entries in a row, as places in its values, each with its column.
    pub(super) fn row(&self, i: usize) -> impl Iterator<Item = (usize, usize)> {
        let own = self.starts[i]..self.starts[i + 1];
        own.clone().zip(self.columns[own].iter().copied())
    }

    /// The matrix for the values of a Jacobian, row by row, and the weights of its rows.
    pub(super) fn set(&mut self, values: &[f64], weights: &[f64]) -> &CsMat<f64> {
        let data = self.matrix.data_mut();
        data.fill(0.0);
        let mut places = self.places.iter();
        for (ends, weight) in self.starts.windows(2).zip(weights) {
            let row = &values[ends[0]..ends[1]];
            for left in row {
                for (right, &place) in row.iter().zip(&mut places) {
                    data[place as usize] += left * (right * weight);
                }
            }
        }
        &self.matrix
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrix_is_the_product_of_its_factors() {
        let rows: [Vec<usize>; 4] = [vec![0, 2], vec![1], vec![0, 1, 3], vec![]];
        let mut normal = NormalMatrix::new(&rows, 5);
        for turn in 1..4 {
            let values: Vec<f64> = (0..6).map(|k| f64::from(k * turn) - 2.5).collect();
            let weights = [0.5, 2.0, 3.0, 7.0];
            let matrix = normal.set(&values, &weights).clone();
            let mut dense = [[0.0; 5]; 5];
            let mut first = 0;
            for (row, weight) in rows.iter().zip(weights) {
                for (a, i) in row.iter().enumerate() {
                    for (b, j) in row.iter().enumerate() {
                        dense[*i][*j] += weight * values[first + a] * values[first + b];
                    }
                }
                first += row.len();
            }
            for (i, row) in dense.iter().enumerate() {
                for (j, expected) in row.iter().enumerate() {
                    let found = matrix.get(i, j).copied().unwrap_or(0.0);
                    assert!((found - expected).abs() < 1e-12, "{i} {j}");
                }
            }
        }
    }
}
