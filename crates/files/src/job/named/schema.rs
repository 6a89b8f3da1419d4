//! The JSON schema of the parameters of a command, made from its table: types, bounds, choices and descriptions.

use isomend_core::mesh::Unit;
use isomend_core::parameters::{Choice, Kind, Parameter, Table};
use serde_json::{Map, Value, json};

use super::{TOLERANCE, UNIT, has_tolerance};

/// The JSON schema (draft 2020-12) of what `named_work` takes for a command.
#[doc(hidden)]
pub fn schema(table: &Table) -> Value {
    let entries = table.entries().filter(|(path, _)| !path.is_empty());
    let mut properties: Map<String, Value> = entries
        .map(|(_, parameter)| (parameter.name.to_owned(), property(parameter)))
        .collect();
    properties.insert(
        UNIT.to_owned(),
        json!({
            "enum": Unit::ALL.map(Unit::sign),
            "description": "The unit of the mesh's coordinates; reports print it with every length.",
        }),
    );
    if has_tolerance(table.command) {
        properties.insert(
            TOLERANCE.to_owned(),
            json!({
                "type": "number", "exclusiveMinimum": 0,
                "description": "The largest error allowed, in the mesh's units; reports list each hole whose patch exceeds it.",
            }),
        );
    }
    json!({ "type": "object", "properties": properties, "additionalProperties": false })
}

/// The schema of one parameter.
fn property(parameter: &Parameter) -> Value {
    let mut schema = kind(parameter);
    let mut text = parameter.sentence.to_owned();
    for part in [parameter.unit, parameter.details] {
        if !part.is_empty() && !text.contains(part) {
            text = format!("{text} {part}");
        }
    }
    let usual = parameter.default.text();
    if !usual.is_empty() {
        text = format!("{text} Default: {usual}.");
    }
    if !parameter.excludes.is_empty() {
        text = format!("{text} Not together with `{}`.", parameter.excludes);
    }
    schema["description"] = Value::from(text);
    schema
}

/// The type of a parameter's values.
fn kind(parameter: &Parameter) -> Value {
    let names = |choices: &[Choice]| choices.iter().map(|c| c.name).collect::<Vec<_>>();
    let list = |items: Value| json!({ "type": "array", "items": items });
    let number = json!({ "type": "integer", "minimum": 0 });
    let or = |word: &str, other: Value| json!({ "anyOf": [{ "const": word }, other] });
    match parameter.kind {
        Kind::Flag(_) => json!({ "type": "boolean" }),
        Kind::Number(..) => bounded(parameter, "number"),
        Kind::Whole(_) => bounded(parameter, "integer"),
        Kind::Voxel => or("auto", bounded(parameter, "number")),
        Kind::Band => or("full", bounded(parameter, "number")),
        Kind::Choice(choices) => json!({ "enum": names(choices) }),
        Kind::Words(choices, _) => list(json!({ "enum": names(choices) })),
        Kind::Holes(true) => or("all", list(number)),
        Kind::Holes(false) => list(number),
        Kind::Groups => list(json!({ "type": "array", "items": number, "minItems": 2 })),
        Kind::Pairs => {
            list(json!({ "type": "array", "items": number, "minItems": 2, "maxItems": 2 }))
        }
        Kind::Like => json!({ "type": "string" }),
    }
}

/// A number with the bounds of its parameter.
fn bounded(parameter: &Parameter, name: &str) -> Value {
    let mut schema = json!({ "type": name });
    let Some(bounds) = parameter.kind.bounds() else {
        return schema;
    };
    let [low, high] = match bounds.open {
        true => ["exclusiveMinimum", "exclusiveMaximum"],
        false => ["minimum", "maximum"],
    };
    schema[low] = json!(bounds.low);
    if bounds.high.is_finite() {
        schema[high] = json!(bounds.high);
    }
    schema
}
