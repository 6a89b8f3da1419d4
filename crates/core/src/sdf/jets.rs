//! Osculating jets: local polynomial graphs fitted to the vertices around a vertex.
//!
//! If voxels are smaller than edges, the facets of a mesh show in its distance field. A polynomial of low degree fitted to the
//! vertices (Cazals and Pouget, "Estimating differential quantities using polynomial fitting of osculating jets", 2005) follows
//! the sampled surface to third or fourth order in the edge length and averages noise.

use std::collections::VecDeque;

use glam::DVec3;

use crate::elementary::{exp, ln};
use crate::linalg::solve_spd;
use crate::mesh::{Mesh, VertexFaces, vertex_normal};

const MAX_DEGREE: usize = 4;
const MAX_TERMS: usize = terms(MAX_DEGREE);
/// Number of vertices wanted for a fit; further rings are added until it is reached.
const WANTED: usize = 19;
/// Number of vertices with which no vertex's neighbours are added any more.
const ENOUGH: usize = 120;
/// Maximum number of rings of vertices around a vertex to which its jet is fitted.
pub const JET_RINGS: usize = 5;
/// Newton's method for a foot point ends with a step this short, in radii of the neighbourhood. The remaining error is its
/// square, and the distance is stationary there.
const CONVERGED: f64 = 1e-5;
/// Faces whose normal has a cosine below this with the vertex normal belong to the other side of a crease.
const SAME_SIDE: f64 = 0.35;

const fn terms(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

/// Index of the coefficient of `uᵃ vᵇ`: by rising total degree.
const fn place(a: usize, b: usize) -> usize {
    (a + b) * (a + b + 1) / 2 + b
}

/// A polynomial graph `w(u, v)` over the tangent plane of a vertex.
#[derive(Clone, Debug)]
pub struct Jet {
    origin: DVec3,
    axes: [DVec3; 3],
    radius: f64,
    /// Zero for terms beyond the fitted degree.
    coefficients: [f64; MAX_TERMS],
    /// From 1 (the vertices are on a smooth graph) to 0 (they are not: crease, tip, noise).
    pub trust: f64,
}

/// Value, gradient and second derivatives of a polynomial at (u, v).
#[derive(Default)]
struct Graph {
    w: f64,
    wu: f64,
    wv: f64,
    wuu: f64,
    wuv: f64,
    wvv: f64,
}

fn powers(t: f64) -> [f64; MAX_DEGREE + 1] {
    let mut p = [1.0; MAX_DEGREE + 1];
    for i in 1..=MAX_DEGREE {
        p[i] = p[i - 1] * t;
    }
    p
}

/// Monomials `uᵃ vᵇ` in order of total degree.
fn monomials(u: f64, v: f64) -> [f64; MAX_TERMS] {
    let (pu, pv) = (powers(u), powers(v));
    let mut out = [0.0; MAX_TERMS];
    for d in 0..=MAX_DEGREE {
        for b in 0..=d {
            out[place(d - b, b)] = pu[d - b] * pv[b];
        }
    }
    out
}

impl Jet {
    /// Evaluates by Horner's rule: first the polynomials in `u` that are the coefficients of powers of `v`, then in `v`.
    fn graph(&self, u: f64, v: f64) -> Graph {
        let mut g = Graph::default();
        for b in (0..=MAX_DEGREE).rev() {
            // The coefficient of `vᵇ`, its derivative and half its second derivative.
            let (mut p, mut pu, mut puu) = (0.0, 0.0, 0.0);
            for a in (0..=MAX_DEGREE - b).rev() {
                puu = puu * u + pu;
                pu = pu * u + p;
                p = p * u + self.coefficients[place(a, b)];
            }
            g.wvv = g.wvv * v + g.wv;
            g.wv = g.wv * v + g.w;
            g.w = g.w * v + p;
            g.wuv = g.wuv * v + g.wu;
            g.wu = g.wu * v + pu;
            g.wuu = g.wuu * v + puu;
        }
        g.wuu *= 2.0;
        g.wvv *= 2.0;
        g
    }

    /// Signed distance of `x` from the graph in world units, positive on the side of the normal, by Newton's method on the
    /// squared distance. `None` if the foot point leaves the neighbourhood to which the graph was fitted.
    pub fn signed_distance(&self, x: DVec3) -> Option<f64> {
        // In the frame of the vertex, in radii of the neighbourhood; the initial foot (u, v) is the projection on the tangent
        // plane.
        let d = (x - self.origin) / self.radius;
        let p = [
            d.dot(self.axes[0]),
            d.dot(self.axes[1]),
            d.dot(self.axes[2]),
        ];
        let (mut u, mut v) = (p[0], p[1]);
        let limit = 1.3;
        let clamp = |u: &mut f64, v: &mut f64| {
            let r = (*u * *u + *v * *v).sqrt();
            if r > limit {
                *u *= limit / r;
                *v *= limit / r;
            }
        };
        clamp(&mut u, &mut v);
        let mut g = self.graph(u, v);
        for _ in 0..12 {
            // Newton's method for the minimum of ½ ((u − p₀)² + (v − p₁)² + (w − p₂)²): gradient and Hessian in u and v.
            let e = g.w - p[2];
            let (ru, rv) = (u - p[0] + e * g.wu, v - p[1] + e * g.wv);
            let mut h = [
                1.0 + g.wu * g.wu + e * g.wuu,
                g.wu * g.wv + e * g.wuv,
                1.0 + g.wv * g.wv + e * g.wvv,
            ];
            // If the Hessian is not safely positive definite, use the Gauss-Newton one, without second derivatives.
            if h[0] * h[2] - h[1] * h[1] < 0.1 || h[0] < 0.1 {
                h = [1.0 + g.wu * g.wu, g.wu * g.wv, 1.0 + g.wv * g.wv];
            }
            let det = h[0] * h[2] - h[1] * h[1];
            let (du, dv) = (
                -(h[2] * ru - h[1] * rv) / det,
                -(h[0] * rv - h[1] * ru) / det,
            );
            u += du;
            v += dv;
            clamp(&mut u, &mut v);
            g = self.graph(u, v);
            if du * du + dv * dv < CONVERGED * CONVERGED {
                break;
            }
        }
        // A foot at the limit is outside the neighbourhood.
        if (u * u + v * v).sqrt() >= limit * 0.999 {
            return None;
        }
        // Positive above the graph, in world units.
        let e = p[2] - g.w;
        let length = ((u - p[0]).powi(2) + (v - p[1]).powi(2) + e * e).sqrt();
        Some(length.copysign(e) * self.radius)
    }

    /// Unit normal of the graph at its origin.
    pub fn normal(&self) -> DVec3 {
        let g = self.graph(0.0, 0.0);
        (self.axes[2] - self.axes[0] * g.wu - self.axes[1] * g.wv).normalize()
    }
}

/// Fits a jet to the vertices around `vertex` by weighted least squares (Cazals and Pouget 2005). `None` if there are fewer than
/// seven, no degree can be fitted, or the vertex has no normal. `around` has the faces of each vertex of the mesh.
pub fn fit_jet(mesh: &Mesh, around: &VertexFaces, vertex: u32) -> Option<Jet> {
    let normal = vertex_normal(mesh, around, vertex);
    if normal == DVec3::ZERO {
        return None;
    }
    let neighbours = neighbourhood(mesh, around, vertex, normal);
    if neighbours.len() < 7 {
        return None;
    }
    // Samples in the tangent frame, in radii of the neighbourhood, with Gaussian weights.
    let origin = mesh.positions[vertex as usize];
    let (u, v) = normal.any_orthonormal_pair();
    let axes = [u, v, normal];
    let radius = neighbours
        .iter()
        .map(|&i| mesh.positions[i as usize].distance(origin))
        .fold(0.0, f64::max);
    let samples: Vec<[f64; 4]> = neighbours
        .iter()
        .map(|&i| {
            let d = (mesh.positions[i as usize] - origin) / radius;
            let weight = exp(-1.5 * d.length_squared());
            [d.dot(axes[0]), d.dot(axes[1]), d.dot(axes[2]), weight]
        })
        .collect();
    let (coefficients, deviation) = best_fit(&samples)?;
    let edge = mean_edge(mesh, around, vertex) / radius;
    Some(Jet {
        origin,
        axes,
        radius,
        coefficients,
        trust: (1.0 - (deviation / edge - 0.12) / 0.15).clamp(0.0, 1.0),
    })
}

/// The fit with the degree that minimises the Bayesian information criterion, and its deviation. Residuals below a millionth do
/// not count.
fn best_fit(samples: &[[f64; 4]]) -> Option<([f64; MAX_TERMS], f64)> {
    let n = samples.iter().map(|s| s[3]).sum::<f64>();
    let count = samples.len() as f64;
    let equations = NormalEquations::new(samples);
    let mut best: Option<(f64, [f64; MAX_TERMS], f64)> = None;
    for degree in 1..=MAX_DEGREE {
        let p = terms(degree);
        if samples.len() < p + p / 3 {
            break;
        }
        let Some(c) = equations.solved(p) else {
            continue;
        };
        let residual = |(s, m): (&[f64; 4], &[f64; MAX_TERMS])| {
            let w: f64 = m[..p].iter().zip(&c).map(|(a, b)| a * b).sum();
            s[3] * (s[2] - w).powi(2)
        };
        let rss: f64 = samples.iter().zip(&equations.rows).map(residual).sum();
        let variance = rss / n;
        let criterion = count * ln(variance + 1e-12) + p as f64 * ln(count);
        let deviation = (variance * count / (count - p as f64).max(1.0)).sqrt();
        if best.as_ref().is_none_or(|b| criterion < b.0) {
            best = Some((criterion, c, deviation));
        }
    }
    best.map(|b| (b.1, b.2))
}

/// The normal equations of a weighted fit; a fit of lower degree uses their leading part.
struct NormalEquations {
    /// The monomials of each sample.
    rows: Vec<[f64; MAX_TERMS]>,
    matrix: [[f64; MAX_TERMS]; MAX_TERMS],
    right: [f64; MAX_TERMS],
}

impl NormalEquations {
    fn new(samples: &[[f64; 4]]) -> Self {
        let rows: Vec<_> = samples.iter().map(|s| monomials(s[0], s[1])).collect();
        let mut matrix = [[0.0; MAX_TERMS]; MAX_TERMS];
        let mut right = [0.0; MAX_TERMS];
        for (s, m) in samples.iter().zip(&rows) {
            for i in 0..MAX_TERMS {
                let weighted = s[3] * m[i];
                // The whole row, which is faster than only the lower half.
                for (a, m) in matrix[i].iter_mut().zip(m) {
                    *a += weighted * m;
                }
                right[i] += weighted * s[2];
            }
        }
        Self {
            rows,
            matrix,
            right,
        }
    }

    /// The solution with the first `terms` terms.
    fn solved(&self, terms: usize) -> Option<[f64; MAX_TERMS]> {
        let mut a = [0.0; MAX_TERMS * MAX_TERMS];
        let a = &mut a[..terms * terms];
        for (i, row) in a.chunks_exact_mut(terms).enumerate() {
            row.copy_from_slice(&self.matrix[i][..terms]);
            row[i] += 1e-10 * self.matrix[0][0];
        }
        let mut c = [0.0; MAX_TERMS];
        c[..terms].copy_from_slice(&self.right[..terms]);
        solve_spd(a, &mut c[..terms]).then_some(c)
    }
}

/// Vertices around `vertex`, ring by ring until there are enough, on this side of creases.
fn neighbourhood(mesh: &Mesh, around: &VertexFaces, vertex: u32, normal: DVec3) -> Vec<u32> {
    let mut found = vec![vertex];
    let mut queue = VecDeque::from([(vertex, 0)]);
    while let Some((v, ring)) = queue.pop_front() {
        if ring >= JET_RINGS || (ring >= 2 && found.len() >= WANTED) {
            break;
        }
        for &f in around.of(v) {
            // Of a fan with more faces, a part decides.
            if found.len() > 2 * ENOUGH {
                return found;
            }
            if crate::mesh::face_normal(mesh, f).dot(normal) < SAME_SIDE {
                continue;
            }
            for &w in &mesh.faces[f as usize] {
                if !found.contains(&w) {
                    found.push(w);
                    queue.push_back((w, ring + 1));
                }
            }
        }
        if found.len() > ENOUGH {
            break;
        }
    }
    found
}

fn mean_edge(mesh: &Mesh, around: &VertexFaces, vertex: u32) -> f64 {
    let p = mesh.positions[vertex as usize];
    let (mut sum, mut count) = (0.0, 0.0);
    for &f in around.of(vertex) {
        for &w in &mesh.faces[f as usize] {
            if w != vertex {
                sum += mesh.positions[w as usize].distance(p);
                count += 1.0;
            }
        }
    }
    sum / f64::max(count, 1.0)
}
