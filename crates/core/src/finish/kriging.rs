//! Universal kriging of heights over a chart.
//!
//! The surface is modelled as a drift (a polynomial) plus an intrinsic random function with a generalised covariance (G.
//! Matheron, "The intrinsic random functions and their applications", 1973; H. Wackernagel, "Multivariate Geostatistics", part
//! V), observed with noise (also M. L. Stein, "Interpolation of Spatial Data", 1999). The kernel's order and the noise maximise
//! the restricted likelihood (H. D. Patterson, R. Thompson, "Recovery of inter-block information when block sizes are unequal",
//! 1971): the likelihood of the data without their drift.

use glam::DVec2;

use crate::cancel::Cancel;
use crate::elementary::ln;
use crate::linalg::{Symmetric, Triangle, Tridiagonal};
use crate::tuning::{Tunable, tunable};

/// Fraction of the kernel's largest eigenvalue. Added to the noise so that the system can be solved.
const KRIGING_RIDGE: Tunable<f64> = tunable("finish.kriging_ridge", 1e-10);

/// Candidate orders of the kernel.
pub(super) const ORDERS: [u8; 4] = [2, 3, 4, 5];
/// Candidate noise levels: the distance, in mean edges, at which the kernel equals the variance of the noise. Noisy meshes need
/// the larger ones: on a sphere with noise of 3 % and 10 % of an edge, every patch took 1.6 when the list ended there, with a
/// kernel too rough.
const NUGGETS: [f64; 10] = [0.0, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4, 12.8, 25.6];
/// Maximum number of terms of a drift.
const TERMS: usize = 6;

/// The generalised covariance of an order for a squared distance: `r² ln r`, `r³`, `−r⁴ ln r`, `−r⁵`.
fn covariance(order: u8, squared: f64) -> f64 {
    let s = squared.max(1e-24);
    match order {
        2 => 0.5 * s * ln(s),
        3 => s * s.sqrt(),
        4 => -0.5 * s * s * ln(s),
        _ => -s * s * s.sqrt(),
    }
}

/// Number of drift terms that a kernel needs: linear up to order 3, quadratic above.
fn terms(order: u8) -> usize {
    if order > 3 { TERMS } else { 3 }
}

/// The terms of the drift at a point.
fn drift(p: DVec2) -> [f64; TERMS] {
    [1.0, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y]
}

/// The model of a kriging: kernel of the surface and noise of the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Model {
    /// The order of the kernel.
    pub(super) order: u8,
    /// The noise level, as a length in mean edges; see [`NUGGETS`].
    pub(super) nugget: f64,
}

/// A surface kriged from data.
pub(super) struct Kriging {
    points: Vec<DVec2>,
    weights: Vec<f64>,
    coefficients: Vec<f64>,
    model: Model,
    contrasts: Contrasts,
    factor: Triangle,
    /// The variance of the surface, in units of the kernel.
    scale: f64,
    /// The variance of the noise, in units of `scale`.
    noise: f64,
}

/// QR factorisation of the drift at the data by Householder reflectors; rows below the triangle are free of drift.
struct DriftBasis {
    reflectors: Vec<(Vec<f64>, f64)>,
    /// The triangle R, by rows.
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

/// Applies a Householder reflector: `x ← x − factor v vᵀ x`.
fn reflect(v: &[f64], factor: f64, x: &mut [f64]) {
    let s: f64 = factor * v.iter().zip(x.iter()).map(|(a, b)| a * b).sum::<f64>();
    x.iter_mut().zip(v).for_each(|(x, v)| *x -= s * v);
}

/// The data without their drift, and the blocks of `Qᵀ K Q` and `Qᵀ z` needed besides.
struct Contrasts {
    basis: DriftBasis,
    /// The first entries of `Qᵀ z`, one for each drift term.
    top_data: Vec<f64>,
    /// The other entries of `Qᵀ z`, which are free of drift.
    data: Vec<f64>,
    /// The drift's block of `Qᵀ K Q`, and the block below it.
    top: Vec<f64>,
    cross: Vec<f64>,
}

impl Contrasts {
    /// Also returns `Zᵀ K Z`, the kernel's block that is free of drift.
    fn new(points: &[DVec2], heights: &[f64], order: u8) -> (Self, Symmetric) {
        let (n, m) = (points.len(), terms(order));
        let entry = |i: usize, j: usize| covariance(order, points[i].distance_squared(points[j]));
        let mut kernel = Symmetric::new(n, entry);
        let basis = DriftBasis::new(points, m);
        for (v, factor) in &basis.reflectors {
            kernel.reflect(v, *factor);
        }
        let block = |i: usize| (0..m).map(move |j| (i, j));
        let entries = |rows: std::ops::Range<usize>| -> Vec<f64> {
            let all = rows.flat_map(block);
            all.map(|(i, j)| kernel.get(i, j)).collect()
        };
        let (top, cross) = (entries(0..m), entries(m..n));
        let mut top_data = heights.to_vec();
        basis.to(&mut top_data);
        let data = top_data.split_off(m);
        let contrasts = Self {
            basis,
            top_data,
            data,
            top,
            cross,
        };
        (contrasts, kernel.without_first(m))
    }

    /// The transpose of the block below the drift's, times a vector.
    fn cross_times(&self, x: &[f64]) -> Vec<f64> {
        let m = self.basis.terms;
        let mut out = vec![0.0; m];
        for (row, x) in self.cross.chunks_exact(m).zip(x) {
            out.iter_mut().zip(row).for_each(|(o, r)| *o += r * x);
        }
        out
    }
}

impl Model {
    /// The model with one of these orders of largest restricted likelihood, `−½ (n ln mean(yᵀ (ZᵀKZ + ν)⁻¹ y) + ln det (ZᵀKZ + ν))`
    /// with `y = Zᵀ z`. `edge` is the mean edge in the points' unit. `ZᵀKZ` is reduced to tridiagonal form once for each order; the form serves
    /// all nuggets. `None` if there are too few data, if no likelihood is finite, or if the token is set.
    pub(super) fn estimate(
        points: &[DVec2],
        heights: &[f64],
        edge: f64,
        orders: &[u8],
        cancel: &Cancel,
    ) -> Option<Self> {
        if points.len() < 2 * TERMS {
            return None;
        }
        let mut best = None::<(f64, Self)>;
        for &order in orders {
            if cancel.is_cancelled() {
                return None;
            }
            let (contrasts, kernel) = Contrasts::new(points, heights, order);
            let (count, ridge) = (
                contrasts.data.len() as f64,
                KRIGING_RIDGE.get() * kernel.largest_eigenvalue(),
            );
            let reduced = Tridiagonal::new(kernel);
            let mut data = contrasts.data;
            reduced.to_reduced(&mut data);
            // The shift by a noise level costs O(n) on the tridiagonal form.
            for nugget in NUGGETS {
                let model = Self { order, nugget };
                let Some(shifted) = reduced.shifted(model.noise(edge) + ridge) else {
                    continue;
                };
                let scale = (shifted.quadratic(&data) / count).max(1e-300);
                let likelihood = -0.5 * (count * ln(scale) + shifted.log_determinant());
                if likelihood.is_finite() && best.is_none_or(|b| likelihood > b.0) {
                    best = Some((likelihood, model));
                }
            }
        }
        best.map(|b| b.1)
    }

    /// The variance of the noise, in units of the kernel.
    fn noise(self, edge: f64) -> f64 {
        if self.nugget > 0.0 {
            covariance(self.order, (self.nugget * edge).powi(2)).abs()
        } else {
            0.0
        }
    }
}

impl Kriging {
    /// Kriging of heights at points with a model. `None` if there are too few data or the result is not finite.
    pub(super) fn new(
        points: Vec<DVec2>,
        heights: &[f64],
        edge: f64,
        model: Model,
    ) -> Option<Self> {
        if points.len() < 2 * TERMS {
            return None;
        }
        let (contrasts, kernel) = Contrasts::new(&points, heights, model.order);
        let ridge = KRIGING_RIDGE.get() * kernel.largest_eigenvalue();
        let noise = model.noise(edge) + ridge;
        // Weights of the data: (ZᵀKZ + ν) b = Zᵀz.
        let factor = kernel.cholesky(noise)?;
        let mut solution = contrasts.data.clone();
        factor.forward(&mut solution);
        let squares: f64 = solution.iter().map(|y| y * y).sum();
        let scale = squares / solution.len() as f64;
        factor.backward(&mut solution);
        // Coefficients of the drift: R c = top of Qᵀz − (lower block)ᵀ b.
        let cross = contrasts.cross_times(&solution);
        let both = contrasts.top_data.iter().zip(cross);
        let mut coefficients: Vec<f64> = both.map(|(z, k)| z - k).collect();
        contrasts.basis.solve(&mut coefficients);
        let mut weights = vec![0.0; contrasts.basis.terms];
        weights.extend(solution);
        contrasts.basis.from(&mut weights);
        let finite = weights.iter().chain(&coefficients).all(|w| w.is_finite());
        finite.then_some(Self {
            points,
            weights,
            coefficients,
            model,
            contrasts,
            factor,
            scale,
            noise,
        })
    }

    /// The standard deviation of the data's noise, in the unit of the heights.
    pub(super) fn noise_deviation(&self) -> f64 {
        (self.scale * self.noise).sqrt()
    }

    /// The height at a point.
    pub(super) fn at(&self, p: DVec2) -> f64 {
        let order = self.model.order;
        let pairs = self.points.iter().zip(&self.weights);
        let kernel = pairs.map(|(q, w)| w * covariance(order, p.distance_squared(*q)));
        let polynomial = self.coefficients.iter().zip(drift(p)).map(|(c, t)| c * t);
        kernel.sum::<f64>() + polynomial.sum::<f64>()
    }

    /// The standard deviation of the height at a point. In the basis `Q` with `Qᵀ B = (R, 0)`, the weights of the data are
    /// `(a, b)` with `Rᵀ a = t` (the drift's terms at the point) and `(A₂₂ + ν) b = k₂ − A₂₁ a`. The variance in units of the
    /// scale is `aᵀ (A₁₁ + ν) a − 2 aᵀ k₁ − bᵀ (A₂₂ + ν) b`.
    pub(super) fn deviation(&self, p: DVec2) -> f64 {
        let c = &self.contrasts;
        let m = c.basis.terms;
        let distances = self.points.iter().map(|q| p.distance_squared(*q));
        let mut k: Vec<f64> = distances.map(|d| covariance(self.model.order, d)).collect();
        c.basis.to(&mut k);
        let mut a = drift(p)[..m].to_vec();
        c.basis.solve_transposed(&mut a);
        let mut rest = k.split_off(m);
        for (r, row) in rest.iter_mut().zip(c.cross.chunks_exact(m)) {
            *r -= row.iter().zip(&a).map(|(c, a)| c * a).sum::<f64>();
        }
        self.factor.forward(&mut rest);
        let mut variance = -rest.iter().map(|r| r * r).sum::<f64>();
        for i in 0..m {
            let row: f64 = (0..m).map(|j| c.top[i * m + j] * a[j]).sum();
            variance += a[i] * (row + self.noise * a[i] - 2.0 * k[i]);
        }
        (self.scale * variance.max(0.0)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scattered(n: usize) -> Vec<DVec2> {
        (0..n)
            .map(|i| {
                let (r, a) = ((i as f64 + 0.5).sqrt(), i as f64 * 2.399_963);
                DVec2::from_angle(a) * r / (n as f64).sqrt()
            })
            .collect()
    }

    #[test]
    fn the_drift_is_reproduced_by_every_model() {
        let points = scattered(60);
        for order in ORDERS {
            for nugget in NUGGETS {
                let height = |p: DVec2| {
                    let linear = 0.3 - 1.2 * p.x + 0.7 * p.y;
                    if order > 3 {
                        linear + p.x * p.x - 0.4 * p.x * p.y
                    } else {
                        linear
                    }
                };
                let heights: Vec<f64> = points.iter().map(|p| height(*p)).collect();
                let model = Model { order, nugget };
                let kriging = Kriging::new(points.clone(), &heights, 0.1, model).unwrap();
                for p in [DVec2::new(0.2, 0.1), DVec2::new(-1.5, 0.9)] {
                    let off = kriging.at(p) - height(p);
                    assert!(off.abs() < 1e-7, "{order} {nugget} {off}");
                    assert!(kriging.deviation(p) < 1e-5);
                }
            }
        }
    }

    /// Solves the system of universal kriging, `(K + ν, B; Bᵀ, 0)`, by elimination with pivots.
    fn solved(points: &[DVec2], order: u8, noise: f64, rhs: &[f64]) -> Vec<f64> {
        let (n, m) = (points.len(), terms(order));
        let size = n + m;
        let mut a = vec![vec![0.0; size + 1]; size];
        for i in 0..n {
            for j in 0..n {
                a[i][j] = covariance(order, points[i].distance_squared(points[j]));
            }
            a[i][i] += noise;
            for j in 0..m {
                a[i][n + j] = drift(points[i])[j];
                a[n + j][i] = drift(points[i])[j];
            }
        }
        (0..size).for_each(|i| a[i][size] = rhs[i]);
        for k in 0..size {
            let pivot = (k..size).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()));
            a.swap(k, pivot.unwrap());
            let row = a[k].clone();
            for (i, other) in a.iter_mut().enumerate().filter(|(i, _)| *i != k) {
                let factor = other[k] / row[k];
                assert!(i < size && factor.is_finite());
                other
                    .iter_mut()
                    .zip(&row)
                    .for_each(|(x, r)| *x -= factor * r);
            }
        }
        (0..size).map(|k| a[k][size] / a[k][k]).collect()
    }

    #[test]
    fn predictions_and_deviations_are_those_of_the_full_system() {
        let points = scattered(30);
        let heights: Vec<f64> = points
            .iter()
            .map(|p| (3.0 * p.x).sin() + p.y * p.y)
            .collect();
        let at = DVec2::new(0.15, -0.35);
        for order in ORDERS {
            let model = Model { order, nugget: 0.8 };
            let kriging = Kriging::new(points.clone(), &heights, 0.3, model).unwrap();
            let n = points.len();
            let squared = points.iter().map(|p| p.distance_squared(at));
            let mut rhs: Vec<f64> = squared.map(|s| covariance(order, s)).collect();
            rhs.extend(&drift(at)[..terms(order)]);
            let weights = solved(&points, order, model.noise(0.3), &rhs);
            let height: f64 = weights.iter().zip(&heights).map(|(w, z)| w * z).sum();
            assert!((height - kriging.at(at)).abs() < 1e-7, "{order} {height}");
            let variance = -weights.iter().zip(&rhs).map(|(w, r)| w * r).sum::<f64>();
            let wanted = (kriging.scale * variance).sqrt();
            let deviation = kriging.deviation(at);
            assert!(
                (deviation / wanted - 1.0).abs() < 1e-5,
                "{order} {deviation} {wanted}"
            );
            assert_eq!(n, kriging.points.len());
        }
    }

    #[test]
    fn the_likelihood_separates_noise_from_shape() {
        let points = scattered(150);
        let smooth: Vec<f64> = points.iter().map(|p| (2.0 * p.x + p.y).cos()).collect();
        let exact = Model::estimate(&points, &smooth, 0.15, &ORDERS, &Cancel::new()).unwrap();
        assert!(exact.order >= 4 && exact.nugget <= 0.4, "{exact:?}");
        let noisy: Vec<f64> = (0..150)
            .map(|i| smooth[i] + 0.2 * (i as f64 * 78.233).sin())
            .collect();
        let noisy = Model::estimate(&points, &noisy, 0.15, &ORDERS, &Cancel::new()).unwrap();
        assert!(noisy.nugget > exact.nugget, "{noisy:?}");
    }

    #[test]
    fn too_few_data_or_none_apart_give_no_surface() {
        assert!(Model::estimate(&scattered(5), &[0.0; 5], 0.1, &ORDERS, &Cancel::new()).is_none());
        let heap = vec![DVec2::ONE; 40];
        let model = Model::estimate(&heap, &[1.0; 40], 0.1, &ORDERS, &Cancel::new());
        let kriging = model.and_then(|m| Kriging::new(heap, &[1.0; 40], 0.1, m));
        assert!(kriging.is_none());
    }
}
