//! Access control for files that the page names: only paths below one folder, without links out of it.

use std::fs;
use std::path::{Component, MAIN_SEPARATOR, Path, PathBuf};

use isomend_files::io::canonical;

/// Upper bound of the length of a path, in bytes.
const LONGEST: usize = 4096;

/// Why a file may not be read or written.
#[derive(Debug, PartialEq, Eq)]
pub enum Denied {
    /// The path is outside the folder, or is no regular file.
    Outside(String),
    /// The path is invalid.
    Wrong(String),
    /// The file of this name exists, and was not to be replaced.
    Exists(String),
    /// The place is taken.
    Taken(String),
    /// The file does not exist.
    Missing(String),
}

impl Denied {
    /// The reason in words.
    pub fn words(self) -> String {
        match self {
            Self::Exists(name) => format!("{name} exists already"),
            Self::Outside(what) | Self::Wrong(what) | Self::Taken(what) | Self::Missing(what) => {
                what
            }
        }
    }
}

/// The path of a file to write below a folder. The file's own folder must exist. Links out of the folder and links in place of the file
/// are refused.
///
/// # Errors
/// [`Denied`].
pub fn to_write(root: &Path, name: &str, overwrite: bool) -> Result<PathBuf, Denied> {
    let path = inside(root, name)?;
    match fs::symlink_metadata(&path) {
        Ok(about) if about.is_dir() => {
            let what = format!("{name} is a folder; name a file in it");
            Err(Denied::Wrong(what))
        }
        Ok(about) if !about.is_file() => {
            let what = format!("{name} is a link or a device, not a file");
            Err(Denied::Outside(what))
        }
        Ok(_) if !overwrite => Err(Denied::Exists(name.to_owned())),
        _ => Ok(path),
    }
}

/// The path of a folder to make below a folder. The folder that it is made in must exist; a file or folder of this name must not.
///
/// # Errors
/// [`Denied`].
pub fn to_make(root: &Path, name: &str) -> Result<PathBuf, Denied> {
    let path = inside(root, name.trim_end_matches(['/', MAIN_SEPARATOR]))?;
    match fs::symlink_metadata(&path) {
        Ok(_) => Err(Denied::Taken(format!(
            "{name} exists already; choose another name"
        ))),
        Err(_) => Ok(path),
    }
}

/// The path of a file to read below a folder.
///
/// # Errors
/// [`Denied`].
pub fn to_read(root: &Path, name: &str) -> Result<PathBuf, Denied> {
    let path = inside(root, name)?;
    match fs::symlink_metadata(&path) {
        Ok(about) if about.is_file() => Ok(path),
        Ok(_) => Err(Denied::Outside(format!("{name} is not a file"))),
        Err(_) => Err(Denied::Missing(format!("there is no file {name}"))),
    }
}

/// Resolves a path below a folder. The path's own folder must exist and, with links resolved, be below the folder.
fn inside(root: &Path, name: &str) -> Result<PathBuf, Denied> {
    let wrong = |what: &str| Err(Denied::Wrong(what.to_owned()));
    if name.trim().is_empty() || name.len() > LONGEST {
        return wrong("the name is empty or too long");
    }
    if name.contains(char::is_control) {
        return wrong("the name contains control characters, such as a line break");
    }
    if name.ends_with(['/', MAIN_SEPARATOR]) {
        return wrong("this is the name of a folder; name a file in it");
    }
    let outside = || {
        Denied::Outside(format!(
            "{name} is not below the folder {}: name a file below it, or start with another folder",
            root.display()
        ))
    };
    // An absolute path is allowed if it leads into the folder.
    let path = Path::new(name);
    let path = path.strip_prefix(root).unwrap_or(path);
    let is_plain = |c: Component| matches!(c, Component::Normal(_) | Component::CurDir);
    if !path.components().all(is_plain) {
        return Err(outside());
    }
    let whole = root.join(path);
    let (Some(folder), Some(file)) = (whole.parent(), whole.file_name()) else {
        return wrong("the path ends in no name");
    };
    let folder = canonical(folder).map_err(|_| {
        let folder = folder.display();
        Denied::Wrong(format!("there is no folder {folder}; make it first"))
    })?;
    match folder.starts_with(root) {
        true => Ok(folder.join(file)),
        false => Err(outside()),
    }
}

/// A path as an argument of a command. A leading dash gets the prefix `./`, so that the path is not taken for an option.
pub fn path_argument(path: &Path) -> String {
    let text = path.to_string_lossy().into_owned();
    match text.starts_with('-') {
        true => format!("./{text}"),
        false => text,
    }
}

/// The path of a template as the value of `--like`. A name that begins like the word for the mirrored mesh gets the prefix `./` too.
pub fn template_argument(path: &Path) -> String {
    let text = path_argument(path);
    match text.starts_with("mirror") {
        true => format!("./{text}"),
        false => text,
    }
}

/// A path relative to a folder; the absolute path if they are on different disks, the path itself if it cannot be resolved.
pub fn relative(folder: &Path, path: &Path) -> PathBuf {
    let whole = |p: &Path| {
        let parent = p.parent().filter(|p| !p.as_os_str().is_empty());
        let parent = canonical(parent.unwrap_or(Path::new("."))).ok()?;
        Some(parent.join(p.file_name()?))
    };
    let (Ok(folder), Some(path)) = (canonical(folder), whole(path)) else {
        return path.to_path_buf();
    };
    let (from, to): (Vec<_>, Vec<_>) = (folder.components().collect(), path.components().collect());
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    if !matches!(
        to.get(common.saturating_sub(1)),
        Some(Component::RootDir | Component::Normal(_))
    ) {
        // On another disk.
        return path;
    }
    let up = from[common..].iter().map(|_| Component::ParentDir);
    up.chain(to[common..].iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_below_the_folder_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let top = folder.path().canonicalize().unwrap();
        let root = top.join("root");
        fs::create_dir_all(root.join("sub")).unwrap();
        fs::write(root.join("old.ply"), "old").unwrap();
        fs::write(top.join("secret.ply"), "secret").unwrap();
        assert_eq!(to_write(&root, "new.ply", false), Ok(root.join("new.ply")));
        assert_eq!(
            to_write(&root, "./sub/new.ply", false),
            Ok(root.join("sub/new.ply"))
        );
        let whole = root.join("sub").join("new.ply");
        assert_eq!(to_write(&root, whole.to_str().unwrap(), false), Ok(whole));
        assert!(matches!(
            to_write(&root, "old.ply", false),
            Err(Denied::Exists(_))
        ));
        assert!(to_write(&root, "old.ply", true).is_ok());
        let elsewhere = top.join("secret.ply");
        for name in [
            "../secret.ply",
            "sub/../../secret.ply",
            "sub/../old.ply",
            elsewhere.to_str().unwrap(),
            "/etc/passwd",
        ] {
            let denied = to_write(&root, name, true);
            assert!(
                matches!(denied, Err(Denied::Outside(_))),
                "{name}: {denied:?}"
            );
            assert!(
                matches!(to_read(&root, name), Err(Denied::Outside(_))),
                "{name}"
            );
        }
        for name in [
            "",
            " ",
            "sub",
            "sub/",
            "none/new.ply",
            "a\0b",
            "a\nb.ply",
            "\u{1b}[2J.ply",
            "a\u{85}.ply",
        ] {
            let denied = to_write(&root, name, true);
            assert!(
                matches!(denied, Err(Denied::Wrong(_))),
                "{name}: {denied:?}"
            );
        }
        assert!(matches!(to_read(&root, "no.ply"), Err(Denied::Missing(_))));
        assert_eq!(to_read(&root, "old.ply"), Ok(root.join("old.ply")));
    }

    #[test]
    fn only_new_folders_below_the_folder_are_made() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap().join("root");
        fs::create_dir_all(root.join("sub")).unwrap();
        fs::write(root.join("old.ply"), "old").unwrap();
        assert_eq!(to_make(&root, "new"), Ok(root.join("new")));
        assert_eq!(to_make(&root, "sub/new/"), Ok(root.join("sub/new")));
        for name in ["sub", "sub/", "old.ply"] {
            let denied = to_make(&root, name);
            assert!(
                matches!(denied, Err(Denied::Taken(_))),
                "{name}: {denied:?}"
            );
        }
        for name in ["", "/", "none/new", "a\nb"] {
            let denied = to_make(&root, name);
            assert!(
                matches!(denied, Err(Denied::Wrong(_))),
                "{name}: {denied:?}"
            );
        }
        for name in ["../new", "sub/../../new", "/new", "."] {
            let denied = to_make(&root, name);
            assert!(
                matches!(denied, Err(Denied::Outside(_))),
                "{name}: {denied:?}"
            );
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_lead_nowhere() {
        let folder = tempfile::tempdir().unwrap();
        let top = folder.path().canonicalize().unwrap();
        let root = top.join("root");
        fs::create_dir_all(&root).unwrap();
        fs::write(top.join("secret.ply"), "secret").unwrap();
        std::os::unix::fs::symlink(&top, root.join("up")).unwrap();
        std::os::unix::fs::symlink("../secret.ply", root.join("link.ply")).unwrap();
        for name in ["up/secret.ply", "up/new.ply", "link.ply"] {
            let denied = to_write(&root, name, true);
            assert!(
                matches!(denied, Err(Denied::Outside(_))),
                "{name}: {denied:?}"
            );
            assert!(
                matches!(to_read(&root, name), Err(Denied::Outside(_))),
                "{name}"
            );
        }
    }

    #[test]
    fn paths_are_made_relative_to_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let top = folder.path().canonicalize().unwrap();
        fs::create_dir_all(top.join("a/b")).unwrap();
        let seen = |from: &str, to: &str| relative(&top.join(from), &top.join(to));
        assert_eq!(seen("a", "a/x.ply"), Path::new("x.ply"));
        assert_eq!(seen("a/b", "a/x.ply"), Path::new("../x.ply"));
        assert_eq!(seen("a", "a/b/x.ply"), Path::new("b/x.ply"));
    }
}
