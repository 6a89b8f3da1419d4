//! The engine's rooms, open to the project's own tests, benchmarks, fuzz targets and Python module. They may change in any release.

/// See the source.
pub mod attributes {
    pub use crate::attributes::*;
}
/// See the source.
pub mod extract {
    pub use crate::extract::*;
}
/// See the source.
pub mod finish {
    pub use crate::finish::*;
}
/// See the source.
pub mod flow {
    pub use crate::flow::*;
}
/// See the source.
pub mod grid {
    pub use crate::grid::*;
}
/// See the source.
pub mod linalg {
    pub use crate::linalg::*;
}
/// See the source.
pub mod mesh {
    pub use crate::mesh::*;
}
/// See the source.
pub mod parameters {
    pub use crate::parameters::solve::*;
}
/// See the source.
pub mod region {
    pub use crate::region::*;
}
/// See the source.
pub mod sdf {
    pub use crate::sdf::*;
}
/// See the source.
pub mod spatial {
    pub use crate::spatial::*;
}
/// See the source.
pub mod stitch {
    pub use crate::stitch::*;
}
/// See the source.
#[cfg(feature = "view")]
pub mod view {
    pub use crate::view::*;
}
