//! `isomend inspect`: what a mesh holds.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use isomend::Inspection;
use isomend::io::Loaded;
use isomend::mesh::mask::Selection;
use isomend::report::{chain_lines, defect_lines, hole_table};

use super::console::{self, Console};
use super::json::{InspectDocument, Target, bounds};
use super::mask::MaskArgs;
use super::{CommonArgs, End, input};

const EXAMPLES: &str = "\
Examples:
  isomend inspect scan.ply                  a table of the holes, with their numbers
  isomend inspect scan.ply --json - | jq '.holes[].diameter'
  isomend inspect scan.ply --ball 10,4,2,3.5 --grow 1   what a mask marks";

/// List the pieces, holes and defects of a mesh.
///
/// Lengths are in the mesh's units. Planarity is the distance of the rim from its best plane, as root mean square over
/// the hole's diameter: 0 is planar.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct InspectArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy or VTP; `-` is standard input.
    #[arg(value_name = "IN")]
    input: PathBuf,

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
    let loaded = input::read(&args.input, args.common.from, console)?;
    let found = isomend::inspect(&loaded.mesh)
        .with_context(|| format!("cannot inspect {}", input::shown(&args.input)))?;
    let marked = args.mask.faces(&loaded)?;
    let mask = marked.map(|marked| Selection::new(&loaded.mesh, &marked));
    if let Some(json) = &args.common.json {
        json.write(&InspectDocument::new(
            &args.input,
            &loaded,
            &found,
            mask.as_ref(),
        ))?;
    }
    if !matches!(args.common.json, Some(Target::Stdout)) {
        let mut text = table(&loaded, &found);
        if let Some(mask) = &mask {
            text += &mask_line(mask);
        }
        console::print(&text).context("cannot write to standard output")?;
    }
    Ok(End::Done)
}

fn mask_line(mask: &Selection) -> String {
    let Some([low, high]) = mask.bounds else {
        return "\nmask: no faces\n".to_owned();
    };
    let pieces = if mask.pieces == 1 { "piece" } else { "pieces" };
    format!(
        "\nmask: {} faces in {} {pieces}, area {:.6}, from {:.5}, {:.5}, {:.5} to {:.5}, {:.5}, {:.5}\n",
        mask.faces, mask.pieces, mask.area, low.x, low.y, low.z, high.x, high.y, high.z
    )
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
