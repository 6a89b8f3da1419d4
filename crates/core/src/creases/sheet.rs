//! Sheets: a smooth side of a surface as an implicit plane or quadric, which continues beyond its data.

use glam::DVec3;

use super::residuals::Residuals;
use crate::elementary::ln;
use crate::linalg::{Cholesky, second_moments, solve_spd, symmetric_eigen};
use crate::tuning::{Tunable, tunable};

/// Number of coefficients of a quadric: x², y², z², xy, yz, xz, x, y, z and 1.
const TERMS: usize = 10;
/// Minimum number of points of a quadric; with fewer a plane is fitted.
const FEWEST_OF_QUADRIC: Tunable<usize> = tunable("creases.sheet.fewest_of_quadric", 14);
/// Maximum weight of a unit normal relative to a position in the sheet's scale; less if edges are short.
const NORMAL_WEIGHT: Tunable<f64> = tunable("creases.sheet.normal_weight", 0.3);
/// Ridge on the quadratic terms, relative to the weight of normals, so that planes and cylinders stay exact.
const RIDGE: f64 = 1e-3;
/// Ridge on the other terms, which makes the system solvable.
const LINEAR_RIDGE: f64 = 1e-9;
/// Number of fits in which values and gradients are divided by the length of the gradient of the quadric before: along a cone the gradient
/// of its implicit function has no constant length.
const REWEIGHTINGS: Tunable<usize> = tunable("creases.sheet.reweightings", 2);
/// Bounds of these lengths.
const SLOPE: [f64; 2] = [0.2, 5.0];
/// Minimum gain in twice the log-likelihood for the reweighted quadric: gradients of unit length keep the others near cylinders and planes,
/// and without the bound noise made patches on cylinders twice as inaccurate.
const REWEIGHTED: Tunable<f64> = tunable("creases.sheet.reweighted", 30.0);
/// Maximum residual, in edges, of a quadric that is reweighted: with more noise it follows the noise.
const MOST_NOISE: Tunable<f64> = tunable("creases.sheet.most_noise", 0.08);
/// Maximum number of points that are compared with their neighbours, and number of neighbours, for the noise.
const MOST_COMPARED: Tunable<usize> = tunable("creases.sheet.most_compared", 200);
const NEIGHBOURS: usize = 6;
/// Residuals below this fraction of an edge are rounding errors and do not decide between plane and quadric.
const ROUNDING: f64 = 1e-5;

/// An implicit surface `f = 0` fitted to points and normals; `f` is positive outside.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    origin: DVec3,
    scale: f64,
    terms: [f64; TERMS],
    /// The points to which it was fitted.
    pub(super) points: Vec<DVec3>,
    /// Their unit normals.
    pub(super) normals: Vec<DVec3>,
    /// Root mean square distance of the points.
    pub(super) residual: f64,
    /// Kriged residuals added to the plane or quadric, if any.
    residuals: Option<Residuals>,
}

impl Sheet {
    /// Fits a plane or a quadric to points with unit normals. The quadric is used if its smaller residual justifies six more
    /// coefficients (Bayesian information criterion). `scale` is the unit of length of the fit, `edge` the mean edge length of
    /// the mesh.
    pub(super) fn fit(points: Vec<DVec3>, normals: Vec<DVec3>, scale: f64, edge: f64) -> Self {
        let plane = Self::plane(points, normals, scale);
        let count = plane.points.len() as f64;
        if plane.points.len() < FEWEST_OF_QUADRIC.get() {
            return plane;
        }
        let Some(quadric) = plane.quadric(edge) else {
            return plane;
        };
        let square = |residual: f64| residual.powi(2) + (ROUNDING * edge).powi(2);
        let gain = count * ln(square(quadric.residual) / square(plane.residual));
        match gain + 6.0 * ln(count) < 0.0 && quadric.residual < plane.residual {
            true => quadric,
            false => plane,
        }
    }

    /// The least-squares plane of some points; their normals determine its orientation.
    pub(super) fn plane(points: Vec<DVec3>, normals: Vec<DVec3>, scale: f64) -> Self {
        let count = points.len().max(1) as f64;
        let origin = points.iter().sum::<DVec3>() / count;
        let moments = second_moments(points.iter().map(|p| (*p - origin) / scale));
        let (_, axes) = symmetric_eigen(&moments);
        let outside: DVec3 = normals.iter().sum();
        let normal = axes[0]
            * if axes[0].dot(outside) < 0.0 {
                -1.0
            } else {
                1.0
            };
        let squares = points.iter().map(|p| (*p - origin).dot(normal).powi(2));
        let residual = (squares.sum::<f64>() / count).sqrt();
        let mut terms = [0.0; TERMS];
        terms[6..9].copy_from_slice(&normal.to_array());
        Self {
            origin,
            scale,
            terms,
            points,
            normals,
            residual,
            residuals: None,
        }
    }

    /// The least-squares quadric of the plane's points and normals; `None` if the system cannot be solved.
    fn quadric(&self, edge: f64) -> Option<Self> {
        let weight = NORMAL_WEIGHT.get().min(edge / self.scale);
        let even = self.weighted_quadric(weight, |_| 1.0)?;
        let square = |residual: f64| residual.powi(2) + (ROUNDING * edge).powi(2);
        let is_gain = |residual: f64| {
            let ratio = square(even.residual) / square(residual);
            self.points.len() as f64 * ln(ratio) > REWEIGHTED.get()
        };
        // An exact one cannot gain.
        if even.residual > MOST_NOISE.get() * edge || !is_gain(0.0) {
            return Some(even);
        }
        let mut reweighted: Option<Self> = None;
        for _ in 0..REWEIGHTINGS.get() {
            let last = reweighted.as_ref().unwrap_or(&even);
            let slope = |p: DVec3| last.gradient(p).length().clamp(SLOPE[0], SLOPE[1]);
            let Some(next) = self.weighted_quadric(weight, slope) else {
                break;
            };
            reweighted = Some(next);
        }
        reweighted.filter(|r| is_gain(r.residual)).or(Some(even))
    }

    /// The quadric for given lengths of the gradient at the points, by which its values and gradients are divided.
    fn weighted_quadric(&self, weight: f64, slope: impl Fn(DVec3) -> f64) -> Option<Self> {
        let (mut matrix, mut terms) = self.normal_equations(weight, slope);
        solve_spd(&mut matrix, &mut terms).then_some(())?;
        let mut sheet = Self {
            terms,
            ..self.clone()
        };
        let squares = sheet.points.iter().map(|p| sheet.distance(*p).powi(2));
        sheet.residual = (squares.sum::<f64>() / self.points.len() as f64).sqrt();
        Some(sheet)
    }

    /// Normal equations of `f(x)/s = 0` and `∇f(x)/s = n` at the points, with the ridges: their matrix, of which only the lower triangle
    /// is set, and their right side.
    fn normal_equations(
        &self,
        weight: f64,
        slope: impl Fn(DVec3) -> f64,
    ) -> ([f64; TERMS * TERMS], [f64; TERMS]) {
        let mut matrix = [0.0; TERMS * TERMS];
        let mut right = [0.0; TERMS];
        let mut add = |row: [f64; TERMS], value: f64, weight: f64| {
            for i in 0..TERMS {
                let w = weight * row[i];
                if w != 0.0 {
                    (0..=i).for_each(|j| matrix[i * TERMS + j] += w * row[j]);
                    right[i] += w * value;
                }
            }
        };
        for (p, n) in self.points.iter().zip(&self.normals) {
            let (x, slope) = ((*p - self.origin) / self.scale, slope(*p));
            add(monomials(x).map(|m| m / slope), 0.0, 1.0);
            for (row, component) in gradients(x).into_iter().zip(n.to_array()) {
                add(row.map(|m| m / slope), component, weight * weight);
            }
        }
        for i in 0..TERMS {
            let ridge = if i < 6 { RIDGE * weight } else { LINEAR_RIDGE };
            matrix[i * TERMS + i] += ridge * ridge * self.points.len() as f64;
        }
        (matrix, right)
    }

    /// The part of its points' root mean square distance that is noise: what points do not have in common with their nearest neighbours.
    pub(super) fn noise(&self) -> f64 {
        let distances: Vec<f64> = self.points.iter().map(|p| self.distance(*p)).collect();
        let square = distances.iter().map(|d| d * d).sum::<f64>() / distances.len().max(1) as f64;
        let step = self.points.len().div_ceil(MOST_COMPARED.get()).max(1);
        let (mut products, mut squares) = (0.0, 0.0);
        for i in (0..self.points.len()).step_by(step) {
            let apart = |j: &usize| self.points[i].distance_squared(self.points[*j]);
            let mut others: Vec<usize> = (0..self.points.len()).filter(|&j| j != i).collect();
            // Of several: in a regular mesh the nearest one is the one that is as wrong.
            if others.len() >= NEIGHBOURS {
                others.select_nth_unstable_by(NEIGHBOURS - 1, |a, b| apart(a).total_cmp(&apart(b)));
                others.truncate(NEIGHBOURS);
                products += others
                    .iter()
                    .map(|&j| distances[i] * distances[j])
                    .sum::<f64>();
                squares += NEIGHBOURS as f64 * distances[i].powi(2);
            }
        }
        let common = (products / squares).clamp(0.0, 1.0);
        match squares > 0.0 {
            true => (square * (1.0 - common)).sqrt(),
            false => 0.0,
        }
    }

    /// Its standard deviations at some points, in their unit, if its data have independent errors as large as its residual: the residual
    /// times the square root of the leverage. `edge` is the edge length with which it was fitted.
    pub(super) fn deviations(&self, at: &[DVec3], edge: f64) -> Vec<f64> {
        let leverages = match self.is_plane() {
            true => self.leverages_of_plane(at),
            false => self.leverages_of_quadric(at, edge),
        };
        let deviation = |leverage: f64| self.residual * leverage.max(0.0).sqrt();
        leverages.into_iter().map(deviation).collect()
    }

    /// Variances of a least-squares plane at some points, for data of variance 1.
    fn leverages_of_plane(&self, at: &[DVec3]) -> Vec<f64> {
        let local = |p: &DVec3| (*p - self.origin) / self.scale;
        let (squares, axes) = symmetric_eigen(&second_moments(self.points.iter().map(local)));
        let leverage = |p: &DVec3| {
            let turned = (1..3).filter(|&k| squares[k] > 0.0);
            let turned = turned.map(|k| local(p).dot(axes[k]).powi(2) / squares[k]);
            1.0 / self.points.len().max(1) as f64 + turned.sum::<f64>()
        };
        at.iter().map(leverage).collect()
    }

    /// Variances of the distance of a least-squares quadric at some points, for data of variance 1.
    fn leverages_of_quadric(&self, at: &[DVec3], edge: f64) -> Vec<f64> {
        let slope = |p: DVec3| self.gradient(p).length().clamp(SLOPE[0], SLOPE[1]);
        let (matrix, _) = self.normal_equations(NORMAL_WEIGHT.get().min(edge / self.scale), slope);
        // It was positive definite when the quadric was fitted.
        let Some(factor) = Cholesky::new(&matrix, TERMS) else {
            return vec![1.0; at.len()];
        };
        let leverage = |p: &DVec3| {
            let row = monomials((*p - self.origin) / self.scale);
            let mut solved = row;
            factor.solve(&mut solved);
            dot(&row, &solved) / self.gradient(*p).length().max(1e-3).powi(2)
        };
        at.iter().map(leverage).collect()
    }

    /// Whether it is a plane.
    pub(super) fn is_plane(&self) -> bool {
        self.terms[..6].iter().all(|t| *t == 0.0)
    }

    /// Adds kriged residuals of some points, which are sorted from the hole outwards; returns whether there are any.
    pub(super) fn refine(&mut self, points: &[DVec3], diameter: f64, edge: f64) -> bool {
        let distances: Vec<f64> = points.iter().map(|p| self.distance(*p)).collect();
        self.residuals = Residuals::fit(points, &distances, diameter, edge);
        self.residuals.is_some()
    }

    /// First-order signed distance `f/|∇f|` (Taubin 1991), in the unit of the points.
    pub(super) fn distance(&self, point: DVec3) -> f64 {
        let x = (point - self.origin) / self.scale;
        let value = dot(&monomials(x), &self.terms);
        let distance = value * self.scale / self.gradient(point).length().max(1e-3);
        distance - self.residuals.as_ref().map_or(0.0, |r| r.at(point))
    }

    /// Gradient of f, in the sheet's scale.
    fn gradient(&self, point: DVec3) -> DVec3 {
        let x = (point - self.origin) / self.scale;
        DVec3::from(gradients(x).map(|row| dot(&row, &self.terms)))
    }

    /// Unit normal of the level set of f through a point.
    pub(super) fn normal(&self, point: DVec3) -> DVec3 {
        let normal = self.gradient(point).normalize_or_zero();
        match &self.residuals {
            Some(residuals) => (normal - residuals.gradient(point)).normalize_or_zero(),
            None => normal,
        }
    }
}

/// Singular values below this fraction of the largest count as zero: nearly coincident sheets have no usable intersection.
const SINGULAR: f64 = 1e-2;

/// Projects a point on the intersection of up to three sheets, by Gauss-Newton steps with the pseudo-inverse; a step is at most
/// `longest` long.
pub(super) fn onto(sheets: &[&Sheet], mut point: DVec3, steps: usize, longest: f64) -> DVec3 {
    for _ in 0..steps {
        let normals: Vec<DVec3> = sheets.iter().map(|s| s.normal(point)).collect();
        let values: Vec<f64> = sheets.iter().map(|s| s.distance(point)).collect();
        let mut gram = [[0.0; 3]; 3];
        for (i, a) in normals.iter().enumerate() {
            for (j, b) in normals.iter().enumerate() {
                gram[i][j] = a.dot(*b);
            }
        }
        let (squares, axes) = symmetric_eigen(&gram);
        let mut step = DVec3::ZERO;
        for (square, axis) in squares.iter().zip(axes) {
            if *square > SINGULAR * SINGULAR * squares[2] && *square > 0.0 {
                let along = axis.to_array();
                let sum = |all: &mut dyn Iterator<Item = f64>| all.sum::<f64>();
                let value = sum(&mut values.iter().zip(along).map(|(v, u)| v * u));
                let direction: DVec3 = normals.iter().zip(along).map(|(n, u)| *n * u).sum();
                step += direction * (value / square);
            }
        }
        point -= step.clamp_length_max(longest);
    }
    point
}

fn dot(a: &[f64; TERMS], b: &[f64; TERMS]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn monomials(x: DVec3) -> [f64; TERMS] {
    let [x, y, z] = x.to_array();
    [x * x, y * y, z * z, x * y, y * z, x * z, x, y, z, 1.0]
}

/// Derivatives of the monomials with respect to x, y and z.
fn gradients(x: DVec3) -> [[f64; TERMS]; 3] {
    let [x, y, z] = x.to_array();
    [
        [2.0 * x, 0.0, 0.0, y, 0.0, z, 1.0, 0.0, 0.0, 0.0],
        [0.0, 2.0 * y, 0.0, x, z, 0.0, 0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 2.0 * z, 0.0, y, x, 0.0, 0.0, 1.0, 0.0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    type Height = dyn Fn(f64, f64) -> f64;
    type Normal = dyn Fn(f64, f64) -> DVec3;

    /// A sheet of points with equal spacing on x, y ∈ [−1, 1] without the middle, at heights of a function.
    fn fitted(height: impl Fn(f64, f64) -> f64, normal: impl Fn(f64, f64) -> DVec3) -> Sheet {
        let grid =
            (0..21 * 21).map(|i| [f64::from(i % 21 - 10) / 10.0, f64::from(i / 21 - 10) / 10.0]);
        let around: Vec<[f64; 2]> = grid.filter(|[x, y]| x.hypot(*y) > 0.45).collect();
        let points = around.iter().map(|&[x, y]| DVec3::new(x, y, height(x, y)));
        let normals = around.iter().map(|&[x, y]| normal(x, y));
        Sheet::fit(points.collect(), normals.collect(), 1.0, 0.1)
    }

    /// Independent values of the standard deviation `size`.
    fn noise(size: f64, seed: u64) -> impl Fn(f64, f64) -> f64 {
        move |x, y| {
            let mut bits = x.to_bits()
                ^ y.to_bits().rotate_left(32)
                ^ seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            for factor in [
                0xbf58_476d_1ce4_e5b9u64,
                0x94d0_49bb_1331_11eb,
                0xbf58_476d_1ce4_e5b9,
            ] {
                bits = (bits ^ (bits >> 29)).wrapping_mul(factor);
            }
            size * 12f64.sqrt() * ((bits >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
        }
    }

    #[test]
    fn deviations_are_those_of_repeated_fits() {
        const FITS: u64 = 200;
        let places = [
            DVec3::ZERO,
            DVec3::new(0.9, 0.9, 0.0),
            DVec3::new(2.0, 0.0, 0.0),
        ];
        let flat = |_: f64, _: f64| 0.0;
        let bowl = |x: f64, y: f64| 0.25 * (x * x + 0.5 * y * y);
        let of_bowl = |x: f64, y: f64| DVec3::new(-0.5 * x, -0.25 * y, 1.0).normalize();
        let up = |_: f64, _: f64| DVec3::Z;
        let surfaces: [(&Height, &Normal); 2] = [(&flat, &up), (&bowl, &of_bowl)];
        for (surface, normal) in surfaces {
            let at = places.map(|p| p.with_z(surface(p.x, p.y)));
            let exact = fitted(surface, normal);
            let (mut squares, mut expected) = ([0.0; 3], [0.0; 3]);
            for seed in 0..FITS {
                let noise = noise(0.02, seed);
                let sheet = fitted(|x, y| surface(x, y) + noise(x, y), normal);
                assert_eq!(sheet.is_plane(), exact.is_plane());
                let deviations = sheet.deviations(&at, 0.1);
                for i in 0..3 {
                    squares[i] +=
                        (sheet.distance(at[i]) - exact.distance(at[i])).powi(2) / FITS as f64;
                    expected[i] += deviations[i] / FITS as f64;
                }
            }
            let ratios: Vec<f64> = (0..3).map(|i| expected[i] / squares[i].sqrt()).collect();
            assert!(ratios.iter().all(|r| (0.8..1.6).contains(r)), "{ratios:?}");
            assert!(expected[2] > 2.0 * expected[0]);
        }
    }

    #[test]
    fn what_neighbours_share_is_no_noise() {
        let up = |_: f64, _: f64| DVec3::Z;
        let rough = fitted(noise(0.02, 1), up);
        let share = rough.noise() / rough.residual;
        assert!((0.9..1.05).contains(&share), "{share}");
        let ripples = fitted(|x, y| 0.02 * (4.0 * x).sin() * (4.0 * y).cos(), up);
        assert!(
            ripples.noise() < 0.5 * ripples.residual,
            "{}",
            ripples.noise() / ripples.residual
        );
        assert_eq!(fitted(|_, _| 0.0, up).noise(), 0.0);
    }
}
