//! Orientation: faces agree within each component, and closed components show their outside.

use super::draft::Draft;
use crate::check::{Component, components};
use crate::elementary::powf;
use crate::mend::{FillError, Inspection};
use crate::mesh::topology::NONE;
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
    wrong
}

/// Whether a component encloses enough volume for its area to be a body with holes rather than a sheet.
fn encloses(c: &Component) -> bool {
    c.volume.abs() > tuning().repair.least_volume * powf(c.area, 1.5)
}
