//! `isomend restore`: cuts out a marked region and fills it.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use isomend::RestoreParams;
use isomend::job::Work;

use super::arguments;
use super::console::Console;
use super::deliver::{self, DeliverArgs};
use super::files::{FilesArgs, Task};
use super::mask::MaskArgs;
use super::parameters::{ParameterArgs, Restore};
use super::{CommonArgs, End, Usage};

const EXAMPLES: &str = "\
Examples:
  isomend restore scan.ply -o out.ply --ball 10,4,2,3.5          replace the surface in a ball
  isomend restore scan.ply -o out.ply --colour ff0000,40 --grow 1   replace red faces and a margin around them
  isomend restore scan.ply -o out.ply --box 0,0,0,9,9,2 --keep-shape 0.9   smooth it, but keep its shape
  isomend restore bust.stl -o bust.ply --ball 0,9,2,3 --piece nose.stl --mark hatch   the missing piece, to print
  isomend inspect scan.ply --ball 10,4,2,3.5                     show what a mask marks";

/// Replace a marked region of the surface.
///
/// The marked faces are cut out along edges, and the region is filled as by `isomend fill`: the patch continues its surroundings. Holes
/// in the region or at its rim are filled with it; other holes stay. All other faces and their vertices stay bit for bit and in order;
/// vertices that only marked faces used are removed.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct RestoreArgs {
    #[command(flatten)]
    files: FilesArgs,

    #[command(flatten)]
    parameters: ParameterArgs<Restore>,

    /// Exit with 3 unless every hole of more than four edges that was to be filled is closed well: by a surface that continues its
    /// surroundings, or as asked for, that intersects no other face. The holes that are not are named.
    #[arg(long)]
    strict: bool,

    /// Write the missing piece, to print: the solid between the faces that were cut out and the patches. Exit with 3 if there is none.
    ///
    /// The piece has the rim of the patch, is watertight and has no self-intersections. It contains only the volume where the patch is above
    /// the faces that were cut out.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    piece: Option<PathBuf>,

    /// Move the contact surface of the piece inward by this length, in the mesh's units, so that a printed piece goes in.
    ///
    /// The contact surface is made of the faces that were cut out. The rim of the patch stays.
    #[arg(long, value_name = "LENGTH", value_parser = arguments::positive, requires = "piece")]
    clearance: Option<f64>,

    #[command(flatten)]
    deliver: DeliverArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,

    #[command(flatten)]
    mask: MaskArgs,
}

impl RestoreArgs {
    /// The work that these options ask for.
    ///
    /// # Errors
    /// If no region is marked or options conflict.
    pub(super) fn work(&self) -> anyhow::Result<Work> {
        let Some(mask) = self.mask.mask().map_err(Usage)? else {
            let what =
                "no region is marked; give --ball, --box, --mask, --faces, --colour or --material";
            return Err(Usage(what.to_owned()).into());
        };
        let params: RestoreParams = self.parameters.params()?;
        Ok(Work::Restore(mask, params))
    }
}

/// Reads, restores and writes each mesh.
pub fn run(args: &RestoreArgs, console: &Console) -> anyhow::Result<End> {
    let mut deliverables = args.deliver.deliverables()?;
    deliverables.piece = args.piece.as_deref().map(deliver::output).transpose()?;
    deliverables.clearance = args.clearance;
    let task = Task {
        work: args.work()?,
        common: &args.common,
        strict: args.strict,
        deliverables,
    };
    args.files.each(&task, console)
}
