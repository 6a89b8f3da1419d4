//! The connected components of a mesh: area, volume, and which component encloses which.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{DisjointSets, Mesh, Topology, area_vector};
use crate::spatial::{Bounds, BoxTree, Bvh, WindingTree, solid_angle};
use crate::threads::{CollectFiltered, CollectIndexed};
use crate::tuning::{Tunable, tunable};

/// Winding number of a component above which a point is inside it: 1 inside a closed one, less near its holes. All sampled points of
/// what lies inside a closed component are above it. Of what lies inside an open one, the mean is, or all are once its holes have lids.
const INSIDE: Tunable<f64> = tunable("check.components.inside", 0.75);
/// Winding number of an open component above which every sampled point of what lies inside it is.
const INSIDE_OPEN: Tunable<f64> = tunable("check.components.inside_open", 0.5);
/// Number of vertices of a component that are tested to decide whether it lies inside another.
const SAMPLES: Tunable<usize> = tunable("check.components.samples", 32);
/// Components with fewer faces enclose nothing: 4 faces make a tetrahedron.
const LEAST_FACES: Tunable<usize> = tunable("check.components.least_faces", 4);

/// A connected component of a mesh: faces connected across edges with exactly two faces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Component {
    /// Number of faces.
    pub faces: usize,
    /// Area, in mesh units squared.
    pub area: f64,
    /// Whether each of its edges has two faces.
    pub closed: bool,
    /// Enclosed volume, negative if the component is inside out. For an open component: the volume of the cone from the centre of
    /// its bounding box over its faces.
    pub volume: f64,
    /// Centre of its bounding box.
    pub centre: DVec3,
    /// Index of the smallest component that encloses it entirely.
    pub inside: Option<usize>,
    /// Number of components that enclose it entirely.
    pub depth: usize,
    /// Whether its area is below the `debris` fraction of the largest component's area.
    pub debris: bool,
    /// Mean thickness of its thinnest wall, in mesh units. A wall is a patch of the surface whose opposite side is parallel to it
    /// within 15 degrees. None if the component is open or has no wall, as a tetrahedron.
    #[serde(default)]
    pub least_wall: Option<f64>,
    /// Area-weighted mean thickness of its walls.
    #[serde(default)]
    pub mean_wall: Option<f64>,
    /// Position of its thinnest wall.
    #[serde(default)]
    pub thinnest_at: Option<DVec3>,
}

/// The components of a welded mesh, in the order of their numbers. A component counts as debris if its area is below `debris`
/// times the largest one.
pub(crate) fn components(mesh: &Mesh, topology: &Topology, debris: f64) -> Vec<Component> {
    let count = topology.component_faces.len();
    let mut faces: Vec<Vec<u32>> = vec![Vec::new(); count];
    for f in topology.faces() {
        faces[topology.component[f as usize] as usize].push(f);
    }
    let boxes: Vec<Bounds> = faces
        .par_iter()
        .map(|own| bounds(mesh, own))
        .collect_indexed();
    let mut open: Vec<Vec<u32>> = vec![Vec::new(); count];
    for h in (0..topology.opposite.len()).filter(|h| topology.opposite[*h] == NONE) {
        let component = topology.component[h / 3];
        if component != NONE {
            open[component as usize].push(h as u32);
        }
    }
    let mut found: Vec<Component> = (0..count)
        .into_par_iter()
        .map(|i| measured(mesh, topology, &faces[i], &boxes[i], open[i].is_empty()))
        .collect_indexed();
    let largest = found.iter().map(|c| c.area).fold(0.0, f64::max);
    for c in &mut found {
        c.debris = c.area < debris * largest;
    }
    nest(mesh, &faces, &open, &boxes, &mut found);
    found
}

/// Lids on the holes of a component: fans from the middle of each set of connected open edges.
struct Lids(Vec<[DVec3; 3]>);

impl Lids {
    fn new(mesh: &Mesh, open: &[u32]) -> Self {
        let edges: Vec<[u32; 2]> = open
            .iter()
            .map(|&h| [start(mesh, h), end(mesh, h)])
            .collect();
        let mut numbers = BTreeMap::new();
        for v in edges.iter().flatten() {
            let next = numbers.len() as u32;
            numbers.entry(*v).or_insert(next);
        }
        let mut sets = DisjointSets::new(numbers.len());
        for [a, b] in &edges {
            sets.join(numbers[a], numbers[b]);
        }
        let at = |v: u32| mesh.positions[v as usize];
        let set_of: Vec<u32> = edges.iter().map(|[a, _]| sets.find(numbers[a])).collect();
        let mut sums: BTreeMap<u32, (DVec3, f64)> = BTreeMap::new();
        for ([a, _], set) in edges.iter().zip(&set_of) {
            let (sum, count) = sums.entry(*set).or_default();
            (*sum, *count) = (*sum + at(*a), *count + 1.0);
        }
        let fan = |([a, b], set): (&[u32; 2], &u32)| {
            let (sum, count) = sums[set];
            [at(*b), at(*a), sum / count]
        };
        Self(edges.iter().zip(&set_of).map(fan).collect())
    }

    /// Their winding number at a point.
    fn winding(&self, p: DVec3) -> f64 {
        let angles = self
            .0
            .iter()
            .map(|t| solid_angle(t[0] - p, t[1] - p, t[2] - p));
        angles.sum::<f64>() / (4.0 * PI)
    }
}

fn bounds(mesh: &Mesh, faces: &[u32]) -> Bounds {
    let corners = faces.iter().flat_map(|&f| mesh.corners(f));
    let (low, high) = crate::mesh::bounds(corners);
    Bounds { low, high }
}

/// Area and volume of the given faces, with the orientation of the input mesh.
fn measured(
    mesh: &Mesh,
    topology: &Topology,
    faces: &[u32],
    around: &Bounds,
    closed: bool,
) -> Component {
    let centre = 0.5 * (around.low + around.high);
    let (mut area, mut volume) = (0.0, 0.0);
    for &f in faces {
        let [a, b, c] = mesh.corners(f).map(|p| p - centre);
        let side = if topology.turned[f as usize] {
            -1.0
        } else {
            1.0
        };
        area += 0.5 * area_vector([a, b, c]).length();
        volume += side * a.dot(b.cross(c)) / 6.0;
    }
    Component {
        faces: faces.len(),
        area,
        closed,
        volume,
        centre,
        inside: None,
        depth: 0,
        debris: false,
        least_wall: None,
        mean_wall: None,
        thinnest_at: None,
    }
}

/// A component that may hold others.
struct Shell<'a> {
    bvh: Bvh,
    tree: WindingTree,
    /// Its open half-edges.
    open: &'a [u32],
    lids: OnceCell<Lids>,
}

impl<'a> Shell<'a> {
    fn new(mesh: &Mesh, faces: &[u32], open: &'a [u32]) -> Self {
        let bvh = Bvh::new(mesh, faces.iter().copied());
        let tree = WindingTree::new(&bvh);
        Self {
            bvh,
            tree,
            open,
            lids: OnceCell::new(),
        }
    }

    /// Whether all sampled vertices of another component are inside it.
    fn holds(&self, mesh: &Mesh, inner: &[u32]) -> bool {
        let least = match self.open.is_empty() {
            true => INSIDE.get(),
            false => INSIDE_OPEN.get(),
        };
        let step = inner.len().div_ceil(SAMPLES.get());
        let mut samples: Vec<(DVec3, f64)> = Vec::new();
        for f in inner.iter().step_by(step) {
            let p = mesh.corners(*f)[0];
            let winding = self.tree.winding_number(&self.bvh, p);
            if winding.abs() <= least {
                return false;
            }
            samples.push((p, winding));
        }
        let sum: f64 = samples.iter().map(|(_, winding)| winding.abs()).sum();
        if sum > INSIDE.get() * samples.len() as f64 {
            return true;
        }
        let lids = self.lids.get_or_init(|| Lids::new(mesh, self.open));
        let is_under =
            |(p, winding): &(DVec3, f64)| (winding + lids.winding(*p)).abs() > INSIDE.get();
        samples.iter().all(is_under)
    }
}

/// Determines which components lie inside which others.
fn nest(
    mesh: &Mesh,
    faces: &[Vec<u32>],
    open: &[Vec<u32>],
    boxes: &[Bounds],
    found: &mut [Component],
) {
    let holds = |outer: &Bounds, inner: &Bounds| {
        outer.low.cmple(inner.low).all() && outer.high.cmpge(inner.high).all()
    };
    // Only components that can enclose others: with thousands of single faces in one place the box tests would be quadratic.
    let large = (0..boxes.len() as u32).filter(|i| faces[*i as usize].len() >= LEAST_FACES.get());
    let large: Vec<u32> = large.collect();
    let large_boxes: Vec<Bounds> = large.iter().map(|i| boxes[*i as usize]).collect();
    let tree = BoxTree::new(&large_boxes);
    // Pairs (outer, inner) where the outer box contains the inner box, sorted by the outer one.
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    for (inner, own) in boxes.iter().enumerate() {
        tree.for_each(own, |i| {
            let outer = large[i as usize];
            let o = outer as usize;
            if found[o].area > found[inner].area && holds(&boxes[o], own) {
                pairs.push((outer, inner as u32));
            }
        });
    }
    pairs.sort_unstable();
    let groups: Vec<&[(u32, u32)]> = pairs.chunk_by(|a, b| a.0 == b.0).collect();
    let inside: Vec<(u32, u32)> = groups
        .into_par_iter()
        .flat_map_iter(|group| {
            let outer = group[0].0 as usize;
            let shell = Shell::new(mesh, &faces[outer], &open[outer]);
            let inner = group.iter();
            let inner = inner.filter(|(_, inner)| shell.holds(mesh, &faces[*inner as usize]));
            inner.copied().collect::<Vec<_>>()
        })
        .collect_filtered();
    // Count the enclosing components and keep the smallest.
    for (outer, inner) in inside {
        let area = |i: usize| found[i].area;
        let (outer, inner) = (outer as usize, inner as usize);
        let nearer = found[inner].inside.is_none_or(|o| area(outer) < area(o));
        found[inner].depth += 1;
        if nearer {
            found[inner].inside = Some(outer);
        }
    }
}
