//! Reach of a region: the faces that its computation needs, and no others.

use std::sync::Arc;

use glam::{DVec3, IVec3, UVec3};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

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
    let boxes = regions.iter().map(|region| boxes(found, region, voxel));
    let boxes: Vec<[Bounds; 2]> = boxes.collect();
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

/// The same for one region, from the faces that meet a box; none where the box may not hold all of them.
pub(super) fn faces_among(
    found: &Inspection,
    degenerate: &[u32],
    region: &ReachQuery,
    voxel: VoxelSize,
    (within, near): (&Bounds, &[u32]),
) -> Option<Vec<u32>> {
    let meeting = |part: &Bounds| -> Option<Vec<u32>> {
        let meets = |f: &u32| Bounds::of(found.mesh.corners(*f)).meets(part);
        within
            .contains(part)
            .then(|| near.iter().copied().filter(meets).collect())
    };
    let boxes = boxes(found, region, voxel);
    let reach = Reach::new(found, region, boxes, &meeting(&boxes[1])?);
    let mut all = meeting(&reach.whole)?;
    all.extend(degenerate);
    Some(reach.held(&found.mesh, &all))
}

/// The box in which a region samples distances, and the box of its patch.
fn boxes(found: &Inspection, region: &ReachQuery, voxel: VoxelSize) -> [Bounds; 2] {
    let sampled = sampled(found, region, voxel);
    [sampled, patched(found, region, &sampled)]
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
        let vertices = known_vertices(found, region, faces);
        let diagonal = (sampled.high - sampled.low).length() / CELLS as f64;
        let ball = |(middle, near): (DVec3, f64)| (middle, (near + diagonal) * (1.0 + ROUNDING));
        let around = |(middle, radius): &(DVec3, f64)| Bounds::of_ball(*middle, *radius);
        let distances = distances(&sampled, &vertices);
        let mut balls: Vec<(DVec3, f64)> = middles(&sampled).zip(distances).map(ball).collect();
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
        let mut boxes: FxHashMap<IVec3, Bounds> = FxHashMap::default();
        for &f in faces {
            let bounds = Bounds::of(mesh.corners(f));
            let all = boxes.entry(cell(f)).or_insert(bounds);
            *all = all.join(&bounds);
        }
        let held = boxes.iter().filter(|(_, bounds)| self.holds(bounds));
        let held: FxHashSet<IVec3> = held.map(|(cell, _)| *cell).collect();
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

/// For the centre of each cell of a box the distance of one of the points, nearly always the nearest; infinite without points. Each cell
/// takes over the points of its neighbours that are nearer than its own, in sweeps from each corner of the box (P.-E. Danielsson,
/// "Euclidean distance mapping", Computer Graphics and Image Processing 14, 1980).
fn distances(sampled: &Bounds, points: &[DVec3]) -> Vec<f64> {
    let size = (sampled.high - sampled.low) / CELLS as f64;
    let middles: Vec<DVec3> = middles(sampled).collect();
    let mut nearest = vec![(f64::INFINITY, DVec3::ZERO); middles.len()];
    let take = |nearest: &mut [(f64, DVec3)], cell: usize, p: DVec3| {
        let squared = middles[cell].distance_squared(p);
        if squared < nearest[cell].0 {
            nearest[cell] = (squared, p);
        }
    };
    // A point outside the box counts for the nearest cell at its side.
    for &p in points {
        let at = ((p - sampled.low) / size).max(DVec3::ZERO).as_uvec3();
        let at = at.min(UVec3::splat(CELLS as u32 - 1)).to_array();
        take(&mut nearest, cell(at.map(|i| i as usize)), p);
    }
    for corner in 0..8 {
        let is_reversed = [0, 1, 2].map(|d| corner >> d & 1 == 1);
        for step in 0..middles.len() {
            let forward = indices(step);
            let at = |d: usize, i: usize| if is_reversed[d] { CELLS - 1 - i } else { i };
            let here = cell([0, 1, 2].map(|d| at(d, forward[d])));
            for d in (0..3).filter(|&d| forward[d] > 0) {
                let mut before = forward;
                before[d] -= 1;
                let (squared, p) = nearest[cell([0, 1, 2].map(|d| at(d, before[d])))];
                if squared.is_finite() {
                    take(&mut nearest, here, p);
                }
            }
        }
    }
    nearest.iter().map(|(squared, _)| squared.sqrt()).collect()
}

/// The number of a cell.
fn cell([x, y, z]: [usize; 3]) -> usize {
    x + CELLS * (y + CELLS * z)
}

/// The places of a cell along the axes.
fn indices(cell: usize) -> [usize; 3] {
    [cell % CELLS, cell / CELLS % CELLS, cell / CELLS.pow(2)]
}

/// The centres of the cells of a box.
fn middles(sampled: &Bounds) -> impl Iterator<Item = DVec3> {
    let size = (sampled.high - sampled.low) / CELLS as f64;
    let low = sampled.low;
    (0..CELLS.pow(3))
        .map(move |cell| low + size * (DVec3::from(indices(cell).map(|i| i as f64)) + 0.5))
}

#[cfg(test)]
mod tests {
    use super::super::sources::search_boxes;
    use super::*;
    use crate::fill::widest_growth;
    use crate::mesh::shapes::icosphere;

    #[test]
    fn faces_are_the_same_from_all_and_from_those_near() {
        let mut mesh = icosphere(5);
        mesh.positions.iter_mut().for_each(|p| p.z *= 3.0);
        let is_kept = |f: &[u32; 3]| f.iter().all(|&v| mesh.positions[v as usize].z < 2.9);
        mesh.faces = mesh.faces.iter().copied().filter(is_kept).collect();
        let found = Inspection::new(&mesh).unwrap();
        let query = ReachQuery {
            holes: found.holes.iter().collect(),
            known: None,
            joined: &[],
            base: None,
            counterparts: None,
            growth: widest_growth(),
            budget: 0,
        };
        let voxel = VoxelSize::Auto;
        let within = search_boxes(&mesh, &query.holes, voxel)[2];
        let near = faces_at(&mesh, &found.topology, &[within], usize::MAX).unwrap();
        let all = faces_of(&found, &[], std::slice::from_ref(&query), voxel).concat();
        assert!(all.len() < near[0].len() && near[0].len() < mesh.faces.len());
        let among = faces_among(&found, &[], &query, voxel, (&within, &near[0]));
        assert_eq!(among, Some(all));
        // A box that does not hold all of them.
        let small = search_boxes(&mesh, &query.holes, voxel)[0].widened(-0.2);
        let among = faces_among(&found, &[], &query, voxel, (&small, &near[0]));
        assert_eq!(among, None);
    }

    #[test]
    fn cells_take_over_the_nearest_points() {
        let (low, high) = (DVec3::new(-1.0, 0.0, 2.0), DVec3::new(1.0, 3.0, 3.0));
        let sampled = Bounds { low, high };
        for count in [1, 2, 5, 40, 400] {
            // Spread over a box of twice the size.
            let spread = |i: usize, step: f64| (i as f64 * step).fract() * 2.0 - 0.5;
            let point = |i: usize| {
                let at = DVec3::new(
                    spread(i, 0.754_877),
                    spread(i, 0.569_840),
                    spread(i, 0.430_159),
                );
                low + at * (high - low)
            };
            let points: Vec<DVec3> = (0..count).map(point).collect();
            let mut worst: f64 = 0.0;
            for (middle, found) in middles(&sampled).zip(distances(&sampled, &points)) {
                let each = points.iter().map(|p| middle.distance(*p));
                let nearest = each.fold(f64::INFINITY, f64::min);
                assert!(found >= nearest * (1.0 - 1e-12));
                worst = worst.max(found - nearest);
            }
            assert!(worst < 0.1, "{count} points: {worst}");
        }
        assert!(distances(&sampled, &[]).iter().all(|d| d.is_infinite()));
    }
}
