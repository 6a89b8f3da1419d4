//! Comparison of two meshes: distances both ways, normals, Willmore energy, and which vertices and faces of the first are kept in the
//! second.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

use crate::elementary::angle_between;
use crate::mesh::{Mesh, area_vector, face_normal, half_cotangents};
use crate::spatial::Bvh;
use crate::threads::CollectIndexed;

/// Upper bound of the number of samples on a mesh.
pub const MOST_SAMPLES: usize = crate::parameters::tables::MOST_SAMPLES;
/// Number of samples that are measured at a time; they take about 50 MB.
const CHUNK: usize = 1 << 20;

/// Why two meshes cannot be compared.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CompareError {
    /// The number of samples is 0 or above [`MOST_SAMPLES`].
    #[error("the number of samples must lie between 1 and {MOST_SAMPLES}, but is {0}")]
    Samples(usize),
    /// A mesh has no face with an area.
    #[error("the {which} mesh has no face with an area, so there is nothing to measure from or to")]
    Empty {
        /// `first` or `second`.
        which: &'static str,
    },
}

/// The comparison of two meshes A and B.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Comparison {
    /// The first mesh.
    pub a: SurfaceFacts,
    /// The second mesh.
    pub b: SurfaceFacts,
    /// From samples of A to the closest points of B.
    pub a_to_b: Distances,
    /// From samples of B to the closest points of A.
    pub b_to_a: Distances,
    /// Vertices and faces of A that are in B.
    pub kept: KeptPart,
}

/// Counts, area and Willmore energy of one mesh.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct SurfaceFacts {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Area in the mesh's units squared.
    pub area: f64,
    /// `½ ∫ h² dA` with h the sum of the principal curvatures, over the inner vertices: 8π for a sphere.
    pub willmore_energy: f64,
    /// Number of vertices on boundary or non-manifold edges; they have no curvature vector.
    pub boundary_vertices: usize,
}

/// Distances from samples of one mesh to another, in the meshes' units.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Distances {
    /// Number of samples, spread evenly over the area.
    pub samples: usize,
    /// Largest distance of a sample or a vertex.
    pub max: f64,
    /// Position of the sample or vertex with the largest distance.
    pub max_at: DVec3,
    /// Root mean square distance of the samples.
    pub rms: f64,
    /// Mean distance of the samples.
    pub mean: f64,
    /// Mean angle between the faces' normals at a sample and at its closest point, in degrees.
    pub normal_mean: f64,
    /// Largest of these angles, in degrees.
    pub normal_max: f64,
}

/// Numbers of vertices and faces of A that are in B, bit for bit.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct KeptPart {
    /// Vertices of A at the exact position of a vertex of B.
    pub vertices: usize,
    /// Leading vertices of A that have the same number and position in B.
    pub vertices_in_order: usize,
    /// Faces of A with the same corner positions and the same orientation as a face of B.
    pub faces: usize,
    /// Leading faces of A that have the same number and the same vertex numbers in B.
    pub faces_in_order: usize,
}

/// Compares two meshes by `samples` samples on each.
///
/// # Errors
/// When a mesh has no face with an area, or `samples` is 0 or above [`MOST_SAMPLES`].
pub fn compare(a: &Mesh, b: &Mesh, samples: usize) -> Result<Comparison, CompareError> {
    if !(1..=MOST_SAMPLES).contains(&samples) {
        return Err(CompareError::Samples(samples));
    }
    let facts = |mesh: &Mesh, which| {
        let facts = surface_facts(mesh);
        if facts.area > 0.0 {
            Ok(facts)
        } else {
            Err(CompareError::Empty { which })
        }
    };
    Ok(Comparison {
        a: facts(a, "first")?,
        b: facts(b, "second")?,
        a_to_b: distances(a, b, samples),
        b_to_a: distances(b, a, samples),
        kept: kept(a, b),
    })
}

fn twice_area(mesh: &Mesh, face: &[u32; 3]) -> f64 {
    area_vector(face.map(|v| mesh.positions[v as usize])).length()
}

fn surface_facts(mesh: &Mesh) -> SurfaceFacts {
    let (energy, boundary) = willmore_energy(mesh);
    SurfaceFacts {
        vertices: mesh.positions.len(),
        faces: mesh.faces.len(),
        area: 0.5 * mesh.faces.iter().map(|f| twice_area(mesh, f)).sum::<f64>(),
        willmore_energy: energy,
        boundary_vertices: boundary,
    }
}

/// `½ Σ |K_i|² A_i` over the inner vertices, with the cotangent curvature vector `K_i` and the mixed Voronoi area `A_i`
/// (Meyer, Desbrun, Schröder, Barr 2003); and the number of vertices on boundary or non-manifold edges.
fn willmore_energy(mesh: &Mesh) -> (f64, usize) {
    let n = mesh.positions.len();
    let (mut bent, mut area) = (vec![DVec3::ZERO; n], vec![0.0; n]);
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    // Accumulate the integrated curvature vector and the area of each vertex, and count the faces of each edge.
    for face in &mesh.faces {
        let p = face.map(|v| mesh.positions[v as usize]);
        let twice = twice_area(mesh, face);
        let cotangents = half_cotangents(p, twice);
        for k in 0..3 {
            let (i, j, l) = (k, (k + 1) % 3, (k + 2) % 3);
            let (a, b) = (face[i], face[j]);
            *edges.entry((a.min(b), a.max(b))).or_default() += 1;
            if twice <= 0.0 {
                continue;
            }
            // The angle opposite the edge from i to j is at corner l.
            let pull = cotangents[l] * (p[j] - p[i]);
            bent[a as usize] += pull;
            bent[b as usize] -= pull;
            area[a as usize] += mixed_area(p[i], p[j], p[l], twice);
        }
    }
    // Exclude vertices on edges that do not have exactly two faces.
    let mut is_boundary = vec![false; n];
    for (&(a, b), &count) in &edges {
        if count != 2 {
            is_boundary[a as usize] = true;
            is_boundary[b as usize] = true;
        }
    }
    let energy = (0..n)
        .filter(|&v| !is_boundary[v] && area[v] > 0.0)
        .map(|v| 0.5 * bent[v].length_squared() / area[v])
        .sum();
    (energy, is_boundary.iter().filter(|b| **b).count())
}

/// The part of a triangle's mixed Voronoi area at its corner `p`; `twice` is twice the triangle's area.
fn mixed_area(p: DVec3, q: DVec3, r: DVec3, twice: f64) -> f64 {
    let at_p = (q - p).dot(r - p);
    let at_q = (p - q).dot(r - q);
    let at_r = (p - r).dot(q - r);
    if at_p < 0.0 {
        return 0.25 * twice;
    }
    if at_q < 0.0 || at_r < 0.0 {
        return 0.125 * twice;
    }
    0.125 * ((r - p).length_squared() * at_q + (q - p).length_squared() * at_r) / twice
}

/// A point on a face.
struct Sample {
    point: DVec3,
    face: u32,
}

/// Visits `count` points at equal steps of the accumulated area, face by face. Inside a face they follow a low-discrepancy sequence.
fn spread(mesh: &Mesh, count: usize, mut visit: impl FnMut(Sample)) {
    let total: f64 = mesh.faces.iter().map(|f| twice_area(mesh, f)).sum();
    let step = total / count as f64;
    let mut number = 0usize;
    let (mut passed, mut next) = (0.0, 0.5 * step);
    for (f, face) in mesh.faces.iter().enumerate() {
        let [p, q, r] = face.map(|v| mesh.positions[v as usize]);
        passed += twice_area(mesh, face);
        while next < passed {
            let k = number as f64;
            // Roberts' R2 sequence in the unit square, folded into the triangle.
            let (mut u, mut v) = (
                (0.5 + 0.754_877_666_246_693 * k).fract(),
                (0.5 + 0.569_840_290_998_053 * k).fract(),
            );
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            visit(Sample {
                point: p + u * (q - p) + v * (r - p),
                face: f as u32,
            });
            number += 1;
            next += step;
        }
    }
}

/// Sums over samples, in their order.
#[derive(Default)]
struct Sums {
    samples: usize,
    distance: f64,
    squared: f64,
    angle: f64,
    angles: usize,
    largest_angle: f64,
    max: f64,
    max_at: DVec3,
}

impl Sums {
    fn update_max(&mut self, point: DVec3, distance: f64) {
        if distance > self.max {
            (self.max, self.max_at) = (distance, point);
        }
    }

    /// Measures samples in parallel, adds the results in order, so that the sums do not depend on the threads, and drops the samples.
    fn take(
        &mut self,
        samples: &mut Vec<Sample>,
        measure: impl Fn(&Sample) -> (f64, f64) + Send + Sync,
    ) {
        let measured: Vec<(f64, f64)> = samples.par_iter().map(measure).collect_indexed();
        for (sample, (distance, angle)) in samples.drain(..).zip(measured) {
            self.samples += 1;
            self.distance += distance;
            self.squared += distance * distance;
            self.update_max(sample.point, distance);
            // A face without area has no normal.
            if angle.is_finite() {
                self.angle += angle;
                self.angles += 1;
                self.largest_angle = self.largest_angle.max(angle);
            }
        }
    }
}

fn distances(from: &Mesh, to: &Mesh, count: usize) -> Distances {
    let bvh = Bvh::new(to, 0..to.faces.len() as u32);
    let measure = |s: &Sample| {
        let Some(foot) = bvh.closest(s.point, f64::INFINITY) else {
            return (f64::NAN, f64::NAN);
        };
        let angle = angle_between(face_normal(from, s.face), face_normal(to, foot.face));
        (foot.distance, angle.to_degrees())
    };
    let mut sums = Sums::default();
    let mut samples = Vec::with_capacity(count.min(CHUNK));
    spread(from, count, |sample| {
        samples.push(sample);
        if samples.len() == CHUNK {
            sums.take(&mut samples, measure);
        }
    });
    sums.take(&mut samples, measure);
    // The maximum also takes the vertices, since the farthest point of a polyhedron is often a vertex.
    let used: HashSet<u32> = from.faces.iter().flatten().copied().collect();
    let mut corners: Vec<u32> = used.into_iter().collect();
    corners.sort_unstable();
    let at_corners: Vec<f64> = corners
        .par_iter()
        .map(|&v| {
            let foot = bvh.closest(from.positions[v as usize], f64::INFINITY);
            foot.map_or(f64::NAN, |f| f.distance)
        })
        .collect_indexed();
    for (v, distance) in corners.into_iter().zip(at_corners) {
        sums.update_max(from.positions[v as usize], distance);
    }
    let n = sums.samples.max(1) as f64;
    Distances {
        samples: sums.samples,
        max: sums.max,
        max_at: sums.max_at,
        rms: (sums.squared / n).sqrt(),
        mean: sums.distance / n,
        normal_mean: sums.angle / sums.angles.max(1) as f64,
        normal_max: sums.largest_angle,
    }
}

type Bits = [u64; 3];

fn bits(p: DVec3) -> Bits {
    p.to_array().map(f64::to_bits)
}

/// The corner positions of a face, rotated to the smallest of the three orders.
fn face_bits(mesh: &Mesh, face: &[u32; 3]) -> [Bits; 3] {
    let corners = face.map(|v| bits(mesh.positions[v as usize]));
    let [a, b, c] = corners;
    [[a, b, c], [b, c, a], [c, a, b]]
        .into_iter()
        .min()
        .unwrap_or(corners)
}

fn kept(a: &Mesh, b: &Mesh) -> KeptPart {
    let places: HashSet<Bits> = b.positions.iter().map(|&p| bits(p)).collect();
    let faces: HashSet<[Bits; 3]> = b.faces.iter().map(|f| face_bits(b, f)).collect();
    let same_places = a.positions.iter().zip(&b.positions);
    let same_faces = a.faces.iter().zip(&b.faces);
    KeptPart {
        vertices: a
            .positions
            .iter()
            .filter(|&&p| places.contains(&bits(p)))
            .count(),
        vertices_in_order: same_places
            .take_while(|(p, q)| bits(**p) == bits(**q))
            .count(),
        faces: a
            .faces
            .iter()
            .filter(|f| faces.contains(&face_bits(a, f)))
            .count(),
        faces_in_order: same_faces.take_while(|(f, g)| f == g).count(),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_mesh_is_all_kept_in_itself() {
        let mesh = shapes::icosphere(3);
        let same = compare(&mesh, &mesh, 2000).expect("a comparison");
        assert!(same.a_to_b.max < 1e-12 && same.a_to_b.normal_mean < 1e-5);
        let (vertices, faces) = (mesh.positions.len(), mesh.faces.len());
        let all = KeptPart {
            vertices,
            vertices_in_order: vertices,
            faces,
            faces_in_order: faces,
        };
        assert_eq!(same.kept, all);
    }

    #[test]
    fn parallel_squares_are_as_far_apart_as_they_are() {
        let square = |z: f64, flip: bool| {
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let positions = corners.map(|[x, y]| DVec3::new(x, y, z)).to_vec();
            let faces = vec![[0, 1, 2], [0, 2, 3]];
            let turned = faces
                .iter()
                .map(|f: &[u32; 3]| [f[0], f[2], f[1]])
                .collect();
            Mesh::new(positions, if flip { turned } else { faces })
        };
        let c = compare(&square(0.0, false), &square(0.25, true), 1000).expect("a comparison");
        for d in [&c.a_to_b, &c.b_to_a] {
            assert_eq!(d.samples, 1000);
            for x in [d.max, d.rms, d.mean] {
                assert!((x - 0.25).abs() < 1e-12, "{d:?}");
            }
            assert!((d.normal_mean - 180.0).abs() < 1e-6);
        }
        assert_eq!(c.kept, KeptPart::default());
        assert_eq!((c.a.boundary_vertices, c.a.willmore_energy), (4, 0.0));
        assert!((c.a.area - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_energy_of_a_sphere_is_8_pi() {
        let fine = surface_facts(&shapes::icosphere(4));
        assert!(
            (fine.willmore_energy / (8.0 * PI) - 1.0).abs() < 0.02,
            "{fine:?}"
        );
    }

    #[test]
    fn samples_are_bounded_and_measured_in_chunks() {
        let mesh = shapes::icosphere(1);
        for wrong in [0, MOST_SAMPLES + 1, usize::MAX] {
            let refused = compare(&mesh, &mesh, wrong);
            assert!(matches!(refused, Err(CompareError::Samples(n)) if n == wrong));
        }
        // More than fit into one chunk: none is lost or counted twice.
        let samples = CHUNK + 1000;
        let same = compare(&mesh, &mesh, samples).expect("a comparison");
        assert_eq!(same.a_to_b.samples, samples);
        assert!(same.a_to_b.rms < 1e-12);
    }

    #[test]
    fn a_mesh_without_area_is_refused() {
        let mesh = shapes::icosphere(1);
        assert!(matches!(
            compare(&mesh, &Mesh::default(), 10),
            Err(CompareError::Empty { which: "second" })
        ));
    }
}
