//! Flat sides with rounded edges and corners between them: the surface on which a ball rolls along two or three sides.

use glam::{DMat3, DVec3};

/// Most planes of a model.
pub(super) const MOST_PLANES: usize = 6;
/// Points farther off than this, in edges, are no part of the surface.
pub(super) const OUTLIER: f64 = 0.3;
/// A model holds when this part of the points lies nearer,
const MOST: f64 = 0.9;
/// these have at most this residual, in edges,
const RESIDUAL: f64 = 0.1;
/// and this part of the points lies on edges or corners that are rounded.
const FEWEST_ROUNDED: f64 = 0.04;
/// Normals whose products have a smaller determinant than this depend on each other.
const DEPENDENT: f64 = 1e-3;
/// Steps that bring a point to the surface.
const STEPS: usize = 4;

/// Half-spaces with what they share rounded, or with what they cover rounded. Positions are relative to the middle of the rim.
#[derive(Clone, Debug)]
pub(crate) struct Rounded {
    pub(super) origin: DVec3,
    pub(super) planes: Vec<Plane>,
    pub(super) faces: Vec<Face>,
    /// 1 where the solid is what the half-spaces share, −1 where it is what any of them covers.
    pub(super) sign: f64,
    /// Radius of the rounding.
    pub(crate) radius: f64,
    /// Root mean square distance of the mesh round the hole from it, in edges.
    pub(crate) residual: f64,
}

/// A plane `normal · x = offset`, with its unit normal outwards.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub(super) normal: DVec3,
    pub(super) offset: f64,
    /// Middle of its faces, and their number.
    pub(super) middle: DVec3,
    pub(super) faces: usize,
}

impl Plane {
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

impl Rounded {
    /// The model, if nearly all of some points lie on it, and some of them on what is rounded: else the radius is not determined.
    pub(super) fn holds(mut self, points: &[DVec3], edge: f64) -> Option<Self> {
        let places = points.iter().map(|p| self.at(*p));
        let near = places.filter(|place| place.distance.abs() < OUTLIER * edge);
        let near: Vec<(f64, bool)> = near
            .map(|place| (place.distance / edge, place.face.planes.len() > 1))
            .collect();
        let squares: f64 = near.iter().map(|(off, _)| off * off).sum();
        let rounded = near.iter().filter(|(_, is_rounded)| *is_rounded).count();
        let residual = (squares / near.len().max(1) as f64).sqrt();
        let holds = near.len() as f64 >= MOST * points.len() as f64
            && rounded as f64 >= FEWEST_ROUNDED * points.len() as f64
            && residual < RESIDUAL;
        self.residual = residual;
        holds.then_some(self)
    }

    /// Signed distance of a point, and what it is the distance from.
    pub(super) fn at(&self, p: DVec3) -> Place<'_> {
        // What lies `radius` and more below all planes; the distance from it less the radius is the rounded one.
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
        // The projection with the fewest planes that satisfies the conditions of Karush, Kuhn and Tucker is the only one.
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

    /// Whether a point lies below all planes after a step back.
    fn is_below(&self, step: DVec3, depths: &[f64]) -> bool {
        let mut all = self.planes.iter().zip(depths);
        all.all(|(plane, depth)| depth - self.sign * plane.normal.dot(step) <= 1e-9 * self.radius)
    }

    /// The nearest point of the surface to one.
    pub(crate) fn onto(&self, point: DVec3) -> DVec3 {
        let mut p = point - self.origin;
        for _ in 0..STEPS {
            let place = self.at(p);
            p -= place.normal * place.distance;
        }
        p + self.origin
    }
}

/// Where a point is.
pub(super) struct Place<'a> {
    pub(super) distance: f64,
    /// Gradient of the distance.
    pub(super) normal: DVec3,
    /// The plane, the edge or the corner that is rounded there,
    pub(super) face: &'a Face,
    /// the derivatives of the distance from it by the depths below its planes,
    pub(super) factors: DVec3,
    /// and its nearest point, `radius` below the surface.
    pub(super) nearest: DVec3,
}

/// A plane, the edge of two or the corner of three: what is needed to project onto it.
#[derive(Clone, Debug)]
pub(super) struct Face {
    pub(super) planes: Vec<usize>,
    /// Normals outwards of the solid that is rounded.
    normals: Vec<DVec3>,
    /// Inverse of the normals' products.
    inverse: DMat3,
}

impl Face {
    /// All with at most three planes; those of planes that depend on each other are left out.
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

    /// The vector from it to a point above each of its planes by these depths, and how much of each normal is in it; none where that is
    /// negative.
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
