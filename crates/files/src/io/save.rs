//! Atomic saving: a file appears complete under its name, or not at all.

use std::fs;
use std::io::Read;
use std::io::{Error, Result, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tempfile::NamedTempFile;

/// Beginning and end of the names of temporary files.
const PREFIX: &str = ".isomend-";
const SUFFIX: &str = ".part";
/// Age from which on a temporary file was left behind by a process that was killed: no run writes a file for so long.
const STALE: Duration = Duration::from_secs(24 * 60 * 60);

/// The files of this process. Locked while a temporary file is created, renamed or removed.
static FILES: Mutex<Files> = Mutex::new(Files {
    unfinished: Vec::new(),
    written: Vec::new(),
});

/// The files of a process.
#[derive(Debug)]
struct Files {
    /// Temporary files not yet renamed to their targets.
    unfinished: Vec<PathBuf>,
    /// The targets that were written.
    written: Vec<PathBuf>,
}

impl Files {
    fn forget(&mut self, temporary: &Path) {
        self.unfinished.retain(|path| path != temporary);
    }
}

fn files() -> MutexGuard<'static, Files> {
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The files that this process has written, in order.
#[doc(hidden)]
pub fn written_files() -> Vec<PathBuf> {
    files().written.clone()
}

/// While this value exists, no file can be created or finished by the functions of this module.
#[doc(hidden)]
#[must_use = "saving goes on when it is dropped"]
#[derive(Debug)]
pub struct Abandoned(MutexGuard<'static, Files>);

impl Abandoned {
    /// The files that were written before.
    pub fn written(&self) -> &[PathBuf] {
        &self.0.written
    }
}

/// Removes all temporary files, for a process that is about to end. Finished files stay. A thread that is saving waits
/// until the result is dropped, then fails.
#[doc(hidden)]
pub fn abandon_unfinished() -> Abandoned {
    let mut files = files();
    for path in files.unfinished.drain(..) {
        // Errors are ignored: the file may be gone already, and nobody remains to report others to.
        let _ = fs::remove_file(path);
    }
    Abandoned(files)
}

/// Removes temporary files in a folder that killed processes left behind. Errors are ignored: the folder may not be readable, and another
/// process may remove the same file.
fn remove_stale(folder: &Path) {
    // Each folder once in a process, since it may hold many files.
    static SEEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    if seen.iter().any(|other| other == folder) {
        return;
    }
    seen.push(folder.to_path_buf());
    drop(seen);
    let is_old = |file: &fs::Metadata| {
        let age = file.modified().ok().and_then(|at| at.elapsed().ok());
        file.is_file() && age.is_some_and(|age| age > STALE)
    };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.as_encoded_bytes();
        let is_own = name.starts_with(PREFIX.as_bytes()) && name.ends_with(SUFFIX.as_bytes());
        if is_own && entry.metadata().is_ok_and(|file| is_old(&file)) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// A temporary file that is in the list of [`FILES`].
struct Temporary(Option<NamedTempFile>);

impl Temporary {
    fn beside(target: &Path) -> Result<Self> {
        let folder = match target.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
            _ => PathBuf::from("."),
        };
        let create = |name: &Path| {
            fs::OpenOptions::new()
                .write(true)
                .create_new(true)
                .open(name)
        };
        let mut files = files();
        remove_stale(&folder);
        let file = tempfile::Builder::new()
            .prefix(PREFIX)
            .suffix(SUFFIX)
            .make_in(folder, create)?;
        files.unfinished.push(file.path().to_path_buf());
        Ok(Self(Some(file)))
    }

    fn become_file(mut self, target: &Path) -> Result<()> {
        let mut files = files();
        match self.0.take() {
            Some(file) => {
                files.forget(file.path());
                file.persist(target).map_err(|failed| failed.error)?;
                files.written.push(target.to_path_buf());
                Ok(())
            }
            None => Ok(()),
        }
    }
}

/// Writes a file that must not exist yet. It appears complete under its name, or not at all.
///
/// # Errors
/// [`std::io::ErrorKind::AlreadyExists`] if the name is taken, even by a link; otherwise the system's error.
#[doc(hidden)]
pub fn write_new(target: &Path, bytes: &[u8]) -> Result<()> {
    let mut temporary = Temporary::beside(target)?;
    if let Some(file) = &mut temporary.0 {
        file.write_all(bytes)?;
    }
    let mut files = files();
    let Some(file) = temporary.0.take() else {
        return Ok(());
    };
    files.forget(file.path());
    file.persist_noclobber(target)
        .map_err(|failed| failed.error)?;
    Ok(())
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(file) = self.0.take() {
            let mut files = files();
            files.forget(file.path());
            drop(file);
        }
    }
}

/// Bytes written to a temporary file beside their target. Dropping this removes the file.
pub(crate) struct Staged {
    target: PathBuf,
    /// The temporary file; `None` if the target is a pipe or device, which gets its bytes at the end.
    temporary: Option<Temporary>,
    bytes: Vec<u8>,
}

impl Staged {
    /// Writes bytes to a temporary file beside a target. If the target is a symbolic link, the file that it names will be replaced or
    /// created, and the link stays. The permissions of a replaced file are kept, and its owner as far as the user may set it.
    ///
    /// # Errors
    /// If the target is a folder or read-only, or the file cannot be written.
    pub(crate) fn new(path: &Path, bytes: &[u8]) -> Result<Self> {
        let old = match fs::metadata(path) {
            Ok(old) if old.is_dir() => {
                return Err(Error::other("it is a folder: name a file in it"));
            }
            Ok(old) if !old.is_file() => {
                return Ok(Self {
                    target: path.to_path_buf(),
                    temporary: None,
                    bytes: bytes.to_vec(),
                });
            }
            // Files in memory have no permissions.
            #[cfg(not(target_family = "wasm"))]
            Ok(old) if old.permissions().readonly() => {
                return Err(Error::other("the file is there and may not be changed"));
            }
            Ok(old) => Some(old),
            Err(_) => None,
        };
        let target = end_of_links(path)?;
        let mut temporary = Temporary::beside(&target)?;
        if let Some(file) = &mut temporary.0 {
            // Before the content is written, so that only those who could read the old file can read it.
            if let Some(old) = &old {
                keep_owner(file.as_file(), old);
                #[cfg(not(target_family = "wasm"))]
                fs::set_permissions(file.path(), old.permissions())?;
            }
            file.write_all(bytes)?;
        }
        Ok(Self {
            target,
            temporary: Some(temporary),
            bytes: Vec::new(),
        })
    }

    /// Renames the temporary file to the target, or writes the bytes to a pipe or device.
    ///
    /// # Errors
    /// If the system refuses it; a file is then unchanged.
    pub(crate) fn commit(self) -> Result<()> {
        match self.temporary {
            Some(temporary) => temporary.become_file(&self.target),
            None => {
                let mut file = fs::OpenOptions::new().write(true).open(&self.target)?;
                file.write_all(&self.bytes)
            }
        }
    }
}

/// Replaces a file atomically: writes to a temporary file beside it, then renames that. A failure leaves the file unchanged. Links and
/// permissions are kept.
///
/// # Errors
/// If the target is a folder or read-only, or the file cannot be written.
#[doc(hidden)]
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<()> {
    Staged::new(path, bytes)?.commit()
}

/// Replaces a file atomically, as [`replace_file`] does, but replaces a link by the file instead of following it.
///
/// # Errors
/// If the file cannot be written.
#[doc(hidden)]
pub fn replace_unlinked(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut temporary = Temporary::beside(path)?;
    if let Some(file) = &mut temporary.0 {
        file.write_all(bytes)?;
    }
    temporary.become_file(path)
}

/// Reads at most `most` bytes of a file. Links, pipes and devices are refused.
///
/// # Errors
/// If it is no plain file, is longer, or cannot be read.
#[doc(hidden)]
pub fn read_plain(path: &Path, most: u64) -> Result<Vec<u8>> {
    let about = fs::symlink_metadata(path)?;
    if !about.is_file() {
        return Err(Error::other("it is a link, a pipe or a device, not a file"));
    }
    if about.len() > most {
        return Err(Error::other(format!("it is longer than {most} bytes")));
    }
    let mut bytes = Vec::new();
    fs::File::open(path)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Follows symbolic links to the file that they name, which need not exist.
fn end_of_links(path: &Path) -> Result<PathBuf> {
    // Upper bound of the number of links, as on Linux.
    const MOST: usize = 40;
    let mut target = path.to_path_buf();
    for _ in 0..MOST {
        match fs::symlink_metadata(&target) {
            Ok(about) if about.is_symlink() => {
                let next = fs::read_link(&target)?;
                target = target.parent().unwrap_or(Path::new("")).join(next);
            }
            _ => return Ok(target),
        }
    }
    Err(Error::other("it is a symbolic link that leads to itself"))
}

#[cfg(unix)]
fn keep_owner(file: &fs::File, old: &fs::Metadata) {
    use std::os::unix::fs::{MetadataExt, fchown};
    let Ok(new) = file.metadata() else { return };
    if (new.uid(), new.gid()) != (old.uid(), old.gid()) {
        // Only root may give files away. Others may give their files to a group of which they are members.
        if fchown(file, Some(old.uid()), Some(old.gid())).is_err() {
            let _ = fchown(file, None, Some(old.gid()));
        }
    }
}

#[cfg(not(unix))]
fn keep_owner(_: &fs::File, _: &fs::Metadata) {}

#[cfg(test)]
mod tests {
    use super::super::samples::open_tetrahedron;
    use super::super::{WriteOptions, read_path, write_path};
    use super::*;

    #[cfg(unix)]
    #[test]
    fn permissions_of_the_target_are_kept_and_links_followed() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (
            folder.path().join("mesh.ply"),
            folder.path().join("link.ply"),
        );
        fs::write(&path, b"old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write_path(&link, &open_tetrahedron(), None, &WriteOptions::default()).unwrap();
        assert_eq!(
            fs::metadata(&path).unwrap().permissions().mode() & 0o777,
            0o640
        );
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert!(read_path(&path, None).is_ok());
        let fresh = folder.path().join("fresh.ply");
        write_path(&fresh, &open_tetrahedron(), None, &WriteOptions::default()).unwrap();
        let plain = folder.path().join("plain");
        fs::write(&plain, b"").unwrap();
        assert_eq!(
            fs::metadata(&fresh).unwrap().permissions(),
            fs::metadata(&plain).unwrap().permissions()
        );
    }

    #[test]
    fn old_temporary_files_are_removed_and_others_stay() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let names = [
            (".isomend-old.part", true),
            (".isomend-new.part", false),
            ("isomend-old.part", true),
            (".isomend-old.ply", true),
        ];
        for (name, is_old) in names {
            let file = fs::File::create(at(name)).unwrap();
            let hours = if is_old { 25 } else { 1 };
            let then = std::time::SystemTime::now() - Duration::from_secs(hours * 60 * 60);
            file.set_modified(then).unwrap();
        }
        replace_file(&at("mesh.ply"), b"new").unwrap();
        let left = names.map(|(name, _)| at(name).exists());
        assert_eq!(left, [false, true, true, true]);
    }

    #[cfg(unix)]
    #[test]
    fn plain_files_are_neither_links_nor_endless() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("far"), b"old").unwrap();
        std::os::unix::fs::symlink(at("far"), at("link")).unwrap();
        std::os::unix::fs::symlink("/dev/zero", at("zero")).unwrap();
        for link in ["link", "zero"] {
            assert!(read_plain(&at(link), 100).is_err());
            replace_unlinked(&at(link), b"new").unwrap();
            assert_eq!(read_plain(&at(link), 3).unwrap(), b"new");
            assert!(read_plain(&at(link), 2).is_err());
        }
        assert_eq!(fs::read(at("far")).unwrap(), b"old");
    }

    #[cfg(unix)]
    #[test]
    fn links_that_lead_nowhere_yet_lead_to_the_new_file() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("models")).unwrap();
        symlink("models/second", at("first")).unwrap();
        symlink("third", at("models/second")).unwrap();
        for content in [&b"new"[..], b"newer"] {
            replace_file(&at("first"), content).unwrap();
            for link in ["first", "models/second"] {
                assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink());
            }
            assert!(fs::symlink_metadata(at("models/third")).unwrap().is_file());
            assert_eq!(fs::read(at("first")).unwrap(), content);
        }
        symlink("nowhere/else", at("lost")).unwrap();
        assert!(replace_file(&at("lost"), b"new").is_err());
        symlink("round", at("round")).unwrap();
        let message = replace_file(&at("round"), b"new").unwrap_err().to_string();
        assert!(message.contains("leads to itself"), "{message}");
        assert_eq!(fs::read_dir(at("models")).unwrap().count(), 2);
    }

    #[cfg(unix)]
    #[test]
    fn the_owner_stays_where_the_user_may_give_files_away() {
        use std::os::unix::fs::{MetadataExt, chown};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.ply");
        fs::write(&path, b"old").unwrap();
        // Only root can make a file with another owner; for other users the owner stays the same.
        let given = chown(&path, Some(1234), Some(5678)).is_ok();
        let before = fs::metadata(&path).unwrap();
        replace_file(&path, b"new").unwrap();
        let after = fs::metadata(&path).unwrap();
        assert_eq!((after.uid(), after.gid()), (before.uid(), before.gid()));
        assert_eq!(given, after.uid() == 1234);
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }
}
