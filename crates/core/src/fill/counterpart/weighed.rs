//! The mirror image of the mesh beside the smooth continuation of a wide hole: both are used, weighed by what each predicts.
//!
//! A smooth patch knows the faces round the hole, the mirror image knows the shape of the other side but not how much the two sides
//! differ. Their differences round the hole are kriged across it, with the standard deviation of that estimate. The two estimates of a
//! vertex are independent, so they are combined with the inverses of their variances. A hole on the plane of symmetry is its own image:
//! there the patch itself is mirrored, with its errors.

use glam::DVec3;

use super::align::Target;
use super::judge::Collar;
use super::motion::Motion;
use super::placed::PlacedPart;
use crate::elementary::{hypot, root_mean_square};
use crate::fill::candidate::FinishedPatch;
use crate::fill::finish_step::Local;
use crate::fill::invented::CounterpartReport;
use crate::fill::params::{FillParams, Finish};
use crate::fill::problem::RegionProblem;
use crate::mesh::{Hole, Mesh, area_vector};
use crate::spatial::{Bvh, Closest, middle};
use crate::tuning::{Tunable, tunable};

/// Edges. Bounds of the rims whose patches are weighed with the mirror image: narrower holes are predicted well by their surroundings, and
/// rims of more edges are solved with fewer of them.
const FEWEST_EDGES: Tunable<usize> = tunable("fill.weighed.fewest_edges", 100);
const MOST_EDGES: Tunable<usize> = tunable("fill.weighed.most_edges", 1500);
/// Expected error of the kriged difference over its standard deviation. On 18 rims of a skull 70 % of the vertices were below the expected
/// error of the patch then, and 91 % below twice of it; with 0.68 41 % and 68 %, with 1.8 74 % and 92 %.
const DEVIATION: Tunable<f64> = tunable("fill.weighed.deviation", 1.4);
/// Upper bound of the vertices round the hole at which the image is compared.
const SAMPLES: Tunable<usize> = tunable("fill.weighed.samples", 1500);
/// Upper bound of the iterations of the image's alignment with the faces round the hole: smooth walls slide on each other, so that 10
/// left patches of a skull a tenth farther from the bone.
const ROUNDS: Tunable<usize> = tunable("fill.weighed.rounds", 40);
/// The step of an alignment that ends it, far below what the image is known to.
const STEP: Tunable<f64> = tunable("fill.weighed.step", 1e-5);
/// Lower bound of the fraction of the patch's vertices that have a partner on the mirror image.
const LEAST_PARTNERS: Tunable<f64> = tunable("fill.weighed.least_partners", 0.9);
/// Lower bound of the weight of a mirror image: below it, the smooth continuation stays as it is.
const LEAST_WEIGHT: Tunable<f64> = tunable("fill.weighed.least_weight", 0.2);
/// Mean rim edges. Within this distance of the rim the mirror image has less than half of its weight, and none at the rim.
const FADE: Tunable<f64> = tunable("fill.weighed.fade", 2.0);

/// Whether the patch of these holes is weighed with the mirror image of the mesh: where each rim is closed by itself, a wide one.
pub(crate) fn is_weighed(params: &FillParams, holes: &[&Hole]) -> bool {
    let edges = FEWEST_EDGES.get()..=MOST_EDGES.get();
    let is_wide = matches!(holes, [hole] if edges.contains(&hole.edges));
    is_wide && params.apart && params.like.is_none() && params.finish == Finish::Auto
}

/// A mirror image at a patch.
struct Image {
    /// The vector from each vertex of the patch to the image, along the vertex's normal.
    offsets: Vec<DVec3>,
    /// The expected error of the image at each vertex.
    errors: Vec<f64>,
    report: CounterpartReport,
}

impl RegionProblem<'_> {
    /// A patch weighed with the mirror image, and the report of the image; the patch as it is where no image is asked for or fits.
    pub(in crate::fill) fn weighed(
        &self,
        finished: FinishedPatch,
    ) -> (FinishedPatch, Option<CounterpartReport>) {
        let parts = self.counterparts.unwrap_or_default();
        let is_asked_for = is_weighed(self.params, self.holes) && !self.cancel.is_cancelled();
        let errors: Option<Vec<f64>> = finished.expected_error.iter().copied().collect();
        let Some(errors) = errors.filter(|e| is_asked_for && !parts.is_empty() && !e.is_empty())
        else {
            return (finished, None);
        };
        let count = self.mesh.positions.len();
        let part = self.wide_part(&finished.patch);
        let local = Local::new(part, count, &finished.patch, self.cancel);
        let rim: Vec<u32> = self.holes[0]
            .rim
            .iter()
            .map(|&v| local.part.local(v))
            .collect();
        let collar = Collar::new(&local.part.mesh, &rim, self.holes[0].diameter);
        let vertices = local.vertices();
        let images = parts.iter();
        let images =
            images.filter_map(|part| self.image(part, &collar, (&local, &vertices, &errors)));
        let error = |image: &Image| root_mean_square(image.errors.iter().copied());
        let Some(image) = images.min_by(|a, b| error(a).total_cmp(&error(b))) else {
            return (finished, None);
        };
        let [smooth, other] = [root_mean_square(errors.iter().copied()), error(&image)];
        let weight = smooth.powi(2) / (smooth.powi(2) + other.powi(2));
        log::debug!(
            "region {}: mirror image of error {other:.3e} beside a smooth patch of error {smooth:.3e}: weight {weight:.2}",
            self.id
        );
        if weight.is_nan() || weight < LEAST_WEIGHT.get() {
            return (finished, None);
        }
        let Some(moved) = self.moved(&finished, &local, (&image, &errors), weight) else {
            return (finished, None);
        };
        let report = CounterpartReport {
            weight: Some(weight),
            ..image.report
        };
        (moved, Some(report))
    }

    /// The patch with its vertices moved towards the image; none where faces turn over then, or more intersect others.
    fn moved(
        &self,
        finished: &FinishedPatch,
        local: &Local,
        (image, errors): (&Image, &[f64]),
        weight: f64,
    ) -> Option<FinishedPatch> {
        let before = &finished.patch.positions;
        let rim = self.rim_positions();
        let edge = self.holes[0].length / rim.len().max(1) as f64;
        // The weight at each vertex: none at the rim.
        let fade = |p: &DVec3| {
            let squared = rim.iter().map(|q| p.distance_squared(*q));
            let squared = squared.fold(f64::INFINITY, f64::min);
            weight * squared / (squared + (FADE.get() * edge).powi(2))
        };
        let weights: Vec<f64> = before.iter().map(fade).collect();
        let moved = before.iter().zip(&image.offsets).zip(&weights);
        let positions: Vec<DVec3> = moved.map(|((p, offset), w)| *p + *offset * *w).collect();
        // Its faces must not turn over, nor intersect more others than before.
        let intersecting = local.count_intersecting(&positions);
        let own = local.part.mesh.positions.len();
        let normal = |face: &[u32; 3], own_positions: &[DVec3]| {
            area_vector(face.map(|v| match (v as usize).checked_sub(own) {
                Some(new) => own_positions[new],
                None => local.part.mesh.positions[v as usize],
            }))
        };
        let is_turned = |f: &[u32; 3]| normal(f, before).dot(normal(f, &positions)) < 0.0;
        if intersecting > finished.patch.report.intersecting_faces
            || local.new_faces().iter().any(is_turned)
        {
            log::debug!(
                "region {}: the patch weighed with the mirror image folds or intersects",
                self.id
            );
            return None;
        }
        let mut finished = FinishedPatch {
            patch: finished.patch.clone(),
            report: finished.report.clone(),
            expected_error: Vec::new(),
        };
        finished.patch.positions = positions;
        finished.patch.report.intersecting_faces = intersecting;
        let whole = |f: &[u32; 3]| f.map(|v| local.part.original(v, local.count));
        let around = local.part.mesh.faces.iter().map(whole);
        finished.patch.measure(self.mesh, around);
        // Errors of both kinds may have the same sign, so that they are not expected to cancel.
        let both = errors.iter().zip(&image.errors).zip(&weights);
        let both: Vec<f64> = both
            .map(|((smooth, other), w)| (1.0 - w) * smooth + w * other)
            .collect();
        let components = finished.report.iter_mut().flat_map(|r| &mut r.components);
        components.for_each(|record| record.set_expected_errors(&both));
        finished.expected_error = both.into_iter().map(Some).collect();
        Some(finished)
    }

    fn rim_positions(&self) -> Vec<DVec3> {
        let rim = self.holes[0].rim.iter();
        rim.map(|&v| self.mesh.positions[v as usize]).collect()
    }

    /// The mirror image at a patch; none where it does not fit the faces round the hole.
    fn image(
        &self,
        part: &PlacedPart,
        collar: &Collar,
        (local, vertices, errors): (&Local, &[(DVec3, DVec3)], &[f64]),
    ) -> Option<Image> {
        let motion = collar
            .aligned(part, (ROUNDS.get(), STEP.get()), self.cancel)
            .ok()?;
        let whole = Whole::new(part, &motion, local);
        let all: Vec<u32> = (0..whole.mesh.faces.len() as u32).collect();
        let centre = middle(&whole.mesh, all.iter().copied());
        let bvh = Bvh::for_few(&whole.mesh, all, centre);
        let target = Target {
            mesh: &whole.mesh,
            bvh: &bvh,
            border: &whole.border,
        };
        let data = collar.offsets(&target, SAMPLES.get())?;
        let field = collar.field(&data, self.cancel)?;
        // The image, moved by the field, at each vertex along its normal; its error is the field's, and the patch's too where the image is
        // the patch's own.
        let at = |(p, n): &(DVec3, DVec3)| {
            let partner = target.partner(*p, *n)?;
            let offset = *n * n.dot(partner.point + field.at(*p) - *p);
            Some((offset, whole.error(&partner, errors)))
        };
        let found: Vec<Option<(DVec3, f64)>> = vertices.iter().map(at).collect();
        let partners = found.iter().flatten().count() as f64;
        if partners < LEAST_PARTNERS.get() * found.len() as f64 {
            return None;
        }
        let report = CounterpartReport {
            kind: Some(part.kind),
            misfit: Some(root_mean_square(data.iter().map(|d| d.offset.length()))),
            ..CounterpartReport::default()
        };
        let error = |((p, _), found): (&(DVec3, DVec3), &Option<(DVec3, f64)>)| {
            let own = found.map_or(0.0, |(_, error)| error);
            hypot(DEVIATION.get() * field.deviation(*p), own)
        };
        Some(Image {
            errors: vertices.iter().zip(&found).map(error).collect(),
            offsets: continued(local, found.into_iter().map(|f| Some(f?.0)).collect()),
            report,
        })
    }
}

/// The mirror image of the faces round a hole, and of the hole's patch where that is near: a hole on the plane of symmetry is its own
/// image.
struct Whole {
    mesh: Mesh,
    /// Whether each vertex is on a boundary edge.
    border: Vec<bool>,
    /// The first face of the patch's image, and the first of its vertices that is not the mesh's.
    first_face: usize,
    first_vertex: usize,
}

impl Whole {
    /// From the part round the hole, its motion, and the patch with the faces around it.
    fn new(part: &PlacedPart, motion: &Motion, local: &Local) -> Self {
        let mut mesh = motion.moved(&part.mesh);
        let mut border = part.border.clone();
        let first_face = mesh.faces.len();
        let around = local.part.mesh.positions.len();
        let first_vertex = mesh.positions.len() + around;
        if part.own_rim.contains(&true) {
            let own = part.placing().then(motion).moved(&local.patch());
            let shift = mesh.positions.len() as u32;
            let shifted = |f: &[u32; 3]| f.map(|v| v + shift);
            mesh.faces.extend(own.faces.iter().map(shifted));
            mesh.positions.extend(own.positions);
            for (border, own) in border.iter_mut().zip(&part.own_rim) {
                *border &= !own;
            }
            border.resize(mesh.positions.len(), false);
        }
        Self {
            mesh,
            border,
            first_face,
            first_vertex,
        }
    }

    /// The expected error at a point: the patch's on the image of the patch, else none.
    fn error(&self, at: &Closest, errors: &[f64]) -> f64 {
        if (at.face as usize) < self.first_face {
            return 0.0;
        }
        let corners = self.mesh.faces[at.face as usize];
        let error = |v: u32| {
            (v as usize)
                .checked_sub(self.first_vertex)
                .map_or(0.0, |v| errors[v])
        };
        let terms = corners.iter().zip(at.barycentric);
        terms.map(|(&v, weight)| weight * error(v)).sum()
    }
}

/// The offsets of all vertices of a patch: a missing one is the mean of its neighbours', from those that have one outwards.
fn continued(local: &Local, mut offsets: Vec<Option<DVec3>>) -> Vec<DVec3> {
    let own = local.part.mesh.positions.len();
    while offsets.iter().any(Option::is_none) {
        let mut sums = vec![(DVec3::ZERO, 0.0); offsets.len()];
        for face in local.new_faces() {
            for k in 0..3 {
                let [v, w] = [face[k], face[(k + 1) % 3]].map(|v| (v as usize).checked_sub(own));
                for (v, w) in [(v, w), (w, v)] {
                    if let (Some(v), Some(w)) = (v, w)
                        && let (None, Some(offset)) = (offsets[v], offsets[w])
                    {
                        sums[v].0 += offset;
                        sums[v].1 += 1.0;
                    }
                }
            }
        }
        let found = sums.iter().any(|(_, count)| *count > 0.0);
        for (offset, (sum, count)) in offsets.iter_mut().zip(sums) {
            if offset.is_none() && (count > 0.0 || !found) {
                *offset = Some(sum / f64::max(count, 1.0));
            }
        }
    }
    offsets.into_iter().flatten().collect()
}
