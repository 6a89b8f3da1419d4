//! Parameters by name, from a JSON object such as `{"max_diameter": 20, "holes": [2, 5]}`: for programs that call isomend through the C
//! interface or the Model Context Protocol.
//!
//! The names and their meanings are the ones of Python's keywords, read from the tables of parameters.

mod schema;
mod value;

use isomend_core::mesh::Unit;
use isomend_core::parameters::Table;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::deliver::Deliverables;
use super::{JobError, MaskSpec, Work};

pub use schema::schema;

/// What commands take beside the parameters of their tables: every one the unit of the coordinates, those that make patches the tolerance.
const UNIT: &str = "unit";
const TOLERANCE: &str = "tolerance";

/// The parameter struct of a command from values in their serialised form, by the names of the parameters. Parameters without a value have
/// their defaults.
///
/// # Errors
/// If a value has another type than its field.
#[doc(hidden)]
pub fn params_of<P: DeserializeOwned>(
    table: &Table,
    values: &Map<String, Value>,
) -> Result<P, serde_json::Error> {
    let mut params = Value::Object(Map::new());
    for (path, parameter) in table.entries().filter(|(path, _)| !path.is_empty()) {
        if let Some(value) = values.get(parameter.name) {
            *path.iter().fold(&mut params, |at, step| &mut at[*step]) = value.clone();
        }
    }
    serde_json::from_value(params)
}

/// The parameter struct of a command from the values that a program gives, by the names of the parameters: `{"voxel": 0.5}`,
/// `{"holes": "all"}`. A null stands for the default.
///
/// # Errors
/// [`JobError::Named`], with the name, if a parameter does not exist, or its value has the wrong type or is out of its bounds.
fn named_params<P: DeserializeOwned>(
    table: &Table,
    given: &Map<String, Value>,
) -> Result<P, JobError> {
    let wrong = |what: String| JobError::Named { what };
    let mut values = Map::new();
    for (name, value) in given.iter().filter(|(_, value)| !value.is_null()) {
        let parameter = table.get(name).ok_or_else(|| wrong(unknown(table, name)))?;
        let other = given.get(parameter.excludes);
        if other.is_some_and(is_chosen) && is_chosen(value) {
            return Err(wrong(format!(
                "{name} and {} exclude each other; give one of them",
                parameter.excludes
            )));
        }
        let value = value::serialised(parameter, value).map_err(wrong)?;
        values.insert(name.clone(), value);
    }
    params_of(table, &values).map_err(|error| wrong(error.to_string()))
}

/// The work of a command, and its deliverables (the unit and the tolerance), from what a program gives by name. The mask is the one of a
/// restoration or a fairing.
///
/// # Errors
/// As [`named_params`], and if there is no such work.
#[doc(hidden)]
pub fn named_work(
    command: &str,
    mask: Option<MaskSpec>,
    mut given: Map<String, Value>,
) -> Result<(Work, Deliverables), JobError> {
    let mut deliverables = Deliverables {
        unit: unit(&mut given)?,
        ..Deliverables::default()
    };
    if has_tolerance(command) {
        deliverables.tolerance = tolerance(&mut given)?;
    }
    let wrong = |what: String| Err(JobError::Named { what });
    let work = match (command, given.keys().next()) {
        ("fill", _) => Work::Fill(named_params(Table::FILL, &given)?),
        ("repair", _) => Work::Repair(named_params(Table::REPAIR, &given)?),
        ("restore", _) => Work::Restore(
            mask.unwrap_or_default(),
            named_params(Table::RESTORE, &given)?,
        ),
        ("fair", _) => Work::Fair(mask, named_params(Table::FAIR, &given)?),
        ("check", _) => Work::Check(named_params(Table::CHECK, &given)?),
        ("inspect", None) => Work::Inspect(None),
        ("inspect", Some(name)) => {
            return wrong(format!("inspect has no parameter '{name}'; it has {UNIT}"));
        }
        _ => {
            return wrong(format!(
                "'{command}' is no work with named parameters: take fill, repair, restore, fair, check or inspect"
            ));
        }
    };
    work.check()?;
    Ok((work, deliverables))
}

/// Whether a command takes the tolerance: one that makes patches.
fn has_tolerance(command: &str) -> bool {
    matches!(command, "fill" | "repair" | "restore")
}

/// Takes the unit of the coordinates out of what a program gives by name.
fn unit(given: &mut Map<String, Value>) -> Result<Option<Unit>, JobError> {
    let unit = take(given, UNIT).map(|value| {
        let unit = value.as_str().map(str::parse).and_then(Result::ok);
        let what = format!("{UNIT} must be mm, cm, m, in, um or ft, but is {value}");
        unit.ok_or(JobError::Named { what })
    });
    unit.transpose()
}

/// Takes the tolerance out of what a program gives by name.
fn tolerance(given: &mut Map<String, Value>) -> Result<Option<f64>, JobError> {
    let tolerance = take(given, TOLERANCE).map(|value| {
        let tolerance = value.as_f64().filter(|t| t.is_finite() && *t > 0.0);
        let what = format!("{TOLERANCE} must be a positive number, but is {value}");
        tolerance.ok_or(JobError::Named { what })
    });
    tolerance.transpose()
}

/// Takes a value out; a null stands for none.
fn take(given: &mut Map<String, Value>, name: &str) -> Option<Value> {
    given.remove(name).filter(|value| !value.is_null())
}

/// Whether a value is more than the absence of a flag.
fn is_chosen(value: &Value) -> bool {
    !value.is_null() && *value != Value::Bool(false)
}

/// The message for a name that is no parameter.
fn unknown(table: &Table, name: &str) -> String {
    let command = table.command;
    if let Some(now) = table.in_place_of(name) {
        return format!("{command} has no parameter '{name}' any more: use {now}");
    }
    let names: Vec<&str> = table.entries().map(|(_, p)| p.name).collect();
    format!(
        "{command} has no parameter '{name}'; it has {}",
        names.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use isomend_core::fill::FillParams;
    use isomend_core::mend::FairExtent;
    use isomend_core::region::VoxelSize;
    use serde_json::json;

    fn object(value: Value) -> Map<String, Value> {
        value.as_object().unwrap().clone()
    }

    fn refused(command: &str, given: Value) -> String {
        let error = named_work(command, None, object(given)).unwrap_err();
        error.to_string()
    }

    #[test]
    fn values_reach_their_fields_in_the_form_that_the_tables_state() {
        let given = json!({
            "voxel": 0.5, "holes": [2, 5], "flat": [1], "bridge": [[3, 4]], "crease": [[1, 2]], "max_diameter": 20,
            "energy": "willmore", "flat_base": false, "keep_open": null,
        });
        let (work, _) = named_work("fill", None, object(given)).unwrap();
        let Work::Fill(params) = work else { panic!() };
        let value = serde_json::to_value(&params).unwrap();
        assert_eq!(value["voxel"], json!({"length": 0.5}));
        assert_eq!(value["holes"], json!([2, 5]));
        assert_eq!(value["bridge"], json!([[3, 4]]));
        assert_eq!(value["crease"], json!([[1, 2]]));
        assert_eq!(params.max_diameter, Some(20.0));
        let nothing = named_work("fill", None, Map::new()).unwrap();
        assert_eq!(nothing.0, Work::Fill(FillParams::default()));
        let words = json!({"holes": "all", "voxel": "auto"});
        assert_eq!(named_work("fill", None, object(words)).unwrap(), nothing);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (command, given, part) in [
            ("fill", json!({"holes": "some"}), "holes must be"),
            ("fill", json!({"max_diameter": -1}), "max_diameter must be"),
            ("fill", json!({"voxel": true}), "voxel must be"),
            ("fill", json!({"energy": "none"}), "energy must be one of"),
            ("fill", json!({"bridge": [[1]]}), "bridge must be"),
            ("fill", json!({"bridge": [[1, 1]]}), "bridge must be"),
            ("fill", json!({"bridge": [[1, 2, 1]]}), "bridge must be"),
            ("fill", json!({"bridge": [[1, -2]]}), "bridge must be"),
            (
                "fill",
                json!({"flat_base": 1}),
                "flat_base must be true or false",
            ),
            (
                "fill",
                json!({"nothing": 1}),
                "fill has no parameter 'nothing'; it has",
            ),
            ("fill", json!({"repair": true}), "any more: use"),
            ("fill", json!({"unit": "yard"}), "unit must be mm"),
            (
                "fill",
                json!({"tolerance": 0}),
                "tolerance must be a positive number",
            ),
            ("restore", json!({}), "a restoration needs a mask"),
            ("restore", json!({"holes": [1]}), "restore has no parameter"),
            (
                "fair",
                json!({"time": 1, "strength": 2}),
                "strength and time exclude each other",
            ),
            ("fair", json!({"strength": 0}), "strength must be"),
            ("fair", json!({"tolerance": 1}), "fair has no parameter"),
            ("convert", json!({}), "take fill, repair, restore"),
        ] {
            let error = refused(command, given.clone());
            assert!(error.contains(part), "{given}: {error}");
        }
    }

    #[test]
    fn restorations_and_fairings_have_masks() {
        let mask = MaskSpec {
            faces: vec![3, 4],
            ..MaskSpec::default()
        };
        let given = json!({"keep_shape": 0.5, "keep_vertices": true, "voxel": 0.5});
        let restored = named_work("restore", Some(mask.clone()), object(given)).unwrap();
        let Work::Restore(marked, params) = restored.0 else {
            panic!()
        };
        assert_eq!(marked, mask);
        assert_eq!((params.keep_shape, params.keep_vertices), (0.5, true));
        assert_eq!(params.fill.voxel, VoxelSize::Length(0.5));
        for (given, wanted) in [
            (json!({"strength": 2}), FairExtent::Strength(2.0)),
            (
                json!({"time": 0.5, "strength": null}),
                FairExtent::Time(0.5),
            ),
            (json!({}), FairExtent::Auto),
        ] {
            let (work, _) = named_work("fair", None, object(given)).unwrap();
            let Work::Fair(None, params) = work else {
                panic!()
            };
            assert_eq!(params.extent, wanted);
        }
    }

    #[test]
    fn a_schema_names_every_parameter_and_accepts_its_default() {
        let all = [
            Table::FILL,
            Table::REPAIR,
            Table::RESTORE,
            Table::FAIR,
            Table::CHECK,
        ];
        for table in all {
            let schema = schema(table);
            assert_eq!(schema["additionalProperties"], json!(false));
            let properties = schema["properties"].as_object().unwrap();
            for (_, parameter) in table.entries() {
                let row = &properties[parameter.name];
                assert!(row["description"].as_str().unwrap().len() > 10);
            }
            let extra = properties.len() - table.entries().count();
            let makes_patches = !["check", "fair"].contains(&table.command);
            assert_eq!(extra, 1 + usize::from(makes_patches));
            assert_eq!(properties.contains_key("tolerance"), makes_patches);
        }
    }
}
