//! Numbers with nouns, percentages, and run times, in words.

use isomend_core::mesh::{Unit, significant};

/// A number with a noun, in the singular for 1.
#[doc(hidden)]
pub fn counted(n: usize, noun: &str) -> String {
    match (n, noun.strip_suffix("vertex")) {
        (1, _) => format!("1 {noun}"),
        (_, Some(before)) => format!("{n} {before}vertices"),
        _ if noun.ends_with("ch") => format!("{n} {noun}es"),
        _ => format!("{n} {noun}s"),
    }
}

/// How many boundary chains do not close.
pub(crate) fn open_chains(n: usize) -> String {
    match n {
        1 => "1 boundary chain does not close".to_owned(),
        n => format!("{n} boundary chains do not close"),
    }
}

/// A percentage with at most three significant digits.
pub(crate) fn percent(x: f64) -> String {
    format!("{} %", significant(x, 3))
}

/// The line over a table that names the unit of its lengths.
#[doc(hidden)]
pub fn lengths_in(unit: Option<Unit>) -> String {
    let unit = unit.map_or("mesh units".to_owned(), |unit| unit.to_string());
    format!("lengths in {unit}:")
}

/// An expected error with two significant digits, as in the table of holes.
pub(crate) fn error_text(unit: Option<Unit>, x: f64) -> String {
    let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
    significant(x, 2) + &unit
}

/// The end of a line with a run time; empty if run times are left out.
#[doc(hidden)]
pub fn timed(seconds: f64) -> String {
    match seconds {
        0.0 => String::new(),
        seconds => format!(", {seconds:.2} s"),
    }
}

/// A number with a description whose first noun is in the plural; in the singular for 1.
pub(super) fn counted_as(n: usize, what: &str) -> String {
    match n {
        1 => format!("1 {}", singular(what)),
        _ => format!("{n} {what}"),
    }
}

/// A description with its first noun in the singular.
pub(super) fn singular(what: &str) -> String {
    let nouns = [
        ("vertices ", "vertex "),
        ("faces ", "face "),
        ("edges ", "edge "),
        ("components ", "component "),
        ("T-junctions ", "T-junction "),
        ("bodies ", "body "),
        ("skins ", "skin "),
    ];
    let spaced = format!("{what} ");
    let at = nouns
        .iter()
        .filter_map(|(many, one)| Some((spaced.find(many)?, many, one)));
    match at.min_by_key(|(at, ..)| *at) {
        Some((_, many, one)) => spaced.replacen(many, one, 1).trim_end().to_owned(),
        None => what.to_owned(),
    }
}
