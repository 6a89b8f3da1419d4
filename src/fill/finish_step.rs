//! The finish of a region's patch, and the second start: a triangulation of the rim, faired.

use std::collections::HashSet;

use glam::DVec3;

use super::candidate::{FinishReport, FinishedPatch, PatchStart};
use super::outcome::{ClosedBy, HoleOutcome, TriangulatedReason, TryFailure};
use super::params::Finish;
use super::problem::RegionProblem;
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::strategy::{Try, Verdict, failures};
use crate::cancel::Cancel;
use crate::finish::{
    FinishFound, FinishMethod, FinishParams, Refusal, Surroundings, biharmonic, finish,
    minimal_surface,
};
use crate::mesh::{Hole, Mesh, Part, bounds};
use crate::region::Sphere;
use crate::stitch::{Patch, count_intersecting, flipped, refined_triangulation};

/// How far round the rims the mesh is looked at, in diagonals of their bounding box. The finish asks for 0.68 of a hole's
/// diameter, along the surface.
const REACH: f64 = 0.8;
/// Rims of more edges get no second start: its triangulation takes time with the cube of their number, and what is as large is
/// seldom told by its rim alone.
const MOST_EDGES: usize = 400;
/// Rims of at most so many edges get one for a hundredth of what the level set takes,
pub(super) const CHEAP_EDGES: usize = 60;
/// and get it where ½∫h² of the finished patch is more than this: such a surface, as bent as a cap of 140° of a sphere, may be one
/// minimum of several.
const BENT: f64 = 8.0;
/// How often the second start is filled and its edges flipped before it is filled at last.
const FAIRINGS: usize = 2;

/// The part of the mesh round a patch, with the patch in it.
struct Local {
    part: Part,
    /// Number of vertices of the whole mesh.
    count: usize,
    /// The part and the patch's faces and vertices behind its own.
    joined: Mesh,
    cancel: Cancel,
}

impl Local {
    /// With a patch whose faces have the whole mesh's numbers.
    fn new(part: Part, count: usize, patch: &Patch, cancel: &Cancel) -> Self {
        let own = part.mesh.positions.len() as u32;
        let local = |v: u32| match v.checked_sub(count as u32) {
            Some(new) => own + new,
            None => part.local(v),
        };
        let faces: Vec<[u32; 3]> = patch.faces.iter().map(|f| f.map(local)).collect();
        Self::of_part(part, count, (&patch.positions, &faces), cancel)
    }

    /// With a patch whose faces have the part's numbers.
    fn of_part(
        part: Part,
        count: usize,
        (positions, faces): (&[DVec3], &[[u32; 3]]),
        cancel: &Cancel,
    ) -> Self {
        let joined = part.mesh.clone();
        let mut local = Self {
            part,
            count,
            joined,
            cancel: cancel.clone(),
        };
        local.set_patch(positions, faces);
        local
    }

    /// Takes another patch in the place of its own.
    fn set_patch(&mut self, positions: &[DVec3], faces: &[[u32; 3]]) {
        let own = &self.part.mesh;
        self.joined.positions.truncate(own.positions.len());
        self.joined.faces.truncate(own.faces.len());
        self.joined.positions.extend_from_slice(positions);
        self.joined.faces.extend_from_slice(faces);
    }

    /// What is round the patch, and which vertices are not its own.
    fn around(&self) -> Surroundings<'_> {
        let own = self.part.mesh.positions.len();
        Surroundings::new(&self.joined, |v| (v as usize) < own).stopped_by(&self.cancel)
    }

    /// The numbers of the patch's own vertices.
    fn new_vertices(&self) -> Vec<u32> {
        (self.part.mesh.positions.len() as u32..self.joined.positions.len() as u32).collect()
    }

    fn new_faces(&self) -> &[[u32; 3]] {
        &self.joined.faces[self.part.mesh.faces.len()..]
    }

    /// Number of the patch's faces that intersect others, were its vertices there.
    fn crossing(&self, positions: &[DVec3]) -> usize {
        count_intersecting(&self.part.mesh, positions, self.new_faces())
    }

    /// Gives a patch of the part the whole mesh's numbers.
    fn to_whole(&self, mut patch: Patch) -> Patch {
        for f in &mut patch.faces {
            *f = f.map(|v| self.part.original(v, self.count));
        }
        patch
    }
}

/// New positions of the vertices of a patch, from its triangles alone.
type LinearFill = fn(&Surroundings<'_>, &[u32]) -> Result<Vec<(u32, DVec3)>, Refusal>;

/// Moves the vertices of a patch of a part to where a fill has them; where it fails they stay.
fn fill(local: &mut Local, patch: &mut Patch, linear: LinearFill) {
    local.set_patch(&patch.positions, &patch.faces);
    let own = local.part.mesh.positions.len();
    let moved = linear(&local.around(), &local.new_vertices());
    for (v, p) in moved.into_iter().flatten() {
        patch.positions[v as usize - own] = p;
    }
    local.set_patch(&patch.positions, &patch.faces);
}

impl RegionProblem<'_> {
    /// Whether its patch is finished.
    pub(super) fn is_finished(&self) -> bool {
        self.params.finishes() && self.previous.is_none()
    }

    /// Finishes the patch of the level set, if there is one. Where there is none, or it crosses faces or is folded, and the region
    /// has one rim, that of the second start too: the better of them. Where it bends a lot, and the rim has few edges, that of
    /// the second start too, which must be much lower. None where there is neither, or patches are not finished.
    ///
    /// Both starts for every hole, and the lower energy, are not worth their time: on 132 holes of scans the error fell by 0.2 %,
    /// and where surfaces bend a lot the lower one of two alike was farther from the truth.
    pub(super) fn finish(&self, patch: Option<Patch>) -> Option<FinishedPatch> {
        if !self.is_finished() {
            return None;
        }
        let first = patch.map(|patch| self.finished(patch, PatchStart::LevelSet));
        let second = || {
            let patch = self.second_start()?;
            Some(self.finished(patch, PatchStart::Triangulation))
        };
        let is_cheap = || self.holes.iter().all(|h| h.edges <= CHEAP_EDGES);
        match first {
            Some(first) if !first.is_sound() => Some(first.or_better(second())),
            Some(first) if first.energy() > BENT && is_cheap() => {
                Some(first.or_much_lower(second()))
            }
            Some(first) => Some(first),
            None => second(),
        }
    }

    /// Moves the vertices of a patch to where the finish has them. What crosses more than before is not taken, but the step
    /// before.
    fn finished(&self, mut patch: Patch, start: PatchStart) -> FinishedPatch {
        let count = self.mesh.positions.len();
        let local = Local::new(self.wide_part(&patch), count, &patch, self.cancel);
        let own = local.part.mesh.positions.len();
        let around = local.around();
        let mut params = FinishParams::default();
        if self.params.finish == Finish::Willmore {
            params.method = FinishMethod::Willmore;
        }
        let (mut blend, mut minimum) = (patch.positions.clone(), patch.positions.clone());
        let mut sigma = vec![None; patch.positions.len()];
        let mut report = FinishReport {
            start,
            pieces: Vec::new(),
        };
        for piece in around.pieces(local.new_faces()) {
            let done = finish(&around, &piece, &params);
            for (i, &v) in done.vertices.iter().enumerate() {
                let at = v as usize - own;
                blend[at] = done.positions[i];
                minimum[at] = *done.minimum.get(i).unwrap_or(&done.positions[i]);
                sigma[at] = done.sigma.get(i).copied().filter(|s| s.is_finite());
            }
            report.pieces.push(done.found);
        }
        if self.cancel.is_cancelled() {
            sigma.fill(None);
            let report = Some(report);
            return FinishedPatch {
                patch,
                report,
                sigma,
            };
        }
        let before = patch.report.intersecting_faces;
        let fits = |positions: &[DVec3]| {
            let crossing = local.crossing(positions);
            (crossing <= before).then_some(crossing)
        };
        let taken = match fits(&blend) {
            Some(crossing) => Some((blend, crossing)),
            None => {
                report.pieces.iter_mut().for_each(FinishFound::refuse_blend);
                fits(&minimum).map(|crossing| (minimum, crossing))
            }
        };
        if let Some((positions, crossing)) = taken {
            patch.positions = positions;
            patch.report.intersecting_faces = crossing;
            let whole = |f: &[u32; 3]| f.map(|v| local.part.original(v, local.count));
            patch.measure(self.mesh, local.part.mesh.faces.iter().map(whole));
        } else {
            report.pieces.iter_mut().for_each(FinishFound::refuse_all);
            sigma.fill(None);
        }
        FinishedPatch {
            patch,
            report: Some(report),
            sigma,
        }
    }

    /// A refined triangulation of the only rim, filled biharmonically; none where there are more rims, or it cannot be had.
    fn second_start(&self) -> Option<Patch> {
        let [hole] = self.holes else {
            return None;
        };
        if self.cancel.is_cancelled() {
            return None;
        }
        let (local, patch) = self.spanned(hole, biharmonic)?;
        Some(local.to_whole(patch))
    }

    /// A refined triangulation of a rim, in the numbers of the part of the mesh that is returned with it, filled and flipped in turn.
    fn spanned(&self, hole: &Hole, linear: LinearFill) -> Option<(Local, Patch)> {
        (hole.edges <= MOST_EDGES).then_some(())?;
        let (mut local, rim, mut patch) = self.refined(hole)?;
        for _ in 0..FAIRINGS {
            fill(&mut local, &mut patch, linear);
            patch = flipped(&local.part.mesh, &rim, &patch);
        }
        fill(&mut local, &mut patch, linear);
        patch.report.intersecting_faces = local.crossing(&patch.positions);
        Some((local, patch))
    }

    /// The part of the mesh round a hole, its rim and a refined triangulation of it, both in the part's numbers.
    fn refined(&self, hole: &Hole) -> Option<(Local, Vec<u32>, Patch)> {
        let part = self.wide_part(&Patch::default());
        let rim: Vec<u32> = hole.rim.iter().map(|&v| part.local(v)).collect();
        let patch = refined_triangulation(&part.mesh, &rim, self.params.edge_ratio()).ok()?;
        let count = self.mesh.positions.len();
        let shape = (&patch.positions[..], &patch.faces[..]);
        let local = Local::of_part(part, count, shape, self.cancel);
        Some((local, rim, patch))
    }

    /// The second start of a region whose first try failed, where it is sound: then further tries are not worth their time. A part
    /// wider than its rim, which continues like a sphere, is the level set's.
    pub(super) fn instead_of_retries(
        &self,
        history: &[(Try, Verdict)],
        report: &RegionReport,
    ) -> Option<RegionPatch> {
        let Some((_, Verdict::Failed(failure))) = history.last() else {
            return None;
        };
        let is_wide = || Sphere::new(self.mesh, self.holes).is_some();
        if *failure == TryFailure::ReachedBox && is_wide() {
            return None;
        }
        let second = self.finish(None).filter(FinishedPatch::is_at_rest)?;
        let report = RegionReport {
            earlier_tries: failures(history),
            ..report.clone()
        };
        Some(self.faired(second, failure.clone(), report))
    }

    /// How far the vertices of the patch of one hole rise beyond the rim's own extent along its normal, in diameters.
    pub(super) fn rise(&self, positions: &[DVec3]) -> Option<f64> {
        let ([hole], None) = (self.holes, self.previous) else {
            return None;
        };
        let height = |p: &DVec3| (*p - hole.centre).dot(hole.normal);
        let of_rim = hole
            .rim
            .iter()
            .map(|&v| height(&self.mesh.positions[v as usize]));
        let extent = |heights: &mut dyn Iterator<Item = f64>| {
            heights.fold((0.0f64, 0.0f64), |(low, high), h| (low.min(h), high.max(h)))
        };
        let (lowest, highest) = extent(&mut of_rim.into_iter());
        let (low, high) = extent(&mut positions.iter().map(height));
        let rise = f64::max(high - highest, lowest - low).max(0.0) / hole.diameter;
        rise.is_finite().then_some(rise)
    }

    /// Closes a hole by a nearly flat cap: the surface of least area over a refined triangulation of its rim. Where that cannot
    /// be had, or crosses more than they do, by triangles between the rim's vertices.
    pub(super) fn close_flat(&self) -> RegionPatch {
        let diameter = self.holes.iter().map(|h| h.diameter).fold(0.0, f64::max);
        let report = RegionReport {
            diameter,
            ..RegionReport::default()
        };
        let flat = match self.holes {
            [hole] => self.flat_cap(hole),
            _ => None,
        };
        let sound = |patch: &&Patch| patch.report.intersecting_faces == 0;
        if let Some(patch) = flat.as_ref().filter(sound) {
            return self.capped(patch.clone(), report);
        }
        let plain = self.triangulate(TriangulatedReason::Flat, report.clone());
        let open = plain.report.closed_by == Some(ClosedBy::Nothing);
        match flat {
            Some(patch)
                if open || patch.report.intersecting_faces <= plain.report.intersecting_faces =>
            {
                self.capped(patch, report)
            }
            _ => plain,
        }
    }

    fn capped(&self, patch: Patch, mut report: RegionReport) -> RegionPatch {
        report.closed_by = Some(ClosedBy::Flat);
        self.all_finished(FinishedPatch::unfinished(patch), report, HoleOutcome::Flat)
    }

    fn flat_cap(&self, hole: &Hole) -> Option<Patch> {
        let (local, patch) = self.spanned(hole, minimal_surface)?;
        let mut patch = local.to_whole(patch);
        patch.report.components = 1;
        let whole = |f: &[u32; 3]| f.map(|v| local.part.original(v, local.count));
        patch.measure(self.mesh, local.part.mesh.faces.iter().map(whole));
        Some(patch)
    }

    /// Closes the holes by themselves: by faired triangulations, unless these cross more than triangles between their vertices.
    pub(super) fn without_level_set(&self, why: TryFailure, report: RegionReport) -> RegionPatch {
        let reason = TriangulatedReason::NoSurface(why.clone());
        let plain = self.triangulate(reason, report.clone());
        let Some(faired) = self.each_faired(why, report) else {
            return plain;
        };
        let open = plain.report.closed_by == Some(ClosedBy::Nothing);
        if open || faired.report.intersecting_faces <= plain.report.intersecting_faces {
            faired
        } else {
            plain
        }
    }

    /// Each hole closed by a faired triangulation; none where one cannot be, or two of them touch.
    fn each_faired(&self, why: TryFailure, mut report: RegionReport) -> Option<RegionPatch> {
        let mut seen = HashSet::new();
        if !self
            .holes
            .iter()
            .flat_map(|h| &h.rim)
            .all(|v| seen.insert(*v))
        {
            return None;
        }
        let count = self.mesh.positions.len() as u32;
        let mut all = FinishedPatch::unfinished(Patch::default());
        let mut pieces = Vec::new();
        let (mut angles, mut shapes) = (0.0, 0.0);
        for hole in self.holes {
            report.diameter = report.diameter.max(hole.diameter);
            let one = RegionProblem {
                holes: &[hole],
                ..*self
            };
            let finished = one.finish(None)?;
            let base = all.patch.positions.len() as u32;
            let moved = |v: u32| if v < count { v } else { v + base };
            let (own, sum) = (&finished.patch.report, &mut all.patch.report);
            sum.components += own.components;
            sum.seam_angle_max = sum.seam_angle_max.max(own.seam_angle_max);
            angles += own.seam_angle_mean * hole.edges as f64;
            shapes += own.quality_mean * finished.patch.faces.len() as f64;
            all.patch.positions.extend(&finished.patch.positions);
            all.patch
                .faces
                .extend(finished.patch.faces.iter().map(|f| f.map(moved)));
            all.sigma.extend(finished.sigma);
            pieces.extend(finished.report.into_iter().flat_map(|r| r.pieces));
        }
        let edges: usize = self.holes.iter().map(|h| h.edges).sum();
        all.patch.report.seam_angle_mean = angles / edges as f64;
        all.patch.report.quality_mean = shapes / all.patch.faces.len().max(1) as f64;
        all.report = Some(FinishReport {
            start: PatchStart::Triangulation,
            pieces,
        });
        let local = Local::new(
            self.wide_part(&all.patch),
            count as usize,
            &all.patch,
            self.cancel,
        );
        all.patch.report.intersecting_faces = local.crossing(&all.patch.positions);
        Some(self.faired(all, why, report))
    }

    /// A region closed by faired triangulations.
    pub(super) fn faired(
        &self,
        patch: FinishedPatch,
        why: TryFailure,
        mut report: RegionReport,
    ) -> RegionPatch {
        report.closed_by = Some(ClosedBy::Faired);
        self.all_finished(patch, report, HoleOutcome::Faired(why))
    }

    /// The part of the mesh round the rims and a patch.
    fn wide_part(&self, patch: &Patch) -> Part {
        let rim = || self.holes.iter().flat_map(|h| &h.rim).copied();
        let (low, high) = bounds(rim().map(|v| self.mesh.positions[v as usize]));
        let margin = DVec3::splat(REACH * low.distance(high));
        let (lowest, highest) = bounds(patch.positions.iter().copied());
        let (low, high) = (low - margin, high + margin);
        self.all.part(low.min(lowest), high.max(highest), rim())
    }
}
