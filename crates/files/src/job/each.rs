//! Work on the bodies of a 3MF file: the mesh is split into one mesh for each object and part, each is mended by
//! itself, and the results are joined ([`super::join`]).

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use super::bodies::checked;
use super::error::with_causes;
use super::join::{Part, joined};
use super::result::{KeptInput, Made, OperationReport, repaired};
use super::steps::{Read, marks, repair_template};
use super::template::with_template;
use super::{JobError, JobSpec, Place, Source, Work, WorkPlan};
use crate::io::{Format, Loaded};
use isomend_core::fill::FillParams;
use isomend_core::mend::{
    BodyNumbers, Control, Event, FairError, FairPlan, FillError, FillPlan, FillReport, HolesByRim,
    Inspection, KeptObject, RestorePlan, RestoreReport, Step,
};
use isomend_core::mesh::{Bodies, HoleId};

/// What a fill with default parameters would do; `found` is the inspection of the mesh.
#[doc(hidden)]
pub fn default_plan(loaded: &Arc<Loaded>, found: &Inspection) -> Result<FillPlan, JobError> {
    let params = FillParams::default();
    let Some(bodies) = loaded.bodies() else {
        return Ok(found.plan(&params)?);
    };
    let source = Source::mesh(Place::memory("mesh"), loaded.clone());
    let spec = JobSpec::plan(source, Work::Fill(params));
    match spec.with(loaded.clone()).plan_each(&bodies, found)? {
        WorkPlan::Fill(plan) => Ok(plan),
        _ => Ok(FillPlan::nothing(found)),
    }
}

/// The objects that cannot be faired, with the reasons. They stay unchanged if another one is faired.
#[derive(Default)]
struct Unfaired {
    objects: Vec<(String, FairError)>,
    is_any_faired: bool,
}

impl Unfaired {
    /// The result for an object; none if the object itself is the reason why there is none.
    ///
    /// # Errors
    /// If the reason concerns the other objects too.
    fn take<T>(&mut self, name: &str, result: Result<T, FairError>) -> Result<Option<T>, JobError> {
        let name = name.to_owned();
        match result {
            Ok(done) => {
                self.is_any_faired = true;
                Ok(Some(done))
            }
            Err(error) if error.is_of_surface() => {
                self.objects.push((name, error));
                Ok(None)
            }
            Err(error) => Err(JobError::FairObject { name, error }),
        }
    }

    /// The objects for a report.
    ///
    /// # Errors
    /// The first reason if no object was faired.
    fn reported(self) -> Result<Vec<KeptObject>, JobError> {
        let mut objects = self.objects.into_iter();
        if !self.is_any_faired
            && let Some((name, error)) = objects.next()
        {
            return Err(JobError::FairObject { name, error });
        }
        let kept = objects.map(|(name, error)| KeptObject {
            name,
            reason: with_causes(&error),
        });
        Ok(kept.collect())
    }
}

/// The marks of a body's faces, from the marks of all faces; empty without a mask.
fn marks_of(marked: Option<&[bool]>, faces: &[u32]) -> Vec<bool> {
    let own = |marked: &[bool]| faces.iter().map(|f| marked[*f as usize]).collect();
    marked.map(own).unwrap_or_default()
}

impl Read<'_> {
    /// The bodies on which the work is done one by one; none if it is done on the whole mesh. A repair treats the mesh as one
    /// if the output cannot hold objects: then the written file is one mesh, and is checked as such.
    pub(super) fn bodies(&self) -> Option<Bodies> {
        match &self.spec.work {
            Work::Fill(_) | Work::Restore(..) | Work::Fair(..) => self.loaded.bodies(),
            Work::Repair(_) => {
                let output = self.spec.output.as_ref();
                let holds = output.is_none_or(|o| o.format == Format::ThreeMf);
                holds.then(|| self.loaded.bodies()).flatten()
            }
            Work::Copy | Work::Inspect(_) | Work::Check(_) => None,
        }
    }

    /// Does the work on each body. `whole` is the inspection of the mesh.
    pub(super) fn make_each(
        &self,
        bodies: &Bodies,
        whole: &Inspection,
        control: &Control,
    ) -> Result<Made, JobError> {
        let task = Task::new(&self.spec.work, &self.loaded, whole, control)?;
        let known = HolesByRim::new(whole);
        let (mut parts, mut unfaired) = (Vec::new(), Unfaired::default());
        for k in 0..bodies.count() {
            let mesh = bodies.mesh(&self.loaded.mesh, k);
            let marked = marks_of(task.marked.as_deref(), &bodies.faces[k]);
            let found = self.spec.work.inspect(&mesh, None)?;
            let numbers = BodyNumbers::new(&known, &found, &bodies.vertices[k], &bodies.names[k]);
            let progress = |step: &Step| in_whole(step, &numbers, [k, bodies.count()], control);
            let control = control.progress(&progress);
            let made = match &task.work {
                Work::Fill(params) => {
                    let params = task.local(params, &numbers, &found)?;
                    found.fill(&params, &control)?.into()
                }
                Work::Restore(_, params) if marked.contains(&true) => {
                    found.restore(&marked, params, &control)?.into()
                }
                Work::Fair(_, params) if task.takes(&marked) => {
                    let marked = task.marked.is_some().then_some(&marked[..]);
                    let faired = found.fair(marked, params, &control);
                    let faired = unfaired.take(&bodies.names[k], faired)?;
                    faired.map_or_else(|| unchanged(&found), Made::from)
                }
                Work::Repair(params) => {
                    let mut params = params.clone();
                    params.fill = task.local(&params.fill, &numbers, &found)?;
                    params.drop = own_components(&params.drop, whole, &found, &bodies.faces[k])?;
                    let whole = |v: u32| bodies.vertices[k][v as usize];
                    let attributes = &self.loaded.attributes;
                    let alike = |a, b| attributes.are_alike(whole(a), whole(b));
                    let carried = self.spec.carried(&self.loaded);
                    repaired(&mesh, &alike, carried, &params, &control)?
                }
                _ => unchanged(&found),
            };
            parts.push(Part { made, numbers });
        }
        let mut made = joined(&self.loaded, bodies, parts, whole)?;
        let kept = unfaired.reported()?;
        if let OperationReport::Faired(report) = &mut made.extent {
            report.whole &= kept.is_empty();
            report.kept_objects = kept;
        }
        Ok(made)
    }

    /// Plans the work on each body.
    pub(super) fn plan_each(
        &self,
        bodies: &Bodies,
        whole: &Inspection,
    ) -> Result<WorkPlan, JobError> {
        let task = Task::new(&self.spec.work, &self.loaded, whole, &Control::new())?;
        let known = HolesByRim::new(whole);
        let (mut fills, mut cuts, mut fairs) = (Vec::new(), Vec::new(), Vec::new());
        let mut unfaired = Unfaired::default();
        for k in 0..bodies.count() {
            let mesh = bodies.mesh(&self.loaded.mesh, k);
            let marked = marks_of(task.marked.as_deref(), &bodies.faces[k]);
            let found = self.spec.work.inspect(&mesh, None)?;
            let mut numbers =
                BodyNumbers::new(&known, &found, &bodies.vertices[k], &bodies.names[k]);
            let fill = match &task.work {
                Work::Fill(params) => found.plan(&task.local(params, &numbers, &found)?)?,
                Work::Repair(params) => {
                    found.plan(&task.local(&params.fill, &numbers, &found)?)?
                }
                Work::Restore(_, params) if marked.contains(&true) => {
                    let mut plan = found.plan_restore(&marked, params)?;
                    plan.cut.number_in_whole(&numbers);
                    // Holes are numbered as after the cut, which only the run makes.
                    numbers.holes.clear();
                    cuts.push(plan.cut);
                    plan.fill
                }
                Work::Fair(_, params) if task.takes(&marked) => {
                    let marked = task.marked.is_some().then_some(&marked[..]);
                    let plan = found.plan_fair(marked, params);
                    fairs.extend(unfaired.take(&bodies.names[k], plan)?);
                    FillPlan::nothing(&found)
                }
                _ => FillPlan::nothing(&found),
            };
            fills.push((fill, numbers));
        }
        let is_restored = matches!(task.work, Work::Restore(..));
        let next = if is_restored {
            1
        } else {
            whole.holes.len() + 1
        };
        let fill = FillPlan::of_bodies(fills, next);
        Ok(match &task.work {
            Work::Repair(params) => WorkPlan::Repair {
                before: Box::new(checked(whole, Some(bodies), &params.checked())?),
                fill,
            },
            Work::Restore(..) => WorkPlan::Restore(RestorePlan::of_bodies(cuts, fill)),
            Work::Fair(..) => {
                let mut plan = FairPlan::of_bodies(&fairs);
                plan.kept_objects = unfaired.reported()?;
                plan.whole &= plan.kept_objects.is_empty();
                WorkPlan::Fair(plan)
            }
            _ => WorkPlan::Fill(fill),
        })
    }
}

/// The result of a restoration or a fairing for a body without marked faces.
fn unchanged(found: &Inspection) -> Made {
    Made {
        mesh: found.input.clone().into_owned(),
        expected_error: Vec::new(),
        kept_input: KeptInput::All,
        extent: OperationReport::Region(RestoreReport::default()),
        report: FillReport::of(found),
        replaced: Vec::new(),
    }
}

/// Reports progress on body `k` of `count` with the hole numbers of the whole mesh.
fn in_whole(step: &Step, numbers: &BodyNumbers, [k, count]: [usize; 2], control: &Control) {
    let number = |id: &HoleId| numbers.holes.get(id).copied().unwrap_or(*id);
    let part = (k as f64 + step.part) / count as f64;
    match step.event {
        Event::Begun(holes) => {
            let holes: Vec<HoleId> = holes.iter().map(number).collect();
            let event = Event::Begun(&holes);
            control.report(&step.within(part, event));
        }
        Event::Ended(report) => {
            let mut report = report.clone();
            report.holes.iter_mut().for_each(|id| *id = number(id));
            let event = Event::Ended(&report);
            control.report(&step.within(part, event));
        }
        Event::Working => control.report(&step.within(part, step.event)),
    }
}

/// The work with its template read, and what it refers to in the whole mesh.
struct Task {
    work: Work,
    marked: Option<Vec<bool>>,
    /// The vertices at which the sharp edges end that the caller numbered, as pairs.
    creases: Vec<[u32; 2]>,
}

impl Task {
    fn new(
        work: &Work,
        loaded: &Loaded,
        whole: &Inspection,
        control: &Control,
    ) -> Result<Self, JobError> {
        let mut work = work.clone();
        let mut marked = None;
        let fill = match &mut work {
            Work::Restore(mask, params) => {
                marked = Some(marks(mask, loaded)?);
                params.fill = with_template(&params.fill)?.into_owned();
                None
            }
            Work::Fill(params) => {
                *params = with_template(params)?.into_owned();
                Some(&*params)
            }
            Work::Repair(params) => {
                *params = repair_template(params)?;
                Some(&params.fill)
            }
            Work::Fair(mask, _) => {
                marked = mask.as_ref().map(|mask| marks(mask, loaded)).transpose()?;
                None
            }
            Work::Copy | Work::Inspect(_) | Work::Check(_) => None,
        };
        let mut creases = Vec::new();
        if let Some(params) = fill {
            check_holes(params, whole)?;
            if !params.crease.is_empty() {
                creases = crease_vertices(params, whole, control)?;
            }
        }
        Ok(Self {
            work,
            marked,
            creases,
        })
    }

    /// Whether a body with these marks is worked on: without a mask each is.
    fn takes(&self, marked: &[bool]) -> bool {
        self.marked.is_none() || marked.contains(&true)
    }

    /// The parameters of a fill for a body: hole numbers and numbers of sharp edges are the body's.
    fn local(
        &self,
        params: &FillParams,
        numbers: &BodyNumbers,
        found: &Inspection,
    ) -> Result<FillParams, JobError> {
        let numbered = numbers.holes.iter();
        let own: HashMap<HoleId, HoleId> = numbered.map(|(own, whole)| (*whole, *own)).collect();
        let own = |id: &HoleId| own.get(id).copied();
        let list = |ids: &Vec<HoleId>| -> Vec<HoleId> { ids.iter().filter_map(own).collect() };
        let mut params = params.clone();
        params.holes = params.holes.as_ref().map(list);
        params.keep_open = list(&params.keep_open);
        params.flat = list(&params.flat);
        let bridges = params.bridge.iter().map(|ids| (list(ids), ids.len()));
        let bridges: Vec<(Vec<HoleId>, usize)> =
            bridges.filter(|(own, _)| !own.is_empty()).collect();
        if bridges.iter().any(|(own, all)| own.len() < *all) {
            return Err(JobError::Fill(FillError::Parameter {
                what: "`bridge` names holes of different objects: each object is filled by itself",
            }));
        }
        params.bridge = bridges.into_iter().map(|(own, _)| own).collect();
        params.crease.clear();
        if !self.creases.is_empty() {
            let ends = found.crease_ends(&Control::new())?;
            let end = |vertex: u32| {
                let same = ends
                    .iter()
                    .find(|e| numbers.vertices[e.vertex as usize] == vertex);
                same.map(|e| e.id)
            };
            let pairs = self.creases.iter();
            params.crease = pairs
                .filter_map(|[a, b]| Some([end(*a)?, end(*b)?]))
                .collect();
        }
        Ok(params)
    }
}

/// The numbers of a body's components that are parts of the named components of the whole mesh. `faces` has the body's faces.
fn own_components(
    named: &[usize],
    whole: &Inspection,
    found: &Inspection,
    faces: &[u32],
) -> Result<Vec<usize>, FillError> {
    let count = whole.topology.component_faces.len();
    if let Some(&id) = named.iter().find(|id| **id == 0 || **id > count) {
        return Err(FillError::NoSuchComponent { id, count });
    }
    let own = found.topology.component.iter().zip(faces);
    let own = own.filter(|(own, f)| {
        **own != u32::MAX && named.contains(&(whole.topology.component[**f as usize] as usize + 1))
    });
    let own: BTreeSet<usize> = own.map(|(own, _)| *own as usize + 1).collect();
    Ok(own.into_iter().collect())
}

/// Checks that the holes that the parameters name exist.
fn check_holes(params: &FillParams, whole: &Inspection) -> Result<(), FillError> {
    let count = whole.holes.len();
    let bridged = params.bridge.iter().flatten();
    let named = params.holes.iter().flatten().chain(&params.keep_open);
    for id in named.chain(&params.flat).chain(bridged) {
        if id.get() == 0 || id.get() > count {
            return Err(FillError::NoSuchHole { id: *id, count });
        }
    }
    Ok(())
}

/// The rim vertices of the sharp edges that the parameters join.
fn crease_vertices(
    params: &FillParams,
    whole: &Inspection,
    control: &Control,
) -> Result<Vec<[u32; 2]>, FillError> {
    let ends = whole.crease_ends(control)?;
    let vertex = |number: usize| {
        let end = ends.iter().find(|end| end.id == number);
        end.map(|end| end.vertex).unwrap_or(u32::MAX)
    };
    Ok(params.crease.iter().map(|pair| pair.map(vertex)).collect())
}
