//! `isomend fair`: fairs a surface, or a marked region of it.

use anyhow::Context;
use clap::{ArgGroup, Args};
use isomend::flow::Variant;
use isomend::io::Loaded;
use isomend::report::{RegionReport, length, level_lines};
use isomend::{
    FairExtent, FairParams, FairPlan, FairReport, Faired, FillParams, SurfaceKind, VoxelSize,
};
use serde::Serialize;

use super::batch::{Files, FilesArgs};
use super::console::{self, Console};
use super::json::FileInfo;
use super::mask::{Marked, MaskArgs};
use super::report::Drawn;
use super::solve::Scheme;
use super::{CommonArgs, End, arguments, progress};

const EXAMPLES: &str = "\
Examples:
  isomend fair scan.ply -o out.ply                               lose what is narrower than eight mean edges
  isomend fair scan.ply -o out.ply --strength 2.5                features narrower than 2.5 go
  isomend fair scan.ply -o out.ply --strength 4 --ball 10,4,2,9  in a ball only; all else stays bit for bit
  isomend fair torus.ply -o out.ply --time 0.02                  Willmore flow for a time";

/// Fair the whole surface, or a marked region.
///
/// The surface evolves by Willmore flow for a time: noise and small features go, spheres, minimal surfaces and large forms
/// stay. A closed mesh as a whole is replaced by the faired surface, remeshed. A marked region is cut out and what it
/// evolves to is joined to the rest, which stays bit for bit and in order. An open mesh keeps a strip along its borders.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
#[command(group(ArgGroup::new("extent").args(["time", "strength"])))]
pub struct FairArgs {
    #[command(flatten)]
    files: FilesArgs,

    /// Features narrower than this length go [default: eight mean edges].
    ///
    /// Waves of this length lose all but a third of their height, those of half of it everything. It is the time
    /// (LENGTH / 2 pi)^4.
    #[arg(long, value_name = "LENGTH", value_parser = arguments::positive)]
    strength: Option<f64>,

    /// Time of the Willmore flow, in the mesh's units to the fourth power.
    #[arg(long, value_name = "T", value_parser = arguments::positive)]
    time: Option<f64>,

    /// Voxel size in the mesh's units.
    ///
    /// `auto` is an eighth of the features that go, at least a third of the mean edge, and more on large models.
    #[arg(long, value_name = "LENGTH|auto", default_value = "auto", value_parser = arguments::voxel)]
    voxel: VoxelSize,

    /// Scheme of the flow's steps: I and II are the paper's.
    #[arg(
        long,
        value_enum,
        value_name = "I|II|gauss-newton",
        default_value = "gauss-newton",
        ignore_case = true
    )]
    variant: Scheme,

    /// Length of the new edges over that of the edges round the region, or over the mean of all.
    #[arg(long, value_name = "RATIO", default_value = "1", value_parser = arguments::edge_ratio)]
    edge_ratio: f64,

    #[command(flatten)]
    mask: MaskArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

impl FairArgs {
    fn params(&self, keep_vertices: bool) -> FairParams {
        FairParams {
            extent: match (self.time, self.strength) {
                (Some(time), _) => FairExtent::Time(time),
                (None, Some(strength)) => FairExtent::Strength(strength),
                (None, None) => FairExtent::Auto,
            },
            voxel: self.voxel,
            variant: Variant::from(self.variant),
            edge_ratio: self.edge_ratio,
            keep_vertices,
        }
    }
}

/// Reads, fairs, writes.
pub fn run(args: &FairArgs, console: &Console) -> anyhow::Result<End> {
    args.mask.mask()?;
    args.files.each("fair", &args.common, console, |files| {
        one(args, files, console)
    })
}

fn one(args: &FairArgs, files: &Files<'_>, console: &Console) -> anyhow::Result<End> {
    let loaded = files.read(args.common.from, console)?;
    let marked = args.mask.marked(&loaded)?.map(Marked::some).transpose()?;
    // A glTF document goes through as it is, and so do the numbers of its vertices.
    let params = args.params(files.to_gltf() && loaded.document.is_some());
    let failed = "cannot fair the mesh";
    if files.output.is_none() {
        let plan = isomend::plan_fair(&loaded.mesh, marked.as_deref(), &params).context(failed)?;
        return preview(&plan, &loaded, files);
    }
    let faired = progress::watched(console, region_line, |progress| {
        isomend::fair_with_progress(&loaded.mesh, marked.as_deref(), &params, progress)
    })
    .context(failed)?;
    finish(faired, loaded, files, console)
}

/// Says what would be done, on standard output unless the JSON report goes there.
fn preview(plan: &FairPlan, loaded: &Loaded, files: &Files<'_>) -> anyhow::Result<End> {
    if let Some(documents) = files.documents {
        documents.add(&FairPlanDocument {
            command: files.command,
            version: env!("CARGO_PKG_VERSION"),
            dry_run: true,
            input: FileInfo::new(files.input, loaded.format, &loaded.mesh),
            notes: &loaded.notes,
            plan,
        })?;
    }
    if !files.report_only {
        let what = match plan.whole {
            true => "all of the surface would be replaced".to_owned(),
            false => format!(
                "{} faces marked, {} would be cut out and replaced",
                plan.marked_faces, plan.removed_faces
            ),
        };
        let heading = match files.several {
            true => format!("{}\n", console::heading(&files.input.display().to_string())),
            false => String::new(),
        };
        let text = format!(
            "{heading}features narrower than {} would go, time {:.4e}, voxel {}\n{what}\n",
            length(plan.strength),
            plan.time,
            length(plan.voxel)
        );
        console::print(&text).context("cannot write to standard output")?;
    }
    Ok(End::Done)
}

fn finish(faired: Faired, loaded: Loaded, files: &Files, console: &Console) -> anyhow::Result<End> {
    let Faired {
        mesh,
        kept,
        mut report,
    } = faired;
    let fill_params = FillParams {
        surface: match kept {
            Some(_) => SurfaceKind::Stitched,
            None => SurfaceKind::Whole,
        },
        ..FillParams::default()
    };
    let before = kept.as_ref().and_then(|kept| files.before(&loaded, kept));
    let loaded = match &kept {
        Some(kept) => loaded.restricted(kept),
        None => loaded,
    };
    let output = files.output.as_ref().context("there is no output")?;
    let (mesh, remarks) = output.write(mesh, &loaded, &fill_params, &mut report.fill.regions)?;
    remarks
        .iter()
        .for_each(|note| console.note(&format!("{}: {note}", output.name())));
    tell(&report, console);
    let fill = &report.fill;
    let mut notes = loaded.notes.clone();
    notes.extend(remarks);
    if let Some(documents) = files.documents {
        documents.add(&FairDocument {
            command: files.command,
            version: env!("CARGO_PKG_VERSION"),
            input: FileInfo::of(files.input, loaded.format, fill.vertices, fill.faces),
            output: FileInfo::new(&output.path, output.format, &mesh),
            notes: &notes,
            complete: true,
            volume_drift: report.volume_drift(),
            report: &report,
        })?;
    }
    files.draw(&Drawn {
        command: files.command,
        input: files.input,
        output: &output.path,
        before: before.as_ref(),
        first: &loaded.mesh,
        after: &mesh,
        kept: kept.as_ref().map_or(0, |kept| kept.mesh.faces.len()),
        notes: &notes,
        report: fill,
    })?;
    Ok(End::Done)
}

/// The report of `isomend fair`.
#[derive(Serialize)]
struct FairDocument<'a> {
    command: &'static str,
    version: &'static str,
    input: FileInfo,
    output: FileInfo,
    notes: &'a [String],
    /// Whether every region was faired.
    complete: bool,
    /// Change of the volume over the volume.
    volume_drift: Option<f64>,
    #[serde(flatten)]
    report: &'a FairReport,
}

/// What `isomend fair --dry-run` says.
#[derive(Serialize)]
struct FairPlanDocument<'a> {
    command: &'static str,
    version: &'static str,
    dry_run: bool,
    input: FileInfo,
    notes: &'a [String],
    #[serde(flatten)]
    plan: &'a FairPlan,
}

fn region_line(region: &RegionReport) -> String {
    let steps: usize = region.levels.iter().map(|l| l.flow.steps.len()).sum();
    let rims: Vec<String> = region.holes.iter().map(usize::to_string).collect();
    let name = match rims.is_empty() {
        true => "all of the surface".to_owned(),
        false => format!("inside rim {}", rims.join("+")),
    };
    let mut line = format!(
        "{name}: {steps} steps, {} vertices, {} faces, {:.2} s",
        region.new_vertices, region.new_faces, region.seconds
    );
    if region.intersecting_faces > 0 {
        line += &format!("; {} faces intersect others", region.intersecting_faces);
    }
    line
}

fn tell(report: &FairReport, console: &Console) {
    console.say(&format!(
        "features narrower than {} went, time {:.4e}, voxel {}",
        length(report.strength),
        report.time,
        length(report.voxel)
    ));
    if !report.whole {
        console.say(&format!(
            "{} faces marked, {} cut out",
            report.marked_faces, report.removed_faces
        ));
    }
    if report.pieces_left > 0 {
        console.warn(&format!(
            "{} closed pieces stay as they are beside the open ones; mark them to fair them too",
            report.pieces_left
        ));
    }
    for region in &report.fill.regions {
        // Off a terminal it was told as it ended.
        if console.wants_progress() {
            console.say(&region_line(region));
        }
        for line in level_lines(region) {
            console.detail(&line);
        }
    }
    console.say(&format!(
        "moved by {} at most, {} root mean square",
        length(report.moved_max),
        length(report.moved_rms)
    ));
    if let Some(drift) = report.volume_drift() {
        console.say(&format!("the volume changed by {:+.3} %", 100.0 * drift));
    }
}
