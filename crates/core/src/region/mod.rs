//! A region, the holes that are filled together: grouping, lattice, distance data, nested level-set solve, zero set.

mod cap;
mod data;
mod distance;
mod group;
mod level;
mod nested;
mod sampling;
mod sphere;
#[cfg(test)]
mod tests;
mod zero_set;

pub use cap::CappedRims;
pub use data::{KeptShape, LevelSurface, MeshData};
pub use distance::{DistanceData, NodeData, Wanted};
pub use group::{BoxSize, Region, VoxelSize, group_holes, group_named};
pub use level::Level;
pub use nested::{LevelReport, NestedSettings, Solved, Start, TimeSpan, solve_nested};
pub use sphere::Sphere;
