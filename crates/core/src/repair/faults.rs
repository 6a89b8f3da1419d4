//! The faults that drafts of a repair are compared by.

/// The faults of a draft, most important first; drafts are compared lexicographically.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Faults {
    /// Input components with no face left.
    pub(super) lost_components: usize,
    /// Faces that intersect others.
    pub(super) crossing: usize,
    /// Non-manifold edges and vertices.
    pub(super) non_manifold: usize,
    /// Holes, and boundary chains that do not close.
    pub(super) open: usize,
}

impl Faults {
    /// Whether there are no non-manifold edges or vertices.
    pub(super) fn is_manifold(&self) -> bool {
        self.non_manifold == 0
    }

    /// The number of intersecting faces and non-manifold edges and vertices.
    pub(super) fn intersecting_or_not_manifold(&self) -> usize {
        self.crossing + self.non_manifold
    }

    /// Whether there are holes.
    pub(super) fn is_open(&self) -> bool {
        self.open > 0
    }
}
