//! Holes in known surfaces: the patch must close them and lie on the surface.

use std::collections::HashMap;

use glam::DVec3;

use super::shapes::*;
use crate::mesh::Mesh;
use crate::stitch::{Patch, StitchInput, StitchParams, Surface, stitch};

pub struct Case {
    pub mesh: Mesh,
    pub loops: Vec<Vec<u32>>,
    pub surface: Analytic,
    pub voxel: f64,
}

impl Case {
    pub fn new(mesh: Mesh, loops: Vec<Vec<u32>>, surface: Analytic, voxel: f64) -> Self {
        let surface = surface.with_mesh(&mesh, &loops);
        Self {
            mesh,
            loops,
            surface,
            voxel,
        }
    }

    pub fn stitch(&self, params: StitchParams) -> Patch {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &v in self.loops.iter().flatten() {
            low = low.min(self.mesh.positions[v as usize]);
            high = high.max(self.mesh.positions[v as usize]);
        }
        let margin = DVec3::splat(0.6 * (high - low).max_element());
        let extracted = extract(&self.surface, low - margin, high + margin, self.voxel);
        let input = StitchInput {
            mesh: &self.mesh,
            loops: &self.loops,
            surface: &self.surface,
            extracted: &extracted,
            voxel: self.voxel,
            params,
        };
        stitch(&input).expect("the patch")
    }
}

/// The mesh with the patch must be closed but for `open` border edges, manifold and oriented.
pub fn assert_joined(mesh: &Mesh, patch: &Patch, open: usize) -> Mesh {
    let mut whole = mesh.clone();
    whole.positions.extend(&patch.positions);
    whole.faces.extend(&patch.faces);
    let mut edges = HashMap::new();
    for f in &whole.faces {
        for k in 0..3 {
            assert_ne!(f[k], f[(k + 1) % 3]);
            let n = edges.entry((f[k], f[(k + 1) % 3])).or_insert(0);
            *n += 1;
            assert_eq!(*n, 1, "directed edge twice");
        }
    }
    let single = edges
        .keys()
        .filter(|(a, b)| !edges.contains_key(&(*b, *a)))
        .count();
    assert_eq!(single, open, "border edges");
    whole
}

pub fn euler(mesh: &Mesh) -> i64 {
    let mut edges = std::collections::HashSet::new();
    let mut used = std::collections::HashSet::new();
    for f in &mesh.faces {
        for k in 0..3 {
            edges.insert((f[k].min(f[(k + 1) % 3]), f[k].max(f[(k + 1) % 3])));
            used.insert(f[k]);
        }
    }
    used.len() as i64 - edges.len() as i64 + mesh.faces.len() as i64
}

pub fn sphere() -> Analytic {
    Analytic::new(|p| p.length() - 1.0)
}

pub fn ragged_cap(seed: u64) -> Case {
    let mut noise = Noise(seed);
    let mut mesh = icosphere(4);
    jitter(&mut mesh, &sphere(), 0.015, &mut noise);
    let mesh = punch(&mesh, |c| c.normalize().z > 0.5 + 0.08 * noise.next());
    let loops = border(&mesh);
    Case::new(mesh, loops, sphere(), 1.7 / 32.0)
}

#[test]
fn ragged_cap_is_closed() {
    for seed in 1..4 {
        let case = ragged_cap(seed);
        let patch = case.stitch(StitchParams::default());
        let whole = assert_joined(&case.mesh, &patch, 0);
        assert_eq!(euler(&whole), 2);
        let off = patch
            .positions
            .iter()
            .map(|p| (p.length() - 1.0).abs())
            .fold(0.0, f64::max);
        assert!(off < 1e-9, "{off} from the sphere");
        assert!(case.surface.depth(DVec3::Z) > 0.0);
    }
}
