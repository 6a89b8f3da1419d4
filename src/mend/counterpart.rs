//! The counterpart after which holes are filled: found once for a fill, its parts given to each region.

use std::sync::OnceLock;

use super::{FillError, Inspection};
use crate::cancel::Cancel;
use crate::fill::{Counterpart, FillParams, Like, PlacedPart};
use crate::mesh::Hole;

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

/// The counterpart of a mesh, found when it is first asked for.
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

    /// The parts that lie at a region of some holes; none where it is filled after none.
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

    /// The counterpart; none where the template is no mesh, which was checked before.
    fn find(&self, like: &Like, scale: bool, cancel: &Cancel) -> Option<Counterpart<'a>> {
        let mesh = &self.found.mesh;
        match like {
            Like::Mirror(plane) => {
                let topology = &self.found.topology;
                Some(Counterpart::mirror(mesh, topology, *plane, cancel))
            }
            Like::Template { mesh: template, .. } => {
                let template = Inspection::new(template.as_ref()?.as_ref()).ok()?;
                let own = template.mesh.clone();
                let found = Counterpart::template(mesh, own, &template.topology, scale, cancel);
                Some(found)
            }
        }
    }
}
