//! Files of isomend: formats of meshes and volumes, textures, jobs from file to file, and reports.
//!
//! The package `isomend` is the interface to it and names what is public.
#![warn(missing_docs)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod io;
pub mod job;
#[allow(clippy::disallowed_methods)] // Drawings and texts, not meshes.
pub mod report;
#[doc(hidden)]
pub mod texture;
