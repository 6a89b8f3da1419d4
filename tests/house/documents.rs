//! The types of the JSON documents as the source declares them: names, fields, documentation and the attributes of serde.
//!
//! They are read from the source, so that neither the library nor its users build a generator, and the engine needs no second derive.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use syn::{Expr, Field, Fields, Item, ItemEnum, ItemStruct, Lit, Meta, Type, Variant};

use super::attributes::{Serde, about, in_short, renamed};
use super::files_below;
use super::identifiers::{self, IDENTIFIERS};

/// The folders with types of documents.
const FOLDERS: [&str; 4] = [
    "crates/core/src",
    "crates/files/src/job",
    "crates/study/src",
    "src/cli",
];

/// A field of a document.
#[derive(Clone)]
pub struct Property {
    pub name: String,
    /// What it holds: one or more sentences.
    pub about: String,
    pub schema: Value,
    pub is_required: bool,
}

/// The fields of one form of a document, in the order of the document.
pub type Form = Vec<Property>;

/// A type of a document.
pub enum Shape {
    /// Objects in one or several forms.
    Object(Vec<Form>),
    /// Another value.
    Value(Value),
}

/// A declaration that derives `Serialize`.
#[derive(Clone)]
enum Declared {
    Struct(ItemStruct),
    Enum(ItemEnum),
}

impl Declared {
    fn of(item: Item) -> Option<(String, Self)> {
        let (name, attributes, declared) = match item {
            Item::Struct(item) => (item.ident.clone(), item.attrs.clone(), Self::Struct(item)),
            Item::Enum(item) => (item.ident.clone(), item.attrs.clone(), Self::Enum(item)),
            _ => return None,
        };
        let derives = attributes.iter().filter_map(|a| match &a.meta {
            Meta::List(list) if list.path.is_ident("derive") => Some(list.tokens.to_string()),
            _ => None,
        });
        let mut words = derives.flat_map(|list| {
            let words: Vec<String> = list.split([',', ':', ' ']).map(ToOwned::to_owned).collect();
            words
        });
        words
            .any(|word| word == "Serialize")
            .then(|| (name.to_string(), declared))
    }
}

/// The name of a type's definition in the schema: without the endings that tell rows of documents from the types they are made from.
pub fn definition(name: &str) -> &str {
    let short = name.strip_suffix("Row").or(name.strip_suffix("Body"));
    short.unwrap_or(name)
}

/// All declared types of documents, and the definitions of these that were met.
pub struct Types {
    declared: HashMap<String, Vec<Declared>>,
    /// The variants of enums with their identifiers in documents.
    keys: HashMap<String, Vec<(String, String)>>,
    /// The definitions in the order in which they were met: name, documentation, shape.
    pub definitions: Vec<(String, String, Shape)>,
    /// The types of the definitions.
    met: HashMap<String, String>,
    /// The type for the parameter `T` of the type in progress.
    parameter: Option<String>,
}

impl Types {
    /// Reads the source.
    pub fn read() -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut files = Vec::new();
        FOLDERS
            .iter()
            .for_each(|folder| files_below(&root.join(folder), &["rs"], &mut files));
        let mut declared: HashMap<String, Vec<Declared>> = HashMap::new();
        let mut keys: HashMap<String, Vec<(String, String)>> = HashMap::new();
        for file in files {
            let source = syn::parse_file(&fs::read_to_string(&file).unwrap()).unwrap();
            for item in source.items {
                if let Item::Impl(own) = &item
                    && own.trait_.is_none()
                    && matches!(*own.self_ty, Type::Path(_))
                {
                    keys.entry(name_of(&own.self_ty))
                        .or_default()
                        .extend(identifiers::keys(own));
                }
                if let Some((name, item)) = Declared::of(item) {
                    declared.entry(name).or_default().push(item);
                }
            }
        }
        Self {
            declared,
            keys,
            definitions: Vec::new(),
            met: HashMap::new(),
            parameter: None,
        }
    }

    fn declaration(&self, name: &str) -> Declared {
        match self.declared.get(name).map(Vec::as_slice) {
            Some([one]) => one.clone(),
            Some(_) => panic!("several types of documents have the name {name}"),
            None => panic!("no type with the name {name} derives Serialize"),
        }
    }

    /// The documentation of a type.
    pub fn about(&self, name: &str) -> String {
        match self.declaration(name) {
            Declared::Struct(item) => about(&item.attrs),
            Declared::Enum(item) => about(&item.attrs),
        }
    }

    /// The forms of a document whose type is `outer<inner>`.
    pub fn document(&mut self, outer: &str, inner: &str) -> Vec<Form> {
        self.parameter = Some(inner.to_owned());
        let forms = self.forms(outer);
        self.parameter = None;
        forms
    }

    /// A reference to the definition of a type, which is made when it is first met.
    fn reference(&mut self, name: &str) -> Value {
        let short = definition(name).to_owned();
        let target = json!({ "$ref": format!("#/$defs/{short}") });
        match self.met.get(&short) {
            Some(other) => assert_eq!(other, name, "two types have the definition {short}"),
            None => {
                self.met.insert(short.clone(), name.to_owned());
                let place = self.definitions.len();
                let placeholder = Shape::Value(Value::Null);
                self.definitions.push((short, String::new(), placeholder));
                let (about, shape) = self.shape(name);
                (self.definitions[place].1, self.definitions[place].2) = (about, shape);
            }
        }
        target
    }

    fn shape(&mut self, name: &str) -> (String, Shape) {
        match self.declaration(name) {
            Declared::Struct(item) => {
                let is_transparent = Serde::of(&item.attrs).is_transparent;
                let shape = match item.fields {
                    Fields::Unnamed(fields) if is_transparent => {
                        Shape::Value(self.value(&fields.unnamed[0].ty))
                    }
                    _ => Shape::Object(self.forms(name)),
                };
                (about(&item.attrs), shape)
            }
            Declared::Enum(item) if Serde::of(&item.attrs).is_untagged => {
                let all_objects = item.variants.iter().all(|v| match &v.fields {
                    Fields::Unnamed(fields) => self.is_object(&fields.unnamed[0].ty),
                    fields => matches!(fields, Fields::Named(_)),
                });
                let shape = match all_objects {
                    true => Shape::Object(self.forms(name)),
                    false => Shape::Value(self.untagged_value(&item)),
                };
                (about(&item.attrs), shape)
            }
            Declared::Enum(item) => {
                let case = Serde::of(&item.attrs).rename_all;
                let variants = item.variants.iter();
                let all: Vec<Value> = variants.map(|v| self.variant(v, case.as_deref())).collect();
                (about(&item.attrs), Shape::Value(json!({ "oneOf": all })))
            }
        }
    }

    /// An untagged enum with values that are no objects. A unit variant is null.
    fn untagged_value(&mut self, item: &ItemEnum) -> Value {
        let variants = item.variants.iter();
        let all = variants.map(|variant| match &variant.fields {
            Fields::Unnamed(fields) => self.value(&fields.unnamed[0].ty),
            Fields::Unit => json!({ "type": "null" }),
            Fields::Named(_) => panic!("{} has named fields", variant.ident),
        });
        json!({ "anyOf": all.collect::<Vec<_>>() })
    }

    /// A variant as serde writes it: its name, or an object with one field of this name.
    fn variant(&mut self, variant: &Variant, case: Option<&str>) -> Value {
        let own = Serde::of(&variant.attrs).rename;
        let name = own.unwrap_or_else(|| renamed(&variant.ident.to_string(), case));
        let text = about(&variant.attrs);
        match &variant.fields {
            Fields::Unit => json!({ "const": name, "description": text }),
            Fields::Unnamed(fields) if fields.unnamed.len() == 1 => {
                let inner = self.value(&fields.unnamed[0].ty);
                json!({
                    "type": "object", "description": text,
                    "required": [name.clone()], "properties": { name: inner },
                })
            }
            _ => panic!("the schema does not know variants as {name}"),
        }
    }

    fn is_object(&self, kind: &Type) -> bool {
        let name = name_of(kind);
        self.declared.contains_key(&name)
            && matches!(self.declaration(&name), Declared::Struct(item) if matches!(item.fields, Fields::Named(_)))
    }

    /// The forms of an object's type.
    fn forms(&mut self, name: &str) -> Vec<Form> {
        match self.declaration(name) {
            Declared::Struct(item) => self.forms_of_fields(&item.fields, name),
            Declared::Enum(item) => {
                assert!(Serde::of(&item.attrs).is_untagged, "{name} has tags");
                let variants = item.variants.iter();
                variants
                    .flat_map(|variant| match &variant.fields {
                        Fields::Unnamed(fields) => self.inner_forms(&fields.unnamed[0].ty),
                        fields => self.forms_of_fields(fields, name),
                    })
                    .collect()
            }
        }
    }

    fn forms_of_fields(&mut self, fields: &Fields, owner: &str) -> Vec<Form> {
        let mut forms = vec![Form::new()];
        for field in fields {
            let serde = Serde::of(&field.attrs);
            if serde.is_skipped {
                continue;
            }
            let added = match serde.is_flat {
                true => self.inner_forms(&field.ty),
                false => vec![vec![self.property(field, &serde, owner)]],
            };
            forms = forms
                .iter()
                .flat_map(|form| added.iter().map(|more| [&form[..], more].concat()))
                .collect();
        }
        forms
    }

    /// The forms of a type whose fields stand in another object. An `Option` permits that all of its fields are left out.
    fn inner_forms(&mut self, kind: &Type) -> Vec<Form> {
        if let Some(inner) = argument(kind, "Option") {
            let mut forms = self.inner_forms(inner);
            forms
                .iter_mut()
                .flatten()
                .for_each(|p| p.is_required = false);
            return forms;
        }
        match argument(kind, "Box") {
            Some(inner) => self.inner_forms(inner),
            None => {
                let name = name_of(kind);
                let parameter = self.parameter.clone().filter(|_| name == "T");
                self.forms(&parameter.unwrap_or(name))
            }
        }
    }

    fn property(&mut self, field: &Field, serde: &Serde, owner: &str) -> Property {
        let name = field.ident.as_ref().unwrap().to_string();
        let about = in_short(&field.attrs);
        assert!(!about.is_empty(), "{owner}::{name} has no documentation");
        // A value that may be left out is not null.
        let kind = argument(&field.ty, "Option").filter(|_| serde.may_be_left_out);
        let kind = kind.unwrap_or(&field.ty);
        let schema = match self.identifiers(owner, &name) {
            Some(identifiers) if argument(kind, "Option").is_some() => nullable(identifiers),
            Some(identifiers) => identifiers,
            None => self.value(kind),
        };
        Property {
            schema,
            name: serde.rename.clone().unwrap_or(name),
            about,
            is_required: !serde.may_be_left_out,
        }
    }

    /// A reference to the identifiers of a field, if it holds some.
    fn identifiers(&mut self, owner: &str, field: &str) -> Option<Value> {
        let is_own = |(of, name, ..): &&(&str, &str, _, _, _)| *of == owner && *name == field;
        let (.., name, text, enums) = IDENTIFIERS.iter().find(is_own)?;
        if self
            .met
            .insert((*name).to_owned(), (*name).to_owned())
            .is_none()
        {
            let mut all = Vec::new();
            for one in *enums {
                let Declared::Enum(item) = self.declaration(one) else {
                    panic!("{one} is no enum");
                };
                let of = |variant: &str| item.variants.iter().find(|v| v.ident == variant).unwrap();
                let keys = self.keys[*one].iter();
                all.extend(keys.map(|(variant, key)| (key.clone(), about(&of(variant).attrs))));
            }
            assert!(all.len() > 1, "{name} has no identifiers");
            let shape = Shape::Value(identifiers::schema(&all));
            self.definitions
                .push(((*name).to_owned(), (*text).to_owned(), shape));
        }
        Some(json!({ "$ref": format!("#/$defs/{name}") }))
    }

    /// The schema of a field's type.
    fn value(&mut self, kind: &Type) -> Value {
        match kind {
            Type::Reference(to) => self.value(&to.elem),
            Type::Slice(of) => json!({ "type": "array", "items": self.value(&of.elem) }),
            Type::Array(of) => {
                let count = length(&of.len);
                json!({
                    "type": "array", "items": self.value(&of.elem), "minItems": count, "maxItems": count,
                })
            }
            _ => self.named_value(kind),
        }
    }

    fn named_value(&mut self, kind: &Type) -> Value {
        if let Some(inner) = argument(kind, "Option") {
            return nullable(self.value(inner));
        }
        if let Some(inner) = argument(kind, "Vec") {
            return json!({ "type": "array", "items": self.value(inner) });
        }
        if let Some(inner) = argument(kind, "Box") {
            return self.value(inner);
        }
        match name_of(kind).as_str() {
            "usize" | "u8" | "u32" | "u64" => json!({ "type": "integer", "minimum": 0 }),
            "f64" => json!({ "type": "number" }),
            "bool" => json!({ "type": "boolean" }),
            "String" | "str" => json!({ "type": "string" }),
            "DVec3" => json!({
                "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3,
            }),
            // The parameters of the work, which `docs/options.md` describes.
            "Value" => json!({ "type": "object" }),
            name => self.reference(name),
        }
    }
}

/// A schema that permits null too.
fn nullable(mut schema: Value) -> Value {
    match schema.get_mut("type") {
        Some(kind) => {
            *kind = json!([kind.clone(), "null"]);
            schema
        }
        None => json!({ "anyOf": [schema, { "type": "null" }] }),
    }
}

/// The last name of a type's path.
fn name_of(kind: &Type) -> String {
    match kind {
        Type::Path(path) => path.path.segments.last().unwrap().ident.to_string(),
        Type::Reference(to) => name_of(&to.elem),
        _ => panic!("the schema does not know a type of a field"),
    }
}

/// The argument of a type `of<argument>`.
fn argument<'a>(kind: &'a Type, of: &str) -> Option<&'a Type> {
    let Type::Path(path) = kind else { return None };
    let last = path.path.segments.last()?;
    let syn::PathArguments::AngleBracketed(list) = &last.arguments else {
        return None;
    };
    match list.args.first()? {
        syn::GenericArgument::Type(argument) if last.ident == of => Some(argument),
        _ => None,
    }
}

/// The length of an array.
fn length(length: &Expr) -> usize {
    match length {
        Expr::Lit(text) => match &text.lit {
            Lit::Int(number) => number.base10_parse().unwrap(),
            _ => panic!("the length of an array is no integer"),
        },
        _ => panic!("the length of an array is no literal"),
    }
}
