//! How well a counterpart fits the faces round a hole, and predicts rings of them that are taken out.

use std::collections::VecDeque;

use glam::DVec3;
use rayon::prelude::*;

use super::align::{Sample, Settings, Target, aligned};
use super::motion::Motion;
use super::placed::PlacedPart;
use crate::cancel::Cancel;
use crate::fill::invented::NotLike;
use crate::finish::{OffsetDatum, OffsetField};
use crate::mesh::{Mesh, VertexFaces, vertex_normal};
use crate::spatial::Bvh;

/// Diameters. Width of the collar of known vertices to which a counterpart is fitted, as for kriging.
const COLLAR: f64 = 0.45;
/// Mean edges. Its least width.
const COLLAR_EDGES: f64 = 3.5;
/// Rounds of the alignment with the collar, and samples of it, at most.
const ROUNDS: usize = 10;
const SAMPLES: usize = 800;
/// Part of the collar that is aligned: the rest may be damaged on one side.
const KEPT: f64 = 0.85;
/// See [`Settings::ridge`]: a smooth collar must not slide on the counterpart.
const RIDGE: f64 = 0.01;
/// Least part of the collar that has partners on the counterpart.
const LEAST_PARTNERS: f64 = 0.7;
/// Upper bound of the motion that brings the counterpart closest to the collar: diameters, and radians.
const FARTHEST: f64 = 0.25;
const LARGEST_ANGLE: f64 = 0.35;
/// Partners farther away than this are none, in diameters.
const FAR: f64 = 0.2;

/// The known vertices round a hole.
pub(super) struct Collar {
    samples: Vec<Sample>,
    /// Their distances from the rim.
    depth: Vec<f64>,
    /// Mean normal.
    normal: DVec3,
    /// Mean length of the rim's edges.
    pub(super) edge: f64,
    diameter: f64,
}

/// A counterpart that was brought to a hole: rigidly, then by the smooth field of the offsets of the known vertices from it.
pub(super) struct Fitted {
    /// The counterpart.
    pub(super) mesh: Mesh,
    pub(super) bvh: Bvh,
    /// The field by which it was moved.
    pub(super) field: OffsetField,
    /// Root mean square distance of the collar from it before that.
    pub(super) misfit: f64,
    /// Root mean square of the field on the collar: the misfit without what is rough.
    pub(super) smooth_misfit: f64,
}

impl Collar {
    /// The vertices that are connected with a rim and near it.
    pub(super) fn new(mesh: &Mesh, rim: &[u32], diameter: f64) -> Self {
        let around = VertexFaces::new(mesh);
        let at = |v: u32| mesh.positions[v as usize];
        let next = rim.iter().cycle().skip(1);
        let lengths = rim.iter().zip(next).map(|(&a, &b)| at(a).distance(at(b)));
        let edge = lengths.sum::<f64>() / rim.len().max(1) as f64;
        let width = (COLLAR * diameter).max(COLLAR_EDGES * edge);
        // Few points of a long rim are enough for distances of half a diameter.
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

    /// Brings a part of a counterpart to the hole.
    pub(super) fn fitted(&self, part: &PlacedPart, cancel: &Cancel) -> Result<Fitted, NotLike> {
        let bvh = Bvh::new(&part.mesh, 0..part.mesh.faces.len() as u32);
        let target = Target {
            mesh: &part.mesh,
            bvh: &bvh,
            border: &part.border,
        };
        let step = self.samples.len().div_ceil(SAMPLES).max(1);
        let few: Vec<Sample> = self.samples.iter().step_by(step).copied().collect();
        let settings = Settings {
            rounds: ROUNDS,
            kept: KEPT,
            scale: false,
            ridge: RIDGE,
        };
        let end = aligned(&few, &target, Motion::IDENTITY, &settings, cancel);
        if !end.rms.is_finite() {
            return Err(self.why_apart(part, &bvh));
        }
        let middle = few.iter().map(|s| s.point).sum::<DVec3>() / few.len() as f64;
        if end.motion.at(middle).distance(middle) > FARTHEST * self.diameter
            || end.motion.angle() > LARGEST_ANGLE
        {
            return Err(NotLike::Apart);
        }
        let mesh = end.motion.inverse().moved(&part.mesh);
        drop(bvh);
        self.joined(mesh, part, cancel)
    }

    /// Why the collar has too few partners on a part of a counterpart.
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
        match open as f64 > (1.0 - LEAST_PARTNERS) * self.samples.len() as f64 {
            true if 2 * own > open => NotLike::Own,
            true => NotLike::Open,
            false => NotLike::Apart,
        }
    }

    /// Moves an aligned counterpart by the smooth field of the collar's offsets from it.
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
        let datum = |(s, depth): (&Sample, &f64)| {
            let (partner, _) = target.partner(s.point, s.normal)?;
            let offset = s.point - partner;
            let is_near = offset.length() < FAR * self.diameter;
            is_near.then_some(OffsetDatum {
                point: s.point,
                offset,
                depth: *depth,
            })
        };
        let all: Vec<Option<OffsetDatum>> = self
            .samples
            .par_iter()
            .zip(&self.depth)
            .map(datum)
            .collect();
        let data: Vec<OffsetDatum> = all.into_iter().flatten().collect();
        if (data.len() as f64) < LEAST_PARTNERS * self.samples.len() as f64 {
            return Err(self.why_apart(part, &bvh));
        }
        let field = OffsetField::fit(&data, self.normal, self.diameter, self.edge, cancel);
        let field = field.ok_or(NotLike::Apart)?;
        let mean = |square: &dyn Fn(&OffsetDatum) -> f64| {
            (data.iter().map(square).sum::<f64>() / data.len() as f64).sqrt()
        };
        let misfit = mean(&|d| d.offset.length_squared());
        let smooth_misfit = mean(&|d| field.at(d.point).length_squared());
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
}

impl Fitted {
    /// Distance of a point from it.
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        self.bvh
            .closest(p, f64::INFINITY)
            .map_or(f64::INFINITY, |c| c.distance)
    }
}
