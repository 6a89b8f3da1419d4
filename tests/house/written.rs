//! Files generated from the parameter tables: the tables of `docs/options.md`, and the keywords of Python's functions in
//! `_options.py` and `_functions.py`. `RENEW=1 cargo test --test house written` writes all of them again.

use isomend::parameters::{DefaultValue, Kind, Parameter, Table};
use isomend_core::parameters::solve;

use super::renewed::renewed;

/// A sentence on the parameter that excludes this one.
fn excluded(parameter: &Parameter) -> String {
    match parameter.excludes {
        "" => String::new(),
        other => format!("Not with `{other}`."),
    }
}

/// A row of an options table.
fn row(parameter: &Parameter, table: &Table) -> String {
    let value = parameter.kind.placeholder().replace('|', "\\|");
    let option = format!("--{} {value}", parameter.option());
    // `--help` has the details.
    let what = format!("{} {}", parameter.sentence, excluded(parameter));
    let what = table.as_options(what.trim_end_matches(['.', ' ']));
    // The page says so once.
    let what = what
        .replace(", in the mesh's units", "")
        .replace(" in the mesh's units", "");
    let default = match parameter.default {
        DefaultValue::Value(text) => format!("`{text}`"),
        usual => table.as_options(&usual.text()),
    };
    format!("| `{}` | {what} | {default} |\n", option.trim_end())
}

#[test]
fn the_page_of_options_has_the_tables() {
    renewed("docs/options.md", |page| {
        let mut made = String::new();
        let mut rest = page;
        let mut count = 0;
        while let Some((before, after)) = rest.split_once("<!-- parameters of ") {
            let (command, after) = after.split_once(" -->\n").unwrap();
            let (_, after) = after.split_once("<!-- end -->").unwrap();
            let table = Table::ALL.iter().find(|t| t.command == command).unwrap();
            made += before;
            made += &format!(
                "<!-- parameters of {command} -->\n\n| option | meaning | default |\n|---|---|---|\n"
            );
            // The solve's parameters are in the table of `fill`.
            let solve = table.solve.filter(|at| at.is_empty()).map(|_| solve::SOLVE);
            for parameter in table.own.iter().chain(solve.unwrap_or_default()) {
                // What a repair shares with a fill is in the table of `fill`.
                let is_shared = command == Table::REPAIR.command
                    && Table::FILL
                        .own
                        .iter()
                        .any(|p| p.option() == parameter.option());
                if !parameter.library_only && !is_shared {
                    made += &row(parameter, table);
                }
            }
            made += "\n<!-- end -->";
            rest = after;
            count += 1;
        }
        assert_eq!(count, Table::ALL.len(), "tables of parameters");
        made + rest
    });
}

/// The type annotation of a Python keyword.
fn annotation(parameter: &Parameter) -> String {
    let is_set = matches!(parameter.default, DefaultValue::Value(_));
    let optional = |name: &str| match is_set {
        true => name.to_owned(),
        false => format!("{name} | None"),
    };
    match parameter.kind {
        Kind::Number(..) => optional("float"),
        Kind::Whole(_) => optional("int"),
        Kind::Voxel => "Voxel".to_owned(),
        Kind::Band => "float | Literal['full']".to_owned(),
        Kind::Choice(choices) => {
            let names: Vec<String> = choices.iter().map(|c| format!("\"{}\"", c.name)).collect();
            format!("Literal[{}]", names.join(", "))
        }
        Kind::Words(choices, _) => {
            let names: Vec<String> = choices.iter().map(|c| format!("\"{}\"", c.name)).collect();
            format!("Iterable[Literal[{}]]", names.join(", "))
        }
        Kind::Flag(_) => "bool".to_owned(),
        Kind::Holes(true) => "Iterable[int | Hole] | Literal['all'] | None".to_owned(),
        // Numbers of components.
        Kind::Holes(false) if parameter.name == "drop" => "Iterable[int]".to_owned(),
        Kind::Holes(false) => "Iterable[int | Hole]".to_owned(),
        Kind::Groups => "Iterable[Iterable[int | Hole]]".to_owned(),
        Kind::Pairs => "Iterable[Iterable[int | CreaseEnd]]".to_owned(),
        // A path, a mesh of isomend or of another package, or a pair of arrays.
        Kind::Like => "Any".to_owned(),
    }
}

#[test]
fn the_option_classes_of_python_equal_the_tables() {
    let class = |name: &str, base: &str, about: &str, parameters: &[Parameter]| {
        let mut text =
            format!("\n\nclass {name}({base}, total=False):\n    \"\"\"{about}\"\"\"\n\n");
        for parameter in parameters {
            text += &format!("    {}: {}\n", parameter.name, annotation(parameter));
        }
        text
    };
    renewed("python/isomend/_options.py", |_| {
        let mut text = "\
\"\"\"The keywords of functions, written from the library's tables of parameters: see docs/ARCHITECTURE.md.\"\"\"

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal

from isomend._holes import CreaseEnd, Hole
from isomend._params import RunOptions, Voxel
"
        .to_owned();
        let about = "The parameters of all works that fill holes.";
        text += &class("SolveOptions", "RunOptions", about, solve::SOLVE);
        for (table, name) in [
            (Table::FILL, "Fill"),
            (Table::REPAIR, "Repair"),
            (Table::RESTORE, "Restore"),
            (Table::FAIR, "Fair"),
        ] {
            let base = table.solve.map_or("RunOptions", |_| "SolveOptions");
            let about = format!("The keywords of :func:`isomend.{}`.", table.command);
            text += &class(&format!("{name}Options"), base, &about, table.own);
        }
        text
    });
}

/// The default of a Python keyword.
fn keyword_default(parameter: &Parameter) -> String {
    let text = match (parameter.kind, parameter.default) {
        (Kind::Flag(_), _) => "False",
        (Kind::Holes(false) | Kind::Groups | Kind::Pairs | Kind::Words(..), _) => "()",
        (Kind::Number(..) | Kind::Whole(_), DefaultValue::Value(text)) => text,
        (Kind::Voxel | Kind::Band | Kind::Choice(_), DefaultValue::Value(text)) => {
            return format!("\"{text}\"");
        }
        _ => "None",
    };
    text.to_owned()
}

/// Wraps words in lines of at most 128 characters: the first line is indented by `first`, the others by `later` spaces.
fn wrapped(words: &str, first: usize, later: usize) -> String {
    let mut text = " ".repeat(first);
    let mut length = first;
    for (i, word) in words.split(' ').enumerate() {
        let count = word.chars().count();
        if i > 0 && length + 1 + count > 128 {
            text += &format!("\n{}", " ".repeat(later));
            length = later;
        } else if i > 0 {
            text.push(' ');
            length += 1;
        }
        text += word;
        length += count;
    }
    text + "\n"
}

/// The documentation of a keyword in a Python docstring.
fn documented(parameter: &Parameter) -> String {
    let usual = match parameter.default {
        DefaultValue::Unset | DefaultValue::Value(_) => String::new(),
        usual => format!(" By default {}.", usual.text()),
    };
    let (name, sentence, not) = (parameter.name, parameter.sentence, excluded(parameter));
    let text = format!("{name}: {sentence}{usual} {not}");
    wrapped(&text.trim_end().replace('`', "``"), 8, 12)
}

/// Replaces the lines after the first mark (searched from `place`) up to the second mark.
fn between(text: &str, place: &str, marks: [&str; 2], new: &str) -> String {
    // The last one: overloads of a function come before it.
    let from = text.rfind(place).unwrap();
    let begin = from + text[from..].find(marks[0]).unwrap() + marks[0].len();
    let begin = begin + text[begin..].find('\n').unwrap() + 1;
    let end = begin + text[begin..].find(marks[1]).unwrap();
    format!("{}{new}{}", &text[..begin], &text[end..])
}

#[test]
fn the_functions_of_python_have_the_keywords_of_the_tables() {
    renewed("python/isomend/_functions.py", |text| {
        let mut text = text.to_owned();
        for table in [Table::FILL, Table::REPAIR] {
            let all: Vec<&Parameter> = table.own.iter().chain(solve::SOLVE).collect();
            let place = format!("def {}(", table.command);
            let keyword = |p: &&Parameter| {
                let (name, default) = (p.name, keyword_default(p));
                format!("    {name}: {} = {default},\n", annotation(p))
            };
            let keywords: String = all.iter().map(keyword).collect();
            text = between(&text, &place, ["    *,", "    threads: "], &keywords);
            let mut about: String = table.own.iter().map(documented).collect();
            if table.solve == Some("") {
                about.extend(solve::SOLVE.iter().map(documented));
            } else {
                let names: Vec<&str> = solve::SOLVE.iter().map(|p| p.name).collect();
                let names = names.join(", ");
                let all = format!("{names}: How holes are filled, as for :func:`fill`.");
                about += &wrapped(&all, 8, 12);
            }
            text = between(
                &text,
                &place,
                ["        faces: ", "        threads"],
                &about,
            );
            let passed: Vec<String> = all.iter().map(|p| format!("{0}={0},", p.name)).collect();
            let passed = wrapped(&passed.join(" "), 8, 8);
            let call = format!("return model.{}(", table.command);
            text = between(&text, &call, [&call, "        threads=threads"], &passed);
        }
        text
    });
}
