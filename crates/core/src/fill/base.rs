//! Candidate: a flat base under an open sheet such as a terrain, with straight walls down from its outer border.

use glam::{DVec2, DVec3};
use thiserror::Error;

use super::base_plane::BasePlane;
use super::candidate::FinishedPatch;
use super::closure::{Closure, HoleOutcome};
use super::faired;
use super::finish_step::Local;
use super::problem::RegionProblem;
use super::reasons::OpenReason;
use super::so_far::Made;
use crate::mesh::triangulate::constrained_delaunay;
use crate::mesh::{Hole, Mesh, bounds};
use crate::stitch::Patch;

/// Border diameters. A border vertex closer to the plane than this is itself a corner of the base.
const ON_PLANE: f64 = 1e-9;

/// Why a sheet cannot get a flat base.
#[derive(Clone, Copy, Debug, Error)]
enum NoBase {
    /// The region is not a single outer border.
    #[error("only a single outer border can stand on a flat base")]
    NotOneBorder,
    /// The projection of the border along the walls intersects itself.
    #[error(
        "the border overhangs: its projection along the walls intersects itself, so no flat base fits under it"
    )]
    Overhang,
    /// Number of wall and base faces that intersect the surface.
    #[error(
        "{0} faces of the walls and the flat base would intersect the surface: the surface overhangs its border, or the base \
         has to be lower (`base_offset`)"
    )]
    Intersects(usize),
}

/// Expected cost: as a faired triangulation, which is an upper bound.
pub(super) fn cost(problem: &RegionProblem<'_>) -> f64 {
    faired::cost(problem)
}

/// Builds the walls and the base under the only rim. If that is impossible the rim stays open, with the reason.
pub(super) fn make(problem: &RegionProblem<'_>) -> Made {
    let report = problem.flat_report();
    Made::Region(match problem.on_base() {
        Ok(patch) => {
            let mut closed =
                problem.all_finished(FinishedPatch::unfinished(patch), report, Closure::Base);
            // A base is meant to be far from its border: its rise is not reported.
            closed.report.rise = None;
            closed
        }
        Err(why) => {
            let outcome = HoleOutcome::Open(OpenReason::NoBase(why.to_string()));
            problem.all(Mesh::default(), report, outcome)
        }
    })
}

impl RegionProblem<'_> {
    fn on_base(&self) -> Result<Patch, NoBase> {
        let ([hole], Some(plane)) = (self.holes, self.base) else {
            return Err(NoBase::NotOneBorder);
        };
        let (positions, faces) = self.walls_and_base(hole, &plane)?;
        let mut patch = Patch {
            positions,
            faces,
            ..Patch::default()
        };
        let rim = hole.rim.iter().map(|&v| self.mesh.positions[v as usize]);
        let (low, high) = bounds(rim.chain(patch.positions.iter().copied()));
        let part = self.all.part(low, high, hole.rim.iter().copied());
        let local = Local::new(part, self.mesh.positions.len(), &patch, self.cancel);
        match local.count_intersecting(&patch.positions) {
            0 => {}
            faces => return Err(NoBase::Intersects(faces)),
        }
        patch.report.components = 1;
        let whole = |f: &[u32; 3]| f.map(|v| local.part.original(v, local.count));
        patch.measure(self.mesh, local.part.mesh.faces.iter().map(whole));
        Ok(patch)
    }

    /// Positions of the base's corners, and faces of walls and base. New vertices are numbered after the mesh's.
    fn walls_and_base(
        &self,
        hole: &Hole,
        plane: &BasePlane,
    ) -> Result<(Vec<DVec3>, Vec<[u32; 3]>), NoBase> {
        let first = self.mesh.positions.len();
        let at = |v: u32| self.mesh.positions[v as usize];
        let mut positions = Vec::new();
        // The base's corner below each vertex of the rim.
        let mut corners = Vec::with_capacity(hole.rim.len());
        let mut outline: Vec<DVec2> = Vec::with_capacity(hole.rim.len());
        for &v in &hole.rim {
            let below = plane.below(at(v));
            outline.push(plane.flat(below));
            if below.distance(at(v)) <= ON_PLANE * hole.diameter {
                corners.push(v);
            } else {
                corners.push((first + positions.len()) as u32);
                positions.push(below);
            }
        }
        // The outline's signed area must be positive, and the outline a simple polygon: otherwise the sheet overhangs.
        let next = |i: usize| (i + 1) % outline.len();
        let twice = (0..outline.len()).map(|i| outline[i].perp_dot(outline[next(i)]));
        if twice.sum::<f64>() <= 0.0 {
            return Err(NoBase::Overhang);
        }
        let base = constrained_delaunay(&outline, &[]).ok_or(NoBase::Overhang)?;
        if base.len() + 2 != outline.len() {
            return Err(NoBase::Overhang);
        }
        let mut faces: Vec<[u32; 3]> = base.iter().map(|f| f.map(|i| corners[i])).collect();
        // Walls: two triangles under each rim edge, fewer where the rim already meets the plane.
        for i in 0..corners.len() {
            let (a, b) = (hole.rim[i], hole.rim[next(i)]);
            let (below_a, below_b) = (corners[i], corners[next(i)]);
            if below_b != b {
                faces.push([a, b, below_b]);
            }
            if below_a != a {
                faces.push([a, below_b, below_a]);
            }
        }
        Ok((positions, faces))
    }
}
