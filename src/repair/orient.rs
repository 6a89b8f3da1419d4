//! Orientation: faces agree within each component, and closed components show their outside.

use std::collections::BTreeMap;

use super::draft::Draft;
use crate::check::{Component, components};
use crate::elementary::powf;
use crate::mend::{FillError, Inspection};
use crate::mesh::DisjointSets;
use crate::mesh::topology::{NONE, end, start};
use crate::tuning::tuning;

/// Reorients the faces; returns the number of reversed ones.
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
    for f in (0..turned.len()).filter(|f| turned[*f]) {
        draft.reverse_face(f);
    }
    Ok(turned.iter().filter(|t| **t).count())
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
    let shows_inside = |(c, border): (&Component, &f64)| {
        let has_inside =
            c.closed || (*border < tuning().repair.short_border * c.area.sqrt() && encloses(c));
        has_inside && c.volume < 0.0 && c.depth.is_multiple_of(2)
    };
    let mut wrong: Vec<bool> = components.iter().zip(&border).map(shows_inside).collect();
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
            c.closed && !c.depth.is_multiple_of(2) && c.volume > 0.0 && wrong[outermost(i)]
        })
        .collect();
    turned_with_body.into_iter().for_each(|i| wrong[i] = true);
    for group in groups(found) {
        let is_outer = group
            .components
            .iter()
            .all(|c| components[*c as usize].depth.is_multiple_of(2));
        for c in group.components {
            wrong[c as usize] = is_outer && group.volume < 0.0;
        }
    }
    wrong
}

/// Components that share edges and are closed together: along each edge as many faces run one way as the other.
struct Group {
    components: Vec<u32>,
    /// With the sign of its orientation.
    volume: f64,
}

fn groups(found: &Inspection) -> Vec<Group> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let crowded = topology.non_manifold_edges(mesh);
    if crowded.is_empty() {
        return Vec::new();
    }
    let component = |h: &u32| topology.component[*h as usize / 3];
    let mut sets = DisjointSets::new(topology.component_faces.len());
    let mut open = vec![false; topology.component_faces.len()];
    for edge in &crowded {
        let up = edge.iter().filter(|h| start(mesh, **h) < end(mesh, **h));
        open[component(&edge[0]) as usize] |= 2 * up.count() != edge.len();
        edge.iter()
            .for_each(|h| _ = sets.join(component(&edge[0]), component(h)));
    }
    for h in (0..topology.boundary.len() as u32).filter(|h| topology.boundary[*h as usize]) {
        open[component(&h) as usize] = true;
    }
    let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for c in 0..open.len() as u32 {
        members.entry(sets.find(c)).or_default().push(c);
    }
    members.retain(|_, own| own.len() > 1 && own.iter().all(|c| !open[*c as usize]));
    let mut volume = vec![0.0; open.len()];
    let centre = mesh.positions.first().copied().unwrap_or_default();
    for f in topology.faces() {
        let [a, b, c] = mesh.corners(f).map(|p| p - centre);
        volume[topology.component[f as usize] as usize] += a.dot(b.cross(c)) / 6.0;
    }
    members
        .into_values()
        .map(|components| Group {
            volume: components.iter().map(|c| volume[*c as usize]).sum(),
            components,
        })
        .collect()
}

/// Whether a component encloses enough volume for its area to be a body with holes rather than a sheet.
fn encloses(c: &Component) -> bool {
    c.volume.abs() > tuning().repair.least_volume * powf(c.area, 1.5)
}
