//! Parametric Willmore flow of a triangulated surface, the reference for the flow of graphs.
//!
//! Mixed formulation for the position x and the curvature vector y = Δ_Γ x, with linear elements and lumped mass (Rusu, "An algorithm
//! for the elastic flow of surfaces", Interfaces and Free Boundaries 7, 2005):
//!
//! `∫ y·ψ + ∫ ∇x:∇ψ = ∫_∂Γ μ·ψ`, `∫ ∂t x·ψ = ∫ (2 n⊗n − E) ∇y:∇ψ − ½ ∫ |y|² ∇x:∇ψ`.
//!
//! Vertices move along their normals ν only: the test functions ψ and the increments δ are multiples of ν. Tangential motion changes
//! the mesh but not the surface, and without this restriction it degrades the mesh in the long run. A step is semi-implicit. It solves
//! for the increment: `Nᵀ(M + τ/2 L1 + τ S M⁻¹ S)N s = τ Nᵀ F(x, y)`, with `L1 = L[|y|²]`, `δ = N s`, `(N s)_i = s_i ν_i`, on the free
//! vertices. For δ along the normal, `2 n⊗n − E` is the identity, so the system is symmetric, as in variant II of the level set flow.

use glam::DVec3;

use isomend_core::linalg::{Csr, Jacobi, LinearOperator, conjugate_gradient};
use isomend_core::mesh::{Mesh, half_cotangents};

/// A surface under parametric Willmore flow, with position and conormal held on its boundary.
#[doc(hidden)]
pub struct ParametricFlow {
    /// The surface.
    pub mesh: Mesh,
    /// Time step τ, in units of length⁴.
    pub tau: f64,
    free: Vec<bool>,
    /// `∫_∂Γ μ·ψ_i`.
    load: Vec<DVec3>,
    /// For each vertex its faces, with the vertex's corner in each.
    fans: Vec<Vec<(u32, u8)>>,
}

/// The record of one step.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct ParametricStep {
    /// Energy `½ Σ m_i |y_i|²` before the step.
    pub energy: f64,
    /// Largest displacement of a vertex.
    pub update: f64,
    /// Number of iterations of the linear solver.
    pub iterations: usize,
}

/// Element matrices, normals and areas of the faces, and the lumped mass of the vertices.
struct Geometry {
    /// `∫ ∇ψa·∇ψb` for (a, b) = (0, 1), (1, 2), (2, 0).
    cotangents: Vec<[f64; 3]>,
    normals: Vec<DVec3>,
    areas: Vec<f64>,
    mass: Vec<f64>,
}

impl ParametricFlow {
    /// A flow with time step `tau`. `conormal` gives the outward unit conormal on a boundary edge from its end points. Boundary
    /// vertices are fixed.
    pub fn new(mesh: Mesh, tau: f64, conormal: impl Fn(DVec3, DVec3) -> DVec3) -> Self {
        let n = mesh.positions.len();
        let mut fans = vec![Vec::new(); n];
        let mut edges = std::collections::HashSet::new();
        for (f, face) in mesh.faces.iter().enumerate() {
            for (corner, &v) in face.iter().enumerate() {
                fans[v as usize].push((f as u32, corner as u8));
                edges.insert((v, face[(corner + 1) % 3]));
            }
        }
        let (mut free, mut load) = (vec![true; n], vec![DVec3::ZERO; n]);
        // Face by face, so that the sums do not depend on the order of a hash table.
        for face in &mesh.faces {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                if !edges.contains(&(b, a)) {
                    let (p, q) = (mesh.positions[a as usize], mesh.positions[b as usize]);
                    let half = 0.5 * p.distance(q) * conormal(p, q);
                    for v in [a, b] {
                        free[v as usize] = false;
                        load[v as usize] += half;
                    }
                }
            }
        }
        Self {
            mesh,
            tau,
            free,
            load,
            fans,
        }
    }

    /// The energy `½ Σ m_i |y_i|²`.
    pub fn energy(&self) -> f64 {
        let geometry = self.geometry();
        let stiffness = self.matrix(&geometry.cotangents);
        energy_of(&self.curvature(&geometry, &stiffness), &geometry.mass)
    }

    /// Takes one step.
    pub fn step(&mut self) -> ParametricStep {
        let geometry = self.geometry();
        let stiffness = self.matrix(&geometry.cotangents);
        let y = self.curvature(&geometry, &stiffness);
        // L1: the stiffness of each face times the mean of |y|² at its corners.
        let square: Vec<f64> = y.iter().map(|y| y.length_squared()).collect();
        let weighted: Vec<[f64; 3]> = self
            .mesh
            .faces
            .iter()
            .zip(&geometry.cotangents)
            .map(|(face, c)| {
                let mean = face.iter().map(|&v| square[v as usize]).sum::<f64>() / 3.0;
                c.map(|c| mean * c)
            })
            .collect();
        let weighted = self.matrix(&weighted);
        // Right-hand side τ Nᵀ F.
        let force = self.force(&geometry, &y, &weighted);
        let normals = self.vertex_normals(&geometry);
        let b: Vec<f64> = force
            .iter()
            .zip(&normals)
            .map(|(f, n)| self.tau * f.dot(*n))
            .collect();
        let system = System {
            jacobi: jacobi(&self.free, &geometry.mass, &stiffness, &weighted, self.tau),
            free: &self.free,
            mass: &geometry.mass,
            normals: &normals,
            stiffness,
            weighted,
            tau: self.tau,
        };
        // Solve for the displacements s along the normals, and move the vertices.
        let mut shift = vec![0.0; b.len()];
        let scaling = Jacobi(system.jacobi());
        let end = conjugate_gradient(&system, &scaling, &b, &mut shift, 1e-7, 2000);
        for ((p, s), n) in self.mesh.positions.iter_mut().zip(&shift).zip(&normals) {
            *p += *s * *n;
        }
        ParametricStep {
            energy: energy_of(&y, &geometry.mass),
            update: shift.iter().fold(0.0, |m, s| m.max(s.abs())),
            iterations: end.iterations,
        }
    }

    fn geometry(&self) -> Geometry {
        let mut geometry = Geometry {
            cotangents: Vec::with_capacity(self.mesh.faces.len()),
            normals: Vec::with_capacity(self.mesh.faces.len()),
            areas: Vec::with_capacity(self.mesh.faces.len()),
            mass: vec![0.0; self.mesh.positions.len()],
        };
        for face in &self.mesh.faces {
            let p = face.map(|v| self.mesh.positions[v as usize]);
            let normal = (p[1] - p[0]).cross(p[2] - p[0]);
            let twice = normal.length();
            face.iter()
                .for_each(|&v| geometry.mass[v as usize] += twice / 6.0);
            // `∫ ∇ψa·∇ψb` over the face is minus half the cotangent of the angle opposite the edge from a to b.
            let [a, b, c] = half_cotangents(p, twice.max(f64::MIN_POSITIVE));
            geometry.cotangents.push([-c, -a, -b]);
            geometry.normals.push(normal.normalize_or_zero());
            geometry.areas.push(0.5 * twice);
        }
        geometry
    }

    /// Unit normals of the vertices: means of the face normals, weighted by area.
    fn vertex_normals(&self, geometry: &Geometry) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; self.fans.len()];
        for ((face, n), area) in self
            .mesh
            .faces
            .iter()
            .zip(&geometry.normals)
            .zip(&geometry.areas)
        {
            face.iter().for_each(|&v| sums[v as usize] += *area * *n);
        }
        sums.into_iter().map(DVec3::normalize_or_zero).collect()
    }

    /// The matrix with the given off-diagonal entries of each face, and rows that sum to zero.
    fn matrix(&self, entries: &[[f64; 3]]) -> Csr {
        let n = self.fans.len();
        Csr::from_rows(n, n, |v, sink| {
            for &(f, corner) in &self.fans[v] {
                let (face, e, a) = (
                    self.mesh.faces[f as usize],
                    entries[f as usize],
                    corner as usize,
                );
                let (after, before) = ((a + 1) % 3, (a + 2) % 3);
                sink.add(face[after], e[a]);
                sink.add(face[before], e[before]);
                sink.add(v as u32, -e[a] - e[before]);
            }
        })
    }

    /// The curvature vectors `y = M⁻¹ (∫_∂Γ μ·ψ − S x)`.
    fn curvature(&self, geometry: &Geometry, stiffness: &Csr) -> Vec<DVec3> {
        (0..self.fans.len())
            .map(|v| {
                let bent: DVec3 = stiffness
                    .row(v)
                    .map(|(j, s)| s * self.mesh.positions[j as usize])
                    .sum();
                (self.load[v] - bent) / geometry.mass[v]
            })
            .collect()
    }

    /// The force `∫ (2 n⊗n − E) ∇y:∇ψ − ½ ∫ |y|² ∇x:∇ψ` at the free vertices, zero at the others.
    fn force(&self, geometry: &Geometry, y: &[DVec3], weighted: &Csr) -> Vec<DVec3> {
        (0..y.len())
            .map(|v| {
                if !self.free[v] {
                    return DVec3::ZERO;
                }
                let mut sum = DVec3::ZERO;
                for &(f, corner) in &self.fans[v] {
                    let (f, a) = (f as usize, corner as usize);
                    let (face, e, n) = (
                        self.mesh.faces[f],
                        geometry.cotangents[f],
                        geometry.normals[f],
                    );
                    let (after, before) = ((a + 1) % 3, (a + 2) % 3);
                    let d = e[a] * (y[face[after] as usize] - y[v])
                        + e[before] * (y[face[before] as usize] - y[v]);
                    sum += 2.0 * n.dot(d) * n - d;
                }
                let pull: DVec3 = weighted
                    .row(v)
                    .map(|(j, w)| w * self.mesh.positions[j as usize])
                    .sum();
                sum - 0.5 * pull
            })
            .collect()
    }
}

fn energy_of(y: &[DVec3], mass: &[f64]) -> f64 {
    0.5 * y
        .iter()
        .zip(mass)
        .map(|(y, m)| m * y.length_squared())
        .sum::<f64>()
}

/// The system matrix `Nᵀ (M + τ/2 L1 + τ S M⁻¹ S) N` on the free vertices.
struct System<'a> {
    free: &'a [bool],
    mass: &'a [f64],
    normals: &'a [DVec3],
    stiffness: Csr,
    weighted: Csr,
    tau: f64,
    jacobi: Vec<f64>,
}

/// The inverse of the system's diagonal, on which unit normals have no influence.
fn jacobi(free: &[bool], mass: &[f64], stiffness: &Csr, weighted: &Csr, tau: f64) -> Vec<f64> {
    let second = weighted.diagonal();
    (0..mass.len())
        .map(|i| {
            let squares = stiffness.row(i).map(|(j, s)| s * s / mass[j as usize]);
            let d = mass[i] + tau * (0.5 * second[i] + squares.sum::<f64>());
            if free[i] { 1.0 / d } else { 0.0 }
        })
        .collect()
}

impl LinearOperator for System<'_> {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let n = x.len();
        let (mut bent, mut back, mut pull) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        y.fill(0.0);
        for k in 0..3 {
            let part: Vec<f64> = x.iter().zip(self.normals).map(|(x, n)| x * n[k]).collect();
            self.stiffness.apply(&part, &mut bent);
            bent.iter_mut().zip(self.mass).for_each(|(b, m)| *b /= m);
            self.stiffness.apply(&bent, &mut back);
            self.weighted.apply(&part, &mut pull);
            for i in 0..n {
                if self.free[i] {
                    let sum = self.mass[i] * part[i] + self.tau * (0.5 * pull[i] + back[i]);
                    y[i] += self.normals[i][k] * sum;
                }
            }
        }
    }

    fn jacobi(&self) -> &[f64] {
        &self.jacobi
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// An octahedron with each edge cut into `n` parts, projected to the unit sphere and stretched along z.
    fn ball(n: i32, stretch: f64) -> Mesh {
        let mut mesh = Mesh::default();
        let mut number = std::collections::HashMap::new();
        for signs in 0..8 {
            let s = [0, 1, 2].map(|k| if signs >> k & 1 == 0 { 1 } else { -1 });
            let mut at = |i: i32, j: i32| {
                let key = [i * s[0], j * s[1], (n - i - j) * s[2]];
                *number.entry(key).or_insert_with(|| {
                    let p = DVec3::from_array(key.map(f64::from)).normalize();
                    mesh.positions.push(DVec3::new(p.x, p.y, stretch * p.z));
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
            for mut face in faces {
                if s[0] * s[1] * s[2] < 0 {
                    face.swap(1, 2);
                }
                mesh.faces.push(face);
            }
        }
        mesh
    }

    #[test]
    fn an_ellipsoid_becomes_rounder_and_its_energy_falls_towards_that_of_a_sphere() {
        let mut flow = ParametricFlow::new(ball(8, 1.3), 2e-3, |_, _| DVec3::ZERO);
        let mut last = flow.energy();
        let spread = |mesh: &Mesh| {
            let lengths = mesh.positions.iter().map(|p| p.length());
            let (low, high) = lengths.fold((f64::MAX, 0.0f64), |(l, h), r| (l.min(r), h.max(r)));
            high / low
        };
        let before = (last, spread(&flow.mesh));
        for _ in 0..60 {
            flow.step();
            let energy = flow.energy();
            assert!(energy < last * (1.0 + 1e-9), "{energy} {last}");
            last = energy;
        }
        assert!(spread(&flow.mesh) < 1.0 + 0.5 * (before.1 - 1.0));
        assert!((last / (8.0 * PI) - 1.0).abs() < 0.03, "{last}");
        assert!(before.0 > 1.02 * last);
    }

    #[test]
    fn a_flat_sheet_stays() {
        let mut mesh = Mesh::default();
        for i in 0..5 {
            for j in 0..5 {
                let shift = 0.1 * f64::from((i * j) % 3 * i32::from(i % 4 != 0 && j % 4 != 0));
                mesh.positions
                    .push(DVec3::new(f64::from(i) + shift, f64::from(j), 0.0));
            }
        }
        for i in 0..4u32 {
            for j in 0..4 {
                let a = 5 * i + j;
                mesh.faces.extend([[a, a + 5, a + 6], [a, a + 6, a + 1]]);
            }
        }
        let outward = |p: DVec3, q: DVec3| (q - p).cross(DVec3::Z).normalize();
        let mut flow = ParametricFlow::new(mesh.clone(), 1.0, outward);
        let step = flow.step();
        assert!(step.energy < 1e-20 && step.update < 1e-10, "{step:?}");
    }
}
