//! `isomend inspect`: what a mesh holds.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use isomend::Inspection;
use isomend::io::Loaded;
use isomend::report::{defect_lines, hole_table};

use super::console::{self, Console};
use super::json::{InspectDocument, Target, bounds};
use super::{CommonArgs, End, input};

const EXAMPLES: &str = "\
Examples:
  isomend inspect scan.ply                  a table of the holes, with their numbers
  isomend inspect scan.ply --json - | jq '.holes[].diameter'";

/// List the pieces, holes and defects of a mesh.
///
/// Lengths are in the mesh's units. Planarity is the distance of the rim from its best plane, as root mean square over
/// the hole's diameter: 0 is planar.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct InspectArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy or VTP.
    #[arg(value_name = "IN")]
    input: PathBuf,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// Reads and lists.
pub fn run(args: &InspectArgs, console: &Console) -> anyhow::Result<End> {
    if let Some(json) = &args.common.json {
        json.check(&[&args.input])?;
    }
    let loaded = input::read(&args.input, args.common.from, console)?;
    let found = isomend::inspect(&loaded.mesh)
        .with_context(|| format!("cannot inspect {}", args.input.display()))?;
    if let Some(json) = &args.common.json {
        json.write(&InspectDocument::new(&args.input, &loaded, &found))?;
    }
    if !matches!(args.common.json, Some(Target::Stdout)) {
        console::print(&table(&loaded, &found)).context("cannot write to standard output")?;
    }
    Ok(End::Done)
}

fn table(loaded: &Loaded, found: &Inspection) -> String {
    let pieces = found.topology.piece_faces.len();
    let [low, high] = bounds(&loaded.mesh);
    let size = high - low;
    let mut text = String::new();
    let mut line = |line: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{line}");
    };
    line(format!(
        "{}: {} vertices, {} faces, {} {}, {} {}; size {:.6} x {:.6} x {:.6}",
        loaded.format,
        loaded.mesh.positions.len(),
        loaded.mesh.faces.len(),
        pieces,
        if pieces == 1 { "piece" } else { "pieces" },
        found.holes.len(),
        if found.holes.len() == 1 {
            "hole"
        } else {
            "holes"
        },
        size.x,
        size.y,
        size.z,
    ));
    for defect in defect_lines(&found.topology.defects) {
        line(defect);
    }
    if found.open_chains > 0 {
        line(format!(
            "{} boundary chains that do not close",
            found.open_chains
        ));
    }
    if !found.holes.is_empty() {
        line(String::new());
        for row in hole_table(&found.holes) {
            line(row);
        }
    }
    text
}
