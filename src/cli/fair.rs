//! `isomend fair`: fairs (smooths) a surface, or a marked region of it, by Willmore flow.

use clap::Args;
use isomend::job::{Deliverables, Work};

use super::console::Console;
use super::files::{FilesArgs, Task};
use super::mask::MaskArgs;
use super::parameters::{Fair, ParameterArgs};
use super::{CommonArgs, End, Usage};

const EXAMPLES: &str = "\
Examples:
  isomend fair scan.ply -o out.ply                               remove features narrower than eight mean edges
  isomend fair scan.ply -o out.ply --strength 2.5                remove features narrower than 2.5
  isomend fair scan.ply -o out.ply --strength 4 --ball 10,4,2,9  in a ball only; the rest stays bit for bit
  isomend fair torus.ply -o out.ply --time 0.02                  Willmore flow for a given time";

/// Fair the whole surface, or a marked region.
///
/// The surface evolves by Willmore flow for a given time: noise and small features disappear; spheres, minimal surfaces and large forms
/// stay. A closed mesh is replaced as a whole by the faired surface, with new triangles. A marked region is cut out and replaced by its
/// faired surface; the rest stays bit for bit and in order. An open mesh keeps a strip along its boundary.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct FairArgs {
    #[command(flatten)]
    files: FilesArgs,

    #[command(flatten)]
    parameters: ParameterArgs<Fair>,

    #[command(flatten)]
    mask: MaskArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

impl FairArgs {
    /// The work that these options ask for.
    ///
    /// # Errors
    /// If options conflict.
    pub(super) fn work(&self) -> anyhow::Result<Work> {
        Ok(Work::Fair(
            self.mask.mask().map_err(Usage)?,
            self.parameters.params()?,
        ))
    }
}

/// Reads, fairs and writes each mesh.
pub fn run(args: &FairArgs, console: &Console) -> anyhow::Result<End> {
    let task = Task {
        work: args.work()?,
        common: &args.common,
        strict: false,
        deliverables: Deliverables::default(),
    };
    args.files.each(&task, console)
}
