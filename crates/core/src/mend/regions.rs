//! Regions of a fill: groups of holes that are filled together, their tasks and patches, and how patches are merged into the
//! mesh.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use super::bores::bores;
use super::choose::{bridges, choose, groups};
use super::control::{Control, Watch};
use super::counterpart::{self, LazyCounterpart};
use super::crease_pairs::join_creases;
use super::hole_group::{HoleGroup, hole_groups};
use super::plan::{FillPlan, PlannedHole, PlannedRegion};
use super::planar_rims::planar_rims;
use super::reach::{ReachQuery, faces_of};
use super::report::{FillReport, HoleReport, InputReport};
use super::solved_patches::SolvedPatches;
use super::sources::RegionSources;
use super::task::RegionTask;
use super::{FillError, Filled, Inspection};
use crate::cancel::Cancel;
use crate::fill::widest_growth;
use crate::fill::{
    Closure, FillParams, HoleOutcome, PlacedPart, ReferenceSurface, RegionPatch, RegionProblem,
    RegionReport, first_region, has_few_edges,
};
use crate::flow::{BendingEnergy, Energy};
use crate::mesh::{Hole, HoleId, Mesh};
use crate::region::{Region, VoxelSize};
use crate::stitch::count_intersecting_faces;
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Unknowns times steps. Budget of the retries at a region: about six seconds of one core.
const BUDGET: Tunable<u64> = tunable("fill.budget", 1_000_000);

/// Number of regions whose faces are found in one pass over the mesh.
const AT_A_TIME: usize = 16;

/// A fill divided into regions, which can be solved one by one, anywhere, and merged.
///
/// ```
/// # use isomend::{Control, FillParams, Inspection, Mesh, glam::DVec3};
/// # let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(DVec3::from_array);
/// # let mesh = Mesh::new(corners.to_vec(), vec![[0, 2, 1], [0, 1, 3], [0, 3, 2]]);
/// # let mut params = FillParams::default();
/// # params.holes = Some(vec![1.into()]);
/// let found = Inspection::new(&mesh)?;
/// let regions = found.regions(&params)?;
/// let patches = regions.tasks().map(|task| task.solve(&Control::new()));
/// let filled = regions.assemble(patches.collect::<Result<_, _>>()?)?;
/// assert_eq!(filled.mesh, isomend::fill(&mesh, &params)?.mesh);
/// # Ok::<(), isomend::FillError>(())
/// ```
pub struct Regions<'a> {
    pub(super) found: &'a Inspection<'a>,
    pub(super) params: FillParams,
    /// The caller's energy, if the flow minimises it.
    pub(super) own: Option<&'a dyn BendingEnergy>,
    /// The surface before a cut whose shape is partly kept, if any.
    pub(super) reference: Option<&'a ReferenceSurface<'a>>,
    /// Outcomes of the holes that belong to no region.
    outcomes: Vec<HoleOutcome>,
    /// The holes of each region, and what is decided for it.
    pub(super) groups: Vec<HoleGroup>,
    /// Upper bound of the cost of a region's level-set retries, in unknowns times steps.
    budget: u64,
    /// Patches of earlier fills of the same run.
    pub(super) before: Option<&'a SolvedPatches>,
    /// The counterpart after which holes are filled, found when it is first asked for.
    counterpart: LazyCounterpart<'a>,
}

impl Inspection<'_> {
    /// The regions of a fill.
    ///
    /// # Errors
    /// If the parameters are invalid.
    pub fn regions(&self, params: &FillParams) -> Result<Regions<'_>, FillError> {
        Regions::new(self, params.clone(), None)
    }
}

impl<'a> Regions<'a> {
    pub(super) fn new(
        found: &'a Inspection,
        mut params: FillParams,
        reference: Option<&'a ReferenceSurface<'a>>,
    ) -> Result<Self, FillError> {
        params.check()?;
        counterpart::check(&params, &found.input)?;
        let bridges = bridges(found, &params)?;
        let (mut outcomes, chosen) = choose(found, &params, &bridges)?;
        let caps = match reference {
            None => planar_rims(found, &params, &chosen),
            Some(_) => Vec::new(),
        };
        let capped = caps.iter().flatten().map(|&h| found.holes[h].id);
        params.flat.extend(capped);
        let joined = match reference {
            None => [bridges, bores(found, &params, &chosen)].concat(),
            Some(_) => bridges,
        };
        let groups = groups(found, &params, (&chosen, &caps), &mut outcomes, &joined);
        let mut groups = hole_groups(found, &params, groups);
        join_creases(found, &params, &mut groups)?;
        let new = Self {
            found,
            groups,
            params,
            own: None,
            reference,
            outcomes,
            budget: BUDGET.get(),
            before: None,
            counterpart: LazyCounterpart::new(found),
        };
        new.check_voxel()?;
        Ok(new)
    }

    /// The same regions with an energy of the caller's.
    pub(super) fn by(mut self, energy: &'a dyn BendingEnergy) -> Self {
        self.params.energy = Energy::Own;
        self.own = Some(energy);
        self
    }

    /// The same regions with at most one level set for each, where others than level sets come next.
    pub(crate) fn without_retries(mut self) -> Self {
        self.budget = 0;
        self
    }

    /// The same regions, of which those that were solved before in the same run are not solved again.
    pub(crate) fn after(mut self, before: &'a SolvedPatches) -> Self {
        self.before = Some(before);
        self
    }

    /// Number of regions.
    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// Whether there is nothing to fill.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// The task of each region as an independent value, which can be sent elsewhere.
    ///
    /// Each holds a copy of the part of the mesh that its region usually needs, so they are made one at a time. A region that
    /// needs more reports it with its patch ([`RegionPatch::is_cramped`]).
    pub fn tasks(&self) -> impl Iterator<Item = RegionTask> {
        let sources = Arc::new(self.sources(None));
        let several = (0..self.len()).step_by(AT_A_TIME);
        several.flat_map(move |first| {
            let regions = first..self.len().min(first + AT_A_TIME);
            self.tasks_of(sources.clone(), regions, 1.0)
        })
    }

    /// The task of a region, by its index, with all of the mesh that the region may need; none where there is no such region.
    pub fn wide_task(&self, region: usize) -> Option<RegionTask> {
        let regions = region..self.len().min(region + 1);
        self.tasks_of(Arc::new(self.sources(None)), regions, widest_growth())
            .next()
    }

    /// The tasks of some regions, whose boxes' margins may grow by this factor.
    fn tasks_of(
        &self,
        sources: Arc<RegionSources<'a>>,
        regions: Range<usize>,
        growth: f64,
    ) -> impl Iterator<Item = RegionTask> {
        let mut counterparts = self
            .counterparts(regions.clone(), &Cancel::new())
            .into_iter();
        let query = |i: usize| self.query(i, &sources, counterparts.next().flatten(), growth);
        let query: Vec<ReachQuery> = regions.clone().map(query).collect();
        let degenerate = sources.degenerate();
        let faces = faces_of(self.found, degenerate, &query, self.params.voxel);
        regions
            .zip(query.into_iter().zip(faces))
            .map(move |(i, (query, faces))| {
                let faces = sources.with_rings(&faces);
                let centres = sources.centres(i);
                RegionTask::new(i + 1, self.found, &query, &faces, centres, &self.params)
            })
    }

    /// The plan of the fill.
    pub fn plan(&self) -> FillPlan {
        let found = self.found;
        let hole = |(hole, outcome): (&Hole, &HoleOutcome)| PlannedHole {
            hole: hole.clone(),
            outcome: match outcome {
                HoleOutcome::Left(why) => Some(HoleOutcome::Left(*why)),
                _ => None,
            },
            region: 0,
        };
        let mut holes: Vec<PlannedHole> =
            found.holes.iter().zip(&self.outcomes).map(hole).collect();
        for (i, group) in self.groups.iter().enumerate() {
            for &h in &group.holes {
                holes[h].region = i + 1;
                holes[h].outcome = group.decided.clone().map(HoleOutcome::Closed);
            }
        }
        FillPlan {
            input: InputReport::of(found),
            holes,
            regions: (0..self.len()).map(|i| self.planned(i)).collect(),
        }
    }

    /// Fills all regions, each independently, and merges their patches.
    pub(crate) fn fill(&self, watch: &Watch) -> Result<Filled, FillError> {
        let clock = Instant::now();
        let all: Vec<usize> = (0..self.len()).collect();
        let patches = self.patches(&all, watch);
        watch.finish()?;
        let mut filled = self.assemble(patches)?;
        filled.report.seconds = clock.elapsed().as_secs_f64();
        Ok(filled)
    }

    /// The holes of each region.
    pub(crate) fn hole_groups(&self) -> impl Iterator<Item = Vec<&Hole>> {
        self.groups.iter().map(|group| self.holes(group))
    }

    /// Estimated work of each region: the square of the voxels across its first grid.
    pub(crate) fn expected_work(&self) -> Vec<f64> {
        let work = |group: &HoleGroup| {
            if group.decided.is_some() {
                return 0.0;
            }
            let region = first_region(&self.found.mesh, &self.holes(group), &self.params);
            (region.diameter / region.voxel).powi(2)
        };
        self.groups.iter().map(work).collect()
    }

    /// Computes the patches of some regions.
    fn patches(&self, regions: &[usize], watch: &Watch) -> Vec<RegionPatch> {
        if regions.is_empty() {
            return Vec::new();
        }
        // A reference surface may be needed outside a region's box: only without one is the search limited to the boxes.
        let in_boxes = self.reference.is_none().then_some(self.params.voxel);
        let sources = self.sources(in_boxes);
        let counterparts = self.counterparts(regions.iter().copied(), watch.token());
        let framed = self.framed(regions, &sources, &counterparts, watch);
        let fill = |((&i, counterparts), framed): (
            (&usize, &Option<Vec<PlacedPart>>),
            Option<RegionPatch>,
        )| {
            if let Some(patch) = framed {
                return patch;
            }
            let group = &self.groups[i];
            let ids: Vec<HoleId> = self.holes(group).iter().map(|h| h.id).collect();
            watch.begin(&ids);
            let [known, all] = sources.of(i);
            let work = RegionProblem {
                id: i + 1,
                mesh: &self.found.mesh,
                holes: &self.holes(group),
                decided: group.decided.as_ref(),
                known: &known,
                all: &all,
                joined: &group.joined,
                base: group.base,
                counterparts: counterparts.as_deref(),
                most_growth: f64::INFINITY,
                budget: self.budget,
                params: &self.params,
                own: self.own,
                reference: self.reference,
                extent: self.reference.and_then(|d| d.extent(&group.holes)),
                keep_going: &|| watch.keep_going(),
                cancel: watch.token(),
            };
            let patch = work.fill();
            watch.end(i, &patch.report);
            patch
        };
        regions
            .par_iter()
            .zip(&counterparts)
            .zip(framed)
            .map(fill)
            .collect_indexed()
    }

    /// The query for the faces of a region whose box's margin may grow by a factor.
    pub(super) fn query(
        &self,
        region: usize,
        sources: &RegionSources<'a>,
        counterparts: Option<Vec<PlacedPart>>,
        growth: f64,
    ) -> ReachQuery<'_> {
        ReachQuery {
            counterparts,
            holes: self.holes(&self.groups[region]),
            known: sources.known_components(region),
            joined: &self.groups[region].joined,
            base: self.groups[region].base,
            growth,
            budget: self.budget,
        }
    }

    /// Appends the patches of all regions, in order, to the mesh. Regions that need more of the mesh than their tasks hold are
    /// computed first.
    ///
    /// # Errors
    /// [`FillError::Patches`] if the patches do not belong to these regions.
    pub fn assemble(&self, mut patches: Vec<RegionPatch>) -> Result<Filled, FillError> {
        let regions = self.len();
        let wrong = patches.iter().zip(1..).find(|(p, id)| p.report.id != *id);
        if patches.len() != regions || wrong.is_some() {
            let patches = wrong.map_or(patches.len(), |(p, _)| p.report.id);
            return Err(FillError::Patches { regions, patches });
        }
        let cramped: Vec<usize> = (0..regions).filter(|&i| patches[i].is_cramped()).collect();
        let watch = Watch::new(Control::new(), vec![1.0; regions]);
        for (&i, patch) in cramped.iter().zip(self.patches(&cramped, &watch)) {
            patches[i] = patch;
        }
        let input = &*self.found.input;
        // Of exactly the needed size: a clone that grows would take twice its own.
        let all = |count: fn(&Mesh) -> usize| {
            count(input) + patches.iter().map(|p| count(&p.mesh)).sum::<usize>()
        };
        let mut mesh = Mesh::new(
            Vec::with_capacity(all(|mesh| mesh.positions.len())),
            Vec::with_capacity(all(|mesh| mesh.faces.len())),
        );
        mesh.positions.extend(&input.positions);
        mesh.faces.extend(&input.faces);
        let mut report = self.report();
        let mut expected_error = Vec::new();
        for (i, patch) in patches.into_iter().enumerate() {
            for (&h, outcome) in self.groups[i].holes.iter().zip(patch.outcomes) {
                report.holes[h].outcome = outcome;
                report.holes[h].region = i + 1;
            }
            append(&mut mesh, input.positions.len(), &patch.mesh);
            expected_error.extend(patch.expected_error);
            report.regions.push(patch.report);
        }
        // A region knows only the mesh and its own patch, so patches of other regions are tested here.
        recount_intersections(&mesh, input.faces.len(), &mut report.regions);
        Ok(Filled {
            mesh,
            expected_error,
            report,
        })
    }

    /// The report before anything is filled.
    fn report(&self) -> FillReport {
        let found = self.found;
        let holes = found.holes.iter().zip(&self.outcomes);
        FillReport {
            all_holes: self.params.holes.is_none(),
            holes: holes
                .map(|(hole, outcome)| HoleReport {
                    hole: hole.clone(),
                    outcome: outcome.clone(),
                    region: 0,
                })
                .collect(),
            ..FillReport::of(found)
        }
    }

    fn holes(&self, group: &HoleGroup) -> Vec<&'a Hole> {
        group.holes.iter().map(|&h| &self.found.holes[h]).collect()
    }

    /// For each of some regions the parts of the counterpart at its holes; none without a counterpart.
    fn counterparts(
        &self,
        regions: impl Iterator<Item = usize>,
        cancel: &Cancel,
    ) -> Vec<Option<Vec<PlacedPart>>> {
        let of = |i: usize| {
            let is_surface = self.groups[i].decided.is_none() && self.reference.is_none();
            let holes = self.holes(&self.groups[i]);
            is_surface.then(|| self.counterpart.parts(&self.params, &holes, cancel))?
        };
        regions.map(of).collect()
    }

    fn sources(&self, in_boxes: Option<VoxelSize>) -> RegionSources<'a> {
        let is_trivial = |decided| matches!(decided, &Some(Closure::RimTriangles(_)));
        let asked = |group: usize| !is_trivial(&self.groups[group].decided);
        RegionSources::new(self.found, &self.groups, &asked, in_boxes)
    }

    /// Refuses a voxel that is too small for the widest region, or larger than it. For a fairing the limit depends on the area, and is
    /// checked there.
    fn check_voxel(&self) -> Result<(), FillError> {
        let VoxelSize::Length(voxel) = self.params.voxel else {
            return Ok(());
        };
        if self.reference.is_some_and(|d| d.time().is_some()) {
            return Ok(());
        }
        let mut widest: f64 = 0.0;
        for group in &self.groups {
            if group.decided.is_some() {
                continue;
            }
            let holes = self.holes(group);
            let part = self.reference.and_then(|d| d.extent(&group.holes));
            let part = part.map_or(0.0, |(low, high)| (high - low).max_element());
            widest = holes
                .iter()
                .map(|h| h.diameter)
                .fold(widest.max(part), f64::max);
        }
        let fits = Region::finest(widest);
        if voxel < fits {
            return Err(FillError::TooFine { voxel, fits });
        }
        if widest > 0.0 && voxel > widest {
            return Err(FillError::TooCoarse { voxel, widest });
        }
        Ok(())
    }

    fn planned(&self, region: usize) -> PlannedRegion {
        let holes = self.holes(&self.groups[region]);
        let is_faired = self.reference.is_none() && has_few_edges(&holes, &self.params);
        let is_solved = self.groups[region].decided.is_none() && !is_faired;
        let grid = is_solved.then(|| first_region(&self.found.mesh, &holes, &self.params));
        let ids: Vec<HoleId> = holes.iter().map(|h| h.id).collect();
        PlannedRegion {
            id: region + 1,
            bridge: self.params.bridges(&ids),
            diameter: holes.iter().map(|h| h.diameter).fold(0.0, f64::max),
            voxel: grid.as_ref().map(|g| g.voxel),
            dims: grid.as_ref().map(Region::finest_dims),
            holes: ids,
        }
    }
}

/// Counts the faces of each region's patch that intersect any other face of the mesh. The patches follow the first `kept` faces.
pub fn recount_intersections(mesh: &Mesh, kept: usize, regions: &mut [RegionReport]) {
    let patches: Vec<usize> = regions.iter().map(|r| r.new_faces).collect();
    let counts = count_intersecting_faces(mesh, kept, &patches);
    for (region, count) in regions.iter_mut().zip(counts) {
        region.set_intersecting(count);
    }
}

fn append(out: &mut Mesh, original: usize, patch: &Mesh) {
    let base = out.positions.len();
    out.positions.extend_from_slice(&patch.positions);
    out.faces.extend(patch.faces.iter().map(|f| {
        f.map(|v| {
            if (v as usize) < original {
                v
            } else {
                (v as usize - original + base) as u32
            }
        })
    }));
}
