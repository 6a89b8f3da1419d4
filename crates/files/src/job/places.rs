//! Places of meshes (files or memory), and checks of input and output paths before the work starts.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::JobError;
use crate::io::{Format, canonical};

/// A file, or the caller's memory.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Place {
    /// A file.
    File(PathBuf),
    /// The caller's memory: the bytes of a file, or a mesh.
    Memory {
        /// Its name in messages.
        name: String,
        /// The folder of files that the mesh refers to, such as materials and images; with `None` they are not looked up.
        folder: Option<PathBuf>,
    },
}

impl Place {
    /// The caller's memory, with a name for messages.
    pub fn memory(name: impl Into<String>) -> Self {
        let name = name.into();
        Self::Memory { name, folder: None }
    }

    /// Its name in messages.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Memory { name, .. } => name.clone(),
        }
    }

    /// The folder of files that the mesh refers to, if there is one.
    pub fn folder(&self) -> Option<&Path> {
        match self {
            Self::File(path) => path.parent(),
            Self::Memory { folder, .. } => folder.as_deref(),
        }
    }

    /// The file, if it is one.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Memory { .. } => None,
        }
    }

    /// Whether both places are the same file, also through links.
    pub fn is_same_file(&self, other: &Place) -> bool {
        match (self, other) {
            (Self::File(a), Self::File(b)) => same_file(a, b),
            _ => false,
        }
    }

    /// Refuses a file whose folder does not exist, and a path that is a folder.
    ///
    /// # Errors
    /// [`JobError::Unwritable`].
    pub fn check_writable(&self) -> Result<(), JobError> {
        let Self::File(path) = self else {
            return Ok(());
        };
        let bad = |what: String| {
            let path = path.clone();
            Err(JobError::Unwritable { path, what })
        };
        if path.is_dir() {
            return bad("it is a folder; name a file in it".to_owned());
        }
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            let name = folder.display();
            return bad(match folder.exists() {
                true => format!("{name} is a file, not a folder"),
                false => format!("there is no folder {name}; create it first"),
            });
        }
        Ok(())
    }
}

impl Place {
    /// Refuses a place for a JSON document that cannot be written or is one of `meshes`.
    pub fn check_document<'a>(
        &self,
        mut meshes: impl Iterator<Item = &'a Place>,
    ) -> Result<(), JobError> {
        self.check_writable()?;
        match self {
            Self::File(path) if meshes.any(|mesh| self.is_same_file(mesh)) => {
                let path = path.clone();
                Err(JobError::DocumentOverMesh { path })
            }
            _ => Ok(()),
        }
    }
}

impl<P: Into<PathBuf>> From<P> for Place {
    fn from(path: P) -> Self {
        Self::File(path.into())
    }
}

/// Refuses a place that is a file which the job reads besides its mesh, unless it is the mesh itself. `read` has what each file is.
///
/// # Errors
/// [`JobError::Places`].
pub(super) fn refuse_over(
    place: &Place,
    mesh: &Place,
    read: &[(&'static str, PathBuf)],
) -> Result<(), JobError> {
    let is_over = |(_, path): &&(&str, PathBuf)| place.is_same_file(&Place::from(path.clone()));
    match read.iter().find(is_over) {
        Some((what, _)) if !place.is_same_file(mesh) => Err(JobError::Places {
            what: format!(
                "{} is the file of {what}, which is read: name another file to write",
                place.name()
            ),
        }),
        _ => Ok(()),
    }
}

/// Whether two paths name the same file. Links are followed; a file that does not exist yet is compared by its folder and name.
fn same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        canonical(path).ok().or_else(|| {
            let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
            let folder = canonical(folder.unwrap_or(Path::new("."))).ok()?;
            Some(folder.join(path.file_name()?))
        })
    };
    place(a).is_some_and(|a| place(b) == Some(a))
}

/// Whether a path is a folder, or ends with a slash and so names a folder to create.
pub fn is_folder_name(path: &Path) -> bool {
    let name = path.as_os_str().to_string_lossy();
    path.is_dir() || name.ends_with(['/', std::path::MAIN_SEPARATOR])
}

/// The output files of several inputs in a folder: each has the name of its input, with the extension of `format` if one is given.
///
/// # Errors
/// [`JobError::Places`] if an input has no file name, if two inputs have the same output, if an output is another input, or if the
/// folder is a file; [`JobError::Unwritable`] if the folder cannot be created.
pub fn in_folder(
    folder: &Path,
    inputs: &[Place],
    format: Option<Format>,
) -> Result<Vec<PathBuf>, JobError> {
    let bad = |what: String| Err(JobError::Places { what });
    if !folder.is_dir() {
        let name: PathBuf = folder.components().collect();
        Place::from(name.clone()).check_writable()?;
        if name.exists() {
            return bad(format!("{} is a file, not a folder", name.display()));
        }
    }
    let mut taken: BTreeMap<PathBuf, String> = BTreeMap::new();
    let mut outputs = Vec::new();
    for input in inputs {
        let Some(name) = input.path().and_then(Path::file_name) else {
            return bad(format!(
                "{} has no name for its result in the folder {}; name an output file",
                input.name(),
                folder.display()
            ));
        };
        let mut path = folder.join(name);
        if let Some(format) = format {
            path.set_extension(format.extension());
        }
        if let Some(other) = taken.insert(path.clone(), input.name()) {
            return bad(format!(
                "{other} and {} would both be written to {}; run them one by one, or rename one",
                input.name(),
                path.display()
            ));
        }
        outputs.push(path);
    }
    refuse_other_inputs(inputs, &outputs)?;
    Ok(outputs)
}

/// Refuses outputs that are another input, for example through a link.
fn refuse_other_inputs(inputs: &[Place], outputs: &[PathBuf]) -> Result<(), JobError> {
    let place = |path: &Path| canonical(path).ok();
    let named = inputs.iter().enumerate();
    let places: BTreeMap<PathBuf, usize> = named
        .filter_map(|(i, input)| Some((place(input.path()?)?, i)))
        .collect();
    for (i, output) in outputs.iter().enumerate() {
        let found = place(output).and_then(|p| places.get(&p));
        if let Some(&other) = found.filter(|other| **other != i) {
            let what = format!(
                "the result of {} would overwrite {}, which is another input; name another folder",
                inputs[i].name(),
                inputs[other].name()
            );
            return Err(JobError::Places { what });
        }
    }
    Ok(())
}
