//! Tests: sparse products against dense ones, and the solvers on Laplacians.

use super::{
    Csr, Jacobi, LinearOperator, Multigrid, MultigridCycle, Preconditioner, SparseMatrix,
    conjugate_gradient,
};

type Dense = Vec<Vec<f64>>;

/// A fixed pseudo-random sequence in [-1, 1).
fn noise(n: usize) -> Vec<f64> {
    let mut state = 1u64;
    (0..n)
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        })
        .collect()
}

/// A matrix with about a fifth of the entries nonzero; each entry is added in two parts.
fn sparse(rows: usize, columns: usize) -> Csr {
    let values = noise(rows * columns);
    Csr::from_rows(rows, columns, |i, sink| {
        for j in (0..columns).rev() {
            let v = values[i * columns + j];
            if v > 0.6 {
                sink.add(j as u32, v);
                sink.add(j as u32, 0.5);
            }
        }
    })
}

fn dense(m: &Csr) -> Dense {
    let mut out = vec![vec![0.0; m.columns]; m.rows()];
    for (i, row) in out.iter_mut().enumerate() {
        for (j, v) in m.row(i) {
            row[j as usize] = v;
        }
    }
    out
}

fn product(a: &Dense, b: &Dense) -> Dense {
    let entry = |row: &[f64], j: usize| row.iter().zip(b).map(|(x, r)| x * r[j]).sum();
    a.iter()
        .map(|row| (0..b[0].len()).map(|j| entry(row, j)).collect())
        .collect()
}

fn assert_close(a: &Dense, b: &Dense) {
    assert_eq!((a.len(), a[0].len()), (b.len(), b[0].len()));
    for (x, y) in a.iter().flatten().zip(b.iter().flatten()) {
        assert!((x - y).abs() < 1e-12, "{x} {y}");
    }
}

#[test]
fn sparse_products_are_those_of_dense_matrices() {
    let (a, b) = (sparse(150, 90), sparse(90, 70));
    for i in 0..a.rows() {
        assert!(a.row(i).is_sorted_by(|x, y| x.0 < y.0));
    }
    assert_close(&dense(&a.times(&b)), &product(&dense(&a), &dense(&b)));
    let (general, other) = [&a, &b].map(|m| SparseMatrix::from(m.clone())).into();
    let own = a.times(&b);
    let theirs = Csr::from(&general * &other);
    assert_eq!((own.offsets, own.indices), (theirs.offsets, theirs.indices));
    assert_eq!(own.values, theirs.values, "both add in the same order");
    let x = noise(90);
    let mut y = vec![0.0; 150];
    a.apply(&x, &mut y);
    let column: Dense = x.iter().map(|&v| vec![v]).collect();
    assert_close(&vec![y], &vec![product(&dense(&a), &column).concat()]);
}

#[test]
fn a_transpose_swaps_rows_and_columns() {
    let a = sparse(150, 90);
    let t = a.transposed();
    let (d, wanted) = (dense(&t), dense(&a));
    for (j, row) in d.iter().enumerate() {
        for (i, v) in row.iter().enumerate() {
            assert_eq!(*v, wanted[i][j]);
        }
    }
    assert_eq!(dense(&t.transposed()), wanted);
    let turned = SparseMatrix::from(a.clone()).transpose_into();
    assert_eq!(dense(&Csr::from(turned)), dense(&t));
    let diagonal: Vec<f64> = (0..150)
        .map(|i| wanted[i].get(i).copied().unwrap_or(0.0))
        .collect();
    assert_eq!(a.diagonal(), diagonal);
}

struct Operator {
    matrix: Csr,
    inverse_diagonal: Vec<f64>,
}

impl Operator {
    fn new(matrix: Csr) -> Self {
        let inverse_diagonal = matrix.diagonal().iter().map(|d| 1.0 / d).collect();
        Self {
            matrix,
            inverse_diagonal,
        }
    }

    /// Iterations until the residual is 1e-10 of the right-hand side; also checks the solution.
    fn iterations(&self, preconditioner: &dyn Preconditioner) -> usize {
        let n = self.matrix.rows();
        let (b, mut x, mut ax) = (noise(n), vec![0.0; n], vec![0.0; n]);
        let outcome = conjugate_gradient(self, preconditioner, &b, &mut x, 1e-10, n);
        self.matrix.apply(&x, &mut ax);
        let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
        let rest = norm(&mut ax.iter().zip(&b).map(|(y, b)| y - b));
        assert!(rest < 2e-10 * norm(&mut b.iter().copied()));
        outcome.iterations
    }
}

impl LinearOperator for Operator {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.matrix.apply(x, y);
    }

    fn jacobi(&self) -> &[f64] {
        &self.inverse_diagonal
    }
}

/// The five-point Laplacian on `n × n` inner nodes with zero boundary values, scaled by `scale(i)` from both sides.
fn laplacian(n: usize, scale: impl Fn(usize) -> f64 + Sync) -> Csr {
    Csr::from_rows(n * n, n * n, |i, sink| {
        let (x, y) = (i / n, i % n);
        let mut send = |j: usize, v: f64| sink.add(j as u32, v * scale(i) * scale(j));
        send(i, 4.0);
        for (inside, j) in [
            (x > 0, i.wrapping_sub(n)),
            (x + 1 < n, i + n),
            (y > 0, i.wrapping_sub(1)),
            (y + 1 < n, i + 1),
        ] {
            if inside {
                send(j, -1.0);
            }
        }
    })
}

/// Bilinear prolongation from `n × n` to `(2 n + 1) × (2 n + 1)` inner nodes.
fn bilinear(n: usize) -> Csr {
    let fine = 2 * n + 1;
    // Fine node 2 i + 1 is coarse node i; fine node 2 i is between coarse nodes i - 1 and i.
    let parents = move |f: usize| {
        let (c, odd) = (f / 2, f % 2 == 1);
        let both = [(c, if odd { 1.0 } else { 0.5 }), (c.wrapping_sub(1), 0.5)];
        both.into_iter()
            .take(if odd { 1 } else { 2 })
            .filter(move |p| p.0 < n)
    };
    Csr::from_rows(fine * fine, n * n, |i, sink| {
        for (a, u) in parents(i / fine) {
            for (b, v) in parents(i % fine) {
                sink.add((a * n + b) as u32, u * v);
            }
        }
    })
}

#[test]
fn scaling_by_the_diagonal_undoes_a_bad_scaling() {
    let even = Operator::new(laplacian(20, |_| 1.0));
    let uneven = Operator::new(laplacian(20, |i| 10f64.powi(i as i32 % 5)));
    let plain = even.iterations(&Jacobi(even.jacobi()));
    let scaled = uneven.iterations(&Jacobi(uneven.jacobi()));
    assert!(plain < 80, "{plain}");
    assert!(scaled < plain + 40, "{scaled} {plain}");
}

#[test]
fn multigrid_needs_few_iterations_at_any_size() {
    for n in [31, 63, 127] {
        let operator = Operator::new(laplacian(n, |_| 1.0));
        let mut sizes = vec![n / 2];
        while sizes[sizes.len() - 1] > 3 {
            sizes.push(sizes[sizes.len() - 1] / 2);
        }
        let mut prolongations: Vec<Csr> = sizes.into_iter().map(bilinear).collect();
        let finest = prolongations.remove(0);
        let first = finest.transposed().times(&operator.matrix.times(&finest));
        let coarse = Multigrid::new(&operator, finest, first, prolongations)
            .expect("a positive definite matrix");
        let cycle = MultigridCycle::new(&operator, &coarse);
        let iterations = operator.iterations(&cycle);
        assert!(iterations <= 14, "{n}: {iterations}");
    }
}
