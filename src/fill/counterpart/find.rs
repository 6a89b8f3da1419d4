//! Motions that bring a mesh onto its counterpart: planes of symmetry, and poses of a template.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::align::{Aligned, Sample, Settings, Target, aligned, distance, samples};
use super::motion::Motion;
use crate::cancel::Cancel;
use crate::linalg::{second_moments, symmetric_eigen};
use crate::mesh::Mesh;

/// Samples of the coarse alignment, from each start, and of the fine one.
const FEW_SAMPLES: usize = 400;
const MANY_SAMPLES: usize = 1500;
/// Normals of planes that are tried beside the principal axes, evenly on a half sphere: about 15° apart. Where principal moments are
/// alike, principal axes say nothing.
const DIRECTIONS: usize = 90;
/// Turns about each of the template's principal axes that are tried beside the poses in which principal axes agree.
const TURNS: usize = 8;
/// Rounds of the coarse and of the fine alignment.
const COARSE: usize = 8;
const FINE: usize = 60;
/// Part of the samples that have a partner: a quarter may have none.
const KEPT: f64 = 0.75;
/// Parts of the samples of the last alignments, each of which is taken where the distance of the nearest ones grows by no more than a factor.
const NEARLY_ALL: [f64; 2] = [0.93, 0.985];
const AS_NEAR: f64 = 1.2;
/// See [`Settings::ridge`].
const RIDGE: f64 = 1e-6;
/// Best ends of the coarse alignment that are aligned finely, and motions that are kept.
const REFINED: usize = 10;
const MOST: usize = 4;
/// Spans. Motions whose root mean square distance is larger are no symmetry, and no pose.
const FARTHEST: f64 = 0.1;
/// A motion is kept when its distance is at most this many times the best distance.
const ALIKE: f64 = 4.0;
/// Spans. Two motions that differ by less are the same.
const SAME: f64 = 0.02;
/// Spans. A symmetry that is done twice leaves everything where it was, but for this.
const INVOLUTION: f64 = 0.05;

/// Middle, principal axes and span of some points.
struct Moments {
    centre: DVec3,
    axes: [DVec3; 3],
    span: f64,
}

impl Moments {
    fn new(samples: &[Sample]) -> Self {
        let count = samples.len().max(1) as f64;
        let centre = samples.iter().map(|s| s.point).sum::<DVec3>() / count;
        let arms = || samples.iter().map(|s| s.point - centre);
        let (_, axes) = symmetric_eigen(&second_moments(arms()));
        let squares: f64 = arms().map(|a| a.length_squared()).sum();
        Self {
            centre,
            axes,
            span: (squares / count).sqrt(),
        }
    }
}

/// Motions of a mesh onto itself that mirror it, the best first; none where it has no symmetry.
pub(super) fn mirrors(mesh: &Mesh, target: &Target, cancel: &Cancel) -> Vec<Motion> {
    let coarse = samples(mesh, FEW_SAMPLES);
    let moments = Moments::new(&coarse);
    let around = (0..DIRECTIONS).map(half_sphere);
    let normals: Vec<DVec3> = moments.axes.into_iter().chain(around).collect();
    let starts = normals
        .iter()
        .map(|n| Motion::reflection(moments.centre, *n));
    let ends = best(mesh, &coarse, target, starts.collect(), false, cancel);
    let is_symmetry = |m: &Motion| {
        let back = |s: &Sample| m.at(m.at(s.point)).distance(s.point);
        let mean = coarse.iter().map(back).sum::<f64>() / coarse.len().max(1) as f64;
        m.is_reflection() && mean < INVOLUTION * moments.span
    };
    ends.into_iter().filter(is_symmetry).collect()
}

/// Motions of a mesh onto a template, the best first; none where none fits.
pub(super) fn poses(
    mesh: &Mesh,
    template: &Mesh,
    target: &Target,
    scale: bool,
    cancel: &Cancel,
) -> Vec<Motion> {
    let coarse = samples(mesh, FEW_SAMPLES);
    let (own, other) = (
        Moments::new(&coarse),
        Moments::new(&samples(template, FEW_SAMPLES)),
    );
    let factor = match scale && own.span > 0.0 {
        true => other.span / own.span,
        false => 1.0,
    };
    // Where it lies already, with middles together, and with principal axes together or turned about one of the template's.
    let mut starts = vec![
        Motion::IDENTITY,
        Motion::about(DMat3::IDENTITY * factor, own.centre, other.centre),
    ];
    for turn in frames(own.axes, other.axes) {
        starts.push(Motion::about(turn * factor, own.centre, other.centre));
    }
    best(mesh, &coarse, target, starts, scale, cancel)
}

/// Rotations that bring the axes of one frame to the axes of another in any order, and turned about each of the other's.
fn frames(from: [DVec3; 3], to: [DVec3; 3]) -> Vec<DMat3> {
    let right = |[x, y, _]: [DVec3; 3]| DMat3::from_cols(x, y, x.cross(y));
    let (from, to) = (right(from), right(to));
    let mut all = Vec::new();
    for axis in 0..3 {
        let [x, y, z] = [0, 1, 2].map(|k| to.col((axis + k) % 3));
        for k in 0..TURNS {
            let (sine, cosine) = (TAU * k as f64 / TURNS as f64).sin_cos();
            let (u, v) = (x * cosine + y * sine, y * cosine - x * sine);
            // The frame, and the one upside down.
            all.push(DMat3::from_cols(u, v, z) * from.transpose());
            all.push(DMat3::from_cols(u, -v, -z) * from.transpose());
        }
    }
    all
}

/// The ends of alignments from some starts, the best first, each once.
fn best(
    mesh: &Mesh,
    coarse: &[Sample],
    target: &Target,
    starts: Vec<Motion>,
    scale: bool,
    cancel: &Cancel,
) -> Vec<Motion> {
    let with = |rounds, kept| Settings {
        rounds,
        kept,
        scale,
        ridge: RIDGE,
    };
    let span = Moments::new(coarse).span;
    let from = |start: &Motion| {
        let end = aligned(coarse, target, *start, &with(COARSE, KEPT), cancel);
        ranked(coarse, target, end)
    };
    let mut ends: Vec<Aligned> = starts.par_iter().map(from).collect();
    ends.sort_by(|a, b| a.rms.total_cmp(&b.rms));
    let ends = distinct(ends, coarse, span, REFINED);
    let fine = samples(mesh, MANY_SAMPLES);
    let from = |end: &Aligned| {
        let first = aligned(&fine, target, end.motion, &with(FINE, KEPT), cancel);
        // Where nearly all samples say the same as the nearest, they say it better: details of a sphere are its farthest samples.
        let mut end = first;
        for kept in NEARLY_ALL {
            let all = aligned(&fine, target, end.motion, &with(FINE, kept), cancel);
            let own = distance(&fine, target, &all.motion, KEPT);
            if own <= AS_NEAR * first.rms {
                end = all;
            }
        }
        ranked(&fine, target, end)
    };
    let mut ends: Vec<Aligned> = ends.par_iter().map(from).collect();
    ends.sort_by(|a, b| a.rms.total_cmp(&b.rms));
    let least = ends.first().map_or(0.0, |e| e.rms);
    // The distance is measured on the target: a template may have another unit.
    let own = |e: &Aligned| e.rms / e.motion.scale();
    let ends = distinct(ends, coarse, span, MOST);
    let fits = |e: &Aligned| own(e) < FARTHEST * span && e.rms <= ALIKE * least.max(1e-6 * span);
    ends.into_iter().filter(fits).map(|e| e.motion).collect()
}

/// An alignment with the distance by which it is ranked: the geometric mean of the distance of the nearest samples, which leaves out what is damaged,
/// and the distance of nearly all, which has the details of a body that slides on itself.
fn ranked(samples: &[Sample], target: &Target, end: Aligned) -> Aligned {
    let of = |kept| distance(samples, target, &end.motion, kept);
    Aligned {
        rms: (of(KEPT) * of(NEARLY_ALL[1])).sqrt(),
        ..end
    }
}

/// The first alignments that differ from all before, up to a number.
fn distinct(ends: Vec<Aligned>, samples: &[Sample], span: f64, most: usize) -> Vec<Aligned> {
    let mut kept: Vec<Aligned> = Vec::new();
    for end in ends.into_iter().filter(|e| e.rms.is_finite()) {
        let is_same = |other: &Aligned| {
            let apart = |s: &Sample| end.motion.at(s.point).distance(other.motion.at(s.point));
            let mean = samples.iter().map(apart).sum::<f64>() / samples.len() as f64;
            mean < SAME * span * end.motion.scale()
        };
        if kept.len() < most && !kept.iter().any(is_same) {
            kept.push(end);
        }
    }
    kept
}

/// A direction of a half sphere, evenly (Á. González, "Measurement of areas on a sphere using Fibonacci and latitude-longitude
/// lattices", 2010).
fn half_sphere(i: usize) -> DVec3 {
    let z = 1.0 - (i as f64 + 0.5) / DIRECTIONS as f64;
    let turn = PI * (3.0 - 5.0_f64.sqrt()) * i as f64;
    let wide = (1.0 - z * z).sqrt();
    DVec3::new(wide * turn.cos(), wide * turn.sin(), z)
}
