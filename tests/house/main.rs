//! Tests of the source's structure: modules import only from lower layers, and no files import each other in a cycle. Also tests of
//! generated files, of words, and of saves, which need a process in which nothing else saves files.
#![allow(clippy::unwrap_used, clippy::too_many_lines)] // An unwrap that fails is a failed test; long tests follow one scenario.

mod attributes;
#[path = "../common/checker.rs"]
mod checker;
mod documents;
mod header;
mod identifiers;
mod page;
mod parameters;
mod renewed;
mod schema;
mod unfinished;
mod unused;
mod words;
mod written;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The rooms of the packages that have several, by layer, from the lowest: a room may import from lower layers only. That packages
/// import from lower packages only is the compiler's to check.
const LAYERS: [(&str, &[&[&str]]); 2] = [
    (
        "core",
        &[
            &[
                "cancel",
                "elementary",
                "setters",
                "threads",
                "parameters",
                "tuning",
            ],
            &["grid", "linalg", "mesh"],
            &["spatial"],
            &["sdf", "extract", "compare", "check"],
            &["flow"],
            &["attributes", "creases", "finish", "region", "stitch"],
            &["fill", "volume"],
            &["mend"],
            &["repair"],
        ],
    ),
    ("files", &[&["io"], &["report", "texture"], &["job"]]),
];

/// Adds the files of some kinds at or below a path.
fn files_below(path: &Path, kinds: &[&str], files: &mut Vec<PathBuf>) {
    let kind = path.extension().and_then(|e| e.to_str());
    if path.is_dir() {
        for entry in fs::read_dir(path).unwrap() {
            files_below(&entry.unwrap().path(), kinds, files);
        }
    } else if kind.is_some_and(|kind| kinds.contains(&kind)) {
        files.push(path.to_owned());
    }
}

/// A module path: the package, then the path in it.
type Module = Vec<String>;

/// The modules of all packages except tests, with their files and the paths that they import.
struct Source {
    files: BTreeMap<Module, PathBuf>,
    imports: BTreeMap<Module, Vec<(bool, Module)>>,
}

impl Source {
    fn read() -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut files = BTreeMap::new();
        collect(
            &root.join("src"),
            &mut vec!["isomend".to_owned()],
            &mut files,
        );
        for package in fs::read_dir(root.join("crates")).unwrap() {
            let package = package.unwrap();
            let name = package.file_name().into_string().unwrap();
            collect(&package.path().join("src"), &mut vec![name], &mut files);
        }
        let imports = files
            .iter()
            .map(|(module, file)| {
                let is_folder = file.ends_with("mod.rs") || module.len() == 1;
                (module.clone(), imports(module, is_folder, &code(file)))
            })
            .collect();
        Self { files, imports }
    }

    fn is_folder(&self, module: &Module) -> bool {
        module.len() == 1 || self.files[module].ends_with("mod.rs")
    }

    /// The module that defines the item of a path, through re-exports; none outside the packages.
    fn definition(&self, path: &Module) -> Option<Module> {
        let depth = (1..=path.len())
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

    /// The files that a file imports from; `mod.rs` files, which only re-export, do not count.
    fn imported_files(&self, module: &Module) -> BTreeSet<Module> {
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

/// The code of a file without comments and without the tests at its end.
fn code(file: &Path) -> String {
    let text = fs::read_to_string(file).unwrap();
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let line = |line: &str| line.split("//").next().unwrap_or("").to_owned();
    code.lines().map(line).collect::<Vec<_>>().join(" ")
}

/// The paths of the packages in `use` statements, and whether they are re-exported.
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
            let parent = module.len() - usize::from(!is_folder);
            let mut from = match parts[0] {
                "crate" => vec![module[0].clone()],
                other if other.starts_with("isomend_") => vec![other[8..].to_owned()],
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
fn modules_import_from_lower_layers_only() {
    let source = Source::read();
    let mut count = 0;
    for (package, layers) in LAYERS {
        let layer = |name: &str| layers.iter().position(|layer| layer.contains(&name));
        for (module, imports) in source.imports.iter().filter(|(m, _)| m[0] == package) {
            let Some(name) = module.get(1) else { continue };
            let own = layer(name).unwrap_or_else(|| panic!("the module {name} is in no layer"));
            for (_, path) in imports.iter().filter(|(_, path)| path[0] == package) {
                let Some(other) = path.get(1).filter(|other| *other != name) else {
                    continue;
                };
                if let Some(other_layer) = layer(other) {
                    assert!(
                        other_layer < own,
                        "{} imports {}",
                        module.join("::"),
                        path.join("::")
                    );
                    count += 1;
                }
            }
        }
    }
    assert!(
        count > 100,
        "only {count} imports between modules were read"
    );
}

#[test]
fn no_files_import_each_other_in_a_cycle() {
    let source = Source::read();
    let imported: BTreeMap<&Module, BTreeSet<Module>> = source
        .files
        .keys()
        .map(|m| (m, source.imported_files(m)))
        .collect();
    assert!(imported.values().map(BTreeSet::len).sum::<usize>() > 300);
    // Files without incoming or without outgoing imports are removed repeatedly; the rest are the cycles.
    let mut left: BTreeSet<&Module> = imported.keys().copied().collect();
    loop {
        let imports_none = |m: &Module| !imported[m].iter().any(|target| left.contains(target));
        let is_not_imported = |m: &Module| !left.iter().any(|from| imported[*from].contains(m));
        let free: Vec<&Module> = left
            .iter()
            .copied()
            .filter(|m| imports_none(m) || is_not_imported(m))
            .collect();
        if free.is_empty() {
            break;
        }
        free.iter().for_each(|m| {
            left.remove(m);
        });
    }
    let names: Vec<String> = left.iter().map(|m| m.join("::")).collect();
    assert!(names.is_empty(), "in cycles: {}", names.join(", "));
}
