//! A fitted counterpart as the surface onto which a patch's vertices are projected.

use glam::DVec3;

use super::judge::Fitted;
use crate::cancel::Cancel;
use crate::fill::problem::RegionProblem;
use crate::mesh::{VertexFaces, vertex_normal};
use crate::sdf::{RimSet, Sampler, Surface};

/// The surface of a counterpart, and the distance by which it is cut along the rims of a region.
pub(super) struct CounterpartSurface<'a> {
    fitted: &'a Fitted,
    normals: Vec<DVec3>,
    known: &'a Sampler<'a>,
    rims: RimSet,
    cancel: &'a Cancel,
}

impl<'a> CounterpartSurface<'a> {
    pub(super) fn new(problem: &'a RegionProblem<'_>, fitted: &'a Fitted) -> Self {
        let around = VertexFaces::new(&fitted.mesh);
        let vertices = 0..fitted.mesh.positions.len() as u32;
        Self {
            fitted,
            normals: vertices
                .map(|v| vertex_normal(&fitted.mesh, &around, v))
                .collect(),
            known: problem.known,
            rims: RimSet::new(problem.holes.iter().copied()),
            cancel: problem.cancel,
        }
    }
}

impl Surface for CounterpartSurface<'_> {
    fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }

    fn project(&self, p: DVec3) -> Option<(DVec3, DVec3)> {
        let closest = self.fitted.bvh.closest(p, f64::INFINITY)?;
        let face = self.fitted.mesh.faces[closest.face as usize];
        let corners = (0..3).map(|k| closest.barycentric[k] * self.normals[face[k] as usize]);
        let normal = corners.sum::<DVec3>().try_normalize()?;
        Some((closest.point, normal))
    }

    fn depth(&self, p: DVec3) -> f64 {
        if self.is_cancelled() {
            return -f64::MAX;
        }
        match self.known.closest_of_all(&self.rims, p) {
            Some((closest, true)) => closest.distance,
            Some((closest, false)) => -closest.distance,
            None => -f64::MAX,
        }
    }
}
