//! Test meshes with known exact surfaces, and measurements of meshes: topology, volume, distances.
#![allow(dead_code)] // Each test file uses some of it.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use isomend::Mesh;

/// Pseudo-random numbers, the same in every run.
pub struct Noise(pub u64);

impl Noise {
    /// From -1 to 1.
    pub fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Each coordinate from -1 to 1.
    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}

/// A rotation after which shapes are aligned with no axis of a lattice.
pub fn turn() -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(3.0, -5.0, 8.0).normalize(), 0.65)
}

/// The mesh rotated by [`turn`].
pub fn turned(mut mesh: Mesh) -> Mesh {
    let turn = turn();
    mesh.positions.iter_mut().for_each(|p| *p = turn * *p);
    mesh
}

/// The mesh without the faces whose centroid is chosen, and without the vertices that become unused.
pub fn cut(mesh: &Mesh, removed: impl Fn(DVec3) -> bool) -> Mesh {
    let mut out = Mesh::default();
    let mut number = HashMap::new();
    for face in &mesh.faces {
        let corners = face.map(|v| mesh.positions[v as usize]);
        if removed(corners.iter().sum::<DVec3>() / 3.0) {
            continue;
        }
        out.faces.push(face.map(|v| {
            *number.entry(v).or_insert_with(|| {
                out.positions.push(mesh.positions[v as usize]);
                out.positions.len() as u32 - 1
            })
        }));
    }
    out
}

/// The unit sphere: an icosahedron with each edge divided into `n`.
pub fn sphere(n: u32) -> Mesh {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut corners = Vec::new();
    for (a, b) in [(1.0, g), (1.0, -g), (-1.0, g), (-1.0, -g)] {
        corners.extend([
            DVec3::new(0.0, a, b),
            DVec3::new(a, b, 0.0),
            DVec3::new(b, 0.0, a),
        ]);
    }
    let mut mesh = Mesh::default();
    let mut number = HashMap::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let (mut a, mut b, c) = (corners[i], corners[j], corners[k]);
                let edges = [a.distance(b), b.distance(c), c.distance(a)];
                if edges.iter().any(|e| (e - 2.0).abs() > 1e-9) {
                    continue;
                }
                if (b - a).cross(c - a).dot(a) < 0.0 {
                    std::mem::swap(&mut a, &mut b);
                }
                divide([a, b, c], n, &mut mesh, &mut number);
            }
        }
    }
    mesh
}

fn divide(corners: [DVec3; 3], n: u32, mesh: &mut Mesh, number: &mut HashMap<[i64; 3], u32>) {
    let [a, b, c] = corners;
    let mut at = |i: u32, j: u32| {
        let (s, t) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
        let p = (a + (b - a) * s + (c - a) * t).normalize();
        let key = p.to_array().map(|x| (x * 1e9).round() as i64);
        *number.entry(key).or_insert_with(|| {
            mesh.positions.push(p);
            mesh.positions.len() as u32 - 1
        })
    };
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..n - i {
            faces.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
            if i + j + 1 < n {
                faces.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    mesh.faces.extend(faces);
}

/// The larger radius of the Clifford torus whose smaller one is 1.
pub const BIG: f64 = std::f64::consts::SQRT_2;

/// The Clifford torus.
pub fn torus(around: u32, across: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let at = |i: u32, j: u32| i % around * across + j % across;
    for i in 0..around {
        for j in 0..across {
            let u = TAU * (f64::from(i) + 0.5 * f64::from(j % 2)) / f64::from(around);
            let w = TAU * f64::from(j) / f64::from(across);
            let r = BIG + w.cos();
            mesh.positions
                .push(DVec3::new(r * u.cos(), r * u.sin(), w.sin()));
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
            if j % 2 == 0 {
                mesh.faces.extend([[a, b, c], [b, d, c]]);
            } else {
                mesh.faces.extend([[a, d, c], [a, b, d]]);
            }
        }
    }
    mesh
}

/// Distance to the Clifford torus.
pub fn torus_distance(p: DVec3) -> f64 {
    (p.x.hypot(p.y) - BIG).hypot(p.z) - 1.0
}

/// A dumb-bell: a catenoid of waist 1 with a ball at each end; its neck is missing between two rims.
pub fn catenoid_neck(spacing: f64) -> Mesh {
    let (neck, join) = (0.55f64, 0.8f64);
    let ball = join.cosh() * join.cosh();
    let centre = join + join.cosh() * join.sinh();
    let start = (-join.tanh()).acos();
    let rows = |length: f64| (length / (0.87 * spacing)).round().max(1.0) as u32;
    let mut profile = Vec::new();
    let n = rows(join.sinh() - neck.sinh());
    for k in 0..=n {
        let s = neck.sinh() + (join.sinh() - neck.sinh()) * f64::from(k) / f64::from(n);
        profile.push((s.asinh().cosh(), s.asinh()));
    }
    let n = rows(ball * start);
    for k in 1..=n {
        let a = start * (1.0 - f64::from(k) / f64::from(n));
        profile.push((ball * a.sin(), centre + ball * a.cos()));
    }
    let upper = revolve(&profile, spacing);
    let count = upper.positions.len() as u32;
    let mut mesh = upper.clone();
    mesh.positions
        .extend(upper.positions.iter().map(|p| DVec3::new(p.x, -p.y, -p.z)));
    mesh.faces
        .extend(upper.faces.iter().map(|f| f.map(|v| v + count)));
    mesh
}

/// A surface of revolution about z from a profile of rising z; rings of radius 0 are poles.
fn revolve(profile: &[(f64, f64)], spacing: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let mut rings = Vec::new();
    for (k, &(r, z)) in profile.iter().enumerate() {
        let n = match r < 1e-9 {
            true => 1,
            false => (TAU * r / spacing).round().max(6.0) as u32,
        };
        let first = PI * (k % 2) as f64 / f64::from(n);
        rings.push((mesh.positions.len() as u32, n, first));
        for i in 0..n {
            let a = first + TAU * f64::from(i) / f64::from(n);
            mesh.positions.push(DVec3::new(r * a.cos(), r * a.sin(), z));
        }
    }
    for pair in rings.windows(2) {
        let [(s, n, a0), (t, m, b0)] = [pair[0], pair[1]];
        let (low, high) = (if n > 1 { n } else { 0 }, if m > 1 { m } else { 0 });
        let (mut i, mut j) = (0, 0);
        while i < low || j < high {
            let next_low = a0 + TAU * f64::from(i + 1) / f64::from(n);
            let next_high = b0 + TAU * f64::from(j + 1) / f64::from(m);
            let (a, b) = (s + i % n, t + j % m);
            if j >= high || (i < low && next_low <= next_high) {
                mesh.faces.push([a, s + (i + 1) % n, b]);
                i += 1;
            } else {
                mesh.faces.push([a, t + (j + 1) % m, b]);
                j += 1;
            }
        }
    }
    mesh
}

/// Distance to the catenoid of waist 1 about z.
pub fn catenoid_distance(p: DVec3) -> f64 {
    let (r, z) = (p.x.hypot(p.y), p.z);
    let mut t = z.clamp(-1.0, 1.0);
    for _ in 0..60 {
        let (c, s) = (t.cosh(), t.sinh());
        let slope = (s * s + 1.0 + (c - r) * c).max(0.1);
        t -= (((c - r) * s + t - z) / slope).clamp(-0.2, 0.2);
    }
    (r - t.cosh()).hypot(z - t)
}

/// Half the height of [`slab`].
pub const HALF: f64 = 0.5;

/// A box of 2 by 2 by 1, its edges divided into lengths of `1 / n`.
pub fn slab(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let mut number = HashMap::new();
    let half = DVec3::new(1.0, 1.0, HALF);
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let (u, w) = ((axis + 1) % 3, (axis + 2) % 3);
            let cells = |k: usize| (2.0 * half[k] * f64::from(n)).round() as u32;
            let mut at = |i: u32, j: u32| {
                let mut p = DVec3::ZERO;
                p[axis] = side * half[axis];
                p[u] = (2.0 * f64::from(i) / f64::from(cells(u)) - 1.0) * half[u];
                p[w] = (2.0 * f64::from(j) / f64::from(cells(w)) - 1.0) * half[w];
                let key = p.to_array().map(|x| (x * 1e9).round() as i64);
                *number.entry(key).or_insert_with(|| {
                    mesh.positions.push(p);
                    mesh.positions.len() as u32 - 1
                })
            };
            let mut faces = Vec::new();
            for i in 0..cells(u) {
                for j in 0..cells(w) {
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    faces.extend([[a, b, c], [a, c, d]]);
                }
            }
            for [a, b, c] in faces {
                mesh.faces
                    .push(if side > 0.0 { [a, b, c] } else { [a, c, b] });
            }
        }
    }
    mesh
}

/// A flat open sheet of 2 by 2 with its sides divided into `n`.
pub fn sheet(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=n {
        for j in 0..=n {
            let at = |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
            mesh.positions.push(DVec3::new(at(i), at(j), 0.0));
        }
    }
    for i in 0..n {
        for j in 0..n {
            let (a, b) = (i * (n + 1) + j, (i + 1) * (n + 1) + j);
            mesh.faces.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    mesh
}

/// The polar angle of a point, in degrees.
pub fn polar(p: DVec3) -> f64 {
    (p.z / p.length()).acos().to_degrees()
}

/// Number of directed edges whose opposite edge does not exist exactly once, and the Euler number, in which a boundary edge counts half.
pub fn topology(mesh: &Mesh) -> (usize, i64) {
    let mut directed: HashMap<(u32, u32), usize> = HashMap::new();
    for f in &mesh.faces {
        for k in 0..3 {
            *directed.entry((f[k], f[(k + 1) % 3])).or_default() += 1;
        }
    }
    let lone = directed
        .iter()
        .filter(|&(&(a, b), &n)| n != 1 || directed.get(&(b, a)) != Some(&1))
        .count();
    let mut used: Vec<u32> = mesh.faces.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let euler = used.len() as i64 - directed.len() as i64 / 2 + mesh.faces.len() as i64;
    (lone, euler)
}

/// Vertices whose faces form more than one fan.
pub fn pinched_vertices(mesh: &Mesh) -> usize {
    let mut next: HashMap<u32, HashMap<u32, u32>> = HashMap::new();
    for f in &mesh.faces {
        for k in 0..3 {
            next.entry(f[k])
                .or_default()
                .insert(f[(k + 1) % 3], f[(k + 2) % 3]);
        }
    }
    let round = |links: &HashMap<u32, u32>| {
        let Some(&start) = links.keys().next() else {
            return true;
        };
        let (mut at, mut count) = (links[&start], 1);
        while at != start && count <= links.len() {
            let Some(&after) = links.get(&at) else {
                return false;
            };
            (at, count) = (after, count + 1);
        }
        count == links.len()
    };
    next.values().filter(|links| !round(links)).count()
}

/// The bits of all coordinates.
pub fn bits(positions: &[DVec3]) -> Vec<[u64; 3]> {
    positions
        .iter()
        .map(|p| p.to_array().map(f64::to_bits))
        .collect()
}

/// A flat sheet with a square hole; both diagonals of the hole are already edges of closed tetrahedra.
pub fn unfillable() -> Mesh {
    let mut mesh = Mesh::default();
    let corner = |r: f64, k: usize| [[r, r, 0.0], [-r, r, 0.0], [-r, -r, 0.0], [r, -r, 0.0]][k];
    for r in [1.0, 3.0] {
        (0..4).for_each(|k| mesh.positions.push(DVec3::from(corner(r, k))));
    }
    for k in 0..4u32 {
        let n = (k + 1) % 4;
        mesh.faces.extend([[k, 4 + k, n], [n, 4 + k, 4 + n]]);
    }
    for (a, b, z) in [(0u32, 2u32, 1.0), (1, 3, -1.0)] {
        let c = mesh.positions.len() as u32;
        let apex = DVec3::new(0.2, 0.1, z);
        mesh.positions
            .extend([apex, apex * DVec3::new(-1.0, -2.0, 1.5)]);
        mesh.faces
            .extend([[a, b, c], [b, a, c + 1], [a, c, c + 1], [b, c + 1, c]]);
    }
    mesh
}

/// A mesh scaled, then moved.
pub fn moved(mesh: &Mesh, scale: f64, by: DVec3) -> Mesh {
    let positions = mesh.positions.iter().map(|p| scale * *p + by);
    Mesh::new(positions.collect(), mesh.faces.clone())
}

/// Two meshes as one, the first one's vertices and faces first.
pub fn joined(a: &Mesh, b: &Mesh) -> Mesh {
    let mut mesh = a.clone();
    let count = a.positions.len() as u32;
    mesh.positions.extend(&b.positions);
    mesh.faces
        .extend(b.faces.iter().map(|f| f.map(|v| v + count)));
    mesh
}

/// Volume enclosed by a closed mesh.
pub fn volume(mesh: &Mesh) -> f64 {
    let corners = mesh
        .faces
        .iter()
        .map(|f| f.map(|v| mesh.positions[v as usize]));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// The surface of a cube from 0 to `n` along each axis: squares of size 1, each divided into two triangles.
pub fn cube(n: i32) -> Mesh {
    let mut mesh = Mesh::default();
    let mut number = HashMap::new();
    for side in 0..6 {
        let axes = [side % 3, (side + 1) % 3, (side + 2) % 3];
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let mut corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(u, v)| {
                let mut p = [0; 3];
                p[axes[0]] = if side < 3 { n } else { 0 };
                (p[axes[1]], p[axes[2]]) = (u, v);
                *number.entry(p).or_insert_with(|| {
                    mesh.positions.push(DVec3::from_array(p.map(f64::from)));
                    mesh.positions.len() as u32 - 1
                })
            });
            if side >= 3 {
                corners.reverse();
            }
            let [a, b, c, d] = corners;
            mesh.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// A cube with two holes: one across an edge, with two crease ends, and one at the opposite corner, with three.
pub fn open_cube() -> Mesh {
    let holes = [
        (DVec3::new(6.0, 0.0, 12.0), 3.2),
        (DVec3::new(12.0, 12.0, 0.0), 2.8),
    ];
    cut(&cube(12), |p| {
        holes.iter().any(|(c, r)| p.distance(*c) < *r)
    })
}

/// The open cube with a small tetrahedron in place of the missing edge: continued sides intersect it.
pub fn blocked_cube() -> Mesh {
    let corners =
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]].map(|p| DVec3::from_array(p.map(f64::from)));
    let block = Mesh::new(
        corners.to_vec(),
        vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    );
    joined(
        &open_cube(),
        &moved(&block, 0.2, DVec3::new(5.93, -0.06, 11.94)),
    )
}
