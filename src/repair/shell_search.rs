//! The search for linings: round single holes, round several together, under all of a component.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::clear::Ground;
use super::draft::Draft;
use super::known::sorted;
use super::offset_shell::{OffsetShell, WallFace, edges_of};
use super::rings::Region;
use super::rounding::Rounding;
use super::shell_vertex::{Shape, ShellBase};
use super::{Edge, edges};
use crate::mend::{FillError, Inspection};
use crate::mesh::{Hole, VertexFaces};
use crate::spatial::Bvh;
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
            parts: tuning().repair.shell_work,
            whole: if may_be_shells {
                tuning().repair.shell_whole_work
            } else {
                0
            },
        }
    }
}

/// Which walls are wanted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// Their thickness in the mesh's units; none for one by the edges.
    pub(super) wall: Option<f64>,
    /// Whether open sheets get walls all over before anything else is tried.
    pub(super) sheets: bool,
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

/// Linings that were found.
pub(super) struct OffsetShells {
    /// The vertices that they add.
    pub(super) vertices: Vec<glam::DVec3>,
    pub(super) groups: Vec<Group>,
    pub(super) blocked: Vec<Blocked>,
}

/// Holes that are closed by one lining.
pub(super) struct Group {
    /// Their places in the report.
    pub(super) report_indices: BTreeSet<usize>,
    pub(super) diameter: f64,
    pub(super) faces: Vec<[u32; 3]>,
    pub(super) edge: f64,
    pub(super) walls: Vec<WallFace>,
    pub(super) walled: bool,
}

/// Linings of single holes, then of several holes of a component together.
pub(super) fn find(
    draft: &Draft,
    report_indices: &HashMap<Edge, usize>,
    (whole, wanted): (bool, Wanted),
    budget: &mut Budget,
) -> Result<OffsetShells, FillError> {
    let found = draft.inspect()?;
    let of_hole = |hole: &Hole| edges(&hole.rim).find_map(|e| report_indices.get(&e).copied());
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
        known_blocked: HashMap::new(),
        no_wall: HashSet::new(),
        wall: wanted.wall,
        bvh: None,
        rounding: draft.rounding,
    };
    let mut groups: Vec<Group> = Vec::new();
    let mut left: BTreeMap<u32, Vec<(usize, &Hole)>> = BTreeMap::new();
    let mut of_sheets: BTreeMap<u32, Vec<(usize, &Hole)>> = BTreeMap::new();
    for hole in open.iter().filter(|_| wanted.sheets && !whole) {
        of_sheets.entry(hole.1.component).or_default().push(*hole);
    }
    of_sheets.retain(|_, holes| search.is_sheet(holes));
    let mut walled: HashSet<u32> = HashSet::new();
    for (component, holes) in &of_sheets {
        if let Some(group) = search.group(holes, Part::Walled) {
            walled.insert(*component);
            groups.push(group);
        }
    }
    for hole in open
        .into_iter()
        .filter(|h| !walled.contains(&h.1.component))
    {
        let alone = (!whole)
            .then(|| search.group(&[hole], Part::Rings))
            .flatten();
        match alone {
            Some(group) => groups.push(group),
            None => left.entry(hole.1.component).or_default().push(hole),
        }
    }
    for holes in left.values() {
        let several = (holes.len() > 1 && !whole)
            .then(|| search.group(holes, Part::Rings))
            .flatten();
        groups.extend(several.or_else(|| search.group(holes, Part::Whole)));
    }
    let mut blocked = search.blocked;
    blocked.sort_by_key(|b| (!b.whole, b.faces.len()));
    Ok(OffsetShells {
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
    known_blocked: HashMap<u32, Vec<u32>>,
    /// Components that were tried to be given walls all over.
    no_wall: HashSet<u32>,
    /// The thickness of walls that is wanted; none for one by the edges.
    wall: Option<f64>,
    /// The faces of the mesh, once walls were looked for.
    bvh: Option<Bvh>,
    rounding: Rounding,
}

/// How much of a component is lined.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    /// As few rings of faces as may be.
    Rings,
    /// All of it, by walls with sides at its rims.
    Walled,
    /// All of it, by walls or else by a layer a hair under it.
    Whole,
}

/// A lining that was found.
struct FoundShell {
    /// Its faces.
    faces: Vec<[u32; 3]>,
    /// The walls that it makes.
    walls: Vec<WallFace>,
    /// Whether it has side walls at the rims.
    walled: bool,
}

impl Search<'_> {
    /// The lining that closes some holes of a component, each with its place in the report.
    fn group(&mut self, holes: &[(usize, &Hole)], part: Part) -> Option<Group> {
        let rims: Vec<&Hole> = holes.iter().map(|(_, hole)| *hole).collect();
        let (edge, found) = match part {
            Part::Rings => self.closed(&rims)?,
            _ => self.shell(&rims, part == Part::Whole)?,
        };
        Some(Group {
            faces: found.faces,
            walls: found.walls,
            walled: found.walled,
            edge,
            report_indices: holes
                .iter()
                .map(|(report_indices, _)| *report_indices)
                .collect(),
            diameter: rims.iter().map(|h| h.diameter).fold(0.0, f64::max),
        })
    }

    /// Whether one of some holes of a component is its outer border: a sheet that no cap closed.
    fn is_sheet(&self, holes: &[(usize, &Hole)]) -> bool {
        let is_small = |h: &Hole| {
            self.found.topology.component_faces[h.component as usize] <= tuning().repair.small_faces
        };
        (holes.iter()).any(|(_, hole)| hole.outer_border || is_small(hole))
    }

    /// The mean edge of some faces, and the depth of walls under them.
    fn depth(&self, faces: &[u32]) -> (f64, f64) {
        let mesh = &self.found.mesh;
        let around = faces.iter().map(|f| {
            let [a, b, c] = mesh.corners(*f);
            a.distance(b) + b.distance(c) + c.distance(a)
        });
        let edge = around.sum::<f64>() / (3 * faces.len().max(1)) as f64;
        (edge, self.wall.unwrap_or(tuning().repair.wall * edge))
    }

    /// The faces of a lining with as few rings of faces as close some holes; none where there is none. Thick ones come first.
    fn closed(&mut self, holes: &[&Hole]) -> Option<(f64, FoundShell)> {
        let all = self.budget.parts;
        let thick = self.rings(holes, true);
        let spent = self.budget.parts;
        if thick.is_some() {
            return thick;
        }
        self.budget.parts = all;
        let thin = self.rings(holes, false);
        self.budget.parts = self.budget.parts.min(spent);
        thin
    }

    /// The same at the depth of walls, or a hair under the surface.
    fn rings(&mut self, holes: &[&Hole], thick: bool) -> Option<(f64, FoundShell)> {
        let rims = edges_of(holes.iter().map(|h| &h.rim[..]));
        let mut region = Region::new(holes);
        let mut left = self.budget.parts.min(tuning().repair.shell_work_each);
        let all = left;
        let mut found = None;
        let mut blocked: Option<Vec<u32>> = None;
        for rings in (0..).map(|i| 1 << i) {
            let grew = region.grow(self.found, &self.around, rings, tuning().repair.shell_faces);
            if !grew || region.faces.len() > tuning().repair.shell_faces.min(left) {
                break;
            }
            left -= region.faces.len();
            let (edge, depth) = self.depth(&region.faces);
            let shape = match thick {
                true => Shape::Hanging(depth),
                false => Shape::Hair,
            };
            match self.shell_under(&region.faces, &rims, shape, &mut left) {
                Ok(shell) => {
                    found = Some((edge, shell));
                    break;
                }
                Err(_) if thick => {}
                Err(obstacles) => {
                    if !obstacles.is_empty() && holes.len() == 1 && self.is_all(&region) {
                        self.known_blocked
                            .insert(region.component, obstacles.clone());
                    }
                    let fewer = |b: &Vec<u32>| obstacles.len() < b.len();
                    if !obstacles.is_empty() && blocked.as_ref().is_none_or(fewer) {
                        blocked = Some(obstacles);
                    }
                }
            }
        }
        self.budget.parts -= all - left;
        if let Some(obstacles) = blocked.filter(|_| found.is_none()) {
            self.block(holes, &obstacles, false);
        }
        found
    }

    /// A lining of all of a component that closes some holes, and its mean edge; none where there is none. It makes walls, or else, where
    /// that is asked for, a layer a `hair` under the surface.
    fn shell(&mut self, holes: &[&Hole], hair: bool) -> Option<(f64, FoundShell)> {
        let rims = edges_of(holes.iter().map(|h| &h.rim[..]));
        let mut region = Region::new(holes);
        let faces = self.found.topology.component_faces[region.component as usize];
        if faces > tuning().repair.shell_whole.min(self.budget.whole) {
            return None;
        }
        region.grow(
            self.found,
            &self.around,
            usize::MAX,
            tuning().repair.shell_whole,
        );
        let mut left = self.budget.whole - faces;
        self.budget.whole = left;
        let (edge, depth) = self.depth(&region.faces);
        if self.no_wall.insert(region.component) {
            for shape in [Shape::Walled(depth), Shape::Hanging(depth)] {
                if let Ok(shell) = self.shell_under(&region.faces, &rims, shape, &mut left) {
                    return Some((edge, shell));
                }
            }
        }
        if !hair {
            // It is looked at again in another way.
            self.budget.whole += faces;
            return None;
        }
        let known = self
            .known_blocked
            .remove(&region.component)
            .filter(|_| holes.len() == 1);
        let base = match known {
            Some(obstacles) => Err(obstacles),
            None => self.shell_under(&region.faces, &rims, Shape::Hair, &mut left),
        };
        if let Err(obstacles) = &base
            && !obstacles.is_empty()
        {
            self.block(holes, obstacles, true);
        }
        Some((edge, base.ok()?))
    }

    /// Whether a region is all of its component.
    fn is_all(&self, region: &Region) -> bool {
        let all = self
            .found
            .topology
            .component_faces
            .get(region.component as usize);
        all == Some(&region.faces.len())
    }

    /// Remembers what is in the way of a lining.
    fn block(&mut self, holes: &[&Hole], obstacles: &[u32], whole: bool) {
        let corners = obstacles
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
    fn shell_under(
        &mut self,
        faces: &[u32],
        rims: &HashSet<Edge>,
        shape: Shape,
        left: &mut usize,
    ) -> Result<FoundShell, Vec<u32>> {
        if self.bvh.is_none() && shape.depth().is_some() {
            let found = self.found;
            self.bvh = Some(Bvh::new(&found.mesh, found.topology.faces()));
        }
        let base = ShellBase {
            found: self.found,
            around: &self.around,
            faces,
            rims,
            rounding: self.rounding,
            shape,
            bvh: shape.depth().and(self.bvh.as_ref()),
        };
        let ground = &mut self.ground;
        let before = ground.mark();
        let first = ground.positions().len() as u32;
        let mut shell = OffsetShell::new(&base, first).ok_or_else(Vec::new)?;
        // The longest is the least likely to be closed.
        shell.loops.sort_by_key(|ring| Reverse(ring.len()));
        let longest = shell.loops.first().map_or(0, Vec::len);
        if longest > tuning().repair.shell_edges {
            return Err(Vec::new());
        }
        shell.place(ground)?;
        let walls = shell.walls(&base);
        for ring in &shell.loops {
            let work = ring.len() * ring.len() / tuning().repair.shell_edges_work;
            let cap = (work <= *left).then(|| ground.close(ring)).flatten();
            *left = left.saturating_sub(work);
            match cap {
                Some(cap) => shell.faces.extend(cap),
                None => {
                    ground.go_back(before);
                    return Err(Vec::new());
                }
            }
        }
        Ok(FoundShell {
            faces: shell.faces,
            walls,
            walled: shape.has_sides(),
        })
    }
}
