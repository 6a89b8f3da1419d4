//! How the source is laid out: rooms import only what lies below them, and no files import each other in a circle. Beside it what needs
//! a process in which nothing else saves files.
#![allow(clippy::unwrap_used, clippy::too_many_lines)] // A test that cannot go on fails; long ones tell one story.

mod parameters;
mod unfinished;
mod written;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The rooms of the library from the ground up: each may import those of lower rows only.
const ROWS: [&[&str]; 14] = [
    &["cancel", "setters", "parameters", "tuning"],
    &["grid", "linalg", "mesh"],
    &["spatial", "io"],
    &["sdf", "extract", "compare", "check"],
    &["flow"],
    &["attributes", "creases", "finish", "region", "stitch"],
    &["fill", "texture", "volume"],
    &["mend"],
    &["repair"],
    &["report", "study"],
    &["job"],
    &["view"],
    &["cli"],
    &["internals"],
];

/// A path of modules from the crate's root.
type Module = Vec<String>;

/// The modules of the crate but tests, with their files and the paths that they import.
struct Source {
    files: BTreeMap<Module, PathBuf>,
    imports: BTreeMap<Module, Vec<(bool, Module)>>,
}

impl Source {
    fn read() -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let mut files = BTreeMap::new();
        collect(&root, &mut Vec::new(), &mut files);
        let imports = files
            .iter()
            .map(|(module, file)| {
                let is_folder = file.ends_with("mod.rs") || module.is_empty();
                (module.clone(), imports(module, is_folder, &code(file)))
            })
            .collect();
        Self { files, imports }
    }

    fn is_folder(&self, module: &Module) -> bool {
        module.is_empty() || self.files[module].ends_with("mod.rs")
    }

    /// The file in which what a path names is defined, through re-exports; none outside the crate.
    fn definition(&self, path: &Module) -> Option<Module> {
        let depth = (0..=path.len())
            .rev()
            .find(|&n| self.files.contains_key(&path[..n]))?;
        let module = path[..depth].to_vec();
        let name = path.get(depth);
        if let Some(name) = name.filter(|_| self.is_folder(&module)) {
            let through = self.imports[&module].iter().find(|(public, target)| {
                *public && target.last() == Some(name) && *target != *path
            });
            if let Some((_, target)) = through {
                return self.definition(target);
            }
        }
        Some(module)
    }

    /// The files that a file imports from; the front of a folder, which names what is in it, counts as none.
    fn arrows(&self, module: &Module) -> BTreeSet<Module> {
        self.imports[module]
            .iter()
            .filter(|(public, _)| !public)
            .filter_map(|(_, path)| self.definition(path))
            .filter(|target| target != module && !self.is_folder(target))
            .collect()
    }
}

fn collect(folder: &Path, at: &mut Module, files: &mut BTreeMap<Module, PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if name.contains("tests") || name == "main" {
            continue;
        }
        let is_rust = path.extension().is_some_and(|e| e == "rs");
        if path.is_dir() {
            at.push(name);
            collect(&path, at, files);
            at.pop();
        } else if is_rust && (name == "mod" || name == "lib") {
            files.insert(at.clone(), path);
        } else if is_rust {
            files.insert([at.clone(), vec![name]].concat(), path);
        }
    }
}

/// The code of a file, without comments and the tests at its end.
fn code(file: &Path) -> String {
    let text = fs::read_to_string(file).unwrap();
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let line = |line: &str| line.split("//").next().unwrap_or("").to_owned();
    code.lines().map(line).collect::<Vec<_>>().join(" ")
}

/// The paths of the crate that `use` lines name, and whether they are passed on.
fn imports(module: &Module, is_folder: bool, code: &str) -> Vec<(bool, Module)> {
    let mut found = Vec::new();
    for statement in code.split(';') {
        let Some(start) = statement.rfind(" use ").map(|at| at + 1).or_else(|| {
            statement
                .trim_start()
                .starts_with("use ")
                .then(|| statement.find("use ").unwrap())
        }) else {
            continue;
        };
        let public = statement[..start].trim_end().ends_with("pub");
        let tree = statement[start + 4..].replace(' ', "");
        let is_path = |c: char| c.is_alphanumeric() || "_:{},*".contains(c);
        if !tree.chars().all(is_path) || tree.matches('{').count() != tree.matches('}').count() {
            continue;
        }
        for path in expanded(&tree) {
            let mut parts: Vec<&str> = path.split("::").collect();
            let parent = module.len() - usize::from(!is_folder && !module.is_empty());
            let mut from = match parts[0] {
                "crate" => Vec::new(),
                "self" => module.clone(),
                "super" if is_folder => module[..module.len() - 1].to_vec(),
                "super" => module[..parent].to_vec(),
                name if is_folder && public => {
                    parts.insert(0, name);
                    module.clone()
                }
                _ => continue,
            };
            for part in &parts[1..] {
                match *part {
                    "super" => {
                        from.pop();
                    }
                    "self" => {}
                    name => from.push(name.split("as").next().unwrap_or(name).to_owned()),
                }
            }
            found.push((public, from));
        }
    }
    found
}

/// The paths of a `use` tree such as `a::{b, c::{d, e}}`.
fn expanded(tree: &str) -> Vec<String> {
    let Some(open) = tree.find('{') else {
        return vec![tree.to_owned()];
    };
    let (prefix, inner) = (
        &tree[..open],
        &tree[open + 1..tree.rfind('}').unwrap_or(tree.len())],
    );
    let (mut depth, mut parts, mut part) = (0, Vec::new(), String::new());
    for c in inner.chars() {
        match c {
            ',' if depth == 0 => parts.push(std::mem::take(&mut part)),
            c => {
                depth += i32::from(c == '{') - i32::from(c == '}');
                part.push(c);
            }
        }
    }
    parts.push(part);
    parts
        .iter()
        .filter(|p| !p.is_empty())
        .flat_map(|p| expanded(p))
        .map(|p| format!("{prefix}{p}"))
        .collect()
}

#[test]
fn arrows_between_rooms_go_down() {
    let source = Source::read();
    let row = |room: &str| ROWS.iter().position(|row| row.contains(&room));
    let mut arrows = 0;
    for (module, imports) in &source.imports {
        let Some(room) = module.first() else { continue };
        let own = row(room).unwrap_or_else(|| panic!("the room {room} stands in no row"));
        for (_, path) in imports {
            let Some(other) = path.first().filter(|other| *other != room) else {
                continue;
            };
            if let Some(other_row) = row(other) {
                assert!(
                    other_row < own,
                    "{} imports {}",
                    module.join("::"),
                    path.join("::")
                );
                arrows += 1;
            }
        }
    }
    assert!(
        arrows > 100,
        "only {arrows} imports between rooms were read"
    );
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let source = Source::read();
    let arrows: BTreeMap<&Module, BTreeSet<Module>> =
        source.files.keys().map(|m| (m, source.arrows(m))).collect();
    assert!(arrows.values().map(BTreeSet::len).sum::<usize>() > 300);
    // Files to which or from which no arrow is left are taken away until none is; circles are what stays.
    let mut left: BTreeSet<&Module> = arrows.keys().copied().collect();
    loop {
        let ends = |m: &Module| !arrows[m].iter().any(|target| left.contains(target));
        let begins = |m: &Module| !left.iter().any(|from| arrows[*from].contains(m));
        let free: Vec<&Module> = left
            .iter()
            .copied()
            .filter(|m| ends(m) || begins(m))
            .collect();
        if free.is_empty() {
            break;
        }
        free.iter().for_each(|m| {
            left.remove(m);
        });
    }
    let names: Vec<String> = left.iter().map(|m| m.join("::")).collect();
    assert!(names.is_empty(), "in circles: {}", names.join(", "));
}
