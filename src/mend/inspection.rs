//! What a mesh holds: found once, used for any number of plans and runs.

use std::borrow::Cow;

use glam::DVec3;

use super::FillError;
use crate::attributes::transfer;
use crate::check::{CheckParams, Subject, Verdict, judge};
use crate::mesh::{
    Hole, LARGEST, Mesh, Model, OpenChain, SMALLEST, Topology, bounds, find_holes, weld_map,
};

/// What a mesh holds. [`Inspection::plan`], [`Inspection::fill`], [`Inspection::restore`] and [`Inspection::fair`] work on it.
#[derive(Clone)]
pub struct Inspection<'m> {
    /// The mesh as given.
    pub input: Cow<'m, Mesh>,
    /// For each vertex the first one at exactly the same position: the vertex that stands for it in `mesh`.
    pub weld: Vec<u32>,
    /// Its holes, the longest first.
    pub holes: Vec<Hole>,
    /// The welded mesh with faces turned to agree.
    pub mesh: Mesh,
    /// Its connectivity.
    pub topology: Topology,
    /// Boundary chains that do not close.
    pub open_chains: Vec<OpenChain>,
}

impl<'m> Inspection<'m> {
    /// Finds the pieces, holes and defects of a mesh, borrowed or owned.
    ///
    /// # Errors
    /// When the mesh is empty, an index is out of range, or a coordinate is not finite or too large or small to measure.
    pub fn new(input: impl Into<Cow<'m, Mesh>>) -> Result<Self, FillError> {
        let input = input.into();
        validate(&input)?;
        let weld = weld_map(&input);
        let welded = |f: &[u32; 3]| f.map(|v| weld[v as usize]);
        let faces = input.faces.iter().map(welded).collect();
        let mut mesh = Mesh::new(input.positions.clone(), faces);
        let mut topology = Topology::new(&mut mesh);
        let own = weld.iter().zip(0u32..).filter(|(w, v)| *w == v).count();
        topology.defects.duplicate_vertices = weld.len() - own;
        let (holes, open_chains) = find_holes(&mesh, &mut topology);
        Ok(Self {
            input,
            weld,
            holes,
            mesh,
            topology,
            open_chains,
        })
    }

    /// Looks for everything that may be wrong with the mesh.
    pub fn check(&self, params: &CheckParams) -> Verdict {
        let subject = Subject {
            input: &self.input,
            mesh: &self.mesh,
            topology: &self.topology,
            holes: &self.holes,
            open_chains: &self.open_chains,
        };
        judge(&subject, params)
    }

    /// The same, with a copy of the mesh if it was borrowed.
    pub fn into_owned(self) -> Inspection<'static> {
        Inspection {
            input: Cow::Owned(self.input.into_owned()),
            weld: self.weld,
            holes: self.holes,
            mesh: self.mesh,
            topology: self.topology,
            open_chains: self.open_chains,
        }
    }

    /// Whether a hole bounds a component of one or two triangles.
    pub(super) fn bounds_small_component(&self, hole: usize) -> bool {
        self.topology.piece_faces[self.holes[hole].piece as usize] <= 2
    }
}

impl Model {
    /// Finds the pieces, holes and defects of the mesh.
    ///
    /// # Errors
    /// As [`Inspection::new`].
    pub fn inspect(&self) -> Result<Inspection<'_>, FillError> {
        Inspection::new(&self.mesh)
    }

    /// The model with another mesh, which begins with the vertices and faces of this one: what it carries is continued on what
    /// comes after them; see [`transfer`].
    #[must_use]
    pub fn mended(&self, mesh: Mesh) -> Self {
        transfer(&self.mesh, &self.attributes, mesh)
    }
}

impl<'m> From<&'m Mesh> for Cow<'m, Mesh> {
    fn from(mesh: &'m Mesh) -> Self {
        Cow::Borrowed(mesh)
    }
}

impl From<Mesh> for Cow<'_, Mesh> {
    fn from(mesh: Mesh) -> Self {
        Cow::Owned(mesh)
    }
}

/// The largest number of faces: half-edges, three for each face, are numbered by 32 bits, and the last number stands for none.
const MOST_FACES: usize = (u32::MAX / 3) as usize - 1;
/// The largest number of vertices, for the same reason.
const MOST_VERTICES: usize = u32::MAX as usize - 1;

/// Refuses more vertices or faces than 32 bits can number.
fn validate_size(vertices: usize, faces: usize) -> Result<(), FillError> {
    let too_many = |what, count, most| Err(FillError::TooMany { what, count, most });
    if faces > MOST_FACES {
        return too_many("faces", faces, MOST_FACES);
    }
    if vertices > MOST_VERTICES {
        return too_many("vertices", vertices, MOST_VERTICES);
    }
    Ok(())
}

/// Refuses what cannot be measured.
pub(super) fn validate(mesh: &Mesh) -> Result<(), FillError> {
    if mesh.faces.is_empty() {
        return Err(FillError::Empty);
    }
    validate_size(mesh.positions.len(), mesh.faces.len())?;
    let count = mesh.positions.len();
    for (face, f) in mesh.faces.iter().enumerate() {
        if let Some(&vertex) = f.iter().find(|&&v| v as usize >= count) {
            return Err(FillError::Index {
                face,
                vertex,
                count,
            });
        }
    }
    if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(FillError::NotFinite { vertex });
    }
    let size = |p: &DVec3| p.abs().max_element();
    if let Some(vertex) = mesh.positions.iter().position(|p| size(p) > LARGEST) {
        let size = size(&mesh.positions[vertex]);
        return Err(FillError::TooLarge { vertex, size });
    }
    let (low, high) = bounds(mesh.positions.iter().copied());
    let extent = (high - low).max_element();
    if 0.0 < extent && extent < SMALLEST {
        return Err(FillError::TooSmall { extent });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_half_edges_than_32_bits_number_are_refused() {
        assert!(validate_size(3, MOST_FACES).is_ok());
        let last = 3 * (MOST_FACES as u64 + 1) - 1;
        assert!(last < u64::from(u32::MAX));
        for (vertices, faces) in [(3, MOST_FACES + 1), (MOST_VERTICES + 1, 1)] {
            let refused = validate_size(vertices, faces);
            assert!(matches!(refused, Err(FillError::TooMany { .. })));
        }
    }
}
