//! Marching cubes: extracts the zero level of a lattice function as a triangle mesh.
//!
//! [`marching_cubes`] visits only the given cells, so that its cost depends on the narrow band and not on the bounding
//! box. The result is manifold: the faces around a vertex form one fan, and every edge is in two faces, or in one where
//! the visited cells end. Only there does the surface have a border.
//!
//! Sources: Lorensen and Cline, "Marching cubes", 1987; Nielson and Hamann, "The asymptotic decider", 1991, for cell
//! faces whose corners alternate in sign.

mod dense;
mod polygon;
mod table;
mod volume;

#[cfg(test)]
mod tests;

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::grid::{add, as_point};
use polygon::Polygon;
use table::{CORNER, EDGE_AXIS, EDGE_NODE, table};

pub use volume::{VolumeSurfaceError, level_surface};

/// Least distance of a vertex from the nodes of its lattice edge, as a fraction of the edge.
///
/// Otherwise a node exactly at the level would give several vertices at one position.
pub const NODE_CLEARANCE: f64 = 1e-6;

/// The axis in [`IsoSurface::edges`] of a vertex inside a cell.
pub const CELL_CENTRE: u8 = 3;

/// A level surface on a lattice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IsoSurface {
    /// Vertices in lattice coordinates (node `[i, j, k]` is at `(i, j, k)`).
    pub positions: Vec<DVec3>,
    /// Triangles, counter-clockwise seen from the positive side.
    pub faces: Vec<[u32; 3]>,
    /// The lattice edge of each vertex: its lower node and its axis (0, 1, 2); or the lowest corner of a cell and
    /// [`CELL_CENTRE`] for a vertex inside that cell.
    pub edges: Vec<([i32; 3], u8)>,
}

/// The zero level of `value` within the given cells; a cell is given by its lowest corner.
///
/// Negative values are inside; a node exactly at the level is outside. Each lattice edge that the surface passes
/// through has one vertex, by linear interpolation and at least [`NODE_CLEARANCE`] from the nodes. Cell faces whose
/// corners alternate in sign are decided by the bilinear saddle of their four values, so that neighbouring cells agree.
/// Vertices and faces are in the order of `cells`, which must not contain duplicates.
pub fn marching_cubes(cells: &[[i32; 3]], value: impl Fn([i32; 3]) -> f64) -> IsoSurface {
    let mut builder = Builder::<EdgeMap>::default();
    let mut corner = [0.0; 8];
    let mut last = None;
    for &cell in cells {
        // The next cell along x shares four corners with this one.
        let follows = last == Some([cell[0].wrapping_sub(1), cell[1], cell[2]]);
        for i in 0..8 {
            let shared = follows && i & 1 == 0;
            corner[i] = if shared {
                corner[i + 1]
            } else {
                value(add(cell, CORNER[i]))
            };
        }
        last = Some(cell);
        let case = (0..8).fold(0, |bits, i| bits | u8::from(corner[i] < 0.0) << i);
        if case != 0 && case != 255 {
            builder.cell(cell, &corner, case);
        }
    }
    builder.surface
}

/// Vertex numbers on lattice edges.
trait EdgeNumbers {
    /// The number of the vertex on an edge of a cell; assigns `fresh` if the edge has no vertex.
    fn number(&mut self, cell: [i32; 3], edge: usize, fresh: u32) -> u32;
}

/// Vertex numbers for cells in any order.
#[derive(Default)]
struct EdgeMap(FxHashMap<EdgeKey, u32>);

impl EdgeNumbers for EdgeMap {
    fn number(&mut self, cell: [i32; 3], edge: usize, fresh: u32) -> u32 {
        let node = add(cell, CORNER[EDGE_NODE[edge] as usize]);
        let key = EdgeKey(node, EDGE_AXIS[edge]);
        *self.0.entry(key).or_insert(fresh)
    }
}

#[derive(Default)]
struct Builder<N> {
    surface: IsoSurface,
    numbers: N,
}

impl<N: EdgeNumbers> Builder<N> {
    fn cell(&mut self, cell: [i32; 3], corner: &[f64; 8], case: u8) {
        for lp in table().loops(case, corner) {
            let mut polygon = Polygon::default();
            for &e in lp {
                let vertex = self.vertex(cell, e as usize, corner);
                polygon.push(e, vertex, self.surface.positions[vertex as usize]);
            }
            if !polygon.triangulate(&mut self.surface.faces) {
                self.fan(cell, &polygon);
            }
        }
    }

    fn vertex(&mut self, cell: [i32; 3], edge: usize, corner: &[f64; 8]) -> u32 {
        let surface = &mut self.surface;
        let fresh = surface.positions.len() as u32;
        let number = self.numbers.number(cell, edge, fresh);
        if number == fresh {
            let axis = EDGE_AXIS[edge];
            let low = EDGE_NODE[edge] as usize;
            let node = add(cell, CORNER[low]);
            let (a, b) = (corner[low], corner[low | 1 << axis]);
            let t = a / (a - b);
            let t = if t.is_finite() {
                t.clamp(NODE_CLEARANCE, 1.0 - NODE_CLEARANCE)
            } else {
                0.5
            };
            let mut p = as_point(node);
            p[axis as usize] += t;
            surface.positions.push(p);
            surface.edges.push((node, axis));
        }
        number
    }

    /// Adds a fan around the polygon's centroid, for a polygon without an admissible triangulation.
    fn fan(&mut self, cell: [i32; 3], polygon: &Polygon) {
        let centre = self.surface.positions.len() as u32;
        self.surface.positions.push(polygon.centroid());
        self.surface.edges.push((cell, CELL_CENTRE));
        polygon.fan(centre, &mut self.surface.faces);
    }
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct EdgeKey([i32; 3], u8);
