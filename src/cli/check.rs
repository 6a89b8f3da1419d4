//! `isomend check`: what is wrong with a mesh.

use std::path::PathBuf;

use clap::Args;
use isomend::Unit;
use isomend::check::{CheckParams, Verdict};
use isomend::job;
use isomend::report::verdict_lines;

use super::console::Console;
use super::parameters::{Check, ParameterArgs};
use super::report::ReportArgs;
use super::several::{Found, Looking};
use super::{CommonArgs, End};

const EXAMPLES: &str = "\
Examples:
  isomend check part.stl                    yes or no, and why
  isomend check part.stl --thin 0.8         also where it is thinner than a printer's nozzle can make it
  isomend check part.stl -q && print part.stl
  isomend check parts/*.stl                 a table with the verdict on each
  isomend check scan.ply --report scan.html --picture scan.png    the places, marked";

/// Say whether a mesh is watertight and can be printed, and why not.
///
/// Looks for borders, edges with more than two faces, vertices where surfaces meet in a point only, faces that are oriented
/// against each other, closed components that are inside out, degenerate and duplicate faces, and faces that cross or touch
/// others. Vertices at exactly the same position count as one. Crossings are decided exactly. Components that are debris or
/// lie inside others are told, but are no reason for a no.
///
/// Exits with 0 for yes and 3 for no; of several files with 1 where one cannot be read, else with 3 where one is a no.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct CheckArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy, VTP, OFF or 3MF; `-` is standard input. Of several a table is printed.
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,

    #[command(flatten)]
    parameters: ParameterArgs<Check>,

    /// The unit of the mesh's coordinates: mm, cm, m, in, um or ft. It stands with lengths, also in --json and --report.
    #[arg(long, value_name = "UNIT")]
    unit: Option<Unit>,

    #[command(flatten)]
    report: ReportArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// Reads and judges.
pub fn run(args: &CheckArgs, console: &Console) -> anyhow::Result<End> {
    let params: CheckParams = args.parameters.params()?;
    let looking = Looking {
        command: "check",
        inputs: &args.inputs,
        report: &args.report,
        common: &args.common,
        unit: args.unit,
        headings: &["faces", "components", "watertight and printable"],
        prints: !args.common.run.quiet,
    };
    looking.each(console, &mut |source, loaded, drawings| {
        let checked =
            job::check(source, loaded, &params, args.unit, drawings).map_err(super::told)?;
        let verdict = &checked.verdict;
        let [low, high] = loaded.mesh.bounds();
        let mut lines = verdict_lines(verdict, low.distance(high), args.unit);
        if let Some(command) = mending(verdict, &source.place.name()) {
            lines.extend([String::new(), command]);
        }
        let answer = match verdict.is_sound() {
            true => "yes".to_owned(),
            false => format!("no: {}", verdict.reasons().join(", ")),
        };
        Ok(Found {
            text: lines.join("\n") + "\n",
            cells: vec![
                verdict.faces.to_string(),
                verdict.components.len().to_string(),
                answer,
            ],
            document: Found::document(&checked.document())?,
            is_good: verdict.is_sound(),
        })
    })
}

/// The command that closes borders which vertices lie on, or which nearly coincide.
fn mending(verdict: &Verdict, name: &str) -> Option<String> {
    let weld = verdict.weld.filter(|_| !verdict.weld_by_default);
    let closes = verdict.weld.is_some() || verdict.t_junctions > 0;
    closes.then(|| {
        let option = weld.map_or(String::new(), |(length, _)| format!(" --weld {length:e}"));
        format!("to close what nearly is: isomend repair {name} -o OUT{option}")
    })
}
