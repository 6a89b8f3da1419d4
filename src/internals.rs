//! The engine's modules, for the project's own tests, benchmarks, fuzz targets and Python module. They may change in any release.

/// Re-exports all items of each named module.
macro_rules! open {
    ($($module:ident)*) => {$(
        /// See the source.
        pub mod $module {
            pub use crate::$module::*;
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
