//! `isomend repair`: what is wrong with a mesh is mended.

use clap::Args;
use isomend::RepairParams;
use isomend::job::Work;

use super::console::Console;
use super::deliver::DeliverArgs;
use super::files::{FilesArgs, Task};
use super::parameters::{ParameterArgs, Repair};
use super::{CommonArgs, End, solve};

const EXAMPLES: &str = "\
Examples:
  isomend repair scan.stl -o whole.stl              all that `isomend check` finds
  isomend repair scan.ply -o whole.ply --debris 0.01    without components of less than a hundredth of the largest one's area
  isomend repair part.stl -o part.stl --weld 0.001 --keep-holes
  isomend repair a.stl b.stl c.obj -o whole/        several, into a folder";

/// Mend what is wrong with a mesh: closed, manifold, oriented and free of crossings, where that can be had.
///
/// In this order: coinciding vertices are merged and degenerate and duplicate faces taken out; faces are turned so that they
/// agree, closed components outward; surfaces that meet in an edge or a vertex are separated, what cannot be is cut out; debris
/// is dropped where asked for; faces that cross others are cut out with a ring of faces round them, of doubled layers the
/// outer one stays; holes are filled as by `isomend fill`. Faces that are no part of a defect stay bit for bit and in order.
/// What is written is checked as by `isomend check`, and the exit code is that of it.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct RepairArgs {
    #[command(flatten)]
    files: FilesArgs,

    #[command(flatten)]
    parameters: ParameterArgs<Repair>,

    /// Exit with 3 unless every hole of more than four edges that was to be filled got a steady surface of the level set,
    /// joined to its rim, that crosses no face, and sharp edges that end at its rim were continued.
    #[arg(long)]
    strict: bool,

    #[command(flatten)]
    deliver: DeliverArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

impl RepairArgs {
    /// What is to be done.
    ///
    /// # Errors
    /// When the options do not go together.
    pub(super) fn work(&self) -> anyhow::Result<Work> {
        let params: RepairParams = self.parameters.params()?;
        solve::check(&params.fill)?;
        Ok(Work::Repair(params))
    }
}

/// Reads, repairs, writes.
pub fn run(args: &RepairArgs, console: &Console) -> anyhow::Result<End> {
    let task = Task {
        work: args.work()?,
        common: &args.common,
        strict: args.strict,
        deliverables: args.deliver.deliverables()?,
    };
    args.files.each(&task, console)
}
