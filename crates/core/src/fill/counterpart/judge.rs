//! Fits a counterpart to the known vertices round a hole: rigid alignment, then a smooth field of offsets, with the misfit of both.

use std::collections::VecDeque;

use glam::DVec3;
use rayon::prelude::*;

use super::align::{SHORTEST_STEP, Sample, Settings, Target, aligned};
use super::motion::Motion;
use super::placed::PlacedPart;
use crate::cancel::Cancel;
use crate::elementary::root_mean_square;
use crate::fill::invented::NotLike;
use crate::finish::{OffsetDatum, OffsetField};
use crate::mesh::{Mesh, VertexFaces, vertex_normal};
use crate::spatial::Bvh;
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Diameters. Width of the collar of known vertices to which a counterpart is fitted, as for kriging.
const COLLAR: Tunable<f64> = tunable("fill.judge.collar", 0.45);
/// Mean rim edges. Lower bound of the collar's width.
const COLLAR_EDGES: Tunable<f64> = tunable("fill.judge.collar_edges", 3.5);
/// Upper bounds of the iterations and of the samples of the alignment with the collar.
const ROUNDS: Tunable<usize> = tunable("fill.judge.rounds", 10);
const SAMPLES: Tunable<usize> = tunable("fill.judge.samples", 800);
/// Fraction of the collar that is aligned: the remainder may be damaged on one of the two sides.
const KEPT: Tunable<f64> = tunable("fill.judge.kept", 0.85);
/// See [`Settings::ridge`]: a smooth collar must not slide on the counterpart.
const RIDGE: f64 = 0.01;
/// Lower bound of the fraction of the collar's vertices with partners on the counterpart.
const LEAST_PARTNERS: Tunable<f64> = tunable("fill.judge.least_partners", 0.7);
/// Upper bounds of the alignment's motion: displacement of the collar's centre in diameters, and rotation in radians.
const FARTHEST: Tunable<f64> = tunable("fill.judge.farthest", 0.25);
const LARGEST_ANGLE: Tunable<f64> = tunable("fill.judge.largest_angle", 0.35);
/// Diameters. Upper bound of the distance of a partner.
const FAR: Tunable<f64> = tunable("fill.judge.far", 0.2);

/// The known vertices round a hole; lengths in the mesh's unit.
pub(super) struct Collar {
    samples: Vec<Sample>,
    /// Distances of the samples from the rim.
    depth: Vec<f64>,
    /// Sum of the samples' normals.
    normal: DVec3,
    /// Mean length of the rim's edges.
    pub(super) edge: f64,
    /// Diameter of the hole.
    diameter: f64,
}

/// A counterpart fitted to a hole: aligned rigidly, then moved by the smooth field of the collar's offsets from it.
pub(super) struct Fitted {
    /// The counterpart.
    pub(super) mesh: Mesh,
    pub(super) bvh: Bvh,
    /// The field of offsets.
    pub(super) field: OffsetField,
    /// Root mean square distance of the collar from the rigidly aligned counterpart.
    pub(super) misfit: f64,
    /// Root mean square of the field on the collar: the misfit without roughness.
    pub(super) smooth_misfit: f64,
}

impl Collar {
    /// The vertices within the collar's width of a rim and connected with it inside the collar.
    pub(super) fn new(mesh: &Mesh, rim: &[u32], diameter: f64) -> Self {
        let around = VertexFaces::new(mesh);
        let at = |v: u32| mesh.positions[v as usize];
        let next = rim.iter().cycle().skip(1);
        let lengths = rim.iter().zip(next).map(|(&a, &b)| at(a).distance(at(b)));
        let edge = lengths.sum::<f64>() / rim.len().max(1) as f64;
        let width = (COLLAR.get() * diameter).max(COLLAR_EDGES.get() * edge);
        // About 300 points of a long rim suffice for distances up to half a diameter.
        let few: Vec<DVec3> = rim
            .iter()
            .step_by(rim.len().div_ceil(300))
            .map(|&v| at(v))
            .collect();
        let distance = |p: DVec3| {
            few.iter()
                .map(|q| p.distance_squared(*q))
                .fold(f64::MAX, f64::min)
                .sqrt()
        };
        // Breadth first from the rim; NaN marks vertices that were not reached.
        let mut depth = vec![f64::NAN; mesh.positions.len()];
        let mut queue: VecDeque<u32> = rim.iter().copied().collect();
        rim.iter().for_each(|&v| depth[v as usize] = 0.0);
        while let Some(v) = queue.pop_front() {
            for w in around.of(v).iter().flat_map(|&f| mesh.faces[f as usize]) {
                let own = &mut depth[w as usize];
                if own.is_nan() {
                    *own = distance(at(w));
                    if *own < width {
                        queue.push_back(w);
                    }
                }
            }
        }
        // The vertices within the collar's width, with their normals.
        let inside = |v: &u32| depth[*v as usize] < width;
        let vertices: Vec<u32> = (0..depth.len() as u32).filter(inside).collect();
        let sample = |&v: &u32| Sample {
            point: at(v),
            normal: vertex_normal(mesh, &around, v),
        };
        let samples: Vec<Sample> = vertices.iter().map(sample).collect();
        Self {
            normal: samples.iter().map(|s| s.normal).sum(),
            samples,
            depth: vertices.iter().map(|&v| depth[v as usize]).collect(),
            edge,
            diameter,
        }
    }

    /// Fits a part of a counterpart to the hole.
    pub(super) fn fitted(&self, part: &PlacedPart, cancel: &Cancel) -> Result<Fitted, NotLike> {
        let motion = self.aligned(part, (ROUNDS.get(), SHORTEST_STEP), cancel)?;
        self.joined(motion.moved(&part.mesh), part, cancel)
    }

    /// The rigid motion that aligns a part of a counterpart with the collar; the bound of the iterations and the step that ends them as in
    /// [`Settings`].
    pub(super) fn aligned(
        &self,
        part: &PlacedPart,
        (rounds, shortest_step): (usize, f64),
        cancel: &Cancel,
    ) -> Result<Motion, NotLike> {
        let bvh = Bvh::new(&part.mesh, 0..part.mesh.faces.len() as u32);
        let target = Target {
            mesh: &part.mesh,
            bvh: &bvh,
            border: &part.border,
        };
        let few = self.samples.iter().step_by(self.step(SAMPLES.get()));
        let few: Vec<Sample> = few.copied().collect();
        let settings = Settings {
            rounds,
            shortest_step,
            kept: KEPT.get(),
            scale: false,
            ridge: RIDGE,
        };
        let end = aligned(&few, &target, Motion::IDENTITY, &settings, cancel);
        if !end.rms.is_finite() {
            return Err(self.why_apart(part, &bvh));
        }
        let middle = few.iter().map(|s| s.point).sum::<DVec3>() / few.len() as f64;
        if end.motion.at(middle).distance(middle) > FARTHEST.get() * self.diameter
            || end.motion.angle() > LARGEST_ANGLE.get()
        {
            return Err(NotLike::Apart);
        }
        Ok(end.motion.inverse())
    }

    /// The reason for which the collar has too few partners on a part of a counterpart.
    fn why_apart(&self, part: &PlacedPart, bvh: &Bvh) -> NotLike {
        let target = Target {
            mesh: &part.mesh,
            bvh,
            border: &part.border,
        };
        let (mut open, mut own) = (0, 0);
        for s in &self.samples {
            let Some(closest) = bvh.closest(s.point, f64::INFINITY) else {
                continue;
            };
            if target.is_on_border(&closest) {
                open += 1;
                let face = part.mesh.faces[closest.face as usize];
                own += usize::from(face.iter().any(|&v| part.own_rim[v as usize]));
            }
        }
        match open as f64 > (1.0 - LEAST_PARTNERS.get()) * self.samples.len() as f64 {
            true if 2 * own > open => NotLike::Own,
            true => NotLike::Open,
            false => NotLike::Apart,
        }
    }

    /// Moves an aligned counterpart by the smooth field of the collar's offsets, so that it meets the rim.
    fn joined(
        &self,
        mut mesh: Mesh,
        part: &PlacedPart,
        cancel: &Cancel,
    ) -> Result<Fitted, NotLike> {
        let bvh = Bvh::new(&mesh, 0..mesh.faces.len() as u32);
        let target = Target {
            mesh: &mesh,
            bvh: &bvh,
            border: &part.border,
        };
        let data = self.offsets(&target, usize::MAX);
        let data = data.ok_or_else(|| self.why_apart(part, &bvh))?;
        let field = self.field(&data, cancel).ok_or(NotLike::Apart)?;
        let misfit = root_mean_square(data.iter().map(|d| d.offset.length()));
        let smooth_misfit = root_mean_square(data.iter().map(|d| field.at(d.point).length()));
        mesh.positions
            .par_iter_mut()
            .for_each(|p| *p += field.at(*p));
        if !mesh.positions.iter().all(|p| p.is_finite()) {
            return Err(NotLike::Apart);
        }
        Ok(Fitted {
            bvh: Bvh::new(&mesh, 0..mesh.faces.len() as u32),
            mesh,
            field,
            misfit,
            smooth_misfit,
        })
    }

    /// The offsets of at most `most` vertices of the collar from their partners on an aligned counterpart; none where too few have one.
    pub(super) fn offsets(&self, target: &Target, most: usize) -> Option<Vec<OffsetDatum>> {
        let datum = |(s, depth): (&Sample, &f64)| {
            let offset = s.point - target.partner(s.point, s.normal)?.point;
            let is_near = offset.length() < FAR.get() * self.diameter;
            is_near.then_some(OffsetDatum {
                point: s.point,
                offset,
                depth: *depth,
            })
        };
        let samples = self.samples.par_iter().zip(&self.depth);
        let samples = samples.step_by(self.step(most));
        let all: Vec<Option<OffsetDatum>> = samples.map(datum).collect_indexed();
        let count = all.len();
        let data: Vec<OffsetDatum> = all.into_iter().flatten().collect();
        (data.len() as f64 >= LEAST_PARTNERS.get() * count as f64).then_some(data)
    }

    /// The smooth field of offsets; none where it cannot be fitted.
    pub(super) fn field(&self, data: &[OffsetDatum], cancel: &Cancel) -> Option<OffsetField> {
        OffsetField::fit(data, self.normal, self.diameter, self.edge, cancel)
    }

    /// The step with which at most `most` vertices are taken.
    fn step(&self, most: usize) -> usize {
        self.samples.len().div_ceil(most).max(1)
    }
}

impl Fitted {
    /// Distance of a point from the counterpart.
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        self.bvh
            .closest(p, f64::INFINITY)
            .map_or(f64::INFINITY, |c| c.distance)
    }
}
