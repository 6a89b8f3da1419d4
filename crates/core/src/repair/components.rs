//! Removal of components: those that the caller named, debris, and those inside others.

use std::collections::BTreeSet;

use super::{Run, solid};
use crate::check::components;
use crate::mend::FillError;
use crate::mesh::topology::NONE;

impl Run<'_> {
    /// Marks the faces of the components that the caller named, and notes their number; empty if there are none.
    pub(super) fn chosen(&mut self) -> Result<Vec<bool>, FillError> {
        let chosen: BTreeSet<usize> = self.params.drop.iter().copied().collect();
        let (Some(&first), Some(&last)) = (chosen.first(), chosen.last()) else {
            return Ok(Vec::new());
        };
        let before = self.report.before.as_ref();
        let count = before.map_or(0, |verdict| verdict.components.len());
        if last > count || first == 0 {
            let id = if last > count { last } else { first };
            return Err(FillError::NoSuchComponent { id, count });
        }
        if chosen.len() == count {
            return Err(FillError::Parameter {
                what: "`drop` names all components of the mesh or of an object: nothing would be left of it",
            });
        }
        self.report.steps.dropped_components = chosen.len();
        let is_chosen = |c: &u32| *c != NONE && chosen.contains(&(*c as usize + 1));
        Ok(self.components.iter().map(is_chosen).collect())
    }

    /// Removes debris and components that lie inside others.
    pub(super) fn drop_components(&mut self) -> Result<(), FillError> {
        let (debris, inside) = (self.params.debris.unwrap_or(0.0), self.params.drop_inside);
        // Generated parts inside a body that became solid are in its matter.
        let buried = self.report.steps.inner_skins > 0;
        if debris <= 0.0 && !inside && !buried {
            return Ok(());
        }
        let removed: Vec<bool> = {
            let found = self.draft.inspect()?;
            let all = components(&found.mesh, &found.topology, debris);
            let mut goes = vec![false; all.len()];
            for (i, c) in all.iter().enumerate() {
                let is_cavity = c.closed && c.volume < 0.0 && !c.depth.is_multiple_of(2);
                let goes_inside = inside && c.inside.is_some() && !is_cavity
                    || buried && solid::is_buried(&all, i);
                let steps = &mut self.report.steps;
                let (count, faces) = match (c.debris, goes_inside) {
                    (true, _) => (&mut steps.debris_components, &mut steps.debris_faces),
                    (_, true) => (&mut steps.inside_components, &mut steps.inside_faces),
                    _ => continue,
                };
                goes[i] = true;
                *count += 1;
                *faces += c.faces;
            }
            let component = found.topology.component.iter();
            component.map(|&p| p != NONE && goes[p as usize]).collect()
        };
        self.take_out(&removed);
        Ok(())
    }

    /// Removes faces because the caller asked for it; returns their number.
    pub(super) fn take_out(&mut self, removed: &[bool]) -> usize {
        let origins = self.draft.origins.faces.iter().zip(removed);
        self.asked
            .extend(origins.filter(|(_, gone)| **gone).map(|(o, _)| o.face));
        self.draft.remove(removed)
    }
}
