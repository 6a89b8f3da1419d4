//! `isomend repair`: repairs the defects of a mesh and fills its holes.

use clap::Args;
use isomend::RepairParams;
use isomend::job::Work;

use super::console::Console;
use super::deliver::DeliverArgs;
use super::files::{FilesArgs, Task};
use super::parameters::{ParameterArgs, Repair};
use super::{CommonArgs, End};

const EXAMPLES: &str = "\
Examples:
  isomend repair scan.stl -o whole.stl              repair everything that `isomend check` finds
  isomend repair scan.ply -o whole.ply --debris 0.01    also remove components smaller than a hundredth of the largest one's area
  isomend repair part.stl -o part.stl --weld 0.001 --skip holes
  isomend repair scan.ply -o whole.ply --keep-open 4    repair, and fill all holes but one, by the numbers of `isomend inspect`
  isomend repair a.stl b.stl c.obj -o whole/        several, into a folder";

/// Repair a mesh: make it closed, manifold, oriented and free of self-intersections, as far as possible.
///
/// In this order: coinciding vertices are merged, and degenerate and duplicate faces are removed; faces are flipped so that neighbours
/// agree and closed components face outward; surfaces that meet in an edge or a vertex are separated, or cut out where that is not
/// possible; small components are removed with --debris; faces that intersect others are cut out with a ring of faces around them, and of
/// doubled layers the outer one stays; holes are filled as by `isomend fill`. Faces that belong to no defect stay bit for bit and in order.
/// The written file is checked as by `isomend check`, which also sets the exit code.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct RepairArgs {
    #[command(flatten)]
    files: FilesArgs,

    #[command(flatten)]
    parameters: ParameterArgs<Repair>,

    /// Exit with 3 unless every hole of more than four edges that was to be filled is closed well: by a surface that continues its
    /// surroundings, or as asked for, that intersects no other face. The holes that are not are named.
    #[arg(long)]
    strict: bool,

    #[command(flatten)]
    deliver: DeliverArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

impl RepairArgs {
    /// The work that these options ask for.
    ///
    /// # Errors
    /// If options conflict.
    pub(super) fn work(&self) -> anyhow::Result<Work> {
        let params: RepairParams = self.parameters.params()?;
        Ok(Work::Repair(params))
    }
}

/// Reads, repairs and writes each mesh.
pub fn run(args: &RepairArgs, console: &Console) -> anyhow::Result<End> {
    let task = Task {
        work: args.work()?,
        common: &args.common,
        strict: args.strict,
        deliverables: args.deliver.deliverables()?,
    };
    args.files.each(&task, console)
}
