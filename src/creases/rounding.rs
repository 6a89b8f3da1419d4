//! Flat sides with rounded edges between them fitted to the mesh round a hole: the planes, then which of them and the radius.

use glam::DVec3;

use super::collar::{self, Collar, median};
use super::rounded::{Face, MOST_PLANES, OUTLIER, Place, Plane, Rounded};
use super::sheet::Sheet;
use crate::linalg::{second_moments, solve_spd, symmetric_eigen};
use crate::mesh::{Mesh, VertexFaces};

/// A plane starts from a face where smoothed normals within two rings differ by less than this, in 1 − cos,
const CALM: f64 = 0.02;
/// and a face joins it when its corners are nearer to it than this, in edges, and its smoothed normal is within this angle of the plane's, in degrees.
const NEAR: f64 = 0.1;
const TURNED: f64 = 6.0;
/// Rounds in which it grows and is fitted again.
const ROUNDS: usize = 6;
/// Faces of the smallest plane.
const FEWEST: usize = 20;
/// Its points count that are nearer than this many medians of their distances, of which this is the least, in edges.
const EXACT_PLANE: f64 = 0.01;
/// Points of narrower strips, such as run along a rounding, are no plane: their second standard deviation, in edges.
const NARROWEST: f64 = 0.8;
/// Planes whose normals have a larger cosine than this are one.
const SAME: f64 = 0.99;
/// Planes are looked for in as many rings of faces as the hole's diameter has edges, between these bounds.
const RINGS: [f64; 2] = [10.0, 24.0];
/// Points of the collar by which a model is judged; more are not needed to determine one radius.
const SAMPLES: usize = 300;
/// The radii tried first: the smallest in edges, the largest in diameters of the hole, and their number.
const RADII: (f64, f64, usize) = (0.5, 1.5, 12);
/// Steps of the golden-section search between two of them.
const GOLDEN: usize = 16;
/// Where a golden section cuts.
const PART: f64 = 0.381_966;

/// Planes of a model cover at least this part of the faces; on 135 holes of solids models that held had 0.35, on 361 of scans nearly all had
/// less than 0.2.
const COVERED: f64 = 0.18;
/// The search for planes ends after this number of seeds, unless the planes cover the second part of the faces.
const PATIENCE: usize = 12;
const EARLY: f64 = 0.08;
/// Points of a plane count that are nearer than this multiple of their median distance.
const TRIM: f64 = 4.0;
/// Cauchy's weight is a half at this multiple of the points' median distance, but at no less than the second of these, in edges.
const SPREAD: f64 = 2.0;
const EXACT: f64 = 0.002;
/// What is added to the diagonal, in parts of it.
const DAMPING: f64 = 1e-3;
/// Upper bound of the turn of a plane in a step, in radians.
const MOST_TILT: f64 = 0.2;
/// Unknowns of the largest model: three of each plane, and the radius.
const MOST_UNKNOWNS: usize = 3 * MOST_PLANES + 1;
/// Steps of the refinement while planes are chosen, and at the end.
const FIRST_STEPS: usize = 5;
const STEPS: usize = 20;

/// The part of a mesh round a hole to which models are fitted.
struct Data {
    collar: Collar,
    /// Points of all of it, to which planes are fitted.
    all: Vec<DVec3>,
    /// Points of the rings next to the hole, on which a model must hold.
    near: Vec<DVec3>,
}

impl Data {
    /// Sum of squared distances of the near points from a model; outliers count as no farther than [`OUTLIER`].
    fn sum(&self, model: &Rounded) -> f64 {
        let outlier = OUTLIER * self.collar.edge;
        let square = |p: &DVec3| model.at(*p).distance.abs().min(outlier).powi(2);
        self.near.iter().map(square).sum()
    }

    /// A model with its residual.
    fn measured(&self, mut model: Rounded) -> Rounded {
        let mean = self.sum(&model) / self.near.len().max(1) as f64;
        model.residual = mean.sqrt() / self.collar.edge;
        model
    }

    /// The model with the radius between two at which the sum is least, by golden sections.
    fn between(&self, mut model: Rounded, [mut low, mut high]: [f64; 2]) -> Rounded {
        let mut at = |radius: f64| {
            model.radius = radius;
            self.sum(&model)
        };
        for _ in 0..GOLDEN {
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

    /// The model of some planes with the best of all radii.
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
        let step = |i: usize| least * (most / least).powf(i as f64 / (RADII.2 - 1) as f64);
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

    /// A model with planes and radius of least squares, by Gauss-Newton steps with Cauchy's weights.
    fn refined(&self, mut model: Rounded, steps: usize) -> Rounded {
        let edge = self.collar.edge;
        for _ in 0..steps {
            let mut off: Vec<f64> = self
                .near
                .iter()
                .map(|p| model.at(*p).distance.abs())
                .collect();
            let width = (SPREAD * median(&mut off)).clamp(EXACT * edge, OUTLIER * edge);
            let unknowns = 3 * model.planes.len() + 1;
            let mut matrix = vec![0.0; unknowns * unknowns];
            let mut step = vec![0.0; unknowns];
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

    /// The best model: the plane that makes it better most is added, for as long as one does.
    fn best(&self) -> Option<Rounded> {
        // The information criterion: each plane has three coefficients.
        let count = self.near.len() as f64;
        let cost = |m: &Rounded| {
            count * (m.residual.powi(2) + 1e-8).ln() + 3.0 * m.planes.len() as f64 * count.ln()
        };
        let planes = planes(&self.collar);
        let covered: usize = planes.iter().map(|p| p.faces).sum();
        if (covered as f64) < COVERED * self.collar.len() as f64 {
            return None;
        }
        let mut chosen = vec![0];
        let mut best: Option<Rounded> = None;
        loop {
            let others = (0..planes.len()).filter(|i| !chosen.contains(i));
            let with = others.filter_map(|i| {
                let all = [&chosen[..], &[i]].concat();
                let planes: Vec<Plane> = all.iter().map(|&i| planes[i]).collect();
                let sign = bend(&planes)?;
                Some((self.refined(self.fit(planes, sign), FIRST_STEPS), all))
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
    /// Two or more flat sides with rounded edges between them; none where the mesh round a hole does not consist of these.
    pub(crate) fn find(mesh: &Mesh, around: &VertexFaces, rim: &[u32]) -> Option<Self> {
        let rings = |across: f64| across.clamp(RINGS[0], RINGS[1]) as u32;
        let collar = Collar::new(mesh, around, rim, rings)?;
        let near = collar::rings(collar.diameter / collar.rim_edge);
        let data = Data {
            all: collar.samples(SAMPLES, u32::MAX),
            near: collar.samples(SAMPLES, near),
            collar,
        };
        let model = data.refined(data.best()?, STEPS);
        model.holds(&data.near, data.collar.edge)
    }
}

impl Plane {
    /// Two unit vectors in it.
    fn axes(&self) -> [DVec3; 2] {
        let x = self.normal.any_orthonormal_vector();
        [x, self.normal.cross(x)]
    }
}

/// The derivatives of the distance of a point: by the tilts of each plane about its axes, whose unit turns it by 1 / `scale`, by its shift, and by
/// the radius.
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

/// Adds a row of weighted least squares to the lower triangle of its normal equations.
fn add_row(matrix: &mut [f64], right: &mut [f64], row: &[f64], (weight, value): (f64, f64)) {
    let count = row.len();
    for i in (0..count).filter(|&i| row[i] != 0.0) {
        let w = weight * row[i];
        (0..=i).for_each(|j| matrix[i * count + j] += w * row[j]);
        right[i] += w * value;
    }
}

/// A model after a step of its unknowns.
fn moved(model: Rounded, step: &[f64], axes: &[[DVec3; 2]], scale: f64) -> Rounded {
    let mut planes = model.planes.clone();
    for (i, plane) in planes.iter_mut().enumerate() {
        let tilt = axes[i][0] * step[3 * i] + axes[i][1] * step[3 * i + 1];
        plane.normal = (plane.normal + (tilt / scale).clamp_length_max(MOST_TILT)).normalize();
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

/// 1 where each plane's faces lie below all others, −1 where they lie above; none where neither.
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
    let (mut tries, mut taken) = (0, 0);
    for &first in &order {
        if variation[first] > CALM {
            break;
        }
        if is_taken[first] || !is_seed[first] {
            continue;
        }
        // Where the calmest faces lie in no planes, there are none.
        if tries >= PATIENCE && (taken as f64) < EARLY * collar.len() as f64 {
            return Vec::new();
        }
        tries += 1;
        // What was no plane from one of its faces is none from the others.
        let (plane, faces) = grown(collar, first, &is_taken);
        faces.iter().for_each(|&f| is_seed[f] = false);
        let Some(plane) = plane else {
            continue;
        };
        faces.iter().for_each(|&f| is_taken[f] = true);
        taken += faces.len();
        let is_same = |p: &Plane| {
            p.normal.dot(plane.normal) > SAME && p.distance(plane.middle).abs() < collar.edge
        };
        match planes.iter_mut().find(|p| is_same(p)) {
            Some(same) if same.faces >= plane.faces => same.faces += plane.faces,
            Some(same) => *same = plane,
            None => planes.push(plane),
        }
    }
    planes.sort_by_key(|p| std::cmp::Reverse(p.faces));
    planes.truncate(MOST_PLANES);
    planes
}

/// The plane that grows from a face, none where it stays too small, and its faces.
fn grown(collar: &Collar, first: usize, is_taken: &[bool]) -> (Option<Plane>, Vec<usize>) {
    let mut normal = collar.smoothed[first];
    let mut offset = normal.dot(collar.middle(first));
    let mut faces = Vec::new();
    let mut near = NEAR * collar.edge;
    for round in 0..ROUNDS {
        let fits = |f: usize| {
            let off = collar.corners(f).map(|p| (normal.dot(p) - offset).abs());
            !is_taken[f]
                && off.iter().all(|d| *d < near)
                && collar.smoothed[f].dot(normal) > TURNED.to_radians().cos()
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
        // What of a rounding comes along at first is left out once the noise of the plane is known.
        if round >= ROUNDS / 2 {
            let mut off: Vec<f64> = sheet
                .points
                .iter()
                .map(|p| sheet.distance(*p).abs())
                .collect();
            near = (TRIM * median(&mut off)).clamp(EXACT_PLANE * collar.edge, near);
        }
    }
    let middle = faces.iter().map(|&f| collar.middle(f)).sum::<DVec3>() / faces.len() as f64;
    let plane = Plane {
        normal,
        offset,
        middle,
        faces: faces.len(),
    };
    let (points, normals) = collar.vertices(&faces);
    let is_wide = width(&points) > NARROWEST * collar.edge
        && Sheet::fit(points, normals, collar.diameter, collar.edge).is_plane();
    ((faces.len() >= FEWEST && is_wide).then_some(plane), faces)
}

/// The second of the standard deviations of some points along their principal axes.
fn width(points: &[DVec3]) -> f64 {
    let count = points.len().max(1) as f64;
    let middle = points.iter().sum::<DVec3>() / count;
    let moments = second_moments(points.iter().map(|p| *p - middle));
    (symmetric_eigen(&moments).0[1].max(0.0) / count).sqrt()
}

/// Faces from neighbour to neighbour for which a condition holds; the first is among them in any case.
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
