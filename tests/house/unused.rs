//! Every public item of the packages is used: what is public to other packages is not covered by the compiler's own lint. No two types that
//! are visible in a whole package share a name.
//! Thresholds are named as their constants are.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

use super::files_below;

/// The folders whose code counts as use.
const CODE: [&str; 9] = [
    "src",
    "c/src",
    "crates",
    "python/src",
    "wasm/src",
    "tests",
    "benches",
    "examples",
    "fuzz",
];

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The kinds of types.
const TYPES: [&str; 4] = ["struct ", "enum ", "trait ", "type "];
/// The kinds of other items.
const OTHERS: [&str; 4] = ["const fn ", "fn ", "const ", "static "];

/// The name of an item of some kinds that a line declares with one of the given visibilities, if it declares one.
fn declared<'a>(line: &'a str, visible: &[&str], kinds: &[&str]) -> Option<&'a str> {
    let line = line.trim_start();
    let rest = visible.iter().find_map(|begin| line.strip_prefix(begin))?;
    let rest = rest.strip_prefix("unsafe ").unwrap_or(rest);
    let rest = kinds.iter().find_map(|kind| rest.strip_prefix(kind))?;
    let name = rest.split(|c| !is_word(c)).next();
    // A macro's `$name` is no name.
    name.filter(|name| !name.is_empty())
}

#[test]
fn public_items_are_used() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in CODE {
        files_below(&root.join(folder), &["rs"], &mut files);
    }
    let texts: Vec<String> = files
        .iter()
        .map(|f| fs::read_to_string(f).unwrap())
        .collect();
    let code = || texts.iter().flat_map(|text| text.lines());
    let mut times: HashMap<&str, usize> = HashMap::new();
    for line in code() {
        let line = line.split("//").next().unwrap_or("");
        for word in line.split(|c| !is_word(c)) {
            *times.entry(word).or_default() += 1;
        }
    }
    let public: Vec<&str> = code()
        .filter_map(|line| declared(line, &["pub "], &[TYPES, OTHERS].concat()))
        .collect();
    assert!(public.len() > 1000, "only {} were read", public.len());
    let unused: Vec<&&str> = public.iter().filter(|name| times[**name] < 2).collect();
    assert!(
        unused.is_empty(),
        "nothing names these public items: {unused:?}"
    );
}

#[test]
fn types_have_names_of_their_own() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in ["src", "crates"] {
        files_below(&root.join(folder), &["rs"], &mut files);
    }
    let is_test = |path: &Path| path.components().any(|part| part.as_os_str() == "tests");
    let mut types: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in files.iter().filter(|file| !is_test(file)) {
        for name in fs::read_to_string(file)
            .unwrap()
            .lines()
            .filter_map(|line| declared(line, &["pub ", "pub(crate) "], &TYPES))
        {
            let place = file.strip_prefix(root).unwrap().display().to_string();
            types.entry(name.to_owned()).or_default().push(place);
        }
    }
    assert!(types.len() > 300, "only {} were read", types.len());
    types.retain(|_, places| places.len() > 1);
    assert!(types.is_empty(), "types of the same name: {types:#?}");
}

#[test]
fn thresholds_have_the_names_of_their_constants() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    files_below(&root.join("crates"), &["rs"], &mut files);
    let mut places: BTreeMap<String, PathBuf> = BTreeMap::new();
    for file in files.iter().filter(|file| !file.ends_with("tuning/mod.rs")) {
        let text = fs::read_to_string(file).unwrap();
        let mut pieces = text.split(": Tunable<");
        let mut before = pieces.next().unwrap();
        for piece in pieces {
            let constant = before.rsplit(|c| !is_word(c)).next().unwrap();
            before = piece;
            let Some((_, rest)) = piece.split_once("tunable(") else {
                continue;
            };
            let name = rest.split('"').nth(1).unwrap();
            let own = name.rsplit_once('.').map(|(_, own)| own.to_uppercase());
            assert_eq!(own.as_deref(), Some(constant), "{}", file.display());
            let other = places.insert(name.to_owned(), file.clone());
            assert!(
                other.is_none(),
                "{name} in {other:?} and {}",
                file.display()
            );
        }
    }
    assert!(places.len() > 350, "only {} were read", places.len());
}
