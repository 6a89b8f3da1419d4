//! isomend fills holes in triangle meshes by 3D level-set Willmore flow.
//!
//! The neighbourhood of each hole is voxelised into a signed distance field. The missing part evolves by Willmore flow to its
//! steady state, with position and normal of the surroundings held fixed. The patch is extracted, joined to the rim and meshed
//! like its surroundings. Patches therefore continue the curvature of their surroundings: a hole in a sphere is closed by a part
//! of that sphere, and the same holds for the other surfaces that are critical points of the Willmore energy `∫ H² dA`.
//!
//! ```
//! use std::f64::consts::PI;
//! use isomend::glam::DVec3;
//! use isomend::{FillParams, Mesh, fill};
//!
//! // A sphere of radius 1 without its top: rings of 24 vertices each.
//! let (rings, around) = (9, 24);
//! let mut mesh = Mesh::new(vec![-DVec3::Z], Vec::new());
//! for ring in 1..=rings {
//!     let latitude = PI * f64::from(ring) / 12.0 - PI / 2.0;
//!     for i in 0..around {
//!         let angle = 2.0 * PI * (f64::from(i) + 0.5 * f64::from(ring)) / f64::from(around);
//!         let (y, x) = angle.sin_cos();
//!         mesh.positions.push(DVec3::new(x * latitude.cos(), y * latitude.cos(), latitude.sin()));
//!     }
//! }
//! let vertex = |ring: u32, i: u32| 1 + (ring - 1) * 24 + i % 24;
//! for i in 0..24 {
//!     mesh.faces.push([0, vertex(1, i + 1), vertex(1, i)]);
//!     for ring in 1..9 {
//!         let [a, b] = [vertex(ring, i), vertex(ring, i + 1)];
//!         let [c, d] = [vertex(ring + 1, i), vertex(ring + 1, i + 1)];
//!         mesh.faces.extend([[a, b, c], [b, d, c]]);
//!     }
//! }
//!
//! let filled = fill(&mesh, &FillParams::default())?;
//! assert!(!filled.report.incomplete());
//! assert_eq!(filled.mesh.faces[..mesh.faces.len()], mesh.faces);
//! for new in &filled.mesh.positions[mesh.positions.len()..] {
//!     assert!((new.length() - 1.0).abs() < 0.02);
//! }
//! # Ok::<(), isomend::FillError>(())
//! ```
//!
//! # Guarantees
//! - Every vertex and face of the input is kept, bit for bit and in order; new vertices and faces follow them.
//! - A filled hole is closed by a manifold patch that shares the rim's edges and is oriented like its surroundings.
//! - Every hole is listed in the [`FillReport`]: closed and how, left as asked, or open, with the reason.
//! - Every run ends, and the result is the same, to the byte, for any number of threads.
//!
//! # Limits
//! - A patch does not restore texture. It is smooth, apart from sharp edges that end at the rim: they are continued where they
//!   predict the surrounding faces better than a smooth patch ([`Sharp`]).
//! - A patch is checked for intersections with the mesh's faces; intersections that cannot be avoided are reported.
//! - A fill closes holes and mends no other defects: edges with more than two faces, misoriented faces and self-intersections of
//!   the input are reported and stay. [`repair`] mends them as far as cutting out and filling can; its report lists the rest.
//!
//! # Entry points
//! - [`fill`], [`restore`], [`fair`] and [`repair`] take a mesh and parameters ([`restore`] and [`fair`] also the marked faces), and
//!   return a mesh and a report.
//! - [`Inspection::check`] lists the defects of a mesh and gives one verdict.
//! - [`Inspection`] analyses a mesh once; plans and runs use it, with a [`Control`] of threads, progress and cancelling.
//!   [`Inspection::regions`] returns the work on each region as a value that can be processed anywhere.
//! - [`Model::inspect`] and [`Model::mended`] carry colours, normals, texture coordinates and materials along.
//! - `job` works from file to file, like the command line; `io` converts files and bytes to meshes and back (feature `io`).
//!
//! [`restore`] cuts out marked faces, which a [`Mask`] may choose, and fills the gap; all other faces are kept as above.
//! [`RestoreParams::keep_shape`] keeps part of the old shape. All lengths are in the units of the mesh.
//!
//! # Features
//! The core without features needs no file format and no command line. `io` reads and writes files, works from file to file and
//! draws pages and pictures, `study` holds the experiments of the paper, `view` serves the local page; `cli`, the default, enables
//! all of them and the program.
//!
//! # Source
//! M. Droske, M. Rumpf, "A level set formulation for Willmore flow", Interfaces and Free Boundaries 6 (2004) 361–378.
#![warn(missing_docs)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

// The command line names the library as other callers do.
#[cfg(feature = "cli")]
extern crate self as isomend;

#[cfg(feature = "cli")]
mod cli;

#[doc(no_inline)]
pub use glam;

#[cfg(feature = "cli")]
#[doc(hidden)]
pub use cli::main as command_line;
pub use isomend_core::attributes::transfer;
pub use isomend_core::cancel::Cancel;
pub use isomend_core::{check, compare, parameters, volume};
#[cfg(feature = "io")]
pub use isomend_files::{io, job, report};
/// The experiments of the paper on Willmore flow: see [`experiments`](study::experiments).
#[cfg(feature = "study")]
pub mod study {
    #[doc(inline)]
    pub use isomend_study::*;
}
/// The local page in a browser that runs the program itself, for the module of WebAssembly: no part of the interface.
#[cfg(all(feature = "cli", target_family = "wasm"))]
#[doc(hidden)]
pub mod in_browser {
    pub use crate::cli::{CommandLine, report_progress};
    pub use isomend_view::InBrowser;
}
pub use isomend_core::extract::{VolumeSurfaceError, level_surface};
pub use isomend_core::fill::{
    AttemptFailure, Closure, CounterpartKind, CounterpartReport, CreaseReport, FillParams, Finish,
    FinishReport, GrainReport, HoleOutcome, LeftReason, Like, NotContinued, NotLike, NotSmooth,
    OpenReason, PatchInitialisation, Quality, RegionPatch, RegionReport, Sharp, Tally,
};
pub use isomend_core::finish::{FinishRecord, FinishResult, Refusal};
pub use isomend_core::flow::{BendingEnergy, Density, Energy, FlowOutcome, StepRecord, Variant};
pub use isomend_core::grid::Volume;
pub use isomend_core::mend::{
    Control, CreaseEnd, Event, FairError, FairExtent, FairParams, FairPlan, FairReport, Faired,
    FillError, FillPlan, FillReport, Filled, HoleReport, Inspection, PlannedHole, PlannedRegion,
    Progress, RegionTask, Regions, RestoreError, RestoreParams, RestorePlan, RestoreReport,
    Restored, Step, fair, fill, inspect, restore,
};
pub use isomend_core::mesh::attributes::{
    Active, Attribute, Attributes, CornerAttribute, EXPECTED_ERROR_NAME, LabelKind, Labels,
    Material, PATCH_NAME, Role, Scalar,
};
pub use isomend_core::mesh::mask::{Mask, MaskError, Selection, Selector};
pub use isomend_core::mesh::triangulate::TriangulationError;
pub use isomend_core::mesh::{
    ChainReason, Defects, FaceOrigin, Hole, HoleId, Mesh, MeshError, Model, OpenChain, Origins,
    Topology, Unit, cut::Remainder,
};
pub use isomend_core::region::{LevelReport, VoxelSize};
pub use isomend_core::repair::{Carried, RepairParams, RepairReport, RepairStep, Repaired, repair};
pub use isomend_core::stitch::StitchError;

/// The examples of the documentation pages, run as tests.
#[cfg(all(doctest, feature = "cli"))]
mod pages {
    #[doc = include_str!("../README.md")]
    struct Readme;
    #[doc = include_str!("../docs/library.md")]
    struct Library;
}
