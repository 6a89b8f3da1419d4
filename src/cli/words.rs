//! Renders work as a command line: the command and the options that do the same.

use clap::Parser;
use isomend::job::Work;
use isomend::parameters::{Kind, Table};
use isomend_view::{Command, CommandRenderer};
use serde::Serialize;
use serde_json::Value;

use super::parameters::typed;
use super::{Cli, Command as Parsed};

/// Renders the steps of the interactive view as command lines.
pub struct CommandLine;

impl CommandRenderer for CommandLine {
    fn command(&self, work: &Work, faces: Option<&str>) -> Result<Command, String> {
        let mut command = match work {
            Work::Fill(params) => command(Table::FILL, params),
            Work::Restore(_, params) => command(Table::RESTORE, params),
            Work::Fair(_, params) => command(Table::FAIR, params),
            Work::Repair(params) => command(Table::REPAIR, params),
            Work::Copy | Work::Inspect(_) | Work::Check(_) => Command::new(work.name()),
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

/// Parses a command back into the work that it asks for.
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
        // The files of the mask do not exist yet.
        Work::Restore(_, params) => params.check().map_err(|error| error.to_string())?,
        Work::Fair(..) => {}
        work => work.check().map_err(|error| error.to_string())?,
    }
    Ok(work)
}

/// The work with an empty mask.
fn without_files(mut work: Work) -> Work {
    if let Work::Restore(mask, _) | Work::Fair(Some(mask), _) = &mut work {
        *mask = isomend::job::MaskSpec::default();
    }
    work
}

/// A command with the options of all parameters that differ from their defaults.
fn command<P: Serialize + Default>(table: &'static Table, params: &P) -> Command {
    let mut command = Command::new(table.command);
    let json = |params: &P| serde_json::to_value(params).unwrap_or_default();
    let (values, usual) = (json(params), json(&P::default()));
    for (path, parameter) in table.entries() {
        let at = |values: &Value| path.iter().fold(values.clone(), |v, step| v[*step].clone());
        let value = at(&values);
        if path.is_empty() || parameter.library_only || value == at(&usual) {
            continue;
        }
        let name = parameter.option();
        if matches!(parameter.kind, Kind::Flag(_)) {
            command.flag(&name);
        }
        for text in typed(parameter, &value) {
            command.option(&name, text);
        }
    }
    command
}
