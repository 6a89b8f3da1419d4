//! Steps that were not saved, kept in a file: what has to be done again to have them.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use flate2::Crc;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::choices::Choices;
use super::runs::Runs;
use crate::io::replace_file;
use crate::job::Work;

/// Why a session cannot be gone on with.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// There is none.
    #[error("there are no steps to go on with: {} cannot be read ({cause})", path.display())]
    Missing {
        /// The file of the session.
        path: PathBuf,
        /// Why.
        cause: std::io::Error,
    },
    /// It is something else.
    #[error("{} is not the file of a session of this program: {what}", path.display())]
    Damaged {
        /// The file of the session.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// It is of another mesh.
    #[error(
        "{} is of another mesh: {} was changed since, or is another file; move the session away to begin anew",
        path.display(),
        input.display()
    )]
    Other {
        /// The file of the session.
        path: PathBuf,
        /// The mesh.
        input: PathBuf,
    },
}

/// What is kept of a session.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SessionFile {
    /// The version of the program that wrote it.
    version: String,
    input: Mark,
    steps: Vec<KeptStep>,
    /// What is chosen on the file as it was read, and on the mesh of each step.
    #[serde(default)]
    choices: Vec<Choices>,
}

/// Steps to a mesh, and what is chosen on the meshes on the way.
pub struct Keep {
    /// The mesh, and how often something was chosen.
    pub of: (u32, u64),
    /// The steps.
    pub steps: Vec<KeptStep>,
    /// What is chosen on the file as it was read, and on the mesh of each step.
    pub choices: Vec<Choices>,
}

/// By what a file is known again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mark {
    bytes: u64,
    crc: u32,
}

impl Mark {
    /// Of the content of a file.
    pub fn of(bytes: &[u8]) -> Self {
        let mut crc = Crc::new();
        crc.update(bytes);
        Self {
            bytes: bytes.len() as u64,
            crc: crc.sum(),
        }
    }
}

/// A step that is kept.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptStep {
    /// What is to be done.
    pub work: Work,
    /// The faces that are marked.
    pub mask: Option<Runs>,
}

/// The file of a session.
pub struct Store {
    path: PathBuf,
    input: PathBuf,
    mark: Mark,
    now: Mutex<Now>,
}

#[derive(Default)]
struct Now {
    /// Whether the file on disk is this session's.
    own: bool,
    /// The mesh whose steps it has, and how often something was chosen before.
    kept: Option<(u32, u64)>,
    /// Why it could not be written last.
    error: Option<String>,
}

impl Store {
    /// The file for a mesh in a folder.
    pub fn new(root: &Path, input: &Path, mark: Mark) -> Self {
        let name = input.file_name().unwrap_or_default().to_string_lossy();
        Self {
            path: root.join(format!(".{name}.isomend-session.json")),
            input: input.to_path_buf(),
            mark,
            now: Mutex::default(),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Why it could not be written last.
    pub fn error(&self) -> Option<String> {
        self.now().error.clone()
    }

    /// The steps that a file keeps, of this mesh, and what was chosen on each of its meshes.
    ///
    /// # Errors
    /// [`ResumeError`].
    pub fn read(&self, file: Option<&Path>) -> Result<(Vec<KeptStep>, Vec<Choices>), ResumeError> {
        let path = file.unwrap_or(&self.path).to_path_buf();
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(cause) => return Err(ResumeError::Missing { path, cause }),
        };
        let kept: SessionFile = match serde_json::from_slice(&bytes) {
            Ok(kept) => kept,
            Err(error) => {
                let what = error.to_string();
                return Err(ResumeError::Damaged { path, what });
            }
        };
        if kept.input != self.mark {
            let input = self.input.clone();
            return Err(ResumeError::Other { path, input });
        }
        Ok((kept.steps, kept.choices))
    }

    /// From now on the file is this session's, which has all that was in it.
    pub fn own(&self) {
        self.now().own = true;
    }

    /// Keeps what `session` tells; none where all is saved. The file of another session is moved aside.
    pub fn keep(&self, session: impl FnOnce() -> Option<Keep>) {
        // Before the session is asked for, so that the last to write has the last state of it.
        let mut now = self.now();
        let keep = session();
        let of = keep.as_ref().map(|keep| keep.of);
        if now.own && of.is_some() && of == now.kept {
            return;
        }
        let is_another = !now.own && self.path.exists();
        let written = match keep {
            // Choices alone do not move the steps of another session aside.
            Some(keep) if is_another && keep.steps.is_empty() => Ok(false),
            Some(keep) => self.write(is_another, keep).map(|()| true),
            None if now.own => fs::remove_file(&self.path).map(|()| false),
            None => Ok(false),
        };
        now.own = *written.as_ref().unwrap_or(&false);
        now.error = written.err().map(|e| e.to_string());
        now.kept = of;
    }

    fn write(&self, is_another: bool, keep: Keep) -> std::io::Result<()> {
        let kept = SessionFile {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            input: self.mark,
            steps: keep.steps,
            choices: keep.choices,
        };
        if is_another {
            fs::rename(&self.path, self.path.with_extension("json.old"))?;
        }
        let text = serde_json::to_vec(&kept).map_err(std::io::Error::other)?;
        replace_file(&self.path, &text)
    }

    fn now(&self) -> std::sync::MutexGuard<'_, Now> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
