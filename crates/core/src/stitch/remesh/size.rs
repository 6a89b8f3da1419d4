//! Target edge lengths at the vertices of the patch.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::Remesher;
use crate::elementary::powi;
use crate::stitch::StitchParams;
use crate::stitch::half_edge::NONE;
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Growth of the target length per unit of length, at most.
const SIZE_GROWTH: Tunable<f64> = tunable("stitch.size_growth", 0.3);

/// Sweeps that smooth the target lengths between neighbours.
const SIZE_SWEEPS: Tunable<usize> = tunable("stitch.size_sweeps", 12);

/// Fraction of the rim's target length. Lower bound of the target length that curvature asks for.
const SIZE_LEAST: Tunable<f64> = tunable("stitch.size_least", 0.25);

/// Voxels. Least target length.
const SIZE_LEAST_VOXEL: Tunable<f64> = tunable("stitch.size_least_voxel", 0.02);

/// Faces of a patch, at most, approximately.
const MOST_FACES: Tunable<f64> = tunable("stitch.most_faces", 1e6);

/// Faces of a patch per square of a rim's number of edges, at most, approximately. A disc with equal edges around it gets
/// 0.3; rims of which a part is finer by orders of magnitude would otherwise reach `MOST_FACES`.
const MOST_FACES_OF_RIM: Tunable<f64> = tunable("stitch.most_faces_of_rim", 16.0);

/// Faces of a patch per equilateral triangle of its area whose edges have the rim's mean length, at most, approximately.
const MOST_FACES_OF_AREA: Tunable<f64> = tunable("stitch.most_faces_of_area", 16.0);

/// Faces of a patch in addition to these, at most, approximately.
const MOST_FACES_BESIDES: Tunable<f64> = tunable("stitch.most_faces_besides", 5000.0);

/// Faces. A patch with more, if all had the size of those at the rim, gets larger faces inward. A disc has this many with a rim of
/// 800 edges and takes 15 s; with 20,000 edges it would have 1e8.
const MOST_EVEN_FACES: Tunable<f64> = tunable("stitch.most_even_faces", 2e5);

/// Growth of the target length per unit of distance from the rim of such a patch, at most.
const STEEPEST_GROWTH: Tunable<f64> = tunable("stitch.steepest_growth", 1.0);

/// Exponent of the distance in the interpolation of target lengths from the rim.
const SIZE_POWER: Tunable<i32> = tunable("stitch.size_power", 3);

/// Area of an equilateral triangle over the square of its edge.
const EQUILATERAL: f64 = 0.433_012_701_892_219_3;

/// The faces that a patch may have if this many are plausible.
fn with_besides(faces: f64, params: &StitchParams) -> f64 {
    (MOST_FACES_BESIDES.get() + faces) / params.edge_factor.powi(2).min(1.0)
}

impl Remesher<'_> {
    /// Sets the targets from the mesh's edges at the rim, shortened where a chord would be too far from the surface.
    pub(super) fn set_sizes(&mut self, params: &StitchParams, voxel: f64) {
        self.even_out_rim();
        if self.mesh.rim_len() > 0 {
            self.take_from_rim();
        }
        let factor = params.edge_factor;
        let chord = params.chord_error * voxel;
        let mesh = &*self.mesh;
        let wanted: Vec<f64> = (0..mesh.position.len() as u32)
            .into_par_iter()
            .map(|v| {
                let size = factor * self.mesh.size[v as usize];
                // A chord of length l is k l² / 8 from a surface of curvature k.
                let by_curvature = (8.0 * chord / self.curvature(v)).sqrt();
                if self.mesh.is_rim(v) {
                    size
                } else {
                    size.min(by_curvature.max(SIZE_LEAST.get() * size))
                }
            })
            .collect_indexed();
        let floor = self.floor(voxel);
        self.mesh.size = wanted
            .into_iter()
            .map(|s| if s >= floor { s } else { floor })
            .collect();
        self.limit_growth();
        if params.may_coarsen {
            self.grow_inward();
        }
        let of_area = MOST_FACES_OF_AREA.get() * self.faces_of_mean_edge();
        let most = self.most_faces(params).min(with_besides(of_area, params));
        self.limit_faces(0.5 * most);
    }

    /// The maximum number of faces plausible for the rims; infinite without rims.
    pub(super) fn most_faces(&self, params: &StitchParams) -> f64 {
        let squares: f64 = self
            .rims
            .loops
            .iter()
            .map(|l| (l.len() as f64).powi(2))
            .sum();
        if squares == 0.0 {
            return f64::INFINITY;
        }
        with_besides(MOST_FACES_OF_RIM.get() * squares, params)
    }

    /// The number of equilateral faces of the patch's area whose edges have the mean length of those at the rims; infinite
    /// without these.
    fn faces_of_mean_edge(&self) -> f64 {
        let mesh = &*self.mesh;
        let there = mesh.faces.iter().filter(|f| f[0] != NONE);
        let area: f64 = there.map(|f| 0.5 * mesh.area_vector(*f).length()).sum();
        let (mut length, mut edges) = (0.0, 0.0);
        for rim in &self.rims.loops {
            let known = |v: &&u32| self.rims.length.contains_key(v);
            length += (rim.iter().filter(known))
                .map(|v| self.rims.length[v])
                .sum::<f64>();
            edges += rim.iter().filter(known).count() as f64;
        }
        let faces = area / (EQUILATERAL * (length / edges).powi(2));
        if faces.is_nan() { f64::INFINITY } else { faces }
    }

    /// Raises the smallest targets until the patch would have at most `most` faces.
    fn limit_faces(&mut self, most: f64) {
        if !most.is_finite() {
            return;
        }
        let mesh = &*self.mesh;
        let parts: Vec<(f64, f64)> = mesh
            .faces
            .iter()
            .map(|f| {
                let size: f64 = f.iter().map(|&v| mesh.size[v as usize]).sum();
                (0.5 * mesh.area_vector(*f).length(), size / 3.0)
            })
            .collect();
        let faces = |floor: f64| -> f64 {
            let wanted =
                |&(area, size): &(f64, f64)| area / (EQUILATERAL * size.max(floor).powi(2));
            parts.iter().map(wanted).sum()
        };
        if faces(0.0) <= most {
            return;
        }
        // A floor at which the whole area has that number of faces, wherever they are.
        let enough = (parts.iter().map(|p| p.0).sum::<f64>() / (EQUILATERAL * most)).sqrt();
        let mut floor = 1e-6 * enough;
        while floor < enough && faces(floor) > most {
            floor = (1.5 * floor).min(enough);
        }
        for size in &mut self.mesh.size {
            *size = size.max(floor);
        }
    }

    /// Lets the targets grow with the distance from the rim where the patch would have more than [`StitchTuning::most_even_faces`] faces:
    /// a rim of n equal edges takes 0.3 n² faces of that size, but 3 n if they grow by as much as their distance.
    ///
    /// [`StitchTuning::most_even_faces`]: crate::tuning::StitchTuning::most_even_faces
    fn grow_inward(&mut self) {
        let mesh = &*self.mesh;
        let rim = mesh.rim_len();
        // The number of faces if the size is linear between the corners of each face of the patch.
        let faces = |sizes: &[f64]| -> f64 {
            let wanted = |f: &[u32; 3]| {
                let [a, b, c] = f.map(|v| sizes[v as usize]);
                let area = 0.5 * mesh.area_vector(*f).length();
                area / (EQUILATERAL * a.min(b).min(c) * a.max(b).max(c))
            };
            let there = mesh.faces.iter().filter(|f| f[0] != NONE);
            there.map(wanted).sum()
        };
        let most = MOST_EVEN_FACES.get();
        if rim == 0 || faces(&mesh.size) <= most {
            return;
        }
        let nearest = |p: &glam::DVec3| {
            let distance = |v: usize| (p.distance(mesh.position[v]), mesh.size[v]);
            let all = (0..rim).map(distance);
            all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
        };
        let near: Vec<(f64, f64)> = mesh.position[rim..]
            .par_iter()
            .map(nearest)
            .collect_indexed();
        let grown = |growth: f64| -> Vec<f64> {
            let inner = mesh.size[rim..].iter().zip(&near);
            let inner = inner.map(|(size, (d, at_rim))| size.max(at_rim + growth * d));
            mesh.size[..rim].iter().copied().chain(inner).collect()
        };
        let mut growth = SIZE_GROWTH.get();
        let mut sizes = grown(growth);
        while growth < STEEPEST_GROWTH.get() && faces(&sizes) > 0.5 * most {
            growth *= 1.5;
            sizes = grown(growth);
        }
        self.mesh.size = sizes;
    }

    /// Interpolates the targets from the rim, with weights that fall with distance.
    fn take_from_rim(&mut self) {
        let mesh = &*self.mesh;
        let rim: Vec<(glam::DVec3, f64)> = (0..mesh.rim_len())
            .map(|v| (mesh.position[v], mesh.size[v]))
            .collect();
        let from_rim: Vec<f64> = mesh.position[mesh.rim_len()..]
            .par_iter()
            .map(|p| {
                let (mut sum, mut weight) = (0.0, 0.0);
                for (q, size) in &rim {
                    let distance = p.distance(*q).max(1e-9 * size);
                    let w = size / powi(distance, SIZE_POWER.get());
                    sum += w * size;
                    weight += w;
                }
                sum / weight
            })
            .collect_indexed();
        let rim_len = self.mesh.rim_len();
        self.mesh.size[rim_len..].copy_from_slice(&from_rim);
    }

    /// The smallest target, so that degenerate rim edges do not lead to too many faces.
    fn floor(&self, voxel: f64) -> f64 {
        let area: f64 = self
            .mesh
            .faces
            .iter()
            .map(|&f| self.mesh.area_vector(f).length() / 2.0)
            .sum();
        (area / MOST_FACES.get())
            .sqrt()
            .max(SIZE_LEAST_VOXEL.get() * voxel)
    }

    /// Smooths the target at rim corners: each becomes the mean with its neighbours along the rim; three passes.
    fn even_out_rim(&mut self) {
        for _ in 0..3 {
            let mut sum: Vec<(f64, f64)> = self.mesh.size[..self.mesh.rim_len()]
                .iter()
                .map(|&s| (s, 1.0))
                .collect();
            for v in 0..self.mesh.rim_len() as u32 {
                if let Some(h) = self.mesh.outgoing(v).next() {
                    let to = self.mesh.to(h);
                    if self.mesh.is_rim(to) {
                        let (a, b) = (self.mesh.size[v as usize], self.mesh.size[to as usize]);
                        sum[v as usize] = (sum[v as usize].0 + b, sum[v as usize].1 + 1.0);
                        sum[to as usize] = (sum[to as usize].0 + a, sum[to as usize].1 + 1.0);
                    }
                }
            }
            for (v, (total, n)) in sum.into_iter().enumerate() {
                self.mesh.size[v] = total / n;
            }
        }
    }

    /// Estimate of the curvature at `v`: mean of the average and the maximum, over its edges, of the change of the normal per
    /// length; at least the curvature of a circle of a hundred edges.
    fn curvature(&self, v: u32) -> f64 {
        let mesh = &*self.mesh;
        let (mut sum, mut n) = (0.0, 0.0);
        let mut most = 0.0f64;
        for w in mesh.neighbours(v) {
            let length = mesh.position[v as usize].distance(mesh.position[w as usize]);
            let turn = (mesh.normal[v as usize] - mesh.normal[w as usize]).length();
            if length > 0.2 * mesh.size[v as usize].min(mesh.size[w as usize]) {
                sum += turn / length;
                most = most.max(turn / length);
                n += 1.0;
            }
        }
        let floor = TAU / (100.0 * mesh.size[v as usize]);
        if n > 0.0 {
            (0.5 * (sum / n + most)).max(floor)
        } else {
            floor
        }
    }

    /// Limits how fast targets grow from vertex to vertex.
    fn limit_growth(&mut self) {
        for _ in 0..SIZE_SWEEPS.get() {
            let mesh = &*self.mesh;
            let limited: Vec<f64> = (0..mesh.position.len() as u32)
                .into_par_iter()
                .map(|v| {
                    let size = mesh.size[v as usize];
                    let reach = |w: u32| {
                        let d = mesh.position[v as usize].distance(mesh.position[w as usize]);
                        mesh.size[w as usize] + SIZE_GROWTH.get() * d
                    };
                    mesh.neighbours(v).map(reach).fold(size, f64::min)
                })
                .collect_indexed();
            self.mesh.size = limited;
        }
    }
}
