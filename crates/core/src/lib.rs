//! The engine of isomend: from a mesh and parameters to a mended mesh and a report.
//!
//! The package `isomend` is the interface to it and names what is public. The modules here are public for the packages of this
//! workspace and may change in any release. They know no files and no command line.
#![warn(missing_docs)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

/// Declares modules that are hidden from the documentation: the facade names what is public of them.
macro_rules! modules {
    ($($module:ident)*) => {$(
        #[doc(hidden)]
        pub mod $module;
    )*};
}

modules! {
    attributes cancel creases elementary extract fill finish flow grid linalg mend mesh region repair sdf spatial stitch threads tuning
}
pub mod check;
pub mod compare;
pub mod parameters;
pub mod volume;

mod setters;

pub use glam;
