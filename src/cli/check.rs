//! `isomend check`: what is wrong with a mesh.

use std::path::PathBuf;

use clap::Args;
use isomend::check::CheckParams;
use isomend::job;
use isomend::report::verdict_lines;

use super::console::{self, Console};
use super::input;
use super::json::Target;
use super::parameters::{Check, ParameterArgs};
use super::report::ReportArgs;
use super::{CommonArgs, End};

const EXAMPLES: &str = "\
Examples:
  isomend check part.stl                    yes or no, and why
  isomend check part.stl --thin 0.8         also where it is thinner than a printer's nozzle can make it
  isomend check part.stl -q && print part.stl
  isomend check scan.ply --report scan.html --picture scan.png    the places, marked";

/// Say whether a mesh is watertight and can be printed, and why not.
///
/// Looks for borders, edges with more than two faces, vertices where surfaces meet in a point only, faces that are oriented
/// against each other, closed components that are inside out, degenerate and duplicate faces, and faces that cross or touch
/// others. Vertices at exactly the same position count as one. Crossings are decided exactly. Components that are debris or
/// lie inside others are told, but are no reason for a no.
///
/// Exits with 0 for yes and 3 for no.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct CheckArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy or VTP; `-` is standard input.
    #[arg(value_name = "IN")]
    input: PathBuf,

    #[command(flatten)]
    parameters: ParameterArgs<Check>,

    #[command(flatten)]
    report: ReportArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// Reads and judges.
pub fn run(args: &CheckArgs, console: &Console) -> anyhow::Result<End> {
    let json = args.common.json.as_ref();
    let place = input::place(&args.input);
    if let Some(json) = json {
        json.check(std::slice::from_ref(&place), &[])?;
    }
    let drawings = args.report.drawings(json)?;
    drawings.check(&place, None).map_err(super::told)?;
    let params: CheckParams = args.parameters.params()?;
    let source = input::source(&args.input, args.common.from)?;
    let loaded = input::read(&source, console)?;
    let checked = job::check(&source, &loaded, &params, &drawings).map_err(super::told)?;
    if let Some(json) = json {
        json.write(&checked.document())?;
    }
    if !matches!(json, Some(Target::Stdout)) && !args.common.run.quiet {
        let [low, high] = loaded.mesh.bounds();
        let lines = verdict_lines(&checked.verdict, low.distance(high));
        console::print_out(&(lines.join("\n") + "\n"))?;
    }
    Ok(match checked.verdict.is_sound() {
        true => End::Done,
        false => End::InPart,
    })
}
