//! `isomend fair`: fairs a surface, or a marked region of it.

use clap::Args;
use isomend::job::{Deliverables, Work};

use super::console::Console;
use super::files::{FilesArgs, Task};
use super::mask::MaskArgs;
use super::parameters::{Fair, ParameterArgs};
use super::{CommonArgs, End};

const EXAMPLES: &str = "\
Examples:
  isomend fair scan.ply -o out.ply                               lose what is narrower than eight mean edges
  isomend fair scan.ply -o out.ply --strength 2.5                features narrower than 2.5 go
  isomend fair scan.ply -o out.ply --strength 4 --ball 10,4,2,9  in a ball only; all else stays bit for bit
  isomend fair torus.ply -o out.ply --time 0.02                  Willmore flow for a time";

/// Fair the whole surface, or a marked region.
///
/// The surface evolves by Willmore flow for a time: noise and small features go, spheres, minimal surfaces and large forms
/// stay. A closed mesh as a whole is replaced by the faired surface, remeshed. A marked region is cut out and what it
/// evolves to is joined to the rest, which stays bit for bit and in order. An open mesh keeps a strip along its borders.
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
    /// What is to be done.
    ///
    /// # Errors
    /// When the options do not go together.
    pub(super) fn work(&self) -> anyhow::Result<Work> {
        Ok(Work::Fair(self.mask.mask()?, self.parameters.params()?))
    }
}

/// Reads, fairs, writes.
pub fn run(args: &FairArgs, console: &Console) -> anyhow::Result<End> {
    let task = Task {
        work: args.work()?,
        common: &args.common,
        strict: false,
        deliverables: Deliverables::default(),
    };
    args.files.each(&task, console)
}
