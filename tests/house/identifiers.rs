//! Identifiers in the JSON documents, such as how a hole was closed: fields that hold text, and the functions `key` that return it.

use serde_json::{Value, json};
use syn::{Arm, Expr, ImplItem, ItemImpl, Lit, Pat, Stmt};

/// Fields of documents that hold identifiers: type and field, the name of the definition and its description, and the enums whose
/// variants have the identifiers.
pub const IDENTIFIERS: [(&str, &str, &str, &str, &[&str]); 5] = [
    (
        "OutcomeRow",
        "closed_by",
        "Closure",
        "How a hole or region was closed.",
        &["Closure"],
    ),
    (
        "RegionRow",
        "closed_by",
        "Closure",
        "How a hole or region was closed.",
        &["Closure"],
    ),
    (
        "OutcomeRow",
        "cause",
        "Cause",
        "Why a hole is open, or was not closed as wished.",
        &["AttemptFailure", "NotSmooth", "LeftReason", "OpenReason"],
    ),
    (
        "NotContinuedRow",
        "cause",
        "ContinuationCause",
        "Why sharp edges were not continued.",
        &["NotContinued"],
    ),
    (
        "CounterpartRow",
        "cause",
        "NotLike",
        "Why a counterpart was refused.",
        &["NotLike"],
    ),
];

/// The variants of an enum with their identifiers, from its function `key`, or `words` where this has the text of `key`.
pub fn keys(item: &ItemImpl) -> Vec<(String, String)> {
    let functions = item.items.iter().filter_map(|item| match item {
        ImplItem::Fn(function) => Some(function),
        _ => None,
    });
    let named = functions.filter(|f| f.sig.ident == "key" || f.sig.ident == "words");
    let arms = named.filter_map(|function| match function.block.stmts.last() {
        Some(Stmt::Expr(Expr::Match(body), None)) => Some(&body.arms),
        _ => None,
    });
    arms.flatten().flat_map(keys_of_arm).collect()
}

/// The variants of an arm with its identifier; none where the identifier is a value's inside the variant.
fn keys_of_arm(arm: &Arm) -> Vec<(String, String)> {
    let text = match &*arm.body {
        Expr::Array(list) => list.elems.first().and_then(text_of),
        other => text_of(other),
    };
    let mut variants = Vec::new();
    add_variants(&arm.pat, &mut variants);
    let pair = |variant: String| Some((variant, text.clone()?));
    variants.into_iter().filter_map(pair).collect()
}

fn text_of(value: &Expr) -> Option<String> {
    match value {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Str(text) => Some(text.value()),
            _ => None,
        },
        _ => None,
    }
}

fn add_variants(pattern: &Pat, variants: &mut Vec<String>) {
    let path = match pattern {
        Pat::Or(cases) => return cases.cases.iter().for_each(|p| add_variants(p, variants)),
        Pat::Path(unit) => &unit.path,
        Pat::TupleStruct(tuple) => &tuple.path,
        Pat::Struct(fields) => &fields.path,
        _ => return,
    };
    variants.push(path.segments.last().unwrap().ident.to_string());
}

/// A schema of text with the identifiers and what they mean. Of several equal identifiers the first counts.
pub fn schema(identifiers: &[(String, String)]) -> Value {
    let mut all: Vec<Value> = Vec::new();
    for (identifier, about) in identifiers {
        if !all.iter().any(|known| known["const"] == **identifier) {
            all.push(json!({ "const": identifier, "description": about }));
        }
    }
    json!({ "oneOf": all })
}
