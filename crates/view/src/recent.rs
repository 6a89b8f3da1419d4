//! The files that were opened lately below a folder. A list begins when a file is opened on a page.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use super::files::to_read;
use isomend_files::io::{canonical, read_plain, replace_unlinked};

/// Upper bound of the number of files in the list.
const MOST: usize = 8;
/// Upper bound of the size of a list, in bytes.
const LONGEST: u64 = 1 << 20;
/// Locked while the list is changed.
static CHANGES: Mutex<()> = Mutex::new(());

/// The files in a list that still exist below a folder, except one, relative to the folder; the last one first.
pub fn recent(list: &Path, root: &Path, except: &Path) -> Vec<String> {
    let except = name_of(root, except);
    let mut names = read(list);
    names.retain(|name| Some(name) != except.as_ref() && to_read(root, name).is_ok());
    names
}

/// Records in a list that files below a folder were opened, the last one last. A list that cannot be written is given up, since nothing depends on it.
pub fn record(list: &Path, root: &Path, files: &[&Path]) {
    let _one_at_a_time = CHANGES.lock().unwrap_or_else(PoisonError::into_inner);
    let before = read(list);
    let mut names = before.clone();
    for file in files {
        if let Some(name) = name_of(root, file) {
            names.retain(|other| *other != name);
            names.insert(0, name);
        }
    }
    names.truncate(MOST);
    if names == before {
        return;
    }
    if let Ok(text) = serde_json::to_vec(&names) {
        let _ = replace_unlinked(list, &text);
    }
}

/// The path of a file relative to the folder; none if it is not below it, or not valid Unicode.
fn name_of(root: &Path, file: &Path) -> Option<String> {
    let whole = canonical(file).ok()?;
    let name = whole.strip_prefix(root).ok()?;
    name.to_str().map(str::to_owned)
}

/// The names in the list; none if there is no list, or it is damaged.
fn read(list: &Path) -> Vec<String> {
    let text = read_plain(list, LONGEST).unwrap_or_default();
    let mut names: Vec<String> = serde_json::from_slice(&text).unwrap_or_default();
    names.truncate(MOST);
    names
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn the_last_files_come_first_and_missing_ones_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        let file = |i: usize| root.join(format!("{i}.ply"));
        for i in 0..12 {
            fs::write(file(i), "").unwrap();
        }
        let list = &root.join("list.json");
        record(list, &root, &[&file(0)]);
        assert_eq!(recent(list, &root, Path::new("none.ply")), ["0.ply"]);
        record(list, &root, &[&file(0), &file(1)]);
        let all = || recent(list, &root, Path::new("none.ply"));
        assert_eq!(all(), ["1.ply", "0.ply"]);
        assert_eq!(recent(list, &root, &file(1)), ["0.ply"]);
        for i in [2, 3, 4, 5, 6, 7, 8, 9, 0] {
            record(list, &root, &[&file(i)]);
        }
        record(list, &root, &[Path::new("/elsewhere/10.ply"), &file(20)]);
        fs::remove_file(file(8)).unwrap();
        let expected = [
            "0.ply", "9.ply", "7.ply", "6.ply", "5.ply", "4.ply", "3.ply",
        ];
        assert_eq!(all(), expected);
        fs::write(list, "[1]").unwrap();
        assert!(all().is_empty());
    }
}
