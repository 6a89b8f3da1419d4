//! `--config FILE`: options from a TOML file. Its entries become arguments in front of the command line's, so that clap checks them
//! like all others. Options on the command line override the options of the file.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::builder::Resettable;
use clap::{Arg, ArgAction, Command, Id, ValueHint};
use isomend::job::Place;
use isomend::parameters::Table;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A usage error on the command line or in an options file that clap does not find.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);

/// Options that a file cannot set.
const NOT_IN_FILES: [&str; 3] = ["config", "help", "version"];

/// Inserts the options of the file that `--config` names, if there is one, after the name of the command.
///
/// # Errors
/// If the file cannot be read, is not TOML, or sets something that is not an option of a command. The message names file and line.
pub fn expand(arguments: Vec<OsString>, program: &Command) -> Result<Vec<OsString>, Usage> {
    let Some(file) = named_file(&arguments) else {
        return Ok(arguments);
    };
    let read = || isomend::io::read_text(&file).map_err(|error| Usage(error.to_string()));
    with_file(arguments, program, &file, read)
}

/// Inserts the options of a file after the name of the command. The file is not read if there is no such command.
///
/// # Errors
/// As [`expand`].
pub fn with_file(
    arguments: Vec<OsString>,
    program: &Command,
    file: &Path,
    read: impl FnOnce() -> Result<String, Usage>,
) -> Result<Vec<OsString>, Usage> {
    let name = arguments[1].to_string_lossy();
    let Some(command) = program.find_subcommand(&*name) else {
        return Ok(arguments);
    };
    let text = read()?;
    refuse_over(file, &arguments[2..])?;
    let source = Source {
        file,
        text: &text,
        program,
    };
    let given = given(command, &arguments[2..]);
    let new = source.arguments(command, &given)?;
    let (head, tail) = arguments.split_at(2);
    Ok(head
        .iter()
        .cloned()
        .chain(new)
        .chain(tail.iter().cloned())
        .collect())
}

/// The file that `--config` names.
fn named_file(arguments: &[OsString]) -> Option<PathBuf> {
    let mut rest = arguments.iter().skip(2).take_while(|a| *a != "--");
    while let Some(argument) = rest.next() {
        if argument == "--config" {
            return rest.next().map(PathBuf::from);
        }
        if let Some(path) = argument.to_str().and_then(|a| a.strip_prefix("--config=")) {
            return Some(path.into());
        }
    }
    None
}

/// Refuses arguments that are the options file itself: it is no mesh, and an output would overwrite it.
fn refuse_over(file: &Path, arguments: &[OsString]) -> Result<(), Usage> {
    let file = Place::from(file);
    let mut is_config = false;
    for argument in arguments {
        let of_option = argument.to_str().filter(|a| a.starts_with('-'));
        let value = of_option.and_then(|a| a.split_once('='));
        let path = match (of_option, value) {
            (Some(_), Some(("--config", _)) | None) => None,
            (Some(_), Some((_, value))) => Some(PathBuf::from(value)),
            (None, _) => Some(PathBuf::from(argument)),
        };
        if !is_config && path.is_some_and(|path| file.is_same_file(&path.into())) {
            let what = format!("{} is the file of --config: name another file", file.name());
            return Err(Usage(what));
        }
        is_config = argument == "--config";
    }
    Ok(())
}

/// The options that are set on the command line.
fn given(command: &Command, arguments: &[OsString]) -> BTreeSet<Id> {
    let mut ids = BTreeSet::new();
    let words = arguments.iter().take_while(|a| *a != "--");
    for word in words.filter_map(|a| a.to_str()) {
        if let Some(long) = word.strip_prefix("--") {
            let name = long.split('=').next().unwrap_or(long);
            ids.extend(option(command, name).map(|arg| arg.get_id().clone()));
        } else if let Some(letters) = word.strip_prefix('-') {
            for letter in letters.chars() {
                let Some(arg) = command
                    .get_arguments()
                    .find(|a| a.get_short() == Some(letter))
                else {
                    break;
                };
                ids.insert(arg.get_id().clone());
                if !is_flag(arg) {
                    break;
                }
            }
        }
    }
    ids
}

/// The option of a command with a long name or an alias.
fn option<'a>(command: &'a Command, name: &str) -> Option<&'a Arg> {
    command.get_arguments().find(|arg| {
        let others = arg.get_all_aliases().unwrap_or_default();
        arg.get_long() == Some(name) || others.contains(&name)
    })
}

fn is_flag(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::SetTrue)
}

/// An options file.
struct Source<'a> {
    file: &'a Path,
    text: &'a str,
    program: &'a Command,
}

/// A key of the file and its value.
type Entry<'t, 'i> = (
    &'t Spanned<std::borrow::Cow<'i, str>>,
    &'t Spanned<DeValue<'i>>,
);

impl Source<'_> {
    /// The arguments for a command. Options that the command line sets, or that conflict with them, are skipped.
    fn arguments(&self, command: &Command, given: &BTreeSet<Id>) -> Result<Vec<OsString>, Usage> {
        let table = DeTable::parse(self.text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            self.fault(at, error.message().trim_end())
        })?;
        let mut arguments = Vec::new();
        for (key, value) in self.entries(table.get_ref(), command)? {
            let Some(arg) = option(command, key.get_ref()) else {
                continue;
            };
            let excluded = command.get_arg_conflicts_with(arg);
            if given.contains(arg.get_id()) || excluded.iter().any(|a| given.contains(a.get_id())) {
                continue;
            }
            let at = key.span().start;
            let spelt = self
                .spelt(arg, value.get_ref())
                .map_err(|what| self.fault(at, &format!("'{}': {what}", key.get_ref())))?;
            self.check(command, &spelt)
                .map_err(|what| self.fault(at, &what))?;
            arguments.extend(spelt);
        }
        Ok(arguments)
    }

    /// The entries for a command; entries of the command's table override top-level ones.
    fn entries<'t, 'i>(
        &self,
        top: &'t DeTable<'i>,
        command: &Command,
    ) -> Result<Vec<Entry<'t, 'i>>, Usage> {
        let (mut common, mut own) = (Vec::new(), Vec::new());
        for (key, value) in top.iter() {
            let name = key.get_ref();
            let DeValue::Table(table) = value.get_ref() else {
                let known = self.program.get_subcommands().any(|c| holds(c, name));
                if !known {
                    return Err(self.unknown(
                        key,
                        command,
                        &format!("option '{name}' of any command"),
                    ));
                }
                common.push((key, value));
                continue;
            };
            let Some(of) = self.program.find_subcommand(&**name) else {
                let what = format!("the table '{name}' is not the name of a command");
                return Err(self.fault(key.span().start, &what));
            };
            for (key, value) in table.iter() {
                if !holds(of, key.get_ref()) {
                    let what = format!("option '{}' of `isomend {name}`", key.get_ref());
                    return Err(self.unknown(key, of, &what));
                }
                if of.get_name() == command.get_name() {
                    own.push((key, value));
                }
            }
        }
        let id = |key: &str| option(command, key).map(Arg::get_id);
        common.retain(|(key, _)| {
            own.iter()
                .all(|(k, _)| id(k.get_ref()) != id(key.get_ref()))
        });
        common.extend(own);
        common.sort_by_key(|(key, _)| key.span().start);
        Ok(common)
    }

    /// The error of a key that is not an option; lists the options of the command `of`.
    fn unknown(&self, key: &Spanned<std::borrow::Cow<'_, str>>, of: &Command, what: &str) -> Usage {
        if let Some(advice) = former(of.get_name(), key.get_ref()) {
            return self.fault(key.span().start, &advice);
        }
        let names = of.get_arguments().filter_map(Arg::get_long);
        let names: Vec<&str> = names.filter(|n| !NOT_IN_FILES.contains(n)).collect();
        let what = format!(
            "there is no {what}; the options of `isomend {}` are {}",
            of.get_name(),
            names.join(", ")
        );
        self.fault(key.span().start, &what)
    }

    /// An option with its value, as arguments. Relative paths become relative to the file's folder.
    fn spelt(&self, arg: &Arg, value: &DeValue<'_>) -> Result<Vec<OsString>, String> {
        let long = arg.get_long().unwrap_or_default();
        if is_flag(arg) {
            return match value {
                DeValue::Boolean(true) => Ok(vec![format!("--{long}").into()]),
                DeValue::Boolean(false) => Ok(Vec::new()),
                _ => Err("true or false is needed".to_owned()),
            };
        }
        let several = matches!(arg.get_action(), ArgAction::Append);
        let values = match value {
            DeValue::Array(items) if several && !items.iter().all(|i| is_number(i.get_ref())) => {
                let items: Result<Vec<_>, _> = items.iter().map(|i| single(i.get_ref())).collect();
                items?
            }
            value => vec![single(value)?],
        };
        let path = matches!(
            arg.get_value_hint(),
            ValueHint::AnyPath | ValueHint::FilePath | ValueHint::DirPath
        );
        let spell = |value: String| {
            let mut spelt = OsString::from(format!("--{long}="));
            if path && value != "-" {
                let folder = self.file.parent().unwrap_or(Path::new(""));
                spelt.push(folder.join(value));
            } else {
                spelt.push(value);
            }
            spelt
        };
        Ok(values.into_iter().map(spell).collect())
    }

    /// Lets clap check a single option.
    fn check(&self, command: &Command, spelt: &[OsString]) -> Result<(), String> {
        let alone = command.clone().mut_args(|arg| {
            arg.required(false)
                .required_unless_present(Resettable::Reset)
        });
        let name = OsString::from("isomend");
        let words = std::iter::once(&name).chain(spelt);
        let Err(error) = alone.try_get_matches_from(words) else {
            return Ok(());
        };
        let text = error.to_string();
        let lines = text.lines().take_while(|line| !line.is_empty());
        let text = lines.map(str::trim).collect::<Vec<_>>().join(" ");
        Err(text.trim_start_matches("error: ").to_owned())
    }

    /// An error at a byte of the file, with file name and line.
    fn fault(&self, at: usize, what: &str) -> Usage {
        let line = 1 + self.text[..at.min(self.text.len())].matches('\n').count();
        Usage(format!("{}, line {line}: {what}", self.file.display()))
    }
}

/// What takes the place of a former option of a command, as a message; none for any other name.
pub fn former(command: &str, option: &str) -> Option<String> {
    let table = Table::ALL.iter().find(|table| table.command == command)?;
    let now = table.in_place_of(&option.replace('-', "_"))?;
    Some(format!(
        "`isomend {command}` has no --{option} any more: use {now}"
    ))
}

/// Whether a file may set an option of this name for a command.
fn holds(command: &Command, name: &str) -> bool {
    !NOT_IN_FILES.contains(&name) && option(command, name).is_some()
}

fn is_number(value: &DeValue<'_>) -> bool {
    matches!(value, DeValue::Integer(_) | DeValue::Float(_))
}

/// One value as text; a list of numbers is joined by commas.
fn single(value: &DeValue<'_>) -> Result<String, String> {
    match value {
        DeValue::String(text) => Ok(text.clone().into_owned()),
        DeValue::Integer(number) if number.radix() == 10 => Ok(number.as_str().to_owned()),
        DeValue::Float(number) => Ok(number.as_str().to_owned()),
        DeValue::Array(items) if items.iter().all(|i| is_number(i.get_ref())) => {
            let numbers: Result<Vec<_>, _> = items.iter().map(|i| single(i.get_ref())).collect();
            Ok(numbers?.join(","))
        }
        DeValue::Array(_) => Err("one value or a list of numbers is needed".to_owned()),
        _ => Err("a text or a number is needed".to_owned()),
    }
}
