//! `isomend fill`: find holes and fill them.

use clap::Args;
use isomend::job::Work;
use isomend::{FillParams, RepairParams, SurfaceKind};
use serde_json::Value;

use super::console::Console;
use super::deliver::DeliverArgs;
use super::files::{FilesArgs, Task};
use super::parameters::{Fill, ParameterArgs};
use super::{CommonArgs, End, Usage, solve};

const EXAMPLES: &str = "\
Examples:
  isomend fill scan.ply -o mended.glb               fill all holes
  isomend fill scan.ply -o mended.ply --holes 2,5   fill two of them, by the numbers of `isomend inspect`
  isomend fill scan.ply -o mended.ply --max-diameter 20 --keep-open 4
  isomend fill vase.obj -o vase.obj --bridge 1+2    rebuild the wall between two facing rims
  isomend fill bust.ply -o bust.ply --flat 1        close the cut neck by a flat cap
  isomend fill part.stl -o part.stl --crease 1+2    continue a sharp edge between two ends that `isomend inspect -v` numbers
  isomend fill scan.stl -o mended.stl --json - -q   a report for a script
  isomend fill scan.ply --dry-run                   only say what would be filled
  isomend fill a.ply b.ply c.obj -o mended/         several, into a folder
  isomend fill - -o - --to stl < a.ply > mended.stl";

/// Find holes and fill them.
///
/// All holes are filled by default, save the outer border of an open sheet. The mesh's own vertices and faces stay bit
/// for bit and in order; new ones come after them.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct FillArgs {
    #[command(flatten)]
    files: FilesArgs,

    #[command(flatten)]
    parameters: ParameterArgs<Fill>,

    /// Exit with 3 unless every hole of more than four edges that was to be filled got a steady surface of the level set,
    /// joined to its rim, that crosses no face, and sharp edges that end at its rim were continued.
    #[arg(long)]
    strict: bool,

    #[command(flatten)]
    deliver: DeliverArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

impl FillArgs {
    /// What is to be done.
    ///
    /// # Errors
    /// When the options do not go together.
    pub(super) fn work(&self) -> anyhow::Result<Work> {
        let params: FillParams = self.parameters.params()?;
        solve::check(&params)?;
        if !self.parameters.flag("repair") {
            return Ok(Work::Fill(params));
        }
        if params.surface == SurfaceKind::Whole {
            let what = "--repair stitches patches into the mesh; --surface whole has the level sets alone, so leave one of them out";
            return Err(Usage(what.to_owned()).into());
        }
        Ok(Work::Repair(RepairParams {
            fill: params,
            ..RepairParams::default()
        }))
    }

    /// Whether a bound was given that has no effect, since the holes are named.
    fn bounds_named_holes(&self) -> bool {
        let names = self.parameters.value("holes").is_some_and(Value::is_array);
        names && self.parameters.value("max_diameter").is_some()
    }
}

/// Reads, fills, writes.
pub fn run(args: &FillArgs, console: &Console) -> anyhow::Result<End> {
    let work = args.work()?;
    if args.bounds_named_holes() {
        console.note("--max-diameter does nothing here: --holes names the holes that are filled");
    }
    let task = Task {
        work,
        common: &args.common,
        strict: args.strict,
        deliverables: args.deliver.deliverables()?,
    };
    args.files.each(&task, console)
}
