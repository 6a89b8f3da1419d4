//! `isomend check`: lists the defects of a mesh and says whether it is watertight and printable.

use clap::Args;
use isomend::Hole;
use isomend::check::{CheckParams, DefectKind, Verdict};
use isomend::job::{Checked, JobSpec, Looked, Work};
use isomend::report::{Standing, verdict_lines};

use super::console::{self, Console};
use super::look::{Look, LookArgs, Shown};
use super::parameters::{Check, ParameterArgs};
use super::{CommonArgs, End};

const EXAMPLES: &str = "\
Examples:
  isomend check part.stl                    yes or no, and why
  isomend check part.stl --thin 0.8         also list parts thinner than a printer's nozzle can make
  isomend check part.stl -q && print part.stl
  isomend check parts/*.stl                 a table with the verdict on each
  isomend check scan.ply --report scan.html --picture scan.png    show where the defects are";

/// Say whether a mesh is watertight and can be printed, and why not.
///
/// Looks for boundary edges, edges with more than two faces, vertices where surfaces meet in a point only, neighbouring faces with
/// opposite orientations, closed components that are inside out, degenerate and duplicate faces, and faces that intersect or touch
/// others. Vertices at exactly the same position count as one. Intersections are decided exactly. Small components and components
/// inside others are listed, but do not make the answer a no.
///
/// Exits with 0 for yes and 3 for no. With several files: 1 if one cannot be read, else 3 if the answer for one is no.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct CheckArgs {
    #[command(flatten)]
    files: LookArgs,

    #[command(flatten)]
    parameters: ParameterArgs<Check>,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// Reads and checks each mesh.
pub fn run(args: &CheckArgs, console: &Console) -> anyhow::Result<End> {
    let params: CheckParams = args.parameters.params()?;
    let look = Look {
        work: Work::Check(params),
        common: &args.common,
        headings: &["faces", "components", "watertight and printable"],
        prints: !args.common.run.quiet,
        show: &|job, looked| match looked {
            Looked::Checked(checked) => shown(job, checked),
            Looked::Inspected(_) => Shown::default(),
        },
    };
    args.files.each(&look, console)
}

/// The verdict on a file as text, and its row.
fn shown(job: &JobSpec, checked: &Checked) -> Shown {
    // The column of the values, in characters.
    const VALUES: usize = 23;
    let verdict = &checked.verdict;
    let [low, high] = checked.loaded.mesh.bounds();
    let mut lines = verdict_lines(verdict, low.distance(high), checked.unit);
    if let Some(command) = next_command(verdict, &checked.found.holes, &job.source.place.name()) {
        lines.extend([String::new(), command]);
    }
    let width = console::width();
    let is_row = |line: &str| line.get(..VALUES).is_some_and(|name| name.contains(": "));
    let wrapped = |line: &String| {
        let indent = if is_row(line) { VALUES } else { 2 };
        console::wrapped(line, width, indent)
    };
    lines = lines.iter().map(wrapped).collect();
    lines[0] = console::verdict(Standing::of_verdict(verdict), &lines[0]);
    let answer = match verdict.is_sound() {
        true => console::verdict(Standing::Yes, "yes"),
        false => {
            let no = console::verdict(Standing::of_verdict(verdict), "no:");
            format!("{no} {}", verdict.reasons().join(", "))
        }
    };
    Shown {
        text: lines.join("\n") + "\n",
        cells: vec![
            verdict.faces.to_string(),
            verdict.components.len().to_string(),
            answer,
        ],
    }
}

/// A line with the command that mends what the verdict names; `None` if there is nothing to mend, or only parts that are thin. A fill leaves
/// outer borders open.
fn next_command(verdict: &Verdict, holes: &[Hole], name: &str) -> Option<String> {
    if verdict.weld.is_some() || verdict.t_junctions > 0 {
        let weld = verdict.weld.filter(|_| !verdict.weld_by_default);
        let option = weld.map_or(String::new(), |(length, _)| format!(" --weld {length:e}"));
        return Some(format!(
            "to close nearly closed boundaries: isomend repair {name} -o OUT{option}"
        ));
    }
    let borders = holes.iter().filter(|h| h.outer_boundary).count();
    let close = match borders {
        0 => "",
        _ => " --close-borders",
    };
    let mut kinds = verdict.defects.iter().map(|defect| defect.kind);
    let is_mended = |kind| !matches!(kind, DefectKind::Thin | DefectKind::ThinWall);
    match kinds.clone().any(is_mended) {
        false => None,
        true if kinds.all(|kind| kind == DefectKind::BoundaryEdge) => {
            Some(match borders > 0 && borders == holes.len() {
                true => format!("to close the outer border: isomend repair {name} -o OUT{close}"),
                false => format!("to close the holes: isomend fill {name} -o OUT"),
            })
        }
        true => Some(format!("to mend it: isomend repair {name} -o OUT{close}")),
    }
}
