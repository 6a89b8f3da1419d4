//! Charts: a sphere or plane over which the neighbourhood of a hole is a graph.

use glam::{DMat3, DVec2, DVec3};

use super::geometry::{median, quantile, vertex_normals};
use super::patch::Patch;
use super::report::ChartKind;
use crate::elementary::atan2;
use crate::tuning::{Tunable, tunable};

/// Fraction of the normals. A chart is refused when more of them than this have a smaller cosine than
/// `CHART_COSINE`.
const CHART_OUTLIERS: Tunable<f64> = tunable("finish.chart_outliers", 0.02);

/// Least cosine between a normal and the direction of a chart: 75.5°.
const CHART_COSINE: Tunable<f64> = tunable("finish.chart_cosine", 0.25);

/// Rounds of the robust sphere fit.
const CHART_ROUNDS: Tunable<usize> = tunable("finish.chart_rounds", 3);

/// Medians of the residuals. Larger residuals are down-weighted: 1.5 standard deviations.
const CHART_ROBUST: Tunable<f64> = tunable("finish.chart_robust", 1.5 * 1.4826);

/// Diameters, root mean square. Points closer to a sphere than this lie on it.
const ON_SPHERE: Tunable<f64> = tunable("finish.on_sphere", 1e-6);

/// Diameters. Spheres with larger radius are treated as planes: rounding hides their curvature.
const FARTHEST_SPHERE: Tunable<f64> = tunable("finish.farthest_sphere", 100.0);

/// Diameters. Added to the median residual, which is zero on exact spheres.
const CHART_EXACT: Tunable<f64> = tunable("finish.chart_exact", 1e-12);

/// Plane coordinates and heights over a sphere or plane, in diameters of the hole.
pub(super) struct Chart {
    surface: ChartSurface,
    /// Columns: the directions of the first and second coordinate, and the direction of the chart's middle.
    frame: DMat3,
    /// The diameter of the hole.
    unit: f64,
}

enum ChartSurface {
    Plane { origin: DVec3 },
    Sphere { centre: DVec3, radius: f64 },
}

impl Chart {
    /// The chart for known vertices around a patch and the patch in the given shape: the sphere that fits best if its radius is
    /// below `largest` (in diameters), otherwise a plane. `None` if too many normals are steep over it.
    pub(super) fn new(
        patch: &Patch,
        shape: &[DVec3],
        data: &[u32],
        normals: &[DVec3],
        largest: f64,
    ) -> Option<Self> {
        // A vertex that has lost all of its faces, for example between notches of the rim, has no normal.
        let with_normal = |v: &u32| normals[*v as usize] != DVec3::ZERO;
        let data = data.iter().copied().filter(with_normal).map(|v| v as usize);
        let (points, normals): (Vec<DVec3>, Vec<DVec3>) =
            data.map(|i| (patch.points[i], normals[i])).unzip();
        // The patch must be a graph over the chart as well as the data, so its normals are tested too.
        let closure_points = patch.closure_points(shape);
        let own = vertex_normals(&closure_points, &patch.closure.faces);
        let own: Vec<DVec3> = patch.closure.moved(&own);
        let steep = |cosines: &mut dyn Iterator<Item = f64>| {
            // NaN counts as steep.
            let least = quantile(cosines, CHART_OUTLIERS.get());
            least.is_nan() || least <= CHART_COSINE.get()
        };
        // The sphere that fits positions and normals best; if the positions are exactly on a sphere, that sphere.
        let unit = patch.diameter;
        let (centre, radius) = fit_sphere(&points, &normals, unit);
        let (centre, radius) = through(&points, centre, radius, unit).unwrap_or((centre, radius));
        // The sphere is the chart if it is small enough and the data and the patch are not steep over it.
        if radius.abs() < largest * unit {
            let surface = ChartSurface::Sphere { centre, radius };
            let over = |p: &DVec3| surface.over(*p);
            let middle: DVec3 = points.iter().map(over).sum();
            let mut data = points.iter().zip(&normals).map(|(p, n)| n.dot(over(p)));
            let mut inner = shape.iter().zip(&own).map(|(p, n)| n.dot(over(p)));
            if !steep(&mut data) && !steep(&mut inner) {
                let frame = frame(middle.try_normalize()?);
                return Some(Self {
                    surface,
                    frame,
                    unit,
                });
            }
        }
        // Otherwise the plane perpendicular to the mean normal of the data, through the mean of the rim, if nothing is steep over
        // it.
        let normal = normals.iter().sum::<DVec3>().try_normalize()?;
        if steep(&mut normals.iter().map(|n| n.dot(normal)))
            || steep(&mut own.iter().map(|n| n.dot(normal)))
        {
            return None;
        }
        let rim = patch.rim_points();
        let origin = rim.iter().sum::<DVec3>() / rim.len() as f64;
        Some(Self {
            surface: ChartSurface::Plane { origin },
            frame: frame(normal),
            unit,
        })
    }

    /// The unit normal of the chart at the foot of a point.
    pub(super) fn normal(&self, point: DVec3) -> DVec3 {
        match self.surface {
            ChartSurface::Plane { .. } => self.frame.z_axis,
            ChartSurface::Sphere { .. } => self.surface.over(point),
        }
    }

    /// The kind of chart, for the report.
    pub(super) fn kind(&self) -> ChartKind {
        match self.surface {
            ChartSurface::Plane { .. } => ChartKind::Plane,
            ChartSurface::Sphere { radius, .. } => ChartKind::Sphere(radius / self.unit),
        }
    }

    /// The coordinates of a point's foot and its height. On the sphere: the azimuthal equidistant projection, which preserves
    /// distances from the middle.
    pub(super) fn coordinates(&self, point: DVec3) -> (DVec2, f64) {
        match self.surface {
            ChartSurface::Plane { origin } => {
                let v = self.frame.transpose() * (point - origin) / self.unit;
                (v.truncate(), v.z)
            }
            ChartSurface::Sphere { centre, radius } => {
                let v = self.frame.transpose() * self.surface.over(point);
                let sine = v.truncate().length();
                let stretch = if sine > 1e-9 {
                    atan2(sine, v.z) / sine
                } else {
                    1.0
                };
                let height = point.distance(centre) - radius.abs();
                (
                    v.truncate() * stretch * radius.abs() / self.unit,
                    height * radius.signum() / self.unit,
                )
            }
        }
    }

    /// The point with the given height over the foot of `point`.
    pub(super) fn lifted(&self, point: DVec3, height: f64) -> DVec3 {
        match self.surface {
            ChartSurface::Plane { .. } => {
                let now = self.coordinates(point).1;
                point + (height - now) * self.unit * self.frame.z_axis
            }
            ChartSurface::Sphere { centre, radius } => {
                centre + self.surface.over(point) * (radius + height * self.unit)
            }
        }
    }
}

impl ChartSurface {
    /// The unit normal of the chart's surface at the foot of a point.
    fn over(&self, point: DVec3) -> DVec3 {
        match *self {
            ChartSurface::Plane { .. } => DVec3::ZERO,
            ChartSurface::Sphere { centre, radius } => {
                (point - centre).normalize_or_zero() * radius.signum()
            }
        }
    }
}

/// Centre and radius of the sphere with `x ≈ c + R n` in least squares over positions and normals; the radius is negative where
/// the surface is hollow. Iteratively reweighted: rounds after the first reduce the weight of outliers.
fn fit_sphere(points: &[DVec3], normals: &[DVec3], unit: f64) -> (DVec3, f64) {
    let mut weights = vec![1.0; points.len()];
    let (mut centre, mut radius) = (DVec3::ZERO, f64::INFINITY);
    for _ in 0..CHART_ROUNDS.get() {
        let sum: f64 = weights.iter().sum();
        let mean = |values: &[DVec3]| {
            let weighted = values.iter().zip(&weights).map(|(v, w)| *v * *w);
            weighted.sum::<DVec3>() / sum
        };
        let (x, n) = (mean(points), mean(normals));
        let (mut both, mut squares) = (0.0, 0.0);
        for ((p, m), w) in points.iter().zip(normals).zip(&weights) {
            both += w * (*p - x).dot(*m - n);
            squares += w * (*m - n).length_squared();
        }
        radius = both / sum / (squares / sum).max(1e-12);
        centre = x - radius * n;
        let off = |(p, m): (&DVec3, &DVec3)| (*p - centre - radius * *m).length();
        let residuals: Vec<f64> = points.iter().zip(normals).map(off).collect();
        let scale =
            CHART_ROBUST.get() * (median(residuals.iter().copied()) + CHART_EXACT.get() * unit);
        let weight = |r: &f64| (scale / r.max(CHART_EXACT.get() * unit)).min(1.0);
        weights = residuals.iter().map(weight).collect();
    }
    (centre, radius)
}

/// Refines a sphere to the sphere through the points, if they are on one: minimises `Σ (|x − c| − |R|)²` by Gauss-Newton. The
/// first fit uses normals computed from flat faces, which are slightly tilted at a rim.
fn through(points: &[DVec3], centre: DVec3, radius: f64, unit: f64) -> Option<(DVec3, f64)> {
    let (mut centre, mut size) = (centre, radius.abs());
    if !size.is_finite() || size >= FARTHEST_SPHERE.get() * unit {
        return None;
    }
    let count = points.len() as f64;
    for _ in 0..CHART_ROUNDS.get() {
        // The radius is the mean distance from the centre, so deviations from the mean direction enter the system.
        let directions = points.iter().map(|p| (*p - centre).normalize_or_zero());
        let directions: Vec<DVec3> = directions.collect();
        let distances = points.iter().map(|p| p.distance(centre));
        let distances: Vec<f64> = distances.collect();
        let mean = directions.iter().sum::<DVec3>() / count;
        size = distances.iter().sum::<f64>() / count;
        let (mut matrix, mut rhs) = (DMat3::ZERO, DVec3::ZERO);
        for (n, d) in directions.iter().zip(&distances) {
            let n = *n - mean;
            matrix += DMat3::from_cols(n * n.x, n * n.y, n * n.z);
            rhs += n * (d - size);
        }
        let step = matrix.inverse() * rhs;
        if !step.is_finite() {
            return None;
        }
        centre += step;
        size += mean.dot(-step);
    }
    let off = |p: &DVec3| (p.distance(centre) - size).powi(2);
    let error = (points.iter().map(off).sum::<f64>() / count).sqrt();
    (error < ON_SPHERE.get() * unit).then(|| (centre, size.copysign(radius)))
}

/// An orthonormal frame: two directions across a unit vector, and the vector.
fn frame(normal: DVec3) -> DMat3 {
    let axis = if normal.x.abs() < 0.8 {
        DVec3::X
    } else {
        DVec3::Y
    };
    let first = normal.cross(axis).normalize_or_zero();
    DMat3::from_cols(first, normal.cross(first), normal)
}

#[cfg(test)]
mod tests {
    use super::super::patch::Located;
    use super::super::tests::{surroundings, with_patch};
    use super::*;
    use crate::mesh::shapes::icosphere;

    /// A band of points on a sphere, below a missing cap.
    fn band() -> Vec<DVec3> {
        let ring = |z: f64| {
            let turn = (0..40).map(|k| f64::from(k) * std::f64::consts::TAU / 40.0);
            turn.map(move |a| {
                let wide = (1.0 - z * z).sqrt();
                DVec3::new(wide * a.cos(), wide * a.sin(), z)
            })
        };
        [0.2, 0.1, 0.0, -0.1].into_iter().flat_map(ring).collect()
    }

    #[test]
    fn normals_that_are_tilted_at_the_rim_do_not_spoil_a_sphere() {
        let middle = DVec3::new(3.0, -1.0, 2.0);
        let directions = band();
        let points: Vec<DVec3> = directions.iter().map(|d| middle - 2.0 * *d).collect();
        let tilted = |d: &DVec3| (*d + DVec3::Z * 0.1 * d.z.max(0.0)).normalize();
        let normals: Vec<DVec3> = directions.iter().map(tilted).collect();
        let (centre, radius) = fit_sphere(&points, &normals, 4.0);
        assert!(radius < 0.0 && (radius + 2.0).abs() > 1e-4, "{radius}");
        let (centre, radius) = through(&points, centre, radius, 4.0).expect("a sphere");
        assert!((radius + 2.0).abs() < 1e-9, "{radius}");
        assert!(centre.distance(middle) < 1e-9, "{centre}");
    }

    #[test]
    fn points_beside_a_sphere_and_flat_ones_keep_the_fit_with_normals() {
        let oval: Vec<DVec3> = band()
            .iter()
            .map(|d| *d * DVec3::new(1.0, 1.01, 1.0))
            .collect();
        assert!(through(&oval, DVec3::ZERO, 1.0, 2.0).is_none());
        assert!(through(&band(), DVec3::ZERO, f64::INFINITY, 2.0).is_none());
        let flat: Vec<DVec3> = band().iter().map(|d| d.with_z(0.0)).collect();
        assert!(through(&flat, DVec3::Z * -1e6, 1e6, 2.0).is_none());
    }

    #[test]
    fn vertices_that_have_lost_all_faces_do_not_refuse_a_chart() {
        let (mesh, patch) = with_patch(icosphere(4), |p| p.z > 0.6, |_, _| DVec3::ZERO);
        let around = surroundings(&mesh, &patch);
        let located = Located::new(&around, &patch).expect("a patch");
        let known = located.patch.known.iter().zip(0u32..);
        let data: Vec<u32> = known.filter(|(k, _)| **k).map(|(_, v)| v).collect();
        let mut normals = located.patch.known_normals();
        for &v in data.iter().step_by(10) {
            normals[v as usize] = DVec3::ZERO;
        }
        let chart = Chart::new(&located.patch, &located.patch.shape(), &data, &normals, 4.0);
        let Some(ChartKind::Sphere(radius)) = chart.map(|c| c.kind()) else {
            panic!("no sphere");
        };
        assert!((radius * located.scale - 1.0).abs() < 1e-6, "{radius}");
    }
}
