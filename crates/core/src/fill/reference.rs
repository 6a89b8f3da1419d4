//! The reference surface: the surface before a cut, from which the flow starts and whose shape it partly keeps.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::region::{CappedRims, KeptShape, TimeSpan};
use crate::sdf::Sampler;

/// How the shape of the reference surface is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Keeping<'a> {
    /// The fraction of its shape that is kept, from 0 to 1, by a pull.
    Part(f64),
    /// By a flow in time: the time span, and the faces that evolve.
    Time(TimeSpan, &'a [bool]),
}

/// The surface before the cut, with its distances.
pub(crate) struct ReferenceSurface<'a> {
    sampler: Sampler<'a>,
    rims: CappedRims,
    keeping: Keeping<'a>,
    /// For each hole the bounding box of the faces that were cut out there.
    extents: Vec<Option<(DVec3, DVec3)>>,
}

impl<'a> ReferenceSurface<'a> {
    /// From the surface's distances and holes, and for each hole that the cut left the bounding box of the faces that were cut
    /// out there.
    pub(crate) fn new(
        sampler: Sampler<'a>,
        rims: CappedRims,
        keeping: Keeping<'a>,
        extents: Vec<Option<(DVec3, DVec3)>>,
    ) -> Self {
        Self {
            sampler,
            rims,
            keeping,
            extents,
        }
    }

    /// The data of the surface in a region. The pull ½ λ d² balances ½ h² for waves of the width below which features are
    /// removed.
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

    /// How long the surface evolves; none where it is pulled instead.
    pub(crate) fn time(&self) -> Option<TimeSpan> {
        match self.keeping {
            Keeping::Time(span, _) => Some(span),
            Keeping::Part(_) => None,
        }
    }

    /// The bounding box of the faces that were cut out at a group of holes.
    pub(crate) fn extent(&self, group: &[usize]) -> Option<(DVec3, DVec3)> {
        let boxes = group.iter().filter_map(|&h| self.extents[h]);
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}
