//! Universal kriging of heights over a chart.
//!
//! The surface is taken for a drift, a polynomial, plus an intrinsic random function with a generalised covariance (G. Matheron,
//! "The intrinsic random functions and their applications", 1973; H. Wackernagel, "Multivariate Geostatistics", part V), seen
//! with noise. The kernel's order and the noise are those of the largest restricted likelihood (H. D. Patterson, R. Thompson,
//! "Recovery of inter-block information when block sizes are unequal", 1971), which is that of the data without their drift.

use glam::DVec2;

use crate::linalg::{Symmetric, Tridiagonal};

/// Orders of the kernel.
const ORDERS: [u8; 4] = [2, 3, 4, 5];
/// Noise, as the length, in mean edges, at which the kernel is as large.
const NUGGETS: [f64; 6] = [0.0, 0.1, 0.2, 0.4, 0.8, 1.6];
/// Added to the noise, in the kernel's largest eigenvalue, for the system to be solvable.
const RIDGE: f64 = 1e-10;
/// Most terms of a drift.
const TERMS: usize = 6;

/// The generalised covariance of an order at a squared distance: `r² ln r`, `r³`, `−r⁴ ln r`, `−r⁵`.
fn covariance(order: u8, squared: f64) -> f64 {
    let s = squared.max(1e-24);
    match order {
        2 => 0.5 * s * s.ln(),
        3 => s * s.sqrt(),
        4 => -0.5 * s * s * s.ln(),
        _ => -s * s * s.sqrt(),
    }
}

/// Number of terms of the drift that a kernel needs: linear up to order 3, quadratic above.
fn terms(order: u8) -> usize {
    if order > 3 { TERMS } else { 3 }
}

/// The terms of the drift at a point.
fn drift(p: DVec2) -> [f64; TERMS] {
    [1.0, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y]
}

/// A surface kriged from data.
pub(super) struct Kriging {
    points: Vec<DVec2>,
    weights: Vec<f64>,
    coefficients: Vec<f64>,
    /// The order of the kernel.
    pub(super) order: u8,
    /// The noise, as a length in mean edges.
    pub(super) nugget: f64,
    variance: Variance,
}

/// What the variance of a prediction needs.
struct Variance {
    basis: DriftBasis,
    reduced: Tridiagonal,
    shift: f64,
    top: Vec<f64>,
    cross: Vec<f64>,
    scale: f64,
}

/// Householder's reflectors that turn the drift at the data into an upper triangle; what is below is free of drift.
struct DriftBasis {
    reflectors: Vec<(Vec<f64>, f64)>,
    /// The triangle, by rows.
    triangle: Vec<f64>,
    terms: usize,
}

impl DriftBasis {
    fn new(points: &[DVec2], terms: usize) -> Self {
        let mut columns: Vec<Vec<f64>> = (0..terms)
            .map(|t| points.iter().map(|p| drift(*p)[t]).collect())
            .collect();
        let mut reflectors = Vec::with_capacity(terms);
        let mut triangle = vec![0.0; terms * terms];
        for k in 0..terms {
            let mut v = columns[k].clone();
            v[..k].fill(0.0);
            let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            let first = -norm.copysign(v[k]);
            let length = norm * (norm + v[k].abs());
            v[k] -= first;
            let factor = if length > 0.0 { 1.0 / length } else { 0.0 };
            for (j, column) in columns.iter_mut().enumerate().skip(k) {
                reflect(&v, factor, column);
                triangle[k * terms + j] = column[k];
            }
            reflectors.push((v, factor));
        }
        Self {
            reflectors,
            triangle,
            terms,
        }
    }

    /// `x ← Qᵀ x`.
    fn to(&self, x: &mut [f64]) {
        self.reflectors.iter().for_each(|(v, f)| reflect(v, *f, x));
    }

    /// `x ← Q x`.
    fn from(&self, x: &mut [f64]) {
        let reversed = self.reflectors.iter().rev();
        reversed.for_each(|(v, f)| reflect(v, *f, x));
    }

    /// Solves `R c = x`.
    fn solve(&self, x: &mut [f64]) {
        let n = self.terms;
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|j| self.triangle[i * n + j] * x[j]).sum();
            x[i] = (x[i] - known) / self.triangle[i * n + i];
        }
    }

    /// Solves `Rᵀ c = x`.
    fn solve_transposed(&self, x: &mut [f64]) {
        let n = self.terms;
        for i in 0..n {
            let known: f64 = (0..i).map(|j| self.triangle[j * n + i] * x[j]).sum();
            x[i] = (x[i] - known) / self.triangle[i * n + i];
        }
    }
}

fn reflect(v: &[f64], factor: f64, x: &mut [f64]) {
    let s: f64 = factor * v.iter().zip(x.iter()).map(|(a, b)| a * b).sum::<f64>();
    x.iter_mut().zip(v).for_each(|(x, v)| *x -= s * v);
}

/// The data without their drift, for one order: `Zᵀ K Z` reduced to tridiagonal form, and what else of `Qᵀ K Q` is needed.
struct Contrasts {
    basis: DriftBasis,
    reduced: Tridiagonal,
    /// `Qᵀ z`, its last part in the basis of the tridiagonal form.
    top_data: Vec<f64>,
    data: Vec<f64>,
    top: Vec<f64>,
    cross: Vec<f64>,
}

impl Contrasts {
    fn new(points: &[DVec2], heights: &[f64], squared: &[f64], order: u8) -> Self {
        let (n, m) = (points.len(), terms(order));
        let mut kernel = Symmetric::new(n, |i, j| covariance(order, squared[i * n + j]));
        let basis = DriftBasis::new(points, m);
        for (v, factor) in &basis.reflectors {
            kernel.reflect(v, *factor);
        }
        let mut top = vec![0.0; m * m];
        for i in 0..m {
            for j in 0..m {
                top[i * m + j] = kernel.get(i, j);
            }
        }
        let mut cross = Vec::with_capacity((n - m) * m);
        for i in m..n {
            cross.extend((0..m).map(|j| kernel.get(i, j)));
        }
        let reduced = Tridiagonal::new(kernel.without_first(m));
        let mut data = heights.to_vec();
        basis.to(&mut data);
        let top_data = data[..m].to_vec();
        let mut data = data.split_off(m);
        reduced.to_reduced(&mut data);
        Self {
            basis,
            reduced,
            top_data,
            data,
            top,
            cross,
        }
    }

    /// `Z`-part times the block of `Qᵀ K Q` beside the drift's.
    fn cross_times(&self, x: &[f64]) -> Vec<f64> {
        let m = self.basis.terms;
        let mut out = vec![0.0; m];
        for (row, x) in self.cross.chunks_exact(m).zip(x) {
            out.iter_mut().zip(row).for_each(|(o, r)| *o += r * x);
        }
        out
    }
}

/// The best of all orders and nuggets so far.
struct Choice {
    likelihood: f64,
    contrasts: Contrasts,
    order: u8,
    nugget: f64,
    shift: f64,
    scale: f64,
}

impl Kriging {
    /// Kriging of heights at points, with the order and the noise of the largest likelihood; `edge` is the mean edge in the
    /// points' unit. None where there are too few data or they allow no number.
    pub(super) fn new(points: Vec<DVec2>, heights: &[f64], edge: f64) -> Option<Self> {
        let n = points.len();
        if n < 2 * TERMS {
            return None;
        }
        let mut squared = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..i {
                squared[i * n + j] = points[i].distance_squared(points[j]);
            }
        }
        let mut best: Option<Choice> = None;
        for order in ORDERS {
            let contrasts = Contrasts::new(&points, heights, &squared, order);
            let count = contrasts.data.len() as f64;
            let ridge = RIDGE * contrasts.reduced.bound();
            let mut own = None::<(f64, f64, f64, f64)>;
            for nugget in NUGGETS {
                let noise = if nugget > 0.0 {
                    covariance(order, (nugget * edge).powi(2)).abs()
                } else {
                    0.0
                };
                let shift = noise + ridge;
                let Some(shifted) = contrasts.reduced.shifted(shift) else {
                    continue;
                };
                let scale = shifted.quadratic(&contrasts.data) / count;
                let likelihood =
                    -0.5 * (count * scale.max(1e-300).ln() + shifted.log_determinant());
                if likelihood.is_finite() && own.is_none_or(|o| likelihood > o.0) {
                    own = Some((likelihood, nugget, shift, scale));
                }
            }
            let Some((likelihood, nugget, shift, scale)) = own else {
                continue;
            };
            if best.as_ref().is_none_or(|b| likelihood > b.likelihood) {
                best = Some(Choice {
                    likelihood,
                    contrasts,
                    order,
                    nugget,
                    shift,
                    scale,
                });
            }
        }
        best?.kriging(points)
    }

    /// The height at a point.
    pub(super) fn at(&self, p: DVec2) -> f64 {
        let pairs = self.points.iter().zip(&self.weights);
        let kernel = pairs.map(|(q, w)| w * covariance(self.order, p.distance_squared(*q)));
        let polynomial = self.coefficients.iter().zip(drift(p)).map(|(c, t)| c * t);
        kernel.sum::<f64>() + polynomial.sum::<f64>()
    }

    /// The standard deviation of the height at a point. In the basis `Q` with `Qᵀ B = (R, 0)`, the weights of the data are `(a,
    /// b)` with `Rᵀ a = t` (the drift's terms at the point) and `(A₂₂ + ν) b = k₂ − A₂₁ a`, and the variance in units of the
    /// scale is `aᵀ A₁₁ a − 2 aᵀ k₁ − bᵀ (A₂₂ + ν) b`.
    pub(super) fn deviation(&self, p: DVec2) -> f64 {
        let v = &self.variance;
        let m = v.basis.terms;
        let distances = self.points.iter().map(|q| p.distance_squared(*q));
        let mut k: Vec<f64> = distances.map(|d| covariance(self.order, d)).collect();
        v.basis.to(&mut k);
        let mut a = drift(p)[..m].to_vec();
        v.basis.solve_transposed(&mut a);
        let mut rest = k.split_off(m);
        for (r, row) in rest.iter_mut().zip(v.cross.chunks_exact(m)) {
            *r -= row.iter().zip(&a).map(|(c, a)| c * a).sum::<f64>();
        }
        v.reduced.to_reduced(&mut rest);
        let Some(shifted) = v.reduced.shifted(v.shift) else {
            return f64::NAN;
        };
        let mut variance = -shifted.quadratic(&rest);
        for i in 0..m {
            let row: f64 = (0..m).map(|j| v.top[i * m + j] * a[j]).sum();
            variance += a[i] * (row - 2.0 * k[i]);
        }
        (v.scale * variance.max(0.0)).sqrt()
    }
}

impl Choice {
    fn kriging(self, points: Vec<DVec2>) -> Option<Kriging> {
        let c = self.contrasts;
        let mut solution = c.data.clone();
        c.reduced.shifted(self.shift)?.solve(&mut solution);
        c.reduced.from_reduced(&mut solution);
        let cross = c.cross_times(&solution);
        let mut coefficients: Vec<f64> = c.top_data.iter().zip(cross).map(|(z, k)| z - k).collect();
        c.basis.solve(&mut coefficients);
        let mut weights = vec![0.0; c.basis.terms];
        weights.extend(solution);
        c.basis.from(&mut weights);
        let finite = weights.iter().chain(&coefficients).all(|w| w.is_finite());
        finite.then_some(Kriging {
            points,
            weights,
            coefficients,
            order: self.order,
            nugget: self.nugget,
            variance: Variance {
                basis: c.basis,
                reduced: c.reduced,
                shift: self.shift,
                top: c.top,
                cross: c.cross,
                scale: self.scale,
            },
        })
    }
}
