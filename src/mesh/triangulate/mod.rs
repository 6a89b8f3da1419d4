//! Triangulations of polygons and loops: in a plane, in space with the least angles between faces, and by cutting ears.

mod constrained;
mod ears;
mod loops;
mod planar;

pub(crate) use constrained::constrained_delaunay;
pub(crate) use ears::{Ground, cut_ears};
pub(crate) use loops::{Polygon, triangulate, triangulate_loop_beside};
pub use loops::{TriangulationError, triangulate_loop};
pub(crate) use planar::Triangulator;
