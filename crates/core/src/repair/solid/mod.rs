//! The solid inside the outer skin: inner skins of double-skinned bodies are found and removed, and the pinholes closed.
//!
//! Meshes made from unsigned distances have an outer and an inner skin a constant small distance apart, joined through pinholes. The
//! winding number does not tell the skins apart: it is one between them and zero on both sides. Found instead, for each set of
//! components that are each other's skins:
//!
//! 1. The thickness: the median distance to the other side of the material (`thickness.rs`).
//! 2. Outer faces: those that a ball from outside touches which is too large for pinholes (`reach.rs`).
//! 3. Inner faces: those that it does not touch, with an outer face on the other side at about the thickness.
//! 4. The border between both: the smallest cut of the dual graph, weighted by edge length (`flow.rs`).
//! 5. What the cut separates is an inner skin only if all its openings are pinholes (`regions.rs`). Insides of open vessels, grooves
//!    and bores are not.

mod flow;
mod group;
mod reach;
mod regions;
mod thickness;

use std::collections::BTreeMap;

use super::filling::Filling;
use super::{Run, border, report};
use crate::check::Component;
use crate::mend::{FillError, Inspection};
use crate::mesh::DisjointSets;
use crate::mesh::topology::NONE;
use crate::spatial::Bvh;
use crate::tuning::{Tunable, tunable};
use group::SkinGroup;
use thickness::{SkinSide, even_distance, sides};

/// Fraction of a component's area that has its other side on another component: then both belong to the same body.
const LINKED: Tunable<f64> = tunable("solid.linked", 0.2);

/// Fraction of the distance by which the distance of two components of the same body varies.
const EVEN: Tunable<f64> = tunable("solid.even", 0.35);

/// Fraction of the faces' area at about this distance. Clothes that cross a wall at all depths have a third.
const EVEN_PART: Tunable<f64> = tunable("solid.even_part", 0.5);

/// Faces. Bodies with fewer have no inner skin.
const LEAST_FACES: Tunable<usize> = tunable("solid.least_faces", 100);

/// The inner skins of a mesh.
#[derive(Default)]
struct InnerSkins {
    /// Marks their faces and the faces of pinholes' necks.
    removed: Vec<bool>,
    /// Their number.
    skins: usize,
    /// The pinholes that lead into them.
    pinholes: usize,
    /// The largest distance between outer and inner skin, in mesh units.
    thickness: f64,
}

impl Run<'_> {
    /// Removes inner skins and closes the pinholes; returns whether there were any.
    pub(super) fn make_solid(&mut self) -> Result<bool, FillError> {
        let (skins, old) = {
            let found = self.draft.inspect()?;
            (inner_skins(&found), border(&found))
        };
        self.go_on()?;
        if skins.skins == 0 {
            return Ok(false);
        }
        let origins = self.draft.origins.faces.clone();
        let count = self.draft.cut(&skins.removed)?;
        let living = self.draft.origins.living(self.input.faces.len());
        let gone = origins.iter().map(|o| o.face);
        self.asked
            .extend(gone.filter(|f| *f != NONE && !living[*f as usize]));
        self.report.steps.inner_skins = skins.skins;
        self.report.steps.inner_skin_faces = count;
        self.report.steps.pinholes = skins.pinholes;
        self.report.steps.skin_thickness = skins.thickness;
        self.fill(&old, Filling::Made)?;
        // Holes that a repair makes are numbered after the input's own.
        report::raise_numbers(&mut self.report.fill, self.choice.last_hole());
        self.early.clone_from(&self.report.fill.holes);
        Ok(true)
    }
}

/// Whether a closed component that faces outward lies in the matter of others: of the components round it more face outward than inward.
pub(super) fn is_buried(all: &[Component], number: usize) -> bool {
    let own = &all[number];
    let (mut depth, mut outer) = (0, own.inside);
    // As many steps as there are components: the relation has no circles, but is computed with rounding.
    for _ in 0..all.len() {
        let Some(next) = outer else { break };
        depth += if all[next].volume < 0.0 { -1 } else { 1 };
        outer = all[next].inside;
    }
    own.closed && own.volume > 0.0 && depth > 0
}

/// Finds the inner skins of a mesh.
fn inner_skins(found: &Inspection) -> InnerSkins {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let mut skins = InnerSkins {
        removed: vec![false; mesh.faces.len()],
        ..InnerSkins::default()
    };
    let bvh = Bvh::new(mesh, topology.faces());
    let all: Vec<u32> = (0..mesh.faces.len() as u32).collect();
    let mut sides = sides(mesh, &bvh, &all);
    let groups = groups(found, &sides);
    let only = groups.len() == 1;
    for faces in groups {
        if faces.len() < LEAST_FACES.get() {
            continue;
        }
        let own = (!only).then(|| Bvh::new(mesh, faces.iter().copied()));
        // Other parts that cross the walls do not count.
        if let Some(own) = &own {
            for (f, side) in faces.iter().zip(thickness::sides(mesh, own, &faces)) {
                sides[*f as usize] = side;
            }
        }
        let bvh = own.as_ref().unwrap_or(&bvh);
        let Some(group) = SkinGroup::new(found, &sides, faces, bvh) else {
            continue;
        };
        let inner = regions::inner_skins(&group, &group.separated());
        if inner.skins > 0 {
            for (removed, own) in skins.removed.iter_mut().zip(&inner.removed) {
                *removed |= own;
            }
            skins.skins += inner.skins;
            skins.pinholes += inner.pinholes;
            skins.thickness = skins.thickness.max(inner.thickness);
        }
    }
    skins
}

/// The faces of components that are each other's other sides, such as a closed outer skin and the closed inner skin in it. Clothes
/// that cross a body are at all distances from it, and stay a body of their own.
fn groups(found: &Inspection, sides: &[SkinSide]) -> Vec<Vec<u32>> {
    let component = |f: u32| found.topology.component[f as usize];
    let count = found.topology.component_faces.len();
    let mut area = vec![0.0; count];
    let mut shared: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
    for f in found.topology.faces() {
        let side = &sides[f as usize];
        area[component(f) as usize] += side.area;
        if side.opposite != NONE && component(side.opposite) != component(f) {
            let pair = (component(f), component(side.opposite));
            shared.entry(pair).or_default().push(f);
        }
    }
    let mut sets = DisjointSets::new(count);
    for ((a, b), faces) in shared {
        let all: f64 = faces.iter().map(|f| sides[*f as usize].area).sum();
        if all > LINKED.get() * area[a as usize]
            && even_distance(sides, &faces, [EVEN.get(), EVEN_PART.get()]).is_some()
        {
            sets.join(a, b);
        }
    }
    let mut faces: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for f in found.topology.faces() {
        faces.entry(sets.find(component(f))).or_default().push(f);
    }
    faces.into_values().collect()
}
