//! Flat caps for the borders of open sheets and the mouths of vessels, kept if they intersect nothing and leave no foil (thin
//! walls) below them.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::Run;
use super::draft::Draft;
use super::shell_walls::LEAST_WALL;
use crate::check::Walls;
use crate::fill::{Closure, FillParams, HoleOutcome, LeftReason, RegionReport};
use crate::mend::{FillError, FillReport, Filled, Inspection, Watch};
use crate::mesh::topology::NONE;
use crate::mesh::{Hole, HoleId, Mesh, area_vector};
use crate::tuning::{Tunable, tunable};

/// Diameters of the smaller boundary loop. The loops of two sheets are the two sides of one gap where half of the shorter
/// one is closer to the other than this; otherwise each is capped, or its sheet gets walls.
const GAP: Tunable<f64> = tunable("repair.gap", 0.25);

/// Fraction of a flat cap's area, at least, over which the body under it is not foil; otherwise its sheet gets walls.
const THICK_CAP: Tunable<f64> = tunable("repair.thick_cap", 0.75);

/// Requests flat caps for the borders of sheets and returns these borders. Excluded are borders that the caller already lists as
/// flat and borders that are filled together with other holes; two borders that are only close to each other are capped
/// separately.
pub(super) fn of_sheets(
    found: &Inspection,
    mut sheets: Vec<HoleId>,
    params: &mut FillParams,
) -> Result<Vec<HoleId>, FillError> {
    if !sheets.is_empty() {
        let regions = found.regions(params)?;
        let stays = |group: &Vec<&Hole>| {
            let is_sheet = |h: &&Hole| sheets.contains(&h.id);
            match group[..] {
                [] | [_] => true,
                [one, other] if group.iter().all(is_sheet) => !is_gap(&found.mesh, one, other),
                _ => false,
            }
        };
        let alone = regions.hole_groups().filter(stays).flatten();
        let alone: HashSet<HoleId> = alone.map(|h| h.id).collect();
        sheets.retain(|id| alone.contains(id) && !params.flat.contains(id));
        params.flat.extend(&sheets);
    }
    Ok(sheets)
}

/// Whether two borders are the sides of one gap: more than half of the shorter one is close to the other one.
fn is_gap(mesh: &Mesh, one: &Hole, other: &Hole) -> bool {
    let (short, long) = match one.rim.len() <= other.rim.len() {
        true => (one, other),
        false => (other, one),
    };
    let width = GAP.get() * one.diameter.min(other.diameter);
    let at = |v: &u32| mesh.positions[*v as usize];
    let is_near = |v: &&u32| long.rim.iter().any(|w| at(v).distance(at(w)) < width);
    2 * short.rim.iter().filter(is_near).count() > short.rim.len()
}

impl Run<'_> {
    /// Replaces level-set patches that bulge out of single holes like balloons by flat caps, if these intersect nothing.
    pub(super) fn cap_mouths(
        &self,
        found: &Inspection,
        params: &FillParams,
        filled: &mut Filled,
    ) -> Result<(), FillError> {
        let is_mouth = |r: &&RegionReport| r.balloons() && r.holes.len() == 1;
        let mouths = filled.report.regions.iter().filter(is_mouth);
        let mouths: Vec<HoleId> = mouths.flat_map(|r| r.holes.iter().copied()).collect();
        if mouths.is_empty() {
            return Ok(());
        }
        let flat = FillParams {
            flat: mouths.clone(),
            ..params.of_holes(Some(mouths))
        };
        let regions = found.regions(&flat)?;
        let watch = Watch::new(*self.control, regions.expected_work());
        let caps = regions.fill(&watch)?;
        exchange(&self.draft.mesh, filled, caps);
        Ok(())
    }

    /// Removes caps of sheets that intersect something or leave foil, so that these sheets get walls later. `caps` are the
    /// numbers of their borders; `first` is the index of the first region of the fill that made them.
    pub(super) fn drop_bad_caps(&mut self, caps: &[HoleId], first: usize) -> Result<(), FillError> {
        let fill = &self.report.fill;
        let own = |r: &&RegionReport| r.id > first && r.holes.iter().any(|id| caps.contains(id));
        let regions: Vec<u32> = (fill.regions.iter().filter(own))
            .map(|r| r.id as u32 - 1)
            .collect();
        if regions.is_empty() {
            return Ok(());
        }
        let thin = foils(&self.draft, &regions, self.params.min_wall)?;
        let is_good = |region: &u32| {
            let r = &fill.regions[*region as usize];
            let clear = r.closure == Some(Closure::Flat) && r.intersecting_faces == 0;
            clear && !thin.contains(region)
        };
        let bad: BTreeSet<u32> = regions.into_iter().filter(|r| !is_good(r)).collect();
        let removed: Vec<bool> = self.draft.region.iter().map(|r| bad.contains(r)).collect();
        self.draft.remove(&removed);
        for region in bad {
            leave(&mut self.report.fill, region);
        }
        Ok(())
    }
}

/// Records the border of a region as left open.
fn leave(report: &mut FillReport, region: u32) {
    let own = &mut report.regions[region as usize];
    own.closure = None;
    own.new_vertices = 0;
    own.set_intersecting(0);
    let id = own.id;
    for hole in report.holes.iter_mut().filter(|h| h.region == id) {
        hole.outcome = HoleOutcome::Left(LeftReason::OuterBoundary);
    }
}

/// Replaces patches by caps of the same holes that intersect nothing. Both fills were made from the mesh `before`.
fn exchange(before: &Mesh, filled: &mut Filled, caps: Filled) {
    let (vertices, faces) = (before.positions.len(), before.faces.len());
    let patches = |filled: &Filled| {
        let mut at = faces;
        let ends = filled.report.regions.iter().map(move |r| {
            at += r.new_faces;
            at - r.new_faces..at
        });
        ends.collect::<Vec<_>>()
    };
    let shift = (filled.mesh.positions.len() - vertices) as u32;
    let moved = |v: u32| v + if v as usize >= vertices { shift } else { 0 };
    // The patches of the two fills as ranges of faces; vertices of caps follow the vertices of the first fill.
    let (old, new) = (patches(filled), patches(&caps));
    let is_clear = |r: &RegionReport| r.closure == Some(Closure::Flat) && r.intersecting_faces == 0;
    let mut mesh = Mesh::new(
        std::mem::take(&mut filled.mesh.positions),
        filled.mesh.faces[..faces].to_vec(),
    );
    mesh.positions.extend(&caps.mesh.positions[vertices..]);
    filled.expected_error.extend(caps.expected_error);
    for (i, region) in filled.report.regions.iter_mut().enumerate() {
        let of_caps = caps.report.regions.iter().zip(&new);
        let mut cap = of_caps.filter(|(r, _)| is_clear(r) && r.holes == region.holes);
        let Some((cap, own)) = cap.next() else {
            mesh.faces.extend(&filled.mesh.faces[old[i].clone()]);
            continue;
        };
        let own = caps.mesh.faces[own.clone()].iter();
        mesh.faces.extend(own.map(|f| f.map(moved)));
        *region = RegionReport {
            id: region.id,
            ..cap.clone()
        };
        for hole in (filled.report.holes.iter_mut()).filter(|h| region.holes.contains(&h.hole.id)) {
            hole.outcome = HoleOutcome::Closed(Closure::Flat);
        }
    }
    filled.mesh = mesh;
}

/// The regions whose flat caps leave foil: below most of the cap the body is thinner than `least`, by default than a fraction of
/// the sheet's mean edge length.
fn foils(draft: &Draft, regions: &[u32], least: Option<f64>) -> Result<BTreeSet<u32>, FillError> {
    let found = draft.inspect()?;
    let (mesh, topology) = (&found.mesh, &found.topology);
    let sheets = Sheets::new(draft, &found);
    let walls = Walls::new(mesh, topology);
    let asked: BTreeSet<u32> = regions.iter().copied().collect();
    // For each region the area of its cap, and the area above thick enough parts of the body.
    let mut areas: HashMap<u32, [f64; 2]> = HashMap::new();
    for f in topology.faces() {
        let region = draft.region[f as usize];
        if !asked.contains(&region) {
            continue;
        }
        let component = topology.component[f as usize] as usize;
        let limit = least.unwrap_or(LEAST_WALL.get() * sheets.edge(component));
        let wall = walls.at(f, sheets.volume[component] < 0.0);
        let own = area_vector(mesh.corners(f)).length();
        let area = areas.entry(region).or_default();
        area[0] += own;
        if wall.is_none_or(|w| w.thickness >= limit) {
            area[1] += own;
        }
    }
    let is_foil = |[all, thick]: [f64; 2]| thick < THICK_CAP.get() * all;
    let foils = areas.into_iter().filter(|(_, area)| is_foil(*area));
    Ok(foils.map(|(region, _)| region).collect())
}

/// Volumes and mean edge lengths of the components of a draft.
struct Sheets {
    /// Six times the signed volume of each component; negative if it is inside out.
    volume: Vec<f64>,
    /// For each component the total edge length of its input faces, and the number of these edges.
    edges: Vec<(f64, usize)>,
}

impl Sheets {
    fn new(draft: &Draft, found: &Inspection) -> Self {
        let (mesh, topology) = (&found.mesh, &found.topology);
        let count = topology.component_faces.len();
        let mut sheets = Self {
            volume: vec![0.0; count],
            edges: vec![(0.0, 0); count],
        };
        // Volumes are computed relative to a vertex of the component: far from the origin cancellation would leave few correct
        // digits.
        let mut origin = vec![None; count];
        for f in topology.faces() {
            let component = topology.component[f as usize] as usize;
            let corners = mesh.corners(f);
            let from = *origin[component].get_or_insert(corners[0]);
            let [a, b, c] = corners.map(|p| p - from);
            let side = if topology.turned[f as usize] {
                -1.0
            } else {
                1.0
            };
            sheets.volume[component] += side * a.dot(b.cross(c));
            if draft.region[f as usize] == NONE {
                let (sum, count) = &mut sheets.edges[component];
                *sum += a.distance(b) + b.distance(c) + c.distance(a);
                *count += 3;
            }
        }
        sheets
    }

    /// The mean edge length of a component.
    fn edge(&self, component: usize) -> f64 {
        let (sum, count) = self.edges[component];
        sum / count.max(1) as f64
    }
}
