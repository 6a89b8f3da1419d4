//! The tables of parameters against the structs that hold them, and what is written from them: the tables of `docs/options.md` and
//! `python/isomend/_options.py`. `RENEW=1 cargo test --test house parameters` writes both anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use isomend::check::CheckParams;
use isomend::parameters::{Kind, Parameter, Table, Usual, solve, tables};
use isomend::volume::VolumeParams;
use isomend::{FairParams, FillParams, RepairParams, RestoreParams};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

fn usual<P: Default + Serialize>() -> Value {
    serde_json::to_value(P::default()).unwrap()
}

/// A command's default parameters as JSON, and whether such JSON is read and what is wrong with it.
struct Held {
    table: &'static Table,
    usual: Value,
    read: fn(Value) -> Result<(), String>,
}

fn read<P: DeserializeOwned>(
    check: impl Fn(&P) -> Result<(), String>,
    params: Value,
) -> Result<(), String> {
    let params = serde_json::from_value(params).map_err(|error| error.to_string())?;
    check(&params)
}

fn said<E: ToString>(result: Result<(), E>) -> Result<(), String> {
    result.map_err(|error| error.to_string())
}

fn held() -> [Held; 6] {
    let row = |table, usual, read| Held { table, usual, read };
    [
        row(&tables::FILL, usual::<FillParams>(), |v| {
            read(|p: &FillParams| said(p.check()), v)
        }),
        row(&tables::RESTORE, usual::<RestoreParams>(), |v| {
            read(|p: &RestoreParams| said(p.check()), v)
        }),
        row(&tables::FAIR, usual::<FairParams>(), |v| {
            read(|p: &FairParams| said(p.check()), v)
        }),
        row(&tables::REPAIR, usual::<RepairParams>(), |v| {
            read(|p: &RepairParams| said(p.check()), v)
        }),
        row(&tables::CHECK, usual::<CheckParams>(), |v| {
            read(|p: &CheckParams| said(p.check()), v)
        }),
        row(&tables::SDF, usual::<VolumeParams>(), |v| {
            read(|p: &VolumeParams| said(p.check()), v)
        }),
    ]
}

/// The value at a path.
fn at<'a>(params: &'a Value, path: &[&str]) -> &'a Value {
    path.iter().fold(params, |value, step| &value[*step])
}

/// The same parameters with another value at a path.
fn with(params: &Value, path: &[&str], value: Value) -> Value {
    let mut params = params.clone();
    let (last, steps) = path.split_last().unwrap();
    let mut holder = &mut params;
    for step in steps {
        // An extent is a word or an object.
        if holder[*step].is_string() {
            holder[*step] = json!({});
        }
        holder = &mut holder[*step];
    }
    holder[*last] = value;
    params
}

#[test]
fn every_field_is_in_a_table_and_every_default_is_that_of_the_table() {
    // Those of a fill that the mask of a restoration and the repair of all holes decide.
    let decided = [
        "holes",
        "keep_open",
        "bridge",
        "flat",
        "surface",
        "max_diameter",
    ];
    for Held { table, usual, .. } in held() {
        let command = table.command;
        let mut fields: BTreeSet<String> = BTreeSet::new();
        for (name, value) in usual.as_object().unwrap() {
            match value.as_object() {
                Some(inner) => fields.extend(inner.keys().map(|key| format!("{name}.{key}"))),
                None => _ = fields.insert(name.clone()),
            }
        }
        for (path, parameter) in table.entries().filter(|(path, _)| !path.is_empty()) {
            let name = parameter.name;
            let field = path.join(".");
            let whole = path[0].to_owned();
            assert!(
                fields.contains(&field) || usual[&whole].is_string(),
                "{command}: there is no field {field} for {name}"
            );
            let value = at(&usual, &path);
            let expected = match (parameter.kind, parameter.default) {
                (Kind::Flag(set), _) => json!(!set),
                (_, Usual::Value("all" | "full")) => Value::Null,
                (Kind::Number(..), Usual::Value(text)) => json!(text.parse::<f64>().unwrap()),
                (_, Usual::Value(text)) => json!(text),
                (Kind::Holes(_) | Kind::Groups, _) => json!([]),
                _ => Value::Null,
            };
            assert_eq!(*value, expected, "{command}: the default of {name}");
        }
        let known: BTreeSet<String> = table.entries().map(|(path, _)| path.join(".")).collect();
        for field in fields {
            let is_decided = decided.iter().any(|name| field == format!("fill.{name}"));
            let is_known = known
                .iter()
                .any(|k| *k == field || k.starts_with(&format!("{field}.")));
            assert!(is_known || is_decided, "{command}: {field} is in no table");
        }
    }
}

#[test]
fn numbers_out_of_bounds_are_refused_by_name() {
    let mut refused = 0;
    for Held { table, usual, read } in held() {
        read(usual.clone()).unwrap();
        for (path, parameter) in table.entries() {
            let Some(bounds) = parameter.kind.bounds() else {
                continue;
            };
            let given = |x: f64| match parameter.kind {
                Kind::Voxel => json!({ "length": x }),
                Kind::Whole(_) => json!(x as u64),
                _ => json!(x),
            };
            let outside = match bounds.open {
                true => [bounds.low, bounds.high],
                false => [bounds.low - 1.0, bounds.high + 1.0],
            };
            // JSON has no infinite numbers.
            for x in outside.into_iter().filter(|x| x.is_finite() && *x > -1.0) {
                let error = read(with(&usual, &path, given(x))).unwrap_err();
                let expected = parameter.check(x).unwrap_err().to_string();
                assert_eq!(error, expected, "{}: {}", table.command, parameter.name);
                refused += 1;
            }
        }
    }
    assert!(refused > 20, "{refused}");
}

#[test]
fn words_and_defaults_that_depend_on_others_are_the_librarys() {
    for Held { table, usual, read } in held() {
        for (path, parameter) in table.entries() {
            if let Kind::Choice(choices) = parameter.kind {
                for choice in choices {
                    read(with(&usual, &path, json!(choice.name))).unwrap();
                }
                let error = read(with(&usual, &path, json!("none of them"))).unwrap_err();
                for choice in choices {
                    assert!(error.contains(&format!("`{}`", choice.name)), "{error}");
                }
                let count = error.matches('`').count() / 2 - 1;
                assert_eq!(count, choices.len(), "{error}");
            }
            let excluded = parameter.excludes;
            assert!(excluded.is_empty() || table.get(excluded).is_some());
        }
    }
    let Usual::Cases(cases) = solve::EDGE_RATIO.default else {
        panic!("the default depends on the energy");
    };
    for case in cases {
        let mut params = usual::<FillParams>();
        if let Some((name, value)) = case.with {
            params[name] = json!(value);
        }
        let params: FillParams = serde_json::from_value(params).unwrap();
        assert_eq!(params.edge_ratio().to_string(), case.value);
    }
}

/// Puts what is made of the tables in the place of what stands there, or says that it is not the same.
fn renewed(file: &str, made: impl Fn(&str) -> String) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let text = fs::read_to_string(&path).unwrap_or_default();
    let made = made(&text);
    if std::env::var_os("RENEW").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let place = text.lines().zip(made.lines()).find(|(old, new)| old != new);
    assert!(
        std::env::var_os("RENEW").is_some() || text == made,
        "{file} is not what the tables of parameters say, first at {place:?}; RENEW=1 cargo test --test house parameters \
         writes it anew"
    );
}

/// In words of the command line: other parameters are options there.
fn as_options(text: &str, table: &Table) -> String {
    let mut text = text.to_owned();
    for (_, parameter) in table.entries() {
        let option = format!("`--{}`", parameter.option());
        text = text.replace(&format!("`{}`", parameter.name), &option);
    }
    text
}

/// A row of the table of a page.
fn row(parameter: &Parameter, table: &Table) -> String {
    let value = parameter.kind.placeholder().replace('|', "\\|");
    let option = format!("--{} {value}", parameter.option());
    let what = format!("{} {}", parameter.sentence, parameter.details);
    let what = as_options(what.trim_end_matches(['.', ' ']), table);
    let default = match parameter.default {
        Usual::Value(text) => format!("`{text}`"),
        usual => as_options(&usual.text(), table),
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
            let table = tables::ALL.iter().find(|t| t.command == command).unwrap();
            made += before;
            made += &format!(
                "<!-- parameters of {command} -->\n\n| option | meaning | default |\n|---|---|---|\n"
            );
            // Those of the solve stand with a fill.
            let solve = table.solve.filter(|at| at.is_empty()).map(|_| solve::SOLVE);
            for parameter in table.own.iter().chain(solve.unwrap_or_default()) {
                if !parameter.library_only {
                    made += &row(parameter, table);
                }
            }
            made += "\n<!-- end -->";
            rest = after;
            count += 1;
        }
        assert_eq!(count, tables::ALL.len(), "tables of parameters");
        made + rest
    });
}

/// The type of a keyword of Python.
fn annotation(parameter: &Parameter) -> String {
    let is_set = matches!(parameter.default, Usual::Value(_));
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
        Kind::Flag(_) => "bool".to_owned(),
        Kind::Holes(true) => "Iterable[int] | None".to_owned(),
        Kind::Holes(false) => "Iterable[int]".to_owned(),
        Kind::Groups => "Iterable[Iterable[int]]".to_owned(),
    }
}

#[test]
fn the_keywords_of_python_are_those_of_the_tables() {
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
from typing import Literal

from isomend._params import RunOptions, Voxel
"
        .to_owned();
        let about = "The parameters of all works that fill holes.";
        text += &class("SolveOptions", "RunOptions", about, solve::SOLVE);
        for (table, name) in [
            (&tables::FILL, "Fill"),
            (&tables::REPAIR, "Repair"),
            (&tables::RESTORE, "Restore"),
            (&tables::FAIR, "Fair"),
        ] {
            let base = table.solve.map_or("RunOptions", |_| "SolveOptions");
            let about = format!("The keywords of :func:`isomend.{}`.", table.command);
            text += &class(&format!("{name}Options"), base, &about, table.own);
        }
        text
    });
}
