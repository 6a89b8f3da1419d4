//! Wall thickness of closed components.

use glam::DVec3;
use rayon::prelude::*;

use super::thin::{FACING, centroid, given_normal};
use super::{Component, Defect, DefectKind, Subject, Verdict};
use crate::mesh::topology::NONE;
use crate::mesh::{Mesh, Topology, area_vector, length, point};
use crate::spatial::Bvh;
use crate::tuning::tuning;

/// Most components that a reason names.
const MOST_NAMED: usize = 3;

/// The thickness of the walls of a mesh: the length of rays inward, against the faces' normals, to where they leave the body.
pub(crate) struct Walls<'a> {
    mesh: &'a Mesh,
    topology: &'a Topology,
    bvh: Bvh,
}

/// The wall at a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wall {
    /// Its thickness in the mesh's units.
    pub(crate) thickness: f64,
    /// Whether its two sides are nearly parallel. Others are wedges: their thickness goes to 0 towards the edge, however thick the body is.
    pub(crate) is_parallel: bool,
}

impl<'a> Walls<'a> {
    pub(crate) fn new(mesh: &'a Mesh, topology: &'a Topology) -> Self {
        Self {
            bvh: Bvh::new(mesh, topology.faces()),
            mesh,
            topology,
        }
    }

    /// The wall at the centre of a face; none where the ray leaves the body nowhere, or through a face that does not face the other way
    /// within 60 degrees. Of a body that is `inside_out` the faces' normals point inward.
    pub(crate) fn at(&self, f: u32, inside_out: bool) -> Option<Wall> {
        let normal = |f: u32| match inside_out {
            true => -given_normal(self.mesh, self.topology, f),
            false => given_normal(self.mesh, self.topology, f),
        };
        let inward = -normal(f);
        if inward == DVec3::ZERO {
            return None;
        }
        let leaves = |g: u32| g != f && normal(g).dot(inward) > 0.0;
        let (g, thickness) = self
            .bvh
            .first_along(centroid(self.mesh, f), inward, leaves)?;
        let cosine = normal(g).dot(inward);
        (cosine > FACING).then_some(Wall {
            thickness,
            is_parallel: cosine > tuning().check.parallel,
        })
    }
}

/// The wall at a face, and the area of the surface that the face stands for.
struct Sample {
    face: u32,
    component: u32,
    area: f64,
    wall: Wall,
}

/// Measures the walls of closed components, at all faces where there is a `limit`, else at some of each component. Returns the faces at
/// walls that are thinner than the limit.
pub(super) fn measure(
    subject: &Subject,
    components: &mut [Component],
    limit: Option<f64>,
) -> Option<Defect> {
    let mesh = subject.mesh;
    let mut samples = samples(subject, components, limit.is_some());
    samples.sort_by(|a, b| {
        let thickness = a.wall.thickness.total_cmp(&b.wall.thickness);
        (a.component.cmp(&b.component).then(thickness)).then(a.face.cmp(&b.face))
    });
    for own in samples.chunk_by(|a, b| a.component == b.component) {
        let component = &mut components[own[0].component as usize];
        let (mut area, mut volume) = (0.0, 0.0);
        let mut parallel = own.iter().filter(|s| s.wall.is_parallel);
        for s in parallel.clone() {
            area += s.area;
            volume += s.area * s.wall.thickness;
        }
        // A single sliver is no wall: the thinnest patch is as large as part of the square of the thickness.
        let mean = volume / area;
        let (mut area, mut volume) = (0.0, 0.0);
        let first = parallel.clone().next();
        let least = parallel.find(|s| {
            area += s.area;
            volume += s.area * s.wall.thickness;
            area >= tuning().check.wall_patch * s.wall.thickness.powi(2)
        });
        component.least_wall = least.map(|_| volume / area);
        component.mean_wall = least.map(|_| mean);
        component.thinnest_at = least.and(first).map(|s| centroid(mesh, s.face));
    }
    let limit = limit?;
    let is_thin = |s: &&Sample| {
        let least = components[s.component as usize].least_wall;
        s.wall.is_parallel && s.wall.thickness < limit && least.is_some_and(|l| l < limit)
    };
    let faces: Vec<u32> = samples.iter().filter(is_thin).map(|s| s.face).collect();
    Some(Defect::new(DefectKind::ThinWall, faces.len(), faces, mesh))
}

/// The walls at all or some faces of closed components.
fn samples(subject: &Subject, components: &[Component], all: bool) -> Vec<Sample> {
    let Subject { mesh, topology, .. } = *subject;
    let total: usize = components
        .iter()
        .filter(|c| c.closed)
        .map(|c| c.faces)
        .sum();
    if total == 0 {
        return Vec::new();
    }
    // Every face, or each n-th of a component.
    let step = |c: &Component| {
        let share = tuning().check.wall_samples * c.faces / total;
        match all {
            true => 1,
            false => c
                .faces
                .div_ceil(share.max(tuning().check.wall_samples_least)),
        }
    };
    let steps: Vec<usize> = components.iter().map(step).collect();
    let mut seen = vec![0; components.len()];
    let is_asked = |f: &u32| {
        let piece = topology.component[*f as usize];
        if piece == NONE || !components[piece as usize].closed {
            return false;
        }
        seen[piece as usize] += 1;
        usize::is_multiple_of(seen[piece as usize] - 1, steps[piece as usize])
    };
    let asked: Vec<u32> = topology.faces().filter(is_asked).collect();
    let walls = Walls::new(mesh, topology);
    let sample = |f: u32| {
        let component = topology.component[f as usize];
        let own = 0.5 * area_vector(mesh.corners(f)).length();
        Some(Sample {
            face: f,
            component,
            area: own * steps[component as usize] as f64,
            wall: walls.at(f, false)?,
        })
    };
    asked.into_par_iter().filter_map(sample).collect()
}

impl Verdict {
    /// The least wall of all components with where it is and the number of its component from 1, and the mean over their areas; none
    /// where no component has a wall.
    pub(crate) fn walls(&self) -> Option<(usize, &Component, f64)> {
        let own = || self.components.iter().filter(|c| c.least_wall.is_some());
        let with = (1..).zip(&self.components);
        let with = with.filter(|(_, c)| c.least_wall.is_some());
        let (number, thinnest) = with.min_by(|(_, a), (_, b)| {
            let [a, b] = [a, b].map(|c| c.least_wall.unwrap_or(f64::INFINITY));
            a.total_cmp(&b)
        })?;
        let area: f64 = own().map(|c| c.area).sum();
        let sum: f64 = own().filter_map(|c| Some(c.area * c.mean_wall?)).sum();
        Some((number, thinnest, sum / area))
    }

    /// Which components have walls thinner than allowed, how thin and where.
    pub(super) fn thin_reason(&self) -> String {
        let limit = self.params.min_wall.unwrap_or_default();
        let is_thin = |(number, c): &(usize, &Component)| match &self.foils[..] {
            [] => c.least_wall.is_some_and(|l| l < limit),
            foils => foils.contains(number),
        };
        let thin = (1..).zip(&self.components).filter(is_thin);
        let mut thin: Vec<(usize, &Component)> = thin.collect();
        thin.sort_by(|a, b| b.1.area.total_cmp(&a.1.area).then(a.0.cmp(&b.0)));
        let one = |(number, c): &(usize, &Component)| {
            let at = c.thinnest_at.unwrap_or(c.centre);
            let least = length(c.least_wall.unwrap_or_default());
            format!("component {number}: {least} at {}", point(at, 0.0))
        };
        let more = match thin.len() {
            n if n > MOST_NAMED => format!("; {} more components", n - MOST_NAMED),
            _ => String::new(),
        };
        let named: Vec<String> = thin.iter().take(MOST_NAMED).map(one).collect();
        let (which, advice) = match self.foils.is_empty() {
            true => ("walls", ""),
            false => (
                "walls that the repair made",
                "; a flat base below the sheet or thicker walls would do",
            ),
        };
        format!(
            "{which} are thinner than {} ({}{more}{advice})",
            length(limit),
            named.join("; ")
        )
    }
}

#[cfg(test)]
mod tests;
