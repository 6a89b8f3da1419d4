//! The parameter tables against the structs that hold the parameters: fields, defaults, bounds and choices.

use std::collections::BTreeSet;

use isomend::check::CheckParams;
use isomend::parameters::{DefaultValue, Kind, Table};
use isomend::volume::VolumeParams;
use isomend::{FairParams, FillParams, RepairParams, RestoreParams};
use isomend_core::parameters::solve;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

fn usual<P: Default + Serialize>() -> Value {
    serde_json::to_value(P::default()).unwrap()
}

/// A command's table, its default parameters as JSON, and a function that reads and checks parameters.
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
        row(Table::FILL, usual::<FillParams>(), |v| {
            read(|p: &FillParams| said(p.check()), v)
        }),
        row(Table::RESTORE, usual::<RestoreParams>(), |v| {
            read(|p: &RestoreParams| said(p.check()), v)
        }),
        row(Table::FAIR, usual::<FairParams>(), |v| {
            read(|p: &FairParams| said(p.check()), v)
        }),
        row(Table::REPAIR, usual::<RepairParams>(), |v| {
            read(|p: &RepairParams| said(p.check()), v)
        }),
        row(Table::CHECK, usual::<CheckParams>(), |v| {
            read(|p: &CheckParams| said(p.check()), v)
        }),
        row(Table::SDF, usual::<VolumeParams>(), |v| {
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
        // An extent is a string or an object.
        if holder[*step].is_string() {
            holder[*step] = json!({});
        }
        holder = &mut holder[*step];
    }
    holder[*last] = value;
    params
}

#[test]
fn every_field_is_in_a_table_and_has_its_default() {
    // Fields of a fill that a restoration's mask or a repair sets.
    let decided = [
        "holes",
        "keep_open",
        "bridge",
        "flat",
        "crease",
        "flat_base",
        "base_offset",
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
                (_, DefaultValue::Value("all" | "full")) => Value::Null,
                (Kind::Number(..), DefaultValue::Value(text)) => {
                    json!(text.parse::<f64>().unwrap())
                }
                (_, DefaultValue::Value(text)) => json!(text),
                (Kind::Holes(_) | Kind::Groups | Kind::Pairs | Kind::Words(..), _) => json!([]),
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
fn the_library_accepts_the_choices_and_dependent_defaults_of_the_tables() {
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
            if let Kind::Words(choices, _) = parameter.kind {
                let names: Vec<&str> = choices.iter().map(|choice| choice.name).collect();
                read(with(&usual, &path, json!(names))).unwrap_or_else(|error| {
                    assert!(error.contains("leave one"), "{error}");
                });
                let error = read(with(&usual, &path, json!(["none of them"]))).unwrap_err();
                assert!(names.iter().all(|name| error.contains(name)), "{error}");
            }
            let excluded = parameter.excludes;
            assert!(excluded.is_empty() || table.get(excluded).is_some());
        }
    }
    let DefaultValue::Cases(cases) = solve::EDGE_RATIO.default else {
        panic!("the default depends on the energy");
    };
    for case in cases {
        let mut params = usual::<FillParams>();
        if let Some((name, values)) = case.with {
            params[name] = json!(values[0]);
        }
        let params: FillParams = serde_json::from_value(params).unwrap();
        assert_eq!(params.edge_ratio().to_string(), case.value);
    }
}
