//! `isomend fill`: find holes and fill them.

use clap::{Args, ValueEnum};
use isomend::job::Work;
use isomend::{FillParams, RepairParams, SurfaceKind};

use super::arguments::{self, Choice, Ids};
use super::console::Console;
use super::files::{FilesArgs, Task};
use super::solve::SolveArgs;
use super::{CommonArgs, End, Usage};

const EXAMPLES: &str = "\
Examples:
  isomend fill scan.ply -o mended.glb               fill all holes
  isomend fill scan.ply -o mended.ply --holes 2,5   fill two of them, by the numbers of `isomend inspect`
  isomend fill scan.ply -o mended.ply --max-diameter 20 --keep-open 4
  isomend fill vase.obj -o vase.obj --bridge 1+2    rebuild the wall between two facing rims
  isomend fill bust.ply -o bust.ply --flat 1        close the cut neck by a flat cap
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

    /// Holes to fill, by their numbers: `all`, or such as `2,5`.
    ///
    /// Numbers are those of `isomend inspect`. An outer border is filled when it is named here.
    #[arg(long, value_name = "all|ID,…", default_value = "all", value_parser = arguments::choice)]
    holes: Choice,

    /// Leave holes open that are wider than this, in the mesh's units, unless --holes names them.
    #[arg(long, value_name = "LENGTH", value_parser = arguments::positive)]
    max_diameter: Option<f64>,

    /// Leave these holes open.
    #[arg(long, value_name = "ID,…", value_parser = arguments::ids)]
    keep_open: Option<Ids>,

    /// Fill these holes in one region whatever their distance, such as `3+7`; may be given several times.
    ///
    /// Holes that are near each other are joined without it.
    #[arg(long, value_name = "ID+ID", value_parser = arguments::bridge)]
    bridge: Vec<Ids>,

    /// Close these holes by nearly flat caps instead of continuing the surface, such as `1,4`: necks, bases, mouths of vessels.
    #[arg(long, value_name = "ID,…", value_parser = arguments::ids)]
    flat: Option<Ids>,

    /// What to write.
    #[arg(
        long,
        value_enum,
        value_name = "stitched|whole",
        default_value = "stitched"
    )]
    surface: Surface,

    /// First mend what else is wrong, as `isomend repair` does. The exit code is that of `isomend check` on what is written.
    #[arg(long)]
    repair: bool,

    #[command(flatten)]
    solve: SolveArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Surface {
    /// The mesh with the patches stitched in.
    Stitched,
    /// The zero sets of the level sets alone, as marching cubes gives them.
    Whole,
}

impl FillArgs {
    fn params(&self) -> FillParams {
        let list = |ids: &Ids| ids.0.clone();
        let mut params = self.solve.params();
        params.holes = match &self.holes {
            Choice::All => None,
            Choice::Some(ids) => Some(ids.clone()),
        };
        params.max_diameter = self.max_diameter;
        params.keep_open = self.keep_open.as_ref().map(list).unwrap_or_default();
        params.bridge = self.bridge.iter().map(list).collect();
        params.flat = self.flat.as_ref().map(list).unwrap_or_default();
        params.surface = match self.surface {
            Surface::Stitched => SurfaceKind::Stitched,
            Surface::Whole => SurfaceKind::Whole,
        };
        params
    }

    /// What is to be done.
    ///
    /// # Errors
    /// When the options do not go together.
    pub(super) fn work(&self) -> anyhow::Result<Work> {
        self.solve.check()?;
        let is_whole = matches!(self.surface, Surface::Whole);
        if is_whole {
            self.solve.check_whole()?;
        }
        if self.repair && is_whole {
            let what = "--repair stitches patches into the mesh; --surface whole has the level sets alone, so leave one of them out";
            return Err(Usage(what.to_owned()).into());
        }
        Ok(match self.repair {
            true => {
                let mut params = RepairParams::default();
                params.fill = self.params();
                Work::Repair(params)
            }
            false => Work::Fill(self.params()),
        })
    }
}

/// Reads, fills, writes.
pub fn run(args: &FillArgs, console: &Console) -> anyhow::Result<End> {
    let work = args.work()?;
    if args.max_diameter.is_some() && matches!(args.holes, Choice::Some(_)) {
        console.note("--max-diameter does nothing here: --holes names the holes that are filled");
    }
    let task = Task {
        work,
        common: &args.common,
        strict: args.solve.strict,
    };
    args.files.each(&task, console)
}
