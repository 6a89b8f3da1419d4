//! Validation of meshes: why a mesh cannot be processed.

use glam::DVec3;
use thiserror::Error;

use super::{LARGEST, Mesh, SMALLEST, bounds};

/// Maximum number of faces: half-edges, three for each face, are numbered with 32 bits, and the last number stands for none.
const MOST_FACES: usize = (u32::MAX / 3) as usize - 1;
/// Maximum number of vertices, for the same reason.
const MOST_VERTICES: usize = u32::MAX as usize - 1;

/// Why a mesh cannot be processed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The mesh has no faces.
    #[error("the mesh has no faces; triangles are needed")]
    Empty,
    /// More vertices or faces than 32-bit numbers allow.
    #[error(
        "the mesh has {count} {what}, but at most {most} can be numbered; cut it into parts, or make it coarser"
    )]
    TooMany {
        /// "vertices" or "faces".
        what: &'static str,
        /// Their number.
        count: usize,
        /// The maximum number.
        most: usize,
    },
    /// A face refers to a vertex that does not exist.
    #[error(
        "face {face} refers to vertex {vertex}, but there {}, numbered from 0; remove the face, or add the vertex", only(*count)
    )]
    Index {
        /// The face, from 0.
        face: usize,
        /// The vertex.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A position is not finite.
    #[error(
        "vertex {vertex} has a coordinate that is not a finite number; remove it, or give it a position"
    )]
    NotFinite {
        /// The vertex, from 0.
        vertex: usize,
    },
    /// A coordinate is too large to compute areas.
    #[error(
        "vertex {vertex} has a coordinate of {size:e}, which is too large to measure; the largest that can be is {LARGEST:e}: \
         scale the mesh down, or remove the vertex if it is a mistake"
    )]
    TooLarge {
        /// The vertex, from 0.
        vertex: usize,
        /// Its largest coordinate.
        size: f64,
    },
    /// The mesh is too small to compute areas.
    #[error(
        "all vertices are within {extent:e} of each other, which is too small to measure; the smallest mesh that can be \
         measures {SMALLEST:e}: scale it up"
    )]
    TooSmall {
        /// The longest side of the bounding box.
        extent: f64,
    },
}

/// Fails for more vertices or faces than 32 bits can number.
fn validate_size(vertices: usize, faces: usize) -> Result<(), MeshError> {
    let too_many = |what, count, most| Err(MeshError::TooMany { what, count, most });
    if faces > MOST_FACES {
        return too_many("faces", faces, MOST_FACES);
    }
    if vertices > MOST_VERTICES {
        return too_many("vertices", vertices, MOST_VERTICES);
    }
    Ok(())
}

impl Mesh {
    /// Checks that the mesh can be processed: it has faces, their corners exist, and positions can be measured.
    ///
    /// # Errors
    /// The first defect, with its place.
    pub fn validate(&self) -> Result<(), MeshError> {
        let mesh = self;
        if mesh.faces.is_empty() {
            return Err(MeshError::Empty);
        }
        validate_size(mesh.positions.len(), mesh.faces.len())?;
        let count = mesh.positions.len();
        for (face, f) in mesh.faces.iter().enumerate() {
            if let Some(&vertex) = f.iter().find(|&&v| v as usize >= count) {
                return Err(MeshError::Index {
                    face,
                    vertex,
                    count,
                });
            }
        }
        if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
            return Err(MeshError::NotFinite { vertex });
        }
        let size = |p: &DVec3| p.abs().max_element();
        if let Some(vertex) = mesh.positions.iter().position(|p| size(p) > LARGEST) {
            let size = size(&mesh.positions[vertex]);
            return Err(MeshError::TooLarge { vertex, size });
        }
        let (low, high) = bounds(mesh.positions.iter().copied());
        let extent = (high - low).max_element();
        if 0.0 < extent && extent < SMALLEST {
            return Err(MeshError::TooSmall { extent });
        }
        Ok(())
    }
}

/// The number of vertices in words, to follow `there`.
fn only(count: usize) -> String {
    match count {
        1 => "is only 1 vertex".to_owned(),
        n => format!("are only {n} vertices"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_vertex_is_named_beside_their_number() {
        let said = |count| {
            MeshError::Index {
                face: 0,
                vertex: 3,
                count,
            }
            .to_string()
        };
        assert!(
            said(3)
                .starts_with("face 0 refers to vertex 3, but there are only 3 vertices, numbered")
        );
        assert!(
            said(1).starts_with("face 0 refers to vertex 3, but there is only 1 vertex, numbered")
        );
    }

    #[test]
    fn more_half_edges_than_32_bits_number_are_refused() {
        assert!(validate_size(3, MOST_FACES).is_ok());
        let last = 3 * (MOST_FACES as u64 + 1) - 1;
        assert!(last < u64::from(u32::MAX));
        for (vertices, faces) in [(3, MOST_FACES + 1), (MOST_VERTICES + 1, 1)] {
            let refused = validate_size(vertices, faces);
            assert!(matches!(refused, Err(MeshError::TooMany { .. })));
        }
    }
}
