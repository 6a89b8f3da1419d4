//! `isomend compare`: two meshes beside each other.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use isomend::compare::{Comparison, Distances, SurfaceFacts, compare};
use isomend::report::{length, point};
use serde::Serialize;

use super::console::{self, Console};
use super::input::is_stream;
use super::json::{FileInfo, Target};
use super::{CommonArgs, End, Usage, arguments, input};

const EXAMPLES: &str = "\
Examples:
  isomend compare scan.ply mended.ply               what of the scan is kept, and how far the rest is
  isomend compare truth.ply mended.ply --json -";

/// Compare two meshes: distances both ways, normals, bending energy, what of A is kept in B.
///
/// Distances are in the meshes' units, from samples spread evenly over the area; the largest also looks at every vertex.
/// The bending energy is half the integral of h squared, h the sum of the principal curvatures: 8 pi for a sphere.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct CompareArgs {
    /// The first mesh; one of the two may be `-`, standard input.
    #[arg(value_name = "A")]
    a: PathBuf,

    /// The second mesh.
    #[arg(value_name = "B")]
    b: PathBuf,

    /// Samples on each mesh, at most 100 million.
    #[arg(long, value_name = "N", default_value = "100000", value_parser = arguments::samples)]
    samples: usize,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// The report of `isomend compare`.
#[derive(Serialize)]
struct CompareDocument<'a> {
    command: &'static str,
    version: &'static str,
    first: FileInfo,
    second: FileInfo,
    #[serde(flatten)]
    comparison: &'a Comparison,
}

/// Reads both and compares.
pub fn run(args: &CompareArgs, console: &Console) -> anyhow::Result<End> {
    if let Some(json) = &args.common.json {
        json.check(&[&args.a, &args.b], &[])?;
    }
    if is_stream(&args.a) && is_stream(&args.b) {
        return Err(Usage("only one of the two meshes can be standard input".to_owned()).into());
    }
    let a = input::read(&args.a, args.common.from, console)?;
    let b = input::read(&args.b, args.common.from, console)?;
    let comparison = compare(&a.mesh, &b.mesh, args.samples).with_context(|| {
        format!(
            "cannot compare {} with {}",
            input::shown(&args.a),
            input::shown(&args.b)
        )
    })?;
    if let Some(json) = &args.common.json {
        json.write(&CompareDocument {
            command: "compare",
            version: env!("CARGO_PKG_VERSION"),
            first: FileInfo::new(&args.a, a.format, &a.mesh),
            second: FileInfo::new(&args.b, b.format, &b.mesh),
            comparison: &comparison,
        })?;
    }
    if !matches!(args.common.json, Some(Target::Stdout)) {
        console::print(&table(&comparison)).context("cannot write to standard output")?;
    }
    Ok(End::Done)
}

fn table(c: &Comparison) -> String {
    let facts = |name: &str, s: &SurfaceFacts| {
        format!(
            "{name}: {} vertices, {} faces, area {}, bending energy {:.4} without {} border vertices\n",
            s.vertices,
            s.faces,
            length(s.area),
            s.willmore_energy,
            s.border_vertices
        )
    };
    // Of the order of the model: coordinates that are much smaller are rounding.
    let size = c.a.area.sqrt();
    let row = |name: &str, d: &Distances| {
        format!(
            "{name:>7} {:>12.4e} {:>12.4e} {:>12.4e} {:>12.3} {:>12.3}  {}\n",
            d.max,
            d.rms,
            d.mean,
            d.normal_mean,
            d.normal_max,
            point(d.max_at, size)
        )
    };
    let k = &c.kept;
    facts("A", &c.a)
        + &facts("B", &c.b)
        + "\n"
        + &console::heading(&format!(
            "{:>7} {:>12} {:>12} {:>12} {:>12} {:>12}  {}",
            "", "max", "rms", "mean", "angle mean", "angle max", "where it is largest"
        ))
        + "\n"
        + &row("A to B", &c.a_to_b)
        + &row("B to A", &c.b_to_a)
        + &format!(
            "\nof A in B, bit for bit: {} of {} vertices, the first {} with the same number; {} of {} faces, the first {}\n",
            k.vertices, c.a.vertices, k.vertices_in_order, k.faces, c.a.faces, k.faces_in_order
        )
}
