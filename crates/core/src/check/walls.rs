//! Wall thickness of closed components, measured by inward rays.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::thin::{FACING, centroid, given_normal};
use super::{Component, Defect, DefectKind, Subject, Verdict};
use crate::mesh::topology::NONE;
use crate::mesh::{Mesh, Topology, area_vector, length, point, welded};
use crate::spatial::Bvh;
use crate::threads::{CollectFiltered, CollectIndexed};
use crate::tuning::{Tunable, tunable};

/// Cosine. The two sides of a wall count as parallel within this angle (15°). Beyond it they form a wedge, whose
/// thickness at any point is less than four times the distance from its edge.
const PARALLEL: Tunable<f64> = tunable("check.parallel", 0.966);

/// Squares of the thickness. The least wall thickness of a component is one at which at least this area is no thicker:
/// about a disk whose radius is a third of the thickness, so that single slivers do not count as walls. A hemisphere with
/// a flat cap has 0.4.
const WALL_PATCH: Tunable<f64> = tunable("check.wall_patch", 0.25);

/// Faces. Number of faces at which wall thickness is measured, shared among components by face count. On 1.1 million
/// faces the mean of 20,000 agreed with the mean over all faces to a thousandth, but the thinnest place may be missed.
const WALL_SAMPLES: Tunable<usize> = tunable("check.wall_samples", 100_000);

/// Faces. Least number of samples in each component that has as many faces.
const WALL_SAMPLES_LEAST: Tunable<usize> = tunable("check.wall_samples_least", 64);

/// Maximum number of components named in a verdict.
const MAX_NAMED: usize = 3;

/// Measures wall thickness: the length of the inward ray from a face, against its normal, to the point where it leaves the body.
#[doc(hidden)]
pub struct Walls<'a> {
    mesh: &'a Mesh,
    topology: &'a Topology,
    bvh: Bvh,
}

/// The wall at a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wall {
    /// Thickness, in mesh units.
    pub(crate) thickness: f64,
    /// Whether the two sides are nearly parallel. Otherwise the place is a wedge, whose thickness goes to 0 towards the edge
    /// however thick the body is.
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

    /// The wall at the centre of a face, as [`wall_at`] measures it. If `inside_out`, the face normals point inward.
    pub(crate) fn at(&self, f: u32, inside_out: bool) -> Option<Wall> {
        wall_at((self.mesh, self.topology, &self.bvh), f, inside_out)
    }
}

/// The wall at the centre of a face; none if the ray does not leave the body, or leaves it through a face whose normal is
/// more than 60 degrees from the ray. If `inside_out`, the face normals point inward.
fn wall_at(
    (mesh, topology, bvh): (&Mesh, &Topology, &Bvh),
    f: u32,
    inside_out: bool,
) -> Option<Wall> {
    let normal = |f: u32| match inside_out {
        true => -given_normal(mesh, topology, f),
        false => given_normal(mesh, topology, f),
    };
    let inward = -normal(f);
    if inward == DVec3::ZERO {
        return None;
    }
    let leaves = |g: u32| g != f && normal(g).dot(inward) > 0.0;
    let (g, thickness) = bvh.first_along(centroid(mesh, f), inward, leaves)?;
    let cosine = normal(g).dot(inward);
    (cosine > FACING.get()).then_some(Wall {
        thickness,
        is_parallel: cosine > PARALLEL.get(),
    })
}

/// Measures walls part by part, for maps of a whole mesh: connectivity and hierarchy are made once.
#[doc(hidden)]
pub struct WallMap {
    mesh: Mesh,
    topology: Topology,
    bvh: Bvh,
}

impl WallMap {
    /// Prepares a mesh. Vertices at exactly the same position count as one.
    pub fn new(mesh: &Mesh) -> Self {
        let (mut mesh, _) = welded(mesh);
        let topology = Topology::new(&mut mesh);
        Self {
            bvh: Bvh::new(&mesh, topology.faces()),
            mesh,
            topology,
        }
    }

    /// The thickness at each of the faces, in mesh units: negative at a wedge, whose sides are not parallel within 15 degrees,
    /// so that it is no wall; NaN where the ray does not leave the body.
    ///
    /// # Panics
    /// If a face does not exist.
    pub fn thickness(&self, faces: Range<u32>) -> Vec<f32> {
        let own = (&self.mesh, &self.topology, &self.bvh);
        let signed = |f: u32| match wall_at(own, f, false) {
            Some(wall) if wall.is_parallel => wall.thickness as f32,
            Some(wall) => -wall.thickness as f32,
            None => f32::NAN,
        };
        faces.into_par_iter().map(signed).collect_indexed()
    }
}

/// A measured wall and the surface area that it represents.
struct Sample {
    face: u32,
    component: u32,
    area: f64,
    wall: Wall,
}

/// Measures the walls of closed components: at all faces if there is a `limit`, else at a sample of each component. Writes the
/// results into the components and returns the faces of walls that are thinner than the limit.
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
        // Mean thickness over all parallel samples of the component; they are sorted by thickness.
        let mut parallel = own.iter().filter(|s| s.wall.is_parallel);
        for s in parallel.clone() {
            area += s.area;
            volume += s.area * s.wall.thickness;
        }
        // A single sliver is not a wall: the thinnest patch is the thinnest samples with at least `wall_patch` times the square
        // of the thickness as their area.
        let mean = volume / area;
        let (mut area, mut volume) = (0.0, 0.0);
        let first = parallel.clone().next();
        let least = parallel.find(|s| {
            area += s.area;
            volume += s.area * s.wall.thickness;
            area >= WALL_PATCH.get() * s.wall.thickness.powi(2)
        });
        component.least_wall = least.map(|_| volume / area);
        component.mean_wall = least.map(|_| mean);
        component.thinnest_at = least.and(first).map(|s| centroid(mesh, s.face));
    }
    // With a limit, list the faces of walls below it.
    let limit = limit?;
    let is_thin = |s: &&Sample| {
        let least = components[s.component as usize].least_wall;
        s.wall.is_parallel && s.wall.thickness < limit && least.is_some_and(|l| l < limit)
    };
    let faces: Vec<u32> = samples.iter().filter(is_thin).map(|s| s.face).collect();
    Some(Defect::new(DefectKind::ThinWall, faces.len(), faces, mesh))
}

/// The number of faces of closed components.
fn closed_faces(components: &[Component]) -> usize {
    let closed = components.iter().filter(|c| c.closed);
    closed.map(|c| c.faces).sum()
}

/// Samples the walls of closed components, at all faces or at every n-th face.
fn samples(subject: &Subject, components: &[Component], all: bool) -> Vec<Sample> {
    let Subject { mesh, topology, .. } = *subject;
    let total = closed_faces(components);
    if total == 0 {
        return Vec::new();
    }
    // The sampling step of a component: 1 for all faces.
    let step = |c: &Component| {
        let share = WALL_SAMPLES.get() * c.faces / total;
        match all {
            true => 1,
            false => c.faces.div_ceil(share.max(WALL_SAMPLES_LEAST.get())),
        }
    };
    let steps: Vec<usize> = components.iter().map(step).collect();
    let mut seen = vec![0; components.len()];
    let is_asked = |f: &u32| {
        let index = topology.component[*f as usize];
        if index == NONE || !components[index as usize].closed {
            return false;
        }
        seen[index as usize] += 1;
        usize::is_multiple_of(seen[index as usize] - 1, steps[index as usize])
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
    asked.into_par_iter().filter_map(sample).collect_filtered()
}

impl Verdict {
    /// Whether the walls were measured at a part of the faces only, since there are many and no least thickness was asked for: a thinner
    /// place may have been missed.
    pub fn samples_walls(&self) -> bool {
        self.params.min_wall.is_none() && closed_faces(&self.components) > WALL_SAMPLES.get()
    }

    /// The thinnest wall of all components: the number of its component from 1, the component, and the area-weighted mean wall
    /// thickness of all components. None if no component has a wall.
    pub fn walls(&self) -> Option<(usize, &Component, f64)> {
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

    /// The message that names the components with too thin walls, how thin they are and where.
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
            n if n > MAX_NAMED => format!("; {} more components", n - MAX_NAMED),
            _ => String::new(),
        };
        let named: Vec<String> = thin.iter().take(MAX_NAMED).map(one).collect();
        let (which, advice) = match self.foils.is_empty() {
            true => ("walls", ""),
            false => (
                "walls that the repair made",
                "; put the sheet on a flat base, or ask for thicker walls",
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
