//! Staging of a job's files: each is written to a temporary file beside its target, and all are renamed together at the end.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use super::JobError;
use crate::io::{IoError, Staged, replace_file};
use isomend_core::cancel::Cancel;
use isomend_core::mend::FillError;

/// Temporary files not yet renamed to their targets. Dropping this removes them.
#[derive(Default)]
pub(super) struct Staging {
    files: Vec<(PathBuf, Staged)>,
    /// Files of earlier runs, and their new names.
    stale: Vec<[PathBuf; 2]>,
}

impl Staging {
    /// Writes a temporary file beside its target.
    ///
    /// # Errors
    /// [`IoError::Write`].
    pub(super) fn add(&mut self, path: &Path, bytes: &[u8]) -> Result<(), JobError> {
        let path = path.to_path_buf();
        let staged = Staged::new(&path, bytes);
        let staged = staged.map_err(|cause| {
            let path = path.clone();
            JobError::Io(IoError::Write { path, cause })
        })?;
        self.files.push((path, staged));
        Ok(())
    }

    /// Appends the files of another staging area.
    pub(super) fn append(&mut self, mut other: Self) {
        self.files.append(&mut other.files);
        self.stale.append(&mut other.stale);
    }

    /// Schedules the renaming of an existing file that this job does not replace, so that it is not taken for a result of this job. Returns
    /// a remark; `None` if there is no such file.
    pub(super) fn set_aside(&mut self, path: Option<&Path>) -> Option<String> {
        let path = path.filter(|path| path.is_file())?;
        let stem = path.file_stem().unwrap_or_default();
        let name = |count: usize| {
            let mut name: OsString = stem.to_owned();
            name.push("_earlier");
            if count > 1 {
                name.push(format!("_{count}"));
            }
            let mut renamed = path.with_file_name(name);
            if let Some(extension) = path.extension() {
                renamed.set_extension(extension);
            }
            renamed
        };
        let renamed = (1..10_000)
            .map(name)
            .find(|p| fs::symlink_metadata(p).is_err())?;
        let note = format!(
            "{}, which was there before and is no result of this run, is now {}",
            path.display(),
            renamed.display()
        );
        self.stale.push([path.to_path_buf(), renamed]);
        Some(note)
    }

    /// Renames all files to their targets, the first one last: if it is in place, all are.
    ///
    /// # Errors
    /// [`FillError::Cancelled`] once the token is set, with nothing changed; [`IoError::Write`] where a file cannot be moved.
    pub(super) fn finish(self, cancel: &Cancel) -> Result<(), JobError> {
        if cancel.is_cancelled() {
            return Err(FillError::Cancelled.into());
        }
        for [path, renamed] in self.stale {
            fs::rename(&path, renamed)
                .map_err(|cause| JobError::Io(IoError::Write { path, cause }))?;
        }
        for (path, staged) in self.files.into_iter().rev() {
            staged
                .commit()
                .map_err(|cause| JobError::Io(IoError::Write { path, cause }))?;
        }
        Ok(())
    }
}

/// Creates the folder of a file if `wanted`.
///
/// # Errors
/// [`JobError::Unwritable`].
pub(super) fn make_folder(path: &Path, wanted: bool) -> Result<(), JobError> {
    match path.parent().filter(|_| wanted) {
        Some(folder) => fs::create_dir_all(folder).map_err(|cause| JobError::Unwritable {
            path: folder.to_path_buf(),
            what: format!("the folder cannot be made: {cause}"),
        }),
        None => Ok(()),
    }
}

/// Writes a text file atomically: to a temporary file next to the target, then renamed.
///
/// # Errors
/// [`IoError::Write`].
#[doc(hidden)]
pub fn write_text(path: &Path, text: &str) -> Result<(), JobError> {
    write_bytes(path, text.as_bytes())
}

/// Writes a file atomically: to a temporary file next to the target, then renamed.
pub(super) fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), JobError> {
    let path = path.to_path_buf();
    replace_file(&path, bytes).map_err(|cause| JobError::Io(IoError::Write { path, cause }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_appear_together_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("b"), b"old").unwrap();
        let staged = || {
            let mut staging = Staging::default();
            staging.add(&at("a"), b"new").unwrap();
            staging.add(&at("b"), b"new").unwrap();
            assert!(!at("a").exists());
            staging
        };
        let cancel = Cancel::new();
        cancel.cancel();
        assert!(staged().finish(&cancel).is_err());
        assert_eq!(fs::read(at("b")).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        staged().finish(&Cancel::new()).unwrap();
        assert_eq!(fs::read(at("a")).unwrap(), b"new");
        assert_eq!(fs::read(at("b")).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn stale_files_get_another_name_and_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("piece_earlier.stl"), b"oldest").unwrap();
        for content in [&b"old"[..], b"newer"] {
            fs::write(at("piece.stl"), content).unwrap();
            let mut staging = Staging::default();
            let note = staging.set_aside(Some(&at("piece.stl"))).unwrap();
            assert!(note.contains("piece_earlier_"), "{note}");
            staging.finish(&Cancel::new()).unwrap();
            assert!(!at("piece.stl").exists());
        }
        assert_eq!(fs::read(at("piece_earlier.stl")).unwrap(), b"oldest");
        assert_eq!(fs::read(at("piece_earlier_2.stl")).unwrap(), b"old");
        assert_eq!(fs::read(at("piece_earlier_3.stl")).unwrap(), b"newer");
        assert!(
            Staging::default()
                .set_aside(Some(&at("none.stl")))
                .is_none()
        );
    }
}
