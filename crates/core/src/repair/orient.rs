//! Orientation: faces agree within each component, and closed components show their outside.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::balance::{open_sets, runs_up};
use super::draft::Draft;
use super::{inner_sheets, union};
use crate::check::{Component, components};
use crate::elementary::powf;
use crate::mend::{FillError, Inspection};
use crate::mesh::DisjointSets;
use crate::mesh::topology::{NONE, end, start};
use crate::spatial::{Bvh, WindingTree};
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Square roots of the component's area. An open component with shorter boundary loops counts as closed if it encloses
/// `LEAST_VOLUME`.
const SHORT_BORDER: Tunable<f64> = tunable("repair.short_border", 1.0);

/// Area to the power 3/2. Least volume of such a component: 0.094 for a sphere.
const LEAST_VOLUME: Tunable<f64> = tunable("repair.least_volume", 0.02);

/// Reorients the faces; returns the number of reversed faces that come from the input.
pub(super) fn orient(draft: &mut Draft) -> Result<usize, FillError> {
    let turned = {
        let found = draft.inspect()?;
        let inside_out = inside_out(&found);
        let topology = &found.topology;
        // The inspection's `turned` makes faces agree; an inside-out component is reversed in addition.
        let turn = |f: usize| match topology.component[f] {
            NONE => false,
            component => topology.turned[f] != inside_out[component as usize],
        };
        let turned: Vec<bool> = (0..draft.mesh.faces.len()).map(turn).collect();
        turned
    };
    let reversed = || (0..turned.len()).filter(|f| turned[*f]);
    reversed().for_each(|f| draft.reverse_face(f));
    let is_of_input = |f: &usize| draft.origins.faces[*f].face != NONE;
    Ok(reversed().filter(is_of_input).count())
}

/// For each component whether it is inside out after its faces were made to agree.
fn inside_out(found: &Inspection) -> Vec<bool> {
    let mut agreeing = found.topology.turned.clone();
    agreeing.fill(false);
    let topology = crate::mesh::Topology {
        opposite: found.topology.opposite.clone(),
        component: found.topology.component.clone(),
        component_faces: found.topology.component_faces.clone(),
        turned: agreeing,
        boundary: found.topology.boundary.clone(),
        defects: found.topology.defects,
    };
    let components = components(&found.mesh, &topology, 0.0);
    let mut border = vec![0.0; components.len()];
    for hole in &found.holes {
        // An outer border means an open sheet.
        let length = if hole.outer_boundary {
            f64::INFINITY
        } else {
            hole.length
        };
        border[hole.component as usize] += length;
    }
    let (mesh, topology) = (&found.mesh, &found.topology);
    let crowded = topology.non_manifold_edges(mesh);
    for &h in crowded.iter().flatten() {
        let at = |v: u32| mesh.positions[v as usize];
        border[topology.component[h as usize / 3] as usize] +=
            at(start(mesh, h)).distance(at(end(mesh, h)));
    }
    let has_inside = |(c, border): (&Component, &f64)| {
        c.closed || (*border < SHORT_BORDER.get() * c.area.sqrt() && encloses(c))
    };
    let has_inside: Vec<bool> = components.iter().zip(&border).map(has_inside).collect();
    let shows_inside = |(c, has_inside): (&Component, &bool)| {
        *has_inside && c.volume < 0.0 && c.depth.is_multiple_of(2)
    };
    let mut wrong: Vec<bool> = components
        .iter()
        .zip(&has_inside)
        .map(shows_inside)
        .collect();
    // The cavities of a body that is inside out as a whole are inside out too.
    let outermost = |mut i: usize| {
        while let Some(outer) = components[i].inside {
            i = outer;
        }
        i
    };
    let turned_with_body: Vec<usize> = (0..components.len())
        .filter(|&i| {
            let c = &components[i];
            has_inside[i] && !c.depth.is_multiple_of(2) && c.volume > 0.0 && wrong[outermost(i)]
        })
        .collect();
    turned_with_body.into_iter().for_each(|i| wrong[i] = true);
    let groups = groups(found, &crowded);
    let is_cavity = cavities(found, &groups);
    for (group, is_cavity) in groups.into_iter().zip(is_cavity) {
        for c in group.components {
            wrong[c as usize] = group.volume < 0.0 && !is_cavity;
        }
    }
    wrong
}

/// Whether a component encloses enough volume for its area to be a body with holes rather than a sheet.
fn encloses(c: &Component) -> bool {
    c.volume.abs() > LEAST_VOLUME.get() * powf(c.area, 1.5)
}

/// For each group of negative volume whether the other faces enclose it, by their winding numbers behind most of its faces.
fn cavities(found: &Inspection, groups: &[Group]) -> Vec<bool> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    if groups.iter().all(|g| g.volume >= 0.0) {
        return vec![false; groups.len()];
    }
    let bvh = Bvh::new(mesh, topology.faces());
    let tree = WindingTree::new(&bvh);
    let is_cavity = |group: &Group| {
        if group.volume >= 0.0 {
            return false;
        }
        let is_own = |f: &u32| group.components.contains(&topology.component[*f as usize]);
        let own: Vec<u32> = topology.faces().filter(is_own).collect();
        let behind = inner_sheets::sampled(&own).map(|f| {
            let [_, p] = inner_sheets::sides(mesh, *f);
            tree.winding_number(&bvh, p) - inner_sheets::winding(mesh, &own, p)
        });
        let (inside, all) = behind.fold((0, 0), |(inside, all), w| {
            (inside + usize::from(w > 0.5), all + 1)
        });
        2 * inside > all
    };
    groups.par_iter().map(is_cavity).collect_indexed()
}

/// Components that are closed together: along each edge as many of their faces run one way as the other.
struct Group {
    components: Vec<u32>,
    /// With the sign of its orientation.
    volume: f64,
}

/// The bodies of which the mesh consists where components share edges: components joined where a body lies between two of their
/// faces, as far as they are closed; else all that share edges, if these are closed together.
fn groups(found: &Inspection, crowded: &[Vec<u32>]) -> Vec<Group> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    if crowded.is_empty() {
        return Vec::new();
    }
    let count = topology.component_faces.len();
    let component = |h: u32| topology.component[h as usize / 3];
    let mut joined = DisjointSets::new(count);
    for edge in crowded {
        edge.iter()
            .for_each(|h| _ = joined.join(component(edge[0]), component(*h)));
    }
    let mut bodies = union::paired_components(mesh, topology);
    let mut groups = Vec::new();
    let mut done = vec![false; count];
    for sets in [&mut bodies, &mut joined] {
        let is_open = open_sets(topology, crowded, |c| sets.find(c), |h| runs_up(mesh, h));
        let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let crowd: BTreeSet<u32> = crowded.iter().flatten().map(|h| component(*h)).collect();
        for c in crowd {
            members.entry(sets.find(c)).or_default().push(c);
        }
        for (set, own) in members {
            if !is_open[set as usize] && !own.iter().any(|c| done[*c as usize]) {
                own.iter().for_each(|c| done[*c as usize] = true);
                groups.push(own);
            }
        }
    }
    let mut volume = vec![0.0; count];
    let centre = mesh.positions.first().copied().unwrap_or_default();
    for f in topology.faces() {
        let [a, b, c] = mesh.corners(f).map(|p| p - centre);
        volume[topology.component[f as usize] as usize] += a.dot(b.cross(c)) / 6.0;
    }
    let sum = |own: &Vec<u32>| own.iter().map(|c| volume[*c as usize]).sum();
    (groups.into_iter())
        .map(|components| Group {
            volume: sum(&components),
            components,
        })
        .collect()
}
