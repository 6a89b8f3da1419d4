//! Meshes for tests.

use std::collections::BTreeMap;

use glam::DVec3;

use super::Mesh;

/// Pseudo-random numbers from 0 to 1, reproducible from the seed (D. E. Knuth, "The Art of Computer Programming" 2, section
/// 3.3.4).
pub fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// The mesh without the faces for whose centroid `remove` is true, and without unused vertices.
pub fn punch(mesh: &Mesh, mut remove: impl FnMut(DVec3) -> bool) -> Mesh {
    let mut renumber = BTreeMap::new();
    let mut out = Mesh::default();
    for f in &mesh.faces {
        let [a, b, c] = f.map(|v| mesh.positions[v as usize]);
        if !remove((a + b + c) / 3.0) {
            out.faces.push(f.map(|v| {
                *renumber.entry(v).or_insert_with(|| {
                    out.positions.push(mesh.positions[v as usize]);
                    out.positions.len() as u32 - 1
                })
            }));
        }
    }
    out
}

/// An icosahedron whose faces are divided into four, `levels` times, on the unit sphere.
pub fn icosphere(levels: usize) -> Mesh {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut positions = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        positions.extend([
            DVec3::new(0.0, a, b),
            DVec3::new(a, b, 0.0),
            DVec3::new(b, 0.0, a),
        ]);
    }
    let mut faces = Vec::new();
    for i in 0..12u32 {
        for j in 0..12u32 {
            for k in 0..12u32 {
                let [a, b, c] = [i, j, k].map(|v| positions[v as usize]);
                let side = |u: DVec3, v: DVec3| (u.distance(v) - 2.0).abs() < 1e-9;
                if i < j
                    && i < k
                    && side(a, b)
                    && side(b, c)
                    && side(c, a)
                    && a.dot(b.cross(c)) > 0.0
                {
                    faces.push([i, j, k]);
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middle = BTreeMap::new();
        let mut finer = Vec::new();
        for f in &faces {
            let m = [0, 1, 2].map(|k: usize| {
                let (a, b) = (f[k], f[(k + 1) % 3]);
                *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    positions.push((positions[a as usize] + positions[b as usize]) / 2.0);
                    positions.len() as u32 - 1
                })
            });
            finer.extend([
                [f[0], m[0], m[2]],
                [f[1], m[1], m[0]],
                [f[2], m[2], m[1]],
                m,
            ]);
        }
        faces = finer;
    }
    Mesh::new(positions.into_iter().map(DVec3::normalize).collect(), faces)
}

/// A grid of `n` × `m` squares divided into triangles; `closed` marks periodic directions.
pub fn grid(n: usize, m: usize, closed: [bool; 2], at: impl Fn(f64, f64) -> DVec3) -> Mesh {
    let (rows, columns) = (n + usize::from(!closed[0]), m + usize::from(!closed[1]));
    let index = |i: usize, j: usize| ((i % rows) * columns + j % columns) as u32;
    let mut mesh = Mesh::default();
    for i in 0..rows {
        for j in 0..columns {
            mesh.positions
                .push(at(i as f64 / n as f64, j as f64 / m as f64));
        }
    }
    for i in 0..n {
        for j in 0..m {
            let [a, b, c, d] = [
                index(i, j),
                index(i + 1, j),
                index(i + 1, j + 1),
                index(i, j + 1),
            ];
            mesh.faces.extend(if (i + j) % 2 == 0 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            });
        }
    }
    mesh
}

/// The unit cube as twelve triangles.
pub fn cube() -> Mesh {
    let corner = |i: u32| DVec3::new((i & 1).into(), (i >> 1 & 1).into(), (i >> 2).into());
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let faces = quads
        .iter()
        .flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]);
    Mesh::new((0..8).map(corner).collect(), faces.collect())
}
