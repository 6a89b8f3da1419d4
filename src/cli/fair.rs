//! `isomend fair`: fairs a surface, or a marked region of it.

use clap::{ArgGroup, Args};
use isomend::job::Work;
use isomend::{FairExtent, FairParams};

use super::console::Console;
use super::files::{FilesArgs, Task};
use super::mask::MaskArgs;
use super::solve::{SchemeArg, VoxelArg};
use super::{CommonArgs, End, arguments};

const EXAMPLES: &str = "\
Examples:
  isomend fair scan.ply -o out.ply                               lose what is narrower than eight mean edges
  isomend fair scan.ply -o out.ply --strength 2.5                features narrower than 2.5 go
  isomend fair scan.ply -o out.ply --strength 4 --ball 10,4,2,9  in a ball only; all else stays bit for bit
  isomend fair torus.ply -o out.ply --time 0.02                  Willmore flow for a time";

const VOXEL: &str = "\
Voxel size in the mesh's units.

`auto` is an eighth of the features that go, at least a third of the mean edge, and more on large models.";

/// Fair the whole surface, or a marked region.
///
/// The surface evolves by Willmore flow for a time: noise and small features go, spheres, minimal surfaces and large forms
/// stay. A closed mesh as a whole is replaced by the faired surface, remeshed. A marked region is cut out and what it
/// evolves to is joined to the rest, which stays bit for bit and in order. An open mesh keeps a strip along its borders.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
#[command(mut_arg("voxel", |voxel| voxel.long_help(VOXEL)))]
#[command(group(ArgGroup::new("extent").args(["time", "strength"])))]
pub struct FairArgs {
    #[command(flatten)]
    files: FilesArgs,

    /// Features narrower than this length go [default: eight mean edges, more on surfaces of over 400,000 faces].
    ///
    /// Waves of this length lose all but a third of their height, those of half of it everything. It is the time
    /// (LENGTH / 2 pi)^4.
    #[arg(long, value_name = "LENGTH", value_parser = arguments::positive)]
    strength: Option<f64>,

    /// Time of the Willmore flow, in the mesh's units to the fourth power.
    #[arg(long, value_name = "T", value_parser = arguments::positive)]
    time: Option<f64>,

    #[command(flatten)]
    voxel: VoxelArg,

    #[command(flatten)]
    scheme: SchemeArg,

    /// Length of the new edges over that of the edges round the region, or over the mean of all.
    #[arg(long, value_name = "RATIO", default_value = "1", value_parser = arguments::edge_ratio)]
    edge_ratio: f64,

    #[command(flatten)]
    mask: MaskArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

impl FairArgs {
    fn params(&self) -> FairParams {
        FairParams {
            extent: match (self.time, self.strength) {
                (Some(time), _) => FairExtent::Time(time),
                (None, Some(strength)) => FairExtent::Strength(strength),
                (None, None) => FairExtent::Auto,
            },
            voxel: self.voxel.voxel,
            variant: self.scheme.variant(),
            edge_ratio: self.edge_ratio,
            ..FairParams::default()
        }
    }

    /// What is to be done.
    ///
    /// # Errors
    /// When the options do not go together.
    pub(super) fn work(&self) -> anyhow::Result<Work> {
        Ok(Work::Fair(self.mask.mask()?, self.params()))
    }
}

/// Reads, fairs, writes.
pub fn run(args: &FairArgs, console: &Console) -> anyhow::Result<End> {
    let task = Task {
        work: args.work()?,
        common: &args.common,
        strict: false,
    };
    args.files.each(&task, console)
}
