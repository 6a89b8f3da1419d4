//! What needs attention at a patch. The command line and Python each say it in their own words.

use isomend_core::fill::{Closure, HoleOutcome, NotSmooth, RegionReport};

/// A remark on a patch that needs attention, in the order of importance.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Remark {
    /// Nothing closed it.
    Open,
    /// Faces of the patch intersect others.
    Intersects,
    /// The level set found no surface.
    NoSurface,
    /// Closed without new vertices, since no smooth surface was found.
    RimTriangles,
    /// The flat cap that was asked for could not be made.
    NoCap,
    /// The level set still moved after its last step.
    NotConverged,
    /// Sharp edges were not continued.
    LostCreases,
    /// The patch rises far above its rim.
    Bulges,
    /// The patch may be far off.
    Unsure,
    /// Rims that a bridge was to join have caps of their own.
    SeparateCaps,
    /// The Willmore energy was used in place of the variation of curvature.
    OtherEnergy,
}

impl Remark {
    /// All remarks, the most important first.
    pub const ALL: [Self; 11] = [
        Self::Open,
        Self::Intersects,
        Self::NoSurface,
        Self::RimTriangles,
        Self::NoCap,
        Self::NotConverged,
        Self::LostCreases,
        Self::Bulges,
        Self::Unsure,
        Self::SeparateCaps,
        Self::OtherEnergy,
    ];

    /// The most important remark on a region; `outcome` is the outcome of a hole of it.
    pub fn of(region: &RegionReport, outcome: Option<&HoleOutcome>) -> Option<Self> {
        let unconverged = !region.levels.is_empty() && !region.converged;
        let of_hole = outcome.and_then(HoleOutcome::closure);
        Some(match of_hole.or(region.closure.as_ref()) {
            _ if matches!(outcome, Some(HoleOutcome::Open(_))) => Self::Open,
            None => Self::Open,
            _ if region.intersecting_faces > 0 => Self::Intersects,
            Some(Closure::Faired(Some(_))) => Self::NoSurface,
            Some(Closure::RimTriangles(NotSmooth::NoSurface(_))) => Self::RimTriangles,
            Some(Closure::RimTriangles(NotSmooth::Flat)) => Self::NoCap,
            Some(Closure::LevelSet) if unconverged => Self::NotConverged,
            _ if region.not_continued.is_some() => Self::LostCreases,
            _ if region.balloons() => Self::Bulges,
            _ if region.is_unsure() => Self::Unsure,
            _ if region.bridge && region.components > 1 => Self::SeparateCaps,
            _ if region.other_energy => Self::OtherEnergy,
            _ => return None,
        })
    }
}
