//! Assembly of the initial patch: the kept part of the extracted surface, zipped to the rim.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::cut::{self, Kept};
use super::gap::{self, Loops};
use super::half_edge::PatchMesh;
use super::manifold_joint::check_joined;
use super::matching;
use super::rim::Rims;
use super::{Patch, StitchError, StitchInput, StitchReport};
use crate::elementary::acos;
use crate::mesh::{DisjointSets, area_vector, bounds};
use crate::threads::CollectIndexed;

/// A patch during stitching, with its connection to the mesh.
pub(super) struct Assembled {
    pub(super) mesh: PatchMesh,
    pub(super) rims: Rims,
    /// The origin of positions.
    pub(super) centre: DVec3,
    pub(super) report: StitchReport,
}

/// Cuts the extracted surface, matches its boundary loops to rims, and fills the gaps between them.
pub(super) fn assemble(input: &StitchInput) -> Result<Assembled, StitchError> {
    let mut report = StitchReport::default();
    let rims = Rims::new(input)?;
    let kept = cut::cut(input);
    input.go_on()?;
    let (gaps, dropped) = matching::gaps(input, &rims, &kept)?;
    let centre = centre(input, &rims);
    let mut mesh = PatchMesh::default();
    let rim = add_rim(input, &rims, centre, &mut mesh);
    let inner = add_kept(input, &kept, &dropped, centre, &mut mesh);
    let loops = Loops { rim, inner };
    for gap in &gaps {
        input.go_on()?;
        gap::fill(input, &rims, gap, &loops, &mut mesh, &mut report)?;
    }
    mesh.connect().map_err(|e| e.moved(centre))?;
    mesh.compact();
    let mut assembled = Assembled {
        mesh,
        rims,
        centre,
        report,
    };
    assembled.split_duplicates();
    Ok(assembled)
}

/// A closed surface, which is joined to no rim, with one target edge length.
pub(super) fn closed(input: &StitchInput, edge: f64) -> Result<Assembled, StitchError> {
    let extracted = input.extracted;
    let centre = middle(extracted.positions.iter());
    let projected: Vec<(DVec3, DVec3)> = extracted
        .positions
        .par_iter()
        .map(|&p| match input.surface.project(p) {
            Some((q, n)) if q.distance(p) < input.voxel => (q - centre, n),
            _ => (p - centre, DVec3::ZERO),
        })
        .collect_indexed();
    let mut mesh = PatchMesh::default();
    (mesh.position, mesh.normal) = projected.into_iter().unzip();
    mesh.size = vec![edge; extracted.positions.len()];
    mesh.faces.clone_from(&extracted.faces);
    mesh.connect().map_err(|e| e.moved(centre))?;
    if let Some(position) = mesh.on_border() {
        let error = StitchError::NotManifold { position };
        return Err(error.moved(centre));
    }
    mesh.compact();
    Ok(Assembled {
        mesh,
        rims: Rims::default(),
        centre,
        report: StitchReport::default(),
    })
}

fn centre(input: &StitchInput, rims: &Rims) -> DVec3 {
    let rim = rims.loops.iter().flatten();
    middle(rim.map(|&v| &input.mesh.positions[v as usize]))
}

/// The centre of the bounding box.
fn middle<'a>(points: impl Iterator<Item = &'a DVec3>) -> DVec3 {
    let (low, high) = bounds(points.copied());
    (low + high) / 2.0
}

/// Adds the rim corners and returns their loops.
fn add_rim(input: &StitchInput, rims: &Rims, centre: DVec3, mesh: &mut PatchMesh) -> Vec<Vec<u32>> {
    let mut loops = Vec::new();
    for lp in &rims.loops {
        let start = mesh.origin.len() as u32;
        loops.push((start..start + lp.len() as u32).collect());
        for &v in lp {
            mesh.origin.push(v);
            mesh.position
                .push(input.mesh.positions[v as usize] - centre);
            mesh.normal.push(rims.normal[&v]);
            mesh.size
                .push(rims.length.get(&v).copied().unwrap_or(input.voxel));
        }
    }
    loops
}

/// Adds the kept part, projected on the surface, and returns its boundary loops, oriented to have the gap on their left.
fn add_kept(
    input: &StitchInput,
    kept: &Kept,
    dropped: &BTreeSet<usize>,
    centre: DVec3,
    mesh: &mut PatchMesh,
) -> Vec<Vec<u32>> {
    let offset = mesh.position.len() as u32;
    let projected: Vec<(DVec3, DVec3)> = kept
        .positions
        .par_iter()
        .zip(&kept.normals)
        .map(|(&p, n)| match input.surface.project(p) {
            // A projection that is far or turns the normal is not used.
            Some((q, m)) if q.distance(p) < input.voxel && m.dot(*n) > 0.0 => (q - centre, m),
            _ => (p - centre, *n),
        })
        .collect_indexed();
    for (p, n) in projected {
        mesh.position.push(p);
        mesh.normal.push(n);
        mesh.size.push(input.voxel);
    }
    for (f, component) in kept.faces.iter().zip(&kept.component) {
        if !dropped.contains(component) {
            mesh.faces.push(f.map(|v| v + offset));
        }
    }
    kept.loops
        .iter()
        .map(|lp| lp.iter().rev().map(|&v| v + offset).collect())
        .collect()
}

impl Assembled {
    /// The output index of a patch vertex: a vertex of the mesh, or a new vertex with index `mesh_len` or higher.
    pub(super) fn output_index(&self, v: u32, mesh_len: u32) -> u32 {
        if self.mesh.is_rim(v) {
            self.mesh.origin[v as usize]
        } else {
            mesh_len + v - self.mesh.rim_len() as u32
        }
    }

    /// Splits interior edges between rim vertices that are also joined by an edge of the mesh, and all but one of several patch
    /// edges between the same two vertices.
    pub(super) fn split_duplicates(&mut self) {
        let mut by_ends: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
        for h in self.mesh.interior_edges() {
            let [a, b] =
                [self.mesh.from(h), self.mesh.to(h)].map(|v| self.output_index(v, u32::MAX / 2));
            by_ends.entry((a.min(b), a.max(b))).or_default().push(h);
        }
        let mut duplicates = Vec::new();
        for ((a, b), list) in by_ends {
            let spare = usize::from(a != b && !self.rims.has_edge(a, b));
            duplicates.extend_from_slice(&list[spare.min(list.len())..]);
        }
        for h in duplicates {
            let (a, b) = (self.mesh.from(h) as usize, self.mesh.to(h) as usize);
            let position = (self.mesh.position[a] + self.mesh.position[b]) / 2.0;
            let normal = (self.mesh.normal[a] + self.mesh.normal[b]).normalize_or_zero();
            let size = (self.mesh.size[a] + self.mesh.size[b]) / 2.0;
            self.mesh.split(h, position, normal, size);
            self.report.split_duplicates += 1;
        }
    }

    /// The faces with output indices.
    pub(super) fn output_faces(&self, mesh_len: u32) -> Vec<[u32; 3]> {
        self.mesh
            .faces
            .iter()
            .map(|f| f.map(|v| self.output_index(v, mesh_len)))
            .collect()
    }

    /// The finished patch.
    pub(super) fn into_patch(mut self, input: &StitchInput) -> Result<Patch, StitchError> {
        self.mesh.compact();
        let rim_len = self.mesh.rim_len();
        let positions = self.mesh.position[rim_len..]
            .iter()
            .map(|&p| p + self.centre)
            .collect();
        let faces = self.output_faces(input.mesh.positions.len() as u32);
        check_joined(input, &faces)?;
        self.measure();
        Ok(Patch {
            positions,
            faces,
            report: self.report,
        })
    }

    /// Computes the report's angles across the rim, quality and topology.
    fn measure(&mut self) {
        let mesh = &self.mesh;
        let angles: Vec<f64> = (0..mesh.rim_len() as u32)
            .filter_map(|v| {
                let h = mesh.rim_edge(v)?;
                let key = (mesh.origin[v as usize], mesh.origin[mesh.to(h) as usize]);
                let beyond = self.rims.beyond.get(&key)?.normal;
                let normal = mesh
                    .area_vector(mesh.faces[h as usize / 3])
                    .normalize_or_zero();
                Some(acos(normal.dot(beyond).clamp(-1.0, 1.0)).to_degrees())
            })
            .collect();
        self.report.seam_angle_mean = angles.iter().sum::<f64>() / angles.len().max(1) as f64;
        self.report.seam_angle_max = angles.iter().copied().fold(0.0, f64::max);
        let quality: f64 = mesh
            .faces
            .iter()
            .map(|&f| quality(f.map(|v| mesh.position[v as usize])))
            .sum();
        self.report.quality_mean = quality / mesh.faces.len().max(1) as f64;
        (self.report.components, self.report.euler) = topology(mesh);
    }
}

/// Twice the inradius over the circumradius: 1 for an equilateral triangle, 0 for a degenerate one.
pub(super) fn quality([a, b, c]: [DVec3; 3]) -> f64 {
    let [x, y, z] = [a.distance(b), b.distance(c), c.distance(a)];
    let area = area_vector([a, b, c]).length() / 2.0;
    let bottom = x * y * z * (x + y + z);
    if bottom > 0.0 {
        16.0 * area * area / bottom
    } else {
        0.0
    }
}

/// Number of connected components and Euler characteristic.
fn topology(mesh: &PatchMesh) -> (usize, i64) {
    let mut sets = DisjointSets::new(mesh.position.len());
    let mut edges = FxHashMap::default();
    for f in &mesh.faces {
        for k in 0..3 {
            let (a, b) = (f[k], f[(k + 1) % 3]);
            edges.insert((a.min(b), a.max(b)), ());
            sets.join(a, b);
        }
    }
    let used: Vec<u32> = (0..mesh.position.len() as u32)
        .filter(|&v| mesh.is_used(v))
        .collect();
    let components = used.iter().filter(|&&v| sets.find(v) == v).count();
    (
        components,
        used.len() as i64 - edges.len() as i64 + mesh.faces.len() as i64,
    )
}
