//! `isomend restore`: replaces a marked region.

use anyhow::{Context, bail};
use clap::Args;
use isomend::report::region_lines;
use isomend::{RestoreParams, Restored};

use super::batch::{Files, FilesArgs};
use super::console::Console;
use super::json::Cut;
use super::mask::MaskArgs;
use super::solve::{Mended, SolveArgs};
use super::{CommonArgs, End, arguments, progress};

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
    #[command(flatten)]
    files: FilesArgs,

    /// How much of the damaged shape to keep, from 0 (nothing) to 1 (all that the grid can hold).
    ///
    /// With W the flow starts from the damaged surface and is pulled to it: features narrower than about (1 - W) / W times
    /// the diameter of the region go, wider ones stay.
    #[arg(long, value_name = "W", default_value = "0", value_parser = arguments::part)]
    keep_shape: f64,

    #[command(flatten)]
    solve: SolveArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,

    // Last, since what follows it would stand under its heading.
    #[command(flatten)]
    mask: MaskArgs,
}

/// Reads, cuts, fills, writes.
pub fn run(args: &RestoreArgs, console: &Console) -> anyhow::Result<End> {
    if args.mask.mask()?.is_none() {
        bail!("no region is marked; give --ball, --box, --mask, --faces, --colour or --material");
    }
    args.solve.check()?;
    args.files.each("restore", &args.common, console, |files| {
        one(args, files, console)
    })
}

fn one(args: &RestoreArgs, files: &Files<'_>, console: &Console) -> anyhow::Result<End> {
    let loaded = files.read(args.common.from, console)?;
    let marked = args.mask.marked(&loaded)?.context("no region is marked")?;
    let marked = marked.some()?;
    // A glTF document goes through as it is, and so do the numbers of its vertices.
    let params = RestoreParams {
        fill: args.solve.params(),
        keep_shape: args.keep_shape,
        keep_vertices: files.to_gltf() && loaded.document.is_some(),
    };
    let failed = "cannot restore the marked region";
    if files.output.is_none() {
        let plan = isomend::plan_restore(&loaded.mesh, &marked, &params).context(failed)?;
        let cut = Cut {
            marked_faces: plan.marked_faces,
            removed_faces: plan.removed_faces,
            removed_vertices: plan.removed_vertices,
            keep_shape: args.keep_shape,
        };
        return files.preview(&loaded, &plan.fill, Some(cut));
    }
    let mut restored = progress::watched(console, region_lines, |progress| {
        isomend::restore_with_progress(&loaded.mesh, &marked, &params, progress)
    })
    .context(failed)?;
    let cut = tell(&restored, console);
    let before = files.before(&loaded, &restored.kept);
    let done = Mended {
        mesh: restored.mesh,
        first: &loaded.restricted(&restored.kept),
        params: &params.fill,
        report: &mut restored.report.fill,
        cut: Some(cut),
        before,
        strict: args.solve.strict,
    };
    files.finish(done, console)
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
