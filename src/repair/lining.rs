//! Holes that nothing else closes are closed by lining the surface round them: a second layer a hair under it, which hangs on the rim
//! and ends where it can be closed.
//!
//! What sticks through a hole stands in a pocket then. A sheet all of which is lined is a thin shell.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::clear::Ground;
use super::draft::Draft;
use super::flat::{closed_after, push};
use super::known::sorted;
use super::layer::{Layer, Lined, edges_of};
use super::rounding::Rounding;
use super::{Edge, edges};
use crate::fill::{ClosedBy, RegionReport};
use crate::mend::{FillError, FillReport, HoleReport, Inspection};
use crate::mesh::cut::settled;
use crate::mesh::topology::NONE;
use crate::mesh::{Hole, VertexFaces};
use crate::tuning::tuning;

/// How many faces may still be looked at.
pub(super) struct Budget {
    parts: usize,
    whole: usize,
}

impl Budget {
    /// What may be looked at, all of components only where they `may_be_shells`.
    pub(super) fn new(may_be_shells: bool) -> Self {
        Self {
            parts: tuning().repair.lined_work,
            whole: if may_be_shells {
                tuning().repair.lined_whole_work
            } else {
                0
            },
        }
    }
}

/// What came of a search for linings.
pub(super) struct Done {
    /// Linings that were added.
    pub(super) count: usize,
    /// What keeps other holes from being lined: all of a component first, then the fewest faces first.
    pub(super) blocked: Vec<Blocked>,
}

/// Faces at which no layer under them crosses nothing, and the holes that could not be lined for them.
pub(super) struct Blocked {
    /// Welded corners of the faces, in rising order.
    pub(super) faces: HashSet<[u32; 3]>,
    /// Vertices of the holes' rims.
    pub(super) rims: HashSet<u32>,
    /// Whether all of the component was to be lined.
    pub(super) whole: bool,
}

/// Closes the `chosen` open holes by linings that cross nothing, so that no face goes: each by one as small as may be, those of a
/// component that are left together, the last by one of all the component. Only the last is tried where it is to be the `whole`.
pub(super) fn line(
    draft: &mut Draft,
    report: &mut FillReport,
    chosen: &dyn Fn(&HoleReport) -> bool,
    whole: bool,
    budget: &mut Budget,
) -> Result<Done, FillError> {
    let told = told(report, chosen);
    if told.is_empty() {
        return Ok(Done {
            count: 0,
            blocked: Vec::new(),
        });
    }
    let mut linings = linings(draft, &told, whole, budget)?;
    let done = Done {
        count: linings.groups.len(),
        blocked: std::mem::take(&mut linings.blocked),
    };
    if done.count > 0 {
        linings.take_over(draft, report);
    }
    Ok(done)
}

/// Cuts faces out that are in the way of a layer, unless more than `most` faces of the input or all of a component would go; adds what
/// they leave to the rims. Returns how many faces of the input went; none where nothing was cut.
pub(super) fn cut(
    draft: &mut Draft,
    blocked: &mut Blocked,
    most: usize,
) -> Result<Option<usize>, FillError> {
    let removed = {
        let found = draft.inspect()?;
        let marks: Vec<bool> = (found.mesh.faces.iter())
            .map(|f| blocked.faces.contains(&sorted(*f)))
            .collect();
        let mut removed = settled(&found.mesh, &found.topology, &marks, true);
        draft.spare(&mut removed);
        let gone = found.mesh.faces.iter().zip(&removed).filter(|(_, r)| **r);
        blocked.rims.extend(gone.flat_map(|(f, _)| f));
        removed
    };
    let gone = removed.iter().zip(&draft.region);
    let own = gone.filter(|(r, region)| **r && **region == NONE).count();
    if own > most || !removed.contains(&true) {
        return Ok(None);
    }
    draft.remove(&removed);
    Ok(Some(own))
}

/// Tells of chosen holes whose rims went with what was cut out as closed by the last lining, if they are open no more.
pub(super) fn tell_gone(
    draft: &Draft,
    report: &mut FillReport,
    chosen: &dyn Fn(&HoleReport) -> bool,
) -> Result<(), FillError> {
    let found = draft.inspect()?;
    let open = edges_of(found.holes.iter().map(|h| &h.rim[..]));
    let Some(last) = report.regions.last_mut() else {
        return Ok(());
    };
    for hole in &mut report.holes {
        if chosen(hole) && !edges(&hole.hole.rim).any(|e| open.contains(&e)) {
            hole.outcome = closed_after(&hole.outcome);
            hole.region = last.id;
            last.holes.push(hole.hole.id);
        }
    }
    Ok(())
}

/// The places in the report of the holes to close, by the edges of their rims.
fn told(report: &FillReport, chosen: &dyn Fn(&HoleReport) -> bool) -> HashMap<Edge, usize> {
    let holes = report.holes.iter().enumerate();
    let open = holes.filter(|(_, h)| chosen(h));
    open.flat_map(|(i, h)| edges(&h.hole.rim).map(move |e| (e, i)))
        .collect()
}

/// Linings that were found.
struct Linings {
    /// The vertices that they add.
    vertices: Vec<glam::DVec3>,
    groups: Vec<Group>,
    blocked: Vec<Blocked>,
}

/// Holes that are closed by one lining.
struct Group {
    /// Their places in the report.
    told: BTreeSet<usize>,
    diameter: f64,
    faces: Vec<[u32; 3]>,
}

/// Linings of single holes, then of several holes of a component together.
fn linings(
    draft: &Draft,
    told: &HashMap<Edge, usize>,
    whole: bool,
    budget: &mut Budget,
) -> Result<Linings, FillError> {
    let found = draft.inspect()?;
    let of_hole = |hole: &Hole| edges(&hole.rim).find_map(|e| told.get(&e).copied());
    let all = found.holes.iter().rev();
    let open: Vec<(usize, &Hole)> = all.filter_map(|h| Some((of_hole(h)?, h))).collect();
    let ground = Ground::new(&found);
    let first = ground.positions().len();
    let mut search = Search {
        found: &found,
        around: VertexFaces::new(&found.mesh),
        ground,
        budget,
        blocked: Vec::new(),
        in_vain: HashMap::new(),
        rounding: draft.rounding,
    };
    let mut groups: Vec<Group> = Vec::new();
    let mut left: BTreeMap<u32, Vec<(usize, &Hole)>> = BTreeMap::new();
    for hole in open {
        let alone = (!whole).then(|| search.group(&[hole], false)).flatten();
        match alone {
            Some(group) => groups.push(group),
            None => left.entry(hole.1.piece).or_default().push(hole),
        }
    }
    for holes in left.values() {
        let several = (holes.len() > 1 && !whole)
            .then(|| search.group(holes, false))
            .flatten();
        groups.extend(several.or_else(|| search.group(holes, true)));
    }
    let mut blocked = search.blocked;
    blocked.sort_by_key(|b| (!b.whole, b.faces.len()));
    Ok(Linings {
        blocked,
        vertices: search.ground.positions()[first..].to_vec(),
        groups,
    })
}

/// A search for linings.
struct Search<'a> {
    found: &'a Inspection<'a>,
    around: VertexFaces,
    ground: Ground<'a>,
    budget: &'a mut Budget,
    blocked: Vec<Blocked>,
    /// Faces that keep an offset shell of a whole component from being placed, by component, where that was found for one hole. What
    /// failed for want of budget is not here: with a larger one it may not.
    in_vain: HashMap<u32, Vec<u32>>,
    rounding: Rounding,
}

impl Search<'_> {
    /// The lining that closes some holes of a component, each with its place in the report.
    fn group(&mut self, holes: &[(usize, &Hole)], whole: bool) -> Option<Group> {
        let rims: Vec<&Hole> = holes.iter().map(|(_, hole)| *hole).collect();
        Some(Group {
            faces: match whole {
                true => self.shell(&rims)?,
                false => self.closed(&rims)?,
            },
            told: holes.iter().map(|(told, _)| *told).collect(),
            diameter: rims.iter().map(|h| h.diameter).fold(0.0, f64::max),
        })
    }

    /// The faces of a lining with as few rings of faces as close some holes; none where there is none.
    fn closed(&mut self, holes: &[&Hole]) -> Option<Vec<[u32; 3]>> {
        let rims = edges_of(holes.iter().map(|h| &h.rim[..]));
        let mut region = Region::new(holes);
        let mut left = self.budget.parts.min(tuning().repair.lined_work_each);
        let all = left;
        let mut found = None;
        let mut blocked: Option<Vec<u32>> = None;
        for rings in (0..).map(|i| 1 << i) {
            let grew = region.grow(self.found, &self.around, rings, tuning().repair.lined_faces);
            if !grew || region.faces.len() > tuning().repair.lined_faces.min(left) {
                break;
            }
            left -= region.faces.len();
            match self.lined(&region.faces, &rims, &mut left) {
                Ok(faces) => {
                    found = Some(faces);
                    break;
                }
                Err(way) => {
                    if !way.is_empty() && holes.len() == 1 && self.is_all(&region) {
                        self.in_vain.insert(region.piece, way.clone());
                    }
                    let fewer = |b: &Vec<u32>| way.len() < b.len();
                    if !way.is_empty() && blocked.as_ref().is_none_or(fewer) {
                        blocked = Some(way);
                    }
                }
            }
        }
        self.budget.parts -= all - left;
        if let Some(way) = blocked.filter(|_| found.is_none()) {
            self.block(holes, &way, false);
        }
        found
    }

    /// The faces of a lining of all of a component that closes some holes; none where there is none.
    fn shell(&mut self, holes: &[&Hole]) -> Option<Vec<[u32; 3]>> {
        let rims = edges_of(holes.iter().map(|h| &h.rim[..]));
        let mut region = Region::new(holes);
        let faces = self.found.topology.piece_faces[region.piece as usize];
        if faces > tuning().repair.lined_whole.min(self.budget.whole) {
            return None;
        }
        region.grow(
            self.found,
            &self.around,
            usize::MAX,
            tuning().repair.lined_whole,
        );
        let mut left = self.budget.whole - faces;
        self.budget.whole = left;
        let known = self
            .in_vain
            .remove(&region.piece)
            .filter(|_| holes.len() == 1);
        let lined = match known {
            Some(way) => Err(way),
            None => self.lined(&region.faces, &rims, &mut left),
        };
        if let Err(way) = &lined
            && !way.is_empty()
        {
            self.block(holes, way, true);
        }
        lined.ok()
    }

    /// Whether a region is all of its component.
    fn is_all(&self, region: &Region) -> bool {
        let all = self.found.topology.piece_faces.get(region.piece as usize);
        all == Some(&region.faces.len())
    }

    /// Remembers what is in the way of a lining.
    fn block(&mut self, holes: &[&Hole], way: &[u32], whole: bool) {
        let corners = way
            .iter()
            .map(|f| sorted(self.found.mesh.faces[*f as usize]));
        self.blocked.push(Blocked {
            faces: corners.collect(),
            rims: holes.iter().flat_map(|h| h.rim.iter().copied()).collect(),
            whole,
        });
    }

    /// The faces of a lining of some faces and what closes its other borders; else the faces that are in its way, none if it is not
    /// for them.
    fn lined(
        &mut self,
        faces: &[u32],
        rims: &HashSet<Edge>,
        left: &mut usize,
    ) -> Result<Vec<[u32; 3]>, Vec<u32>> {
        let lined = Lined {
            found: self.found,
            around: &self.around,
            faces,
            rims,
            rounding: self.rounding,
        };
        let ground = &mut self.ground;
        let before = ground.mark();
        let first = ground.positions().len() as u32;
        let mut layer = Layer::new(&lined, first).ok_or_else(Vec::new)?;
        // The longest is the least likely to be closed.
        layer.loops.sort_by_key(|ring| Reverse(ring.len()));
        let longest = layer.loops.first().map_or(0, Vec::len);
        if longest > tuning().repair.lined_edges {
            return Err(Vec::new());
        }
        layer.place(ground)?;
        for ring in &layer.loops {
            let work = ring.len() * ring.len() / tuning().repair.lined_edges_work;
            let cap = (work <= *left).then(|| ground.close(ring)).flatten();
            *left = left.saturating_sub(work);
            match cap {
                Some(cap) => layer.faces.extend(cap),
                None => {
                    ground.go_back(before);
                    return Err(Vec::new());
                }
            }
        }
        Ok(layer.faces)
    }
}

/// The faces round some rims.
struct Region {
    piece: u32,
    faces: Vec<u32>,
    known: HashSet<u32>,
    border: BTreeSet<u32>,
    rings: usize,
}

impl Region {
    fn new(holes: &[&Hole]) -> Self {
        Self {
            piece: holes.first().map_or(NONE, |h| h.piece),
            faces: Vec::new(),
            known: HashSet::new(),
            border: holes.iter().flat_map(|h| h.rim.iter().copied()).collect(),
            rings: 0,
        }
    }

    /// Takes faces in until there are so many rings of them, or more than so many; says whether there were more.
    fn grow(
        &mut self,
        found: &Inspection,
        around: &VertexFaces,
        rings: usize,
        most: usize,
    ) -> bool {
        let before = self.faces.len();
        while self.rings < rings && self.faces.len() <= most && !self.border.is_empty() {
            let first = self.faces.len();
            for v in std::mem::take(&mut self.border) {
                for &f in around.of(v) {
                    if found.topology.piece[f as usize] == self.piece && self.known.insert(f) {
                        self.faces.push(f);
                    }
                }
            }
            let new = self.faces[first..].iter();
            self.border = new.flat_map(|f| found.mesh.faces[*f as usize]).collect();
            self.rings += 1;
        }
        self.faces.len() > before
    }
}

impl Linings {
    /// Adds the linings to a draft and tells of them.
    fn take_over(self, draft: &mut Draft, report: &mut FillReport) {
        for position in &self.vertices {
            draft.mesh.positions.push(*position);
            draft.origins.vertices.push(NONE);
            draft.sigma.push(None);
        }
        for group in self.groups {
            let region = report.regions.len();
            group
                .faces
                .iter()
                .for_each(|f| push(draft, region as u32, *f));
            let mut holes = Vec::new();
            for told in &group.told {
                let hole = &mut report.holes[*told];
                hole.outcome = closed_after(&hole.outcome);
                hole.region = region + 1;
                holes.push(hole.hole.id);
            }
            report.regions.push(RegionReport {
                id: region + 1,
                holes,
                diameter: group.diameter,
                closed_by: Some(ClosedBy::Lining),
                components: 1,
                ..RegionReport::default()
            });
        }
    }
}
