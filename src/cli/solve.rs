//! What the commands that fill regions share: the options of the solve and of the output, reading, telling and writing.

use std::path::Path;

use clap::{Args, ValueEnum};
use isomend::flow::Variant;
use isomend::io::{Format, Loaded};
use isomend::pipeline::Progress;
use isomend::report::{FillReport, HoleOutcome, level_lines, summary_lines};
use isomend::{FillError, FillParams, Mesh, VoxelSize};

use super::console::Console;
use super::json::{Cut, FileInfo, FillDocument, Target};
use super::output::Output;
use super::{End, arguments, input, progress};

/// Options of the solve and of what is written.
#[derive(Debug, Args)]
pub struct SolveArgs {
    /// Voxel size in the mesh's units.
    ///
    /// `auto` takes 32 voxels across the hole, more where its rim is finer, at most 160.
    #[arg(long, value_name = "LENGTH|auto", default_value = "auto", value_parser = arguments::voxel)]
    voxel: VoxelSize,

    /// Scheme of the flow's steps: I and II are the paper's; all end in the same surface.
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

    /// Length of the patch's edges over that of the edges round the hole.
    #[arg(long, value_name = "RATIO", default_value = "0.8", value_parser = arguments::edge_ratio)]
    edge_ratio: f64,

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

impl SolveArgs {
    /// The parameters of the solve; the others are the usual ones.
    pub fn params(&self) -> FillParams {
        FillParams {
            voxel: self.voxel,
            variant: match self.variant {
                Scheme::I => Variant::I,
                Scheme::II => Variant::II,
                Scheme::GaussNewton => Variant::GaussNewton,
            },
            steps: self.steps,
            time_step: self.time_step,
            edge_ratio: self.edge_ratio,
            ..FillParams::default()
        }
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
}

impl Files<'_> {
    /// Checks what can be checked before the work, and reads the mesh.
    pub fn read(&self, from: Option<Format>, console: &Console) -> anyhow::Result<Loaded> {
        if let Some(json) = self.json {
            json.check(&[self.input, &self.output.path])?;
        }
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
