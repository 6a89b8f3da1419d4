//! The generalized winding number, evaluated hierarchically.
//!
//! Jacobson, Kavan, Sorkine-Hornung, "Robust inside-outside segmentation using generalized winding numbers", 2013. Distant
//! clusters of triangles are replaced by a dipole, a quadrupole and an octupole as in Barill, Dickson, Schmidt, Levin, Jacobson,
//! "Fast winding numbers for soups and clouds", 2018.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::bvh::{Bvh, Child, WIDTH};
use crate::elementary::atan2;
use crate::mesh::area_vector;

/// Cluster radii. Beyond this distance from its centre a cluster is replaced by its expansion.
const FAR_RADII: f64 = 2.3;

/// Moments of a cluster of triangles about its centre.
struct Moments {
    /// Area-weighted mean of the triangles' centroids, rounded to single precision so that it is stored exactly.
    centre: DVec3,
    /// Upper bound of the distance of a corner from `centre`.
    radius: f64,
    /// Sum of area × normal.
    dipole: DVec3,
    /// Sum of area × (centroid − centre) ⊗ normal.
    quadrupole: DMat3,
    /// For each component i of the normal: sum of area × nᵢ × second moment about `centre`.
    octupole: [DMat3; 3],
    area: f64,
}

/// Moments as stored, in single precision. The relative error of a cluster's contribution is about 1e-7.
#[derive(Clone, Copy, Default)]
struct Cluster {
    centre: [f32; 3],
    radius: f32,
    dipole: [f32; 3],
    area: f32,
    quadrupole: [f32; 9],
    /// Upper triangles: xx, xy, xz, yy, yz, zz.
    octupole: [[f32; 6]; 3],
}

/// Moments of the nodes of a [`Bvh`], for evaluating the winding number.
pub struct WindingTree {
    clusters: Vec<Cluster>,
}

impl WindingTree {
    /// Computes the moments bottom-up.
    pub fn new(bvh: &Bvh) -> Self {
        let mut clusters = vec![Cluster::default(); bvh.nodes.len()];
        // Children come after their parents, so go backwards.
        for (index, node) in bvh.nodes.iter().enumerate().rev() {
            let of = |child| match child {
                Child::Node(child) => clusters[child as usize].moments(),
                Child::Leaf(leaf) => {
                    let places = bvh.places(leaf);
                    Moments::joined(places.map(|at| Moments::of_face(&bvh.corners(at))))
                }
            };
            clusters[index] = Moments::joined(node.children().map(of)).stored();
        }
        Self { clusters }
    }

    /// The winding number at `p`: about 1 inside, 0 outside, and in between near the holes of an open mesh.
    pub fn winding_number(&self, bvh: &Bvh, p: DVec3) -> f64 {
        let q = p - bvh.centre;
        let mut sum = 0.0;
        let mut stack: Vec<u32> = Vec::with_capacity(64);
        if !bvh.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(index) = stack.pop() {
            let cluster = &self.clusters[index as usize];
            let reach = FAR_RADII * f64::from(cluster.radius);
            if (vector(cluster.centre) - q).length_squared() > reach * reach {
                sum += cluster.moments().far_field(q);
                continue;
            }
            for child in bvh.nodes[index as usize].children() {
                match child {
                    Child::Node(child) => stack.push(child),
                    Child::Leaf(leaf) => {
                        for place in bvh.places(leaf) {
                            let [a, b, c] = bvh.corners(place);
                            sum += solid_angle(a - q, b - q, c - q);
                        }
                    }
                }
            }
        }
        sum / (4.0 * PI)
    }
}

impl Cluster {
    #[inline]
    fn moments(&self) -> Moments {
        let q = self.quadrupole.map(f64::from);
        Moments {
            centre: vector(self.centre),
            radius: self.radius.into(),
            dipole: vector(self.dipole),
            quadrupole: DMat3::from_cols_array(&q),
            octupole: self.octupole.map(|o| {
                let [xx, xy, xz, yy, yz, zz] = o.map(f64::from);
                DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz])
            }),
            area: self.area.into(),
        }
    }
}

#[inline]
fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// The nearest point in single precision.
fn storable(p: DVec3) -> DVec3 {
    vector(p.as_vec3().to_array())
}

impl Moments {
    fn stored(&self) -> Cluster {
        Cluster {
            centre: self.centre.as_vec3().to_array(),
            radius: self.radius as f32,
            dipole: self.dipole.as_vec3().to_array(),
            area: self.area as f32,
            quadrupole: self.quadrupole.to_cols_array().map(|v| v as f32),
            octupole: self.octupole.map(|o| {
                let m = o.to_cols_array();
                [m[0], m[1], m[2], m[4], m[5], m[8]].map(|v| v as f32)
            }),
        }
    }

    fn of_face(c: &[DVec3; 3]) -> Self {
        let dipole = 0.5 * area_vector(*c);
        let centroid = (c[0] + c[1] + c[2]) / 3.0;
        let centre = storable(centroid);
        // The second moment of a triangle about a point is the mean of the second moments of its edge midpoints.
        let moment = (0..3).fold(DMat3::ZERO, |m, k| {
            let d = 0.5 * (c[k] + c[(k + 1) % 3]) - centre;
            m + outer(d, d) * (1.0 / 3.0)
        });
        Self {
            centre,
            radius: c.iter().map(|v| v.distance(centre)).fold(0.0, f64::max),
            dipole,
            quadrupole: outer(centroid - centre, dipole),
            octupole: dipole.to_array().map(|n| moment * n),
            area: dipole.length(),
        }
    }

    fn joined(parts: impl Iterator<Item = Self>) -> Self {
        let mut all: [Option<Self>; WIDTH] = [const { None }; WIDTH];
        for (slot, part) in all.iter_mut().zip(parts) {
            *slot = Some(part);
        }
        let parts = || all.iter().flatten();
        // The new centre is the area-weighted mean of the centres.
        let area: f64 = parts().map(|c| c.area).sum();
        let mut centre = parts().next().map_or(DVec3::ZERO, |c| c.centre);
        if area > 0.0 {
            centre = parts().map(|c| c.centre * c.area).sum::<DVec3>() / area;
        }
        let centre = storable(centre);
        let mut sum = Self {
            centre,
            radius: 0.0,
            dipole: DVec3::ZERO,
            quadrupole: DMat3::ZERO,
            octupole: [DMat3::ZERO; 3],
            area,
        };
        for c in parts() {
            // Translate the moments of the part to the new centre.
            let s = c.centre - centre;
            sum.radius = sum.radius.max(s.length() + c.radius);
            sum.dipole += c.dipole;
            sum.quadrupole += c.quadrupole + outer(s, c.dipole);
            for (i, o) in sum.octupole.iter_mut().enumerate() {
                let first = c.quadrupole.col(i);
                *o += c.octupole[i] + outer(first, s) + outer(s, first) + outer(s, s) * c.dipole[i];
            }
        }
        sum
    }

    fn far_field(&self, q: DVec3) -> f64 {
        // Taylor expansion of the solid angle about the centre, up to the octupole (Barill et al. 2018).
        let r = self.centre - q;
        let r2 = r.length_squared();
        let r3 = r2 * r2.sqrt();
        let trace = self.quadrupole.x_axis.x + self.quadrupole.y_axis.y + self.quadrupole.z_axis.z;
        let (mut mixed, mut cubic) = (0.0, 0.0);
        for (i, s) in self.octupole.iter().enumerate() {
            mixed += 2.0 * s.col(i).dot(r) + (s.x_axis.x + s.y_axis.y + s.z_axis.z) * r[i];
            cubic += r[i] * r.dot(*s * r);
        }
        let first = self.dipole.dot(r) + trace - 3.0 * r.dot(self.quadrupole * r) / r2;
        (first - 1.5 * mixed / r2 + 7.5 * cubic / (r2 * r2)) / r3
    }
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Signed solid angle of a triangle seen from the origin (van Oosterom and Strackee, 1983).
pub(crate) fn solid_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let numerator = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * atan2(numerator, denominator)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    fn sphere(n: u32, keep: impl Fn(DVec3) -> bool) -> Mesh {
        let mut mesh = Mesh::default();
        for i in 0..=n {
            for j in 0..2 * n {
                let (t, u) = (
                    PI * f64::from(i) / f64::from(n),
                    PI * f64::from(j) / f64::from(n),
                );
                mesh.positions
                    .push(DVec3::new(t.sin() * u.cos(), t.sin() * u.sin(), t.cos()));
            }
        }
        for i in 0..n {
            for j in 0..2 * n {
                let (a, b) = (i * 2 * n + j, i * 2 * n + (j + 1) % (2 * n));
                let (c, d) = (a + 2 * n, b + 2 * n);
                for f in [[a, c, d], [a, d, b]] {
                    let centre = f.iter().map(|&v| mesh.positions[v as usize]).sum::<DVec3>() / 3.0;
                    if keep(centre) {
                        mesh.faces.push(f);
                    }
                }
            }
        }
        mesh
    }

    #[test]
    fn it_agrees_with_the_sum_of_solid_angles() {
        let mesh = sphere(24, |c| c.z < 0.6);
        let faces = (0..mesh.faces.len() as u32).collect();
        let [one, several] = [
            Bvh::new(&mesh, 0..mesh.faces.len() as u32),
            Bvh::for_few(&mesh, faces, DVec3::ZERO),
        ]
        .map(|bvh| (WindingTree::new(&bvh), bvh));
        for i in 0..300 {
            let t = f64::from(i);
            let p = 1.5 * DVec3::new((t * 0.37).sin(), (t * 0.73).cos(), (t * 0.11).sin());
            let exact: f64 = mesh
                .faces
                .iter()
                .map(|f| {
                    let [a, b, c] = f.map(|v| mesh.positions[v as usize] - p);
                    solid_angle(a, b, c)
                })
                .sum::<f64>()
                / (4.0 * PI);
            for (tree, bvh) in [&one, &several] {
                let fast = tree.winding_number(bvh, p);
                assert!((fast - exact).abs() < 0.005, "{p}: {fast} against {exact}");
            }
        }
    }
}
