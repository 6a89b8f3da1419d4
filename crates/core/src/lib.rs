//! The engine of isomend: from a mesh and parameters to a mended mesh and a report.
//!
//! The package `isomend` is the interface to it and names what is public. The modules here are public for the packages of this
//! workspace and may change in any release. They know no files and no command line.
#![warn(missing_docs)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

// Hidden from the documentation: the facade names what is public of these modules. Each is declared by itself, so that rustfmt finds it.
#[doc(hidden)]
pub mod attributes;
#[doc(hidden)]
pub mod cancel;
#[doc(hidden)]
pub mod creases;
#[doc(hidden)]
pub mod elementary;
#[doc(hidden)]
pub mod extract;
#[doc(hidden)]
pub mod fill;
#[doc(hidden)]
pub mod finish;
#[doc(hidden)]
pub mod flow;
#[doc(hidden)]
pub mod grid;
#[doc(hidden)]
pub mod linalg;
#[doc(hidden)]
pub mod mend;
#[doc(hidden)]
pub mod mesh;
#[doc(hidden)]
pub mod region;
#[doc(hidden)]
pub mod repair;
#[doc(hidden)]
pub mod sdf;
#[doc(hidden)]
pub mod spatial;
#[doc(hidden)]
pub mod stitch;
#[doc(hidden)]
pub mod threads;
#[doc(hidden)]
pub mod tuning;

pub mod check;
pub mod compare;
pub mod parameters;
pub mod volume;

mod setters;

pub use glam;
