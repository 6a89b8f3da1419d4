//! Galerkin multigrid as a preconditioner.
//!
//! The caller supplies the prolongations; coarse matrices are Galerkin products. Smoothers are Chebyshev polynomials in D⁻¹A; the
//! coarsest system is solved by Cholesky factorisation. The cycle (V-cycle) runs in single precision.

use std::sync::Mutex;

use super::cg::{LinearOperator, Preconditioner};
use super::csr::Csr;
use super::dense::Cholesky;
use crate::elementary::powi;

/// Parameters of the smoother on a level.
struct Smoothing {
    degree: usize,
    /// Largest eigenvalue λ over the smallest eigenvalue that is damped.
    ratio: f32,
    /// Power iterations to estimate λ, the largest eigenvalue of D⁻¹A, and the factor for their underestimate: 16 to 20 % on the
    /// finest level, where iterations cost most; less on the others.
    power_iterations: usize,
    safety: f32,
}

/// Smoother of the finest level.
const FINE: Smoothing = Smoothing {
    degree: 2,
    ratio: 6.0,
    power_iterations: 6,
    safety: 1.22,
};
/// Smoother of the coarse levels.
const COARSE: Smoothing = Smoothing {
    degree: 4,
    ratio: 8.0,
    power_iterations: 15,
    safety: 1.08,
};
/// Added to the diagonal of coarse matrices, as a fraction of their largest diagonal entry.
const SHIFT: f64 = 1e-10;
/// Systems with at most this number of unknowns are solved directly.
const DIRECT: usize = 400;

/// A coarse level.
struct Coarse {
    matrix: Csr<f32>,
    inverse_diagonal: Vec<f32>,
    smoother: Chebyshev,
    /// Restriction to the next coarser level, and prolongation from it.
    transfer: Option<(Csr<f32>, Csr<f32>)>,
}

/// Scratch vectors of one level, reused from one cycle to the next.
#[derive(Clone, Default)]
struct Space {
    /// Right-hand side.
    b: Vec<f32>,
    /// Solution.
    x: Vec<f32>,
    /// Residual.
    rest: Vec<f32>,
    direction: Vec<f32>,
    product: Vec<f32>,
}

impl Space {
    fn new(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        Self {
            b: zeros(),
            x: zeros(),
            rest: zeros(),
            direction: zeros(),
            product: zeros(),
        }
    }
}

/// The coarse levels of a hierarchy, for use with the fine operator they were made for or one close to it.
pub struct Multigrid {
    restriction: Csr<f32>,
    prolongation: Csr<f32>,
    smoother: Chebyshev,
    levels: Vec<Coarse>,
    direct: Cholesky,
    /// Scratch vectors of the finest and of each coarse level; a running cycle takes them out.
    spaces: Mutex<Vec<Space>>,
}

impl Multigrid {
    /// Builds the levels from the fine operator, the prolongation to the finest level, the Galerkin matrix of the first coarse
    /// level, and the prolongations between the coarse levels, finest first. `None` if the coarsest matrix is not positive
    /// definite, or once the operator is cancelled.
    pub fn new(
        operator: &impl LinearOperator,
        prolongation: Csr,
        first: Csr,
        coarser: Vec<Csr>,
    ) -> Option<Self> {
        let apply = |x: &[f32], y: &mut [f32]| operator.apply_single(x, y);
        let diagonal: Vec<f32> = operator.jacobi().iter().map(|&d| d as f32).collect();
        // The smoother of the finest level.
        let smoother = Chebyshev::new(&FINE, &apply, &diagonal);
        let prolongation = prolongation.into_single();
        let mut levels = Vec::new();
        let mut matrix = shifted(first);
        for p in coarser {
            if operator.is_cancelled() {
                return None;
            }
            // The remaining levels are not needed: this one is solved directly.
            if matrix.rows() <= DIRECT {
                break;
            }
            // The Galerkin product RAP with R = Pᵀ.
            let r = p.transposed();
            let next = r.times(&matrix.times(&p));
            levels.push(Coarse::new(
                matrix,
                Some((r.into_single(), p.into_single())),
            ));
            matrix = shifted(next);
        }
        let direct = factorised(&matrix)?;
        levels.push(Coarse::new(matrix, None));
        Some(Self {
            restriction: prolongation.transposed(),
            prolongation,
            smoother,
            levels,
            direct,
            spaces: Mutex::default(),
        })
    }

    /// Takes the scratch vectors, or allocates them if another cycle has them.
    fn spaces(&self) -> Vec<Space> {
        let kept = self.spaces.lock().map(|mut s| std::mem::take(&mut *s));
        match kept {
            Ok(spaces) if !spaces.is_empty() => spaces,
            _ => std::iter::once(self.prolongation.rows())
                .chain(self.levels.iter().map(|l| l.matrix.rows()))
                .map(Space::new)
                .collect(),
        }
    }

    /// A V-cycle from a coarse level down: solves approximately for the right-hand side `spaces[0].b`, into `spaces[0].x`.
    fn cycle(&self, level: usize, spaces: &mut [Space]) {
        let coarse = &self.levels[level];
        let [here, coarser @ ..] = spaces else {
            return;
        };
        let Some((restriction, prolongation)) = &coarse.transfer else {
            let mut x: Vec<f64> = here.b.iter().map(|&v| v.into()).collect();
            self.direct.solve(&mut x);
            here.x.iter_mut().zip(x).for_each(|(x, v)| *x = v as f32);
            return;
        };
        let apply = |x: &[f32], y: &mut [f32]| coarse.matrix.apply(x, y);
        coarse
            .smoother
            .run(&apply, &coarse.inverse_diagonal, here, true);
        here.subtract(&apply);
        restriction.apply(&here.rest, &mut coarser[0].b);
        self.cycle(level + 1, coarser);
        prolongation.apply(&coarser[0].x, &mut here.product);
        here.correct();
        coarse
            .smoother
            .run(&apply, &coarse.inverse_diagonal, here, false);
    }
}

impl Space {
    /// `rest = b − A x`.
    fn subtract(&mut self, apply: &dyn Fn(&[f32], &mut [f32])) {
        apply(&self.x, &mut self.product);
        for ((r, b), p) in self.rest.iter_mut().zip(&self.b).zip(&self.product) {
            *r = b - p;
        }
    }

    /// Adds the coarse correction, which is in `product`, to the solution.
    fn correct(&mut self) {
        for (x, c) in self.x.iter_mut().zip(&self.product) {
            *x += c;
        }
    }
}

/// Adds a small multiple of its largest entry to the diagonal.
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

/// The factor of the coarsest matrix, with a growing diagonal shift if rounding has made it indefinite.
fn factorised(matrix: &Csr) -> Option<Cholesky> {
    let n = matrix.rows();
    let top = matrix.diagonal().into_iter().fold(0.0, f64::max);
    (0..5).find_map(|k| {
        let mut entries = dense(matrix);
        if k > 0 {
            for i in 0..n {
                entries[i * n + i] += top * 1e-10 * powi(100.0, k);
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
    fn new(matrix: Csr, transfer: Option<(Csr<f32>, Csr<f32>)>) -> Self {
        let inverse_diagonal: Vec<f32> = matrix
            .diagonal()
            .into_iter()
            .map(|d| if d > 0.0 { (1.0 / d) as f32 } else { 0.0 })
            .collect();
        let matrix = matrix.into_single();
        let apply = |x: &[f32], y: &mut [f32]| matrix.apply(x, y);
        let smoother = Chebyshev::new(&COARSE, &apply, &inverse_diagonal);
        Self {
            matrix,
            inverse_diagonal,
            smoother,
            transfer,
        }
    }
}

/// Chebyshev smoother for the interval [λ/ratio, λ] of eigenvalues of D⁻¹A (Adams, Brezina, Hu, Tuminaro 2003).
struct Chebyshev {
    degree: usize,
    theta: f32,
    delta: f32,
}

impl Chebyshev {
    fn new(
        smoothing: &Smoothing,
        apply: &dyn Fn(&[f32], &mut [f32]),
        inverse_diagonal: &[f32],
    ) -> Self {
        let Smoothing { degree, ratio, .. } = *smoothing;
        let found = largest_eigenvalue(apply, inverse_diagonal, smoothing.power_iterations);
        let lambda = smoothing.safety * found;
        Self {
            degree,
            theta: 0.5 * (lambda + lambda / ratio),
            delta: 0.5 * (lambda - lambda / ratio),
        }
    }

    /// Smooths `space.x` for the right-hand side `space.b`; the initial x counts as zero if `from_zero`.
    fn run(
        &self,
        apply: &dyn Fn(&[f32], &mut [f32]),
        inverse_diagonal: &[f32],
        space: &mut Space,
        from_zero: bool,
    ) {
        // The residual: b itself for x = 0.
        if from_zero {
            space.x.fill(0.0);
            space.rest.copy_from_slice(&space.b);
        } else {
            space.subtract(apply);
        }
        let Space {
            x,
            rest,
            direction,
            product,
            ..
        } = space;
        // First direction: D⁻¹ r / θ, where θ is the middle of the interval and δ half its length (Y. Saad, "Iterative Methods
        // for Sparse Linear Systems", 2003, algorithm 12.1).
        let sigma = self.theta / self.delta;
        let mut rho = 1.0 / sigma;
        let scale = 1.0 / self.theta;
        for (((p, x), d), r) in direction
            .iter_mut()
            .zip(&mut *x)
            .zip(inverse_diagonal)
            .zip(&*rest)
        {
            *p = scale * d * r;
            *x += *p;
        }
        // Each further direction is ρ ρ₋ times the last plus 2ρ/δ times D⁻¹ r, with ρ = 1 / (2θ/δ − ρ₋) where ρ₋ is the ρ of the
        // step before.
        for _ in 1..self.degree {
            apply(direction, product);
            let next = 1.0 / (2.0 * sigma - rho);
            let (keep, add) = (next * rho, 2.0 * next / self.delta);
            for ((((p, x), d), r), a) in direction
                .iter_mut()
                .zip(&mut *x)
                .zip(inverse_diagonal)
                .zip(&mut *rest)
                .zip(&*product)
            {
                *r -= a;
                *p = keep * *p + add * d * *r;
                *x += *p;
            }
            rho = next;
        }
    }
}

/// The largest eigenvalue of D⁻¹A by power iterations from a fixed pseudo-random vector.
fn largest_eigenvalue(
    apply: &dyn Fn(&[f32], &mut [f32]),
    inverse_diagonal: &[f32],
    iterations: usize,
) -> f32 {
    let n = inverse_diagonal.len();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut v: Vec<f32> = (0..n)
        .map(|i| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let random = (state >> 40) as f32 / (1u32 << 24) as f32 - 0.5;
            if inverse_diagonal[i] > 0.0 {
                random
            } else {
                0.0
            }
        })
        .collect();
    let mut w = vec![0.0; n];
    let mut lambda = 1.0;
    let norm = |v: &[f32]| v.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>().sqrt() as f32;
    for _ in 0..iterations {
        let length = norm(&v);
        if length <= 0.0 || !length.is_finite() {
            break;
        }
        v.iter_mut().for_each(|x| *x /= length);
        apply(&v, &mut w);
        for i in 0..n {
            v[i] = inverse_diagonal[i] * w[i];
        }
        lambda = norm(&v);
    }
    lambda
}

/// A multigrid cycle on a fine operator, as a preconditioner.
pub struct MultigridCycle<'a, A: LinearOperator> {
    operator: &'a A,
    coarse: &'a Multigrid,
    inverse_diagonal: Vec<f32>,
}

impl<'a, A: LinearOperator> MultigridCycle<'a, A> {
    /// Combines the fine operator and the coarse levels.
    pub fn new(operator: &'a A, coarse: &'a Multigrid) -> Self {
        Self {
            operator,
            coarse,
            inverse_diagonal: operator.jacobi().iter().map(|&d| d as f32).collect(),
        }
    }
}

impl<A: LinearOperator> Preconditioner for MultigridCycle<'_, A> {
    fn estimates_error(&self) -> bool {
        true
    }

    fn apply(&self, r: &[f64], z: &mut [f64]) {
        let coarse = self.coarse;
        let apply = |x: &[f32], y: &mut [f32]| self.operator.apply_single(x, y);
        let mut spaces = coarse.spaces();
        let [fine, coarser @ ..] = &mut spaces[..] else {
            return;
        };
        // Scales the right-hand side so that entries stay well inside the range of single precision.
        let top = r.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let scale = if top > 0.0 { top.recip() } else { 1.0 };
        for (b, r) in fine.b.iter_mut().zip(r) {
            *b = (scale * r) as f32;
        }
        coarse
            .smoother
            .run(&apply, &self.inverse_diagonal, fine, true);
        if self.operator.is_cancelled() {
            return;
        }
        fine.subtract(&apply);
        coarse.restriction.apply(&fine.rest, &mut coarser[0].b);
        coarse.cycle(0, coarser);
        coarse.prolongation.apply(&coarser[0].x, &mut fine.product);
        fine.correct();
        coarse
            .smoother
            .run(&apply, &self.inverse_diagonal, fine, false);
        for (z, &x) in z.iter_mut().zip(&fine.x) {
            *z = top * f64::from(x);
        }
        if let Ok(mut kept) = coarse.spaces.lock() {
            *kept = spaces;
        }
    }
}
