//! How far a region looks: the faces that the work on it needs, and no others.

use std::sync::Arc;

use glam::{DVec3, UVec3};

use super::Inspection;
use super::sources::{PATCH_MARGIN, grown_box};
use crate::fill::RIM_REACH;
use crate::mesh::topology::NONE;
use crate::mesh::{Hole, bounds};
use crate::region::VoxelSize;
use crate::sdf::faces_at;
use crate::spatial::{Bounds, BoxTree};

/// The box of a region is divided into so many cells along each axis to bound how far its samples look.
const CELLS: usize = 16;
/// What roundings may add to a distance, in parts of it.
const ROUNDING: f64 = 1e-9;

/// A region for which faces are looked for.
pub(super) struct Looking<'a> {
    pub(super) holes: Vec<&'a Hole>,
    /// For each piece of the mesh whether the region knows it; none where it knows all.
    pub(super) known: Option<Vec<bool>>,
    /// What its box has grown by, at most.
    pub(super) growth: f64,
}

/// For each of some regions the faces that it may look at.
pub(super) fn faces_of(found: &Inspection, regions: &[Looking], voxel: VoxelSize) -> Vec<Vec<u32>> {
    let at = |boxes: &[Bounds]| -> Vec<Arc<[u32]>> {
        faces_at(&found.mesh, &found.topology, boxes, usize::MAX).unwrap_or_default()
    };
    let inner: Vec<Bounds> = regions.iter().map(|r| inner(found, r, voxel)).collect();
    let reaches: Vec<Reach> = regions
        .iter()
        .zip(inner.iter().zip(&at(&inner)))
        .map(|(region, (inner, faces))| Reach::new(found, region, *inner, faces))
        .collect();
    let outer: Vec<Bounds> = reaches.iter().map(|r| r.whole).collect();
    let degenerate: Vec<u32> = (0..found.mesh.faces.len() as u32)
        .filter(|&f| found.topology.piece[f as usize] == NONE)
        .collect();
    let of = |(reach, faces): (&Reach, &Arc<[u32]>)| {
        let holds = |f: &&u32| reach.holds(&Bounds::of(found.mesh.corners(**f)));
        let all = faces.iter().chain(&degenerate);
        all.filter(holds).copied().collect()
    };
    reaches.iter().zip(&at(&outer)).map(of).collect()
}

/// The box in which a region samples and its patch lies, with what the patch must not cross.
fn inner(found: &Inspection, region: &Looking, voxel: VoxelSize) -> Bounds {
    let rims = region.holes.iter().flat_map(|h| &h.rim);
    let (low, high) = bounds(rims.map(|&v| found.mesh.positions[v as usize]));
    let rims = Bounds { low, high }.widened(RIM_REACH * low.distance(high));
    let kinds = [VoxelSize::Auto, voxel].map(|voxel| [(voxel, false), (voxel, true)]);
    let grown = kinds.concat().into_iter().map(|(voxel, is_coarse)| {
        let holes = &region.holes;
        let [low, high] = grown_box(&found.mesh, holes, voxel, is_coarse, region.growth);
        Bounds { low, high }.widened(PATCH_MARGIN * (high - low).max_element())
    });
    grown.fold(rims, |all, b| all.join(&b))
}

/// The boxes that hold what a region looks at.
struct Reach {
    boxes: Vec<Bounds>,
    tree: BoxTree,
    /// The box round all of them.
    whole: Bounds,
}

impl Reach {
    /// That of a region which samples in a box; the faces that meet the box are given.
    ///
    /// For a point of a cell there is a known vertex in another cell, no farther than the middles of the two are apart and a diagonal,
    /// and what is nearest to the point is no farther.
    fn new(found: &Inspection, region: &Looking, inner: Bounds, faces: &[u32]) -> Self {
        let size = (inner.high - inner.low) / CELLS as f64;
        let is_known = |f: &&u32| match (found.topology.piece[**f as usize], &region.known) {
            (NONE, _) => false,
            (piece, known) => known.as_ref().is_none_or(|known| known[piece as usize]),
        };
        let known = faces.iter().filter(is_known);
        let corners = known.flat_map(|&f| found.mesh.corners(f));
        let rims = region.holes.iter().flat_map(|h| &h.rim);
        let rims = rims.map(|&v| found.mesh.positions[v as usize]);
        let mut holds_vertex = vec![false; CELLS.pow(3)];
        for p in corners
            .chain(rims)
            .filter(|p| inner.contains(&Bounds::of_ball(*p, 0.0)))
        {
            let at = ((p - inner.low) / size).as_uvec3();
            let [x, y, z] = at.min(UVec3::splat(CELLS as u32 - 1)).to_array();
            holds_vertex[x as usize + CELLS * (y as usize + CELLS * z as usize)] = true;
        }
        let middle = |cell: usize| {
            let at = [cell % CELLS, cell / CELLS % CELLS, cell / CELLS.pow(2)];
            inner.low + size * (DVec3::from(at.map(|i| i as f64)) + 0.5)
        };
        let cells = 0..CELLS.pow(3);
        let vertices: Vec<DVec3> = cells
            .clone()
            .filter(|&c| holds_vertex[c])
            .map(middle)
            .collect();
        let mut boxes = vec![inner];
        for from in cells.map(middle) {
            let squares = vertices.iter().map(|to| from.distance_squared(*to));
            let nearest = squares.fold(f64::INFINITY, f64::min).sqrt();
            let reach = (nearest + 1.5 * size.length()) * (1.0 + ROUNDING);
            let around = Bounds::of_ball(from, reach);
            if reach.is_finite() && !inner.contains(&around) {
                boxes.push(around);
            }
        }
        let whole = boxes.iter().fold(inner, |all, b| all.join(b));
        Self {
            tree: BoxTree::new(&boxes),
            boxes,
            whole,
        }
    }

    fn holds(&self, face: &Bounds) -> bool {
        self.tree.find(&self.boxes, face, |_| true).is_some()
    }
}
