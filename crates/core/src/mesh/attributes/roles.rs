//! Roles of attributes: the meaning of their numbers, and active arrays for viewers.

use serde::{Deserialize, Serialize};

/// Meaning of an attribute's numbers, as far as it matters for carrying them over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Role {
    /// A unit normal of three components.
    Normal,
    /// A colour of three or four components: 0 to 1 as floats, 0 to the largest value as integers.
    Colour,
    /// A texture coordinate; the number is its set.
    Uv(u32),
    /// A unit tangent and, as a fourth component, its handedness.
    Tangent,
    /// Anything else.
    Other,
}

/// Role of an array for a viewer: one array each of a file may be the active scalars, vectors and so on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Active {
    /// No role.
    Plain,
    /// The active scalars.
    Scalars,
    /// The active vectors.
    Vectors,
    /// The active normals.
    Normals,
    /// The active texture coordinates.
    TextureCoordinates,
    /// The active tensors.
    Tensors,
}
