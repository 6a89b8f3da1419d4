//! Directed edges of faces.

use std::collections::HashSet;

/// Directed edges of faces.
pub(super) fn sides(face: [u32; 3]) -> [(u32, u32); 3] {
    [(face[0], face[1]), (face[1], face[2]), (face[2], face[0])]
}

/// Directed edges that are in use.
pub(super) type Used = HashSet<(u32, u32)>;
