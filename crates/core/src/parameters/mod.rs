//! The parameters of the commands, declared once in the tables of [`Table::ALL`]: name, unit, bounds, default and description of
//! each.
//!
//! These tables generate the options of the command line with their help, the keys of `--config`, the bounds that the library checks
//! and its error messages, the forms of the local page, the checks of Python's keywords, the commands of a recipe, and the tables of
//! `docs/options.md`. The parameter structs, such as [`FillParams`](crate::fill::FillParams), hold the values; a test compares their fields
//! and defaults with the tables.

mod rows;
#[doc(hidden)]
pub mod solve;
pub(crate) mod tables;

use thiserror::Error;

pub use rows::{ChoiceRow, Row, document};

/// A parameter of one or several commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name in Python and in messages; the option of the command line is the same with dashes.
    pub name: &'static str,
    /// Path of the value in the serialised parameters, separated by dots; empty if the parameter selects the command's work instead.
    pub field: &'static str,
    /// The type of its values.
    pub kind: Kind,
    /// Unit of a number; empty where it has none.
    pub unit: &'static str,
    /// The value if none is given.
    pub default: DefaultValue,
    /// What the parameter does, in one sentence. Names of other parameters and values are in backticks.
    pub sentence: &'static str,
    /// Further text for the long help and the documentation; may be empty.
    pub details: &'static str,
    /// A parameter that cannot be combined with this one; may be empty.
    pub excludes: &'static str,
    /// Whether only the library and Python have it, not the command line and the page.
    pub library_only: bool,
}

/// The type of a parameter's values, and how they are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A number within bounds, and its placeholder in the help.
    Number(NumberBounds, &'static str),
    /// A whole number from 1 to the given maximum.
    Whole(usize),
    /// A positive length, or `auto`; serialised as a [`VoxelSize`](crate::region::VoxelSize).
    Voxel,
    /// A positive length, or `full` for no limit.
    Band,
    /// One of several words.
    Choice(&'static [Choice]),
    /// Any of several words, and the placeholder of one; serialised as a list.
    Words(&'static [Choice], &'static str),
    /// A flag, and the value of the field if the flag is given.
    Flag(bool),
    /// Numbers of holes; if `true`, also `all`, which is serialised as none.
    Holes(bool),
    /// Groups of holes.
    Groups,
    /// Pairs of numbers of crease ends.
    Pairs,
    /// A counterpart, as [`Like`](crate::fill::Like) is written.
    Like,
}

/// A word that can be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The word, as it is written and serialised.
    pub name: &'static str,
    /// Its meaning; may be empty.
    pub sentence: &'static str,
}

/// Bounds of a number, which must be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NumberBounds {
    /// The lower bound.
    pub low: f64,
    /// The upper bound; infinite for none.
    pub high: f64,
    /// Whether the bounds themselves are excluded.
    pub open: bool,
}

/// The value of a parameter that is not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DefaultValue {
    /// None: there is no limit or selection.
    Unset,
    /// A value, as it is written.
    Value(&'static str),
    /// A default that depends on the mesh, or no action; described in words.
    Words(&'static str),
    /// A default that depends on other parameters: the value of the last case that applies.
    Cases(&'static [Case]),
}

/// A default that applies if another parameter has one of several values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Case {
    /// The default.
    pub value: &'static str,
    /// The other parameter and its values; none for the first case, which always applies.
    pub with: Option<(&'static str, &'static [&'static str])>,
}

/// The parameters of a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    /// The command's name.
    pub command: &'static str,
    /// The parameters of this command alone.
    pub own: &'static [Parameter],
    /// For commands that fill holes: path of the shared parameters of `solve::SOLVE` in the serialised parameters; empty for the top
    /// level.
    pub solve: Option<&'static str>,
    /// Former parameters, by name, and what takes their place, as on the command line.
    pub former: &'static [(&'static str, &'static str)],
}

/// The error of a number outside a parameter's bounds.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{parameter} must be {}, but is {value}", bounds.text(*whole))]
pub struct OutOfBounds {
    /// Name of the parameter.
    pub parameter: &'static str,
    /// The number.
    pub value: f64,
    /// The allowed bounds.
    pub bounds: NumberBounds,
    /// Whether the parameter takes whole numbers only.
    pub whole: bool,
}

impl NumberBounds {
    /// Any number greater than 0.
    pub const POSITIVE: Self = Self {
        low: 0.0,
        high: f64::INFINITY,
        open: true,
    };
    /// 0 or any positive number.
    pub const NOT_NEGATIVE: Self = Self {
        low: 0.0,
        high: f64::INFINITY,
        open: false,
    };
    /// A fraction, from 0 to 1.
    pub const PART: Self = Self {
        low: 0.0,
        high: 1.0,
        open: false,
    };

    /// Whether a finite number is within the bounds.
    pub fn hold(&self, value: f64) -> bool {
        let inside = match self.open {
            true => value > self.low && value < self.high,
            false => value >= self.low && value <= self.high,
        };
        inside && value.is_finite()
    }

    /// The allowed numbers, in words.
    pub fn text(&self, whole: bool) -> String {
        let Self { low, high, open } = self;
        match (whole, *open) {
            (true, _) => format!("a whole number from {low} to {high}"),
            (false, true) if *low == 0.0 && high.is_infinite() => "a positive number".to_owned(),
            (false, true) => format!("a number between {low} and {high}"),
            (false, false) => format!("a number from {low} to {high}"),
        }
    }
}

impl Kind {
    /// The bounds of its numbers; none for other types.
    pub fn bounds(&self) -> Option<NumberBounds> {
        match *self {
            Self::Number(bounds, _) => Some(bounds),
            Self::Whole(most) => Some(NumberBounds {
                low: 1.0,
                high: most as f64,
                open: false,
            }),
            Self::Voxel | Self::Band => Some(NumberBounds::POSITIVE),
            _ => None,
        }
    }
}

impl Parameter {
    /// The values that a table entry takes over: a flag without name and text.
    const PLAIN: Self = Self {
        name: "",
        field: "",
        kind: Kind::Flag(true),
        unit: "",
        default: DefaultValue::Unset,
        sentence: "",
        details: "",
        excludes: "",
        library_only: false,
    };

    /// Checks a number against the bounds; an absent number always passes.
    ///
    /// # Errors
    /// [`OutOfBounds`], with the parameter's name and the allowed numbers.
    pub fn check(&self, value: impl Into<Option<f64>>) -> Result<(), OutOfBounds> {
        match (value.into(), self.kind.bounds()) {
            (Some(value), Some(bounds)) if !bounds.hold(value) => Err(OutOfBounds {
                parameter: self.name,
                value,
                bounds,
                whole: matches!(self.kind, Kind::Whole(_)),
            }),
            _ => Ok(()),
        }
    }

    /// Its option on the command line, without the leading dashes.
    pub fn option(&self) -> String {
        self.name.replace('_', "-")
    }
}

impl DefaultValue {
    /// The default in words; empty for [`DefaultValue::Unset`].
    pub fn text(&self) -> String {
        match self {
            Self::Unset => String::new(),
            Self::Value(text) | Self::Words(text) => (*text).to_owned(),
            Self::Cases(cases) => {
                let text = |case: &Case| match case.with {
                    Some((name, values)) => {
                        format!("{} with `{name}` {}", case.value, values.join(" or "))
                    }
                    None => case.value.to_owned(),
                };
                let texts: Vec<String> = cases.iter().map(text).collect();
                texts.join(", ")
            }
        }
    }
}

impl Table {
    /// All parameters, with the paths of their values in the serialised parameters.
    pub fn entries(&self) -> impl Iterator<Item = (Vec<&'static str>, &'static Parameter)> {
        let own = self.own.iter().map(|p| (None, p));
        let solve = self.solve.into_iter().flat_map(|at| {
            let at = Some(at).filter(|at| !at.is_empty());
            solve::SOLVE.iter().map(move |p| (at, p))
        });
        own.chain(solve).map(|(at, parameter)| {
            let steps = parameter.field.split('.').filter(|step| !step.is_empty());
            (at.into_iter().chain(steps).collect(), parameter)
        })
    }

    /// Replaces the names of parameters in a text by the options of the command line, such as `--max-diameter`.
    pub fn as_options(&self, text: &str) -> String {
        self.entries().fold(text.to_owned(), |text, (_, p)| {
            text.replace(&format!("`{}`", p.name), &format!("`--{}`", p.option()))
        })
    }

    /// What takes the place of a former parameter; none for any other name.
    pub fn in_place_of(&self, name: &str) -> Option<&'static str> {
        let former = self.former.iter().find(|(former, _)| *former == name);
        former.map(|(_, now)| *now)
    }

    /// The parameter with the given name.
    pub fn get(&self, name: &str) -> Option<&'static Parameter> {
        let mut parameters = self.entries().map(|(_, parameter)| parameter);
        parameters.find(|parameter| parameter.name == name)
    }
}
