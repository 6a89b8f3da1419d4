//! Shapes for tests: analytic surfaces, rims of their meshes, and extraction.

use std::collections::{BTreeMap, HashSet};

use glam::DVec3;

use crate::extract::marching_cubes;
use crate::mesh::Mesh;
pub use crate::mesh::shapes::{grid, icosphere, punch};
use crate::sdf::Surface;

/// A pseudo-random sequence in [0, 1).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }
}

type Field = Box<dyn Fn(DVec3) -> f64 + Sync>;

/// The zero set of a function, and the mesh that determines which part belongs to the hole.
pub struct Analytic {
    pub field: Field,
    triangles: Vec<[DVec3; 3]>,
    rim: HashSet<(usize, usize)>,
}

impl Analytic {
    pub fn new(field: impl Fn(DVec3) -> f64 + Sync + 'static) -> Self {
        Self {
            field: Box::new(field),
            triangles: Vec::new(),
            rim: HashSet::new(),
        }
    }

    /// Sets the mesh and the rim loops of the hole.
    pub fn with_mesh(mut self, mesh: &Mesh, loops: &[Vec<u32>]) -> Self {
        self.triangles = mesh
            .faces
            .iter()
            .map(|f| f.map(|v| mesh.positions[v as usize]))
            .collect();
        let edges: HashSet<(u32, u32)> = loops
            .iter()
            .flat_map(|l| (0..l.len()).map(move |i| (l[(i + 1) % l.len()], l[i])))
            .collect();
        for (i, f) in mesh.faces.iter().enumerate() {
            for k in 0..3 {
                if edges.contains(&(f[k], f[(k + 1) % 3])) {
                    self.rim.insert((i, k));
                }
            }
        }
        self
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let e = 1e-5;
        let d = |u: DVec3| ((self.field)(p + e * u) - (self.field)(p - e * u)) / (2.0 * e);
        DVec3::new(d(DVec3::X), d(DVec3::Y), d(DVec3::Z))
    }
}

impl Surface for Analytic {
    fn project(&self, p: DVec3) -> Option<(DVec3, DVec3)> {
        let mut q = p;
        for _ in 0..30 {
            let g = self.gradient(q);
            let step = (self.field)(q) / g.length_squared();
            q -= step * g;
            if step.abs() * g.length() < 1e-12 {
                break;
            }
        }
        let n = self.gradient(q).normalize_or_zero();
        ((self.field)(q).abs() < 1e-6 && n != DVec3::ZERO).then_some((q, n))
    }

    fn depth(&self, p: DVec3) -> f64 {
        let mut best = (f64::INFINITY, false);
        for (i, t) in self.triangles.iter().enumerate() {
            let low = t[0].min(t[1]).min(t[2]);
            let high = t[0].max(t[1]).max(t[2]);
            if p.distance_squared(p.clamp(low, high)) > best.0 {
                continue;
            }
            let (q, edges) = closest(p, t);
            let d = p.distance_squared(q);
            if d < best.0 * (1.0 - 1e-12) {
                best = (d, edges.iter().any(|&k| self.rim.contains(&(i, k))));
            } else if d < best.0 * (1.0 + 1e-12) {
                best.1 |= edges.iter().any(|&k| self.rim.contains(&(i, k)));
            }
        }
        if best.1 {
            best.0.sqrt()
        } else {
            -best.0.sqrt()
        }
    }
}

/// The closest point of a triangle and the edges that contain it.
fn closest(p: DVec3, t: &[DVec3; 3]) -> (DVec3, Vec<usize>) {
    let n = (t[1] - t[0]).cross(t[2] - t[0]);
    let inside = (0..3).all(|k| (t[(k + 1) % 3] - t[k]).cross(p - t[k]).dot(n) >= 0.0);
    if inside && n != DVec3::ZERO {
        return (p - (p - t[0]).dot(n) / n.length_squared() * n, Vec::new());
    }
    let mut best = (f64::INFINITY, p, Vec::new());
    for k in 0..3 {
        let (a, d) = (t[k], t[(k + 1) % 3] - t[k]);
        let q = a + ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0) * d;
        let l = p.distance_squared(q);
        if l < best.0 * (1.0 - 1e-12) {
            best = (l, q, vec![k]);
        } else if l < best.0 * (1.0 + 1e-12) {
            best.2.push(k);
        }
    }
    (best.1, best.2)
}

/// The boundary loops, in the direction of a patch.
pub fn boundary_loops(mesh: &Mesh) -> Vec<Vec<u32>> {
    let edges: HashSet<(u32, u32)> = mesh
        .faces
        .iter()
        .flat_map(|f| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])])
        .collect();
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for f in &mesh.faces {
        for k in 0..3 {
            let (a, b) = (f[k], f[(k + 1) % 3]);
            if !edges.contains(&(b, a)) {
                next.entry(b).or_default().push(a);
            }
        }
    }
    let mut loops = Vec::new();
    while let Some((&start, _)) = next.iter().find(|(_, to)| !to.is_empty()) {
        let mut lp = vec![];
        let mut at = start;
        while let Some(to) = next.get_mut(&at).and_then(Vec::pop) {
            lp.push(at);
            at = to;
        }
        loops.push(lp);
    }
    loops
}

/// Moves the vertices randomly by up to `by`, and projects them back on the surface.
pub fn jitter(mesh: &mut Mesh, surface: &Analytic, by: f64, noise: &mut Noise) {
    for p in &mut mesh.positions {
        let moved = *p + by * noise.vector();
        *p = surface.project(moved).map_or(*p, |q| q.0);
    }
}

/// The zero set of the surface's function within a box, in world coordinates.
pub fn extract(surface: &Analytic, low: DVec3, high: DVec3, voxel: f64) -> Mesh {
    let count = ((high - low) / voxel).ceil();
    let [n, m, l] = [count.x as i32, count.y as i32, count.z as i32];
    let cells: Vec<[i32; 3]> = (0..l)
        .flat_map(|z| (0..m).flat_map(move |y| (0..n).map(move |x| [x, y, z])))
        .collect();
    let world = |p: DVec3| low + voxel * p;
    let iso = marching_cubes(&cells, |p| {
        (surface.field)(world(DVec3::new(p[0].into(), p[1].into(), p[2].into())))
    });
    Mesh::new(iso.positions.iter().map(|&p| world(p)).collect(), iso.faces)
}
