//! An offset shell: a reversed copy of a part of a surface, a little below it and attached to its rims.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use glam::DVec3;

use super::clear::{Ground, intersecting_or_flat};
use super::rounding::Rounding;
use super::shell_vertex::{Shape, ShellBase, ShellVertex, below, under};
use super::{Edge, edges};
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{DisjointSets, Mesh, Part, area_vector, face_normal};
use crate::spatial::intersecting;
use crate::tuning::{Tunable, tunable};

/// Factor of the depth where the shell intersects anything.
const SHELL_NEARER: Tunable<f64> = tunable("repair.shell_nearer", 0.25);

/// Times that a shell is moved closer to the surface, at most.
const SHELL_ROUNDS: Tunable<usize> = tunable("repair.shell_rounds", 5);

/// Factor of the depth of a wall where it intersects anything, in the first `WALL_STEPS` rounds.
const WALL_NEARER: Tunable<f64> = tunable("repair.wall_nearer", 0.7);

/// Rounds with `WALL_NEARER`; later rounds use the factor of a shell, since only a few places remain.
const WALL_STEPS: Tunable<usize> = tunable("repair.wall_steps", 10);

/// Times that a wall is made thinner, at most.
const WALL_ROUNDS: Tunable<usize> = tunable("repair.wall_rounds", 24);

/// An offset shell of some faces of a mesh.
pub(super) struct OffsetShell {
    /// New vertices.
    vertices: Vec<ShellVertex>,
    /// Faces of the shell. Vertex numbers below `first` are mesh vertices, the others are new.
    pub(super) faces: Vec<[u32; 3]>,
    /// The mesh face above each shell face.
    under: Vec<u32>,
    /// The number of faces below the surface, which come first; the others are side walls at the rims.
    under_surface: usize,
    /// The boundary loops of the shell other than the rims, in the direction of the faces that would close them.
    pub(super) loops: Vec<Vec<u32>>,
    /// Number of the first new vertex.
    first: u32,
    shape: Shape,
    rounding: Rounding,
}

/// The wall between a shell face and the surface above it.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallFace {
    /// Area of the shell face.
    pub(super) area: f64,
    /// Mean depth along the surface normal, in mesh units; 0 where the shell lies outside, as beside a sharp fold.
    pub(super) thickness: f64,
    /// Its centre.
    pub(super) at: DVec3,
}

/// The shell vertex of each corner of the covered faces; corners that share a vertex of the shell have the same one.
struct Corners {
    /// Index of each covered face.
    place: HashMap<u32, u32>,
    /// Shell vertex of each corner, by 3 × index + corner.
    vertex: Vec<u32>,
}

impl OffsetShell {
    /// Builds the shell; none if the faces have boundary edges other than the rims, or are not consistently oriented.
    pub(super) fn new(base: &ShellBase, first: u32) -> Option<Self> {
        let mut shell = Self {
            vertices: Vec::new(),
            faces: Vec::new(),
            under: Vec::new(),
            under_surface: 0,
            shape: base.shape,
            loops: Vec::new(),
            first,
            rounding: base.rounding,
        };
        let corners = shell.corners(base)?;
        let mut middles: HashMap<Edge, u32> = HashMap::new();
        for (&f, i) in base.faces.iter().zip(0..) {
            shell.face(base, &corners, f, i, &mut middles);
        }
        shell.under_surface = shell.faces.len();
        if base.shape.has_sides() {
            shell.sides(base, &corners);
        }
        shell.loops = loops(base, &corners, &middles, first)?;
        Some(shell)
    }

    /// Assigns shell vertices to the corners: rim vertices are shared with the surface unless there are side walls; the others
    /// get a copy below.
    fn corners(&mut self, base: &ShellBase) -> Option<Corners> {
        let (mesh, topology) = (&base.found.mesh, &base.found.topology);
        let place: HashMap<u32, u32> = base.faces.iter().copied().zip(0..).collect();
        // Join corners across inner edges of the covered region; corners at rims are marked.
        let mut sets = DisjointSets::new(3 * base.faces.len());
        let mut on_rim = vec![false; 3 * base.faces.len()];
        for (&f, i) in base.faces.iter().zip(0..) {
            for k in 0..3 {
                let own = [3 * i + k, 3 * i + (k + 1) % 3];
                let (a, b) = ends(mesh, 3 * f + k);
                let opposite = topology.opposite[(3 * f + k) as usize];
                if opposite == NONE {
                    let is_rim = topology.boundary[(3 * f + k) as usize]
                        && base.rims.contains(&(a.min(b), a.max(b)));
                    if !is_rim {
                        return None;
                    }
                    own.iter().for_each(|c| on_rim[*c as usize] = true);
                } else if ends(mesh, opposite) != (b, a) {
                    return None;
                } else if let Some(j) = place.get(&(opposite / 3)) {
                    let k = opposite % 3;
                    sets.join(own[0], 3 * j + (k + 1) % 3);
                    sets.join(own[1], 3 * j + k);
                }
            }
        }
        // Rim corners keep the mesh vertex.
        let mut stays = HashSet::new();
        let stay = |c: &u32| on_rim[*c as usize] && !base.shape.has_sides();
        for c in (0..on_rim.len() as u32).filter(stay) {
            stays.insert(sets.find(c));
        }
        // Every other set of corners gets one new vertex.
        let mut of_set: HashMap<u32, u32> = HashMap::new();
        let mut vertex = Vec::with_capacity(on_rim.len());
        for c in 0..on_rim.len() as u32 {
            let face = base.faces[c as usize / 3];
            let v = mesh.faces[face as usize][c as usize % 3];
            let set = sets.find(c);
            let own = match (stays.contains(&set), of_set.get(&set)) {
                (true, _) => v,
                (_, Some(copy)) => *copy,
                _ => {
                    let copy = self.add(below(base, v));
                    of_set.insert(set, copy);
                    copy
                }
            };
            vertex.push(own);
        }
        Some(Corners { place, vertex })
    }

    /// Adds the side walls: two faces between each rim edge and its copy.
    fn sides(&mut self, base: &ShellBase, corners: &Corners) {
        for (&f, i) in base.faces.iter().zip(0..) {
            for k in 0..3 {
                if base.found.topology.opposite[(3 * f + k) as usize] != NONE {
                    continue;
                }
                let (a, b) = ends(&base.found.mesh, 3 * f + k);
                let [c, d] = [k, (k + 1) % 3].map(|k| corners.vertex[(3 * i + k) as usize]);
                self.faces.extend([[b, a, c], [b, c, d]]);
                self.under.extend([f, f]);
            }
        }
    }

    /// The walls of the placed shell, one for each face below the surface.
    pub(super) fn walls(&self, base: &ShellBase) -> Vec<WallFace> {
        let mesh = &base.found.mesh;
        let wall = |(face, under): (&[u32; 3], &u32)| {
            let normal = face_normal(mesh, *under);
            let below = |v: u32| self.vertices.get(v.checked_sub(self.first)? as usize);
            let depth = |v: &u32| below(*v).map_or(0.0, |b| -b.depth * b.direction.dot(normal));
            let at = face.map(|v| match below(v) {
                Some(b) => b.from + b.depth * b.direction,
                None => mesh.positions[v as usize],
            });
            WallFace {
                area: 0.5 * area_vector(at).length(),
                thickness: (face.iter().map(depth).sum::<f64>() / 3.0).max(0.0),
                at: at.iter().sum::<DVec3>() / 3.0,
            }
        };
        let own = self.faces[..self.under_surface].iter();
        own.zip(&self.under).map(wall).collect()
    }

    fn add(&mut self, vertex: ShellVertex) -> u32 {
        self.vertices.push(vertex);
        self.first + self.vertices.len() as u32 - 1
    }

    /// Adds the shell faces below one face. Two kinds get an extra vertex in the middle, because two shells would share an edge
    /// or coincide there: inner edges with both ends on rims, and faces with no new vertex.
    fn face(
        &mut self,
        base: &ShellBase,
        corners: &Corners,
        f: u32,
        place: u32,
        middles: &mut HashMap<Edge, u32>,
    ) {
        let mesh = &base.found.mesh;
        let v = [0, 1, 2].map(|k| corners.vertex[(3 * place + k) as usize]);
        let middle = [0u32, 1, 2].map(|k| {
            let (a, b) = (v[k as usize], v[(k as usize + 1) % 3]);
            let opposite = base.found.topology.opposite[(3 * f + k) as usize];
            if opposite == NONE || a >= self.first || b >= self.first {
                return None;
            }
            let edge = (a.min(b), a.max(b));
            Some(*middles.entry(edge).or_insert_with(|| {
                let from = 0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize]);
                self.vertices
                    .push(under(base, from, &[f, opposite / 3], [a, b]));
                self.first + self.vertices.len() as u32 - 1
            }))
        });
        let count = middle.iter().flatten().count();
        let all_old = v.iter().all(|v| *v < self.first);
        let mut new: Vec<[u32; 3]> = match count {
            0 if all_old => {
                let centre = mesh.corners(f).iter().sum::<DVec3>() / 3.0;
                let m = self.add(under(base, centre, &[f], [v[0], v[1]]));
                vec![[v[0], v[1], m], [v[1], v[2], m], [v[2], v[0], m]]
            }
            _ => divided(v, middle),
        };
        new.iter_mut().for_each(|f| f.swap(1, 2));
        self.under.resize(self.under.len() + new.len(), f);
        self.faces.extend(new);
    }

    /// Reduces the depth of the shell where it intersects anything, until it is clear, and adds it to the ground. If that fails,
    /// returns the surface faces above the faces that still intersect.
    pub(super) fn place(&mut self, ground: &mut Ground) -> Result<(), Vec<u32>> {
        let surface: Vec<[u32; 3]> = self.under.iter().map(|f| ground.face(*f)).collect();
        let depth = self.vertices.iter().map(|v| v.depth).fold(0.0, f64::max);
        let mut local = LocalShell::new(self, ground, &ground.near_all(&surface, depth));
        if self.shape.depth().is_some() {
            self.try_least_depth(&mut local)?;
        }
        let mut asked: Vec<usize> = (0..self.faces.len()).collect();
        for round in 0.. {
            local.place(&self.vertices, self.rounding, |v| v.depth);
            let wrong = local.wrong(asked);
            if wrong.is_empty() {
                break;
            }
            let moved = self.reduce_depth(&wrong, round);
            if round == self.rounds() || moved.is_empty() {
                return Err(self.above(wrong.into_iter()));
            }
            // Faces that were clear need a new test only if one of their vertices moved.
            let touches = |f: &usize| self.faces[*f].iter().any(|v| moved.contains(v));
            asked = (0..self.faces.len())
                .filter(|f| wrong.contains(&(*f as u32)) || touches(f))
                .collect();
        }
        ground.add_vertices(local.new_positions());
        self.faces.iter().for_each(|f| ground.add(*f));
        Ok(())
    }

    /// Fails where the shell intersects anything even at its least depth, where it would end after twenty rounds.
    fn try_least_depth(&self, local: &mut LocalShell) -> Result<(), Vec<u32>> {
        local.place(&self.vertices, self.rounding, |v| v.min_depth);
        let all: Vec<[u32; 3]> = local.own.iter().chain(&local.near).copied().collect();
        let pairs = intersecting(&local.positions, &all, local.own.len());
        match pairs.is_empty() {
            true => Ok(()),
            false => Err(self.above(pairs.iter().map(|(f, _)| *f))),
        }
    }

    /// The surface faces above some faces, ascending.
    fn above(&self, faces: impl Iterator<Item = u32>) -> Vec<u32> {
        let above: BTreeSet<u32> = faces.map(|f| self.under[f as usize]).collect();
        above.into_iter().collect()
    }

    /// Maximum number of depth reductions.
    fn rounds(&self) -> usize {
        match self.shape {
            Shape::Thin => SHELL_ROUNDS.get(),
            _ => WALL_ROUNDS.get(),
        }
    }

    /// Reduces the depth of the new vertices of some faces; returns the vertices that moved.
    fn reduce_depth(&mut self, faces: &HashSet<u32>, round: usize) -> HashSet<u32> {
        let corners = faces.iter().flat_map(|f| self.faces[*f as usize]);
        let new: HashSet<u32> = corners.filter(|v| *v >= self.first).collect();
        let factor = match self.shape {
            Shape::Walled(_) | Shape::Hanging(_) if round < WALL_STEPS.get() => WALL_NEARER.get(),
            _ => SHELL_NEARER.get(),
        };
        let mut moved = HashSet::new();
        for v in new {
            let vertex = &mut self.vertices[(v - self.first) as usize];
            let depth = (factor * vertex.depth).max(vertex.min_depth);
            if depth < vertex.depth {
                moved.insert(v);
            }
            vertex.depth = depth;
        }
        moved
    }
}

/// A shell and the faces near it, with local vertex numbers: first the vertices of the mesh, then the new vertices of the shell.
struct LocalShell {
    positions: Vec<DVec3>,
    /// The faces of the shell.
    own: Vec<[u32; 3]>,
    near: Vec<[u32; 3]>,
    /// Number of the first new vertex of the shell.
    first: usize,
}

impl LocalShell {
    fn new(shell: &OffsetShell, ground: &Ground, near: &[[u32; 3]]) -> Self {
        let corners = shell.faces.iter().flatten().copied();
        let old = corners.filter(|v| *v < shell.first);
        let part = Part::of_faces(ground.positions(), near, old);
        let local = |f: &[u32; 3]| f.map(|v| part.local_or_new(v, shell.first as usize));
        Self {
            own: shell.faces.iter().map(local).collect(),
            first: part.mesh.positions.len(),
            positions: part.mesh.positions,
            near: part.mesh.faces,
        }
    }

    /// Positions the new vertices at some depths.
    fn place(
        &mut self,
        vertices: &[ShellVertex],
        rounding: Rounding,
        depth: impl Fn(&ShellVertex) -> f64,
    ) {
        self.positions.truncate(self.first);
        let at = vertices.iter();
        self.positions
            .extend(at.map(|v| rounding.moved(v.from, depth(v) * v.direction)));
    }

    fn new_positions(&self) -> &[DVec3] {
        &self.positions[self.first..]
    }

    /// The shell faces among the `asked` ones that intersect anything or have no area, and the shell faces that they intersect.
    fn wrong(&self, asked: Vec<usize>) -> HashSet<u32> {
        let mut is_asked = vec![false; self.own.len()];
        asked.iter().for_each(|f| is_asked[*f] = true);
        let count = asked.len();
        let mut order = asked;
        order.extend((0..self.own.len()).filter(|f| !is_asked[*f]));
        let own: Vec<[u32; 3]> = order.iter().map(|f| self.own[*f]).collect();
        let wrong = intersecting_or_flat(&self.positions, &own, count, &self.near);
        let both = wrong.into_iter().flat_map(|(f, g)| [f, g.unwrap_or(f)]);
        both.map(|i| order[i as usize] as u32).collect()
    }
}

/// Subdivides a triangle at the given midpoints; midpoint k is on the edge after corner k.
fn divided(v: [u32; 3], middle: [Option<u32>; 3]) -> Vec<[u32; 3]> {
    // Rotate so that the first edge has a midpoint and, if there are two, the second edge as well.
    let first = (0..3).find(|&k| middle[k].is_some() && middle[(k + 2) % 3].is_none());
    let turn = |k: usize| (first.unwrap_or(0) + k) % 3;
    let [a, b, c] = [v[turn(0)], v[turn(1)], v[turn(2)]];
    match [middle[turn(0)], middle[turn(1)], middle[turn(2)]] {
        [None, ..] => vec![v],
        [Some(m), None, _] => vec![[a, m, c], [m, b, c]],
        [Some(m), Some(n), None] => vec![[m, b, n], [a, m, n], [a, n, c]],
        [Some(m), Some(n), Some(o)] => vec![[a, m, o], [m, b, n], [n, c, o], [m, n, o]],
    }
}

fn ends(mesh: &Mesh, half_edge: u32) -> (u32, u32) {
    (start(mesh, half_edge), end(mesh, half_edge))
}

/// The boundary loops of a shell other than the rims; none if two loops share a vertex.
fn loops(
    base: &ShellBase,
    corners: &Corners,
    middles: &HashMap<Edge, u32>,
    first: u32,
) -> Option<Vec<Vec<u32>>> {
    let topology = &base.found.topology;
    let mut parts: Vec<[u32; 2]> = Vec::new();
    for (&f, i) in base.faces.iter().zip(0..) {
        for k in 0..3 {
            let opposite = topology.opposite[(3 * f + k) as usize];
            if opposite == NONE || corners.place.contains_key(&(opposite / 3)) {
                continue;
            }
            let [a, b] = [k, (k + 1) % 3].map(|k| corners.vertex[(3 * i + k) as usize]);
            match middles.get(&(a.min(b), a.max(b))) {
                Some(m) if a < first && b < first => parts.extend([[a, *m], [*m, b]]),
                _ => parts.push([a, b]),
            }
        }
    }
    parts.sort_unstable();
    let mut next: BTreeMap<u32, u32> = BTreeMap::new();
    for [a, b] in parts {
        if next.insert(a, b).is_some() {
            return None;
        }
    }
    let mut loops = Vec::new();
    while let Some((start, mut at)) = next.pop_first() {
        let mut ring = vec![start];
        while at != start {
            ring.push(at);
            at = next.remove(&at)?;
        }
        loops.push(ring);
    }
    Some(loops)
}

/// The edges of the given rims.
pub(super) fn edges_of<'a>(rims: impl Iterator<Item = &'a [u32]>) -> HashSet<Edge> {
    rims.flat_map(|rim| edges(rim).collect::<Vec<_>>())
        .collect()
}
