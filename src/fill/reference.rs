//! The surface before a cut, where the flow starts from it.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::region::{CappedRims, KeptShape, TimeSpan};
use crate::sdf::Sampler;

/// What is kept of the surface before the cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Keeping<'a> {
    /// This part of its shape, from 0 to 1, by a pull.
    Part(f64),
    /// What is left of it after these of its faces have evolved for so long.
    Time(TimeSpan, &'a [bool]),
}

/// The surface before the cut.
pub(crate) struct ReferenceSurface<'a> {
    sampler: Sampler<'a>,
    rims: CappedRims,
    keeping: Keeping<'a>,
    /// For each hole the bounding box of what was cut out there.
    extents: Vec<Option<(DVec3, DVec3)>>,
}

impl<'a> ReferenceSurface<'a> {
    /// With the holes that the surface had, and for each hole that the cut left the bounding box of what was cut out there.
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
    pub(crate) fn time(&self) -> Option<TimeSpan> {
        match self.keeping {
            Keeping::Time(span, _) => Some(span),
            Keeping::Part(_) => None,
        }
    }

    /// The bounding box of what was cut out at a group of holes.
    pub(crate) fn extent(&self, group: &[usize]) -> Option<(DVec3, DVec3)> {
        let boxes = group.iter().filter_map(|&h| self.extents[h]);
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}
