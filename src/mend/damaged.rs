//! The surface before a cut, where the flow starts from it.

use std::f64::consts::TAU;

use glam::DVec3;

use super::opening::Opening;
use crate::mesh::triangulate::triangulate_loop;
use crate::mesh::{Hole, Mesh, Topology};
use crate::region::{CappedRims, KeptShape, TimeSpan};
use crate::sdf::Sampler;

/// What is kept of the surface before the cut.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Keeping<'a> {
    /// This part of its shape, from 0 to 1, by a pull.
    Part(f64),
    /// What is left of it after these of its faces have evolved for so long.
    Time(TimeSpan, &'a [bool]),
}

/// A surface without holes.
pub(super) struct Closed {
    mesh: Mesh,
    topology: Topology,
    /// Which of its faces evolve.
    evolving: Vec<bool>,
}

/// The surface before the cut.
pub(super) struct Damaged<'a> {
    sampler: Sampler<'a>,
    rims: CappedRims,
    keeping: Keeping<'a>,
    /// For each hole the bounding box of what was cut out there.
    extents: Vec<Option<(DVec3, DVec3)>>,
}

impl Damaged<'_> {
    /// The surface in a region: ½ λ d² balances ½ h² at waves of the width below which features are to go.
    pub(super) fn kept(&self, diameter: f64, voxel: f64) -> KeptShape<'_> {
        let weight = match self.keeping {
            Keeping::Part(part) => (TAU / (diameter * (1.0 - part) / part).max(voxel)).powi(4),
            Keeping::Time(..) => 0.0,
        };
        KeptShape {
            sampler: &self.sampler,
            rims: &self.rims,
            weight,
            evolving: match self.keeping {
                Keeping::Time(_, evolving) => Some(evolving),
                Keeping::Part(_) => None,
            },
        }
    }

    /// How long it evolves.
    pub(super) fn time(&self) -> Option<TimeSpan> {
        match self.keeping {
            Keeping::Time(span, _) => Some(span),
            Keeping::Part(_) => None,
        }
    }

    /// The bounding box of what was cut out at a group of holes.
    pub(super) fn extent(&self, group: &[usize]) -> Option<(DVec3, DVec3)> {
        let boxes = group.iter().filter_map(|&h| self.extents[h]);
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

impl Opening<'_> {
    /// The surface before the cut, of which part of the shape is kept.
    pub(super) fn damaged(&self, part: f64) -> Damaged<'_> {
        let before = self.before;
        let holes: Vec<&Hole> = before.holes.iter().collect();
        Damaged {
            sampler: Sampler::new(&before.mesh, &before.topology),
            rims: CappedRims::new(&holes, |h| !h.outer_border),
            keeping: Keeping::Part(part),
            extents: self.extents(),
        }
    }

    /// The surface before the cut with its holes closed, so that it has an inside everywhere.
    pub(super) fn closed(&self) -> Closed {
        let mut mesh = self.before.mesh.clone();
        for hole in &self.before.holes {
            if let Ok(faces) = triangulate_loop(&self.before.mesh, &hole.rim) {
                mesh.faces.extend(faces);
            }
        }
        let mut evolving = self.removed.clone();
        evolving.resize(mesh.faces.len(), false);
        let topology = Topology::new(&mut mesh);
        Closed {
            mesh,
            topology,
            evolving,
        }
    }

    /// The surface before the cut, which evolves.
    pub(super) fn evolving<'a>(&self, closed: &'a Closed, span: TimeSpan) -> Damaged<'a> {
        Damaged {
            sampler: Sampler::new(&closed.mesh, &closed.topology),
            rims: CappedRims::none(),
            keeping: Keeping::Time(span, &closed.evolving),
            extents: self.extents(),
        }
    }
}
