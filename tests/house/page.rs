//! The generated parts of `docs/json.md`: tables of fields from the definitions of the schema, and an example.

use std::collections::BTreeSet;

use isomend::Control;
use isomend::job::{Drawings, Source, inspect};
use serde_json::Value;

use super::checker::Schema;
use super::documents::{Form, Property, Shape};
use super::renewed::renewed;
use super::schema::{Definition, definitions};

/// A tetrahedron without one of its faces.
const OPEN: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";

/// Most inner fields that a row lists. The schema has the others.
const MOST_LISTED: usize = 7;

/// Writes the tables of fields. Each list of an inner object's fields is written once.
struct Tables {
    definitions: Vec<Definition>,
    /// The definitions whose fields are listed.
    listed: BTreeSet<String>,
}

impl Tables {
    fn definition(&self, name: &str) -> &Definition {
        let found = self.definitions.iter().find(|d| d.name == name);
        found.unwrap_or_else(|| panic!("the schema has no definition {name}"))
    }

    /// The fields of a definition, in all its forms.
    fn fields(&self, name: &str) -> Form {
        let Shape::Object(forms) = &self.definition(name).shape else {
            return Form::new();
        };
        let mut fields = Form::new();
        for field in forms.iter().flatten() {
            if !fields.iter().any(|known| known.name == field.name) {
                fields.push(field.clone());
            }
        }
        fields
    }

    /// The fields of `name` without the fields that others of the words have: `Fill without Convert`.
    fn chosen(&self, words: &str) -> Form {
        let (name, without) = words.split_once(" without ").unwrap_or((words, ""));
        let others: BTreeSet<String> = without
            .split_whitespace()
            .flat_map(|other| self.fields(other))
            .map(|field| field.name)
            .collect();
        let mut fields = self.fields(name);
        fields.retain(|field| !others.contains(&field.name));
        assert!(!fields.is_empty(), "{words} has no fields");
        fields
    }

    /// The names of the inner fields of a field, if they are not listed elsewhere on the page.
    fn inner(&mut self, field: &Property) -> Option<String> {
        let name = reference(&field.schema)?;
        if !matches!(&self.definition(&name).shape, Shape::Object(forms) if forms.len() == 1) {
            return None;
        }
        let names: Vec<String> = self.fields(&name).into_iter().map(|f| f.name).collect();
        let is_short = (1..=MOST_LISTED).contains(&names.len());
        let is_new = is_short && self.listed.insert(name);
        is_new.then(|| {
            names
                .iter()
                .map(|n| format!("`{n}`"))
                .collect::<Vec<_>>()
                .join(", ")
        })
    }

    /// A row for each field: its name, and its first sentence.
    fn rows(&mut self, words: &str) -> String {
        let mut text = "field | content\n---|---\n".to_owned();
        for field in self.chosen(words) {
            let sentence = summary(&field.about);
            let inner = self.inner(&field).map(|names| format!(": {names}"));
            text += &format!(
                "`{}` | {sentence}{}\n",
                field.name,
                inner.unwrap_or_default()
            );
        }
        text
    }

    /// An item for each command: the names of its fields.
    fn names(&mut self, all: &str) -> String {
        let mut text = String::new();
        let (names, without) = all.split_once(" without ").unwrap();
        for name in names.split(' ') {
            let fields = self.chosen(&format!("{name} without {without}"));
            let each = fields.iter().map(|field| match self.inner(field) {
                Some(inner) => format!("`{}` ({inner})", field.name),
                None => format!("`{}`", field.name),
            });
            let each = each.collect::<Vec<_>>().join(", ");
            text += &format!("- {}: {each}\n", self.command(name));
        }
        text
    }

    /// The command that writes a document.
    fn command(&self, name: &str) -> String {
        let fields = self.fields(name);
        let command = fields.iter().find(|f| f.name == "command").unwrap();
        format!("`{}`", command.schema["enum"][0].as_str().unwrap())
    }

    /// The text for a mark.
    fn text(&mut self, mark: &str) -> String {
        match mark.split_once(" of ") {
            Some(("fields", words)) => self.rows(words),
            Some(("names", words)) => self.names(words),
            _ if mark == "example" => format!("```json\n{}```\n", lines(&example())),
            _ => panic!("docs/json.md has the unknown mark {mark}"),
        }
    }
}

/// The name of the definition of a value, of its items, or of the value that may be null.
fn reference(schema: &Value) -> Option<String> {
    if let Some(target) = schema.get("$ref") {
        return Some(target.as_str()?.strip_prefix("#/$defs/")?.to_owned());
    }
    let inner = schema.get("items").or_else(|| schema["anyOf"].get(0))?;
    reference(inner)
}

/// The first sentence of a field's documentation for a table, where counts need no `Number of`.
fn summary(about: &str) -> String {
    let sentence = about.split(". ").next().unwrap().trim_end_matches('.');
    let sentence = sentence.replace('|', "\\|");
    let Some(counted) = sentence.strip_prefix("Number of ") else {
        return sentence;
    };
    let (first, rest) = counted.split_at(1);
    format!("{}{rest}", first.to_uppercase())
}

/// The document of an inspection.
fn example() -> String {
    let source = Source::bytes("open.obj", OPEN.into());
    let loaded = source.read().unwrap();
    let drawings = Drawings::default();
    let inspected = inspect(&source, &loaded, None, None, &drawings, &Control::new()).unwrap();
    serde_json::to_string(&inspected.document()).unwrap()
}

/// A JSON object with a line for each of its fields.
fn lines(object: &str) -> String {
    let (mut text, mut depth, mut is_text) = (String::new(), 0, false);
    for letter in object.chars() {
        is_text ^= letter == '"';
        depth += i32::from("[{".contains(letter)) - i32::from("]}".contains(letter));
        match letter {
            '{' if depth == 1 => text += "{\n  ",
            ',' if depth == 1 && !is_text => text += ",\n  ",
            '}' if depth == 0 => text += "\n}\n",
            other => text.push(other),
        }
    }
    text
}

#[test]
fn the_page_of_reports_has_the_fields_and_a_valid_example() {
    renewed("docs/json.md", |page| {
        let mut tables = Tables {
            definitions: definitions(),
            listed: BTreeSet::new(),
        };
        let marks = page
            .split("<!-- ")
            .skip(1)
            .filter_map(|part| part.split_once(" -->"));
        // Inner objects with a table of their own are not listed elsewhere.
        let own = marks.filter_map(|(mark, _)| mark.strip_prefix("fields of "));
        tables.listed = own
            .map(|w| w.split(' ').next().unwrap().to_owned())
            .collect();
        let (mut made, mut rest) = (String::new(), page);
        while let Some((before, after)) = rest.split_once("<!-- ") {
            let (mark, after) = after.split_once(" -->\n").unwrap();
            let (_, after) = after.split_once("<!-- end -->").unwrap();
            made += &format!(
                "{before}<!-- {mark} -->\n\n{}\n<!-- end -->",
                tables.text(mark)
            );
            rest = after;
        }
        made + rest
    });
}

#[test]
fn the_page_names_how_holes_are_closed_and_why_not() {
    let page = include_str!("../../docs/json.md");
    let mut count = 0;
    for definition in definitions() {
        if let ("Closure" | "Cause", Shape::Value(value)) =
            (definition.name.as_str(), &definition.shape)
        {
            for one in value["oneOf"].as_array().unwrap() {
                let name = one["const"].as_str().unwrap();
                assert!(page.contains(&format!("`{name}`")), "the page lacks {name}");
                count += 1;
            }
        }
    }
    assert!(count > 25, "only {count} identifiers were found");
}

#[test]
fn the_example_is_as_the_schema_describes_it() {
    let document: Value = serde_json::from_str(&lines(&example())).unwrap();
    let schema = Schema::read();
    assert_eq!(schema.faults(&document), [""; 0]);
    assert_eq!(document["holes"][0]["edges"], 3);
    let mut wrong = document;
    wrong["holes"][0]["edges"] = Value::from("three");
    assert_ne!(schema.faults(&wrong), [""; 0]);
}
