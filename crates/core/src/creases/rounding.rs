//! Fit of flat sides with rounded edges to the mesh around a hole: planes first, then their combination and the radius.

use glam::DVec3;

use super::collar::{self, Collar, median};
use super::rounded::{Face, MOST_PLANES, OUTLIER, Place, Plane, Rounded};
use super::sheet::Sheet;
use crate::cancel::Cancel;
use crate::elementary::{cos, ln, powf};
use crate::linalg::{second_moments, solve_spd, symmetric_eigen};
use crate::mesh::{Mesh, VertexFaces};
use crate::tuning::{Tunable, tunable};

/// A plane is seeded at a face where smoothed normals within two rings differ by less than this, in 1 − cos.
const CALM: Tunable<f64> = tunable("creases.rounding.calm", 0.02);
/// A face joins a plane if its corners are closer than this, in edges,
const NEAR: Tunable<f64> = tunable("creases.rounding.near", 0.1);
/// and its smoothed normal is within this angle of the plane's normal, in degrees.
const TURNED: Tunable<f64> = tunable("creases.rounding.turned", 6.0);
/// Rounds in which a plane grows and is refitted.
const ROUNDS: Tunable<usize> = tunable("creases.rounding.rounds", 6);
/// Minimum number of faces of a plane.
const FEWEST: Tunable<usize> = tunable("creases.rounding.fewest", 20);
/// Minimum, in edges, of the distance within which faces join a growing plane once its noise is known.
const EXACT_PLANE: Tunable<f64> = tunable("creases.rounding.exact_plane", 0.01);
/// Narrower strips, for example along a rounding, are not planes: minimum of the second standard deviation of a plane's points,
/// in edges.
const NARROWEST: Tunable<f64> = tunable("creases.rounding.narrowest", 0.8);
/// Planes whose normals have a larger cosine than this are the same.
const SAME: Tunable<f64> = tunable("creases.rounding.same", 0.99);
/// Planes are searched in as many rings of faces as the hole's diameter has edges, between these bounds.
const RINGS: [f64; 2] = [10.0, 24.0];
/// Number of points of the collar used to evaluate a model; more are not needed to determine one radius.
const SAMPLES: Tunable<usize> = tunable("creases.rounding.samples", 300);
/// Radii attempted first: the smallest in edges, the largest in diameters of the hole, and their number.
const RADII: (f64, f64, usize) = (0.5, 1.5, 12);
/// Steps of the golden-section search between two of these radii.
const GOLDEN: Tunable<usize> = tunable("creases.rounding.golden", 16);
/// The fraction at which a golden section cuts.
const PART: f64 = 0.381_966;

/// Minimum fraction of the faces that the planes of a model cover. On 135 holes of solids accepted models had at least 0.35; on
/// 361 holes of scans nearly all had less than 0.2.
const COVERED: Tunable<f64> = tunable("creases.rounding.covered", 0.18);
/// The search for planes ends after this number of seeds
const PATIENCE: Tunable<usize> = tunable("creases.rounding.patience", 12);
/// unless the planes cover at least this fraction of the faces.
const EARLY: Tunable<f64> = tunable("creases.rounding.early", 0.08);
/// A face joins a growing plane within this multiple of the median distance of its points, once its noise is known.
const TRIM: Tunable<f64> = tunable("creases.rounding.trim", 4.0);
/// Width of Cauchy's weight (distance at which it is ½), as a multiple of the median distance of the points;
const SPREAD: Tunable<f64> = tunable("creases.rounding.spread", 2.0);
/// and its minimum, in edges.
const EXACT: Tunable<f64> = tunable("creases.rounding.exact", 0.002);
/// Added to the diagonal of the normal equations, as a fraction of it.
const DAMPING: f64 = 1e-3;
/// Maximum tilt of a plane in a step, in radians.
const MOST_TILT: Tunable<f64> = tunable("creases.rounding.most_tilt", 0.2);
/// Unknowns of the largest model: three for each plane, and the radius.
const MOST_UNKNOWNS: usize = 3 * MOST_PLANES + 1;
/// Steps of the refinement while planes are selected.
const FIRST_STEPS: Tunable<usize> = tunable("creases.rounding.first_steps", 5);
/// Steps of the final refinement.
const STEPS: Tunable<usize> = tunable("creases.rounding.steps", 20);

/// The part of a mesh around a hole to which models are fitted.
struct Data {
    collar: Collar,
    /// Points of the whole collar, to which planes are fitted.
    all: Vec<DVec3>,
    /// Points of the rings next to the hole, on which a model must hold.
    near: Vec<DVec3>,
}

impl Data {
    /// Sum of squared distances of the near points from a model, each clamped to [`OUTLIER`].
    fn sum(&self, model: &Rounded) -> f64 {
        let outlier = OUTLIER.get() * self.collar.edge;
        let square = |p: &DVec3| model.at(*p).distance.abs().min(outlier).powi(2);
        self.near.iter().map(square).sum()
    }

    /// Sets the residual of a model.
    fn measured(&self, mut model: Rounded) -> Rounded {
        let mean = self.sum(&model) / self.near.len().max(1) as f64;
        model.residual = mean.sqrt() / self.collar.edge;
        model
    }

    /// The model with the radius between two values that minimises the sum, by golden-section search.
    fn between(&self, mut model: Rounded, [mut low, mut high]: [f64; 2]) -> Rounded {
        let mut at = |radius: f64| {
            model.radius = radius;
            self.sum(&model)
        };
        for _ in 0..GOLDEN.get() {
            let (a, b) = (low + PART * (high - low), high - PART * (high - low));
            if at(a) < at(b) {
                high = b;
            } else {
                low = a;
            }
        }
        model.radius = 0.5 * (low + high);
        self.measured(model)
    }

    /// The model of given planes with the best radius.
    fn fit(&self, planes: Vec<Plane>, sign: f64) -> Rounded {
        let collar = &self.collar;
        let mut model = Rounded {
            origin: collar.origin,
            faces: Face::all(&planes, sign),
            planes,
            sign,
            radius: 0.0,
            residual: 0.0,
        };
        let (least, most) = (RADII.0 * collar.edge, RADII.1 * collar.diameter);
        let step = |i: usize| least * powf(most / least, i as f64 / (RADII.2 - 1) as f64);
        let mut at = |i: usize| {
            model.radius = step(i);
            self.sum(&model)
        };
        let sums: Vec<f64> = (0..RADII.2).map(&mut at).collect();
        let best = (0..RADII.2).min_by(|a, b| sums[*a].total_cmp(&sums[*b]));
        let best = best.unwrap_or(0);
        let range = [
            step(best.saturating_sub(1)),
            step((best + 1).min(RADII.2 - 1)),
        ];
        self.between(model, range)
    }

    /// Refines planes and radius of a model in least squares, by Gauss-Newton steps with Cauchy's weights.
    fn refined(&self, mut model: Rounded, steps: usize) -> Rounded {
        let edge = self.collar.edge;
        for _ in 0..steps {
            if self.collar.cancel.is_cancelled() {
                break;
            }
            // The width of the weights follows the median distance.
            let mut off: Vec<f64> = self
                .near
                .iter()
                .map(|p| model.at(*p).distance.abs())
                .collect();
            let width =
                (SPREAD.get() * median(&mut off)).clamp(EXACT.get() * edge, OUTLIER.get() * edge);
            let unknowns = 3 * model.planes.len() + 1;
            let mut matrix = vec![0.0; unknowns * unknowns];
            let mut step = vec![0.0; unknowns];
            // Normal equations of a step.
            let axes: Vec<[DVec3; 2]> = model.planes.iter().map(|p| p.axes()).collect();
            for p in self.near.iter().chain(&self.all) {
                let place = model.at(*p);
                let weight = 1.0 / (1.0 + (place.distance / width).powi(2));
                let row = derivatives(&model, &place, &axes, self.collar.diameter);
                add_row(
                    &mut matrix,
                    &mut step,
                    &row[..unknowns],
                    (weight, -place.distance),
                );
            }
            (0..unknowns).for_each(|i| matrix[i * unknowns + i] *= 1.0 + DAMPING);
            (0..unknowns).for_each(|i| matrix[i * unknowns + i] += 1e-9);
            if !solve_spd(&mut matrix, &mut step) {
                break;
            }
            model = moved(model, &step, &axes, self.collar.diameter);
        }
        self.measured(model)
    }

    /// The best model, by forward selection: adds the plane that improves the model most, as long as one does.
    fn best(&self) -> Option<Rounded> {
        // The Bayesian information criterion; each plane has three coefficients.
        let count = self.near.len() as f64;
        let cost = |m: &Rounded| {
            count * ln(m.residual.powi(2) + 1e-8) + 3.0 * m.planes.len() as f64 * ln(count)
        };
        let planes = planes(&self.collar);
        let covered: usize = planes.iter().map(|p| p.faces).sum();
        if (covered as f64) < COVERED.get() * self.collar.len() as f64 {
            return None;
        }
        let mut chosen = vec![0];
        let mut best: Option<Rounded> = None;
        loop {
            if self.collar.cancel.is_cancelled() {
                return None;
            }
            let others = (0..planes.len()).filter(|i| !chosen.contains(i));
            let with = others.filter_map(|i| {
                let all = [&chosen[..], &[i]].concat();
                let planes: Vec<Plane> = all.iter().map(|&i| planes[i]).collect();
                let sign = bend(&planes)?;
                Some((self.refined(self.fit(planes, sign), FIRST_STEPS.get()), all))
            });
            match with.min_by(|a, b| cost(&a.0).total_cmp(&cost(&b.0))) {
                Some((next, all)) if best.as_ref().is_none_or(|b| cost(&next) < cost(b)) => {
                    chosen = all;
                    best = Some(next);
                }
                _ => return best,
            }
        }
    }
}

impl Rounded {
    /// Fits two or more flat sides with rounded edges between them; `None` if the mesh around the hole does not have that shape,
    /// or the token is set.
    pub(crate) fn find(
        mesh: &Mesh,
        around: &VertexFaces,
        rim: &[u32],
        cancel: &Cancel,
    ) -> Option<Self> {
        let rings = |across: f64| across.clamp(RINGS[0], RINGS[1]) as u32;
        let collar = Collar::new(mesh, around, rim, rings, cancel)?;
        let near = collar::rings(collar.diameter / collar.rim_edge);
        let data = Data {
            all: collar.samples(SAMPLES.get(), u32::MAX),
            near: collar.samples(SAMPLES.get(), near),
            collar,
        };
        let model = data.refined(data.best()?, STEPS.get());
        (!cancel.is_cancelled()).then_some(())?;
        model.holds(&data.near, data.collar.edge)
    }
}

impl Plane {
    /// Two orthogonal unit vectors in the plane.
    fn axes(&self) -> [DVec3; 2] {
        let x = self.normal.any_orthonormal_vector();
        [x, self.normal.cross(x)]
    }
}

/// The derivatives of a point's distance: with respect to the tilts of each plane about its axes (a unit tilts it by 1 /
/// `scale`), to its shift, and to the radius.
fn derivatives(
    model: &Rounded,
    place: &Place<'_>,
    axes: &[[DVec3; 2]],
    scale: f64,
) -> [f64; MOST_UNKNOWNS] {
    let mut row = [0.0; MOST_UNKNOWNS];
    let mut sum = 0.0;
    for (&i, factor) in place.face.planes.iter().zip(place.factors.to_array()) {
        let [x, y] = axes[i];
        row[3 * i] = factor * x.dot(place.nearest) / scale;
        row[3 * i + 1] = factor * y.dot(place.nearest) / scale;
        row[3 * i + 2] = -factor;
        sum += factor;
    }
    row[3 * axes.len()] = model.sign * (sum - 1.0);
    row
}

/// Adds a row of weighted least squares to the lower triangle of the normal equations.
fn add_row(matrix: &mut [f64], right: &mut [f64], row: &[f64], (weight, value): (f64, f64)) {
    let count = row.len();
    for i in (0..count).filter(|&i| row[i] != 0.0) {
        let w = weight * row[i];
        (0..=i).for_each(|j| matrix[i * count + j] += w * row[j]);
        right[i] += w * value;
    }
}

/// The model after a step of its unknowns.
fn moved(model: Rounded, step: &[f64], axes: &[[DVec3; 2]], scale: f64) -> Rounded {
    let mut planes = model.planes.clone();
    for (i, plane) in planes.iter_mut().enumerate() {
        let tilt = axes[i][0] * step[3 * i] + axes[i][1] * step[3 * i + 1];
        plane.normal =
            (plane.normal + (tilt / scale).clamp_length_max(MOST_TILT.get())).normalize();
        plane.offset += step[3 * i + 2];
    }
    let change = step[step.len() - 1].clamp(-0.3 * model.radius, 0.3 * model.radius);
    Rounded {
        faces: Face::all(&planes, model.sign),
        radius: model.radius + change,
        planes,
        ..model
    }
}

/// 1 if each plane's faces are below all other planes, −1 if they are above; otherwise `None`.
fn bend(planes: &[Plane]) -> Option<f64> {
    let pairs = (0..planes.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let mut above = pairs.flat_map(|(i, j)| {
        let (a, b) = (&planes[i], &planes[j]);
        [a.distance(b.middle) > 0.0, b.distance(a.middle) > 0.0]
    });
    let first = above.next()?;
    above
        .all(|other| other == first)
        .then_some(if first { -1.0 } else { 1.0 })
}

/// The planes of a collar with the most faces.
fn planes(collar: &Collar) -> Vec<Plane> {
    let variation = collar.variation();
    let mut order: Vec<usize> = (0..collar.len()).collect();
    order.sort_by(|a, b| variation[*a].total_cmp(&variation[*b]));
    let mut is_taken = vec![false; collar.len()];
    let mut is_seed = vec![true; collar.len()];
    let mut planes: Vec<Plane> = Vec::new();
    let (mut seeds, mut taken) = (0, 0);
    for &first in &order {
        if variation[first] > CALM.get() || collar.cancel.is_cancelled() {
            break;
        }
        if is_taken[first] || !is_seed[first] {
            continue;
        }
        // If the flattest faces are in no planes, there are none.
        if seeds >= PATIENCE.get() && (taken as f64) < EARLY.get() * collar.len() as f64 {
            return Vec::new();
        }
        seeds += 1;
        // If one face of a region gave no plane, the others will not either.
        let (plane, faces) = grown(collar, first, &is_taken);
        faces.iter().for_each(|&f| is_seed[f] = false);
        let Some(plane) = plane else {
            continue;
        };
        faces.iter().for_each(|&f| is_taken[f] = true);
        taken += faces.len();
        let is_same = |p: &Plane| {
            p.normal.dot(plane.normal) > SAME.get() && p.distance(plane.middle).abs() < collar.edge
        };
        match planes.iter_mut().find(|p| is_same(p)) {
            Some(same) if same.faces >= plane.faces => same.faces += plane.faces,
            Some(same) => *same = plane,
            None => planes.push(plane),
        }
    }
    // The largest planes.
    planes.sort_by_key(|p| std::cmp::Reverse(p.faces));
    planes.truncate(MOST_PLANES);
    planes
}

/// Grows a plane from a face; returns it (`None` if it stays too small) and its faces.
fn grown(collar: &Collar, first: usize, is_taken: &[bool]) -> (Option<Plane>, Vec<usize>) {
    let mut normal = collar.smoothed[first];
    let mut offset = normal.dot(collar.middle(first));
    let mut faces = Vec::new();
    let mut near = NEAR.get() * collar.edge;
    for round in 0..ROUNDS.get() {
        // Grow: connected faces close to the plane in position and normal. Then refit.
        let fits = |f: usize| {
            let off = collar.corners(f).map(|p| (normal.dot(p) - offset).abs());
            !is_taken[f]
                && off.iter().all(|d| *d < near)
                && collar.smoothed[f].dot(normal) > cos(TURNED.get().to_radians())
        };
        faces = flood(collar, first, fits);
        if faces.len() < 3 {
            return (None, faces);
        }
        faces.sort_unstable();
        let (points, normals) = collar.vertices(&faces);
        let sheet = Sheet::plane(points, normals, collar.diameter);
        normal = sheet.normal(DVec3::ZERO);
        offset = -sheet.distance(DVec3::ZERO);
        // Faces of a rounding may have joined at first; they are excluded once the noise of the plane is known.
        if round >= ROUNDS.get() / 2 {
            let mut off: Vec<f64> = sheet
                .points
                .iter()
                .map(|p| sheet.distance(*p).abs())
                .collect();
            near = (TRIM.get() * median(&mut off)).clamp(EXACT_PLANE.get() * collar.edge, near);
        }
    }
    // The result must be large and wide enough, and no quadric.
    let middle = faces.iter().map(|&f| collar.middle(f)).sum::<DVec3>() / faces.len() as f64;
    let plane = Plane {
        normal,
        offset,
        middle,
        faces: faces.len(),
    };
    let (points, normals) = collar.vertices(&faces);
    let is_wide = width(&points) > NARROWEST.get() * collar.edge
        && Sheet::fit(points, normals, collar.diameter, collar.edge).is_plane();
    (
        (faces.len() >= FEWEST.get() && is_wide).then_some(plane),
        faces,
    )
}

/// The second largest standard deviation of points along their principal axes.
fn width(points: &[DVec3]) -> f64 {
    let count = points.len().max(1) as f64;
    let middle = points.iter().sum::<DVec3>() / count;
    let moments = second_moments(points.iter().map(|p| *p - middle));
    (symmetric_eigen(&moments).0[1].max(0.0) / count).sqrt()
}

/// The connected faces for which `holds` is true, starting from `first`, which is always included.
fn flood(collar: &Collar, first: usize, holds: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut is_in = vec![false; collar.len()];
    let mut faces = vec![first];
    is_in[first] = true;
    let mut at = 0;
    while let Some(&f) = faces.get(at) {
        for g in collar.across(f) {
            if !is_in[g] && holds(g) {
                is_in[g] = true;
                faces.push(g);
            }
        }
        at += 1;
    }
    faces
}
