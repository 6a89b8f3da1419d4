//! The search of a repair: plans are orders of steps, tried from the one that loses least to the one that loses most, until the
//! result of one is sound and has the input's shape. Else the best result is taken.

use std::collections::HashSet;

use super::bodies::Given;
use super::draft::Draft;
use super::filling::Filling;
use super::genus::Genus;
use super::plan_quality::{DESTROYED, PlanQuality};
use super::relax::RELAXED_FACES;
use super::witness::{Shape, Witness};
use super::{Carried, RepairReport, RepairStep, Run, border, dangling, orient, relax};
use crate::mend::{FillError, HoleReport};
use crate::spatial::intersecting_pairs;
use crate::tuning::{Tunable, tunable};

/// Fraction of the boundary edges as given. If cleaning leaves fewer, they were cracks, and holes are not filled before cleaning:
/// a tube of 2,500 faces with cracks spent three of four seconds on patches of cracks, which destroyed it.
const CRACKED_REST: Tunable<f64> = tunable("repair.cracked_rest", 0.5);

/// Faces. If all unions leave more intersecting ones, and more than the fraction `LEFT_PART`, none are cut out.
const LEFT_FACES: Tunable<usize> = tunable("repair.left_faces", 200);

/// Fraction of all faces: see `LEFT_FACES`.
const LEFT_PART: Tunable<f64> = tunable("repair.left_part", 0.1);

/// Faces. If each intersecting face intersects more others than this on average, the exact union has thousands of triangles to
/// classify around one point, and vertices are moved before it: 6,600 pairs of 350 faces at the axis of a torus that is thicker
/// than its ring took 20 s, and rounding let 4,300 intersect.
const DENSE_PARTNERS: Tunable<usize> = tunable("repair.dense_partners", 10);

/// Fraction of the input's area. A plan without faults that loses less ends the search in meshes of any size.
const LITTLE_LOST: Tunable<f64> = tunable("repair.little_lost", 2e-3);

/// Faces. In larger meshes a plan without faults whose solid agrees ends the search, even if it loses more than
/// `DOUBTFUL_LOSS`: each further plan may take ten seconds.
const SETTLED_FACES: Tunable<usize> = tunable("repair.settled_faces", 5000);

/// Nodes of level sets, as [`SolvedPatches`](crate::mend::SolvedPatches) counts them. Once as many were solved and a plan left no
/// fault, only the plan that cuts nothing out is tried; once twice as many were, only it and the one that cuts first; once half as many
/// were, no plan with each hole by itself: on parts with hundreds of holes and thousands of intersections six more plans took up to a
/// minute, and none had the shape.
const MUCH_SOLVED: Tunable<usize> = tunable("repair.much_solved", 2_000_000);

/// An order of steps after the mesh is cleaned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plan {
    /// Vertices of folds are moved, where many sheets of one component pass through a place, before anything is united.
    RelaxFirst,
    /// Bodies of the mesh as given are united, before it is cleaned, if all that intersect are closed.
    UniteGiven,
    /// Bodies are united, with their holes closed by triangles meanwhile, which are filled afterwards.
    UniteCleaned,
    /// Holes with one obvious closure are closed and closed bodies united. Only if nothing intersects then, the other holes are
    /// filled.
    Unite,
    /// Vertices of folds and noise are moved until nothing intersects: in the end, if the best plan made handles or bodies.
    RelaxFolds,
    /// Closed bodies are united, vertices of folds and noise moved, all holes filled, vertices moved again, and the remaining
    /// intersecting faces cut out.
    Relax,
    /// All holes are filled, then closed bodies united, then intersecting faces cut out.
    FillThenCut,
    /// The same, with the holes filled before the mesh is cleaned: cleaning may have joined bodies that only touch.
    FillThenClean,
    /// Closed bodies are united, then intersecting faces cut out, then all holes filled.
    CutThenFill,
    /// Holes are filled; faces that intersect or meet at non-manifold edges stay.
    Keep,
}

impl Plan {
    /// Whether it is one of the last two, which need the fewest level sets.
    fn is_last(self) -> bool {
        matches!(self, Self::CutThenFill | Self::Keep)
    }

    /// The plans for a mesh in which faces intersect or not, and that is open or not, in the order in which they are tried.
    fn list(intersects: bool, is_open: bool) -> &'static [Self] {
        match (intersects, is_open) {
            (false, _) => &[Self::CutThenFill],
            (true, false) => &[
                Self::RelaxFirst,
                Self::UniteGiven,
                Self::UniteCleaned,
                Self::Relax,
                Self::CutThenFill,
                Self::Keep,
            ],
            (true, true) => &[
                Self::Unite,
                Self::RelaxFirst,
                Self::UniteGiven,
                Self::UniteCleaned,
                Self::Relax,
                Self::FillThenCut,
                Self::FillThenClean,
                Self::CutThenFill,
                Self::Keep,
            ],
        }
    }
}

/// A search in progress.
struct Search<'a> {
    cleaned: State,
    /// Of the cleaned mesh, if faces intersect: nothing else is united.
    genus: Option<Genus>,
    /// The mesh before it was cleaned, if faces intersect.
    given: Option<Given>,
    carried: &'a Carried<'a>,
    intersects: bool,
    /// The best result with its plan.
    best: Option<(PlanQuality, State, Plan)>,
}

/// What the steps change.
#[derive(Clone)]
pub(super) struct State {
    draft: Draft,
    report: RepairReport,
    lost: usize,
    early: Vec<HoleReport>,
    asked: HashSet<u32>,
}

impl Run<'_> {
    /// A copy of the state that the steps change.
    pub(super) fn state(&self) -> State {
        State {
            draft: self.draft.clone(),
            report: self.report.clone(),
            lost: self.lost,
            early: self.early.clone(),
            asked: self.asked.clone(),
        }
    }

    /// Returns to an earlier state.
    pub(super) fn restore(&mut self, state: State) {
        self.draft = state.draft;
        self.report = state.report;
        self.lost = state.lost;
        self.early = state.early;
        self.asked = state.asked;
    }

    /// Runs the plans on the cleaned mesh and keeps the best result. `given` is the mesh before it was cleaned, if faces intersect.
    pub(super) fn search(
        &mut self,
        given: Option<Given>,
        carried: &Carried,
    ) -> Result<(), FillError> {
        self.joins = self.report.steps.welded_vertices + self.report.steps.stitched_junctions > 0;
        let intersects = self.params.does(RepairStep::Intersections) && self.intersects()?;
        self.cleaned_border = border(&*self.draft.inspect()?).len();
        let is_open = self.params.does(RepairStep::Holes) && self.cleaned_border > 0;
        let plans = Plan::list(intersects, is_open);
        self.compares = plans.len() > 1;
        let mut search = Search {
            cleaned: self.state(),
            genus: intersects.then(|| self.genus()).transpose()?,
            given,
            carried,
            intersects,
            best: None,
        };
        for &plan in plans {
            let best = search.best.as_ref().map(|(quality, ..)| quality);
            if plan == Plan::Keep && best.is_some_and(|q| !q.destroys) {
                break;
            }
            // Vertices stay if the bodies could be united.
            if plan == Plan::Relax && best.is_some_and(|q| !q.is_wrong) {
                continue;
            }
            if self.has_solved_enough(plan, best) {
                continue;
            }
            let Some(quality) = self.attempt(plan, &mut search)? else {
                continue;
            };
            // Another way to close what the bodies mean loses no less.
            let unites = matches!(plan, Plan::UniteGiven | Plan::UniteCleaned);
            let is_large = self.input.faces.len() > SETTLED_FACES.get();
            let is_meant = match is_large {
                true => !quality.destroys,
                false => !quality.has_another_solid(),
            };
            if unites && quality.is_clean() && is_meant {
                self.is_united = true;
            }
            let loses_little = quality.lost <= LITTLE_LOST.get();
            if !quality.is_wrong && (loses_little || is_large) || is_large && quality.is_tolerable()
            {
                break;
            }
        }
        if search.best.as_ref().is_some_and(|(best, ..)| best.made > 0) {
            self.attempt(Plan::RelaxFolds, &mut search)?;
        }
        self.try_apart(&mut search)?;
        if let Some((_, state, _)) = search.best {
            self.restore(state);
        }
        Ok(())
    }

    /// Whether enough level sets were solved, so that a plan is not tried after the best one.
    fn has_solved_enough(&self, plan: Plan, best: Option<&PlanQuality>) -> bool {
        let spent = self.solved.nodes();
        match best.is_some_and(PlanQuality::is_clean) {
            true => spent > MUCH_SOLVED.get() && plan != Plan::Keep,
            false => spent > 2 * MUCH_SOLVED.get() && !plan.is_last(),
        }
    }

    /// Follows the best plan once more, with each hole closed by itself, if it joined rims and has quite another solid than the input.
    fn try_apart(&mut self, search: &mut Search) -> Result<(), FillError> {
        let best = search.best.as_ref();
        let Some((_, state, plan)) = best.filter(|(q, ..)| q.destroys) else {
            return Ok(());
        };
        // Regions of many rims, which no level set closes, count no nodes, but apart each of their holes is solved.
        let has_many = 2 * self.solved.nodes() > MUCH_SOLVED.get();
        if self.apart || has_many || !state.report.fill.joins_rims() {
            return Ok(());
        }
        let plan = *plan;
        (self.apart, self.is_united) = (true, false);
        self.attempt(plan, search)?;
        self.apart = false;
        Ok(())
    }

    /// Follows a plan from the cleaned mesh; its state is kept if it is the best. Returns its quality, if it could be followed to its
    /// end.
    fn attempt(
        &mut self,
        plan: Plan,
        search: &mut Search,
    ) -> Result<Option<PlanQuality>, FillError> {
        self.restore(search.cleaned.clone());
        let best = search.best.as_ref();
        self.bound = best.and_then(|(quality, ..)| quality.bound());
        if !self.follow(plan, search.given.as_ref(), search.carried)? {
            return Ok(None);
        }
        self.adopt_meant()?;
        let shape = self.shape(search)?;
        let quality = self.quality(&shape, search.genus)?;
        log::debug!(
            "plan {plan:?}, {} nodes solved: {quality:?}",
            self.solved.nodes()
        );
        self.report.doubt = shape.doubt();
        let best = search.best.as_ref();
        if best.is_none_or(|(known, ..)| quality < *known) {
            search.best = Some((quality, self.state(), plan));
        }
        Ok(Some(quality))
    }

    /// Runs a plan; returns whether it could be followed to its end.
    fn follow(
        &mut self,
        plan: Plan,
        given: Option<&Given>,
        carried: &Carried,
    ) -> Result<bool, FillError> {
        self.cuts = self.params.does(RepairStep::Intersections) && plan != Plan::Keep;
        self.splits = self.params.does(RepairStep::NonManifold) && plan != Plan::Keep;
        match plan {
            Plan::UniteGiven | Plan::FillThenClean => match given {
                Some(given) => (self.draft, self.report) = given.clone(),
                None => return Ok(false),
            },
            _ => {}
        }
        match plan {
            Plan::UniteGiven => self.unite_then_fill(true, carried),
            Plan::Keep => self.fill_then_unite(plan, given, carried),
            Plan::RelaxFirst if !self.is_dense()? => Ok(false),
            Plan::RelaxFirst => self.relax_then_fill(None, carried),
            Plan::RelaxFolds => self.relax_folds(carried),
            Plan::Relax => self.relax_then_fill(given, carried),
            _ if self.is_united => Ok(false),
            Plan::UniteCleaned => self.unite_then_fill(false, carried),
            _ if self.leaves_many() => Ok(false),
            Plan::FillThenClean if !self.joins || self.closes_cracks(given)? => Ok(false),
            _ => self.fill_then_unite(plan, given, carried),
        }
    }

    /// Whether cleaning closed most of the boundary: the mesh was cracked, and a fill before cleaning would close each crack as a hole.
    /// Called with the mesh as `given`.
    fn closes_cracks(&self, given: Option<&Given>) -> Result<bool, FillError> {
        let Some((given, _)) = given else {
            return Ok(false);
        };
        let before = border(&*given.inspect()?).len();
        let rest = CRACKED_REST.get() * before as f64;
        Ok((self.cleaned_border as f64) < rest)
    }

    /// Whether each intersecting face intersects many others on average.
    fn is_dense(&mut self) -> Result<bool, FillError> {
        let crossing = self.draft.self_intersections()?;
        if crossing.len() > RELAXED_FACES.get() {
            return Ok(false);
        }
        let found = self.draft.inspect()?;
        let faces: Vec<[u32; 3]> = (crossing.iter())
            .map(|f| found.mesh.faces[*f as usize])
            .collect();
        let all: Vec<u32> = (0..faces.len() as u32).collect();
        let pairs = intersecting_pairs(&found.mesh.positions, &faces, &all);
        Ok(pairs.len() > DENSE_PARTNERS.get() * faces.len())
    }

    /// Unites bodies, with their holes closed meanwhile, then fills what is open.
    fn unite_then_fill(&mut self, cleans: bool, carried: &Carried) -> Result<bool, FillError> {
        let unites = match cleans {
            true => self.unite_given(carried)?,
            false => self.unite_capped(carried)?,
        };
        if unites {
            self.separate()?;
            self.drop_components()?;
            return self.fill_and_cut(false);
        }
        Ok(unites)
    }

    /// Moves vertices where the surface is folded or noisy, then fills what is open and cuts what intersects still. Returns whether
    /// any vertices were moved.
    fn relax_then_fill(
        &mut self,
        given: Option<&Given>,
        carried: &Carried,
    ) -> Result<bool, FillError> {
        // A union that left as many intersecting faces in an earlier plan would again.
        let crossing = self.draft.self_intersections()?.len();
        if let Some(given) = given.filter(|_| self.left.is_none_or(|left| left < crossing)) {
            self.unite(given, carried)?;
        }
        relax::relax(&mut self.draft, &mut self.report)?;
        if self.report.steps.relaxed_vertices == 0 {
            return Ok(false);
        }
        self.separate()?;
        self.drop_components()?;
        let old = border(&*self.draft.inspect()?);
        self.fill(&old, Filling::Chosen)?;
        relax::relax(&mut self.draft, &mut self.report)?;
        self.fill_and_cut(true)
    }

    /// Moves vertices and fills holes, if nothing intersects once vertices moved.
    fn relax_folds(&mut self, carried: &Carried) -> Result<bool, FillError> {
        relax::relax(&mut self.draft, &mut self.report)?;
        match self.draft.self_intersections()?.is_empty() {
            true => self.relax_then_fill(None, carried),
            false => Ok(false),
        }
    }

    /// Fills holes, unites bodies, and cuts what intersects still.
    fn fill_then_unite(
        &mut self,
        plan: Plan,
        given: Option<&Given>,
        carried: &Carried,
    ) -> Result<bool, FillError> {
        let old = border(&*self.draft.inspect()?);
        match plan {
            Plan::Unite => self.fill(&old, Filling::Obvious)?,
            Plan::FillThenCut | Plan::FillThenClean => self.fill(&old, Filling::Chosen)?,
            _ => {}
        }
        let fills = !matches!(plan, Plan::CutThenFill | Plan::Keep);
        let filled = fills.then(|| (self.draft.clone(), self.report.clone()));
        if plan == Plan::FillThenClean {
            self.clean(carried)?;
        }
        if let Some(given) = filled.as_ref().or(given).filter(|_| self.cuts) {
            self.unite(given, carried)?;
        }
        if matches!(
            plan,
            Plan::FillThenCut | Plan::FillThenClean | Plan::CutThenFill
        ) && self.leaves_many()
        {
            return Ok(false);
        }
        self.separate()?;
        self.drop_components()?;
        if plan == Plan::Unite && !self.draft.self_intersections()?.is_empty() {
            return Ok(false);
        }
        self.fill_and_cut(matches!(plan, Plan::FillThenCut | Plan::FillThenClean))
    }

    /// Whether each union that was tried left many intersecting faces: cutting these out would leave little of the mesh.
    fn leaves_many(&self) -> bool {
        let faces = self.input.faces.len();
        let many =
            |left: usize| left > LEFT_FACES.get() && left as f64 > LEFT_PART.get() * faces as f64;
        self.left.is_some_and(many)
    }

    /// Separates surfaces that meet in edges and vertices.
    fn separate(&mut self) -> Result<(), FillError> {
        if !self.splits {
            return Ok(());
        }
        dangling::join(&mut self.draft)?;
        self.separate_sheets()?;
        // A separated component may be a closed body now, whose outside is known.
        if self.params.does(RepairStep::Orientation)
            && self.report.steps.split_vertices + self.report.steps.non_manifold_faces > 0
        {
            self.report.steps.reoriented_faces += orient::orient(&mut self.draft)?;
        }
        self.go_on()
    }

    /// The shape of the present state: the input's where nothing intersected, no face is gone, and each hole was closed by itself.
    fn shape(&mut self, search: &Search) -> Result<Shape, FillError> {
        let faces = self.input.faces.len();
        let cleaned = &search.cleaned.draft;
        let is_whole = || cleaned.origins.living(faces) == self.draft.origins.living(faces);
        let closes_apart = || self.report.walls.is_empty() && !self.report.fill.joins_rims();
        if !search.intersects && is_whole() && closes_apart() {
            return Ok(Shape::whole());
        }
        let witness = match self.witness.take() {
            Some(witness) => witness,
            None => self.new_witness(cleaned)?,
        };
        let shape = witness.shape(&self.draft, &self.asked);
        self.witness = Some(witness);
        shape
    }

    /// Whether the present plan has lost more of the input than its result may, to be the best.
    pub(super) fn loses_too_much(&mut self) -> Result<bool, FillError> {
        let Some(bound) = self.bound else {
            return Ok(false);
        };
        self.adopt_meant()?;
        let Some(witness) = &self.witness else {
            return Ok(false);
        };
        Ok(witness.lost_share(&self.draft, &self.asked)? > bound)
    }

    /// Takes the solid of closed bodies, which is decided everywhere, for the one that the input means.
    fn adopt_meant(&mut self) -> Result<(), FillError> {
        if let Some(meant) = self.meant.take() {
            self.witness = Some(self.new_witness(&meant)?);
        }
        Ok(())
    }

    /// The witness of a cleaned draft.
    fn new_witness(&self, cleaned: &Draft) -> Result<Witness, FillError> {
        let turns = self.params.does(RepairStep::Orientation);
        Witness::new(cleaned, self.input, turns)
    }

    fn genus(&self) -> Result<Genus, FillError> {
        Ok(Genus::of(&*self.draft.inspect()?))
    }

    fn quality(&mut self, shape: &Shape, before: Option<Genus>) -> Result<PlanQuality, FillError> {
        let faults = self.draft.faults()?;
        let made = match before {
            Some(before) => self.genus()?.beyond(before),
            None => 0,
        };
        let destroys = DESTROYED.get();
        Ok(PlanQuality {
            destroys: shape.lost.max(1.0 - shape.agreement) > destroys,
            is_wrong: faults.intersecting_or_not_manifold() > 0
                || (faults.is_open() && self.report.fill.incomplete())
                || shape.doubt().is_some(),
            faults,
            made,
            lost: shape.lost,
            differs: 1.0 - shape.agreement,
        })
    }
}
