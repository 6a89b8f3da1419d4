//! The collar of a rim: the faces around it, with normals smoothed except across creases.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::rings::rings_of;
use crate::cancel::Cancel;
use crate::elementary::exp;
use crate::mesh::{Mesh, Part, VertexFaces, area_vector};
use crate::tuning::{Tunable, tunable};

/// Minimum and maximum width of the collar in which creases are searched, in rings of faces.
const RINGS: [f64; 2] = [6.0, 14.0];
/// Width of that collar between the bounds, in diameters of the hole.
const WIDTH: Tunable<f64> = tunable("creases.collar.width", 0.5);
/// Passes of the bilateral filter of normals.
const SMOOTHINGS: Tunable<usize> = tunable("creases.collar.smoothings", 10);
/// Width of the filter's weight exp(−(1 − n·n′)/width): normals that differ by more than 30° hardly influence each other.
const SMOOTHING_WIDTH: Tunable<f64> = tunable("creases.collar.smoothing_width", 0.12);
/// Number that stands for "no face".
const NONE: u32 = u32::MAX;

/// Width in rings of the collar in which creases are searched. `across` is the hole's diameter in edges.
pub(super) fn rings(across: f64) -> u32 {
    (WIDTH.get() * across).clamp(RINGS[0], RINGS[1]) as u32
}

/// Some rings of faces around a rim. Positions are relative to the centroid of the rim.
pub(super) struct Collar {
    /// Positions of the vertices.
    positions: Vec<DVec3>,
    /// The centroid of the rim, which was subtracted from positions.
    pub(super) origin: DVec3,
    /// Faces with indices into `positions`.
    faces: Vec<[u32; 3]>,
    /// The ring of each face, from 0 at the rim.
    pub(super) ring: Vec<u32>,
    pub(super) areas: Vec<f64>,
    /// Unit normals of faces.
    pub(super) normals: Vec<DVec3>,
    /// Unit normals of faces after the bilateral filter, which preserves creases.
    pub(super) smoothed: Vec<DVec3>,
    /// For each face the faces across its edges; `u32::MAX` for none.
    pub(super) adjacent: Vec<[u32; 3]>,
    /// The rim's vertices (numbers in the mesh), in the direction in which a patch uses its edges.
    pub(super) rim: Vec<u32>,
    /// Positions of the rim's vertices.
    rim_points: Vec<DVec3>,
    /// Indices of the rim's vertices into `positions`.
    rim_local: Vec<u32>,
    is_on_rim: Vec<bool>,
    around: VertexFaces,
    /// For each edge of the rim, `rim[i] → rim[i + 1]`, the face next to it.
    pub(super) beyond: Vec<u32>,
    /// Largest distance between two vertices of the rim.
    pub(super) diameter: f64,
    /// Mean edge length of the rim.
    pub(super) rim_edge: f64,
    /// Median edge length of the collar.
    pub(super) edge: f64,
    /// Stops the smoothing of normals and the search for sides and planes.
    pub(super) cancel: Cancel,
}

impl Collar {
    /// The collar of a rim. `None` if an edge of the rim has no face next to it, or a mean length is zero. `rings` maps the
    /// hole's diameter in edges to the width in rings.
    pub(super) fn new(
        mesh: &Mesh,
        around: &VertexFaces,
        rim: &[u32],
        rings: impl Fn(f64) -> u32,
        cancel: &Cancel,
    ) -> Option<Self> {
        // Rim and lengths.
        let count = rim.len();
        let at = |v: u32| mesh.positions[v as usize];
        let origin = rim.iter().map(|&v| at(v)).sum::<DVec3>() / count as f64;
        let rim_points: Vec<DVec3> = rim.iter().map(|&v| at(v) - origin).collect();
        let edges = (0..count).map(|i| rim_points[i].distance(rim_points[(i + 1) % count]));
        let rim_edge = edges.sum::<f64>() / count as f64;
        let diameter = diameter(&rim_points);
        // Faces of the collar, with local numbers.
        let (list, ring) = rings_of(mesh, around, rim, rings(diameter / rim_edge));
        let part = Part::new(mesh, &list, rim.iter().copied());
        let positions: Vec<DVec3> = part.mesh.positions.iter().map(|p| *p - origin).collect();
        let faces = part.mesh.faces.clone();
        let rim_local: Vec<u32> = rim.iter().map(|&v| part.local(v)).collect();
        let vectors = faces
            .iter()
            .map(|f| area_vector(f.map(|v| positions[v as usize])));
        let vectors: Vec<DVec3> = vectors.collect();
        let (adjacent, beyond) = neighbours(&part, rim);
        let length = |a: u32, b: u32| positions[a as usize].distance(positions[b as usize]);
        let lengths = faces
            .iter()
            .flat_map(|&[a, b, c]| [length(a, b), length(b, c), length(c, a)]);
        let mut lengths: Vec<f64> = lengths.collect();
        let mut collar = Self {
            origin,
            areas: vectors.iter().map(|v| v.length()).collect(),
            normals: vectors.iter().map(|v| v.normalize_or_zero()).collect(),
            smoothed: Vec::new(),
            adjacent,
            rim: rim.to_vec(),
            rim_points,
            is_on_rim: on_rim(positions.len(), &rim_local),
            rim_local,
            around: VertexFaces::new(&part.mesh),
            beyond: beyond?,
            diameter,
            rim_edge,
            edge: median(&mut lengths),
            faces,
            ring,
            positions,
            cancel: cancel.clone(),
        };
        collar.smoothed = collar.smooth();
        (collar.edge > 0.0 && rim_edge > 0.0).then_some(collar)
    }

    /// Number of vertices.
    pub(super) fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Position of a vertex.
    pub(super) fn position(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize]
    }

    /// Number of faces.
    pub(super) fn len(&self) -> usize {
        self.faces.len()
    }

    /// Face normals after the bilateral filter (Tomasi and Manduchi 1998, applied to the faces of a mesh).
    fn smooth(&self) -> Vec<DVec3> {
        let mut normals = self.normals.clone();
        for _ in 0..SMOOTHINGS.get() {
            if self.cancel.is_cancelled() {
                break;
            }
            let of = |f: usize| {
                let own = normals[f];
                let sum = self.across(f).fold(own, |sum, g| {
                    let other = normals[g];
                    sum + other * exp(-(1.0 - own.dot(other)) / SMOOTHING_WIDTH.get())
                });
                sum.normalize_or_zero()
            };
            normals = (0..self.faces.len()).map(of).collect();
        }
        normals
    }

    /// The faces across the edges of a face.
    pub(super) fn across(&self, face: usize) -> impl Iterator<Item = usize> {
        let adjacent = self.adjacent[face].into_iter();
        adjacent.filter(|g| *g != NONE).map(|g| g as usize)
    }

    /// Positions of a face's corners.
    pub(super) fn corners(&self, face: usize) -> [DVec3; 3] {
        self.faces[face].map(|v| self.positions[v as usize])
    }

    /// Middle of a face.
    pub(super) fn middle(&self, face: usize) -> DVec3 {
        self.corners(face).iter().sum::<DVec3>() / 3.0
    }

    /// Positions of at most `most` vertices of the innermost `rings` rings, evenly selected.
    pub(super) fn samples(&self, most: usize, rings: u32) -> Vec<DVec3> {
        let near = self
            .faces
            .iter()
            .zip(&self.ring)
            .filter(|(_, r)| **r < rings);
        let mut near: Vec<u32> = near.flat_map(|(f, _)| *f).collect();
        near.sort_unstable();
        near.dedup();
        let step = near.len().div_ceil(most.max(1)).max(1);
        near.iter()
            .step_by(step)
            .map(|&v| self.positions[v as usize])
            .collect()
    }

    /// Positions of the vertices of some faces, and their unit normals weighted by the areas of these faces; in rising order of
    /// vertices.
    pub(super) fn vertices(&self, faces: &[usize]) -> (Vec<DVec3>, Vec<DVec3>) {
        let mut corners: Vec<(u32, u32)> = faces
            .iter()
            .flat_map(|&f| self.faces[f].map(|v| (v, f as u32)))
            .collect();
        corners.sort_unstable();
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        for of_vertex in corners.chunk_by(|a, b| a.0 == b.0) {
            let normal = |&(_, f): &(u32, u32)| self.normals[f as usize] * self.areas[f as usize];
            points.push(self.positions[of_vertex[0].0 as usize]);
            normals.push(
                of_vertex
                    .iter()
                    .map(normal)
                    .sum::<DVec3>()
                    .normalize_or_zero(),
            );
        }
        (points, normals)
    }

    /// Positions of the vertices of some faces, innermost rings first.
    pub(super) fn points_from_rim(&self, faces: &[usize]) -> Vec<DVec3> {
        let corners = faces
            .iter()
            .flat_map(|&f| self.faces[f].map(|v| (v, self.ring[f])));
        let mut corners: Vec<(u32, u32)> = corners.collect();
        corners.sort_unstable();
        corners.dedup_by_key(|c| c.0);
        corners.sort_by_key(|c| c.1);
        corners.iter().map(|c| self.position(c.0)).collect()
    }

    /// The faces of a vertex.
    pub(super) fn around(&self, vertex: u32) -> &[u32] {
        self.around.of(vertex)
    }

    /// A face's corners as indices into `positions`.
    pub(super) fn corners_of(&self, face: u32) -> [u32; 3] {
        self.faces[face as usize]
    }

    /// The largest distance to rim vertex `at` among vertices that are connected to it through vertices for which `holds` is
    /// true.
    pub(super) fn reach(&self, at: usize, holds: impl Fn(u32) -> bool) -> f64 {
        let first = self.rim_points[at];
        let mut is_seen = vec![false; self.positions.len()];
        let mut front: Vec<u32> = vec![self.rim_local[at]];
        let mut far = 0.0;
        while let Some(v) = front.pop() {
            for &f in self.around(v) {
                for w in self.faces[f as usize] {
                    if !std::mem::replace(&mut is_seen[w as usize], true) && holds(w) {
                        far = f64::max(far, self.positions[w as usize].distance(first));
                        front.push(w);
                    }
                }
            }
        }
        far
    }

    /// Positions of the vertices that are not on the rim.
    pub(super) fn inner_points(&self) -> impl Iterator<Item = DVec3> {
        let all = self.positions.iter().zip(&self.is_on_rim);
        all.filter(|(_, on_rim)| !**on_rim).map(|(p, _)| *p)
    }

    /// Position of a vertex of the rim; `at` may exceed the rim's length.
    pub(super) fn rim_point(&self, at: usize) -> DVec3 {
        self.rim_points[at % self.rim.len()]
    }
}

/// For each face the faces across its edges, and for each edge of the rim the face next to it; `None` if one has none.
fn neighbours(part: &Part, rim: &[u32]) -> (Vec<[u32; 3]>, Option<Vec<u32>>) {
    let faces = &part.mesh.faces;
    let mut sides = FxHashMap::default();
    for (i, f) in faces.iter().enumerate() {
        (0..3).for_each(|k| {
            sides.insert((f[k], f[(k + 1) % 3]), i as u32);
        });
    }
    let adjacent = faces.iter().map(|f| {
        let across = |k: usize| sides.get(&(f[(k + 1) % 3], f[k])).copied();
        [0, 1, 2].map(|k| across(k).unwrap_or(NONE))
    });
    let rim: Vec<u32> = rim.iter().map(|&v| part.local(v)).collect();
    let next = |i: usize| rim[(i + 1) % rim.len()];
    let beyond = (0..rim.len()).map(|i| sides.get(&(next(i), rim[i])).copied());
    (adjacent.collect(), beyond.collect())
}

/// Marks the rim's vertices among `count` vertices.
fn on_rim(count: usize, rim: &[u32]) -> Vec<bool> {
    let mut is_on_rim = vec![false; count];
    rim.iter().for_each(|&v| is_on_rim[v as usize] = true);
    is_on_rim
}

fn diameter(points: &[DVec3]) -> f64 {
    let squares = points
        .iter()
        .enumerate()
        .flat_map(|(i, p)| points[..i].iter().map(move |q| p.distance_squared(*q)));
    squares.fold(0.0, f64::max).sqrt()
}

/// The median; for an even number of values the mean of the two middle ones, 0 without values.
pub(super) fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}
