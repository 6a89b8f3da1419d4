//! Inspection of a mesh: its components, holes and defects, found once and used for any number of plans and runs.

use std::borrow::Cow;

use super::FillError;
use crate::attributes::transfer;
use crate::check::{CheckParams, Subject, Verdict, judge};
use crate::mesh::{
    Bodies, Hole, Mesh, Model, OpenChain, Topology, find_holes, weld_map, weld_map_of_bodies,
};

/// An analysed mesh. [`Inspection::plan`], [`Inspection::fill`], [`Inspection::restore`] and [`Inspection::fair`] work on it.
#[derive(Clone)]
#[non_exhaustive]
pub struct Inspection<'m> {
    /// The mesh as given.
    pub input: Cow<'m, Mesh>,
    /// For each vertex the first one at exactly the same position, which represents it in `mesh`.
    pub weld: Vec<u32>,
    /// Its holes, the longest first.
    pub holes: Vec<Hole>,
    /// The welded mesh, its faces oriented consistently. Borrowed where the input is, and is so already.
    pub mesh: Cow<'m, Mesh>,
    /// Its connectivity.
    pub topology: Topology,
    /// Boundary chains that do not close.
    pub open_chains: Vec<OpenChain>,
}

impl<'m> Inspection<'m> {
    /// Finds the components, holes and defects of a mesh, borrowed or owned.
    ///
    /// # Errors
    /// If the mesh is empty, an index is out of range, or a coordinate is not finite, or too large or too small to measure with.
    pub fn new(input: impl Into<Cow<'m, Mesh>>) -> Result<Self, FillError> {
        Self::of_bodies(input, None)
    }

    /// The same for a mesh of several bodies, which are not connected where they touch.
    pub fn of_bodies(
        input: impl Into<Cow<'m, Mesh>>,
        bodies: Option<&Bodies>,
    ) -> Result<Self, FillError> {
        let input = input.into();
        input.validate()?;
        let weld = match bodies {
            None => weld_map(&input),
            Some(bodies) => weld_map_of_bodies(&input, bodies),
        };
        let own = weld.iter().zip(0u32..).filter(|(w, v)| *w == v).count();
        let mut mesh = match input {
            Cow::Borrowed(mesh) if own == weld.len() => Cow::Borrowed(mesh),
            _ => {
                let welded = |f: &[u32; 3]| f.map(|v| weld[v as usize]);
                let faces = input.faces.iter().map(welded).collect();
                Cow::Owned(Mesh::new(input.positions.clone(), faces))
            }
        };
        let mut topology = Topology::without_orienting(&mesh);
        if topology.defects.misoriented_edges > 0 {
            topology.orient(mesh.to_mut());
        }
        topology.defects.duplicate_vertices = weld.len() - own;
        let (mut holes, open_chains) = find_holes(&mesh, &mut topology);
        if let Some(bodies) = bodies {
            let body =
                |v| (0..bodies.count()).find(|b| bodies.vertices[*b].binary_search(&v).is_ok());
            for hole in &mut holes {
                hole.object = body(hole.rim[0]).map(|b| bodies.names[b].clone());
            }
        }
        Ok(Self {
            input,
            weld,
            holes,
            mesh,
            topology,
            open_chains,
        })
    }

    /// Checks the mesh for all kinds of defects.
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

    /// The same inspection with an owned copy of the mesh, if it was borrowed.
    pub fn into_owned(self) -> Inspection<'static> {
        Inspection {
            input: Cow::Owned(self.input.into_owned()),
            weld: self.weld,
            holes: self.holes,
            mesh: Cow::Owned(self.mesh.into_owned()),
            topology: self.topology,
            open_chains: self.open_chains,
        }
    }

    /// Whether a hole bounds a component of one or two triangles.
    pub(super) fn bounds_small_component(&self, hole: usize) -> bool {
        self.topology.is_loose(self.holes[hole].component)
    }
}

impl Model {
    /// Finds the components, holes and defects of the mesh.
    ///
    /// # Errors
    /// As [`Inspection::new`].
    pub fn inspect(&self) -> Result<Inspection<'_>, FillError> {
        Inspection::new(&self.mesh)
    }

    /// The model with another mesh, whose first vertices and faces are this mesh's. Its attributes are continued onto the
    /// vertices and faces after them; see [`transfer`].
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
