//! Quality measures of a patch: angles across the rim and the shape of its faces.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::Patch;
use super::assemble::quality;
use crate::elementary::acos;
use crate::mesh::{Mesh, area_vector};

impl Patch {
    /// Recomputes the angles across the rim and the quality of the faces after vertices moved. `around` must contain the faces of
    /// `mesh` at the rim, and may contain others.
    pub fn measure(&mut self, mesh: &Mesh, around: impl Iterator<Item = [u32; 3]>) {
        let len = mesh.positions.len() as u32;
        let at = |v: u32| match v.checked_sub(len) {
            Some(new) => self.positions[new as usize],
            None => mesh.positions[v as usize],
        };
        let edges = |f: [u32; 3]| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])];
        let normal = |f: [u32; 3]| area_vector(f.map(at)).normalize_or_zero();
        let old = self.faces.iter().flatten().copied().filter(|&v| v < len);
        let rim: FxHashSet<u32> = old.collect();
        let mut beyond: FxHashMap<(u32, u32), DVec3> = FxHashMap::default();
        for f in around {
            for (a, b) in edges(f) {
                if rim.contains(&a) && rim.contains(&b) {
                    beyond.insert((b, a), normal(f));
                }
            }
        }
        let (mut angles, mut shape) = (Vec::new(), 0.0);
        for &f in &self.faces {
            shape += quality(f.map(at));
            for edge in edges(f) {
                if let Some(n) = beyond.get(&edge) {
                    let cosine = normal(f).dot(*n).clamp(-1.0, 1.0);
                    angles.push(acos(cosine).to_degrees());
                }
            }
        }
        let mean = |sum: f64, count: usize| sum / count.max(1) as f64;
        self.report.quality_mean = mean(shape, self.faces.len());
        self.report.seam_angle_mean = mean(angles.iter().sum(), angles.len());
        self.report.seam_angle_max = angles.into_iter().fold(0.0, f64::max);
    }
}
