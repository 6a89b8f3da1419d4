//! Mesh repair: reorients, welds, unites, separates or cuts out defective faces, then fills the holes.
//!
//! Faces that are not part of a defect are kept bit for bit and in order.

mod balance;
mod bodies;
mod bodies_report;
mod caps;
mod chains;
mod choice;
mod clean;
mod clear;
mod components;
mod cracks;
mod dangling;
mod displaced;
mod draft;
mod faults;
mod filling;
mod finish;
mod flakes;
mod genus;
mod growing;
mod inner_sheets;
mod intersection_cache;
mod offset_shell;
mod offset_shells;
mod orient;
mod params;
mod plan_quality;
mod plans;
mod relax;
mod report;
mod rim_triangles;
mod rings;
mod rounding;
mod seams;
mod self_intersections;
mod setters;
mod sheets;
mod shell_rounds;
mod shell_search;
mod shell_vertex;
mod shell_walls;
mod solid;
mod steps;
mod turned;
mod twins;
mod union;
mod widen;
mod witness;

use std::collections::HashSet;
use std::time::Instant;

use glam::DMat4;

use crate::check::{DefectKind, weld_length};
use crate::mend::{Control, FillError, FillReport, HoleReport, Inspection, SolvedPatches, Watch};
use crate::mesh::topology::NONE;
use crate::mesh::{Hole, Mesh, Origins};
use crate::tuning::{Tunable, tunable};
use bodies::Given;
use choice::Choice;
use clean::Alike;
use draft::Draft;
use faults::Faults;
use filling::Filling;
use plans::State;
use rounding::Rounding;
use witness::Witness;

pub use params::{LostComponents, RepairParams, RepairReport, RepairStep};
pub use steps::{RepairSteps, SelfIntersectionPass};

/// Passes, at most. Each cuts intersecting faces out and fills the holes; each later pass cuts one more ring of faces.
const PASSES: Tunable<usize> = tunable("repair.passes", 2);

/// Rings of faces, at most, by which a hole is widened that cannot be closed without self-intersections.
const WIDER: Tunable<usize> = tunable("repair.wider", 3);

/// For patches that intersect other faces, at most one in this many faces of the input is cut out, plus
/// `LOST_CROSSING` for each face that intersected others in the input: caps of sheets inside each other always
/// intersect.
const LOST_PART: Tunable<usize> = tunable("repair.lost_part", 30);

/// Faces cut out for each face that intersected others in the input, at most.
const LOST_CROSSING: Tunable<usize> = tunable("repair.lost_crossing", 2);

/// Rings of faces around intersecting faces that are cut out with them.
const RINGS: Tunable<usize> = tunable("repair.rings", 1);

/// A repaired mesh.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Repaired {
    /// The mesh: vertices and faces from the input first, in order, then the patches.
    pub mesh: Mesh,
    /// The input vertex or face of each of its first vertices and faces; the others are new.
    pub origins: Origins,
    /// The expected error of each patch vertex; see [`crate::mend::Filled::expected_error`].
    pub expected_error: Vec<Option<f64>>,
    /// What the repair found and did.
    pub report: RepairReport,
    /// Report of the fills. Holes are numbered as they were when they were filled.
    pub fill: FillReport,
}

/// Properties of the input and the output format that constrain a repair.
#[derive(Clone, Copy)]
pub struct Carried<'a> {
    /// Whether two coinciding vertices may be merged because their attributes are equal.
    pub alike: &'a Alike<'a>,
    /// Keeps all input vertices under their numbers and puts changed faces after unchanged ones.
    pub in_place: bool,
    /// The transform from the coordinates that the output stores as 32-bit floats to mesh coordinates (the identity for most
    /// formats); none if the output stores 64-bit floats. All positions are rounded accordingly before self-intersections are
    /// searched (input positions too, unless `in_place`), so that the written file is as free of them as the result.
    pub stored: Option<DMat4>,
}

impl Default for Carried<'_> {
    fn default() -> Self {
        Self {
            alike: &|_, _| true,
            in_place: false,
            stored: None,
        }
    }
}

/// Repairs a mesh.
///
/// # Errors
/// If the mesh or the parameters are invalid, or [`FillError::Cancelled`]. A defect that cannot be repaired is not an error; it
/// is in the report.
pub fn repair(
    mesh: &Mesh,
    params: &RepairParams,
    carried: &Carried,
    control: &Control,
) -> Result<Repaired, FillError> {
    params.check()?;
    control.install(|| {
        let clock = Instant::now();
        let mut run = Run {
            input: mesh,
            draft: Draft::new(mesh, Vec::new()),
            params,
            control,
            report: RepairReport::default(),
            choice: Choice::default(),
            cuts: params.does(RepairStep::Intersections),
            splits: params.does(RepairStep::NonManifold),
            lost: 0,
            meant: None,
            left: None,
            is_united: false,
            joins: false,
            cleaned_border: 0,
            compares: false,
            witness: None,
            bound: None,
            solved: SolvedPatches::default(),
            apart: params.fill.apart,
            early: Vec::new(),
            asked: HashSet::new(),
            border: HashSet::new(),
            outer: HashSet::new(),
            components: Vec::new(),
        };
        run.draft.rounding = Rounding::new(carried.stored);
        let given = run.prepare(carried)?;
        run.search(given, carried)?;
        let mut done = run.finish(carried)?;
        done.fill.seconds = clock.elapsed().as_secs_f64();
        Ok(done)
    })
}

/// The state of a running repair.
struct Run<'a> {
    input: &'a Mesh,
    draft: Draft,
    params: &'a RepairParams,
    control: &'a Control<'a>,
    report: RepairReport,
    choice: Choice,
    /// Whether the present plan cuts intersecting faces out.
    cuts: bool,
    /// Whether it separates surfaces, or cuts them out where they cannot be separated.
    splits: bool,
    /// Input faces removed so far because patches intersected other faces.
    lost: usize,
    /// The mesh as given with the faces added that make all intersecting bodies closed, if they are then.
    meant: Option<Draft>,
    /// The least number of intersecting faces that a union left.
    left: Option<usize>,
    /// Whether a union has the solid that the input means.
    is_united: bool,
    /// Whether cleaning joined boundaries.
    joins: bool,
    /// Number of boundary edges of the cleaned mesh.
    cleaned_border: usize,
    /// Whether several plans are compared: a fill that fails is one of many.
    compares: bool,
    /// The solid that the input means, once it was needed.
    witness: Option<Witness>,
    /// Fraction of the input's area. The result of a plan that has lost more is not the best.
    bound: Option<f64>,
    /// Patches of all fills of the repair.
    solved: SolvedPatches,
    /// Whether each hole is closed by itself.
    apart: bool,
    /// Holes closed before the fill of the chosen ones.
    early: Vec<HoleReport>,
    /// Input faces removed because the caller asked for it.
    asked: HashSet<u32>,
    /// The boundary edges of the input.
    border: HashSet<Edge>,
    /// The edges of its outer borders.
    outer: HashSet<Edge>,
    /// The component of each input face; `u32::MAX` for degenerate faces.
    components: Vec<u32>,
}

impl Run<'_> {
    /// Returns an error if the run was cancelled.
    fn go_on(&self) -> Result<(), FillError> {
        Watch::new(*self.control, Vec::new()).finish()
    }

    /// Checks the input and cleans it. Returns the draft before it was cleaned if faces intersect.
    fn prepare(&mut self, carried: &Carried) -> Result<Option<Given>, FillError> {
        let params = self.params;
        // Check the input and set up the draft.
        let found = Inspection::new(self.input)?;
        self.report.before = Some(found.check(&params.checked()));
        self.choice = Choice::new(&found, &params.fill)?;
        self.report.fill = FillReport::of(&found);
        let rounding = self.draft.rounding;
        self.components.clone_from(&found.topology.component);
        let dropped = self.chosen()?;
        // What is dropped on request does not count as lost.
        let mut wanted = self.components.clone();
        let unwanted = wanted.iter_mut().zip(&dropped).filter(|(_, gone)| **gone);
        unwanted.for_each(|(component, _)| *component = NONE);
        self.draft = Draft::new(self.input, wanted);
        self.draft.rounding = rounding;
        // Determined before rounding, which hides the number of digits of the coordinates.
        self.draft.unit = weld_length(&found.mesh);
        if !carried.in_place {
            self.draft.round_from(0);
        }
        // Reuse the self-intersections that the check found.
        let before = self.report.before.iter().flat_map(|v| &v.defects);
        let mut crossing = before.filter(|d| d.kind == DefectKind::SelfIntersection);
        let crossing = crossing.next().map_or(&[][..], |d| &d.faces);
        self.draft.adopt(found, crossing);
        {
            let found = self.draft.inspect()?;
            self.border = border(&found);
            let outer = found.holes.iter().filter(|h| h.outer_boundary);
            self.outer = outer.flat_map(|h| edges(&h.rim)).collect();
            self.draft.unit = weld_length(&found.mesh).max(self.draft.unit);
        }
        if !dropped.is_empty() {
            self.report.steps.dropped_faces = self.take_out(&dropped);
        }
        self.go_on()?;
        let given = (params.does(RepairStep::Intersections) && self.intersects()?)
            .then(|| (self.draft.clone(), self.report.clone()));
        self.clean(carried)?;
        if params.does(RepairStep::Duplicates) && params.does(RepairStep::Intersections) {
            twins::drop(&mut self.draft, &mut self.report)?;
        }
        if params.does(RepairStep::Intersections) {
            inner_sheets::drop(&mut self.draft, &mut self.report)?;
        }
        // Plans that begin with the mesh as given would bring the inner skins back.
        if params.solid && self.make_solid()? {
            return Ok(None);
        }
        Ok(given)
    }

    /// Repairs that cut nothing out (merging, welding, duplicates), then reorients the faces.
    fn clean(&mut self, carried: &Carried) -> Result<(), FillError> {
        clean::clean(
            &mut self.draft,
            self.params,
            carried.alike,
            &mut self.report,
        )?;
        self.go_on()?;
        if self.params.does(RepairStep::Orientation) {
            self.report.steps.reoriented_faces += orient::orient(&mut self.draft)?;
        }
        Ok(())
    }

    /// Cuts intersecting faces out and fills the holes, in passes, until no patch intersects anything. Fills the chosen holes of the
    /// input too, unless they are `filled`. Returns false where the result cannot be the best, by what is lost.
    fn fill_and_cut(&mut self, filled: bool) -> Result<bool, FillError> {
        let mut old = border(&*self.draft.inspect()?);
        let mut reopened = false;
        for pass in 0..PASSES.get() {
            self.go_on()?;
            let before = (pass > 0).then(|| self.judged_state()).transpose()?;
            let cut = self.cuts && self.cut(pass)?;
            if pass > 0 && !cut && !reopened {
                break;
            }
            let which = match pass == 0 && !filled {
                true => Filling::Chosen,
                false => Filling::Made,
            };
            self.fill(&old, which)?;
            reopened = false;
            if self.splits {
                let before = self.report.steps.non_manifold_faces;
                self.separate_sheets()?;
                reopened = self.report.steps.non_manifold_faces > before;
            }
            if let Some(before) = before {
                self.keep_better(before)?;
            }
            if self.loses_too_much()? {
                return Ok(false);
            }
            old = border(&*self.draft.inspect()?);
        }
        // A plan that separates nothing removes nothing either.
        let drops = self.splits || !self.params.does(RepairStep::NonManifold);
        if drops {
            dangling::drop(
                &mut self.draft,
                &mut self.report,
                self.params.does(RepairStep::Intersections),
            )?;
        }
        if self.params.does(RepairStep::Intersections) {
            self.clear()?;
        }
        if self.params.does(RepairStep::Intersections) && drops {
            dangling::drop(&mut self.draft, &mut self.report, false)?;
        }
        if self.params.does(RepairStep::Duplicates) {
            clean::flip_new(&mut self.draft)?;
        }
        // Open sheets may have become closed components.
        if self.params.does(RepairStep::Orientation) {
            self.report.steps.reoriented_faces += orient::orient(&mut self.draft)?;
        }
        Ok(true)
    }

    /// Replaces patches that intersect other faces: by rim triangles, after widening the hole, by an offset shell, or by leaving
    /// the hole open.
    fn clear(&mut self) -> Result<(), FillError> {
        self.go_on()?;
        let borders = self.params.borders;
        let (border, outer) = (self.border.clone(), self.outer.clone());
        let was_border = |hole: &Hole, origin: &[u32]| {
            let before: Vec<u32> = hole.rim.iter().map(|v| origin[*v as usize]).collect();
            let moved = || hole.outer_boundary && edges(&before).any(|e| outer.contains(&e));
            !borders && (edges(&before).all(|e| border.contains(&e)) || moved())
        };
        let origin = self.draft.origins.vertices.clone();
        let is_left = |hole: &Hole| hole.outer_boundary && was_border(hole, &origin);
        rim_triangles::settle(&mut self.draft, &mut self.report.fill, &is_left)?;
        let open = |hole: &Hole| was_border(hole, &origin);
        report::open(&self.draft, &mut self.report.fill, &open)?;
        for rings in 0..=WIDER.get() {
            self.go_on()?;
            let most = self.most_lost();
            self.lost += widen::widen(&mut self.draft, &mut self.report.fill, rings, most)?;
        }
        self.separate_again()?;
        let origin = self.draft.origins.vertices.clone();
        let open = |hole: &Hole| was_border(hole, &origin);
        report::open(&self.draft, &mut self.report.fill, &open)?;
        dangling::close(&self.draft, &mut self.report.fill)?;
        self.add_offset_shells(&was_border)?;
        let crossing = self.draft.self_intersections()?;
        let left = crossing.iter().map(|f| self.draft.component(*f as usize));
        let left: HashSet<u32> = left.filter(|c| *c != NONE).collect();
        self.report.steps.components_left_intersecting = left.len();
        report::count_intersecting_faces(&mut self.draft, &mut self.report.fill)
    }

    /// Separates surfaces that patches joined at edges or vertices, if that reduces the faults.
    fn separate_again(&mut self) -> Result<(), FillError> {
        if self.splits && !self.draft.faults()?.is_manifold() {
            let before = self.judged_state()?;
            self.separate_sheets()?;
            self.keep_better(before)?;
        }
        Ok(())
    }

    /// A snapshot of the state that a pass changes, with its faults.
    fn judged_state(&mut self) -> Result<(State, Faults), FillError> {
        let faults = self.draft.faults()?;
        Ok((self.state(), faults))
    }

    /// Restores an earlier state if there are more faults now; returns whether the present state was kept.
    fn keep_better(&mut self, (before, faults): (State, Faults)) -> Result<bool, FillError> {
        let better = self.draft.faults()? <= faults;
        if !better {
            self.restore(before);
        }
        Ok(better)
    }

    /// The number of input faces that may still be removed because of patches that intersect others.
    fn most_lost(&self) -> usize {
        let crossed = self.report.before.as_ref();
        let crossed = crossed.map_or(0, |v| v.count(DefectKind::SelfIntersection));
        let all = self.input.faces.len() / LOST_PART.get() + LOST_CROSSING.get() * crossed;
        all.saturating_sub(self.lost)
    }

    fn cut(&mut self, pass: usize) -> Result<bool, FillError> {
        let most = self.most_lost();
        let cut = match pass {
            0 => self_intersections::cut(&mut self.draft, RINGS.get())?,
            _ => self_intersections::cut_patches(&mut self.draft, RINGS.get() + pass, most)?,
        };
        let Some(cut) = cut else {
            return Ok(false);
        };
        if pass > 0 {
            self.lost += cut.own;
        }
        self.report.steps.intersection_passes.push(cut.pass);
        self.report.steps.covered_faces += cut.covered;
        Ok(true)
    }
}

/// An edge between welded vertices, the smaller number first.
type Edge = (u32, u32);

fn edges(rim: &[u32]) -> impl Iterator<Item = Edge> {
    let next = rim.iter().cycle().skip(1);
    rim.iter().zip(next).map(|(&v, &w)| (v.min(w), v.max(w)))
}

/// The boundary edges.
fn border(found: &Inspection) -> HashSet<Edge> {
    use crate::mesh::topology::{end, start};
    let (mesh, topology) = (&found.mesh, &found.topology);
    (0..topology.boundary.len() as u32)
        .filter(|&h| topology.boundary[h as usize])
        .map(|h| (start(mesh, h), end(mesh, h)))
        .map(|(v, w)| (v.min(w), v.max(w)))
        .collect()
}
