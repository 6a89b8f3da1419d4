//! Hole numbers.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The number of a hole in its mesh, from 1, in falling order of the rim's length. Serialised and printed as a plain number.
///
/// ```
/// use isomend::HoleId;
///
/// let id = HoleId::from(2);
/// assert_eq!(id.get(), 2);
/// assert_eq!(format!("hole {id}"), "hole 2");
/// ```
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[serde(transparent)]
pub struct HoleId(pub(crate) usize);

impl HoleId {
    /// The number.
    pub const fn get(self) -> usize {
        self.0
    }
}

impl From<usize> for HoleId {
    fn from(number: usize) -> Self {
        Self(number)
    }
}

impl From<HoleId> for usize {
    fn from(id: HoleId) -> Self {
        id.0
    }
}

impl fmt::Display for HoleId {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(f)
    }
}
