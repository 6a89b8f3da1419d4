//! Triangulations of polygons and loops: in a plane, in space with smallest angles between faces, and by ear cutting.

mod constrained;
mod ears;
mod loops;
mod planar;

pub(crate) use constrained::{constrained_between, constrained_delaunay};
pub(crate) use ears::{Ground, cut_ears};
pub(crate) use loops::{Polygon, triangulate, triangulate_loop_with_neighbours};
pub use loops::{TriangulationError, triangulate_loop};
pub use planar::Triangulator;
