//! `isomend study`: runs the experiments of the paper and writes their tables, plots and fields.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Context, bail};
use clap::{Args, ValueEnum, ValueHint};
use isomend::Energy;
use isomend::io::{Precision, write_volume_path};
use isomend::job::{Document, Place, write_text};
use isomend::study::experiments::{
    CapSettings, CircleSettings, GraphSettings, MergeSettings, OrthogonalSettings, PatchesSettings,
    SurfacesSettings, Table1Settings, cap, circle, graph, merge, orthogonal, patches, surfaces,
    table1,
};
use isomend::study::{Frame, Observer, StudyError, StudyReport, to_svg};
use serde::{Deserialize, Serialize};

use super::console::{self, Console};
use super::json::Target;
use super::parameters::{ParameterArgs, Study};
use super::{End, RunArgs, arguments};

const EXAMPLES: &str = "\
Examples:
  isomend study table1                                 the table, with stated and computed values
  isomend study merge --plot merge.svg --series merge  a figure of level lines, and files for ParaView
  isomend study patches --finest 64 --csv patches.csv";

/// Run an experiment of the paper.
///
/// Prints tables, and what the paper, theory or the prototype states next to the computed values. All lengths and times are
/// dimensionless.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct StudyArgs {
    /// The experiment.
    #[arg(value_name = "NAME", value_enum)]
    name: Experiment,

    /// The finest grid: cells along a side for table1 and circle, voxels across the hole for patches, across the box for surfaces. Finer
    /// grids are left out.
    #[arg(long, value_name = "N", value_parser = arguments::count)]
    finest: Option<usize>,

    #[command(flatten)]
    parameters: ParameterArgs<Study>,

    /// Write the tables as comma-separated values.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,

    /// Write the report as JSON to a file, or to standard output with `-`.
    #[arg(long, value_name = "FILE|-", value_hint = ValueHint::FilePath)]
    json: Option<Target>,

    /// Draw charts and level lines as SVG.
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,

    /// Write the fields of single steps into a folder, as VTI files with one PVD file for each run. The folder is created if necessary.
    #[arg(long, value_name = "DIR")]
    series: Option<PathBuf>,

    #[command(flatten)]
    pub(super) run: RunArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Experiment {
    /// Spherical cap as a graph: error and order for h = 1/4 to 1/256, variants I, II, Gauss-Newton (Table 1)
    Table1,
    /// Growing circle: radius against the exact one (Figures 2 and 3); most of a minute
    Circle,
    /// Flow of a graph, its energy, and its difference from a parametric flow (Figures 4 and 5)
    Graph,
    /// Two squares that merge (Figure 6); a few minutes
    Merge,
    /// Level lines at right angles to a natural boundary (Figure 7)
    Orthogonal,
    /// A graph that becomes a spherical cap (Figure 1)
    Cap,
    /// Closed surfaces that evolve in time: sphere, torus, uneven sphere, cube; the schemes compared; a few minutes
    Surfaces,
    /// Fills of exact surfaces in 3D: error, order, normals, at 16 to 128 voxels across; a few minutes
    Patches,
}

/// Runs an experiment and writes the requested files.
pub fn run(args: &StudyArgs, console: &Console) -> anyhow::Result<End> {
    check(args)?;
    let recorder = Recorder {
        console,
        folder: args.series.as_deref(),
        written: Mutex::new(BTreeMap::new()),
    };
    let report = experiment(args, args.energy()?, &recorder)?;
    recorder.finish()?;
    if let Some(path) = &args.csv {
        write_text(path, &report.csv())?;
    }
    if let Some(path) = &args.plot {
        let svg = to_svg(&report).map_err(|error| anyhow::anyhow!("cannot draw: {error}"))?;
        write_text(path, &svg)?;
    }
    if let Some(json) = &args.json {
        let body = StudyBody {
            holds: report.holds(),
            report: &report,
        };
        json.write(&Document::new("study", body))?;
    }
    if !matches!(args.json, Some(Target::Stdout)) {
        let text = report.text_lines().join("\n") + "\n";
        console::print_out(&text)?;
    }
    Ok(if report.holds() {
        End::Done
    } else {
        End::InPart
    })
}

/// The solver parameters that this command has.
#[derive(Deserialize)]
struct Solve {
    energy: Energy,
}

impl StudyArgs {
    fn energy(&self) -> anyhow::Result<Energy> {
        let Solve { energy } = self.parameters.params()?;
        Ok(energy)
    }
}

/// Voxels. The coarsest grid in space.
const COARSEST: usize = 16;

/// Refuses wrong options before the experiment starts.
fn check(args: &StudyArgs) -> anyhow::Result<()> {
    if let Some(json) = &args.json {
        json.check(&[], &[])?;
    }
    for path in args.csv.iter().chain(&args.plot) {
        Place::from(path.as_path()).check_writable()?;
    }
    if let Some(path) = &args.plot {
        let extension = path.extension().unwrap_or_default();
        if !extension.eq_ignore_ascii_case("svg") {
            bail!(
                "--plot {} is not SVG; name a file that ends in .svg",
                path.display()
            );
        }
    }
    if let Some(folder) = &args.series {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    }
    match (args.finest, coarsest(args.name)) {
        (Some(_), None) => bail!("--finest applies to table1, circle, surfaces and patches only"),
        (Some(finest), Some(coarsest)) if finest < coarsest => {
            bail!("--finest {finest} leaves no grid; the coarsest one there has {coarsest}")
        }
        _ => {}
    }
    if args.energy()? != Energy::Willmore && args.name != Experiment::Patches {
        bail!("--energy applies to patches only");
    }
    Ok(())
}

/// The coarsest grid of an experiment that `--finest` applies to.
fn coarsest(name: Experiment) -> Option<usize> {
    match name {
        Experiment::Table1 => Table1Settings::default().cells.into_iter().min(),
        Experiment::Circle => {
            let runs = CircleSettings::default().runs.into_iter();
            runs.map(|run| run.0).min()
        }
        Experiment::Surfaces | Experiment::Patches => Some(COARSEST),
        _ => None,
    }
}

fn experiment(
    args: &StudyArgs,
    energy: Energy,
    observer: &Recorder,
) -> Result<StudyReport, StudyError> {
    let finest = args.finest.unwrap_or(usize::MAX);
    match args.name {
        Experiment::Table1 => {
            let mut settings = Table1Settings::default();
            settings.cells.retain(|&cells| cells <= finest);
            table1(&settings, observer)
        }
        Experiment::Circle => {
            let mut settings = CircleSettings::default();
            settings.runs.retain(|run| run.0 <= finest);
            circle(&settings, observer)
        }
        Experiment::Graph => graph(&GraphSettings::default(), observer),
        Experiment::Merge => merge(&MergeSettings::default(), observer),
        Experiment::Orthogonal => orthogonal(&OrthogonalSettings::default(), observer),
        Experiment::Cap => cap(&CapSettings::default(), observer),
        Experiment::Surfaces => {
            let mut settings = SurfacesSettings::default();
            settings.voxels = settings.voxels.min(finest);
            surfaces(&settings, observer)
        }
        Experiment::Patches => {
            let mut settings = PatchesSettings::default();
            settings.flow.energy = energy;
            settings.refinements.retain(|&r| COARSEST << r <= finest);
            patches(&settings, observer)
        }
    }
}

/// The report of `isomend study`.
#[derive(Serialize)]
struct StudyBody<'a> {
    /// Whether every claim holds.
    holds: bool,
    #[serde(flatten)]
    report: &'a StudyReport,
}

/// Prints progress and writes fields.
struct Recorder<'a> {
    console: &'a Console,
    folder: Option<&'a Path>,
    /// Time and file name of each field, by run.
    written: Mutex<BTreeMap<String, Vec<(f64, String)>>>,
}

impl Recorder<'_> {
    /// Writes the PVD files, which give ParaView the time of each field.
    fn finish(&self) -> anyhow::Result<()> {
        let Some(folder) = self.folder else {
            return Ok(());
        };
        let written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        if written.is_empty() {
            self.console.warn("this experiment has no fields to write");
        }
        for (series, files) in written.iter() {
            let mut text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n".to_owned();
            for (time, file) in files {
                text += &format!("<DataSet timestep=\"{time:e}\" part=\"0\" file=\"{file}\"/>\n");
            }
            text += "</Collection>\n</VTKFile>\n";
            write_text(&folder.join(format!("{series}.pvd")), &text)?;
        }
        Ok(())
    }
}

impl Observer for Recorder<'_> {
    fn progress(&self, line: &str) {
        self.console.say(line);
    }

    fn frame(&self, frame: &Frame) -> Result<(), StudyError> {
        let Some(folder) = self.folder else {
            return Ok(());
        };
        let file = format!("{}-{:06}.vti", frame.series, frame.step);
        let path = folder.join(&file);
        write_volume_path(&path, frame.volume, "phi", Precision::F64).map_err(|error| {
            StudyError::Frame {
                step: frame.step,
                reason: error.to_string(),
            }
        })?;
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        written
            .entry(frame.series.to_owned())
            .or_default()
            .push((frame.time, file));
        Ok(())
    }

    fn keep_going(&self) -> bool {
        true
    }
}
