//! The surface before a cut, where the flow starts from it.

use std::f64::consts::TAU;

use glam::DVec3;

use super::opening::Opening;
use crate::region::{KeptShape, TimeSpan};
use crate::sdf::{RimSet, Sampler};

/// What is kept of the surface before the cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Keeping {
    /// This part of its shape, from 0 to 1, by a pull.
    Part(f64),
    /// What is left of it after it has evolved for so long.
    Time(TimeSpan),
}

/// The surface before the cut.
pub(super) struct Damaged<'a> {
    sampler: Sampler<'a>,
    rims: RimSet,
    keeping: Keeping,
    /// Which of its faces were cut out.
    removed: &'a [bool],
    /// For each hole the bounding box of what was cut out there.
    extents: Vec<Option<(DVec3, DVec3)>>,
}

impl Damaged<'_> {
    /// The surface in a region: ½ λ d² balances ½ h² at waves of the width below which features are to go.
    pub(super) fn kept(&self, diameter: f64, voxel: f64) -> KeptShape<'_> {
        let weight = match self.keeping {
            Keeping::Part(part) => (TAU / (diameter * (1.0 - part) / part).max(voxel)).powi(4),
            Keeping::Time(_) => 0.0,
        };
        KeptShape {
            sampler: &self.sampler,
            rims: &self.rims,
            weight,
            evolving: self.time().map(|_| self.removed),
        }
    }

    /// How long it evolves.
    pub(super) fn time(&self) -> Option<TimeSpan> {
        match self.keeping {
            Keeping::Time(span) => Some(span),
            Keeping::Part(_) => None,
        }
    }

    /// The bounding box of what was cut out at a group of holes.
    pub(super) fn extent(&self, group: &[usize]) -> Option<(DVec3, DVec3)> {
        let boxes = group.iter().filter_map(|&h| self.extents[h]);
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

impl Opening {
    /// The surface before the cut, of which something is kept.
    pub(super) fn damaged(&self, keeping: Keeping) -> Damaged<'_> {
        let before = &self.before;
        let closed = !before.holes.iter().any(|h| h.outer_border);
        Damaged {
            sampler: Sampler::new(&before.mesh, &before.topology),
            rims: RimSet::new(before.holes.iter(), closed),
            keeping,
            removed: &self.removed,
            extents: self.extents(),
        }
    }
}
