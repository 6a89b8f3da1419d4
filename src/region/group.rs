//! Which holes are filled together, and on which lattice.
pub struct Grouping; pub struct Region; pub fn group_holes() {}
