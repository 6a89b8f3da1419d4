//! Makes command-line options from the tables of `isomend::parameters`: their help texts, parsing into JSON values, and formatting of JSON
//! values as arguments.

use std::marker::PhantomData;

use anyhow::Context;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use isomend::Like;
use isomend::job;
use isomend::parameters::{Choice, DefaultValue, Kind, Parameter, Table};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::arguments;

/// A command with a table of parameters.
pub trait OfCommand {
    /// The table of its parameters.
    const TABLE: &'static Table;
}

macro_rules! commands {
    ($($name:ident $table:ident),*) => {$(
        #[derive(Debug)]
        pub struct $name;

        impl OfCommand for $name {
            const TABLE: &'static Table = Table::$table;
        }
    )*};
}

commands!(Fill FILL, Restore RESTORE, Fair FAIR, Repair REPAIR, Check CHECK, Sdf SDF, Compare COMPARE, Study STUDY);

/// The parameters of a command that were given, and the defaults of options that have one.
#[derive(Debug)]
pub struct ParameterArgs<C> {
    /// JSON values by the names of their parameters.
    given: Map<String, Value>,
    command: PhantomData<C>,
}

impl<C: OfCommand> ParameterArgs<C> {
    /// The value of a parameter; `None` if it was not given and has no default.
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.given.get(name)
    }

    /// The parameter struct of the command; parameters that were not given have their defaults.
    ///
    /// # Errors
    /// If the table does not match the struct, which a test rules out.
    pub fn params<P: DeserializeOwned>(&self) -> anyhow::Result<P> {
        job::params_of(C::TABLE, &self.given).context("the options do not fit the parameters")
    }
}

impl<C: OfCommand> Args for ParameterArgs<C> {
    fn augment_args(command: Command) -> Command {
        let table = C::TABLE;
        options(table).fold(command, |command, p| command.arg(argument(p, table)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<C: OfCommand> FromArgMatches for ParameterArgs<C> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let value = |p: &Parameter| Some((p.name.to_owned(), given(p, matches)?));
        Ok(Self {
            given: options(C::TABLE).filter_map(value).collect(),
            command: PhantomData,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The parameters of a command that are options.
fn options(table: &'static Table) -> impl Iterator<Item = &'static Parameter> {
    let parameters = table.entries().map(|(_, parameter)| parameter);
    parameters.filter(|parameter| !parameter.library_only)
}

/// The JSON value of an option.
fn given(parameter: &Parameter, matches: &ArgMatches) -> Option<Value> {
    match parameter.kind {
        Kind::Flag(value) => matches
            .get_flag(parameter.name)
            .then_some(Value::Bool(value)),
        Kind::Groups | Kind::Pairs => {
            let groups = matches.get_many::<Value>(parameter.name)?;
            Some(groups.cloned().collect())
        }
        Kind::Words(..) => {
            let lists = matches.get_many::<Value>(parameter.name)?;
            let words = lists.flat_map(|list| list.as_array().into_iter().flatten());
            Some(words.cloned().collect())
        }
        _ => matches.get_one(parameter.name).cloned(),
    }
}

/// The command-line option for a parameter.
fn argument(parameter: &'static Parameter, table: &Table) -> Arg {
    let mut argument = Arg::new(parameter.name).long(parameter.option());
    let mut help = parameter.sentence.to_owned();
    match parameter.default {
        DefaultValue::Value(text) => argument = argument.default_value(text),
        DefaultValue::Unset => {}
        usual => help = format!("{} [default: {}]", help.trim_end_matches('.'), usual.text()),
    }
    let short = table.as_options(help.trim_end_matches('.'));
    argument = argument.help(short);
    if !parameter.details.is_empty() {
        let long = format!("{help}\n\n{}", parameter.details);
        argument = argument.long_help(table.as_options(&long));
    }
    if !parameter.excludes.is_empty() {
        argument = argument.conflicts_with(parameter.excludes);
    }
    match parameter.kind {
        Kind::Flag(_) => argument.action(ArgAction::SetTrue),
        Kind::Choice(choices) => argument
            .value_name(parameter.kind.placeholder())
            .ignore_case(true)
            .value_parser(choice_parser(choices)),
        kind => argument
            .value_name(kind.placeholder())
            // So that a negative number gets the message of its parameter.
            .allow_negative_numbers(true)
            .action(match kind {
                Kind::Groups | Kind::Pairs | Kind::Words(..) => ArgAction::Append,
                _ => ArgAction::Set,
            })
            .value_parser(move |text: &str| parsed(parameter, text)),
    }
}

/// The parser for a parameter with named choices.
fn choice_parser(choices: &'static [Choice]) -> impl TypedValueParser<Value = Value> {
    let possible = choices.iter().map(|choice| {
        let value = PossibleValue::new(choice.name);
        match choice.sentence {
            "" => value,
            sentence => value.help(sentence.trim_end_matches('.')),
        }
    });
    PossibleValuesParser::new(possible)
        .map(|text| Value::from(named(choices, &text).unwrap_or_default()))
}

/// Parses the text of an option into a JSON value.
fn parsed(parameter: &Parameter, text: &str) -> Result<Value, String> {
    let number = || {
        let bounds = parameter.kind.bounds()?;
        let value = text.parse::<f64>().ok()?;
        bounds.hold(value).then_some(value)
    };
    let length = |word: &str| {
        number()
            .ok_or_else(|| format!("a positive length in the mesh's units is needed, or {word}"))
    };
    match parameter.kind {
        Kind::Whole(most) => arguments::count_to(text, most).map(Value::from),
        Kind::Voxel if text == "auto" => Ok(Value::from(text)),
        Kind::Voxel => length("auto").map(|value| serde_json::json!({ "length": value })),
        Kind::Band if text == "full" => Ok(Value::Null),
        Kind::Band => length("full").map(Value::from),
        Kind::Holes(true) if text == "all" => Ok(Value::Null),
        Kind::Holes(_) => arguments::ids(text).map(Value::from),
        Kind::Groups => arguments::bridge(text).map(Value::from),
        Kind::Pairs => arguments::crease(text).map(Value::from),
        Kind::Like => {
            let like: Like = text.parse()?;
            Ok(Value::from(like.to_string()))
        }
        Kind::Number(bounds, _) => {
            let value = number().map(Value::from);
            value.ok_or_else(|| format!("{} is needed", bounds.text(false)))
        }
        Kind::Words(choices, _) => words(text, choices),
        Kind::Choice(_) | Kind::Flag(_) => Ok(Value::from(text)),
    }
}

/// The name of a choice as it is serialised; the case of the word does not matter.
fn named(choices: &[Choice], word: &str) -> Option<&'static str> {
    let same = |choice: &&Choice| choice.name.eq_ignore_ascii_case(word);
    choices.iter().find(same).map(|choice| choice.name)
}

/// Parses words separated by commas.
fn words(text: &str, choices: &[Choice]) -> Result<Value, String> {
    let name = |word: &str| {
        let names: Vec<&str> = choices.iter().map(|choice| choice.name).collect();
        named(choices, word.trim())
            .ok_or_else(|| format!("'{}' is none of {}", word.trim(), names.join(", ")))
    };
    let names: Vec<&str> = text.split(',').map(name).collect::<Result<_, _>>()?;
    Ok(Value::from(names))
}

/// Formats a JSON value as the texts of an option: one for each time that the option is given, none for the default.
pub fn typed(parameter: &Parameter, value: &Value) -> Vec<String> {
    let joined = |ids: &Value, separator: &str| {
        let ids = ids.as_array().into_iter().flatten();
        ids.map(Value::to_string)
            .collect::<Vec<_>>()
            .join(separator)
    };
    match (parameter.kind, value) {
        (Kind::Voxel, value) => match value["length"].as_f64() {
            Some(length) => vec![number(length)],
            None => Vec::new(),
        },
        (Kind::Groups | Kind::Pairs, Value::Array(groups)) => {
            groups.iter().map(|ids| joined(ids, "+")).collect()
        }
        (Kind::Words(..), Value::Array(words)) if !words.is_empty() => {
            let words: Vec<&str> = words.iter().filter_map(Value::as_str).collect();
            vec![words.join(",")]
        }
        (Kind::Words(..), _) => Vec::new(),
        (Kind::Holes(_), Value::Array(_)) => vec![joined(value, ",")],
        (_, Value::String(word)) => vec![word.clone()],
        (Kind::Whole(_), Value::Number(count)) => vec![count.to_string()],
        (_, Value::Number(x)) => x.as_f64().map(number).into_iter().collect(),
        _ => Vec::new(),
    }
}

/// A number as text that parses to the same value.
fn number(x: f64) -> String {
    match x.abs() {
        size if (1e-5..1e15).contains(&size) => x.to_string(),
        _ => format!("{x:e}"),
    }
}
