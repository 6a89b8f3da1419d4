//! Jobs from mesh file to mesh file: read, mark faces, mend, round, transfer attributes, check the result and write it.
//!
//! The command line and all other front ends that work on files use this module. A [`JobSpec`] describes the work, [`run`] does it, and
//! a [`JobResult`] reports the outcome, as values and as the JSON document that the command line writes.
//!
//! ```no_run
//! use isomend::job::{JobSpec, Work, run};
//! use isomend::{Control, FillParams};
//!
//! let mut params = FillParams::default();
//! params.max_diameter = Some(20.0);
//! let spec = JobSpec::new("scan.ply", "mended.glb", Work::Fill(params))?;
//! let result = run(&spec, &Control::new())?;
//! println!("{} holes, {} still open", result.report.holes.len(), result.report.tally().open);
//! println!("{}", serde_json::to_string_pretty(&result.document()).unwrap());
//! # Ok::<(), isomend::job::JobError>(())
//! ```
//!
//! A [`Batch`] does the same for several files; it writes into a folder, with one document for all.
//! [`JobSpec::read`], [`Read::mend`] and [`Mended::write`] are the three steps of [`run`], for callers that report in between.
//! [`inspect`] documents the holes and properties of a mesh, [`check`] its defects, [`compare`] the distance of two meshes, and
//! [`measure`] a signed distance volume. A [`SurfaceSpec`] extracts the surface at a level of a volume.

mod batch;
mod bodies;
mod deliver;
mod documents;
mod draw;
mod each;
mod error;
mod hash;
mod inside_out;
mod inspection;
mod join;
mod marks;
mod mended;
mod named;
mod no_base;
mod outcome;
mod output;
mod paint;
mod painted;
mod places;
mod read;
mod result;
mod rounding;
mod spec;
mod staging;
mod steps;
mod stored;
mod surface;
mod template;
mod texels;
mod unchanged;
mod units;
mod volumes;

pub use batch::{Batch, BatchObserver, BatchResult};
pub use deliver::{Deliverables, Mark};
pub use documents::{Document, FileInfo};
pub use draw::Drawings;
pub use error::JobError;
pub use inspection::{Checked, Compared, Inspected, Looked, check, compare, inspect};
pub use marks::{Marked, MaskSpec, PaintedColour, parse_face_numbers};
pub use mended::Mended;
pub use outcome::{JobPlan, JobResult, WorkPlan};
pub use output::Output;
pub use places::Place;
pub use read::Source;
pub use result::{KeptElements, OperationReport};
pub use spec::{JobSpec, Work};
pub use steps::{Read, run};
pub use surface::{SurfaceResult, SurfaceSpec};
pub use unchanged::Unchanged;
pub use volumes::{MeasuredFile, VolumeSeconds, measure, write_volume};

pub use {
    each::default_plan, error::PANICKED, error::with_causes, hash::sha256, named::named_work,
    named::params_of, named::schema, staging::write_text, texels::INTERMEDIATE,
    units::contradiction, volumes::DISTANCE,
};
