//! The counterpart after which holes are filled: found once for a fill, its parts given to each region.

use super::regions::Regions;
use super::{FillError, Inspection};
use crate::cancel::Cancel;
use crate::fill::{Counterpart, FillParams, Like, PlacedPart, RegionPlan};

/// Whether the template of some parameters is there and is a mesh.
pub(super) fn check(params: &FillParams) -> Result<(), FillError> {
    match &params.like {
        Some(Like::Template {
            mesh: Some(mesh), ..
        }) => Ok(mesh.validate()?),
        Some(like) if like.unread().is_some() => Err(FillError::Parameter {
            what: "the template of `like` was not read: a job reads its file, in the library `Like::template` takes a mesh",
        }),
        _ => Ok(()),
    }
}

impl<'a> Regions<'a> {
    /// The parts of the counterpart at some regions; none for those that are filled after none.
    pub(super) fn counterparts(
        &self,
        regions: impl Iterator<Item = usize>,
        cancel: &Cancel,
    ) -> Vec<Option<Vec<PlacedPart>>> {
        let of = |i: usize| {
            let is_surface = self.plans[i] == RegionPlan::Solve && self.reference.is_none();
            let like = self.params.like.as_ref().filter(|_| is_surface)?;
            let counterpart = self.counterpart.get_or_init(|| self.find(like, cancel));
            let holes = self.holes(&self.groups[i]);
            let parts = |c: &Counterpart| c.parts(&self.found.mesh, &holes);
            Some(counterpart.as_ref().map(parts).unwrap_or_default())
        };
        regions.map(of).collect()
    }

    /// The counterpart; none where the template is no mesh, which was checked before.
    fn find(&self, like: &Like, cancel: &Cancel) -> Option<Counterpart<'a>> {
        let mesh = &self.found.mesh;
        match like {
            Like::Mirror(plane) => {
                let topology = &self.found.topology;
                Some(Counterpart::mirror(mesh, topology, *plane, cancel))
            }
            Like::Template { mesh: template, .. } => {
                let template = Inspection::new(template.as_ref()?.as_ref()).ok()?;
                let own = template.mesh.clone();
                let scale = self.params.like_scale;
                let found = Counterpart::template(mesh, own, &template.topology, scale, cancel);
                Some(found)
            }
        }
    }
}
