//! Spatial queries on triangle meshes: bounding volume hierarchy, closest point, ray casting, exact intersection tests,
//! generalized winding number.

mod angles;
mod boxes;
mod build;
mod bvh;
mod crossings;
mod intersect;
mod oriented;
mod ploc;
mod predicates;
mod ray;
mod slender;
mod slivers;
mod triangle;
mod winding;

pub use boxes::{Bounds, BoxTree};
pub use build::middle;
pub use bvh::{Bvh, Closest};
pub(crate) use crossings::{coord3, turns};
pub use intersect::intersecting;
pub(crate) use intersect::{intersecting_pairs, partners};
pub(crate) use predicates::faces_intersect;
pub(crate) use triangle::meets;
pub use triangle::{Barycentric, closest_on_triangle};
pub use winding::WindingTree;
pub(crate) use winding::solid_angle;
