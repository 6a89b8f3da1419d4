//! `isomend inspect`: what a mesh holds.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use isomend::Inspection;
use isomend::io::Loaded;
use isomend::mesh::mask::Selection;
use isomend::report::{chain_lines, defect_lines, hole_table, length, point};

use super::console::{self, Console};
use super::json::{InspectDocument, Target};
use super::mask::{Marked, MaskArgs};
use super::report::ReportArgs;
use super::{CommonArgs, End, input};

const EXAMPLES: &str = "\
Examples:
  isomend inspect scan.ply                  a table of the holes, with their numbers
  isomend inspect scan.ply --json - | jq '.holes[].diameter'
  isomend inspect scan.ply --report scan.html           the holes in a 3D view, with their numbers
  isomend inspect scan.ply --ball 10,4,2,3.5 --grow 1   what a mask marks";

/// List the pieces, holes and defects of a mesh.
///
/// Lengths are in the mesh's units. The normal is that of the rim's plane, out of the surface; the height is the rim's
/// extent along it. Planarity is the distance of the rim from its best plane, as root mean square over the hole's diameter:
/// 0 is planar.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct InspectArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy or VTP; `-` is standard input.
    #[arg(value_name = "IN")]
    input: PathBuf,

    #[command(flatten)]
    report: ReportArgs,

    #[command(flatten)]
    mask: MaskArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// Reads and lists.
pub fn run(args: &InspectArgs, console: &Console) -> anyhow::Result<End> {
    if let Some(json) = &args.common.json {
        json.check(&[&args.input], &[])?;
    }
    if args.report.is_wanted() {
        args.report
            .check(&args.input, None, args.common.json.as_ref())?;
    }
    let loaded = input::read(&args.input, args.common.from, console)?;
    let found = isomend::inspect(&loaded.mesh)
        .with_context(|| format!("cannot inspect {}", input::shown(&args.input)))?;
    let marked = args.mask.marked(&loaded)?;
    let selection = |marked: &Marked| Selection::new(&loaded.mesh, &marked.faces);
    let mask = marked.as_ref().map(selection);
    if let Some(json) = &args.common.json {
        json.write(&InspectDocument::new(
            &args.input,
            &loaded,
            &found,
            mask.as_ref(),
        ))?;
    }
    if args.report.is_wanted() {
        args.report.write_looked_at(&args.input, &loaded, &found)?;
    }
    if !matches!(args.common.json, Some(Target::Stdout)) {
        let mut text = table(&loaded, &found);
        if let (Some(mask), Some(marked)) = (&mask, &marked) {
            text += &mask_line(mask, &marked.missed);
        }
        console::print(&text).context("cannot write to standard output")?;
    }
    Ok(End::Done)
}

fn mask_line(mask: &Selection, missed: &[String]) -> String {
    let Some([low, high]) = mask.bounds else {
        return format!("\nmask: no faces: {}\n", missed.join("; "));
    };
    let pieces = if mask.pieces == 1 { "piece" } else { "pieces" };
    format!(
        "\nmask: {} faces in {} {pieces}, area {}, from {} to {}\n",
        mask.faces,
        mask.pieces,
        length(mask.area),
        point(low, low.distance(high)),
        point(high, low.distance(high)),
    )
}

fn table(loaded: &Loaded, found: &Inspection) -> String {
    let pieces = found.topology.piece_faces.len();
    let [low, high] = loaded.mesh.bounds();
    let size = high - low;
    let mut text = String::new();
    let mut line = |line: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{line}");
    };
    line(format!(
        "{}: {} vertices, {} faces, {} {}, {} {}; size {}",
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
        size.to_array().map(length).join(" x "),
    ));
    line(format!(
        "bounds: from {} to {}",
        point(low, size.length()),
        point(high, size.length())
    ));
    for defect in defect_lines(&found.topology.defects) {
        line(defect);
    }
    for chain in chain_lines(&found.open_chains) {
        line(chain);
    }
    if !found.holes.is_empty() {
        line(String::new());
        let mut rows = hole_table(&found.holes).into_iter();
        rows.next()
            .into_iter()
            .for_each(|head| line(console::heading(&head)));
        rows.for_each(line);
    }
    text
}
