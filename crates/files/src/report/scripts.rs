//! JavaScript modules of the 3D viewer, shared by reports and the interactive view, and a bundler that joins a module with its imports.
//!
//! A browser opens a report as a single file from the disk, where it cannot load modules from other files. Therefore the modules are
//! joined into one script, each after the modules that it imports.

/// An ES module: the name of its file and its text. Names are unique across folders.
pub type Script = (&'static str, &'static str);

/// The modules of the viewer, in any order.
const VIEWER: [Script; 11] = [
    ("activity.js", include_str!("viewer/activity.js")),
    ("bends.js", include_str!("viewer/bends.js")),
    ("camera.js", include_str!("viewer/camera.js")),
    ("controls.js", include_str!("viewer/controls.js")),
    ("geometry.js", include_str!("viewer/geometry.js")),
    ("labels.js", include_str!("viewer/labels.js")),
    ("point.js", include_str!("viewer/point.js")),
    ("shaders.js", include_str!("viewer/shaders.js")),
    ("still.js", include_str!("viewer/still.js")),
    ("surface.js", include_str!("viewer/surface.js")),
    ("viewer.js", include_str!("viewer/viewer.js")),
];

/// Joins the module `main` and everything that it imports, from `own` and from the viewer, into one script. `import` and `export`
/// are removed, so all top-level names share one scope and must be unique.
///
/// An import of an unknown module is dropped; [`check`] finds it in tests.
pub fn bundle(main: &str, own: &[Script]) -> String {
    let mut bundle = Bundle {
        own,
        names: Vec::new(),
        text: String::new(),
    };
    bundle.add(main);
    bundle.text
}

struct Bundle<'a> {
    own: &'a [Script],
    /// The modules that have been added, or whose imports are being added.
    names: Vec<&'a str>,
    text: String,
}

impl<'a> Bundle<'a> {
    /// Adds the imports of a module, then the module.
    fn add(&mut self, name: &str) {
        let own: &'a [Script] = self.own;
        let found = own.iter().chain(&VIEWER).find(|(own, _)| *own == name);
        let Some(&(name, text)) = found.filter(|(name, _)| !self.names.contains(name)) else {
            return;
        };
        self.names.push(name);
        let (imports, body) = imports(text);
        for import in imports {
            self.add(import);
        }
        for line in body {
            self.text += line.strip_prefix("export ").unwrap_or(line);
            self.text.push('\n');
        }
    }
}

/// The file names that a module imports, without folders, and its lines without the import statements. A statement starts at the start of
/// a line and ends at the end of a line.
fn imports(text: &str) -> (Vec<&str>, Vec<&str>) {
    let (mut names, mut body) = (Vec::new(), Vec::new());
    let mut inside = false;
    for line in text.lines() {
        inside |= line.starts_with("import ");
        if !inside {
            body.push(line);
        } else if let Some(path) = line.strip_suffix("\";") {
            names.extend(path.rsplit(['/', '"']).next());
            inside = false;
        }
    }
    (names, body)
}

/// For tests of a bundle.
///
/// # Panics
/// If a module imports a name that is not exported, or if two modules of the bundle declare the same top-level name.
#[allow(clippy::unwrap_used)]
pub fn check(main: &str, own: &[Script]) {
    use std::collections::BTreeMap;

    let all: BTreeMap<&str, &str> = own.iter().chain(&VIEWER).copied().collect();
    assert_eq!(all.len(), own.len() + VIEWER.len(), "two files of a name");
    let exported = |name: &str| -> Vec<&str> {
        let lines = all[name].lines().filter_map(|l| l.strip_prefix("export "));
        lines.flat_map(declared).collect()
    };
    for (name, text) in &all {
        for statement in text.split("\nimport ").skip(1) {
            let (names, rest) = statement.split_once(" from \"").unwrap();
            let (path, _) = rest.split_once('"').unwrap();
            let from = path.rsplit('/').next().unwrap();
            for wanted in names
                .split(['{', '}', ',', ' ', '\n'])
                .filter(|n| !n.is_empty())
            {
                assert!(
                    exported(from).contains(&wanted),
                    "{name}: {from} exports no {wanted}"
                );
            }
        }
    }
    let text = bundle(main, own);
    let mut names: Vec<&str> = text.lines().flat_map(declared).collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(
        names.len(),
        count,
        "a name stands at the top of two modules"
    );
    let left = text
        .lines()
        .find(|l| l.starts_with("import ") || l.starts_with("export "));
    assert_eq!(left, None);
}

/// The names that a top-level line declares: a function, a class, or constants with simple values.
fn declared(line: &str) -> Vec<&str> {
    let line = line.strip_prefix("export ").unwrap_or(line);
    let name = |text: &'static str| line.strip_prefix(text);
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let first = |rest: &str| rest.find(|c: char| !is_word(c)).unwrap_or(rest.len());
    let own = ["async function ", "function ", "class "];
    if let Some(rest) = own.into_iter().find_map(name) {
        return vec![&rest[..first(rest)]];
    }
    let Some(rest) = ["const ", "let "].into_iter().find_map(name) else {
        return Vec::new();
    };
    let plain = rest.split(", ").take_while(|part| part.contains(" = "));
    let names = plain.map(|part| &part[..first(part)]);
    names.filter(|name| !name.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::{bundle, imports};

    #[test]
    fn imports_are_followed_and_left_out() {
        let text = "// What.\nimport { a } from \"./a.js\";\nimport {\n  b,\n} from \"../x/b.js\";\n\nexport const c = a + b;";
        let (names, body) = imports(text);
        assert_eq!(names, ["a.js", "b.js"]);
        assert_eq!(body, ["// What.", "", "export const c = a + b;"]);
        let own = [
            (
                "main.js",
                "import { b } from \"./b.js\";\nimport { a } from \"./a.js\";\nb(a);",
            ),
            ("a.js", "export const a = 1;"),
            (
                "b.js",
                "import { a } from \"./a.js\";\nexport function b() { return a; }",
            ),
        ];
        let one = "const a = 1;\nfunction b() { return a; }\nb(a);\n";
        assert_eq!(bundle("main.js", &own), one);
    }
}
