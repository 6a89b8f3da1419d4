//! Search for offset shells that close single holes, several holes of a component together, or cover a whole component.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::choice::SMALL_FACES;
use super::clear::Ground;
use super::draft::Draft;
use super::intersection_cache::sorted;
use super::offset_shell::{OffsetShell, WallFace, edges_of};
use super::rings::Region;
use super::rounding::Rounding;
use super::shell_vertex::{Shape, ShellBase};
use super::{Edge, edges};
use crate::mend::{FillError, Inspection};
use crate::mesh::{Hole, VertexFaces};
use crate::spatial::Bvh;
use crate::tuning::{Tunable, tunable};

/// Mean edges of the surface. Default thickness of the walls of an open sheet.
const WALL: Tunable<f64> = tunable("repair.wall", 1.0);

/// Faces of an offset shell for one hole, at most; it bounds the time, not the shape.
const SHELL_FACES: Tunable<usize> = tunable("repair.shell_faces", 20_000);

/// Faces of a component that gets an offset shell as a whole, as the last resort, at most.
const SHELL_WHOLE: Tunable<usize> = tunable("repair.shell_whole", 250_000);

/// Faces of all components that get an offset shell as a whole, at most.
const SHELL_WHOLE_WORK: Tunable<usize> = tunable("repair.shell_whole_work", 1_000_000);

/// Edges. Longer boundary loops are not closed: where hundreds of edges could not be closed at the rim, they seldom can
/// be farther away.
const SHELL_EDGES: Tunable<usize> = tunable("repair.shell_edges", 200);

/// Faces visited by the searches for offset shells of parts of a mesh, at most.
const SHELL_WORK: Tunable<usize> = tunable("repair.shell_work", 400_000);

/// Faces visited for one hole or for the holes of one component, at most.
const SHELL_WORK_EACH: Tunable<usize> = tunable("repair.shell_work_each", 40_000);

/// The search for triangles that close a boundary loop counts as the square of its number of edges over this, in visited
/// faces.
const SHELL_EDGES_WORK: Tunable<usize> = tunable("repair.shell_edges_work", 2);

/// The number of faces that the searches may still visit, for partial shells and for shells of whole components.
pub(super) struct Budget {
    parts: usize,
    whole: usize,
}

impl Budget {
    /// The full budget; shells of whole components only if `may_be_shells`.
    pub(super) fn new(may_be_shells: bool) -> Self {
        Self {
            parts: SHELL_WORK.get(),
            whole: if may_be_shells {
                SHELL_WHOLE_WORK.get()
            } else {
                0
            },
        }
    }
}

/// Options for walls.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// Thickness in mesh units; none for one from the edge lengths.
    pub(super) wall: Option<f64>,
    /// Whether open sheets get walls over the whole component before anything else is tried.
    pub(super) sheets: bool,
}

/// Faces below which every shell intersects something, and the holes that they block.
pub(super) struct Blocked {
    /// Sorted welded corners of the faces.
    pub(super) faces: HashSet<[u32; 3]>,
    /// Rim vertices of the blocked holes.
    pub(super) rims: HashSet<u32>,
    /// Whether the shell was to cover the whole component.
    pub(super) whole: bool,
}

/// Offset shells found by a search.
pub(super) struct OffsetShells {
    /// New vertices of the shells.
    pub(super) vertices: Vec<glam::DVec3>,
    pub(super) groups: Vec<Group>,
    pub(super) blocked: Vec<Blocked>,
}

/// Holes closed by one offset shell.
pub(super) struct Group {
    /// Indices of the holes in the report.
    pub(super) report_indices: BTreeSet<usize>,
    pub(super) diameter: f64,
    pub(super) faces: Vec<[u32; 3]>,
    pub(super) edge: f64,
    pub(super) walls: Vec<WallFace>,
    pub(super) walled: bool,
}

/// Searches shells for single holes, then for several holes of a component together, then for whole components.
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
    // Open sheets get walls over the whole component first.
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
        // Single holes, with as few rings as possible.
        let alone = (!whole)
            .then(|| search.group(&[hole], Part::Rings))
            .flatten();
        match alone {
            Some(group) => groups.push(group),
            None => left.entry(hole.1.component).or_default().push(hole),
        }
    }
    // Then the remaining holes of a component together, last the whole component.
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

/// State of a search for offset shells.
struct Search<'a> {
    found: &'a Inspection<'a>,
    around: VertexFaces,
    ground: Ground<'a>,
    budget: &'a mut Budget,
    blocked: Vec<Blocked>,
    /// For each component the faces that block a shell of the whole component, if the search for one of its holes found them.
    /// Searches that ran out of budget are not recorded, since a larger budget may succeed.
    known_blocked: HashMap<u32, Vec<u32>>,
    /// Components for which walls over the whole component were tried already.
    no_wall: HashSet<u32>,
    /// Wanted wall thickness; none for one from the edge lengths.
    wall: Option<f64>,
    /// The faces of the mesh, built when walls are first searched.
    bvh: Option<Bvh>,
    rounding: Rounding,
}

/// The extent of a shell.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    /// As few rings of faces round the rims as possible.
    Rings,
    /// The whole component, as walls.
    Walled,
    /// The whole component, as walls or else just below the surface.
    Whole,
}

/// An offset shell that intersects nothing.
struct FoundShell {
    /// Its faces.
    faces: Vec<[u32; 3]>,
    /// The walls between it and the surface.
    walls: Vec<WallFace>,
    /// Whether it has side walls at the rims.
    walled: bool,
}

impl Search<'_> {
    /// The shell that closes some holes of a component; the holes come with their indices in the report.
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

    /// Whether one of the holes is the outer border of its component, or the component is small: a sheet that no cap closed.
    fn is_sheet(&self, holes: &[(usize, &Hole)]) -> bool {
        let is_small = |h: &Hole| {
            self.found.topology.component_faces[h.component as usize] <= SMALL_FACES.get()
        };
        (holes.iter()).any(|(_, hole)| hole.outer_boundary || is_small(hole))
    }

    /// The mean edge length of some faces, and the depth of walls below them.
    fn depth(&self, faces: &[u32]) -> (f64, f64) {
        let mesh = &self.found.mesh;
        let around = faces.iter().map(|f| {
            let [a, b, c] = mesh.corners(*f);
            a.distance(b) + b.distance(c) + c.distance(a)
        });
        let edge = around.sum::<f64>() / (3 * faces.len().max(1)) as f64;
        (edge, self.wall.unwrap_or(WALL.get() * edge))
    }

    /// The shell with the fewest rings of faces that closes some holes; none if there is none. Walls at full depth are tried
    /// first.
    ///
    /// Where faces intersect however near the surface they are, they do so below any larger region too: the search ends there.
    fn closed(&mut self, holes: &[&Hole]) -> Option<(f64, FoundShell)> {
        let all = self.budget.parts;
        let mut reached = usize::MAX;
        let thick = self.rings(holes, true, &mut reached);
        let spent = self.budget.parts;
        if thick.is_some() {
            return thick;
        }
        self.budget.parts = all;
        let thin = self.rings(holes, false, &mut reached);
        self.budget.parts = self.budget.parts.min(spent);
        thin
    }

    /// The same at full depth if `thick`, else just below the surface. Doubles the number of rings, up to `reached`, until a shell
    /// closes the holes or the budget is spent. Lowers `reached` to the number of rings at which nothing can be made.
    fn rings(
        &mut self,
        holes: &[&Hole],
        thick: bool,
        reached: &mut usize,
    ) -> Option<(f64, FoundShell)> {
        let rims = edges_of(holes.iter().map(|h| &h.rim[..]));
        let mut region = Region::new(holes);
        let mut left = self.budget.parts.min(SHELL_WORK_EACH.get());
        let all = left;
        let mut found = None;
        let mut blocked: Option<Vec<u32>> = None;
        for rings in (0..).map(|i| 1 << i) {
            if rings > *reached {
                break;
            }
            let grew = region.grow(self.found, &self.around, rings, SHELL_FACES.get());
            if !grew || region.faces.len() > SHELL_FACES.get().min(left) {
                break;
            }
            left -= region.faces.len();
            let (edge, depth) = self.depth(&region.faces);
            let shape = match thick {
                true => Shape::Hanging(depth),
                false => Shape::Thin,
            };
            match self.shell_under(&region.faces, &rims, shape, &mut left) {
                Ok(shell) => {
                    found = Some((edge, shell));
                    break;
                }
                Err(obstacles) if thick => {
                    if !obstacles.is_empty() && self.is_blocked(&region.faces, &rims) {
                        *reached = rings;
                    }
                }
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

    /// Whether a shell below some faces intersects something however near the surface it is.
    fn is_blocked(&mut self, faces: &[u32], rims: &HashSet<Edge>) -> bool {
        let base = ShellBase {
            found: self.found,
            around: &self.around,
            faces,
            rims,
            rounding: self.rounding,
            shape: Shape::Thin,
            bvh: None,
        };
        let first = self.ground.positions().len() as u32;
        let before = self.ground.mark();
        let Some(mut shell) = OffsetShell::new(&base, first) else {
            return false;
        };
        let placed = shell.place(&mut self.ground);
        self.ground.restore(before);
        placed.is_err_and(|obstacles| !obstacles.is_empty())
    }

    /// A shell of the whole component that closes some holes, and its mean edge length; none if there is none. It forms walls or
    /// else, if `or_thin`, lies just below the surface.
    fn shell(&mut self, holes: &[&Hole], or_thin: bool) -> Option<(f64, FoundShell)> {
        let rims = edges_of(holes.iter().map(|h| &h.rim[..]));
        let mut region = Region::new(holes);
        let faces = self.found.topology.component_faces[region.component as usize];
        if faces > SHELL_WHOLE.get().min(self.budget.whole) {
            return None;
        }
        region.grow(self.found, &self.around, usize::MAX, SHELL_WHOLE.get());
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
        if !or_thin {
            // The component will be searched again, so refund its faces.
            self.budget.whole += faces;
            return None;
        }
        let known = self
            .known_blocked
            .remove(&region.component)
            .filter(|_| holes.len() == 1);
        let base = match known {
            Some(obstacles) => Err(obstacles),
            None => self.shell_under(&region.faces, &rims, Shape::Thin, &mut left),
        };
        if let Err(obstacles) = &base
            && !obstacles.is_empty()
        {
            self.block(holes, obstacles, true);
        }
        Some((edge, base.ok()?))
    }

    /// Whether a region is its whole component.
    fn is_all(&self, region: &Region) -> bool {
        let all = self
            .found
            .topology
            .component_faces
            .get(region.component as usize);
        all == Some(&region.faces.len())
    }

    /// Records the faces that block a shell.
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

    /// The shell of some faces with caps that close its other loops. On failure returns the faces that block it; an empty list if
    /// the cause is another.
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
        // Longest loop first: it is the least likely to be closed.
        shell.loops.sort_by_key(|ring| Reverse(ring.len()));
        let longest = shell.loops.first().map_or(0, Vec::len);
        if longest > SHELL_EDGES.get() {
            return Err(Vec::new());
        }
        shell.place(ground)?;
        let walls = shell.walls(&base);
        for ring in &shell.loops {
            let work = ring.len() * ring.len() / SHELL_EDGES_WORK.get();
            let cap = (work <= *left).then(|| ground.close(ring)).flatten();
            *left = left.saturating_sub(work);
            match cap {
                Some(cap) => shell.faces.extend(cap),
                None => {
                    ground.restore(before);
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
