//! The generalized winding number, by rays and boundary edges where these are few, else hierarchically.
//!
//! Jacobson, Kavan, Sorkine-Hornung, "Robust inside-outside segmentation using generalized winding numbers", 2013. Distant
//! clusters of triangles are replaced by a dipole, a quadrupole and an octupole as in Barill, Dickson, Schmidt, Levin, Jacobson,
//! "Fast winding numbers for soups and clouds", 2018.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::angles::Angles;
use super::bvh::{Bvh, Child, WIDTH};
use super::crossings::Crossings;
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

/// Moments in single precision, while the tree is made. The relative error of a cluster's contribution is about 1e-7.
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

/// What the expansion of a cluster needs, as a polynomial of r, the vector from the point to the centre: the solid angle is
/// (d·r + t + (q(r) + m·r + c(r) / r²) / r²) / |r|³, with the factors of the Taylor series in q, m and c.
#[derive(Clone, Copy, Default)]
struct Far {
    centre: [f32; 3],
    radius: f32,
    /// d: the dipole.
    dipole: [f32; 3],
    /// t: the trace of the quadrupole.
    trace: f32,
    /// q: xx, yy, zz, xy, xz, yz.
    square: [f32; 6],
    /// m: the contracted octupole.
    linear: [f32; 3],
    /// c: xxx, yyy, zzz, xxy, xxz, xyy, yyz, xzz, yzz, xyz.
    cubic: [f32; 10],
}

/// What the winding number of the faces of a [`Bvh`] is evaluated from.
pub struct WindingTree(Source);

enum Source {
    /// Rays and boundary edges, where these are few: exact up to rounding.
    Crossings(Crossings),
    Clusters(Clusters),
}

/// Moments of the nodes of a [`Bvh`].
struct Clusters(Vec<Far>);

impl WindingTree {
    /// Finds the boundary or, if it has many edges, computes moments.
    pub fn new(bvh: &Bvh) -> Self {
        Self(match Crossings::new(bvh) {
            Some(crossings) => Source::Crossings(crossings),
            None => Source::Clusters(Clusters::new(bvh)),
        })
    }

    /// The winding number at `p`: about 1 inside, 0 outside, and in between near the holes of an open mesh.
    pub fn winding_number(&self, bvh: &Bvh, p: DVec3) -> f64 {
        let q = p - bvh.centre;
        match &self.0 {
            Source::Crossings(crossings) => crossings.winding_number(bvh, q),
            Source::Clusters(clusters) => clusters.winding_number(bvh, q),
        }
    }
}

impl Clusters {
    /// Computes the moments bottom-up.
    fn new(bvh: &Bvh) -> Self {
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
        Self(clusters.iter().map(Cluster::far).collect())
    }

    /// The winding number at a point relative to the hierarchy's centre.
    fn winding_number(&self, bvh: &Bvh, q: DVec3) -> f64 {
        let mut far = 0.0;
        let mut near = Angles::new();
        let mut stack: Vec<u32> = Vec::with_capacity(64);
        if !bvh.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(index) = stack.pop() {
            let cluster = &self.0[index as usize];
            let r = vector(cluster.centre) - q;
            let reach = FAR_RADII * f64::from(cluster.radius);
            if r.length_squared() > reach * reach {
                far += cluster.solid_angle(r);
                continue;
            }
            for child in bvh.nodes[index as usize].children() {
                match child {
                    Child::Node(child) => stack.push(child),
                    Child::Leaf(leaf) => {
                        for place in bvh.places(leaf) {
                            let [a, b, c] = bvh.corners(place);
                            let (sine, cosine) = half_solid_angle(a - q, b - q, c - q);
                            near.add(sine, cosine);
                        }
                    }
                }
            }
        }
        (far + 2.0 * near.sum()) / (4.0 * PI)
    }
}

impl Far {
    /// The solid angle of the cluster seen from the point from which `r` leads to its centre: the Taylor expansion about the centre,
    /// up to the octupole (Barill et al. 2018).
    #[inline]
    fn solid_angle(&self, r: DVec3) -> f64 {
        let [x, y, z] = r.to_array();
        let of = |v: f32| f64::from(v);
        let [xx, yy, zz, xy, xz, yz] = &self.square;
        let square = x * (of(*xx) * x + of(*xy) * y + of(*xz) * z)
            + y * (of(*yy) * y + of(*yz) * z)
            + of(*zz) * z * z;
        let [xxx, yyy, zzz, xxy, xxz, xyy, yyz, xzz, yzz, xyz] = &self.cubic;
        let cubic = x * x * (of(*xxx) * x + of(*xxy) * y + of(*xxz) * z)
            + y * y * (of(*xyy) * x + of(*yyy) * y + of(*yyz) * z)
            + z * z * (of(*xzz) * x + of(*yzz) * y + of(*zzz) * z)
            + of(*xyz) * x * y * z;
        let near = 1.0 / r.length_squared();
        let first = vector(self.dipole).dot(r) + of(self.trace);
        let second = square + vector(self.linear).dot(r) + near * cubic;
        (first + near * second) * near * near.sqrt()
    }
}

impl Cluster {
    fn far(&self) -> Far {
        let q = &self.quadrupole;
        let [x, y, z] = &self.octupole;
        let mut linear = [0.0; 3];
        // Upper triangles: xx 0, xy 1, xz 2, yy 3, yz 4, zz 5.
        const ROWS: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];
        for (i, side) in self.octupole.iter().enumerate() {
            for (m, row) in linear.iter_mut().zip(ROWS) {
                *m -= 3.0 * side[row[i]];
            }
            linear[i] -= 1.5 * (side[0] + side[3] + side[5]);
        }
        let cubic = [
            x[0],
            y[3],
            z[5],
            2.0 * x[1] + y[0],
            2.0 * x[2] + z[0],
            2.0 * y[1] + x[3],
            2.0 * y[4] + z[3],
            2.0 * z[2] + x[5],
            2.0 * z[4] + y[5],
            2.0 * (x[4] + y[2] + z[1]),
        ];
        Far {
            centre: self.centre,
            radius: self.radius,
            dipole: self.dipole,
            trace: q[0] + q[4] + q[8],
            square: [q[0], q[4], q[8], q[1] + q[3], q[2] + q[6], q[5] + q[7]].map(|v| -3.0 * v),
            linear,
            cubic: cubic.map(|v| 7.5 * v),
        }
    }

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
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Signed solid angle of a triangle seen from the origin (van Oosterom and Strackee, 1983).
pub(crate) fn solid_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (numerator, denominator) = half_solid_angle(a, b, c);
    2.0 * atan2(numerator, denominator)
}

/// Numerator and denominator of the tangent of half the solid angle.
#[inline]
fn half_solid_angle(a: DVec3, b: DVec3, c: DVec3) -> (f64, f64) {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let numerator = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    (numerator, denominator)
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
        .map(|bvh| (Clusters::new(&bvh), bvh));
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
                let fast = tree.winding_number(bvh, p - bvh.centre);
                assert!((fast - exact).abs() < 0.005, "{p}: {fast} against {exact}");
                let all = WindingTree::new(bvh).winding_number(bvh, p);
                assert!((all - exact).abs() < 1e-9, "{p}: {all} against {exact}");
            }
        }
    }

    #[test]
    fn points_below_and_on_the_lines_of_edges_see_each_face_once() {
        // The surface of a cube of 3 × 3 × 3 unit cubes, each triangle with corners of its own.
        let mut whole = Mesh::default();
        for (axis, is_high) in [0, 1, 2].into_iter().flat_map(|k| [(k, false), (k, true)]) {
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let corner = |u: i32, v: i32| {
                    let mut p = DVec3::ZERO;
                    p[axis] = if is_high { 3.0 } else { 0.0 };
                    (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u.into(), v.into());
                    p
                };
                let [a, b] = [corner(i, j), corner(i + 1, j)];
                let [c, d] = [corner(i + 1, j + 1), corner(i, j + 1)];
                for t in [[a, b, c], [a, c, d]] {
                    let first = whole.positions.len() as u32;
                    whole.positions.extend(t);
                    let [b, c] = if is_high { [1, 2] } else { [2, 1] };
                    whole.faces.push([first, first + b, first + c]);
                }
            }
        }
        for open in [0, 1, 5, 40] {
            let mut mesh = whole.clone();
            let every = whole.faces.len().checked_div(open).unwrap_or(usize::MAX);
            let left = whole.faces.iter().enumerate();
            let left = left.filter(|(f, _)| (f + 1) % every != 0);
            mesh.faces = left.map(|(_, face)| *face).collect();
            let bvh = Bvh::new(&mesh, 0..mesh.faces.len() as u32);
            let tree = WindingTree::new(&bvh);
            for i in 0..7 * 7 * 7 {
                let p = 0.5 * DVec3::new((i % 7).into(), (i / 7 % 7).into(), (i / 49).into());
                let is_on = p.to_array().iter().any(|x| *x == 0.0 || *x == 3.0);
                if is_on {
                    continue;
                }
                let exact: f64 = (0..mesh.faces.len() as u32)
                    .map(|f| {
                        let [a, b, c] = mesh.corners(f).map(|v| v - p);
                        solid_angle(a, b, c)
                    })
                    .sum::<f64>()
                    / (4.0 * PI);
                let found = tree.winding_number(&bvh, p);
                assert!((found - exact).abs() < 1e-9, "{p}: {found} against {exact}");
            }
        }
    }
}
