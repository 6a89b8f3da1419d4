//! A checker of JSON documents by the schema of the reports, `docs/json.schema.json`.
#![allow(dead_code)] // Each test file uses some of it.

use std::fs;
use std::path::Path;

use serde_json::Value;

/// A schema with its definitions.
pub struct Schema(Value);

impl Schema {
    /// The schema in the repository.
    pub fn read() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/json.schema.json");
        Self(serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap())
    }

    /// The names of the definitions of documents.
    pub fn documents(&self) -> Vec<&str> {
        let all = self.0["$defs"]["Report"]["anyOf"].as_array().unwrap();
        all.iter().map(target).collect()
    }

    /// What is wrong with a document, or with a list of documents.
    pub fn faults(&self, document: &Value) -> Vec<String> {
        self.faults_of(&self.0, document, "")
    }

    /// What is wrong with a document that should have a definition.
    pub fn faults_by(&self, definition: &str, document: &Value) -> Vec<String> {
        self.faults_of(&self.0["$defs"][definition], document, "")
    }

    /// What is wrong with a value. Fields that the schema does not describe are faults too, which other checkers permit.
    fn faults_of(&self, schema: &Value, value: &Value, place: &str) -> Vec<String> {
        let mut faults = Vec::new();
        for (keyword, rule) in schema.as_object().unwrap() {
            match keyword.as_str() {
                "$ref" => {
                    let target = &self.0["$defs"][target(schema)];
                    faults.extend(self.faults_of(target, value, place));
                }
                "anyOf" | "oneOf" => {
                    let each = rule.as_array().unwrap().iter();
                    let each = each.map(|one| self.faults_of(one, value, place));
                    faults.extend(each.min_by_key(Vec::len).unwrap());
                }
                "required" => {
                    let names = rule.as_array().unwrap().iter().filter_map(Value::as_str);
                    let missing = names.filter(|name| value.get(name).is_none());
                    faults.extend(missing.map(|name| format!("{place}/{name} is missing")));
                }
                "properties" => {
                    for (name, inner) in value.as_object().into_iter().flatten() {
                        let place = format!("{place}/{name}");
                        match rule.get(name) {
                            Some(rule) => faults.extend(self.faults_of(rule, inner, &place)),
                            None => faults.push(format!("{place} is not described")),
                        }
                    }
                }
                "items" => {
                    for (k, inner) in value.as_array().into_iter().flatten().enumerate() {
                        faults.extend(self.faults_of(rule, inner, &format!("{place}/{k}")));
                    }
                }
                _ if is_met(keyword, rule, value) => {}
                _ => faults.push(format!("{place} is {value}, against {keyword} {rule}")),
            }
        }
        faults
    }
}

/// The name of the definition that a schema refers to.
fn target(schema: &Value) -> &str {
    let target = schema["$ref"].as_str().unwrap();
    target.strip_prefix("#/$defs/").unwrap()
}

/// Whether a value obeys a rule that concerns it alone.
fn is_met(keyword: &str, rule: &Value, value: &Value) -> bool {
    let count = value.as_array().map(|list| list.len() as u64);
    match keyword {
        "type" => match rule.as_array() {
            Some(types) => types.iter().any(|one| is_of(one, value)),
            None => is_of(rule, value),
        },
        "const" => rule == value,
        "enum" => rule.as_array().unwrap().contains(value),
        "minItems" => count.is_none_or(|n| n >= rule.as_u64().unwrap()),
        "maxItems" => count.is_none_or(|n| n <= rule.as_u64().unwrap()),
        "minimum" => value.as_f64().is_none_or(|x| x >= rule.as_f64().unwrap()),
        "$schema" | "title" | "description" | "$defs" => true,
        other => panic!("the checker does not know the keyword {other}"),
    }
}

/// Whether a value has a type of JSON schemas.
fn is_of(name: &Value, value: &Value) -> bool {
    match name.as_str().unwrap() {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        "null" => value.is_null(),
        other => panic!("the checker does not know the type {other}"),
    }
}
