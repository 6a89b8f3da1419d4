//! Reference surfaces of restorations and fairings: the surface before a cut.

use super::cut::CutResult;
use crate::fill::{Keeping, ReferenceSurface};
use crate::mesh::triangulate::triangulate_loop;
use crate::mesh::{Hole, Mesh, Topology};
use crate::region::{CappedRims, TimeSpan};
use crate::sdf::Sampler;

/// A mesh whose holes were closed.
pub(super) struct ClosedSurface {
    mesh: Mesh,
    topology: Topology,
    /// Whether each face evolves.
    evolving: Vec<bool>,
}

impl CutResult<'_> {
    /// The surface before the cut; this fraction of its shape is kept.
    pub(super) fn reference(&self, part: f64) -> ReferenceSurface<'_> {
        let before = self.before;
        let holes: Vec<&Hole> = before.holes.iter().collect();
        ReferenceSurface::new(
            Sampler::new(&before.mesh, &before.topology),
            CappedRims::new(&holes, |h| !h.outer_boundary),
            Keeping::Part(part),
            self.extents(),
        )
    }

    /// The surface before the cut with its holes closed, so that it has an inside everywhere.
    pub(super) fn closed(&self) -> ClosedSurface {
        let mut mesh = self.before.mesh.clone().into_owned();
        for hole in &self.before.holes {
            if let Ok(faces) = triangulate_loop(&self.before.mesh, &hole.rim) {
                mesh.faces.extend(faces);
            }
        }
        let mut evolving = self.removed.clone();
        evolving.resize(mesh.faces.len(), false);
        let topology = Topology::new(&mut mesh);
        ClosedSurface {
            mesh,
            topology,
            evolving,
        }
    }

    /// The closed surface before the cut, as the initial surface of a flow in time.
    pub(super) fn evolving<'a>(
        &self,
        closed: &'a ClosedSurface,
        span: TimeSpan,
    ) -> ReferenceSurface<'a> {
        ReferenceSurface::new(
            Sampler::new(&closed.mesh, &closed.topology),
            CappedRims::none(),
            Keeping::Time(span, &closed.evolving),
            self.extents(),
        )
    }
}
