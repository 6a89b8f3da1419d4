//! What the commands that fill regions share: the options of the solve and of the output, reading, telling and writing.

use std::path::Path;

use anyhow::bail;
use clap::{Args, ValueEnum};
use isomend::flow::{Energy, Variant};
use isomend::io::{Format, Loaded};
use isomend::pipeline::Progress;
use isomend::report::{FillReport, HoleOutcome, level_lines, summary_lines};
use isomend::{FillError, FillParams, Mesh, SurfaceKind, VoxelSize};

use super::console::Console;
use super::json::{Cut, FileInfo, FillDocument, Target};
use super::output::Output;
use super::report::{Before, Drawn, ReportArgs};
use super::{End, arguments, input, progress};

/// Edge ratio for the variation of curvature: longer chords are farther from its surface than that is from smooth data.
const FINE_EDGE_RATIO: f64 = 0.65;

/// Options of the solve and of what is written.
#[derive(Debug, Args)]
pub struct SolveArgs {
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

    /// Length of the patch's edges over that of the edges round the hole [default: 0.8, with curvature-variation 0.65].
    #[arg(long, value_name = "RATIO", value_parser = arguments::edge_ratio)]
    edge_ratio: Option<f64>,

    /// Format of the output, whatever its extension: obj, ply, stl, gltf, glb, vtk or vtp.
    #[arg(long, value_name = "FORMAT", value_parser = arguments::format)]
    to: Option<Format>,

    /// Write text instead of binary: PLY, STL and VTK legacy.
    #[arg(long)]
    ascii: bool,
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

impl SolveArgs {
    /// The parameters of the solve; the others are the usual ones.
    pub fn params(&self) -> FillParams {
        FillParams {
            voxel: self.voxel,
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
            ..FillParams::default()
        }
    }

    /// Whether the options go together.
    pub fn check(&self) -> anyhow::Result<()> {
        if self.energy != EnergyName::Willmore
            && (!matches!(self.variant, Scheme::GaussNewton) || self.time_step.is_some())
        {
            bail!(
                "--variant and --time-step are for the Willmore energy; leave them out, or --energy"
            );
        }
        Ok(())
    }

    /// Where the mesh goes.
    pub fn output(&self, path: &Path) -> anyhow::Result<Output> {
        Output::new(path, self.to, self.ascii)
    }
}

/// The files of a run.
pub struct Files<'a> {
    /// The name of the command.
    pub command: &'static str,
    /// The mesh read.
    pub input: &'a Path,
    /// The mesh written.
    pub output: Output,
    /// Where the report goes.
    pub json: Option<&'a Target>,
    /// What is drawn.
    pub report: &'a ReportArgs,
    /// The mesh before, where it is not the one whose vertices and faces come first.
    pub before: Option<Before>,
}

impl Files<'_> {
    /// Checks what can be checked before the work, and reads the mesh.
    pub fn read(&self, from: Option<Format>, console: &Console) -> anyhow::Result<Loaded> {
        if let Some(json) = self.json {
            json.check(&[self.input, &self.output.path])?;
        }
        self.report
            .check(self.input, &self.output.path, self.json)?;
        progress::catch_interrupt()?;
        input::read(self.input, from, console)
    }

    /// Writes the mesh and the report, and tells what was done. `loaded` is the mesh whose vertices and faces come first;
    /// `cut` says what of the input is not among them.
    pub fn finish(
        &self,
        mesh: Mesh,
        loaded: &Loaded,
        params: &FillParams,
        report: &FillReport,
        cut: Option<Cut>,
        console: &Console,
    ) -> anyhow::Result<End> {
        let mut notes = loaded.notes.clone();
        let (mesh, remarks) = self.output.write(mesh, loaded, params)?;
        notes.extend(remarks);
        notes[loaded.notes.len()..]
            .iter()
            .for_each(|note| console.note(&format!("{}: {note}", self.output.path.display())));
        tell(report, console);
        if let Some(json) = self.json {
            let path = self.input;
            json.write(&FillDocument {
                command: self.command,
                version: env!("CARGO_PKG_VERSION"),
                input: FileInfo::of(path, loaded.format, report.vertices, report.faces),
                output: FileInfo::new(&self.output.path, self.output.format, &mesh),
                notes: &notes,
                complete: !report.incomplete(),
                cut,
                report,
            })?;
        }
        if self.report.is_wanted() {
            self.report.write(&Drawn {
                command: self.command,
                input: self.input,
                output: &self.output.path,
                before: self.before.as_ref(),
                first: &loaded.mesh,
                after: &mesh,
                kept: match params.surface {
                    SurfaceKind::Stitched => loaded.mesh.faces.len(),
                    SurfaceKind::Whole => 0,
                },
                notes: &notes,
                report,
            })?;
        }
        Ok(if report.incomplete() {
            End::InPart
        } else {
            End::Done
        })
    }
}

/// Runs with a progress bar that Ctrl-C stops.
pub fn watched<R>(console: &Console, run: impl FnOnce(&Progress) -> R) -> R {
    let bar = progress::bar(console);
    let result = run(&|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
        !progress::interrupted()
    });
    bar.finish_and_clear();
    result
}

/// The result; none, which is said, when the user stopped the run.
pub fn unless_stopped<R>(
    result: Result<R, FillError>,
    console: &Console,
) -> anyhow::Result<Option<R>> {
    match result {
        Err(error) if !matches!(error, FillError::Cancelled) => Err(error.into()),
        Ok(done) if !progress::interrupted() => Ok(Some(done)),
        _ => {
            console.warn("stopped; nothing was written");
            Ok(None)
        }
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
