//! Words that comments, names, messages and pages do not use, because readers would have to learn them first.

use std::fs;
use std::path::Path;

use super::files_below;

/// What is not written, and what is written instead.
const BANNED: [(&str, &str); 24] = [
    ("told", "reported, printed, given; message, record"),
    ("foretell", "predict"),
    ("foretells", "predicts"),
    ("foretold", "predicted"),
    ("so many", "a number or its unit"),
    ("so much", "a number or its unit"),
    ("that of", "the noun itself"),
    ("those of", "the noun itself"),
    ("what is new", "new vertices and faces"),
    ("crumb", "small component"),
    ("crumbs", "small components"),
    ("at rest", "converged"),
    ("comes to rest", "converges"),
    ("come to rest", "converge"),
    ("let be", "left unchanged"),
    ("hopeless", "the measured condition"),
    ("likewise", "also"),
    ("meets itself", "intersects itself"),
    ("meet itself", "intersect itself"),
    ("how sure", "expected error"),
    ("such ones", "the noun itself"),
    ("such a one", "the noun itself"),
    ("lining", "offset shell"),
    ("linings", "offset shells"),
];

/// The extensions of files that are read.
const KINDS: [&str; 12] = [
    "rs", "py", "pyi", "js", "css", "html", "md", "sh", "toml", "c", "h", "cs",
];

/// Folders and pages that are read, from the root of the repository.
const READ: [&str; 13] = [
    "src",
    "c",
    "crates",
    "tests",
    "python",
    "scripts",
    "benches",
    "examples",
    "fuzz/fuzz_targets",
    "blender",
    "docs",
    "README.md",
    "CONTRIBUTING.md",
];

/// The text of a file in one line, without the marks at the beginning of comment lines, so that a phrase is found across a line
/// break; and where in it each line begins.
fn joined(text: &str) -> (String, Vec<usize>) {
    let (mut all, mut starts) = (String::new(), Vec::new());
    for line in text.lines() {
        starts.push(all.len());
        // Old names of serialised fields stay readable.
        let line = if line.contains("alias = ") {
            ""
        } else {
            line.trim_start()
        };
        let line = line.trim_start_matches(['/', '!', '#', '*']);
        all += line.trim().to_lowercase().as_str();
        all.push(' ');
    }
    (all, starts)
}

/// Where a phrase stands as words of its own.
fn places(text: &str, phrase: &str) -> Vec<usize> {
    let is_part = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    let found = text.match_indices(phrase).map(|(at, _)| at);
    found
        .filter(|at| {
            !is_part(text[..*at].chars().next_back())
                && !is_part(text[at + phrase.len()..].chars().next())
        })
        .collect()
}

#[test]
fn banned_words_are_not_used() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    READ.iter()
        .for_each(|path| files_below(&root.join(path), &KINDS, &mut files));
    files.retain(|file| !file.ends_with("tests/house/words.rs"));
    files.sort();
    assert!(files.len() > 400, "only {} files were read", files.len());
    let mut wrong = Vec::new();
    for file in &files {
        let (text, starts) = joined(&fs::read_to_string(file).unwrap());
        for (phrase, instead) in BANNED {
            for at in places(&text, phrase) {
                let line = starts.partition_point(|start| *start <= at);
                let name = file.strip_prefix(root).unwrap().display();
                wrong.push(format!("{name}:{line}: \"{phrase}\": {instead}"));
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "{} places:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

#[test]
fn phrases_are_found_across_lines_and_as_whole_words() {
    let (text, starts) = joined("/// This is so\n    /// many, untold\nlet told = 1;");
    assert_eq!(places(&text, "so many").len(), 1);
    assert_eq!(places(&text, "told").len(), 1);
    assert_eq!(
        starts.partition_point(|s| *s <= places(&text, "told")[0]),
        3
    );
}
