//! What the commands that fill regions share: the options of the solve and of the output, reading, telling and writing.

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use isomend::flow::{Energy, Variant};
use isomend::io::Loaded;
use isomend::report::{FillReport, HoleOutcome, Plan, level_lines, plan_lines, summary_lines};
use isomend::{FillParams, Mesh, SurfaceKind, VoxelSize};

use super::batch::Files;
use super::console::{self, Console};
use super::json::{Cut, FileInfo, FillDocument, PlanDocument};
use super::report::{Before, Drawn};
use super::{End, Usage, arguments};

/// Options of the solve and of what is written.
#[derive(Debug, Args)]
pub struct SolveArgs {
    /// Voxel size in the mesh's units.
    ///
    /// `auto` takes 32 voxels across the hole, up to 64 where its rim is finer or it is a slot, up to 96 in a region with a
    /// small loop; with curvature-variation 2.5 times as many, at most 128. A length may be 1/1024 of the hole or more.
    #[arg(long, value_name = "LENGTH|auto", default_value = "auto", value_parser = arguments::voxel)]
    voxel: VoxelSize,

    #[command(flatten)]
    energy: EnergyArg,

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

    /// Most steps of the flow on each grid [default: 20, with I and II 200].
    #[arg(long, value_name = "N", value_parser = arguments::steps)]
    steps: Option<usize>,

    /// Length of the patch's edges over that of the edges round the hole [default: 0.8, with curvature-variation 0.45].
    #[arg(long, value_name = "RATIO", value_parser = arguments::edge_ratio)]
    edge_ratio: Option<f64>,

    /// Exit with 3 unless every hole of more than four edges that was to be filled got a steady surface of the level set,
    /// joined to its rim, that crosses no face.
    #[arg(long)]
    pub(super) strict: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum Scheme {
    #[value(name = "I")]
    I,
    #[value(name = "II")]
    II,
    #[value(name = "gauss-newton")]
    GaussNewton,
}

impl From<Scheme> for Variant {
    fn from(scheme: Scheme) -> Self {
        match scheme {
            Scheme::I => Self::I,
            Scheme::II => Self::II,
            Scheme::GaussNewton => Self::GaussNewton,
        }
    }
}

/// The energy of a solve.
#[derive(Clone, Copy, Debug, Args)]
pub struct EnergyArg {
    /// What a patch makes small.
    ///
    /// The default continues spheres, minimal surfaces and tori and is the most robust, on rough scans above all. Take the
    /// other where the surroundings are smooth and like a cylinder, a cone or an ellipsoid, which the Willmore energy cannot
    /// continue exactly; it takes a few times as long, on voxels 0.4 times as large and with finer triangles unless told otherwise.
    #[arg(
        long,
        value_enum,
        value_name = "willmore|curvature-variation",
        default_value = "willmore"
    )]
    energy: EnergyName,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum EnergyName {
    /// The integral of the squared mean curvature.
    Willmore,
    /// The integral of the squared slope of the mean curvature along the surface.
    CurvatureVariation,
}

impl EnergyArg {
    /// The energy.
    pub fn energy(self) -> Energy {
        match self.energy {
            EnergyName::Willmore => Energy::Willmore,
            EnergyName::CurvatureVariation => Energy::CurvatureVariation,
        }
    }
}

impl SolveArgs {
    /// The parameters of the solve; the others are the usual ones.
    pub fn params(&self) -> FillParams {
        FillParams {
            voxel: self.voxel,
            energy: self.energy.energy(),
            variant: self.variant.into(),
            steps: self.steps,
            time_step: self.time_step,
            edge_ratio: self.edge_ratio,
            ..FillParams::default()
        }
    }

    /// Refuses what has no effect on a level set's own triangles.
    pub fn check_whole(&self) -> anyhow::Result<()> {
        if self.edge_ratio.is_some() {
            let what = "--edge-ratio is for patches; --surface whole has the triangles of the grid, whose size is --voxel";
            return Err(Usage(what.to_owned()).into());
        }
        Ok(())
    }

    /// Whether the options go together.
    pub fn check(&self) -> anyhow::Result<()> {
        if self.energy.energy() != Energy::Willmore
            && (!matches!(self.variant, Scheme::GaussNewton) || self.time_step.is_some())
        {
            bail!(
                "--variant and --time-step are for the Willmore energy; leave them out, or --energy"
            );
        }
        Ok(())
    }
}

/// What became of a mesh.
pub struct Mended<'a> {
    /// The mesh after.
    pub mesh: Mesh,
    /// The mesh whose vertices and faces come first.
    pub first: &'a Loaded,
    /// The parameters.
    pub params: &'a FillParams,
    /// What was found and done.
    pub report: &'a mut FillReport,
    /// What of the input is not in `first`.
    pub cut: Option<Cut>,
    /// The mesh before, where something was cut out and it is to be drawn.
    pub before: Option<Before>,
    /// Whether anything but a steady surface that is joined and crosses nothing counts as done in part.
    pub strict: bool,
}

impl Files<'_> {
    /// Writes the mesh and the reports, and tells what was done.
    pub fn finish(&self, done: Mended, console: &Console) -> anyhow::Result<End> {
        let Mended {
            mesh,
            first,
            params,
            report,
            cut,
            before,
            strict,
        } = done;
        let output = self.output.as_ref().context("there is no output")?;
        let mut notes = first.notes.clone();
        let (mesh, remarks) = output.write(mesh, first, params, &mut report.regions)?;
        let report = &*report;
        notes.extend(remarks);
        notes[first.notes.len()..]
            .iter()
            .for_each(|note| console.note(&format!("{}: {note}", output.name())));
        self.tell(report, console);
        if let Some(documents) = self.documents {
            let path = self.input;
            documents.add(&FillDocument {
                command: self.command,
                version: env!("CARGO_PKG_VERSION"),
                input: FileInfo::of(path, first.format, report.vertices, report.faces),
                output: FileInfo::new(&output.path, output.format, &mesh),
                notes: &notes,
                complete: !report.incomplete(),
                flawless: report.flawless(),
                outcomes: report.tally(),
                cut,
                report,
            })?;
        }
        self.draw(&Drawn {
            command: self.command,
            input: self.input,
            output: &output.path,
            before: before.as_ref(),
            first: &first.mesh,
            after: &mesh,
            kept: match params.surface {
                SurfaceKind::Stitched => first.mesh.faces.len(),
                SurfaceKind::Whole => 0,
            },
            notes: &notes,
            report,
        })?;
        let done = !report.incomplete() && (!strict || report.flawless());
        Ok(if done { End::Done } else { End::InPart })
    }

    /// Says what would be done, on standard output unless the JSON report goes there.
    pub fn preview(&self, loaded: &Loaded, plan: &Plan, cut: Option<Cut>) -> anyhow::Result<End> {
        if let Some(documents) = self.documents {
            documents.add(&PlanDocument {
                command: self.command,
                version: env!("CARGO_PKG_VERSION"),
                dry_run: true,
                input: FileInfo::of(self.input, loaded.format, plan.vertices, plan.faces),
                notes: &loaded.notes,
                cut,
                plan,
            })?;
        }
        if !self.report_only {
            let mut text = String::new();
            if self.several {
                text += &format!("{}\n", console::heading(&self.input.display().to_string()));
            }
            if let Some(cut) = cut {
                text += &format!(
                    "{} faces marked, {} would be cut out\n",
                    cut.marked_faces, cut.removed_faces
                );
            }
            text += &(plan_lines(plan).join("\n") + "\n");
            console::print(&text).context("cannot write to standard output")?;
        }
        Ok(End::Done)
    }

    fn tell(&self, report: &FillReport, console: &Console) {
        // Off a terminal each region was told of as it ended.
        for line in summary_lines(report, console.wants_progress()) {
            console.say(&line);
        }
        for region in &report.regions {
            for line in level_lines(region) {
                console.detail(&line);
            }
        }
        let name = if self.several {
            format!("{}: ", self.input.display())
        } else {
            String::new()
        };
        for hole in &report.holes {
            if let HoleOutcome::Failed(why) = &hole.outcome {
                console.warn(&format!("{name}hole {} is still open: {why}", hole.hole.id));
            }
        }
    }
}
