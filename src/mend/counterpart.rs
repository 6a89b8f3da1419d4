//! The counterpart of a mesh: registered once for a fill, with its parts for each region.

use std::sync::OnceLock;

use super::{FillError, Inspection};
use crate::cancel::Cancel;
use crate::fill::{Counterpart, FillParams, Like, PlacedPart, unit_normal};
use crate::mesh::Hole;

/// Checks that the template of a fill, if there is one, has been read and is a valid mesh.
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

/// The counterpart of a mesh, registered when it is first needed.
pub(super) struct LazyCounterpart<'a> {
    found: &'a Inspection<'a>,
    counterpart: OnceLock<Option<Counterpart<'a>>>,
}

impl<'a> LazyCounterpart<'a> {
    pub(super) fn new(found: &'a Inspection<'a>) -> Self {
        Self {
            found,
            counterpart: OnceLock::new(),
        }
    }

    /// The counterpart's parts at a region with the given holes; `None` if no counterpart is requested.
    pub(super) fn parts(
        &self,
        params: &FillParams,
        holes: &[&Hole],
        cancel: &Cancel,
    ) -> Option<Vec<PlacedPart>> {
        let like = params.like.as_ref()?;
        let find = || self.find(like, params.like_scale, cancel);
        let found = self.counterpart.get_or_init(find).as_ref();
        let parts = |c: &Counterpart| c.parts(&self.found.mesh, holes);
        Some(found.map(parts).unwrap_or_default())
    }

    /// The counterpart; `None` only for an invalid template, which [`check`] refuses.
    fn find(&self, like: &Like, scale: bool, cancel: &Cancel) -> Option<Counterpart<'a>> {
        let mesh = &self.found.mesh;
        match like {
            Like::Mirror(plane) => {
                let topology = &self.found.topology;
                let unit = |n| unit_normal(n).unwrap_or(n);
                let plane = plane.map(|[point, normal]| [point, unit(normal)]);
                Some(Counterpart::mirror(mesh, topology, plane, cancel))
            }
            Like::Template { mesh: template, .. } => {
                let template = Inspection::new(template.as_ref()?.as_ref()).ok()?;
                let own = template.mesh.into_owned();
                let found = Counterpart::template(mesh, own, &template.topology, scale, cancel);
                Some(found)
            }
        }
    }
}
