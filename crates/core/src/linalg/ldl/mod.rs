//! Sparse symmetric systems by `L D Lᵀ` factorisation, multifrontal, ordered by nested dissection.
//!
//! Columns that share their rows are eliminated together in a dense matrix of these rows (a front); the update matrix that
//! remains is added to the front of their parent in the elimination tree (I. S. Duff, J. K. Reid, "The multifrontal solution of
//! indefinite sparse symmetric linear equations", ACM Trans. Math. Software 9, 1983). The analysis is done once for a pattern and
//! reused for all matrices with that pattern. The order of all sums is fixed by the pattern, so the result has the same bits on
//! any number of threads.

mod front;
mod supernodes;
#[cfg(test)]
mod tests;

use sprs::CsMat;

use super::dissection::dissect;
use crate::cancel::Cancel;
use front::Front;
use supernodes::{Supernode, elimination_tree, postorder, supernodes};

/// Symbolic analysis of a symmetric matrix: an elimination order and the structure of the factor.
#[derive(Clone, Debug)]
pub struct LdlPattern {
    /// The unknown eliminated at each position.
    order: Vec<u32>,
    /// The position of each unknown.
    place: Vec<u32>,
    /// The supernodes, in the order of their columns.
    supernodes: Vec<Supernode>,
    cancel: Cancel,
}

/// A factorised symmetric matrix.
#[derive(Clone, Debug)]
pub struct Ldl<'a> {
    pattern: &'a LdlPattern,
    /// The columns of the supernodes, each from its diagonal on; `D` is in place of the unit diagonal of `L`.
    values: Vec<f64>,
}

impl LdlPattern {
    /// Analyses a symmetric matrix with both triangles stored. Once the token is set, the analysis ends early and every
    /// factorisation with it returns `None`.
    pub fn new(matrix: &CsMat<f64>, cancel: &Cancel) -> Self {
        let order = dissect(matrix, cancel);
        if cancel.is_cancelled() {
            // The order of a cancelled dissection has much fill; the factor might not fit into memory.
            return Self {
                place: inverse(&order),
                order,
                supernodes: Vec::new(),
                cancel: cancel.clone(),
            };
        }
        let (parent, lengths) = elimination_tree(matrix, &order, &inverse(&order));
        let rank = postorder(&parent, &lengths);
        let moved = inverse(&rank);
        let order: Vec<u32> = rank.iter().map(|&k| order[k as usize]).collect();
        let parent = |k: &u32| moved.get(parent[*k as usize] as usize).copied();
        let parents: Vec<u32> = rank
            .iter()
            .map(|k| parent(k).unwrap_or(supernodes::NONE))
            .collect();
        let lengths: Vec<u32> = rank.iter().map(|&k| lengths[k as usize]).collect();
        let place = inverse(&order);
        Self {
            supernodes: supernodes(matrix, &order, &place, (&parents, &lengths)),
            order,
            place,
            cancel: cancel.clone(),
        }
    }

    /// Number of stored entries of the factor, including its diagonal.
    pub fn entries(&self) -> usize {
        let stored = |s: &Supernode| (0..s.columns).map(|j| s.rows.len() - j).sum::<usize>();
        self.supernodes.iter().map(stored).sum()
    }

    /// Factorises a matrix with this pattern after multiplying its diagonal by `1 + shift`. `None` if a pivot is zero or not
    /// finite, or the token is set.
    pub fn factorise(&self, matrix: &CsMat<f64>, shift: f64) -> Option<Ldl<'_>> {
        let mut values = Vec::with_capacity(self.entries());
        let mut front = Front::default();
        // The row in the current front of each position.
        let mut local = vec![0u32; self.order.len()];
        // Update matrices waiting for their parent front, on a stack, and the supernodes that they come from.
        let (mut left, mut waiting) = (Vec::new(), Vec::new());
        for (s, node) in self.supernodes.iter().enumerate() {
            for (i, &row) in (0u32..).zip(&node.rows) {
                local[row as usize] = i;
            }
            if self.cancel.is_cancelled() {
                return None;
            }
            front.reset(node.rows.len());
            self.add_matrix(&mut front, node, &local, matrix, shift);
            for _ in 0..node.children {
                let child: &Supernode = &self.supernodes[waiting.pop()?];
                let rows = child.below();
                let start = left.len() - rows.len() * (rows.len() + 1) / 2;
                add_left(&mut front, rows, &local, &left[start..]);
                left.truncate(start);
            }
            if !front.eliminate(node.columns, &self.cancel) {
                return None;
            }
            (0..node.columns).for_each(|j| values.extend_from_slice(front.column(j)));
            if !node.below().is_empty() {
                let rest = node.columns..node.rows.len();
                rest.for_each(|j| left.extend_from_slice(front.column(j)));
                waiting.push(s);
            }
        }
        (!self.cancel.is_cancelled()).then_some(Ldl {
            pattern: self,
            values,
        })
    }

    /// Adds the entries of the matrix in the columns of a supernode.
    fn add_matrix(
        &self,
        front: &mut Front,
        node: &Supernode,
        local: &[u32],
        matrix: &CsMat<f64>,
        shift: f64,
    ) {
        for j in 0..node.columns {
            let place = node.first + j;
            let column = front.column_mut(j);
            let row = matrix.outer_view(self.order[place] as usize);
            for (i, &v) in row.iter().flat_map(|row| row.iter()) {
                let at = self.place[i] as usize;
                if at > place {
                    column[local[at] as usize] += v;
                } else if at == place {
                    column[j] += (1.0 + shift) * v;
                }
            }
        }
    }
}

/// Adds a child's update matrix: the columns of a lower triangle one after another (extend-add).
fn add_left(front: &mut Front, rows: &[u32], local: &[u32], left: &[f64]) {
    let mut rest = left;
    for (j, &at) in rows.iter().enumerate() {
        let (own, others) = rest.split_at(rows.len() - j);
        rest = others;
        let column = front.column_mut(local[at as usize] as usize);
        for (&i, v) in rows[j..].iter().zip(own) {
            column[local[i as usize] as usize] += v;
        }
    }
}

/// The inverse permutation.
fn inverse(order: &[u32]) -> Vec<u32> {
    let mut place = vec![0; order.len()];
    for (k, &i) in (0u32..).zip(order) {
        place[i as usize] = k;
    }
    place
}

impl Ldl<'_> {
    /// Solves in place.
    pub fn solve(&self, b: &mut [f64]) {
        let order = &self.pattern.order;
        let mut x: Vec<f64> = order.iter().map(|&i| b[i as usize]).collect();
        let mut rest = self.values.as_slice();
        for node in &self.pattern.supernodes {
            for j in 0..node.columns {
                let (column, others) = rest.split_at(node.rows.len() - j);
                rest = others;
                let value = x[node.first + j];
                for (&i, v) in node.rows[j + 1..].iter().zip(&column[1..]) {
                    x[i as usize] -= v * value;
                }
            }
        }
        let mut rest = self.values.as_slice();
        for node in self.pattern.supernodes.iter().rev() {
            for j in (0..node.columns).rev() {
                let (others, column) = rest.split_at(rest.len() + j - node.rows.len());
                rest = others;
                let below = node.rows[j + 1..].iter().zip(&column[1..]);
                let sum: f64 = below.map(|(&i, v)| v * x[i as usize]).sum();
                let own = &mut x[node.first + j];
                *own = *own / column[0] - sum;
            }
        }
        for (value, &i) in x.iter().zip(order) {
            b[i as usize] = *value;
        }
    }
}
