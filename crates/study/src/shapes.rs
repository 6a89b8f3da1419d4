//! Test surfaces with exact signed distances, for the fill of an unknown ball.
//!
//! Every surface passes through the origin, the centre of the unknown ball of radius 1. In the shape's own frame, z is the outward
//! normal at the origin. The frame is rotated so that it is aligned with no lattice.

use glam::DVec3;

use isomend_core::region::{DistanceData, NodeData};

/// An exact signed distance, negative inside, in world units.
type Distance = Box<dyn Fn(DVec3) -> f64 + Sync + Send>;

/// A surface with an exact signed distance, part of which is unknown.
pub struct ExactShape {
    /// Its name.
    pub name: &'static str,
    /// Whether it is a critical point of the Willmore energy, so that the fill converges to it.
    pub critical: bool,
    distance: Distance,
}

/// Radius of the unknown ball.
pub const UNKNOWN_RADIUS: f64 = 1.0;

impl ExactShape {
    fn new(
        name: &'static str,
        critical: bool,
        distance: impl Fn(DVec3) -> f64 + Sync + Send + 'static,
    ) -> Self {
        Self {
            name,
            critical,
            distance: Box::new(distance),
        }
    }

    /// The exact signed distance.
    pub fn distance(&self, x: DVec3) -> f64 {
        (self.distance)(to_frame(x))
    }

    /// The unit normal of the level set through `x`, by central differences of the distance.
    pub fn normal(&self, x: DVec3) -> DVec3 {
        let e = 1e-5;
        let slope = |axis: DVec3| self.distance(x + e * axis) - self.distance(x - e * axis);
        DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize()
    }

    /// A plane.
    pub fn plane() -> Self {
        Self::new("plane", true, |p| p.z)
    }

    /// A sphere from which the unknown ball cuts a cap of the given opening angle.
    pub fn sphere_cap(name: &'static str, degrees: f64) -> Self {
        let r = UNKNOWN_RADIUS / (2.0 * (0.5 * degrees.to_radians()).sin());
        Self::new(name, true, move |p| (p + DVec3::Z * r).length() - r)
    }

    /// The Clifford torus, with the unknown ball on its outer or inner equator; the ball's radius is `part` times the tube's.
    pub fn clifford_torus(name: &'static str, part: f64, outer: bool) -> Self {
        let r = UNKNOWN_RADIUS / part;
        let big = r * 2f64.sqrt();
        let side = if outer { 1.0 } else { -1.0 };
        Self::new(name, true, move |p| {
            let a = big + side * r + side * p.z;
            (a.hypot(p.x) - big).hypot(p.y) - r
        })
    }

    /// A catenoid whose neck has the radius of the unknown ball; the ball is on the neck.
    pub fn catenoid() -> Self {
        Self::new("catenoid neck", true, catenoid)
    }

    /// A Dupin cyclide that is a Möbius image of the Clifford torus; the unknown ball is on the outside of its thick part.
    pub fn cyclide() -> Self {
        // d is the mean radius of the tube, c half the difference of its extreme radii; a² + c² = 2 d² makes the surface critical.
        let d: f64 = UNKNOWN_RADIUS / 1.1;
        let c = 0.35 * d;
        let a = (2.0 * d * d - c * c).sqrt();
        Self::new("Dupin cyclide", true, move |p| cyclide(p, a, c, d))
    }

    /// A cylinder with the radius of the unknown ball.
    pub fn cylinder() -> Self {
        let r = UNKNOWN_RADIUS;
        Self::new("cylinder", false, move |p| p.x.hypot(p.z + r) - r)
    }

    /// An ellipsoid with semiaxes 1.4, 1.1, 0.9 times the unknown ball's radius; the ball is at the end of the shortest.
    pub fn ellipsoid() -> Self {
        let axes = UNKNOWN_RADIUS * DVec3::new(1.4, 1.1, 0.9);
        Self::new("ellipsoid", false, move |p| {
            ellipsoid(p + DVec3::Z * axes.z, axes)
        })
    }

    /// All test surfaces.
    pub fn all() -> Vec<Self> {
        vec![
            Self::plane(),
            Self::sphere_cap("sphere 60", 60.0),
            Self::sphere_cap("sphere 90", 90.0),
            Self::clifford_torus("Clifford torus, outer", 1.0, true),
            Self::clifford_torus("Clifford torus, inner", 0.6, false),
            Self::catenoid(),
            Self::cyclide(),
            Self::cylinder(),
            Self::ellipsoid(),
        ]
    }
}

impl DistanceData for ExactShape {
    fn sample(&self, x: DVec3, _limit: f64) -> NodeData {
        let d = self.distance(x);
        NodeData {
            signed: d,
            distance: d.abs(),
            free: x.length() < UNKNOWN_RADIUS,
        }
    }
}

/// Transforms from the world to the shape's frame, which is aligned with no lattice: x, y tangential, z outward. The reference values
/// were computed in the same frame.
fn to_frame(x: DVec3) -> DVec3 {
    let z = DVec3::new(0.711_652, 0.674_309, 0.197_125).normalize();
    let u = DVec3::new(-0.692_111, 0.721_080, 0.032_017)
        .reject_from_normalized(z)
        .normalize();
    DVec3::new(x.dot(u), x.dot(z.cross(u)), x.dot(z))
}

/// Signed distance to the catenoid: Newton's method for the parameter of the closest point of the profile `r = a cosh t, z = a t`.
fn catenoid(p: DVec3) -> f64 {
    let a = UNKNOWN_RADIUS;
    let (r, z) = ((p.z + a).hypot(p.x), p.y);
    let mut t = z / a;
    for _ in 0..60 {
        let (c, s) = (t.cosh(), t.sinh());
        let f = (a * c - r) * a * s + (a * t - z) * a;
        let df = a * a * (s * s + 1.0) + (a * c - r) * a * c;
        t -= (f / df.max(0.1 * a * a)).clamp(-0.2, 0.2);
    }
    let d = (r - a * t.cosh()).hypot(z - a * t);
    if r > a * (z / a).cosh() { d } else { -d }
}

/// Signed distance to the cyclide. Its parallel surfaces are the cyclides `(|q|² − D² + b²)² = 4 (a x − c D)² + 4 b² y²` with
/// `b² = a² − c²`, one D for each distance. Newton's method for D starts at the distance from the centre circle of the tube.
fn cyclide(p: DVec3, a: f64, c: f64, d: f64) -> f64 {
    let bb = a * a - c * c;
    // The thick end is at −x, where the outward direction is −x.
    let q = DVec3::new(-(a + d + c) - p.z, p.x, p.y);
    let torus = (q.x.hypot(q.y) - a).hypot(q.z);
    let mut tube = torus.max(0.3 * d);
    for _ in 0..60 {
        let s = q.length_squared() - tube * tube + bb;
        let along = a * q.x - c * tube;
        let f = s * s - 4.0 * along * along - 4.0 * bb * q.y * q.y;
        let slope = -4.0 * tube * s + 8.0 * c * along;
        if slope == 0.0 {
            break;
        }
        let step = (f / slope).clamp(-0.2 * d, 0.2 * d);
        tube -= step;
        if step.abs() < 1e-15 * d {
            break;
        }
    }
    tube - d
}

/// Signed distance to the ellipsoid: bisection for the multiplier of the closest point (Eberly, "Distance from a point to an
/// ellipsoid").
fn ellipsoid(p: DVec3, axes: DVec3) -> f64 {
    let q = p.abs();
    let squares = axes * axes;
    let excess = |t: f64| (axes * q / (squares + t)).length_squared() - 1.0;
    let smallest = axes.min_element();
    let mut low = -smallest * smallest * (1.0 - 1e-9);
    let mut high = q.length() * axes.max_element();
    for _ in 0..100 {
        let mid = 0.5 * (low + high);
        if excess(mid) > 0.0 {
            low = mid;
        } else {
            high = mid;
        }
    }
    let closest = squares * q / (squares + 0.5 * (low + high));
    let d = q.distance(closest);
    if (p / axes).length_squared() < 1.0 {
        -d
    } else {
        d
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The gradient has length 1, and the foot point along it is on the surface.
    #[test]
    fn distances_are_distances() {
        for shape in ExactShape::all() {
            assert!(shape.distance(DVec3::ZERO).abs() < 1e-9, "{}", shape.name);
            for k in 0..200 {
                let k = f64::from(k);
                let x = DVec3::new((1.1 * k).sin(), (1.7 * k + 1.0).sin(), (2.3 * k).cos());
                let x = 0.9 * x;
                let d = shape.distance(x);
                if d.abs() > 0.25 {
                    continue;
                }
                let e = 1e-5;
                let slope = |axis: DVec3| {
                    (shape.distance(x + e * axis) - shape.distance(x - e * axis)) / (2.0 * e)
                };
                let g = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
                let what = shape.name;
                assert!(
                    (g.length() - 1.0).abs() < 1e-5,
                    "{what}: {x} {}",
                    g.length()
                );
                let foot = shape.distance(x - d * g);
                assert!(foot.abs() < 1e-5, "{what}: {x} {d} {foot}");
            }
        }
    }
}
