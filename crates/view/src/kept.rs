//! Where the page keeps its own files: recovery files of sessions and lists of recent files. They are in the user's folder for the state
//! of programs, so that a file or link in the folder of the meshes can neither replace nor redirect them.

use std::path::{Path, PathBuf};

#[cfg(not(target_family = "wasm"))]
use isomend_files::io::canonical;
#[cfg(not(target_family = "wasm"))]
use isomend_files::job::sha256;

/// Number of hexadecimal digits of a path's hash in a file name.
#[cfg(not(target_family = "wasm"))]
const DIGITS: usize = 16;

/// The places of the page's own files.
#[derive(Clone, Debug)]
pub struct Kept {
    /// The folder of the meshes.
    root: PathBuf,
    /// The user's folder for the state of this program; none if there is none.
    folder: Option<PathBuf>,
}

impl Kept {
    /// The user's folder, which is made if it does not exist; the folder of the meshes if that fails.
    #[cfg(not(target_family = "wasm"))]
    pub fn of_user(root: &Path) -> Self {
        let folder = user_folder(|name| std::env::var_os(name).map(PathBuf::from));
        Self {
            root: root.to_path_buf(),
            folder: folder.filter(|folder| made(folder).is_ok()),
        }
    }

    /// Hidden files in the folder of the meshes.
    #[cfg(any(test, target_family = "wasm"))]
    pub fn within(root: &Path) -> Self {
        Self {
            root: root.to_path_buf(),
            folder: None,
        }
    }

    /// The recovery file of the session of an input file.
    pub fn session(&self, input: &Path) -> PathBuf {
        let name = input.file_name().unwrap_or_default().to_string_lossy();
        match &self.folder {
            #[cfg(not(target_family = "wasm"))]
            Some(folder) => folder.join(format!("{name}-{}.session.json", key(input))),
            _ => self.root.join(format!(".{name}.isomend-session.json")),
        }
    }

    /// The list of the files that were opened lately below the folder of the meshes.
    pub fn recent(&self) -> PathBuf {
        match &self.folder {
            #[cfg(not(target_family = "wasm"))]
            Some(folder) => folder.join(format!("recent-{}.json", key(&self.root))),
            _ => self.root.join(".isomend-recent.json"),
        }
    }
}

/// The first digits of the hash of a file's whole path.
#[cfg(not(target_family = "wasm"))]
fn key(path: &Path) -> String {
    let whole = canonical(path).unwrap_or_else(|_| path.to_path_buf());
    let mut hash = sha256(whole.as_os_str().as_encoded_bytes());
    hash.truncate(DIGITS);
    hash
}

/// The user's folder for the state of this program: below `XDG_STATE_HOME`, or the folder that the system has instead.
#[cfg(not(target_family = "wasm"))]
fn user_folder(variable: impl Fn(&str) -> Option<PathBuf>) -> Option<PathBuf> {
    let absolute = |name: &str| variable(name).filter(|path| path.is_absolute());
    let home = |below: &str| absolute("HOME").map(|home| home.join(below));
    let found = absolute("XDG_STATE_HOME").or_else(|| match std::env::consts::OS {
        "windows" => absolute("LOCALAPPDATA"),
        "macos" => home("Library/Application Support"),
        _ => home(".local/state"),
    });
    found.map(|folder| folder.join("isomend"))
}

/// Makes a folder that only the user can read.
#[cfg(not(target_family = "wasm"))]
fn made(folder: &Path) -> std::io::Result<()> {
    let mut builder = std::fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn the_folder_follows_the_variables_of_the_system() {
        let folder = |variables: &[(&str, &str)]| {
            let of = |name: &str| variables.iter().find(|(n, _)| *n == name);
            user_folder(|name| of(name).map(|(_, value)| PathBuf::from(value)))
        };
        let both = [("XDG_STATE_HOME", "/state"), ("HOME", "/home/a")];
        assert_eq!(folder(&both), Some("/state/isomend".into()));
        let home = Some("/home/a/.local/state/isomend".into());
        assert_eq!(folder(&both[1..]), home);
        let relative = [("XDG_STATE_HOME", "state"), ("HOME", "/home/a")];
        assert_eq!(folder(&relative), home);
        assert_eq!(folder(&[("HOME", "")]), None);
    }

    #[test]
    fn files_of_one_name_in_two_folders_have_sessions_of_their_own() {
        let kept = Kept {
            root: "/meshes".into(),
            folder: Some("/state/isomend".into()),
        };
        let [a, b] =
            ["/meshes/a/ball.ply", "/meshes/b/ball.ply"].map(|p| kept.session(Path::new(p)));
        assert!(a != b && a.starts_with("/state/isomend"));
        let own = Kept::within(Path::new("/meshes"));
        assert_eq!(own.recent(), Path::new("/meshes/.isomend-recent.json"));
    }
}
