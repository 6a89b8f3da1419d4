//! Mesh repair: reorients, welds, unites, separates or cuts out defective faces, then fills the holes.
//!
//! Faces that are not part of a defect are kept bit for bit and in order.

mod bodies;
mod caps;
mod choice;
mod clean;
mod clear;
mod cracks;
mod dangling;
mod draft;
mod finish;
mod growing;
mod intersection_cache;
mod offset_shell;
mod offset_shells;
mod orient;
mod params;
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
mod union;
mod widen;

use std::collections::HashSet;
use std::time::Instant;

use glam::DMat4;

use super::{FillError, FillReport, Inspection};
use crate::check::{DefectKind, components, weld_length};
use crate::fill::FillParams;
use crate::mend::{Control, Watch};
use crate::mesh::topology::NONE;
use crate::mesh::{Hole, HoleId, Mesh, Origins};
use crate::tuning::tuning;
use choice::Choice;
use clean::Alike;
use draft::{Draft, Faults};
use rounding::Rounding;

pub use params::{RepairParams, RepairReport, SelfIntersectionPass};

/// A repaired mesh.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Repaired {
    /// The mesh: vertices and faces from the input first, in order, then the patches.
    pub mesh: Mesh,
    /// The input vertex or face of each of its first vertices and faces; the others are new.
    pub origins: Origins,
    /// The expected error of each patch vertex; see [`super::Filled::expected_error`].
    pub expected_error: Vec<Option<f64>>,
    /// What the repair found and did.
    pub report: RepairReport,
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
            lost: 0,
            border: HashSet::new(),
            components: Vec::new(),
        };
        run.draft.rounding = Rounding::new(carried.stored);
        run.prepare(carried)?;
        run.fill_and_cut()?;
        let mut done = run.finish(carried)?;
        done.report.fill.seconds = clock.elapsed().as_secs_f64();
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
    /// Input faces removed so far because patches intersected other faces.
    lost: usize,
    /// The boundary edges of the input.
    border: HashSet<Edge>,
    /// The component of each input face; `u32::MAX` for degenerate faces.
    components: Vec<u32>,
}

impl Run<'_> {
    /// Returns an error if the run was cancelled.
    fn go_on(&self) -> Result<(), FillError> {
        Watch::new(*self.control, Vec::new()).finish()
    }

    /// The steps before intersecting faces are cut and holes are filled.
    fn prepare(&mut self, carried: &Carried) -> Result<(), FillError> {
        let params = self.params;
        // Check the input and set up the draft.
        let found = Inspection::new(self.input)?;
        self.report.before = Some(found.check(&params.checked()));
        self.choice = Choice::new(&found, &params.fill)?;
        self.report.fill = FillReport::of(&found);
        let rounding = self.draft.rounding;
        self.components.clone_from(&found.topology.component);
        self.draft = Draft::new(self.input, self.components.clone());
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
        let crosses = !crossing.is_empty();
        self.draft.adopt(found, crossing);
        {
            let found = self.draft.inspect()?;
            self.border = border(&found);
            self.draft.unit = weld_length(&found.mesh).max(self.draft.unit);
        }
        self.go_on()?;
        let given =
            (crosses && params.crossings).then(|| (self.draft.clone(), self.report.clone()));
        // Clean, unite closed bodies, separate non-manifold surfaces.
        self.clean(carried)?;
        if let Some(given) = given {
            self.unite(given, carried)?;
        }
        if params.split {
            dangling::join(&mut self.draft)?;
            sheets::separate(&mut self.draft, &mut self.report)?;
            // A separated component may be a closed body now, whose outside is known.
            if params.orient && self.report.split_vertices + self.report.non_manifold_faces > 0 {
                self.report.reoriented_faces += orient::orient(&mut self.draft)?;
            }
        }
        self.go_on()?;
        self.drop_components()
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
        if self.params.orient {
            self.report.reoriented_faces = orient::orient(&mut self.draft)?;
        }
        Ok(())
    }

    /// Removes debris and components that lie inside others.
    fn drop_components(&mut self) -> Result<(), FillError> {
        let (debris, inside) = (self.params.debris.unwrap_or(0.0), self.params.drop_inside);
        if debris <= 0.0 && !inside {
            return Ok(());
        }
        let removed: Vec<bool> = {
            let found = self.draft.inspect()?;
            let all = components(&found.mesh, &found.topology, debris);
            let mut goes = vec![false; all.len()];
            for (i, c) in all.iter().enumerate() {
                let count = match (c.debris, inside && c.inside.is_some()) {
                    (true, _) => &mut self.report.debris,
                    (_, true) => &mut self.report.inside,
                    _ => continue,
                };
                goes[i] = true;
                *count = [count[0] + 1, count[1] + c.faces];
            }
            let component = found.topology.component.iter();
            component.map(|&p| p != NONE && goes[p as usize]).collect()
        };
        self.draft.remove(&removed);
        Ok(())
    }

    /// Cuts intersecting faces out and fills the holes, in passes, until no patch intersects anything.
    fn fill_and_cut(&mut self) -> Result<(), FillError> {
        let mut old = border(&*self.draft.inspect()?);
        let mut reopened = false;
        for pass in 0..tuning().repair.passes {
            self.go_on()?;
            let before = (pass > 0).then(|| self.state()).transpose()?;
            let cut = self.params.crossings && self.cut(pass)?;
            if pass > 0 && !cut && !reopened {
                break;
            }
            self.fill(&old, pass == 0)?;
            reopened = false;
            if self.params.split {
                let before = self.report.non_manifold_faces;
                sheets::separate(&mut self.draft, &mut self.report)?;
                reopened = self.report.non_manifold_faces > before;
            }
            if let Some(before) = before {
                self.keep_better(before)?;
            }
            old = border(&*self.draft.inspect()?);
        }
        let may_stay = self.params.crossings;
        dangling::drop(&mut self.draft, &mut self.report, may_stay)?;
        if self.params.crossings {
            self.clear()?;
            dangling::drop(&mut self.draft, &mut self.report, false)?;
        }
        if self.params.clean {
            clean::flip_new(&mut self.draft)?;
        }
        // Open sheets may have become closed components.
        if self.params.orient {
            self.report.reoriented_faces += orient::orient(&mut self.draft)?;
        }
        Ok(())
    }

    /// Replaces patches that intersect other faces: by rim triangles, after widening the hole, by an offset shell, or by leaving
    /// the hole open.
    fn clear(&mut self) -> Result<(), FillError> {
        self.go_on()?;
        let borders = self.params.borders;
        let border = std::mem::take(&mut self.border);
        let was_border = |hole: &Hole, origin: &[u32]| {
            let before: Vec<u32> = hole.rim.iter().map(|v| origin[*v as usize]).collect();
            !borders && edges(&before).all(|e| border.contains(&e))
        };
        let origin = self.draft.origins.vertices.clone();
        let is_left = |hole: &Hole| hole.outer_boundary && was_border(hole, &origin);
        rim_triangles::settle(&mut self.draft, &mut self.report.fill, &is_left)?;
        let open = |hole: &Hole| was_border(hole, &origin);
        report::open(&self.draft, &mut self.report.fill, &open)?;
        for rings in 0..=tuning().repair.wider {
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
        self.report.left_self_intersecting = left.len();
        report::count_intersecting_faces(&mut self.draft, &mut self.report.fill)
    }

    /// Separates surfaces that patches joined at edges or vertices, if that reduces the faults.
    fn separate_again(&mut self) -> Result<(), FillError> {
        if self.params.split && !self.draft.faults()?.is_manifold() {
            let before = self.state()?;
            sheets::separate(&mut self.draft, &mut self.report)?;
            self.keep_better(before)?;
        }
        Ok(())
    }

    /// A snapshot of the state that a pass changes, with its faults.
    fn state(&mut self) -> Result<State, FillError> {
        let faults = self.draft.faults()?;
        let mut draft = self.draft.clone();
        draft.forget_inspection();
        Ok(((draft, self.report.clone(), self.lost), faults))
    }

    /// Restores an earlier state if there are more faults now; returns whether the present state was kept.
    fn keep_better(&mut self, (before, faults): State) -> Result<bool, FillError> {
        let better = self.draft.faults()? <= faults;
        if !better {
            (self.draft, self.report, self.lost) = before;
        }
        Ok(better)
    }

    /// The number of input faces that may still be removed because of patches that intersect others.
    fn most_lost(&self) -> usize {
        let crossed = self.report.before.as_ref();
        let crossed = crossed.map_or(0, |v| v.count(DefectKind::SelfIntersection));
        let all = self.input.faces.len() / tuning().repair.lost_part
            + tuning().repair.lost_crossing * crossed;
        all.saturating_sub(self.lost)
    }

    fn cut(&mut self, pass: usize) -> Result<bool, FillError> {
        let most = self.most_lost();
        let cut = match pass {
            0 => self_intersections::cut(&mut self.draft, tuning().repair.rings)?,
            _ => self_intersections::cut_patches(
                &mut self.draft,
                tuning().repair.rings + pass,
                most,
            )?,
        };
        let Some(cut) = cut else {
            return Ok(false);
        };
        if pass > 0 {
            self.lost += cut.own;
        }
        self.report.passes.push(cut.pass);
        self.report.covered_faces += cut.covered;
        Ok(true)
    }

    /// Fills holes: the chosen ones in the first pass, in later passes those with an edge outside the `old` boundary, which the
    /// cuts made.
    fn fill(&mut self, old: &HashSet<Edge>, first: bool) -> Result<(), FillError> {
        let (mesh, expected_error, report, caps) = {
            let mut found = self.draft.take_inspection()?;
            let sheets = match self.params.borders && !self.params.fill.flat_base {
                true => choice::take_borders(&mut found),
                false => Vec::new(),
            };
            let mut made: Vec<HoleId> = Vec::new();
            for hole in &mut found.holes {
                if edges(&hole.rim).any(|e| !old.contains(&e)) {
                    // A hole made by a cut is not the outer border of a sheet.
                    hole.outer_boundary = false;
                    made.push(hole.id);
                }
            }
            let mut params = match first && self.params.holes {
                true => self.choice.params(
                    &found,
                    &self.draft.origins.vertices,
                    &made,
                    &self.params.fill,
                ),
                false => FillParams {
                    holes: Some(made),
                    max_diameter: None,
                    keep_open: Vec::new(),
                    bridge: Vec::new(),
                    flat: Vec::new(),
                    crease: Vec::new(),
                    ..self.params.fill.clone()
                },
            };
            let mut caps = caps::of_sheets(&found, sheets, &mut params)?;
            let regions = found.regions(&params)?;
            let watch = Watch::new(*self.control, regions.expected_work());
            let mut filled = regions.fill(&watch)?;
            if first && self.params.borders {
                self.cap_mouths(&found, &params, &mut filled)?;
            }
            if first {
                let numbers = self.choice.numbers(&found, &self.draft.origins.vertices);
                report::renumber(&mut filled.report, &numbers);
                caps.iter_mut()
                    .for_each(|id| *id = numbers.get(id).copied().unwrap_or(*id));
            }
            (filled.mesh, filled.expected_error, filled.report, caps)
        };
        let regions = self.report.fill.regions.len();
        let holes = if first {
            0
        } else {
            report::last_number(&self.report.fill)
        };
        let caps: Vec<HoleId> = caps.iter().map(|id| HoleId(id.0 + holes)).collect();
        let known = self.draft.mesh.positions.len();
        self.draft
            .append_fill(mesh, expected_error, &report, regions);
        self.draft.round_from(known);
        self.append_report(report, regions, holes, first);
        self.drop_bad_caps(&caps, regions)
    }

    /// Appends the report of a fill to the report of the fills before it.
    fn append_report(&mut self, mut new: FillReport, regions: usize, holes: usize, first: bool) {
        let all = &mut self.report.fill;
        if first {
            all.holes.clear();
            all.all_holes = new.all_holes;
            all.open_chains = new.open_chains;
        }
        for mut hole in new.holes.drain(..) {
            if !first && hole.region == 0 {
                continue;
            }
            hole.hole.id.0 += holes;
            hole.region += if hole.region > 0 { regions } else { 0 };
            all.holes.push(hole);
        }
        for mut region in new.regions.drain(..) {
            region.id += regions;
            region.holes.iter_mut().for_each(|id| id.0 += holes);
            all.regions.push(region);
        }
    }
}

/// A snapshot: the draft, its report and the number of input faces lost because of patches; with its faults.
type State = ((Draft, RepairReport, usize), Faults);

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
