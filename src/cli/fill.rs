//! `isomend fill`: finds holes and fills them.

use clap::Args;
use isomend::job::Work;
use serde_json::Value;

use super::console::Console;
use super::deliver::DeliverArgs;
use super::files::{FilesArgs, Task};
use super::parameters::{Fill, ParameterArgs};
use super::{CommonArgs, End};

const EXAMPLES: &str = "\
Examples:
  isomend fill scan.ply -o mended.glb               fill all holes
  isomend fill scan.ply -o mended.ply --holes 2,5   fill two holes, by the numbers of `isomend inspect`
  isomend fill scan.ply -o mended.ply --max-diameter 20 --keep-open 4
  isomend fill vase.obj -o vase.obj --bridge 1+2    rebuild the wall between two facing rims
  isomend fill bust.ply -o bust.ply --flat 1        close the cut neck by a flat cap
  isomend fill part.stl -o part.stl --crease 1+2    continue a sharp edge between two ends that `isomend inspect -v` numbers
  isomend fill scan.stl -o mended.stl --json - -q   a report for a script
  isomend fill scan.ply --dry-run                   only print what would be filled
  isomend fill a.ply b.ply c.obj -o mended/         several, into a folder
  isomend fill - -o - --to stl < a.ply > mended.stl";

/// Find holes and fill them.
///
/// By default all holes are filled, except the outer border of an open sheet. The vertices and faces of the input stay bit for bit and in
/// order; new vertices and faces are appended.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct FillArgs {
    #[command(flatten)]
    files: FilesArgs,

    #[command(flatten)]
    parameters: ParameterArgs<Fill>,

    /// Exit with 3 unless every hole of more than four edges that was to be filled is closed well: by a surface that continues its
    /// surroundings, or as asked for, that intersects no other face. The holes that are not are named.
    #[arg(long)]
    strict: bool,

    #[command(flatten)]
    deliver: DeliverArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

impl FillArgs {
    /// The work that these options ask for.
    ///
    /// # Errors
    /// If options conflict.
    pub(super) fn work(&self) -> anyhow::Result<Work> {
        Ok(Work::Fill(self.parameters.params()?))
    }

    /// Whether `--max-diameter` was given but has no effect, since `--holes` names the holes.
    fn bounds_named_holes(&self) -> bool {
        let names = self.parameters.value("holes").is_some_and(Value::is_array);
        names && self.parameters.value("max_diameter").is_some()
    }
}

/// Reads, fills and writes each mesh.
pub fn run(args: &FillArgs, console: &Console) -> anyhow::Result<End> {
    let work = args.work()?;
    if args.bounds_named_holes() {
        console.note("--max-diameter has no effect here: --holes names the holes to fill");
    }
    let task = Task {
        work,
        common: &args.common,
        strict: args.strict,
        deliverables: args.deliver.deliverables()?,
    };
    args.files.each(&task, console)
}
