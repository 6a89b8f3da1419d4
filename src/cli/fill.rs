//! `isomend fill`: find holes and fill them.

use std::path::PathBuf;

use anyhow::bail;
use clap::{Args, ValueEnum};
use isomend::flow::{Energy, Variant};
use isomend::io::{Format, Loaded};
use isomend::report::{FillReport, HoleOutcome, level_lines, summary_lines};
use isomend::{FillError, FillParams, Filled, SurfaceKind, VoxelSize};

use super::arguments::{self, Choice, Ids};
use super::console::Console;
use super::json::{FileInfo, FillDocument};
use super::output::Output;
use super::{CommonArgs, End, input, progress};

const EXAMPLES: &str = "\
Examples:
  isomend fill scan.ply -o mended.glb               fill all holes
  isomend fill scan.ply -o mended.ply --holes 2,5   fill two of them, by the numbers of `isomend inspect`
  isomend fill scan.ply -o mended.ply --max-diameter 20 --keep-open 4
  isomend fill vase.obj -o vase.obj --bridge 1+2    rebuild the wall between two facing rims
  isomend fill scan.stl -o mended.stl --json - -q   a report for a script";

/// Edge ratio for the variation of curvature: longer chords are farther from its surface than that is from smooth data.
const FINE_EDGE_RATIO: f64 = 0.65;

/// Find holes and fill them.
///
/// All holes are filled by default, save the outer border of an open sheet. The mesh's own vertices and faces stay bit
/// for bit and in order; new ones come after them.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct FillArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy or VTP.
    #[arg(value_name = "IN")]
    input: PathBuf,

    /// The file to write, in the format of its extension.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,

    /// Holes to fill, by their numbers: `all`, or such as `2,5`.
    ///
    /// Numbers are those of `isomend inspect`. An outer border is filled when it is named here.
    #[arg(long, value_name = "all|ID,…", default_value = "all", value_parser = arguments::choice)]
    holes: Choice,

    /// Leave holes open that are wider than this, in the mesh's units.
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

    /// Voxel size in the mesh's units.
    ///
    /// `auto` takes 32 voxels across the hole, more where its rim is finer, at most 160; with curvature-variation 64.
    #[arg(long, value_name = "LENGTH|auto", default_value = "auto", value_parser = arguments::voxel)]
    voxel: VoxelSize,

    /// What the patch makes small.
    ///
    /// The default continues spheres, minimal surfaces and tori and is the most robust, on rough scans above all. Take the
    /// other where the surroundings are smooth and like a cylinder, a cone or an ellipsoid, which the Willmore energy cannot
    /// continue exactly; it takes a few times as long, on voxels half as large and with finer triangles unless told otherwise.
    #[arg(
        long,
        value_enum,
        value_name = "willmore|curvature-variation",
        default_value = "willmore"
    )]
    energy: EnergyName,

    /// Scheme of the flow's steps: I and II are the paper's, for the Willmore energy; all end in the same surface.
    #[arg(
        long,
        value_enum,
        value_name = "I|II|gauss-newton",
        default_value = "gauss-newton",
        ignore_case = true
    )]
    variant: Scheme,

    /// Time step of the flow, in units of the voxel size to the fourth power.
    ///
    /// Without it each step aims at the steady state.
    #[arg(long, value_name = "T", value_parser = arguments::positive)]
    time_step: Option<f64>,

    /// Most steps of the flow on each grid [default: 30, with I and II 200].
    #[arg(long, value_name = "N", value_parser = arguments::count)]
    steps: Option<usize>,

    /// What to write.
    #[arg(
        long,
        value_enum,
        value_name = "stitched|whole",
        default_value = "stitched"
    )]
    surface: Surface,

    /// Length of the patch's edges over that of the edges round the hole [default: 0.8, with curvature-variation 0.65].
    #[arg(long, value_name = "RATIO", value_parser = arguments::edge_ratio)]
    edge_ratio: Option<f64>,

    /// Format of the output, whatever its extension: obj, ply, stl, gltf, glb, vtk or vtp.
    #[arg(long, value_name = "FORMAT", value_parser = arguments::format)]
    to: Option<Format>,

    /// Write text instead of binary: PLY, STL and VTK legacy.
    #[arg(long)]
    ascii: bool,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Scheme {
    #[value(name = "I")]
    I,
    #[value(name = "II")]
    II,
    #[value(name = "gauss-newton")]
    GaussNewton,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum EnergyName {
    /// The integral of the squared mean curvature.
    Willmore,
    /// The integral of the squared slope of the mean curvature along the surface.
    CurvatureVariation,
}

impl EnergyName {
    pub(super) fn energy(self) -> Energy {
        match self {
            Self::Willmore => Energy::Willmore,
            Self::CurvatureVariation => Energy::CurvatureVariation,
        }
    }
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
        FillParams {
            voxel: self.voxel,
            holes: match &self.holes {
                Choice::All => None,
                Choice::Some(ids) => Some(ids.clone()),
            },
            max_diameter: self.max_diameter,
            keep_open: self.keep_open.as_ref().map(list).unwrap_or_default(),
            bridge: self.bridge.iter().map(list).collect(),
            surface: match self.surface {
                Surface::Stitched => SurfaceKind::Stitched,
                Surface::Whole => SurfaceKind::Whole,
            },
            energy: self.energy.energy(),
            variant: match self.variant {
                Scheme::I => Variant::I,
                Scheme::II => Variant::II,
                Scheme::GaussNewton => Variant::GaussNewton,
            },
            steps: self.steps,
            time_step: self.time_step,
            edge_ratio: self.edge_ratio.unwrap_or(match self.energy {
                EnergyName::Willmore => FillParams::default().edge_ratio,
                EnergyName::CurvatureVariation => FINE_EDGE_RATIO,
            }),
        }
    }
}

/// Reads, fills, writes.
pub fn run(args: &FillArgs, console: &Console) -> anyhow::Result<End> {
    let params = args.params();
    if params.energy != Energy::Willmore
        && (params.variant != Variant::GaussNewton || params.time_step.is_some())
    {
        bail!("--variant and --time-step are for the Willmore energy; leave them out, or --energy");
    }
    let output = Output::new(&args.output, args.to, args.ascii)?;
    if let Some(json) = &args.common.json {
        json.check(&[&args.input, &args.output])?;
    }
    progress::catch_interrupt()?;
    let loaded = input::read(&args.input, args.common.from, console)?;
    let Some(filled) = fill(&loaded, &params, console)? else {
        console.warn("stopped; nothing was written");
        return Ok(End::Interrupted);
    };
    let mut notes = loaded.notes.clone();
    let (mesh, remarks) = output.write(filled.mesh, &loaded, &params)?;
    notes.extend(remarks);
    notes[loaded.notes.len()..]
        .iter()
        .for_each(|note| console.note(&format!("{}: {note}", output.path.display())));
    tell(&filled.report, console);
    if let Some(json) = &args.common.json {
        json.write(&FillDocument {
            command: "fill",
            version: env!("CARGO_PKG_VERSION"),
            input: FileInfo::new(&args.input, loaded.format, &loaded.mesh),
            output: FileInfo::new(&output.path, output.format, &mesh),
            notes: &notes,
            complete: !filled.report.incomplete(),
            report: &filled.report,
        })?;
    }
    Ok(if filled.report.incomplete() {
        End::InPart
    } else {
        End::Done
    })
}

/// Fills with a progress bar; nothing when the user stopped it.
fn fill(loaded: &Loaded, params: &FillParams, console: &Console) -> anyhow::Result<Option<Filled>> {
    let bar = progress::bar(console);
    let result = isomend::fill_with_progress(&loaded.mesh, params, &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
        !progress::interrupted()
    });
    bar.finish_and_clear();
    match result {
        Err(FillError::Cancelled) => Ok(None),
        Ok(_) if progress::interrupted() => Ok(None),
        Ok(filled) => Ok(Some(filled)),
        Err(error) => Err(error.into()),
    }
}

fn tell(report: &FillReport, console: &Console) {
    for line in summary_lines(report) {
        console.say(&line);
    }
    for region in &report.regions {
        for line in level_lines(region) {
            console.detail(&line);
        }
    }
    for hole in &report.holes {
        if let HoleOutcome::Failed(why) = &hole.outcome {
            console.warn(&format!("hole {} is still open: {why}", hole.hole.id));
        }
    }
}
