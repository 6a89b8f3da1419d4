//! What the numbers of attributes mean, and the parts that arrays play for viewers.

use serde::{Deserialize, Serialize};

/// What the numbers of an attribute mean, as far as it matters for carrying them over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Role {
    /// A unit normal of three components.
    Normal,
    /// A colour of three or four components: 0 to 1 as floats, 0 to the largest number as integers.
    Colour,
    /// A texture coordinate of the set of this number.
    Uv(u32),
    /// A unit tangent and, as a fourth component, its handedness.
    Tangent,
    /// Anything else.
    Other,
}

/// The part that an array plays for a viewer: of the arrays of a file one each may be the active scalars, vectors and so on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Active {
    /// None in particular.
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
