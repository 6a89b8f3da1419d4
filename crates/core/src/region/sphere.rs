//! Fits the sphere that continues a surface at its rims.

use glam::DVec3;

use crate::mesh::{Hole, Mesh};
use crate::tuning::{Tunable, tunable};

/// Diameters, root mean square over positions and normals. Rims closer to a sphere than this lie on it.
const SPHERE_FITS: Tunable<f64> = tunable("region.sphere_fits", 0.05);

/// Diameters. Spheres with larger radius are not considered: their box would be large, and the missing part may as well
/// be a shallow cap.
const LARGEST_SPHERE: Tunable<f64> = tunable("region.largest_sphere", 1.25);

/// A sphere whose inside or outside is the solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    centre: DVec3,
    /// Negative where the solid is outside, as in a spherical cavity.
    radius: f64,
}

impl Sphere {
    /// The sphere with the least `Σ |p − c − R n|²` over the rims' edges, weighted by their length, where `p` is the midpoint of
    /// an edge and `n` the normal of the face there; none where it fits badly or is large.
    pub fn new(mesh: &Mesh, holes: &[&Hole]) -> Option<Self> {
        let edges = || holes.iter().flat_map(|hole| rim_edges(mesh, hole));
        let length: f64 = edges().map(|e| e.length).sum();
        let mean = |of: &dyn Fn(&RimEdge) -> DVec3| {
            edges().map(|e| e.length * of(&e)).sum::<DVec3>() / length
        };
        // The least squares: R from the centred midpoints and normals, then c.
        let (middle, normal) = (mean(&|e| e.middle), mean(&|e| e.normal));
        let (mut both, mut square) = (0.0, 0.0);
        for e in edges() {
            let n = e.normal - normal;
            both += e.length * (e.middle - middle).dot(n);
            square += e.length * n.length_squared();
        }
        let radius = both / square;
        let new = Self {
            centre: middle - radius * normal,
            radius,
        };
        // The root mean square residual decides whether the rims fit the sphere.
        let off =
            |e: &RimEdge| e.length * (e.middle - new.centre - radius * e.normal).length_squared();
        let error = (edges().map(|e| off(&e)).sum::<f64>() / length).sqrt();
        let diameter = holes.iter().map(|h| h.diameter).fold(0.0, f64::max);
        // Also false for NaN.
        (error < SPHERE_FITS.get() * diameter && radius.abs() < LARGEST_SPHERE.get() * diameter)
            .then_some(new)
    }

    /// The lowest and the highest corner of its bounding box, in world units.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let radius = DVec3::splat(self.radius.abs());
        (self.centre - radius, self.centre + radius)
    }

    /// The signed distance of a world point in world units, negative in the solid.
    pub fn signed_distance(&self, x: DVec3) -> f64 {
        (x.distance(self.centre) - self.radius.abs()) * self.radius.signum()
    }
}

/// An edge of a rim.
struct RimEdge {
    middle: DVec3,
    /// Unit outward normal of the face there.
    normal: DVec3,
    length: f64,
}

fn rim_edges<'a>(mesh: &'a Mesh, hole: &'a Hole) -> impl Iterator<Item = RimEdge> + 'a {
    let next = hole.rim.iter().cycle().skip(1);
    let edges = hole.rim.iter().zip(next).zip(&hole.conormals);
    edges.map(|((&a, &b), conormal)| {
        let [a, b] = [a, b].map(|v| mesh.positions[v as usize]);
        RimEdge {
            middle: 0.5 * (a + b),
            normal: (b - a).normalize_or_zero().cross(*conormal),
            length: a.distance(b),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{grid, icosphere, punch};
    use crate::mesh::{Topology, find_holes};

    fn sphere(mut mesh: Mesh) -> Option<Sphere> {
        let mut topology = Topology::new(&mut mesh);
        let (holes, _) = find_holes(&mesh, &mut topology);
        Sphere::new(&mesh, &holes.iter().collect::<Vec<_>>())
    }

    #[test]
    fn the_rest_of_a_sphere_determines_the_sphere_and_its_solid_side() {
        for top in [-0.8, 0.0, 0.8] {
            let mut mesh = punch(&icosphere(4), |c| c.z < top);
            for side in [1.0, -1.0] {
                let found = sphere(mesh.clone()).expect("a sphere");
                assert!(found.centre.length() < 0.1, "{found:?}");
                assert!((found.radius * side - 1.0).abs() < 0.1, "{found:?}");
                assert!(found.signed_distance(DVec3::ZERO) * side < -0.8);
                mesh.faces.iter_mut().for_each(|f| f.swap(0, 1));
            }
        }
    }

    #[test]
    fn planes_and_ends_of_tubes_have_none() {
        let sheet = grid(20, 20, [false, false], |u, v| DVec3::new(u, v, 0.0));
        assert_eq!(
            sphere(punch(&sheet, |c| (c.x - 0.5).hypot(c.y - 0.5) < 0.3)),
            None
        );
        let tube = grid(24, 20, [true, false], |u, v| {
            let (s, c) = (std::f64::consts::TAU * u).sin_cos();
            DVec3::new(c, s, 8.0 * v)
        });
        assert_eq!(sphere(tube), None);
    }
}
