//! Writes meshes, reports and recipes of the session.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::app::App;
use super::deliver::{add_options, unit_alone, without_files};
use super::recipe::{Places, Recipe};
use super::session::SavedAs;
use super::state::{State, StepDone, between};
use isomend_core::attributes::SEAM_NOTE;
use isomend_core::mend::Control;
use isomend_files::io::Format;
use isomend_files::job::{
    Deliverables, Drawings, JobError, JobSpec, Output, Place, Source, Work, inspect,
};

/// The remark on patches of earlier steps that have no texels.
const PLAIN_EARLIER: &str = "patches of earlier steps across seams of the texture keep a plain material: in OBJ only patches of the last \
                             step get texels; fill the holes in one step, or work on a GLB file";

/// The result of saving.
pub struct Saved {
    /// The file.
    pub path: PathBuf,
    /// Remarks.
    pub notes: Vec<String>,
    /// The JSON document of the command that writes the deliverables; null if there is none.
    pub document: Value,
    /// Deliverables that were not written, and patches that are not within the tolerance, in lines.
    pub warnings: Vec<String>,
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

    /// Writes a mesh and what is handed over with it, as the last commands of its recipe do.
    ///
    /// # Errors
    /// When the format does not allow it, the last step does not make the deliverables, or a file cannot be written.
    pub fn save_mesh(
        &self,
        state: &State,
        output: &Output,
        wanted: &Deliverables,
    ) -> Result<Saved, JobError> {
        output.check()?;
        state.check_deliverables(wanted)?;
        let mut saved = Saved {
            path: output.place.path().unwrap_or(&self.input).to_path_buf(),
            notes: self.plain_earlier(state).into_iter().collect(),
            document: Value::Null,
            warnings: Vec::new(),
        };
        let mut source = self.source_of(state);
        if let Some(step) = &state.step {
            // Checks the deliverables against the format and the file of the mesh.
            let mended = step.mended.clone().drawn(Drawings::default());
            let mended = step.delivering(mended.to(output.clone()), wanted.clone())?;
            let is_last = self.is_last(state, output.format);
            let is_plain = *wanted == unit_alone(wanted);
            if is_last || !is_plain {
                let mended = match is_last {
                    true => mended,
                    // The deliverables come from the command before the one that converts the mesh.
                    false => mended.to(Output::new(
                        state.place(&self.input),
                        Some(self.format_between),
                    )?),
                };
                let done = mended.write()?;
                saved.document = serde_json::to_value(done.document()).unwrap_or_default();
                saved.warnings = done.delivery_warnings();
                saved.notes.extend_from_slice(done.notes_written());
                if is_last {
                    return Ok(saved);
                }
                source = Source {
                    bytes: done.bytes,
                    format: Some(self.format_between),
                    ..Source::from(state.place(&self.input))
                };
            }
        }
        let mut spec = JobSpec::plan(source, Work::Copy);
        spec.output = Some(output.clone());
        spec.deliverables = unit_alone(wanted);
        let done = spec.read()?.mend(&Control::new())?.into_owned().write()?;
        saved.notes.extend_from_slice(done.notes_written());
        Ok(saved)
    }

    /// A remark if patches of earlier steps lie across seams of the texture and have no texels, although they were to have some.
    fn plain_earlier(&self, state: &State) -> Option<String> {
        let across_seams = |step: &&StepDone| {
            let notes = step.document["notes"].as_array().into_iter().flatten();
            let mut notes = notes.filter_map(Value::as_str);
            !step.no_texture && notes.any(|note| note.starts_with(SEAM_NOTE))
        };
        let mut earlier = state.steps();
        earlier.pop();
        let found = self.plain_between() && earlier.iter().any(across_seams);
        found.then(|| PLAIN_EARLIER.to_owned())
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

    /// Writes the report page of a step, or of the input. It names the unit and measures the patches by the tolerance.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn save_report(
        &self,
        state: &State,
        path: &Path,
        wanted: &Deliverables,
    ) -> Result<Saved, JobError> {
        let drawn = |command_line: String| Drawings {
            page: Some(path.to_path_buf()),
            command_line,
            ..Drawings::default()
        };
        match &state.step {
            Some(step) => {
                state.check_deliverables(wanted)?;
                let (output, wanted) = self.reported(state, wanted)?;
                let mut command = step.command.clone();
                add_options(&mut command, &wanted, &|path| path.display().to_string());
                let drawings = drawn(format!("isomend {}", command.words().join(" ")));
                let mended = step.mended.clone().drawn(drawings).to(output);
                step.delivering(mended, wanted)?.write()?;
            }
            None => {
                let drawings = drawn(format!("isomend inspect {}", self.input.display()));
                let source = self.source_of(state);
                inspect(
                    &source,
                    &state.loaded,
                    None,
                    None,
                    &drawings,
                    &Control::new(),
                )?;
            }
        }
        Ok(Saved {
            path: path.to_path_buf(),
            notes: Vec::new(),
            document: Value::Null,
            warnings: Vec::new(),
        })
    }

    /// The output and the deliverables of a report, without files besides the mesh. If the mesh was saved as its last command writes it,
    /// the output has the same bytes, so that the report names the hash of the saved file. In memory a textured OBJ or glTF file has no
    /// texels beside it, so that its bytes differ; its report is of the mesh in the session.
    fn reported(
        &self,
        state: &State,
        wanted: &Deliverables,
    ) -> Result<(Output, Deliverables), JobError> {
        let mut wanted = without_files(wanted);
        let between = state.place(&self.input);
        let saved = self.session().output(state.id).cloned();
        let format = saved
            .as_ref()
            .and_then(|saved| Format::from_extension(&saved.path));
        let has_side_files = |format: Format| {
            matches!(format, Format::Obj | Format::Gltf) && state.textures().count() > 0
        };
        let is_same = |format: &Format| self.is_last(state, *format) && !has_side_files(*format);
        let (Some(saved), Some(format)) = (saved, format.filter(is_same)) else {
            wanted.mark = None;
            wanted.continue_paint = false;
            return Ok((Output::new(between, Some(self.format_between))?, wanted));
        };
        let place = Place::Memory {
            name: saved.path.display().to_string(),
            folder: saved.path.parent().map(Path::to_path_buf),
        };
        let mut output = Output::new(place, Some(format))?;
        output.ascii = saved.ascii;
        wanted.mark = saved.deliverables.mark;
        wanted.continue_paint = saved.deliverables.continue_paint;
        Ok((output, wanted))
    }

    /// The recipe that makes a mesh and saves it to a file.
    ///
    /// # Errors
    /// When the file's extension names no format, or a step cannot be written as a command.
    pub fn recipe(
        &self,
        state: &State,
        (folder, stem): (&Path, &str),
        saved: &SavedAs,
    ) -> Result<Recipe, String> {
        let output = &saved.path;
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
            false => Some(self.host.renderer.command(&Work::Copy, None)?),
        };
        let places = Places {
            folder,
            stem,
            input: (&self.input, self.from),
            between: &|depth| self.between(depth),
            output,
            deliverables: &saved.deliverables,
            delivers: saved.delivered,
            plain_between: self.plain_between(),
        };
        Ok(Recipe::new(state, last, saved.ascii, &places))
    }
}
