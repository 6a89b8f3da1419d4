//! The files that were opened lately below a folder. The list is kept in the folder, beside the recovery files of sessions; it is
//! written once a second file is opened there.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::files::to_read;
use crate::io::{canonical, replace_file};

/// Upper bound of the number of files in the list.
const MOST: usize = 8;
/// The name of the list.
const LIST: &str = ".isomend-recent.json";
/// Locked while the list is changed.
static CHANGES: Mutex<()> = Mutex::new(());

/// The files that were opened lately and still exist, except one, relative to the folder; the last one first.
pub fn recent(root: &Path, except: &Path) -> Vec<String> {
    let except = name_of(root, except);
    let mut names = read(root);
    names.retain(|name| Some(name) != except.as_ref() && to_read(root, name).is_ok());
    names
}

/// Records that files were opened, the last one last. A list that cannot be written is given up, since nothing depends on it.
pub fn record(root: &Path, files: &[&Path]) {
    let _one_at_a_time = CHANGES.lock().unwrap_or_else(PoisonError::into_inner);
    let before = read(root);
    let mut names = before.clone();
    for file in files {
        if let Some(name) = name_of(root, file) {
            names.retain(|other| *other != name);
            names.insert(0, name);
        }
    }
    names.truncate(MOST);
    if names == before || names.len() < 2 {
        return;
    }
    if let Ok(text) = serde_json::to_vec(&names) {
        let _ = replace_file(&list(root), &text);
    }
}

/// The path of a file relative to the folder; none if it is not below it, or not valid Unicode.
fn name_of(root: &Path, file: &Path) -> Option<String> {
    let whole = canonical(file).ok()?;
    let name = whole.strip_prefix(root).ok()?;
    name.to_str().map(str::to_owned)
}

/// The names in the list; none if there is no list, or it is damaged.
fn read(root: &Path) -> Vec<String> {
    let text = fs::read(list(root)).unwrap_or_default();
    let mut names: Vec<String> = serde_json::from_slice(&text).unwrap_or_default();
    names.truncate(MOST);
    names
}

fn list(root: &Path) -> PathBuf {
    root.join(LIST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_files_come_first_and_missing_ones_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        let file = |i: usize| root.join(format!("{i}.ply"));
        for i in 0..12 {
            fs::write(file(i), "").unwrap();
        }
        record(&root, &[&file(0)]);
        assert!(!list(&root).exists(), "a single file is no list");
        record(&root, &[&file(0), &file(1)]);
        let all = || recent(&root, Path::new("none.ply"));
        assert_eq!(all(), ["1.ply", "0.ply"]);
        assert_eq!(recent(&root, &file(1)), ["0.ply"]);
        for i in [2, 3, 4, 5, 6, 7, 8, 9, 0] {
            record(&root, &[&file(i)]);
        }
        record(&root, &[Path::new("/elsewhere/10.ply"), &file(20)]);
        fs::remove_file(file(8)).unwrap();
        let expected = [
            "0.ply", "9.ply", "7.ply", "6.ply", "5.ply", "4.ply", "3.ply",
        ];
        assert_eq!(all(), expected);
        fs::write(list(&root), "[1]").unwrap();
        assert!(all().is_empty());
    }
}
