//! The JSON schema of the reports, `docs/json.schema.json`, from the types in the source.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::documents::{Form, Property, Shape, Types, definition};
use super::renewed::renewed;

/// All works that change a mesh.
const WORKS: [&str; 5] = ["fill", "restore", "fair", "repair", "convert"];

/// The documents: the commands that write it, the type of its content, and its name in the schema where this is not the type's.
const DOCUMENTS: [(&[&str], &str, &str); 12] = [
    (&["fill", "restore"], "FillBody", ""),
    (&["fair"], "FairBody", ""),
    (&["repair"], "RepairBody", ""),
    (&["convert"], "Files", "Convert"),
    (&WORKS, "PlanBody", ""),
    (&WORKS, "FailedBody", ""),
    (&["inspect"], "InspectBody", ""),
    (&["check"], "CheckBody", ""),
    (&["compare"], "CompareBody", ""),
    (&["sdf"], "VolumeBody", ""),
    (&["surface"], "SurfaceBody", ""),
    (&["study"], "StudyBody", ""),
];

/// A definition of the schema.
pub struct Definition {
    pub name: String,
    about: String,
    pub shape: Shape,
}

/// The definitions of all documents, then of the types that they contain.
pub fn definitions() -> Vec<Definition> {
    let mut types = Types::read();
    let mut all = Vec::new();
    for (commands, body, name) in DOCUMENTS {
        let mut forms = types.document("Document", body);
        for form in &mut forms {
            let command = form.iter_mut().find(|p| p.name == "command").unwrap();
            command.schema = json!({ "enum": commands });
        }
        all.push(Definition {
            name: if name.is_empty() {
                definition(body)
            } else {
                name
            }
            .to_owned(),
            about: types.about(body),
            shape: Shape::Object(forms),
        });
    }
    let inner = types.definitions.into_iter();
    all.extend(inner.map(|(name, about, shape)| Definition { name, about, shape }));
    let mut names: Vec<&str> = all.iter().map(|d| d.name.as_str()).collect();
    names.sort_unstable();
    let doubled = names.windows(2).find(|pair| pair[0] == pair[1]);
    assert!(doubled.is_none(), "two definitions are {doubled:?}");
    all
}

/// A schema with the sentence on its field. It comes first, since readers search it.
fn described(property: &Property) -> String {
    let about = json!(property.about).to_string();
    let schema = property.schema.to_string();
    format!("{{\"description\":{about},{}", &schema[1..])
}

/// The lines of an object's form, one for each field.
fn form_text(form: &Form, indent: &str) -> String {
    let required = form.iter().filter(|p| p.is_required);
    let required: Vec<&str> = required.map(|p| p.name.as_str()).collect();
    let fields: Vec<String> = form
        .iter()
        .map(|p| format!("{indent}  {}: {}", json!(p.name), described(p)))
        .collect();
    format!(
        "{indent}\"type\": \"object\",\n{indent}\"required\": {},\n{indent}\"properties\": {{\n{}\n{indent}}}",
        json!(required),
        fields.join(",\n")
    )
}

fn definition_text(definition: &Definition) -> String {
    let head = format!(
        "    {}: {{\n      \"description\": {},\n",
        json!(definition.name),
        json!(definition.about)
    );
    let body = match &definition.shape {
        Shape::Object(forms) if forms.len() == 1 => form_text(&forms[0], "      "),
        Shape::Object(forms) => {
            let forms = forms.iter();
            let forms =
                forms.map(|f| format!("        {{\n{}\n        }}", form_text(f, "          ")));
            let forms = forms.collect::<Vec<_>>().join(",\n");
            format!("      \"anyOf\": [\n{forms}\n      ]")
        }
        Shape::Value(value) => {
            let lines = value.as_object().unwrap().iter();
            let lines = lines.map(|(key, value)| format!("      {}: {value}", json!(key)));
            lines.collect::<Vec<_>>().join(",\n")
        }
    };
    format!("{head}{body}\n    }}")
}

/// The text of the schema.
fn schema_text(definitions: &[Definition]) -> String {
    let of_documents = definitions[..DOCUMENTS.len()].iter();
    let references: Vec<Value> = of_documents
        .map(|d| json!({ "$ref": format!("#/$defs/{}", d.name) }))
        .collect();
    let all: Vec<String> = definitions.iter().map(definition_text).collect();
    let mut text =
        "{\n  \"$schema\": \"https://json-schema.org/draft/2020-12/schema\",\n".to_owned();
    text += "  \"title\": \"JSON reports of isomend\",\n";
    text += "  \"description\": \"One document, or a list of them for several inputs. Lengths are in the mesh's units, angles in degrees.\",\n";
    let list = json!({ "type": "array", "items": { "$ref": "#/$defs/Report" } });
    let either = json!([{ "$ref": "#/$defs/Report" }, list]);
    writeln!(text, "  \"anyOf\": {either},\n  \"$defs\": {{").unwrap();
    let one = json!({ "description": "The document of one input.", "anyOf": references });
    writeln!(
        text,
        "    \"Report\": {one},\n{}\n  }}\n}}",
        all.join(",\n")
    )
    .unwrap();
    text
}

#[test]
fn the_schema_of_reports_equals_the_types() {
    let text = schema_text(&definitions());
    let read: Map<String, Value> = serde_json::from_str(&text).unwrap();
    assert!(read["$defs"].as_object().unwrap().len() > 50);
    renewed("docs/json.schema.json", |_| text.clone());
}
