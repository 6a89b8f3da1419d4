//! The texts of the page are in seven files, in English and in German.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The files of texts, each with the line that begins its table.
const STRINGS: [(&str, &str); 7] = [
    ("strings.js", "const WORDS = {\n"),
    ("deliver_strings.js", "const DELIVER_WORDS = {\n"),
    ("job_strings.js", "const JOB_WORDS = {\n"),
    ("like_strings.js", "const LIKE_WORDS = {\n"),
    ("paint_strings.js", "const PAINT_WORDS = {\n"),
    ("parameter_strings.js", "const PARAMETER_WORDS = {\n"),
    ("print_strings.js", "const PRINT_WORDS = {\n"),
];
/// Parts of literals that are not texts for a user: CSS, command lines, keys of the program's tables, and the page's name.
const NO_WORDS: [&str; 7] = [
    "isomend view",
    "bold px system-ui, sans-serif",
    "--faces mask.txt",
    "the mesh's unit",
    "in the mesh's units",
    "use strict",
    "last region",
];
/// Texts allowed in the markup: names that are the same in every language, units, and the text for browsers without scripts.
const MARKUP: [&str; 14] = [
    "isomend view",
    "English",
    "Deutsch",
    "auto",
    "mm",
    "cm",
    "m",
    "µm",
    "in",
    "ft",
    "x",
    "y",
    "z",
    "This page needs JavaScript.",
];

/// Literals beside texts that a script shows: values that are compared, names of elements and properties, and the program's name.
const NO_TEXTS: [&str; 7] = [
    "dark",
    "title",
    "textContent",
    "dd",
    "isomend",
    " – isomend view",
    ",  · isomend ",
];
/// What comes before a text that a user sees: assignments, properties of new elements, messages.
const SHOWN: [&str; 19] = [
    ".textContent = ",
    ".innerText = ",
    ".innerHTML = ",
    ".title = ",
    ".placeholder = ",
    ".ariaLabel = ",
    ".label = ",
    "textContent: ",
    "title: ",
    "placeholder: ",
    "ariaLabel: ",
    "setAttribute(\"aria-label\", ",
    "setAttribute(\"title\", ",
    "say(",
    "notify(",
    "Error(",
    "confirm(",
    "alert(",
    "prompt(",
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/view/web")
}

fn text(name: &str) -> String {
    fs::read_to_string(folder().join(name)).unwrap()
}

/// Whether a script is a file of texts.
fn has_texts(name: &str) -> bool {
    STRINGS.iter().any(|(file, _)| *file == name)
}

/// The scripts of the page, except the files of texts.
fn scripts() -> BTreeMap<String, String> {
    let names = fs::read_dir(folder()).unwrap();
    let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names
        .filter(|name| name.ends_with(".js") && !has_texts(name))
        .map(|name| (name.clone(), text(&name)))
        .collect()
}

/// The string literals of a script, without comments and without the expressions in templates.
fn literals(script: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut chars = script.chars().peekable();
    let mut last = ' ';
    while let Some(c) = chars.next() {
        match c {
            '/' if chars.peek() == Some(&'/') && last != ':' => {
                while chars.next_if(|c| *c != '\n').is_some() {}
            }
            '/' if chars.peek() == Some(&'*') => {
                let mut before = ' ';
                for c in chars.by_ref() {
                    if before == '*' && c == '/' {
                        break;
                    }
                    before = c;
                }
            }
            '"' | '`' => {
                let mut literal = String::new();
                let mut depth = 0;
                while let Some(d) = chars.next() {
                    match d {
                        '\\' => drop(chars.next()),
                        '$' if c == '`' && chars.peek() == Some(&'{') => depth += 1,
                        '}' if depth > 0 => depth -= 1,
                        _ if d == c && depth == 0 => break,
                        _ if depth == 0 => literal.push(d),
                        _ => {}
                    }
                }
                found.push(literal);
            }
            _ => {}
        }
        last = c;
    }
    found
}

/// Whether a text has two consecutive words, the second in lower case, and is not a CSS selector.
fn has_words(literal: &str) -> bool {
    let mut rest = literal.to_owned();
    for known in NO_WORDS {
        rest = rest.replace(known, "");
    }
    let is_selector = rest.starts_with(['#', '.', '[', '<', '-']) || rest.contains(":not(");
    let words: Vec<&str> = rest.split(' ').collect();
    let is_word = |w: &str| w.len() > 1 && w.chars().all(|c| c.is_alphabetic() || "’'".contains(c));
    let follows = words.windows(2).any(|pair| {
        let first = pair[0].trim_end_matches([',', '.', ':', ';']);
        let second = pair[1].trim_end_matches([',', '.', ':', ';', '!', '?', '…']);
        is_word(first) && is_word(second) && second.chars().all(char::is_lowercase)
    });
    follows && !is_selector
}

/// A line of a script without the calls whose literals are names of texts or of elements, with their arguments.
fn without_calls(line: &str) -> String {
    let mut kept = line.to_owned();
    for call in [
        "tr(", "counts(", "find(", "all(", "has(", "replace(", "join(",
    ] {
        while let Some(start) = kept.find(call) {
            let mut depth = 0;
            let end = kept[start..].find(|c| {
                depth += i32::from(c == '(') - i32::from(c == ')');
                c == ')' && depth == 0
            });
            let end = end.map_or(kept.len(), |end| start + end + 1);
            kept.replace_range(start..end, "");
        }
    }
    kept
}

/// The literals with words that a script shows to a user.
fn shown_literals(script: &str) -> Vec<String> {
    let has_word = |l: &String| {
        l.split(|c: char| !c.is_alphabetic())
            .any(|word| word.chars().count() > 1)
    };
    let mut found = Vec::new();
    for before in SHOWN {
        for rest in script.split(before).skip(1) {
            let end = rest.find(['\n', ';']).unwrap_or(rest.len());
            found.extend(
                literals(&without_calls(&rest[..end]))
                    .into_iter()
                    .filter(has_word),
            );
        }
    }
    found
}

/// The table of texts: each name with its English and German text.
fn table() -> BTreeMap<String, (String, String)> {
    let mut words = String::new();
    for (file, begin) in STRINGS {
        let text = text(file);
        let (_, own) = text.split_once(begin).unwrap();
        words += own.split_once("\n};").unwrap().0;
        words.push('\n');
    }
    let joined = words
        .replace("[\n    \"", "[\"")
        .replace("\",\n    \"", "\", \"")
        .replace("\",\n  ]", "\"]");
    let rows = joined
        .lines()
        .map(str::trim)
        .filter(|line| !line.starts_with("//"));
    rows.map(|line| {
        let (name, said) = line.split_once(": [").unwrap_or_else(|| panic!("{line}"));
        let said: Vec<String> = literals(said);
        assert_eq!(said.len(), 2, "{name} is not said in two languages");
        let name = name.trim_matches('"').to_owned();
        (name, (said[0].clone(), said[1].clone()))
    })
    .collect()
}

/// The names of placeholders in braces, sorted.
fn places(said: &str) -> Vec<String> {
    let parts = said.split('{').skip(1);
    let mut names: Vec<String> = parts
        .filter_map(|p| Some(p.split_once('}')?.0.to_owned()))
        .collect();
    names.sort();
    names.dedup();
    names
}

#[test]
fn scripts_of_the_page_have_no_texts_for_users() {
    for (name, script) in scripts() {
        let found: Vec<String> = literals(&script)
            .into_iter()
            .filter(|l| has_words(l))
            .collect();
        assert!(
            found.is_empty(),
            "{name} has words that belong to {STRINGS:?}: {found:?}"
        );
    }
    assert!(has_words("The mesh is open.") && has_words(", lost again"));
    assert!(!has_words("#holes li") && !has_words("bridge"));
}

#[test]
fn scripts_show_only_texts_of_the_table() {
    for (name, script) in scripts() {
        let mut found = shown_literals(&script);
        found.retain(|l| !NO_TEXTS.contains(&l.as_str()) && !NO_WORDS.contains(&l.as_str()));
        assert!(found.is_empty(), "{name} shows {found:?}");
    }
    let wrong = "a.textContent = is ? \"Yes\" : tr(is ? \"undo\" : \"redo\");\nsay(`Done ${n}`);";
    assert_eq!(shown_literals(wrong), ["Yes", "Done "]);
    let right = "b.title = `${a} s`; find(\"#x\").value = \"Yes\"; say(tr(\"open\"));";
    assert!(shown_literals(right).is_empty());
}

/// Whether a word stands in a text, not as a part of a longer word.
fn contains_word(text: &str, word: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word).any(|(at, _)| {
        let [before, after] = [&text[..at], &text[at + word.len()..]];
        !before.ends_with(is_part) && !after.starts_with(is_part)
    })
}

/// The name of a variant in Rust, from its name in JSON: `SelfIntersection` for `self_intersection`.
fn variant(name: &str) -> String {
    let upper = |part: &str| {
        let (first, rest) = part.split_at(part.len().min(1));
        first.to_uppercase() + rest
    };
    name.split('_').map(upper).collect()
}

/// The text of all files of a folder that end in `.rs`.
fn rust_below(folder: &Path) -> String {
    let mut all = String::new();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            all += &rust_below(&path);
        } else if path.extension().is_some_and(|e| e == "rs") {
            all += &fs::read_to_string(&path).unwrap();
        }
    }
    all
}

#[test]
fn every_text_is_used() {
    let strings = text("strings.js");
    // The part after the table names texts too: the help, and what is counted.
    let (_, after) = strings.split_once("\n};").unwrap();
    let used = scripts().into_values().collect::<String>()
        + &text("page.html")
        + &text("start.html")
        + after;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let rust = rust_below(&root.join("src")) + &rust_below(&root.join("crates"));
    // Beginnings of names that scripts complete, as "kind_" in tr("kind_" + kind).
    let begins: Vec<&str> = used
        .split('"')
        .filter(|part| part.ends_with('_') && !part.contains(' '))
        .collect();
    let is_completed = |name: &str| {
        begins.iter().any(|begin| {
            let rest = name.strip_prefix(begin).unwrap_or_default();
            let rest = rest.strip_suffix("_hint").unwrap_or(rest);
            // A list of words has a box for each: "p_skip_holes" is the box of `holes` of the parameter `skip`.
            let part = rest.split_once('_').map_or(rest, |(_, part)| part);
            let in_program = |name: &str| contains_word(&rust, name);
            let is_in_program = in_program(rest)
                || in_program(&variant(rest))
                || in_program(&format!("\"{part}\""));
            !rest.is_empty() && (contains_word(&used, rest) || is_in_program)
        })
    };
    let unused: Vec<String> = table()
        .into_keys()
        .filter(|name| !used.contains(&format!("\"{name}\"")) && !is_completed(name))
        .collect();
    assert!(unused.is_empty(), "nothing shows {unused:?}");
}

#[test]
fn the_markup_has_no_texts_for_users() {
    let html = text("page.html") + &text("start.html");
    let body = html
        .split('>')
        .map(|part| part.split('<').next().unwrap_or_default().trim());
    for said in body.filter(|said| said.chars().filter(|c| c.is_alphabetic()).count() > 0) {
        let is_axis = said.len() == 2 && said.ends_with(['X', 'Y', 'Z']);
        assert!(is_axis || MARKUP.contains(&said), "page.html says {said:?}");
    }
    for attribute in [" aria-label=", " title=", " alt="] {
        assert!(!html.contains(attribute), "page.html has{attribute}");
    }
}

#[test]
fn every_text_is_in_both_languages() {
    let words = table();
    for (name, (english, german)) in &words {
        assert!(!english.is_empty() && !german.is_empty(), "{name}");
        assert_eq!(places(english), places(german), "{name}");
    }
    let html = text("page.html");
    for kind in ["data-words=\"", "data-label=\"", "data-title=\""] {
        for part in html.split(kind).skip(1) {
            let name = part.split('"').next().unwrap();
            assert!(words.contains_key(name), "page.html names {name:?}");
        }
    }
    let mut all: Vec<(String, String)> = scripts().into_iter().collect();
    all.extend(STRINGS.map(|(file, _)| (file.to_owned(), text(file))));
    for (file, script) in &all {
        for part in script.split("tr(\"").skip(1) {
            let name = part.split('"').next().unwrap();
            let is_whole = part[name.len() + 1..].starts_with([')', ',']);
            let begins = words.keys().any(|key| key.starts_with(name));
            assert!(
                if is_whole {
                    words.contains_key(name)
                } else {
                    begins
                },
                "{file} says {name:?}"
            );
        }
    }
}
