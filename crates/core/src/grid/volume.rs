//! A dense scalar volume, as volume files hold it.

use glam::DVec3;

/// Values on the nodes of a box-shaped lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Number of nodes along x, y and z.
    pub dims: [usize; 3],
    /// Position of the first node.
    pub origin: DVec3,
    /// Distance of neighbouring nodes along each axis; positive.
    pub spacing: DVec3,
    /// The value of each node; x varies fastest, then y.
    pub values: Vec<f64>,
}

impl Volume {
    /// The value at a node.
    #[inline]
    pub fn at(&self, [i, j, k]: [usize; 3]) -> f64 {
        self.values[(k * self.dims[1] + j) * self.dims[0] + i]
    }

    /// The world position of a point in lattice coordinates; node `[i, j, k]` is at `(i, j, k)`.
    pub fn position(&self, point: DVec3) -> DVec3 {
        self.origin + self.spacing * point
    }

    /// The smallest and the largest value.
    pub fn range(&self) -> [f64; 2] {
        let start = [f64::INFINITY, f64::NEG_INFINITY];
        self.values
            .iter()
            .fold(start, |[low, high], v| [low.min(*v), high.max(*v)])
    }
}
