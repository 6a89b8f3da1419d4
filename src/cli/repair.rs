//! `isomend repair`: what is wrong with a mesh is mended.

use clap::Args;
use isomend::RepairParams;
use isomend::job::Work;

use super::arguments;
use super::console::Console;
use super::files::{FilesArgs, Task};
use super::solve::SolveArgs;
use super::{CommonArgs, End};

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
    steps: StepArgs,

    /// Drop vertices that no face of the input uses.
    #[arg(long)]
    drop_unused: bool,

    /// Leave the holes of the mesh open; those that the repair makes are filled.
    #[arg(long)]
    keep_holes: bool,

    /// Close the outer borders of open sheets too, which are left open otherwise.
    #[arg(long, conflicts_with = "keep_holes")]
    close_borders: bool,

    /// Leave holes open that are wider than this, in the mesh's units.
    #[arg(long, value_name = "LENGTH", value_parser = arguments::positive)]
    max_diameter: Option<f64>,

    #[command(flatten)]
    solve: SolveArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// The steps of a repair but the last, the filling of holes.
#[derive(Debug, Args)]
pub struct StepArgs {
    /// Merge vertices of the border that are no farther apart than this; those at exactly the same position are merged anyway.
    #[arg(long, value_name = "LENGTH", value_parser = arguments::positive)]
    weld: Option<f64>,

    /// Take out components with less than this part of the area of the largest one.
    #[arg(long, value_name = "PART", value_parser = arguments::part)]
    debris: Option<f64>,

    /// Take out components that lie wholly inside another one.
    #[arg(long)]
    drop_inside: bool,

    /// Leave coinciding vertices, and degenerate and duplicate faces.
    #[arg(long)]
    keep_duplicates: bool,

    /// Turn no faces over.
    #[arg(long)]
    keep_orientation: bool,

    /// Leave edges with more than two faces, and vertices where surfaces meet in a point only.
    #[arg(long)]
    keep_non_manifold: bool,

    /// Leave faces that cross others.
    #[arg(long)]
    keep_crossings: bool,
}

impl StepArgs {
    /// The parameters of a repair; holes are filled as usual.
    pub fn params(&self) -> RepairParams {
        RepairParams {
            clean: !self.keep_duplicates,
            weld: self.weld,
            orient: !self.keep_orientation,
            split: !self.keep_non_manifold,
            debris: self.debris,
            drop_inside: self.drop_inside,
            crossings: !self.keep_crossings,
            ..RepairParams::default()
        }
    }
}

impl RepairArgs {
    /// What is to be done.
    ///
    /// # Errors
    /// When the options do not go together.
    pub(super) fn work(&self) -> anyhow::Result<Work> {
        self.solve.check()?;
        let mut params = self.steps.params();
        params.drop_unused = self.drop_unused;
        params.holes = !self.keep_holes;
        params.borders = self.close_borders;
        params.fill = self.solve.params();
        params.fill.max_diameter = self.max_diameter;
        Ok(Work::Repair(params))
    }
}

/// Reads, repairs, writes.
pub fn run(args: &RepairArgs, console: &Console) -> anyhow::Result<End> {
    let task = Task {
        work: args.work()?,
        common: &args.common,
        strict: args.solve.strict,
    };
    args.files.each(&task, console)
}
