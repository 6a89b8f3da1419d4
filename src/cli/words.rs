//! Work in the words of the command line: the options that ask for it.

use clap::Parser;
use isomend::job::Work;
use isomend::view::{Command, Words};
use isomend::{Energy, Variant};
use isomend::{
    FairExtent, FairParams, FillParams, Finish, HoleId, RepairParams, RestoreParams, SurfaceKind,
    VoxelSize,
};

use super::{Cli, Command as Parsed};

/// The command line's words for steps.
pub struct CommandLine;

impl Words for CommandLine {
    fn command(&self, work: &Work, faces: Option<&str>) -> Result<Command, String> {
        let mut command = match work {
            Work::Fill(params) => fill(params),
            Work::Restore(_, params) => restore(params),
            Work::Fair(_, params) => fair(params),
            Work::Repair(params) => repair(params),
            Work::Copy => Command::new(work.name()),
        };
        let plain = command.clone();
        if let Some(faces) = faces {
            command.option("faces", faces);
        }
        match without_files(parsed(&command)?) == without_files(work.clone()) {
            true => Ok(plain),
            false => Err(format!(
                "`isomend {}` has no options for these parameters",
                command.name
            )),
        }
    }
}

/// What a command asks for.
fn parsed(command: &Command) -> Result<Work, String> {
    let mut arguments = vec!["isomend".to_owned()];
    arguments.extend(command.words());
    arguments.extend(["in.ply", "-o", "out.ply"].map(str::to_owned));
    let cli = Cli::try_parse_from(arguments).map_err(|error| {
        let text = error.render().to_string();
        let first = text.lines().next().unwrap_or_default();
        first.trim_start_matches("error: ").to_owned()
    })?;
    let work = match cli.command {
        Parsed::Fill(args) => args.work(),
        Parsed::Restore(args) => args.work(),
        Parsed::Fair(args) => args.work(),
        Parsed::Repair(args) => args.work(),
        Parsed::Convert(_) => Ok(Work::Copy),
        _ => return Err("the command line has no such work".to_owned()),
    };
    let work = work.map_err(|error| format!("{error:#}"))?;
    match &work {
        // The files of a mask are not there yet.
        Work::Restore(_, params) => params.check().map_err(|error| error.to_string())?,
        Work::Fair(..) => {}
        work => work.check().map_err(|error| error.to_string())?,
    }
    Ok(work)
}

/// The work without what its mask chooses.
fn without_files(mut work: Work) -> Work {
    if let Work::Restore(mask, _) | Work::Fair(Some(mask), _) = &mut work {
        *mask = isomend::job::MaskSpec::default();
    }
    work
}

fn fill(params: &FillParams) -> Command {
    let mut command = Command::new("fill");
    holes(&mut command, params);
    solve(&mut command, params);
    command
}

/// Which holes are filled, and how.
fn holes(command: &mut Command, params: &FillParams) {
    if let Some(ids) = &params.holes {
        command.option("holes", joined(ids, ","));
    }
    if let Some(length) = params.max_diameter {
        command.option("max-diameter", number(length));
    }
    if !params.keep_open.is_empty() {
        command.option("keep-open", joined(&params.keep_open, ","));
    }
    for ids in &params.bridge {
        command.option("bridge", joined(ids, "+"));
    }
    if !params.flat.is_empty() {
        command.option("flat", joined(&params.flat, ","));
    }
    if params.surface == SurfaceKind::Whole {
        command.option("surface", "whole");
    }
}

/// The options of the solve.
fn solve(command: &mut Command, params: &FillParams) {
    voxel(command, params.voxel);
    if params.energy == Energy::CurvatureVariation {
        command.option("energy", "curvature-variation");
    }
    match params.finish {
        Finish::Auto => {}
        Finish::Willmore => command.option("finish", "willmore"),
        Finish::None => command.option("finish", "none"),
    }
    variant(command, params.variant);
    if let Some(step) = params.time_step {
        command.option("time-step", number(step));
    }
    if let Some(steps) = params.steps {
        command.option("steps", steps);
    }
    if let Some(ratio) = params.edge_ratio {
        command.option("edge-ratio", number(ratio));
    }
}

fn voxel(command: &mut Command, voxel: VoxelSize) {
    if let VoxelSize::Length(length) = voxel {
        command.option("voxel", number(length));
    }
}

fn variant(command: &mut Command, variant: Variant) {
    match variant {
        Variant::GaussNewton => {}
        Variant::I => command.option("variant", "I"),
        Variant::II => command.option("variant", "II"),
    }
}

fn restore(params: &RestoreParams) -> Command {
    let mut command = Command::new("restore");
    if params.keep_shape != 0.0 {
        command.option("keep-shape", number(params.keep_shape));
    }
    solve(&mut command, &params.fill);
    command
}

fn fair(params: &FairParams) -> Command {
    let mut command = Command::new("fair");
    match params.extent {
        FairExtent::Auto => {}
        FairExtent::Time(time) => command.option("time", number(time)),
        FairExtent::Strength(length) => command.option("strength", number(length)),
    }
    voxel(&mut command, params.voxel);
    variant(&mut command, params.variant);
    if params.edge_ratio != FairParams::default().edge_ratio {
        command.option("edge-ratio", number(params.edge_ratio));
    }
    command
}

/// A repair; where certain holes are chosen, a fill with a repair before it, whose other steps cannot be chosen.
fn repair(params: &RepairParams) -> Command {
    let fills = &params.fill;
    let chosen = fills.holes.is_some() || !fills.bridge.is_empty();
    if chosen || !fills.keep_open.is_empty() || !fills.flat.is_empty() {
        let mut command = fill(fills);
        command.flag("repair");
        return command;
    }
    let mut command = Command::new("repair");
    if let Some(length) = params.weld {
        command.option("weld", number(length));
    }
    if let Some(part) = params.debris {
        command.option("debris", number(part));
    }
    let flags = [
        ("drop-inside", params.drop_inside),
        ("keep-duplicates", !params.clean),
        ("keep-orientation", !params.orient),
        ("keep-non-manifold", !params.split),
        ("keep-crossings", !params.crossings),
        ("drop-unused", params.drop_unused),
        ("keep-holes", !params.holes),
        ("close-borders", params.borders),
    ];
    for (name, _) in flags.iter().filter(|(_, is_set)| *is_set) {
        command.flag(name);
    }
    if let Some(length) = fills.max_diameter {
        command.option("max-diameter", number(length));
    }
    solve(&mut command, fills);
    command
}

/// A number that reads as the same.
fn number(x: f64) -> String {
    match x.abs() {
        size if (1e-5..1e15).contains(&size) => x.to_string(),
        _ => format!("{x:e}"),
    }
}

fn joined(ids: &[HoleId], separator: &str) -> String {
    let ids: Vec<String> = ids.iter().map(HoleId::to_string).collect();
    ids.join(separator)
}
