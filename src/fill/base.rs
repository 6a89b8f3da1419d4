//! Candidate: a flat base under an open sheet such as a terrain, with straight walls down from its border.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::candidate::FinishedPatch;
use super::faired;
use super::finish_step::Local;
use super::outcome::{ClosedBy, FailedReason, HoleOutcome};
use super::problem::RegionProblem;
use super::report::RegionReport;
use super::so_far::Made;
use crate::mesh::Hole;
use crate::mesh::triangulate::constrained_delaunay;
use crate::stitch::Patch;

/// A vertex of the border nearer to the plane than this, in parts of the border's diameter, is a corner of the base itself.
const ON_PLANE: f64 = 1e-9;

/// The plane of a base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct BasePlane {
    /// The unit vector to which walls are parallel: along an axis, from the sheet to the base.
    down: DVec3,
    /// Component along it of the plane's points.
    level: f64,
}

impl BasePlane {
    /// The plane under the outer border of a sheet with these vertices: perpendicular to the axis that is nearest to the normal of the border,
    /// `offset` below the lowest vertex; without an offset by the mean edge of the border, so that the lowest place has a thickness.
    pub(crate) fn new(
        hole: &Hole,
        vertices: impl Iterator<Item = DVec3>,
        offset: Option<f64>,
    ) -> Self {
        let normal = hole.normal.to_array();
        let largest = (0..3).max_by(|&i, &j| normal[i].abs().total_cmp(&normal[j].abs()));
        let axis = largest.unwrap_or(2);
        let mut down = DVec3::ZERO;
        down[axis] = normal[axis].signum();
        let lowest = vertices
            .map(|p| p.dot(down))
            .fold(f64::NEG_INFINITY, f64::max);
        let offset = offset.unwrap_or(hole.length / hole.edges.max(1) as f64);
        Self {
            down,
            level: lowest + offset,
        }
    }

    /// The point of the plane below a point.
    fn below(&self, p: DVec3) -> DVec3 {
        // Exactly in the plane, with the other coordinates bit for bit.
        DVec3::select(
            self.down.abs().cmpgt(DVec3::ZERO),
            self.level * self.down,
            p,
        )
    }

    /// Coordinates within the plane, seen such that a base that faces down turns to the left.
    fn flat(&self, p: DVec3) -> DVec2 {
        let x = self.down.any_orthonormal_vector();
        DVec2::new(p.dot(x), p.dot(self.down.cross(x)))
    }
}

/// Why the border of a sheet cannot stand on a flat base.
#[derive(Clone, Copy, Debug, Error)]
enum NoBase {
    /// Not one border alone.
    #[error("only a single outer border can stand on a flat base")]
    NotOneBorder,
    /// Seen from above the border crosses itself.
    #[error(
        "the border overhangs: seen along the walls it crosses itself, so that no flat base fits under it"
    )]
    Overhang,
    /// Number of faces of walls and base that intersect others.
    #[error(
        "walls and a flat base would intersect the surface (faces that would: {0}); either the surface overhangs its border, or the base is to lie \
         lower (`base_offset`)"
    )]
    Intersects(usize),
}

/// Expected cost: that of a faired triangulation, which is more.
pub(super) fn cost(problem: &RegionProblem<'_>) -> f64 {
    faired::cost(problem)
}

/// The walls and the base of the only rim; where there can be none, the rim stays open, with the reason.
pub(super) fn make(problem: &RegionProblem<'_>) -> Made {
    let report = RegionReport {
        diameter: problem.diameter(),
        ..RegionReport::default()
    };
    Made::Region(match problem.on_base() {
        Ok(patch) => {
            let report = RegionReport {
                closed_by: Some(ClosedBy::Base),
                ..report
            };
            let mut closed =
                problem.all_finished(FinishedPatch::unfinished(patch), report, HoleOutcome::Base);
            // It stands below its border, as was asked.
            closed.report.rise = None;
            closed
        }
        Err(why) => {
            let report = RegionReport {
                closed_by: Some(ClosedBy::Nothing),
                ..report
            };
            let outcome = HoleOutcome::Failed(FailedReason::NoBase(why.to_string()));
            problem.all(crate::mesh::Mesh::default(), report, outcome)
        }
    })
}

impl RegionProblem<'_> {
    fn on_base(&self) -> Result<Patch, NoBase> {
        let ([hole], Some(plane)) = (self.holes, self.base) else {
            return Err(NoBase::NotOneBorder);
        };
        let (positions, faces) = self.walls_and_base(hole, &plane)?;
        let patch = Patch {
            positions,
            faces,
            ..Patch::default()
        };
        let points = hole.rim.iter().map(|&v| self.mesh.positions[v as usize]);
        let points = points.chain(patch.positions.iter().copied());
        let (low, high) = points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
        let part = self.all.part(low, high, hole.rim.iter().copied());
        let local = Local::new(part, self.mesh.positions.len(), &patch, self.cancel);
        match local.crossing(&patch.positions) {
            0 => {}
            faces => return Err(NoBase::Intersects(faces)),
        }
        let mut patch = patch;
        patch.report.components = 1;
        let whole = |f: &[u32; 3]| f.map(|v| local.part.original(v, local.count));
        patch.measure(self.mesh, local.part.mesh.faces.iter().map(whole));
        Ok(patch)
    }

    /// Positions of the base's corners and faces of walls and base; new vertices are numbered behind those of the mesh.
    fn walls_and_base(
        &self,
        hole: &Hole,
        plane: &BasePlane,
    ) -> Result<(Vec<DVec3>, Vec<[u32; 3]>), NoBase> {
        let first = self.mesh.positions.len();
        let at = |v: u32| self.mesh.positions[v as usize];
        let mut positions = Vec::new();
        // The corner of the base below each vertex of the rim.
        let mut corners = Vec::with_capacity(hole.rim.len());
        for &v in &hole.rim {
            let below = plane.below(at(v));
            if below.distance(at(v)) <= ON_PLANE * hole.diameter {
                corners.push(v);
            } else {
                corners.push((first + positions.len()) as u32);
                positions.push(below);
            }
        }
        let outline: Vec<DVec2> = hole
            .rim
            .iter()
            .map(|&v| plane.flat(plane.below(at(v))))
            .collect();
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
