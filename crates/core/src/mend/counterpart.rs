//! The counterpart of a mesh: registered once for a fill, with its parts for each region.

use std::sync::OnceLock;

use super::{FillError, Inspection};
use crate::cancel::Cancel;
use crate::fill::{Counterpart, FillParams, Like, PlacedPart, is_weighed, unit_normal};
use crate::mesh::{Hole, Mesh};
use crate::tuning::{Tunable, tunable};

/// Sizes of meshes, in mesh units, at which distances are found fast: their squares are single-precision numbers. Beyond, each search for a
/// nearest point visits all faces, and one mesh of 300 faces took 6 s.
const SIZES: [f64; 2] = [1e-18, 1e18];

/// Faces. In larger meshes planes of symmetry are searched only where the caller asks for them.
const MOST_SEARCHED: Tunable<usize> = tunable("mend.counterpart.most_searched", 4_000_000);

/// Whether a mesh has a size at which distances are found fast.
fn is_measured(mesh: &Mesh) -> bool {
    let [low, high] = mesh.bounds();
    let size = (high - low).max_element();
    size == 0.0 || (SIZES[0]..SIZES[1]).contains(&size)
}

/// Checks that the template of a fill, if there is one, has been read and is a valid mesh, and that counterparts of the mesh can be looked
/// for.
pub(super) fn check(params: &FillParams, mesh: &Mesh) -> Result<(), FillError> {
    let sized = |mesh: &Mesh| match is_measured(mesh) {
        true => Ok(()),
        false => Err(FillError::Parameter {
            what: "counterparts of `like` are looked for in meshes of a size between 1e-18 and 1e18 only: scale the mesh, or the template",
        }),
    };
    if params.like.is_some() {
        sized(mesh)?;
    }
    match &params.like {
        Some(Like::Template {
            mesh: Some(mesh), ..
        }) => {
            mesh.validate()?;
            sized(mesh)
        }
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

    /// The counterpart's parts at a region with the given holes; `None` if no counterpart is requested, and none is weighed with the
    /// smooth continuation.
    pub(super) fn parts(
        &self,
        params: &FillParams,
        holes: &[&Hole],
        cancel: &Cancel,
    ) -> Option<Vec<PlacedPart>> {
        let like = match &params.like {
            Some(like) => like,
            None if is_weighed(params, holes) && self.is_searched() => &Like::Mirror(None),
            None => return None,
        };
        let find = || self.find(like, params.like.is_none(), cancel);
        let found = self.counterpart.get_or_init(find).as_ref();
        let parts = |c: &Counterpart| c.parts(&self.found.mesh, holes);
        let parts = found.map(parts).unwrap_or_default();
        // That nothing fits is a result where the caller asked for a counterpart.
        (params.like.is_some() || !parts.is_empty()).then_some(parts)
    }

    /// Whether planes of symmetry are searched without being asked for.
    fn is_searched(&self) -> bool {
        is_measured(&self.found.mesh) && self.found.mesh.faces.len() <= MOST_SEARCHED.get()
    }

    /// The counterpart; `None` only for an invalid template, which [`check`] refuses.
    fn find(&self, like: &Like, is_quick: bool, cancel: &Cancel) -> Option<Counterpart<'a>> {
        let mesh = &self.found.mesh;
        match like {
            Like::Mirror(plane) => {
                let topology = &self.found.topology;
                let unit = |n| unit_normal(n).unwrap_or(n);
                let plane = plane.map(|[point, normal]| [point, unit(normal)]);
                Some(Counterpart::mirror(mesh, topology, plane, is_quick, cancel))
            }
            Like::Template { mesh: template, .. } => {
                let template = Inspection::new(template.as_ref()?.as_ref()).ok()?;
                let own = template.mesh.into_owned();
                let found = Counterpart::template(mesh, own, &template.topology, cancel);
                Some(found)
            }
        }
    }
}
