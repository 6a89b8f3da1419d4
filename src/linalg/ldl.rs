//! Sparse symmetric systems by `L D Lᵀ`, with an ordering by nested dissection.
//!
//! The factor is found row by row along the elimination tree (T. A. Davis, "Algorithm 849: a concise sparse Cholesky
//! factorization package", 2005). The analysis is done once for a pattern and serves all matrices that have it. The order of
//! all sums is fixed by the pattern, so that the result has the same bits on any number of threads.

use sprs::CsMat;

use super::dissection::dissect;

/// No row yet.
const NONE: u32 = u32::MAX;

/// What the pattern of a symmetric matrix tells: an order of elimination and the shape of the factor.
#[derive(Clone, Debug)]
pub struct LdlPattern {
    /// The unknown that is eliminated at each place.
    order: Vec<u32>,
    /// The place of each unknown.
    place: Vec<u32>,
    /// Parent of each place in the elimination tree.
    parent: Vec<u32>,
    /// Start of each column of the factor, and their end.
    starts: Vec<usize>,
}

/// A factorised symmetric matrix.
#[derive(Clone, Debug)]
pub struct Ldl<'a> {
    pattern: &'a LdlPattern,
    rows: Vec<u32>,
    values: Vec<f64>,
    diagonal: Vec<f64>,
}

impl LdlPattern {
    /// The analysis of a symmetric matrix of which both triangles are stored.
    pub fn new(matrix: &CsMat<f64>) -> Self {
        let n = matrix.rows();
        let order = dissect(matrix);
        let mut place = vec![0; n];
        for (k, &i) in order.iter().enumerate() {
            place[i as usize] = k as u32;
        }
        let (mut parent, mut mark) = (vec![NONE; n], vec![NONE; n]);
        let mut lengths = vec![0usize; n];
        for k in 0..n {
            mark[k] = k as u32;
            for mut j in before(matrix, &order, &place, k).map(|e| e.0) {
                while mark[j] != k as u32 {
                    if parent[j] == NONE {
                        parent[j] = k as u32;
                    }
                    lengths[j] += 1;
                    mark[j] = k as u32;
                    j = parent[j] as usize;
                }
            }
        }
        let mut starts = vec![0; n + 1];
        for k in 0..n {
            starts[k + 1] = starts[k] + lengths[k];
        }
        Self {
            order,
            place,
            parent,
            starts,
        }
    }

    /// Number of entries of the factor below its diagonal.
    pub fn entries(&self) -> usize {
        self.starts[self.order.len()]
    }

    /// Factorises a matrix with this pattern, to whose diagonal `shift` times itself is added; none where a pivot is zero or
    /// not a number.
    pub fn factorise(&self, matrix: &CsMat<f64>, shift: f64) -> Option<Ldl<'_>> {
        let n = self.order.len();
        let mut rows = vec![0u32; self.entries()];
        let mut values = vec![0.0; self.entries()];
        let mut diagonal = vec![0.0; n];
        let mut filled = self.starts[..n].to_vec();
        let mut row = vec![0.0; n];
        let (mut mark, mut path, mut reach) = (vec![NONE; n], Vec::new(), Vec::new());
        for k in 0..n {
            mark[k] = k as u32;
            reach.clear();
            let own = self.order[k] as usize;
            let mut pivot = (1.0 + shift) * matrix.get(own, own).copied().unwrap_or(0.0);
            for (j, value) in before(matrix, &self.order, &self.place, k) {
                row[j] += value;
                let mut at = j;
                while mark[at] != k as u32 {
                    path.push(at as u32);
                    mark[at] = k as u32;
                    at = self.parent[at] as usize;
                }
                // Columns come after those that they depend on: paths are put in front of each other.
                while let Some(at) = path.pop() {
                    reach.push(at);
                }
            }
            for &j in reach.iter().rev() {
                let j = j as usize;
                let value = std::mem::take(&mut row[j]);
                let column = self.starts[j]..filled[j];
                for (i, v) in rows[column.clone()].iter().zip(&values[column]) {
                    row[*i as usize] -= v * value;
                }
                let scaled = value / diagonal[j];
                pivot -= scaled * value;
                rows[filled[j]] = k as u32;
                values[filled[j]] = scaled;
                filled[j] += 1;
            }
            if pivot == 0.0 || !pivot.is_finite() {
                return None;
            }
            diagonal[k] = pivot;
        }
        Some(Ldl {
            pattern: self,
            rows,
            values,
            diagonal,
        })
    }
}

impl Ldl<'_> {
    /// Solves in place.
    pub fn solve(&self, b: &mut [f64]) {
        let (order, starts) = (&self.pattern.order, &self.pattern.starts);
        let mut x: Vec<f64> = order.iter().map(|&i| b[i as usize]).collect();
        for k in 0..x.len() {
            let (column, value) = (starts[k]..starts[k + 1], x[k]);
            for (i, v) in self.rows[column.clone()].iter().zip(&self.values[column]) {
                x[*i as usize] -= v * value;
            }
        }
        for k in (0..x.len()).rev() {
            let column = starts[k]..starts[k + 1];
            let below = self.rows[column.clone()].iter().zip(&self.values[column]);
            let sum: f64 = below.map(|(i, v)| v * x[*i as usize]).sum();
            x[k] = x[k] / self.diagonal[k] - sum;
        }
        for (value, &i) in x.iter().zip(order) {
            b[i as usize] = *value;
        }
    }
}

/// The places before `k` in whose columns row `k` of the reordered matrix has entries, with these.
fn before<'a>(
    matrix: &'a CsMat<f64>,
    order: &'a [u32],
    place: &'a [u32],
    k: usize,
) -> impl Iterator<Item = (usize, f64)> + 'a {
    let range = matrix.indptr().outer_inds_sz(order[k] as usize);
    let (indices, values) = (matrix.indices(), matrix.data());
    let entries = range.map(move |e| (place[indices[e]] as usize, values[e]));
    entries.filter(move |&(j, _)| j < k)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sprs::TriMat;

    /// The square of a grid's Laplacian plus a little, as in the fairing of a patch.
    fn grid(n: usize) -> CsMat<f64> {
        let mut entries = TriMat::new((n * n, n * n));
        for i in 0..n * n {
            let (x, y) = (i % n, i / n);
            entries.add_triplet(i, i, 4.1 + 0.01 * (i as f64).sin());
            let mut join = |j: usize| {
                entries.add_triplet(i, j, -1.0);
                entries.add_triplet(j, i, -1.0);
            };
            if x + 1 < n {
                join(i + 1);
            }
            if y + 1 < n {
                join(i + n);
            }
        }
        let laplacian: CsMat<f64> = entries.to_csr();
        &laplacian * &laplacian
    }

    #[test]
    fn systems_are_solved_to_rounding_and_the_analysis_serves_again() {
        for n in [1, 2, 7, 40] {
            let matrix = grid(n);
            let pattern = LdlPattern::new(&matrix);
            for shift in [0.0, 0.5] {
                let factor = pattern.factorise(&matrix, shift).unwrap();
                let wanted: Vec<f64> = (0..n * n).map(|i| (i as f64 * 0.7).cos()).collect();
                let mut b = vec![0.0; n * n];
                for (i, row) in matrix.outer_iterator().enumerate() {
                    b[i] = row.iter().map(|(j, v)| v * wanted[j]).sum();
                    b[i] += shift * matrix.get(i, i).unwrap() * wanted[i];
                }
                factor.solve(&mut b);
                for (x, w) in b.iter().zip(wanted) {
                    assert!((x - w).abs() < 1e-11, "{n} {x} {w}");
                }
            }
        }
    }

    #[test]
    fn the_order_keeps_the_factor_sparse() {
        let matrix = grid(60);
        let entries = LdlPattern::new(&matrix).entries();
        // In the order of rows the band alone has 3600 · 122 = 439,000 entries; 171,000 were measured.
        assert!(entries < 200_000, "{entries}");
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        let mut entries = TriMat::new((2, 2));
        entries.add_triplet(0, 0, 1.0);
        entries.add_triplet(0, 1, 1.0);
        entries.add_triplet(1, 0, 1.0);
        entries.add_triplet(1, 1, 1.0);
        let matrix: CsMat<f64> = entries.to_csr();
        let pattern = LdlPattern::new(&matrix);
        assert!(pattern.factorise(&matrix, 0.0).is_none());
    }
}
