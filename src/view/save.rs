//! Writes meshes, reports and recipes of the session.

use std::path::{Path, PathBuf};

use super::app::App;
use super::recipe::{Places, Recipe};
use super::state::{State, between};
use crate::io::Format;
use crate::job::{Drawings, JobError, JobSpec, Output, Source, Work, inspect};
use crate::mend::Control;

/// The result of saving.
pub struct Saved {
    /// The file.
    pub path: PathBuf,
    /// Remarks.
    pub notes: Vec<String>,
}

impl App {
    /// A mesh as the input of the next command.
    pub fn source_of(&self, state: &State) -> Source {
        let mut source = Source::mesh(state.place(&self.input), state.loaded.clone());
        source.format = self.from.filter(|_| state.depth == 0);
        source
    }

    /// The intermediate file after `depth` steps. Only a recipe writes it; the session keeps intermediate files in memory.
    pub fn between(&self, depth: usize) -> PathBuf {
        between(&self.input, depth, self.format_between.extension())
    }

    /// Writes a mesh, as the last command of its recipe does.
    ///
    /// # Errors
    /// When the format does not allow it, or the file cannot be written.
    pub fn save_mesh(&self, state: &State, path: &Path, ascii: bool) -> Result<Saved, JobError> {
        let mut output = Output::new(path, None)?;
        output.ascii = ascii;
        output.check()?;
        let step = state
            .step
            .as_ref()
            .filter(|_| self.is_last(state, output.format));
        let done = match step {
            Some(step) => step
                .mended
                .clone()
                .drawn(Drawings::default())
                .to(output)
                .write()?,
            None => {
                let mut spec = JobSpec::plan(self.source_of(state), Work::Copy);
                spec.output = Some(output);
                spec.read()?.mend(&Control::new())?.into_owned().write()?
            }
        };
        Ok(Saved {
            path: path.to_path_buf(),
            notes: done.notes_written().to_vec(),
        })
    }

    /// Whether the command of a mesh's last step gives the same mesh in the given format. Steps with glTF as the intermediate format keep
    /// the numbers of vertices, which a command that writes another format does not, except a fill.
    fn is_last(&self, state: &State, format: Format) -> bool {
        let is_gltf = |f: Format| matches!(f, Format::Gltf | Format::Glb);
        let fills = |work: &Work| matches!(work, Work::Fill(_));
        let same = !is_gltf(self.format_between) || is_gltf(format);
        state
            .step
            .as_ref()
            .is_some_and(|step| same || fills(&step.work))
    }

    /// Writes the report page of a step, or of the input.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn save_report(&self, state: &State, path: &Path) -> Result<Saved, JobError> {
        let drawn = |command_line: String| Drawings {
            page: Some(path.to_path_buf()),
            command_line,
            ..Drawings::default()
        };
        match &state.step {
            Some(step) => {
                let drawings = drawn(format!("isomend {}", step.command.words().join(" ")));
                let output = Output::new(state.place(&self.input), Some(self.format_between))?;
                step.mended.clone().drawn(drawings).to(output).write()?;
            }
            None => {
                let drawings = drawn(format!("isomend inspect {}", self.input.display()));
                inspect(&self.source_of(state), &state.loaded, None, None, &drawings)?;
            }
        }
        Ok(Saved {
            path: path.to_path_buf(),
            notes: Vec::new(),
        })
    }

    /// The recipe that makes a mesh and saves it to a file.
    ///
    /// # Errors
    /// When the file's extension names no format, or a step cannot be written as a command.
    pub fn recipe(
        &self,
        state: &State,
        (folder, stem): (&Path, &str),
        (output, ascii): (&Path, bool),
    ) -> Result<Recipe, String> {
        if [&self.input, output]
            .iter()
            .any(|path| path.to_str().is_none())
        {
            return Err(
                "the name of a file is not valid Unicode, so a script cannot contain it".to_owned(),
            );
        }
        let format = Format::from_extension(output);
        let format = format.ok_or("the extension of the saved file names no known format")?;
        let last = match self.is_last(state, format) {
            true => None,
            false => Some(self.renderer.command(&Work::Copy, None)?),
        };
        let places = Places {
            folder,
            stem,
            input: (&self.input, self.from),
            between: &|depth| self.between(depth),
            output,
        };
        Ok(Recipe::new(state, last, ascii, &places))
    }
}
