//! Reach of a region: the faces that its computation needs, and no others.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{DVec3, IVec3, UVec3};
use rayon::prelude::*;

use super::Inspection;
use super::sources::{PATCH_MARGIN, grown_box};
use crate::fill::{BasePlane, PlacedPart, RIM_REACH};
use crate::mesh::topology::NONE;
use crate::mesh::{Hole, Mesh, bounds};
use crate::region::VoxelSize;
use crate::sdf::faces_at;
use crate::spatial::{Bounds, BoxTree};
use crate::threads::CollectIndexed;

/// Cells along each axis of the box in which a region samples distances. For each cell an upper bound of the distance to the
/// known surface is computed.
const CELLS: usize = 16;
/// Relative error by which rounding may increase a distance.
const ROUNDING: f64 = 1e-9;

/// A region whose reachable faces are searched.
pub(super) struct ReachQuery<'a> {
    pub(super) holes: Vec<&'a Hole>,
    /// For each component of the mesh whether the region knows it; none where it knows all.
    pub(super) known: Option<Vec<bool>>,
    /// Pairs of vertices between which the caller wants sharp edges.
    pub(super) joined: &'a [[u32; 2]],
    /// The plane of its flat base, if it gets one.
    pub(super) base: Option<BasePlane>,
    /// The parts of the counterpart at its holes, if there is a counterpart.
    pub(super) counterparts: Option<Vec<PlacedPart>>,
    /// Upper bound of the factor of its box's margin.
    pub(super) growth: f64,
    /// Upper bound of the cost of its level-set retries, in unknowns times steps.
    pub(super) budget: u64,
}

/// For each region the faces that its computation may read. `degenerate` are the mesh's degenerate faces.
pub(super) fn faces_of(
    found: &Inspection,
    degenerate: &[u32],
    regions: &[ReachQuery],
    voxel: VoxelSize,
) -> Vec<Vec<u32>> {
    let at = |boxes: &[Bounds]| -> Vec<Arc<[u32]>> {
        faces_at(&found.mesh, &found.topology, boxes, usize::MAX).unwrap_or_default()
    };
    let boxes = |region: &ReachQuery| {
        let sampled = sampled(found, region, voxel);
        [sampled, patched(found, region, &sampled)]
    };
    let boxes: Vec<[Bounds; 2]> = regions.iter().map(boxes).collect();
    let patched: Vec<Bounds> = boxes.iter().map(|b| b[1]).collect();
    let reaches: Vec<Reach> = regions
        .par_iter()
        .zip(boxes.par_iter().zip(&at(&patched)))
        .map(|(region, (boxes, faces))| Reach::new(found, region, *boxes, faces))
        .collect_indexed();
    let outer: Vec<Bounds> = reaches.iter().map(|r| r.whole).collect();
    let of = |(reach, faces): (&Reach, &Arc<[u32]>)| {
        let all: Vec<u32> = faces.iter().chain(degenerate).copied().collect();
        reach.held(&found.mesh, &all)
    };
    reaches
        .par_iter()
        .zip(&at(&outer))
        .map(of)
        .collect_indexed()
}

/// The box in which a region samples distances.
fn sampled(found: &Inspection, region: &ReachQuery, voxel: VoxelSize) -> Bounds {
    let kinds = [VoxelSize::Auto, voxel].map(|voxel| [(voxel, false), (voxel, true)]);
    let grown = kinds.concat().into_iter().map(|(voxel, is_coarse)| {
        let holes = &region.holes;
        grown_box(&found.mesh, holes, voxel, is_coarse, region.growth)
    });
    let all = grown.reduce(|all, b| all.join(&b));
    all.unwrap_or(Bounds::of_ball(DVec3::ZERO, 0.0))
}

/// The box that holds its patch and the faces that the patch must not intersect.
fn patched(found: &Inspection, region: &ReachQuery, sampled: &Bounds) -> Bounds {
    let rims = region.holes.iter().flat_map(|h| &h.rim);
    let (low, high) = bounds(rims.map(|&v| found.mesh.positions[v as usize]));
    let rims = Bounds { low, high }.widened(RIM_REACH.get() * low.distance(high));
    let size = (sampled.high - sampled.low).max_element();
    rims.join(&sampled.widened(PATCH_MARGIN * size))
}

/// The space that a region reads: a box, and balls around the centres of the cells of the box in which it samples.
struct Reach {
    patched: Bounds,
    balls: Vec<(DVec3, f64)>,
    /// The tree over the boxes of the balls.
    tree: BoxTree,
    /// The bounding box of all of these.
    whole: Bounds,
    /// The size of the cells.
    size: DVec3,
}

impl Reach {
    /// The reach of a region, from the faces that meet the box of its patch.
    ///
    /// The nearest surface point to any point of a cell is no farther from the cell's centre than the nearest known vertex plus a
    /// cell diagonal.
    fn new(
        found: &Inspection,
        region: &ReachQuery,
        [sampled, patched]: [Bounds; 2],
        faces: &[u32],
    ) -> Self {
        let vertices = spread(&sampled, &known_vertices(found, region, faces));
        let diagonal = (sampled.high - sampled.low).length() / CELLS as f64;
        let ball = |middle: DVec3| {
            let squares = vertices.iter().map(|v| middle.distance_squared(*v));
            let nearest = squares.fold(f64::INFINITY, f64::min).sqrt();
            (middle, (nearest + diagonal) * (1.0 + ROUNDING))
        };
        let around = |(middle, radius): &(DVec3, f64)| Bounds::of_ball(*middle, *radius);
        let mut balls: Vec<(DVec3, f64)> = middles(&sampled).map(ball).collect();
        balls.retain(|ball| ball.1.is_finite() && !patched.contains(&around(ball)));
        let boxes: Vec<Bounds> = balls.iter().map(around).collect();
        Self {
            tree: BoxTree::new(&boxes),
            whole: boxes.iter().fold(patched, |all, b| all.join(b)),
            balls,
            patched,
            size: (sampled.high - sampled.low) / CELLS as f64,
        }
    }

    /// The faces, of the given ones, within reach, and some more: faces whose centres are in one cell are tested together.
    fn held(&self, mesh: &Mesh, faces: &[u32]) -> Vec<u32> {
        let cell = |f: u32| {
            let Bounds { low, high } = Bounds::of(mesh.corners(f));
            (0.5 * (low + high) / self.size).floor().as_ivec3()
        };
        let mut boxes: HashMap<IVec3, Bounds> = HashMap::new();
        for &f in faces {
            let bounds = Bounds::of(mesh.corners(f));
            let all = boxes.entry(cell(f)).or_insert(bounds);
            *all = all.join(&bounds);
        }
        let held = boxes.iter().filter(|(_, bounds)| self.holds(bounds));
        let held: HashSet<IVec3> = held.map(|(cell, _)| *cell).collect();
        let is_held = |f: &u32| held.contains(&cell(*f));
        faces.iter().copied().filter(is_held).collect()
    }

    fn holds(&self, bounds: &Bounds) -> bool {
        let meets = |at: u32| {
            let (middle, radius) = self.balls[at as usize];
            bounds.gap(&Bounds::of_ball(middle, 0.0)) <= radius
        };
        self.patched.meets(bounds) || self.tree.find(bounds, meets).is_some()
    }
}

/// Vertices that a region knows: its rims' vertices and the vertices of known faces.
fn known_vertices(found: &Inspection, region: &ReachQuery, faces: &[u32]) -> Vec<DVec3> {
    let is_known = |f: &&u32| match (found.topology.component[**f as usize], &region.known) {
        (NONE, _) => false,
        (component, known) => known.as_ref().is_none_or(|known| known[component as usize]),
    };
    let corners = faces.iter().filter(is_known);
    let corners = corners.flat_map(|&f| found.mesh.faces[f as usize]);
    let rims = region.holes.iter().flat_map(|h| h.rim.iter().copied());
    rims.chain(corners)
        .map(|v| found.mesh.positions[v as usize])
        .collect()
}

/// Thins points out to one per cell of a box, with cells half as large as those for samples. Points outside count for the nearest
/// cell at the side.
fn spread(sampled: &Bounds, points: &[DVec3]) -> Vec<DVec3> {
    let cells = 2 * CELLS;
    let size = (sampled.high - sampled.low) / cells as f64;
    let mut is_taken = vec![false; cells.pow(3)];
    let is_first = |p: &&DVec3| {
        let at = ((**p - sampled.low) / size).max(DVec3::ZERO).as_uvec3();
        let [x, y, z] = at.min(UVec3::splat(cells as u32 - 1)).to_array();
        let cell = x as usize + cells * (y as usize + cells * z as usize);
        !std::mem::replace(&mut is_taken[cell], true)
    };
    points.iter().filter(is_first).copied().collect()
}

/// The centres of the cells of a box.
fn middles(sampled: &Bounds) -> impl Iterator<Item = DVec3> {
    let size = (sampled.high - sampled.low) / CELLS as f64;
    let low = sampled.low;
    (0..CELLS.pow(3)).map(move |cell| {
        let at = [cell % CELLS, cell / CELLS % CELLS, cell / CELLS.pow(2)];
        low + size * (DVec3::from(at.map(|i| i as f64)) + 0.5)
    })
}
