//! The header of the C interface, `c/include/isomend.h`, against the source in `c/src`: functions, fields, types and values.
//!
//! The header is written by hand, for its comments; this test takes milliseconds, where a generator would have to be built in every run.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::files_below;

/// Types of the source that have another name in C.
const TYPES: [(&str, &str); 14] = [
    ("MeshHandle", "isomend_mesh"),
    ("ResultHandle", "isomend_result"),
    ("CancelHandle", "isomend_cancel"),
    ("RunOptions", "isomend_options"),
    ("MaskArrays", "isomend_mask"),
    ("ProgressFunction", "isomend_progress"),
    ("Status", "isomend_status"),
    ("c_char", "char"),
    ("c_void", "void"),
    ("u32", "uint32_t"),
    ("i32", "int32_t"),
    ("usize", "size_t"),
    ("f64", "double"),
    ("f32", "float"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("c")
}

/// A text with single blanks between words and none beside punctuation.
fn squeezed(text: &str) -> String {
    let mut out = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for mark in ["(", ")", ",", ";", "*", "{", "}", "="] {
        out = out.replace(&format!(" {mark}"), mark);
        out = out.replace(&format!("{mark} "), mark);
    }
    out
}

/// A type of the source in C: `*const *mut T` becomes `T**`. C has no constant pointers here but to constant values.
fn in_c(rust: &str) -> String {
    let rust = rust.trim();
    if let Some(inner) = rust.strip_prefix("*mut ") {
        return format!("{}*", in_c(inner));
    }
    if let Some(inner) = rust.strip_prefix("*const ") {
        return format!("const {}*", in_c(inner));
    }
    let known = TYPES.iter().find(|(name, _)| *name == rust);
    known.map_or(rust, |(_, c)| c).to_owned()
}

/// Parameters of a function in C, from `name: type, …`.
fn parameters(rust: &str) -> String {
    let one = |parameter: &str| {
        let (name, kind) = parameter.split_once(':')?;
        let kind = in_c(kind);
        let blank = if kind.ends_with('*') { "" } else { " " };
        Some(format!("{kind}{blank}{}", name.trim()))
    };
    let all: Vec<String> = rust.split(',').filter_map(one).collect();
    match all.is_empty() {
        true => "void".to_owned(),
        false => all.join(","),
    }
}

/// The declaration in C of a function of the source, from the text behind `extern "C" fn `.
fn declaration(text: &str) -> String {
    let (name, rest) = text.split_once('(').unwrap();
    let (given, rest) = rest.split_once(')').unwrap();
    let result = rest.split('{').next().unwrap().trim();
    let result = result.strip_prefix("->").map_or("void".to_owned(), in_c);
    let blank = if result.ends_with('*') { "" } else { " " };
    format!("{result}{blank}{name}({})", parameters(given))
}

/// The source without comments.
fn source() -> String {
    let mut files = Vec::new();
    files_below(&root().join("src"), &["rs"], &mut files);
    files.sort();
    let code = |file: &PathBuf| fs::read_to_string(file).unwrap();
    let text: String = files.iter().map(code).collect();
    let line = |line: &str| line.split("//").next().unwrap_or("").to_owned();
    text.lines().map(line).collect::<Vec<_>>().join(" ")
}

/// The header without comments and preprocessor lines, squeezed.
fn header() -> String {
    let text = fs::read_to_string(root().join("include/isomend.h")).unwrap();
    let mut code = String::new();
    for (number, part) in text.split("/*").enumerate() {
        let rest = if number == 0 {
            part
        } else {
            part.split_once("*/").unwrap().1
        };
        code += rest;
    }
    let lines = code.lines().filter(|line| !line.starts_with('#'));
    squeezed(&lines.collect::<Vec<_>>().join(" "))
}

#[test]
fn the_header_declares_the_functions_of_the_source() {
    let source = source();
    let made: BTreeSet<String> = source
        .split("#[unsafe(no_mangle)]")
        .skip(1)
        .map(|item| squeezed(&declaration(item.split_once("fn ").unwrap().1)))
        .collect();
    assert!(made.len() > 20, "only {} were read", made.len());
    let header = header();
    let declared: BTreeSet<String> = header
        .split([';', '{', '}'])
        .filter(|statement| statement.contains("isomend_") && statement.ends_with(')'))
        .filter(|statement| !statement.starts_with("typedef"))
        .map(str::to_owned)
        .collect();
    let missing: Vec<_> = made.difference(&declared).collect();
    let extra: Vec<_> = declared.difference(&made).collect();
    assert!(
        missing.is_empty() && extra.is_empty(),
        "the header lacks {missing:#?}\nand has instead {extra:#?}"
    );
}

#[test]
fn the_header_has_the_values_and_fields_of_the_source() {
    let source = source();
    let header = header();
    let body = |begin: &str| {
        let rest = source.split_once(begin).unwrap().1;
        rest.split_once('}').unwrap().0.to_owned()
    };
    let values: BTreeMap<String, String> = body("pub enum Status {")
        .split(',')
        .filter_map(|row| row.split_once('='))
        .map(|(name, value)| {
            (
                format!("ISOMEND_{}", name.trim().to_uppercase()),
                value.trim().to_owned(),
            )
        })
        .collect();
    assert_eq!(values.len(), 7);
    for (name, value) in &values {
        let row = format!("{name}={value}");
        assert!(header.contains(&row), "the header lacks {row}");
    }
    assert_eq!(header.matches("ISOMEND_").count(), values.len());
    for (of, name, count) in [
        ("RunOptions", "isomend_options", 4),
        ("MaskArrays", "isomend_mask", 6),
    ] {
        let fields: Vec<String> = body(&format!("pub struct {of} {{"))
            .split(',')
            .filter(|field| field.contains(':'))
            .map(parameters)
            .collect();
        assert_eq!(fields.len(), count);
        let row = format!("typedef struct {name}{{{};}}", fields.join(";"));
        assert!(header.contains(&row), "the header lacks {row}");
    }
    let text = fs::read_to_string(root().join("include/isomend.h")).unwrap();
    let version = source.split_once("ABI_VERSION: u32 = ").unwrap().1;
    let version = version.split(';').next().unwrap();
    assert!(text.contains(&format!("#define ISOMEND_ABI_VERSION {version}\n")));
}
