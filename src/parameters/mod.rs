//! The parameters of the commands: name, unit, bounds, default and a sentence of each, declared once in the tables of
//! [`Table::ALL`].
//!
//! From these tables come the options of the command line with their help, the keys of `--config`, the bounds that the library
//! checks and the messages of its errors, the form of the local page, the checks of Python's keywords, the words of a recipe, and
//! the tables of `docs/options.md`. The structs of parameters, such as [`FillParams`](crate::FillParams), hold the values; a test
//! compares their fields and defaults with the tables.

mod rows;
pub(crate) mod solve;
pub(crate) mod tables;

use thiserror::Error;

pub use rows::{ChoiceRow, Row, document};

/// A parameter of one or several commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name in Python and in messages; the option of the command line is the same with dashes.
    pub name: &'static str,
    /// Path of the value in the serialised parameters, with dots between its steps; empty where the parameter chooses the work.
    pub field: &'static str,
    /// What values there are.
    pub kind: Kind,
    /// Unit of a number; empty where it has none.
    pub unit: &'static str,
    /// The value where none is given.
    pub default: Usual,
    /// What the parameter does, in one sentence. Other parameters and words stand in backticks.
    pub sentence: &'static str,
    /// More about it, for the long help and the table of the documentation; may be empty.
    pub details: &'static str,
    /// A parameter that cannot be given beside this one; empty where there is none.
    pub excludes: &'static str,
    /// Whether files are mended without it: the library and Python have it, the command line and the page do not.
    pub library_only: bool,
}

/// What values a parameter has, and how they are typed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A number within bounds, and what stands for it in the help.
    Number(Bounds, &'static str),
    /// A whole number from 1 to a largest one.
    Whole(usize),
    /// A positive length, or `auto`; serialised as a [`VoxelSize`](crate::VoxelSize).
    Voxel,
    /// A positive length, or `full` for none.
    Band,
    /// One of some words.
    Choice(&'static [Choice]),
    /// A flag, and the value of the field where it is given.
    Flag(bool),
    /// Numbers of holes; where this is set also `all`, which is serialised as none.
    Holes(bool),
    /// Groups of holes.
    Groups,
    /// Pairs of numbers of crease ends.
    Pairs,
    /// What holes are filled after, as [`Like`](crate::Like) is written.
    Like,
}

/// A word that can be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The word, as it is typed and serialised.
    pub name: &'static str,
    /// What it stands for; may be empty.
    pub sentence: &'static str,
}

/// Bounds of a number, which has to be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The lower bound.
    pub low: f64,
    /// The upper bound; infinite where there is none.
    pub high: f64,
    /// Whether the bounds themselves are excluded.
    pub open: bool,
}

/// The value of a parameter that is not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Usual {
    /// There is none: nothing is bounded or chosen.
    Unset,
    /// A value, as it is typed.
    Value(&'static str),
    /// It depends on the mesh, or nothing is done: in words.
    Words(&'static str),
    /// It depends on other parameters: that of the last case that holds.
    Cases(&'static [Case]),
}

/// A default that holds where another parameter has a certain value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Case {
    /// The default.
    pub value: &'static str,
    /// The other parameter and the values of it; none for the first case, which holds always.
    pub with: Option<(&'static str, &'static [&'static str])>,
}

/// The parameters of a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    /// The command.
    pub command: &'static str,
    /// Those of its own.
    pub own: &'static [Parameter],
    /// Where the parameters of a solve stand in its serialised parameters, for commands that fill holes; empty for the top.
    pub solve: Option<&'static str>,
}

/// A number that a parameter cannot have.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{parameter} must be {}, but is {value}", bounds.text(*whole))]
pub struct OutOfBounds {
    /// Name of the parameter.
    pub parameter: &'static str,
    /// The number.
    pub value: f64,
    /// The bounds that it has to keep.
    pub bounds: Bounds,
    /// Whether only whole numbers are allowed.
    pub whole: bool,
}

impl Bounds {
    /// Any number greater than 0.
    pub const POSITIVE: Self = Self {
        low: 0.0,
        high: f64::INFINITY,
        open: true,
    };
    /// 0 or any greater number.
    pub const NOT_NEGATIVE: Self = Self {
        low: 0.0,
        high: f64::INFINITY,
        open: false,
    };
    /// A part of a whole.
    pub const PART: Self = Self {
        low: 0.0,
        high: 1.0,
        open: false,
    };

    /// Whether a number keeps them.
    pub fn hold(&self, value: f64) -> bool {
        let inside = match self.open {
            true => value > self.low && value < self.high,
            false => value >= self.low && value <= self.high,
        };
        inside && value.is_finite()
    }

    /// The numbers that keep them, in words.
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
    /// The bounds of its numbers.
    pub fn bounds(&self) -> Option<Bounds> {
        match *self {
            Self::Number(bounds, _) => Some(bounds),
            Self::Whole(most) => Some(Bounds {
                low: 1.0,
                high: most as f64,
                open: false,
            }),
            Self::Voxel | Self::Band => Some(Bounds::POSITIVE),
            _ => None,
        }
    }
}

impl Parameter {
    /// What a parameter has of which nothing else is said: a flag.
    const PLAIN: Self = Self {
        name: "",
        field: "",
        kind: Kind::Flag(true),
        unit: "",
        default: Usual::Unset,
        sentence: "",
        details: "",
        excludes: "",
        library_only: false,
    };

    /// Whether a number keeps the bounds; none always does.
    ///
    /// # Errors
    /// With the name and what is allowed.
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

    /// Its option on the command line, without the dashes before it.
    pub fn option(&self) -> String {
        self.name.replace('_', "-")
    }
}

impl Usual {
    /// In words; empty where there is nothing to say.
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

    /// A text in which other parameters are named as options of the command line, as `--max-diameter`.
    pub fn as_options(&self, text: &str) -> String {
        self.entries().fold(text.to_owned(), |text, (_, p)| {
            text.replace(&format!("`{}`", p.name), &format!("`--{}`", p.option()))
        })
    }

    /// The parameter of a name.
    pub fn get(&self, name: &str) -> Option<&'static Parameter> {
        let mut parameters = self.entries().map(|(_, parameter)| parameter);
        parameters.find(|parameter| parameter.name == name)
    }
}
