//! Crease ends: the vertices of rims at which sharp edges of the mesh end, numbered over all holes.

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Control, FillError, Inspection};
use crate::creases::RimSides;
use crate::fill::may_have_crease_ends;
use crate::mesh::{Hole, HoleId, VertexFaces};

/// A vertex of a hole's rim at which a sharp edge of the mesh ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CreaseEnd {
    /// Number, from 1, in the order of the holes and of the vertices of each rim.
    pub id: usize,
    /// Number of its hole.
    pub hole: HoleId,
    /// The rim vertex; the first of several at the same position.
    pub vertex: u32,
    /// Its position, in the mesh's units.
    pub position: DVec3,
    /// Angle between the normals of the two smooth sides that meet in the sharp edge, in degrees.
    pub angle: f64,
}

impl Inspection<'_> {
    /// Finds the vertices at which sharp edges of the mesh end at the rims of its holes.
    ///
    /// Rims of more than four and at most 1000 edges are examined, each separately. The result does not depend on the number of
    /// threads.
    ///
    /// # Errors
    /// [`FillError::Threads`] and [`FillError::Cancelled`].
    pub fn crease_ends(&self, control: &Control) -> Result<Vec<CreaseEnd>, FillError> {
        control.install(|| self.ends_of_rims(control))
    }

    fn ends_of_rims(&self, control: &Control) -> Result<Vec<CreaseEnd>, FillError> {
        let holes = self.holes.iter().filter(|h| may_have_crease_ends(h));
        let holes: Vec<&Hole> = holes.collect();
        if holes.is_empty() {
            return Ok(Vec::new());
        }
        let around = VertexFaces::new(&self.mesh);
        let cancel = control.token();
        let of_hole = |hole: &&Hole| {
            if control.is_cancelled() {
                return Err(FillError::Cancelled);
            }
            let sides = RimSides::new(&self.mesh, &around, &hole.rim, &cancel);
            let ends = sides.map_or_else(|_| Vec::new(), |sides| sides.ends());
            let end = |end: crate::creases::SharpEnd| CreaseEnd {
                id: 0,
                hole: hole.id,
                vertex: end.vertex,
                position: self.mesh.positions[end.vertex as usize],
                angle: end.angle,
            };
            Ok(ends.into_iter().map(end).collect())
        };
        let ends: Result<Vec<Vec<CreaseEnd>>, FillError> = holes.par_iter().map(of_hole).collect();
        let mut ends = ends?.concat();
        if control.is_cancelled() {
            return Err(FillError::Cancelled);
        }
        (1..)
            .zip(&mut ends)
            .for_each(|(id, end): (usize, &mut CreaseEnd)| end.id = id);
        Ok(ends)
    }
}
