//! Model of flat sides with rounded edges and corners between them: the surface of a ball that rolls along two or three planes.

use crate::tuning::{Tunable, tunable};
use glam::{DMat3, DVec3};

/// Maximum number of planes of a model.
pub(super) const MOST_PLANES: usize = 6;
/// Points farther than this from the surface, in edges, are outliers.
pub(super) const OUTLIER: Tunable<f64> = tunable("creases.rounded.outlier", 0.3);
/// A model is accepted if at least this fraction of the points are not outliers,
const MOST: Tunable<f64> = tunable("creases.rounded.most", 0.9);
/// their residual is at most this, in edges,
const RESIDUAL: Tunable<f64> = tunable("creases.rounded.residual", 0.1);
/// and at least this fraction of the points are on rounded edges or corners.
const FEWEST_ROUNDED: Tunable<f64> = tunable("creases.rounded.fewest_rounded", 0.04);
/// Normals whose Gram matrix has a determinant below this are linearly dependent.
const DEPENDENT: f64 = 1e-3;
/// Steps that project a point on the surface.
const STEPS: Tunable<usize> = tunable("creases.rounded.steps", 4);

/// The intersection or the union of half-spaces, with rounded edges and corners. Positions are relative to the middle of the rim.
#[derive(Clone, Debug)]
pub(crate) struct Rounded {
    pub(super) origin: DVec3,
    pub(super) planes: Vec<Plane>,
    pub(super) faces: Vec<Face>,
    /// 1 if the solid is the intersection of the half-spaces, −1 if it is their union.
    pub(super) sign: f64,
    /// Radius of the rounding.
    pub(crate) radius: f64,
    /// Root mean square distance of the mesh around the hole from the model, in edges.
    pub(crate) residual: f64,
}

/// A plane `normal · x = offset` with an outward unit normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub(super) normal: DVec3,
    pub(super) offset: f64,
    /// Centroid of its faces.
    pub(super) middle: DVec3,
    /// Number of its faces.
    pub(super) faces: usize,
}

impl Plane {
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

impl Rounded {
    /// The model, if nearly all points are on it and some of them are on rounded edges; otherwise the radius would not be
    /// determined.
    pub(super) fn holds(mut self, points: &[DVec3], edge: f64) -> Option<Self> {
        let places = points.iter().map(|p| self.at(*p));
        let near = places.filter(|place| place.distance.abs() < OUTLIER.get() * edge);
        let near: Vec<(f64, bool)> = near
            .map(|place| (place.distance / edge, place.face.planes.len() > 1))
            .collect();
        let squares: f64 = near.iter().map(|(off, _)| off * off).sum();
        let rounded = near.iter().filter(|(_, is_rounded)| *is_rounded).count();
        let residual = (squares / near.len().max(1) as f64).sqrt();
        let holds = near.len() as f64 >= MOST.get() * points.len() as f64
            && rounded as f64 >= FEWEST_ROUNDED.get() * points.len() as f64
            && residual < RESIDUAL.get();
        self.residual = residual;
        holds.then_some(self)
    }

    /// The signed distance of a point, and the element from which it is measured.
    pub(super) fn at(&self, p: DVec3) -> Place<'_> {
        // The core solid is at least `radius` below all planes; the rounded surface is at distance `radius` from the core.
        let mut depths = [0.0; MOST_PLANES];
        for (depth, plane) in depths.iter_mut().zip(&self.planes) {
            *depth = self.sign * plane.distance(p) + self.radius;
        }
        let depths = &depths[..self.planes.len()];
        let highest = (0..depths.len()).max_by(|a, b| depths[*a].total_cmp(&depths[*b]));
        let highest = highest.unwrap_or(0);
        let alone = Place {
            distance: self.sign * (depths[highest] - self.radius),
            normal: self.planes[highest].normal,
            face: &self.faces[highest],
            factors: DVec3::X,
            nearest: p - self.sign * self.planes[highest].normal * depths[highest],
        };
        if depths[highest] <= 0.0 {
            return alone;
        }
        // The unique projection on the core is the one that satisfies the Karush-Kuhn-Tucker conditions; elements with fewer
        // planes come first.
        let on = self.faces.iter().find_map(|face| {
            let (away, factors) = face.away(depths)?;
            self.is_below(away, depths).then_some((face, away, factors))
        });
        let Some((face, away, factors)) = on else {
            return alone;
        };
        let length = away.length();
        if length <= 0.0 {
            return alone;
        }
        Place {
            distance: self.sign * (length - self.radius),
            normal: self.sign * away / length,
            face,
            factors: factors / length,
            nearest: p - away,
        }
    }

    /// Whether a point with these depths is below all planes after moving back by `step`.
    fn is_below(&self, step: DVec3, depths: &[f64]) -> bool {
        let mut all = self.planes.iter().zip(depths);
        all.all(|(plane, depth)| depth - self.sign * plane.normal.dot(step) <= 1e-9 * self.radius)
    }

    /// The point of the surface closest to `point`.
    pub(crate) fn onto(&self, point: DVec3) -> DVec3 {
        let mut p = point - self.origin;
        for _ in 0..STEPS.get() {
            let place = self.at(p);
            p -= place.normal * place.distance;
        }
        p + self.origin
    }
}

/// The result of a distance query.
pub(super) struct Place<'a> {
    pub(super) distance: f64,
    /// Gradient of the distance.
    pub(super) normal: DVec3,
    /// The plane, edge or corner of the core that is closest,
    pub(super) face: &'a Face,
    /// the derivatives of the distance with respect to the depths of its planes,
    pub(super) factors: DVec3,
    /// and its closest point, `radius` below the surface.
    pub(super) nearest: DVec3,
}

/// An element of the core: a plane, the edge of two planes or the corner of three, with the data to project on it.
#[derive(Clone, Debug)]
pub(super) struct Face {
    pub(super) planes: Vec<usize>,
    /// Normals that point out of the rounded solid.
    normals: Vec<DVec3>,
    /// Inverse of the Gram matrix of the normals.
    inverse: DMat3,
}

impl Face {
    /// All elements of at most three planes, except those with linearly dependent normals.
    pub(super) fn all(planes: &[Plane], sign: f64) -> Vec<Self> {
        let mut sets: Vec<Vec<usize>> = Vec::new();
        for i in 0..planes.len() {
            sets.push(vec![i]);
            for j in 0..i {
                sets.push(vec![j, i]);
                sets.extend((0..j).map(|k| vec![k, j, i]));
            }
        }
        sets.sort_by_key(Vec::len);
        let face = |set: Vec<usize>| {
            let normals: Vec<DVec3> = set.iter().map(|&i| sign * planes[i].normal).collect();
            let mut gram = DMat3::IDENTITY;
            for (i, a) in normals.iter().enumerate() {
                (0..normals.len()).for_each(|j| gram.col_mut(j)[i] = a.dot(normals[j]));
            }
            (gram.determinant() > DEPENDENT).then(|| Self {
                planes: set,
                normals,
                inverse: gram.inverse(),
            })
        };
        sets.into_iter().filter_map(face).collect()
    }

    /// The vector from the element to a point with these depths above its planes, and its coefficients in the normals; `None` if
    /// a coefficient is negative.
    fn away(&self, depths: &[f64]) -> Option<(DVec3, DVec3)> {
        let mut own = DVec3::ZERO;
        for (i, &plane) in self.planes.iter().enumerate() {
            own[i] = depths[plane];
        }
        let factors = self.inverse * own;
        let pairs = self.normals.iter().zip(factors.to_array());
        let is_push = factors.cmpge(DVec3::ZERO).all();
        is_push.then(|| (pairs.map(|(n, f)| *n * f).sum(), factors))
    }
}
