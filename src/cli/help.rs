//! The help texts: options in groups by task, and in the short help (`-h`) of commands with many options the most needed ones only.

use clap::{Arg, Command};

/// Options by group, in the order of the help texts. An option that is in none, and one that is [most needed](NEEDED), comes first.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Files", &["to", "ascii", "from", "unit", "dry_run"]),
    (
        "Holes",
        &[
            "holes",
            "max_diameter",
            "keep_open",
            "bridge",
            "apart",
            "flat",
            "crease",
            "flat_base",
            "base_offset",
        ],
    ),
    (
        "Repair",
        &[
            "solid",
            "close_borders",
            "wall",
            "drop",
            "drop_inside",
            "debris",
            "weld",
            "skip",
            "drop_unused",
        ],
    ),
    (
        "Patches",
        &[
            "keep_shape",
            "voxel",
            "energy",
            "finish",
            "sharp",
            "like",
            "grain",
            "edge_ratio",
            "strict",
        ],
    ),
    (
        "Results",
        &[
            "report",
            "picture",
            "json",
            "piece",
            "clearance",
            "patches",
            "mark",
            "no_texture",
            "paint",
            "tolerance",
        ],
    ),
    ("Run", &["config", "threads", "quiet", "verbose", "help"]),
];

/// For commands with many options those that most people need, which the short help lists.
const NEEDED: [(&str, &[&str]); 4] = [
    (
        "fill",
        &[
            "output",
            "holes",
            "max_diameter",
            "keep_open",
            "flat",
            "report",
        ],
    ),
    (
        "repair",
        &[
            "output",
            "solid",
            "close_borders",
            "drop_inside",
            "min_wall",
            "report",
        ],
    ),
    (
        "restore",
        &[
            "output",
            "ball",
            "mask",
            "colour",
            "grow",
            "keep_shape",
            "piece",
        ],
    ),
    (
        "fair",
        &["output", "strength", "ball", "mask", "colour", "grow"],
    ),
];

/// The program with the options of its commands in groups.
pub fn grouped(program: Command) -> Command {
    program.mut_subcommands(|command| {
        let name = command.get_name().to_owned();
        let needed = NEEDED.iter().find(|(of, _)| *of == name);
        let needed = needed.map(|(_, options)| *options);
        let command = command.mut_args(|option| placed(option, needed, &name));
        let command = with_examples(command);
        match needed {
            Some(_) => with_hint(command, &name),
            None => command,
        }
    })
}

/// An option of a command in its group. Options of masks keep theirs, so that they stand together.
fn placed(option: Arg, needed: Option<&[&str]>, command: &str) -> Arg {
    let name = name_of(&option);
    let is_needed = needed.is_some_and(|needed| needed.contains(&name.as_str()));
    let is_mask = option.get_help_heading() == Some(super::mask::HEADING);
    if (is_needed && !is_mask) || option.is_positional() {
        return option.help_heading(None::<&str>);
    }
    let group = GROUPS.iter().find(|(_, own)| own.contains(&name.as_str()));
    let option = match group {
        // `check` has the threshold of debris, but repairs nothing.
        Some(("Repair", _)) if command == "check" => option,
        Some((heading, _)) => option.help_heading(*heading),
        None => option,
    };
    option.hide_short_help(needed.is_some() && !is_needed)
}

/// A command whose examples have their explanations on lines of their own, which terminals of any width keep.
fn with_examples(command: Command) -> Command {
    let Some(examples) = command.get_after_help().map(ToString::to_string) else {
        return command;
    };
    let line = |line: &str| match line.trim_start().split_once("  ") {
        Some((example, what)) => format!("  {example}\n      {}", what.trim_start()),
        None => line.to_owned(),
    };
    let lines: Vec<String> = examples.lines().map(line).collect();
    command.after_help(lines.join("\n"))
}

/// The name of an option, with underscores.
fn name_of(option: &Arg) -> String {
    option.get_long().unwrap_or_default().replace('-', "_")
}

/// A command whose short help says where all options are.
fn with_hint(command: Command, name: &str) -> Command {
    let examples = command.get_after_help().cloned().unwrap_or_default();
    let short = format!("{examples}\n\n`isomend {name} --help` lists all options, by task.");
    command.after_help(short).after_long_help(examples)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::super::Cli;
    use super::*;

    /// The help text of a command, as `-h` or `--help` prints it.
    fn help(name: &str, long: bool) -> String {
        let mut program = grouped(Cli::command());
        let command = program.find_subcommand_mut(name).unwrap();
        match long {
            true => command.render_long_help().to_string(),
            false => command.render_help().to_string(),
        }
    }

    #[test]
    fn the_short_help_lists_the_most_needed_options_and_the_long_one_all() {
        for (name, needed) in NEEDED {
            let (short, long) = (help(name, false), help(name, true));
            let listed = |text: &str| {
                text.lines()
                    .filter(|l| l.trim_start().starts_with('-'))
                    .count()
            };
            assert_eq!(listed(&short), needed.len() + 1, "{short}");
            assert!(short.lines().count() <= 45, "{short}");
            assert!(short.contains("--help` lists all options"), "{short}");
            let program = Cli::command();
            let all = program.find_subcommand(name).unwrap().get_arguments();
            for option in all.filter_map(Arg::get_long) {
                assert!(
                    long.contains(&format!("--{option} "))
                        || long.contains(&format!("--{option}\n")),
                    "{option}"
                );
            }
            assert!(
                long.contains("\nPatches:") || name == "fair" && long.contains("\nRun:"),
                "{long}"
            );
        }
    }

    #[test]
    fn groups_name_options_that_exist() {
        let program = Cli::command();
        let of_all: Vec<&Arg> = program
            .get_subcommands()
            .flat_map(Command::get_arguments)
            .collect();
        let exists = |name: &str| name == "help" || of_all.iter().any(|a| name_of(a) == name);
        let grouped = GROUPS.iter().flat_map(|(_, own)| own.iter());
        for name in grouped.chain(NEEDED.iter().flat_map(|(_, own)| own.iter())) {
            assert!(exists(name), "{name}");
        }
    }
}
