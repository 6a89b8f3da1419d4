//! Values of parameters as programs give them, checked and converted to the form in which the parameter structs are serialised.

use std::collections::HashSet;

use isomend_core::parameters::{Choice, Kind, Parameter};
use serde_json::{Value, json};

/// The serialised form of a value.
///
/// # Errors
/// The name of the parameter, what it takes, and the value.
pub fn serialised(parameter: &Parameter, value: &Value) -> Result<Value, String> {
    let wrong = |what: &str| format!("{} must be {what}, but is {value}", parameter.name);
    match parameter.kind {
        Kind::Flag(set) => match value {
            Value::Bool(is_given) => Ok(Value::Bool(*is_given == set)),
            _ => Err(wrong("true or false")),
        },
        Kind::Voxel if value == "auto" => Ok(value.clone()),
        Kind::Voxel => Ok(json!({ "length": bounded(parameter, value)? })),
        Kind::Band if value == "full" => Ok(Value::Null),
        Kind::Band | Kind::Number(..) | Kind::Whole(_) => bounded(parameter, value),
        Kind::Holes(true) if value == "all" => Ok(Value::Null),
        Kind::Holes(can_be_all) => match is_list(value, &Value::is_u64) {
            true => Ok(value.clone()),
            false if can_be_all => Err(wrong("\"all\" or a list of hole numbers")),
            false => Err(wrong("a list of hole numbers")),
        },
        Kind::Groups => match is_list(value, &is_group) {
            true => Ok(value.clone()),
            false => Err(wrong("a list of groups of two different holes or more")),
        },
        Kind::Pairs => match is_list(value, &|pair| is_group(pair) && count(pair) == 2) {
            true => Ok(value.clone()),
            false => Err(wrong("a list of pairs of different crease ends")),
        },
        Kind::Choice(choices) => match is_one_of(choices, value) {
            true => Ok(value.clone()),
            false => Err(wrong(&format!("one of {}", names(choices)))),
        },
        Kind::Words(choices, _) => match value {
            Value::String(_) if is_one_of(choices, value) => Ok(json!([value])),
            Value::Array(_) if is_list(value, &|word| is_one_of(choices, word)) => {
                Ok(value.clone())
            }
            _ => Err(wrong(&format!("a list of words from {}", names(choices)))),
        },
        Kind::Like => match value.as_str() {
            Some(text) if !text.is_empty() => Ok(value.clone()),
            _ => Err(wrong(
                "\"mirror\", \"mirror:x,y,z,nx,ny,nz\" or the path of a mesh",
            )),
        },
    }
}

/// A number within the bounds of its parameter.
fn bounded(parameter: &Parameter, value: &Value) -> Result<Value, String> {
    let wrong = |what: String| format!("{} must be {what}, but is {value}", parameter.name);
    let is_whole = matches!(parameter.kind, Kind::Whole(_));
    let number = value.as_f64().filter(|_| !is_whole || value.is_u64());
    let Some(number) = number else {
        let bounds = parameter.kind.bounds();
        let allowed = bounds.map_or("a number".to_owned(), |b| b.text(is_whole));
        return Err(wrong(allowed));
    };
    let checked = parameter.check(number);
    checked.map_err(|error| error.to_string())?;
    Ok(value.clone())
}

fn is_list(value: &Value, is_item: &dyn Fn(&Value) -> bool) -> bool {
    value.as_array().is_some_and(|all| all.iter().all(is_item))
}

fn count(value: &Value) -> usize {
    value.as_array().map_or(0, Vec::len)
}

/// Whether a value is a list of two or more different whole numbers.
fn is_group(value: &Value) -> bool {
    let numbers = value.as_array().map_or(&[][..], |all| all);
    let mut seen = HashSet::with_capacity(numbers.len());
    let is_new = |number: &Value| number.as_u64().is_some_and(|n| seen.insert(n));
    numbers.len() > 1 && numbers.iter().all(is_new)
}

fn is_one_of(choices: &[Choice], value: &Value) -> bool {
    choices.iter().any(|choice| value == choice.name)
}

fn names(choices: &[Choice]) -> String {
    let names: Vec<&str> = choices.iter().map(|choice| choice.name).collect();
    names.join(", ")
}
