//! Global registration of a mesh with its counterpart: finds planes of symmetry, and poses of a template.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::align::{Aligned, SHORTEST_STEP, Sample, Settings, Target, aligned, distance, samples};
use super::motion::Motion;
use crate::cancel::Cancel;
use crate::elementary::{cos, sin, sin_cos};
use crate::linalg::{second_moments, symmetric_eigen};
use crate::mesh::Mesh;
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Number of samples of the coarse alignments and of the fine ones.
const FEW_SAMPLES: Tunable<usize> = tunable("fill.find.few_samples", 400);
const MANY_SAMPLES: Tunable<usize> = tunable("fill.find.many_samples", 1500);
/// Number of initial plane normals besides the principal axes, evenly on a half sphere, about 15° apart. If principal moments are equal,
/// principal axes are arbitrary.
const DIRECTIONS: Tunable<usize> = tunable("fill.find.directions", 90);
/// Number of initial rotations about each principal axis of the template, for both directions of the axis.
const TURNS: Tunable<usize> = tunable("fill.find.turns", 8);
/// Upper bounds of the iterations of a coarse and of a fine alignment.
const COARSE: Tunable<usize> = tunable("fill.find.coarse", 8);
const FINE: Tunable<usize> = tunable("fill.find.fine", 60);
/// Fraction of the samples used: a quarter of the surface may have no counterpart.
const KEPT: Tunable<f64> = tunable("fill.find.kept", 0.75);
/// Fractions of the samples used by the last alignments. The result of each is accepted if the distance of the nearest samples
/// ([`KEPT`]) is at most [`AS_NEAR`] times as large as before.
const NEARLY_ALL: [f64; 2] = [0.93, 0.985];
const AS_NEAR: Tunable<f64> = tunable("fill.find.as_near", 1.2);
/// See [`Settings::ridge`].
const RIDGE: f64 = 1e-6;
/// Upper bounds of the number of coarse results that are refined, and of the motions that are returned.
const REFINED: Tunable<usize> = tunable("fill.find.refined", 10);
const MOST: Tunable<usize> = tunable("fill.find.most", 4);
/// The same numbers of samples and of results for a search that nobody asked for.
const FEW_SAMPLES_QUICK: Tunable<usize> = tunable("fill.find.few_samples_quick", 150);
const MANY_SAMPLES_QUICK: Tunable<usize> = tunable("fill.find.many_samples_quick", 600);
const REFINED_QUICK: Tunable<usize> = tunable("fill.find.refined_quick", 3);
/// Upper bound of the iterations of a fine alignment there, and the step that ends one: its result is aligned again with the faces round
/// each hole.
const FINE_QUICK: Tunable<usize> = tunable("fill.find.fine_quick", 15);
const STEP_QUICK: Tunable<f64> = tunable("fill.find.step_quick", 1e-4);
/// Spans. Upper bound of the root mean square distance of a symmetry or pose.
const FARTHEST: Tunable<f64> = tunable("fill.find.farthest", 0.1);
/// Spans. A template whose rigid motions have a smaller distance is not scaled.
const CLOSELY: Tunable<f64> = tunable("fill.find.closely", 0.002);
/// Upper bound of the distance of a scaled template over its distance unscaled.
const NEARER_IF_SCALED: Tunable<f64> = tunable("fill.find.nearer_if_scaled", 0.5);
/// Upper bound of a motion's distance over the best motion's.
const ALIKE: Tunable<f64> = tunable("fill.find.alike", 4.0);
/// Spans. Motions whose mean difference on the samples is smaller count as the same.
const SAME: Tunable<f64> = tunable("fill.find.same", 0.02);
/// Spans. Upper bound of the mean distance between the samples and the same samples reflected twice.
const INVOLUTION: Tunable<f64> = tunable("fill.find.involution", 0.05);

/// What motions are searched, and how thoroughly.
pub(super) struct Search {
    /// Whether motions scale.
    scale: bool,
    /// Number of samples of the coarse alignments.
    few: usize,
    /// Number of samples of the fine alignments.
    many: usize,
    /// Upper bound of the number of coarse results that are refined.
    refined: usize,
    /// Upper bound of the iterations of a fine alignment.
    fine: usize,
    /// See [`Settings::shortest_step`].
    shortest_step: f64,
}

impl Search {
    /// For a counterpart that the caller asked for.
    pub(super) fn full(scale: bool) -> Self {
        Self {
            scale,
            few: FEW_SAMPLES.get(),
            many: MANY_SAMPLES.get(),
            refined: REFINED.get(),
            fine: FINE.get(),
            shortest_step: SHORTEST_STEP,
        }
    }

    /// For a mirror image that is tried without being asked for.
    pub(super) fn quick() -> Self {
        Self {
            scale: false,
            few: FEW_SAMPLES_QUICK.get(),
            many: MANY_SAMPLES_QUICK.get(),
            refined: REFINED_QUICK.get(),
            fine: FINE_QUICK.get(),
            shortest_step: STEP_QUICK.get(),
        }
    }
}

/// Centre, principal axes and span (root mean square distance from the centre) of points.
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

/// The reflections that map a mesh approximately onto itself, the best first; empty without a symmetry.
pub(super) fn mirrors(
    mesh: &Mesh,
    target: &Target,
    search: &Search,
    cancel: &Cancel,
) -> Vec<Motion> {
    let coarse = samples(mesh, search.few);
    let moments = Moments::new(&coarse);
    let around = (0..DIRECTIONS.get()).map(half_sphere);
    let normals: Vec<DVec3> = moments.axes.into_iter().chain(around).collect();
    let starts = normals
        .iter()
        .map(|n| Motion::reflection(moments.centre, *n));
    let ends = best(mesh, &coarse, target, starts.collect(), search, cancel);
    let ends = ends.into_iter().map(|end| end.motion);
    let is_symmetry = |m: &Motion| {
        let back = |s: &Sample| m.at(m.at(s.point)).distance(s.point);
        let mean = coarse.iter().map(back).sum::<f64>() / coarse.len().max(1) as f64;
        m.is_reflection() && mean < INVOLUTION.get() * moments.span
    };
    ends.filter(is_symmetry).collect()
}

/// The motions that map a mesh onto a template, the best first; empty if none fits. They scale only if no rigid motion fits closely, and
/// the distance is less than half the distance of the best rigid motion.
pub(super) fn poses(mesh: &Mesh, template: &Mesh, target: &Target, cancel: &Cancel) -> Vec<Motion> {
    let coarse = samples(mesh, FEW_SAMPLES.get());
    let (own, other) = (
        Moments::new(&coarse),
        Moments::new(&samples(template, FEW_SAMPLES.get())),
    );
    let found = |scale: bool| {
        let factor = match scale && own.span > 0.0 {
            true => other.span / own.span,
            false => 1.0,
        };
        // Initial motions: none, equal centres, and rotations relative to the principal axes.
        let mut starts = vec![
            Motion::IDENTITY,
            Motion::about(DMat3::IDENTITY * factor, own.centre, other.centre),
        ];
        for turn in frames(own.axes, other.axes) {
            starts.push(Motion::about(turn * factor, own.centre, other.centre));
        }
        best(mesh, &coarse, target, starts, &Search::full(scale), cancel)
    };
    let least = |ends: &[Aligned]| ends.first().map_or(f64::INFINITY, own_distance);
    let mut ends = found(false);
    if least(&ends) > CLOSELY.get() * own.span {
        let scaled = found(true);
        if least(&scaled) < NEARER_IF_SCALED.get() * least(&ends) {
            ends = scaled;
        }
    }
    ends.into_iter().map(|end| end.motion).collect()
}

/// The distance by which an alignment is ranked, in the mesh's unit.
fn own_distance(end: &Aligned) -> f64 {
    end.rms / end.motion.scale()
}

/// Rotations that map one principal axis of a frame to one of another, in both directions, with [`TURNS`] rotations about it. They contain
/// all rotations that align the axes.
fn frames(from: [DVec3; 3], to: [DVec3; 3]) -> Vec<DMat3> {
    let right = |[x, y, _]: [DVec3; 3]| DMat3::from_cols(x, y, x.cross(y));
    let (from, to) = (right(from), right(to));
    let mut all = Vec::new();
    for axis in 0..3 {
        let [x, y, z] = [0, 1, 2].map(|k| to.col((axis + k) % 3));
        for k in 0..TURNS.get() {
            let (sine, cosine) = sin_cos(TAU * k as f64 / TURNS.get() as f64);
            let (u, v) = (x * cosine + y * sine, y * cosine - x * sine);
            // The frame, and the frame with the axis reversed.
            all.push(DMat3::from_cols(u, v, z) * from.transpose());
            all.push(DMat3::from_cols(u, -v, -z) * from.transpose());
        }
    }
    all
}

/// Aligns samples from several initial motions: coarsely from all, then finely from the best. Returns the different results that fit, the
/// best first.
fn best(
    mesh: &Mesh,
    coarse: &[Sample],
    target: &Target,
    starts: Vec<Motion>,
    search: &Search,
    cancel: &Cancel,
) -> Vec<Aligned> {
    let with = |rounds, kept| Settings {
        rounds,
        shortest_step: search.shortest_step,
        kept,
        scale: search.scale,
        ridge: RIDGE,
    };
    // Coarse alignment from each initial motion.
    let span = Moments::new(coarse).span;
    let from = |start: &Motion| {
        let end = aligned(
            coarse,
            target,
            *start,
            &with(COARSE.get(), KEPT.get()),
            cancel,
        );
        ranked(coarse, target, end)
    };
    let mut ends: Vec<Aligned> = starts.par_iter().map(from).collect_indexed();
    ends.sort_by(|a, b| a.rms.total_cmp(&b.rms));
    let ends = distinct(ends, coarse, span, search.refined);
    // Fine alignment of the best ones.
    let fine = samples(mesh, search.many);
    let from = |end: &Aligned| {
        let first = aligned(
            &fine,
            target,
            end.motion,
            &with(search.fine, KEPT.get()),
            cancel,
        );
        // Then with nearly all samples, if these agree with the nearest: on a sphere with details the farthest samples are the details.
        let mut end = first;
        for kept in NEARLY_ALL {
            let all = aligned(&fine, target, end.motion, &with(search.fine, kept), cancel);
            let own = distance(&fine, target, &all.motion, KEPT.get());
            if own <= AS_NEAR.get() * first.rms {
                end = all;
            }
        }
        ranked(&fine, target, end)
    };
    let mut ends: Vec<Aligned> = ends.par_iter().map(from).collect_indexed();
    ends.sort_by(|a, b| a.rms.total_cmp(&b.rms));
    // Keep the different ones that are close enough.
    let least = ends.first().map_or(0.0, own_distance);
    let ends = distinct(ends, coarse, span, MOST.get());
    let farthest = (FARTHEST.get() * span).min(ALIKE.get() * least.max(1e-6 * span));
    let is_close = |end: &Aligned| own_distance(end) <= farthest;
    ends.into_iter().filter(is_close).collect()
}

/// An alignment with the distance by which it is ranked: the geometric mean of the distance of the nearest samples, which excludes damage,
/// and the distance of nearly all samples, which includes the details of a body that slides on itself.
fn ranked(samples: &[Sample], target: &Target, end: Aligned) -> Aligned {
    let of = |kept| distance(samples, target, &end.motion, kept);
    Aligned {
        rms: (of(KEPT.get()) * of(NEARLY_ALL[1])).sqrt(),
        ..end
    }
}

/// The first alignments, at most `most`, that differ from all before them.
fn distinct(ends: Vec<Aligned>, samples: &[Sample], span: f64, most: usize) -> Vec<Aligned> {
    let mut kept: Vec<Aligned> = Vec::new();
    for end in ends.into_iter().filter(|e| e.rms.is_finite()) {
        let is_same = |other: &Aligned| {
            let apart = |s: &Sample| end.motion.at(s.point).distance(other.motion.at(s.point));
            let mean = samples.iter().map(apart).sum::<f64>() / samples.len() as f64;
            mean < SAME.get() * span * end.motion.scale()
        };
        if kept.len() < most && !kept.iter().any(is_same) {
            kept.push(end);
        }
    }
    kept
}

/// Direction `i` of [`DIRECTIONS`] on a Fibonacci lattice of the half sphere (Á. González, "Measurement of areas on a sphere using
/// Fibonacci and latitude-longitude lattices", 2010).
fn half_sphere(i: usize) -> DVec3 {
    let z = 1.0 - (i as f64 + 0.5) / DIRECTIONS.get() as f64;
    let turn = PI * (3.0 - 5.0_f64.sqrt()) * i as f64;
    let wide = (1.0 - z * z).sqrt();
    DVec3::new(wide * cos(turn), wide * sin(turn), z)
}
