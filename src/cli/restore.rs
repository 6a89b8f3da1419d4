//! `isomend restore`: replaces a marked region.

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::Args;
use isomend::io::{Format, Loaded};
use isomend::{RestoreError, RestoreParams, Restored};

use super::console::Console;
use super::json::Cut;
use super::mask::MaskArgs;
use super::report::{Before, ReportArgs};
use super::solve::{self, Files, SolveArgs};
use super::{CommonArgs, End, arguments};

const EXAMPLES: &str = "\
Examples:
  isomend restore scan.ply -o out.ply --ball 10,4,2,3.5          replace what lies in a ball
  isomend restore scan.ply -o out.ply --colour ff0000,40 --grow 1   what is painted red, and a margin
  isomend restore scan.ply -o out.ply --box 0,0,0,9,9,2 --keep-shape 0.9   smooth it, but keep its shape
  isomend inspect scan.ply --ball 10,4,2,3.5                     what a mask marks";

/// Replace a marked region of the surface.
///
/// The marked faces are cut out along edges, and the region is filled as by `isomend fill`: the patch continues what is
/// round it. Holes in the region or at its rim are filled with it, others stay. All other faces, and their vertices, stay
/// bit for bit and in order; vertices that only marked faces used go.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct RestoreArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy or VTP.
    #[arg(value_name = "IN")]
    input: PathBuf,

    /// The file to write, in the format of its extension.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,

    /// How much of the damaged shape to keep, from 0 (nothing) to 1 (all that the grid can hold).
    ///
    /// With W the flow starts from the damaged surface and is pulled to it: features narrower than about (1 - W) / W times
    /// the diameter of the region go, wider ones stay.
    #[arg(long, value_name = "W", default_value = "0", value_parser = arguments::part)]
    keep_shape: f64,

    #[command(flatten)]
    solve: SolveArgs,

    #[command(flatten)]
    report: ReportArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,

    // Last, since what follows it would stand under its heading.
    #[command(flatten)]
    mask: MaskArgs,
}

/// Reads, cuts, fills, writes.
pub fn run(args: &RestoreArgs, console: &Console) -> anyhow::Result<End> {
    let mut files = Files {
        command: "restore",
        input: &args.input,
        output: args.solve.output(&args.output)?,
        json: args.common.json.as_ref(),
        report: &args.report,
        before: None,
    };
    if args.mask.mask()?.is_none() {
        bail!("no region is marked; give --ball, --box, --mask, --faces, --colour or --material");
    }
    let loaded = files.read(args.common.from, console)?;
    args.solve.check()?;
    let marked = args.mask.faces(&loaded)?.unwrap_or_default();
    // A glTF document goes through as it is, and so do the numbers of its vertices.
    let gltf = matches!(files.output.format, Format::Gltf | Format::Glb);
    let params = RestoreParams {
        fill: args.solve.params(),
        keep_shape: args.keep_shape,
        keep_vertices: gltf && loaded.document.is_some(),
    };
    let restored = solve::watched(console, |progress| {
        isomend::restore_with_progress(&loaded.mesh, &marked, &params, progress)
    });
    let restored = match restored {
        Err(RestoreError::Fill(error)) => Err(error),
        Err(error) => return Err(error).context("cannot restore the marked region"),
        Ok(restored) => Ok(restored),
    };
    let Some(restored) = solve::unless_stopped(restored, console)? else {
        return Ok(End::Interrupted);
    };
    let cut = tell(&restored, console);
    files.before = args.report.is_wanted().then(|| Before {
        mesh: loaded.mesh.clone(),
        gone: restored.kept.faces.iter().map(|kept| !kept).collect(),
    });
    let kept = remaining(loaded, &restored);
    let fill = &restored.report.fill;
    files.finish(restored.mesh, &kept, &params.fill, fill, Some(cut), console)
}

/// The input without what was cut out.
fn remaining(loaded: Loaded, restored: &Restored) -> Loaded {
    let kept = &restored.kept;
    Loaded {
        mesh: kept.mesh.clone(),
        attributes: loaded
            .attributes
            .with_faces(&kept.faces)
            .with_vertices(&kept.vertices),
        ..loaded
    }
}

fn tell(restored: &Restored, console: &Console) -> Cut {
    let report = &restored.report;
    console.say(&format!(
        "{} faces marked, {} cut out",
        report.marked_faces, report.removed_faces
    ));
    Cut {
        marked_faces: report.marked_faces,
        removed_faces: report.removed_faces,
        removed_vertices: report.removed_vertices,
        keep_shape: report.keep_shape,
    }
}
