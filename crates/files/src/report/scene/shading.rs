//! Vertex normals and mean curvature of a mesh, for drawing.

use glam::{DVec3, Vec3};

use isomend_core::mesh::Mesh;

/// Number of averaging passes of the curvature; each adds one ring of neighbours.
const RINGS: usize = 2;

/// Normals and curvatures of vertices.
pub struct Shading {
    /// Unit normals; zero at vertices without faces.
    pub normals: Vec<Vec3>,
    /// Sum of the principal curvatures.
    pub curvature: Vec<f32>,
}

impl Shading {
    /// Normals weighted by area. The curvature is the cotangent curvature vector, projected onto the normal, summed over a vertex's
    /// neighbourhood and divided by its area. Boundary vertices have no curvature vector: they only receive the values of their neighbours.
    pub fn new(mesh: &Mesh) -> Self {
        let n = mesh.positions.len();
        // Sums over the faces at each vertex: normals, curvature vector, a third of the area, and the opposite edges.
        let (mut normals, mut bent) = (vec![DVec3::ZERO; n], vec![DVec3::ZERO; n]);
        let (mut area, mut turned) = (vec![0.0; n], vec![DVec3::ZERO; n]);
        for face in &mesh.faces {
            let p = face.map(|v| mesh.positions[v as usize]);
            let cross = (p[1] - p[0]).cross(p[2] - p[0]);
            let twice = cross.length();
            for k in 0..3 {
                let (i, j, l) = (k, (k + 1) % 3, (k + 2) % 3);
                let (a, b) = (face[i] as usize, face[j] as usize);
                normals[a] += cross;
                area[a] += twice / 6.0;
                // Around an interior vertex the opposite edges form a closed loop, so their sum is zero.
                turned[a] += p[l] - p[j];
                // Half the cotangent of the angle at corner l, times the opposite edge; degenerate faces are skipped.
                let at_l = (p[i] - p[l], p[j] - p[l]);
                if twice > 1e-9 * at_l.0.length() * at_l.1.length() {
                    let pull = 0.5 * at_l.0.dot(at_l.1) / twice * (p[j] - p[i]);
                    bent[a] += pull;
                    bent[b] -= pull;
                }
            }
        }
        let normals: Vec<DVec3> = normals.iter().map(|n| n.normalize_or_zero()).collect();
        let mut total: Vec<f64> = bent.iter().zip(&normals).map(|(b, n)| -b.dot(*n)).collect();
        // Boundary vertices do not contribute.
        for v in 0..n {
            if turned[v].length_squared() > 1e-12 * area[v] {
                (total[v], area[v]) = (0.0, 0.0);
            }
        }
        for _ in 0..RINGS {
            (total, area) = (spread(mesh, &total), spread(mesh, &area));
        }
        let mean = |(t, a): (&f64, &f64)| if *a > 0.0 { (t / a) as f32 } else { 0.0 };
        Self {
            curvature: total.iter().zip(&area).map(mean).collect(),
            normals: normals.iter().map(|n| n.as_vec3()).collect(),
        }
    }

    /// Appends a vertex of another mesh.
    pub fn push(&mut self, other: &Self, vertex: u32) {
        self.normals.push(other.normals[vertex as usize]);
        self.curvature.push(other.curvature[vertex as usize]);
    }
}

/// For each vertex, the sum of twice its value and of its neighbours' values. A neighbour counts once per common face: twice across an
/// interior edge.
fn spread(mesh: &Mesh, values: &[f64]) -> Vec<f64> {
    let mut sums: Vec<f64> = values.iter().map(|v| 2.0 * v).collect();
    for &[a, b, c] in &mesh.faces {
        let [a, b, c] = [a, b, c].map(|v| v as usize);
        sums[a] += values[b] + values[c];
        sums[b] += values[c] + values[a];
        sums[c] += values[a] + values[b];
    }
    sums
}
