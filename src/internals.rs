//! The engine's rooms, open to the project's own tests, benchmarks, fuzz targets and Python module. They may change in any release.

/// A module for each room, with all that the room has.
macro_rules! open {
    ($($room:ident)*) => {$(
        /// See the source.
        pub mod $room {
            pub use crate::$room::*;
        }
    )*};
}

open! { attributes extract finish flow grid linalg mesh region sdf spatial stitch }
#[cfg(feature = "view")]
open! { view }

/// See the source.
pub mod parameters {
    pub use crate::parameters::solve::*;
}
