//! Open sheets inside a solid, such as partitions that touch its walls: they enclose nothing, and are removed. Cavities with holes enclose
//! what is no matter, and stay.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::RepairReport;
use super::balance::{open_sets, runs_up};
use super::draft::Draft;
use super::intersection_cache::sorted;
use super::witness::{BEFORE, Solid, UNDECIDED};
use crate::mend::{FillError, Inspection};
use crate::mesh::topology::{LOOSE_FACES, NONE};
use crate::mesh::{Hole, Mesh, area_vector};
use crate::spatial::solid_angle;
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Faces of a component that are tested to decide whether it lies inside another.
const SAMPLES: Tunable<usize> = tunable("repair.samples", 64);

/// Faces. Open sheets inside a solid are looked for among components of at most this many: the work grows with its square.
const SHEET_FACES: Tunable<usize> = tunable("repair.sheet_faces", 2000);

/// Winding number of a component, with the sign changed, on the emptier side of its faces: a mean above this is a cavity with holes. A flat
/// sheet has one half, a sphere without a fifth of its area 0.85.
const HOLLOW: Tunable<f64> = tunable("repair.hollow", 0.75);

/// Removes the open components that lie inside the solid of all others: the winding number of the others is one in front of each of
/// their faces and behind it.
pub(super) fn drop(draft: &mut Draft, report: &mut RepairReport) -> Result<(), FillError> {
    let removed: Vec<bool> = {
        let found = draft.inspect()?;
        let topology = &found.topology;
        let faces = sheets(&found);
        if faces.iter().all(Vec::is_empty) {
            return Ok(());
        }
        let bounding = topology.faces();
        let bounding = bounding.filter(|f| !topology.is_loose(topology.component[*f as usize]));
        let solid = Solid::new(&draft.mesh, bounding, false);
        let is_inner = |own: &Vec<u32>| {
            let of_solid = if own.len() > LOOSE_FACES {
                &own[..]
            } else {
                &[]
            };
            let mut points = sampled(own).flat_map(|f| sides(&draft.mesh, *f));
            !own.is_empty()
                && points.all(|p| is_inside_without(&solid, &draft.mesh, of_solid, p))
                && !is_cavity(&draft.mesh, own)
        };
        let inner: Vec<bool> = faces.par_iter().map(is_inner).collect_indexed();
        for (own, _) in faces.iter().zip(&inner).filter(|(_, inner)| **inner) {
            report.steps.inside_components += 1;
            report.steps.inside_faces += own.len();
        }
        let component = topology.component.iter();
        component.map(|&p| p != NONE && inner[p as usize]).collect()
    };
    if removed.contains(&true) {
        draft.remove(&removed);
    }
    Ok(())
}

/// The outer borders that lie inside the solid of all other components, such as the borders of eyes in a head: the sheets can be
/// closed there without a change of the outside.
pub(super) fn inner_borders(draft: &Draft) -> Result<Vec<Vec<u32>>, FillError> {
    let found = draft.inspect()?;
    let topology = &found.topology;
    let is_small = |c: u32| topology.component_faces[c as usize] <= SHEET_FACES.get();
    let borders = found
        .holes
        .iter()
        .filter(|h| h.outer_boundary && is_small(h.component));
    let borders: Vec<_> = borders.collect();
    if borders.is_empty() || topology.component_faces.len() < 2 {
        return Ok(Vec::new());
    }
    let mut of_component: HashMap<u32, Vec<u32>> =
        borders.iter().map(|h| (h.component, Vec::new())).collect();
    for f in topology.faces() {
        if let Some(own) = of_component.get_mut(&topology.component[f as usize]) {
            own.push(f);
        }
    }
    let solid = Solid::new(&found.mesh, topology.faces(), false);
    let at = |v: u32| found.mesh.positions[v as usize];
    let is_inner = |hole: &&&Hole| {
        let own = &of_component[&hole.component];
        let next = hole.rim.iter().cycle().skip(1);
        hole.rim.iter().zip(next).all(|(v, w)| {
            // Beside the edge, where the winding number of the sheet itself jumps.
            let middle = 0.5 * (at(*v) + at(*w));
            let p = middle + BEFORE.get() * (hole.centre - middle);
            is_inside_without(&solid, &found.mesh, own, p)
        })
    };
    Ok(borders
        .iter()
        .filter(is_inner)
        .map(|h| h.rim.clone())
        .collect())
}

/// At most [`SAMPLES`] of some faces, evenly selected.
pub(super) fn sampled(own: &[u32]) -> impl Iterator<Item = &u32> {
    own.iter().step_by(own.len().div_ceil(SAMPLES.get()).max(1))
}

/// Whether a component inside a solid bounds a cavity, but for holes.
fn is_cavity(mesh: &Mesh, own: &[u32]) -> bool {
    let emptiness = |f: &u32| {
        let [front, back] = sides(mesh, *f).map(|p| -winding(mesh, own, p));
        front.max(back)
    };
    let sum: f64 = sampled(own).map(emptiness).sum();
    sum > HOLLOW.get() * sampled(own).count() as f64
}

/// Whether a point is inside a solid, also without some of its faces.
fn is_inside_without(solid: &Solid, mesh: &Mesh, own: &[u32], p: DVec3) -> bool {
    solid.winding(p) - winding(mesh, own, p) > 1.0 - UNDECIDED.get()
}

/// For each component its faces, if it may be a sheet inside a solid; else none.
fn sheets(found: &Inspection) -> Vec<Vec<u32>> {
    let topology = &found.topology;
    let count = topology.component_faces.len();
    // A component may be closed although others share its edges.
    let crowded = topology.non_manifold_edges(&found.mesh);
    let open = open_sets(topology, &crowded, |c| c, |h| runs_up(&found.mesh, h));
    let mut faces: Vec<Vec<u32>> = vec![Vec::new(); count];
    if count < 2 || !open.contains(&true) {
        return faces;
    }
    // Walls between bodies that touch are there twice; the union removes them.
    let key = |f: u32| sorted(found.mesh.faces[f as usize]);
    let mut times: HashMap<[u32; 3], u32> = HashMap::new();
    for f in topology.faces() {
        *times.entry(key(f)).or_insert(0) += 1;
        let component = topology.component[f as usize] as usize;
        let is_small = topology.component_faces[component] <= SHEET_FACES.get();
        if open[component] && is_small {
            faces[component].push(f);
        }
    }
    for own in &mut faces {
        if own.iter().any(|f| times[&key(*f)] > 1) {
            own.clear();
        }
    }
    // What is left at each edge must stay in pairs: the sides of bodies that touch inside others are no sheets.
    for edge in &crowded {
        let component = |h: &u32| topology.component[*h as usize / 3];
        for own in edge.iter().map(component) {
            let others = edge.iter().filter(|h| component(h) != own).count();
            if !others.is_multiple_of(2) {
                faces[own as usize].clear();
            }
        }
    }
    faces
}

/// A point in front of a face and one behind it.
pub(super) fn sides(mesh: &Mesh, face: u32) -> [DVec3; 2] {
    let corners = mesh.corners(face);
    let normal = area_vector(corners);
    let centre = corners.iter().sum::<DVec3>() / 3.0;
    let step = BEFORE.get() * (0.5 * normal.length()).sqrt();
    let step = step * normal.normalize_or_zero();
    [centre + step, centre - step]
}

/// The winding number of some faces at a point: their solid angles over 4π.
pub(super) fn winding(mesh: &Mesh, faces: &[u32], p: DVec3) -> f64 {
    let angle = |f: &u32| {
        let [a, b, c] = mesh.corners(*f).map(|corner| corner - p);
        solid_angle(a, b, c)
    };
    faces.iter().map(angle).sum::<f64>() / (4.0 * PI)
}
