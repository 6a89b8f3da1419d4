//! A Galerkin multigrid cycle as a preconditioner.
//!
//! The caller brings the prolongations; coarse matrices are Galerkin products, smoothers are Chebyshev polynomials in
//! D⁻¹A, the coarsest system is solved by a Cholesky factorisation.

use super::cg::{LinearOperator, Preconditioner};
use super::csr::Csr;
use super::dense::Cholesky;

/// Power iterations for the largest eigenvalue of D⁻¹A, and the factor for what they miss.
const POWER_ITERATIONS: usize = 15;
const SAFETY: f64 = 1.08;
/// Degrees of the smoothers, and λ over the smallest eigenvalue they damp.
const FINE_DEGREE: usize = 2;
const FINE_RATIO: f64 = 6.0;
const COARSE_DEGREE: usize = 4;
const COARSE_RATIO: f64 = 8.0;
/// Coarse matrices are lifted by this part of their largest diagonal entry.
const SHIFT: f64 = 1e-10;
/// Systems up to this size are factorised.
const DIRECT: usize = 400;

struct Coarse {
    matrix: Csr,
    inverse_diagonal: Vec<f64>,
    smoother: Chebyshev,
    /// To the next coarser level, and back.
    transfer: Option<(Csr, Csr)>,
}

/// The coarse levels of a hierarchy, to be used with the fine operator they were made for or one close to it.
pub struct Multigrid {
    restriction: Csr,
    prolongation: Csr,
    smoother: Chebyshev,
    levels: Vec<Coarse>,
    direct: Cholesky,
    /// 1: V-cycle, 2: W-cycle.
    gamma: usize,
}

impl Multigrid {
    /// From the fine operator, the prolongation to the finest level, the Galerkin matrix of the first coarse level, and the prolongations
    /// between the coarse levels, finest first. None where the coarsest matrix is not positive definite.
    pub fn new(
        operator: &impl LinearOperator,
        prolongation: Csr,
        first: Csr,
        coarser: Vec<Csr>,
        gamma: usize,
    ) -> Option<Self> {
        let apply = |x: &[f64], y: &mut [f64]| operator.apply(x, y);
        let smoother = Chebyshev::new(FINE_DEGREE, FINE_RATIO, &apply, operator.jacobi());
        let restriction = prolongation.transposed();
        let mut levels = Vec::new();
        let mut matrix = shifted(first);
        for p in coarser {
            if matrix.rows() <= DIRECT {
                break;
            }
            let r = p.transposed();
            let next = r.times(&matrix.times(&p));
            levels.push(Coarse::new(matrix, Some((r, p))));
            matrix = shifted(next);
        }
        let direct = factorised(&matrix)?;
        levels.push(Coarse::new(matrix, None));
        Some(Self {
            restriction,
            prolongation,
            smoother,
            levels,
            direct,
            gamma,
        })
    }

    fn cycle(&self, level: usize, b: &[f64]) -> Vec<f64> {
        let coarse = &self.levels[level];
        let Some((restriction, prolongation)) = &coarse.transfer else {
            let mut x = b.to_vec();
            self.direct.solve(&mut x);
            return x;
        };
        let smooth = &coarse.smoother;
        let apply = |x: &[f64], y: &mut [f64]| coarse.matrix.apply(x, y);
        let mut x = vec![0.0; b.len()];
        smooth.run(&apply, &coarse.inverse_diagonal, b, &mut x, true);
        let repeats = if level + 2 < self.levels.len() { self.gamma } else { 1 };
        let mut r = vec![0.0; b.len()];
        for _ in 0..repeats {
            residual(&apply, b, &x, &mut r);
            let mut rc = vec![0.0; restriction.rows()];
            restriction.apply(&r, &mut rc);
            let correction = self.cycle(level + 1, &rc);
            prolongation.apply(&correction, &mut r);
            x.iter_mut().zip(&r).for_each(|(x, c)| *x += c);
        }
        smooth.run(&apply, &coarse.inverse_diagonal, b, &mut x, false);
        x
    }
}

fn residual(apply: &dyn Fn(&[f64], &mut [f64]), b: &[f64], x: &[f64], r: &mut [f64]) {
    apply(x, r);
    r.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
}

fn shifted(mut matrix: Csr) -> Csr {
    let top = matrix.diagonal().into_iter().fold(0.0, f64::max);
    for i in 0..matrix.rows() {
        for k in matrix.offsets[i]..matrix.offsets[i + 1] {
            if matrix.indices[k] as usize == i {
                matrix.values[k] += SHIFT * top;
            }
        }
    }
    matrix
}

/// The factor of the coarsest matrix, lifted further where rounding has left it indefinite.
fn factorised(matrix: &Csr) -> Option<Cholesky> {
    let n = matrix.rows();
    let top = matrix.diagonal().into_iter().fold(0.0, f64::max);
    (0..5).find_map(|k| {
        let mut entries = dense(matrix);
        if k > 0 {
            for i in 0..n {
                entries[i * n + i] += top * 1e-10 * 100f64.powi(k);
            }
        }
        Cholesky::new(&entries, n)
    })
}

fn dense(matrix: &Csr) -> Vec<f64> {
    let n = matrix.rows();
    let mut out = vec![0.0; n * n];
    for i in 0..n {
        for (j, v) in matrix.row(i) {
            out[i * n + j as usize] = v;
        }
    }
    out
}

impl Coarse {
    fn new(matrix: Csr, transfer: Option<(Csr, Csr)>) -> Self {
        let inverse_diagonal: Vec<f64> = matrix
            .diagonal()
            .into_iter()
            .map(|d| if d > 0.0 { 1.0 / d } else { 0.0 })
            .collect();
        let apply = |x: &[f64], y: &mut [f64]| matrix.apply(x, y);
        let smoother = Chebyshev::new(COARSE_DEGREE, COARSE_RATIO, &apply, &inverse_diagonal);
        Self {
            matrix,
            inverse_diagonal,
            smoother,
            transfer,
        }
    }
}

/// Chebyshev iteration over [λ/ratio, λ] of D⁻¹A (Adams, Brezina, Hu, Tuminaro 2003).
struct Chebyshev {
    degree: usize,
    theta: f64,
    delta: f64,
}

impl Chebyshev {
    fn new(
        degree: usize,
        ratio: f64,
        apply: &dyn Fn(&[f64], &mut [f64]),
        inverse_diagonal: &[f64],
    ) -> Self {
        let lambda = SAFETY * largest_eigenvalue(apply, inverse_diagonal);
        Self {
            degree,
            theta: 0.5 * (lambda + lambda / ratio),
            delta: 0.5 * (lambda - lambda / ratio),
        }
    }

    fn run(
        &self,
        apply: &dyn Fn(&[f64], &mut [f64]),
        inverse_diagonal: &[f64],
        b: &[f64],
        x: &mut [f64],
        from_zero: bool,
    ) {
        let n = b.len();
        let mut r = b.to_vec();
        let mut ap = vec![0.0; n];
        if !from_zero {
            residual(apply, b, x, &mut r);
        }
        let sigma = self.theta / self.delta;
        let mut rho = 1.0 / sigma;
        let mut p: Vec<f64> = (0..n).map(|i| inverse_diagonal[i] * r[i] / self.theta).collect();
        x.iter_mut().zip(&p).for_each(|(x, p)| *x += p);
        for _ in 1..self.degree {
            apply(&p, &mut ap);
            let next = 1.0 / (2.0 * sigma - rho);
            for i in 0..n {
                r[i] -= ap[i];
                p[i] = next * rho * p[i] + 2.0 * next / self.delta * inverse_diagonal[i] * r[i];
                x[i] += p[i];
            }
            rho = next;
        }
    }
}

/// The largest eigenvalue of D⁻¹A by power iterations from a fixed rough vector.
fn largest_eigenvalue(apply: &dyn Fn(&[f64], &mut [f64]), inverse_diagonal: &[f64]) -> f64 {
    let n = inverse_diagonal.len();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut v: Vec<f64> = (0..n)
        .map(|i| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let random = (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
            if inverse_diagonal[i] > 0.0 { random } else { 0.0 }
        })
        .collect();
    let mut w = vec![0.0; n];
    let mut lambda = 1.0;
    for _ in 0..POWER_ITERATIONS {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length <= 0.0 || !length.is_finite() {
            break;
        }
        v.iter_mut().for_each(|x| *x /= length);
        apply(&v, &mut w);
        for i in 0..n {
            v[i] = inverse_diagonal[i] * w[i];
        }
        lambda = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    }
    lambda
}

/// A multigrid cycle round a fine operator.
pub struct MultigridCycle<'a, A: LinearOperator> {
    /// The fine operator.
    pub operator: &'a A,
    /// The coarse levels.
    pub coarse: &'a Multigrid,
}

impl<A: LinearOperator> Preconditioner for MultigridCycle<'_, A> {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        let smooth = &self.coarse.smoother;
        let apply = |x: &[f64], y: &mut [f64]| self.operator.apply(x, y);
        z.fill(0.0);
        smooth.run(&apply, self.operator.jacobi(), r, z, true);
        let mut rest = vec![0.0; r.len()];
        residual(&apply, r, z, &mut rest);
        let mut rc = vec![0.0; self.coarse.restriction.rows()];
        self.coarse.restriction.apply(&rest, &mut rc);
        let correction = self.coarse.cycle(0, &rc);
        self.coarse.prolongation.apply(&correction, &mut rest);
        z.iter_mut().zip(&rest).for_each(|(z, c)| *z += c);
        smooth.run(&apply, self.operator.jacobi(), r, z, false);
    }
}
