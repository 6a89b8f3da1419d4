//! Documentation and attributes of serde at types, fields and variants in the source.

use syn::{Attribute, Expr, Lit, Meta};

/// The attributes of serde at a type, field or variant.
#[derive(Default)]
pub struct Serde {
    pub is_flat: bool,
    pub is_untagged: bool,
    pub is_transparent: bool,
    pub is_skipped: bool,
    pub may_be_left_out: bool,
    pub rename: Option<String>,
    pub rename_all: Option<String>,
}

impl Serde {
    pub fn of(attributes: &[Attribute]) -> Self {
        let mut found = Self::default();
        for attribute in attributes.iter().filter(|a| a.path().is_ident("serde")) {
            let read = attribute.parse_nested_meta(|meta| {
                let name = meta.path.get_ident().unwrap().to_string();
                let text = match meta.value() {
                    Ok(value) => Some(value.parse::<syn::LitStr>()?.value()),
                    Err(_) => None,
                };
                match name.as_str() {
                    "flatten" => found.is_flat = true,
                    "untagged" => found.is_untagged = true,
                    "transparent" => found.is_transparent = true,
                    "skip" => found.is_skipped = true,
                    "skip_serializing_if" => found.may_be_left_out = true,
                    "rename" => found.rename = text,
                    "rename_all" => found.rename_all = text,
                    // They concern reading only.
                    "alias" | "default" | "skip_deserializing" | "deny_unknown_fields" => {}
                    other => panic!("the schema does not know serde's attribute {other}"),
                }
                Ok(())
            });
            read.unwrap();
        }
        found
    }
}

/// The documentation of an item as text in one line, without links, in the words of JSON.
pub fn about(attributes: &[Attribute]) -> String {
    in_json(&lines(attributes))
}

/// The same of its first paragraph only.
pub fn in_short(attributes: &[Attribute]) -> String {
    let lines = lines(attributes);
    let first = lines.split(String::is_empty).next();
    in_json(first.unwrap_or_default())
}

/// The lines of an item's documentation.
fn lines(attributes: &[Attribute]) -> Vec<String> {
    let line = |attribute: &Attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(text) => match &text.lit {
                Lit::Str(text) => Some(text.value().trim().to_owned()),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    };
    attributes.iter().filter_map(line).collect()
}

fn in_json(lines: &[String]) -> String {
    let text = unlinked(lines.join(" ").trim());
    text.replace("`None`", "null")
        .replace("; none ", "; null ")
        .replace(". None ", ". Null ")
}

/// A text without the targets of its links: [`CheckParams::thin`] becomes `thin`.
fn unlinked(text: &str) -> String {
    let (mut made, mut rest) = (String::new(), text);
    while let Some((before, after)) = rest.split_once("[`") {
        let (name, after) = after.split_once("`]").unwrap();
        let after = match after.strip_prefix('(') {
            Some(target) => target.split_once(')').unwrap().1,
            None => after,
        };
        let name = name.rsplit("::").next().unwrap();
        made += &format!("{before}`{name}`");
        rest = after;
    }
    made + rest
}

/// `CurvatureVariation` as `curvature_variation` or `curvature-variation`.
pub fn renamed(name: &str, case: Option<&str>) -> String {
    let separator = match case {
        None => return name.to_owned(),
        Some("snake_case") => '_',
        Some("kebab-case") => '-',
        Some(other) => panic!("the schema does not know the case {other}"),
    };
    let mut made = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !made.is_empty() {
            made.push(separator);
        }
        made.extend(letter.to_lowercase());
    }
    made
}
