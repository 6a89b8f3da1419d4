//! From file to file: read, mark, mend, round, carry over, check what is written, write.
//!
//! The command line, and whatever else takes files, does this and nothing of its own: a [`JobSpec`] says what is wanted,
//! [`run`] does it, a [`JobResult`] says what came of it, as values and as the JSON document of the command line.
//!
//! ```no_run
//! use isomend::job::{JobSpec, Work, run};
//! use isomend::{Control, FillParams};
//!
//! let mut params = FillParams::default();
//! params.max_diameter = Some(20.0);
//! let spec = JobSpec::new("scan.ply", "mended.glb", Work::Fill(params))?;
//! let result = run(&spec, &Control::new())?;
//! println!("{} holes, {} still open", result.report.holes.len(), result.report.tally().failed);
//! println!("{}", serde_json::to_string_pretty(&result.document()).unwrap());
//! # Ok::<(), isomend::job::JobError>(())
//! ```
//!
//! A [`Batch`] is the same for several files, into a folder, with one document for all.
//! [`JobSpec::read`], [`Read::mend`] and [`Mended::write`] are its three steps, for those who tell something in between.
//! [`inspect`] makes the document of what a mesh holds, [`check`] that of what is wrong with it, [`compare`] that of two meshes,
//! [`measure`] that of a signed distance volume. A [`SurfaceSpec`] goes from a volume to the surface at one of its levels.

mod batch;
mod deliver;
mod documents;
mod draw;
mod error;
mod hash;
mod inspection;
mod marks;
mod mended;
mod outcome;
mod output;
mod places;
mod read;
mod result;
mod spec;
mod steps;
mod surface;
mod template;
mod unchanged;
mod volumes;

pub use batch::{Batch, BatchObserver, BatchResult};
pub use deliver::{Deliverables, Mark};
pub use documents::{Document, FileInfo};
pub use draw::Drawings;
pub use error::JobError;
pub use inspection::{Checked, Compared, Inspected, check, compare, inspect};
pub use marks::{Marked, MaskSpec, PaintedColour, parse_face_numbers};
pub use mended::Mended;
pub use outcome::{JobPlan, JobResult, WorkPlan};
pub use output::Output;
pub use places::Place;
pub use read::Source;
pub use result::{Extent, Kept};
pub use spec::{JobSpec, Work};
pub use steps::{Read, run};
pub use surface::{SurfaceResult, SurfaceSpec};
pub use unchanged::Unchanged;
pub use volumes::{MeasuredFile, VolumeSeconds, measure, write_volume};

#[cfg_attr(not(feature = "cli"), allow(unused_imports))]
pub(crate) use {output::write_text, volumes::DISTANCE};
