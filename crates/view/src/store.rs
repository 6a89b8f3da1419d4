//! The recovery file of a session: unsaved steps and choices, from which the session can be repeated.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use flate2::Crc;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::choices::Choices;
use super::runs::Runs;
use isomend_files::io::{bytes_of, read_plain, replace_unlinked};
use isomend_files::job::Work;

/// Upper bound of the size of a recovery file, in bytes. Its marked faces are ranges: a few MB for the most ragged mask of a large mesh.
const MOST: u64 = 1 << 30;
/// Upper bound of the number of files of earlier sessions that are kept beside the last one.
const MOST_OLD: usize = 99;

/// Why a session cannot be resumed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// No steps of the mesh are kept.
    #[error("no unsaved steps of {} are kept; open it without --resume", input.display())]
    Nothing {
        /// The mesh.
        input: PathBuf,
    },
    /// The recovery file cannot be read.
    #[error("there are no steps to resume: {} cannot be read ({cause})", path.display())]
    Missing {
        /// The recovery file.
        path: PathBuf,
        /// The cause.
        cause: std::io::Error,
    },
    /// The file is no recovery file, or damaged.
    #[error("{} is not the file of a session of this program: {what}", path.display())]
    Damaged {
        /// The recovery file.
        path: PathBuf,
        /// The error of the parser.
        what: String,
    },
    /// The recovery file belongs to another mesh.
    #[error(
        "{} belongs to another mesh: {} has changed since, or is another file; move the session file away to start a new session",
        path.display(),
        input.display()
    )]
    Other {
        /// The recovery file.
        path: PathBuf,
        /// The mesh.
        input: PathBuf,
    },
}

/// The content of a recovery file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SessionFile {
    /// The version of the program that wrote it.
    version: String,
    input: Fingerprint,
    steps: Vec<StoredStep>,
    /// The choices on the input and on the mesh after each step.
    #[serde(default)]
    choices: Vec<Choices>,
}

/// The steps to a mesh, and the choices on the meshes on the way.
pub struct Snapshot {
    /// Number of the mesh, and number of changes of choices so far; equal for equal snapshots.
    pub of: (u32, u64),
    /// The steps.
    pub steps: Vec<StoredStep>,
    /// The choices on the input and on the mesh after each step.
    pub choices: Vec<Choices>,
}

/// Size and checksum by which the input file is recognised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fingerprint {
    bytes: u64,
    crc: u32,
}

impl Fingerprint {
    /// The fingerprint of a file's content.
    pub fn of(bytes: &[u8]) -> Self {
        let mut crc = Crc::new();
        crc.update(bytes);
        Self {
            bytes: bytes.len() as u64,
            crc: crc.sum(),
        }
    }
}

/// A stored step.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredStep {
    /// The work, without the marked faces.
    pub work: Work,
    /// The marked faces.
    pub mask: Option<Runs>,
    /// Whether patches across seams of a texture get no texels of their own.
    #[serde(default)]
    pub no_texture: bool,
}

/// The recovery file of a session.
pub struct Store {
    path: PathBuf,
    input: PathBuf,
    fingerprint: Fingerprint,
    status: Mutex<Status>,
}

#[derive(Default)]
struct Status {
    /// Whether the file on disk belongs to this session.
    own: bool,
    /// [`Snapshot::of`] of the stored snapshot.
    stored: Option<(u32, u64)>,
    /// The error of the last write.
    error: Option<String>,
}

impl Store {
    /// The recovery file `path` of an input file.
    pub fn new(path: PathBuf, input: &Path, fingerprint: Fingerprint) -> Self {
        Self {
            path,
            input: input.to_path_buf(),
            fingerprint,
            status: Mutex::default(),
        }
    }

    /// The path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The error of the last write, if it failed.
    pub fn error(&self) -> Option<String> {
        self.status().error.clone()
    }

    /// Reads the steps and choices of a recovery file of this input; `file` is none for the default file.
    ///
    /// # Errors
    /// [`ResumeError`].
    pub fn read(
        &self,
        file: Option<&Path>,
    ) -> Result<(Vec<StoredStep>, Vec<Choices>), ResumeError> {
        let path = file.unwrap_or(&self.path).to_path_buf();
        // A file that the user names may be a link or a pipe.
        let bytes = match file {
            Some(file) => bytes_of(file).map_err(std::io::Error::other),
            None => read_plain(&path, MOST),
        };
        let bytes = match bytes {
            Ok(bytes) => bytes,
            Err(cause) if file.is_none() && cause.kind() == ErrorKind::NotFound => {
                let input = self.input.clone();
                return Err(ResumeError::Nothing { input });
            }
            Err(cause) => return Err(ResumeError::Missing { path, cause }),
        };
        let kept: SessionFile = match serde_json::from_slice(&bytes) {
            Ok(kept) => kept,
            Err(error) => {
                let what = error.to_string();
                return Err(ResumeError::Damaged { path, what });
            }
        };
        if kept.input != self.fingerprint {
            let input = self.input.clone();
            return Err(ResumeError::Other { path, input });
        }
        Ok((kept.steps, kept.choices))
    }

    /// Takes the file over from the earlier session, whose steps this session has repeated.
    pub fn own(&self) {
        self.status().own = true;
    }

    /// Writes the snapshot that `session` returns, or deletes the own file if it returns none because everything is saved. The file of
    /// another session is renamed first.
    pub fn update(&self, session: impl FnOnce() -> Option<Snapshot>) {
        // Lock before taking the snapshot, so that the last writer has the latest state.
        let mut status = self.status();
        let snapshot = session();
        let of = snapshot.as_ref().map(|snapshot| snapshot.of);
        if status.own && of.is_some() && of == status.stored {
            return;
        }
        let is_another = !status.own && fs::symlink_metadata(&self.path).is_ok();
        let written = match snapshot {
            // Choices alone do not replace the steps of another session.
            Some(snapshot) if is_another && snapshot.steps.is_empty() => Ok(false),
            Some(snapshot) => self.write(is_another, snapshot).map(|()| true),
            None if status.own => fs::remove_file(&self.path).map(|()| false),
            None => Ok(false),
        };
        status.own = *written.as_ref().unwrap_or(&false);
        status.error = written.err().map(|e| e.to_string());
        status.stored = of;
    }

    /// A name of its own for the file of an earlier session, of which none is lost.
    fn free_old_path(&self) -> PathBuf {
        let first = std::iter::once("json.old".to_owned());
        let names = first.chain((2..MOST_OLD).map(|number| format!("json.old{number}")));
        let mut paths = names.map(|name| self.path.with_extension(name));
        let is_free = |path: &PathBuf| fs::symlink_metadata(path).is_err();
        let last = self.path.with_extension(format!("json.old{MOST_OLD}"));
        paths.find(is_free).unwrap_or(last)
    }

    /// Whether the file has the steps of this session.
    pub fn is_own(&self) -> bool {
        self.status().own
    }

    fn write(&self, is_another: bool, snapshot: Snapshot) -> std::io::Result<()> {
        let kept = SessionFile {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            input: self.fingerprint,
            steps: snapshot.steps,
            choices: snapshot.choices,
        };
        if is_another {
            fs::rename(&self.path, self.free_old_path())?;
        }
        let text = serde_json::to_vec(&kept).map_err(std::io::Error::other)?;
        replace_unlinked(&self.path, &text)
    }

    fn status(&self) -> std::sync::MutexGuard<'_, Status> {
        self.status.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
