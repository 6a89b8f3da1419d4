//! Deliverables of a saved mesh: patches and missing piece as files, mark, unit and tolerance, as options of a command and as figures.

use std::path::Path;
use std::sync::PoisonError;

use serde_json::{Value, json};

use super::app::error_text;
use super::state::{State, StepDone};
use super::words::Command;
use isomend_core::mend::Control;
use isomend_core::mesh::Unit;
use isomend_files::io::Format;
use isomend_files::job::{Deliverables, JobError, Mark, Mended, Output};

/// Why an unedited or a faired mesh has only a unit.
const NO_PATCHES: &str = "this mesh has no patches to hand over; fill, restore or repair it first";

/// The options of a command for deliverables; `argument` writes the path of a file.
pub fn add_options(
    command: &mut Command,
    wanted: &Deliverables,
    argument: &dyn Fn(&Path) -> String,
) {
    for (name, output) in [("patches", &wanted.patches), ("piece", &wanted.piece)] {
        if let Some(path) = output.as_ref().and_then(|o| o.place.path()) {
            command.option(name, argument(path));
        }
    }
    if let Some(clearance) = wanted.clearance {
        command.option("clearance", clearance);
    }
    if let Some(mark) = wanted.mark {
        command.option("mark", mark_text(mark));
    }
    if wanted.continue_paint {
        command.option("paint", "continue");
    }
    if let Some(tolerance) = wanted.tolerance {
        command.option("tolerance", tolerance);
    }
    add_unit(command, wanted.unit);
}

/// The option for the unit of the coordinates.
pub fn add_unit(command: &mut Command, unit: Option<Unit>) {
    if let Some(unit) = unit {
        command.option("unit", unit);
    }
}

/// A mark as the command line writes it.
pub fn mark_text(mark: Mark) -> String {
    match mark {
        Mark::Colour([r, g, b]) => format!("colour={r:02x}{g:02x}{b:02x}"),
        Mark::Hatch => "hatch".to_owned(),
    }
}

/// The deliverables without the files besides the mesh.
pub fn without_files(wanted: &Deliverables) -> Deliverables {
    Deliverables {
        patches: None,
        piece: None,
        clearance: None,
        ..wanted.clone()
    }
}

/// The unit without the other deliverables.
pub fn unit_alone(wanted: &Deliverables) -> Deliverables {
    Deliverables {
        unit: wanted.unit,
        ..Deliverables::default()
    }
}

impl State {
    /// Whether the command of the last step has options for patches: a fill, a restoration or a repair.
    pub fn has_patches(&self) -> bool {
        let step = self.step.as_ref();
        step.is_some_and(|step| step.work.makes_patches())
    }

    /// Refuses deliverables that the last step does not make.
    ///
    /// # Errors
    /// [`JobError::Deliverable`].
    pub fn check_deliverables(&self, wanted: &Deliverables) -> Result<(), JobError> {
        match self.has_patches() || *wanted == unit_alone(wanted) {
            true => Ok(()),
            false => Err(JobError::Deliverable {
                what: NO_PATCHES.to_owned(),
            }),
        }
    }

    /// Area and expected error of the new faces of the last step, as in the JSON document of a job with this unit and tolerance; null if it
    /// has no patches.
    ///
    /// # Errors
    /// [`JobError::Deliverable`] if the tolerance is invalid.
    pub fn invented(&self, wanted: &Deliverables) -> Result<Value, JobError> {
        let Some(step) = self.step.as_ref().filter(|_| self.has_patches()) else {
            return Ok(Value::Null);
        };
        let measured = Deliverables {
            unit: wanted.unit,
            tolerance: wanted.tolerance,
            ..Deliverables::default()
        };
        let mended = step.mended.clone().delivering(measured)?;
        let mut document = serde_json::to_value(mended.document()).unwrap_or_default();
        Ok(document["invented"].take())
    }

    /// Why the last step makes no missing piece; `None` if it makes one. Computed once, in full precision.
    pub fn piece_refusal(&self) -> Option<String> {
        let step = self.step.as_ref()?;
        // The lock is not held while the piece is computed: the computation may run other requests on this thread.
        let known = || self.piece.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(refusal) = known().clone() {
            return refusal;
        }
        let made = step.mended.piece(&Control::new());
        let refusal = made.err().map(|error| error_text(&error));
        *known() = Some(refusal.clone());
        refusal
    }

    /// Whether the command with these options would end with exit code 0, if the step itself is complete: a piece can be made, and all
    /// patches are within the tolerance.
    ///
    /// # Errors
    /// As [`State::invented`].
    pub fn delivers(&self, wanted: &Deliverables) -> Result<bool, JobError> {
        if wanted.piece.is_some() && self.piece_refusal().is_some() {
            return Ok(false);
        }
        if wanted.tolerance.is_none() {
            return Ok(true);
        }
        let beyond = self.invented(wanted)?["beyond_tolerance"].take();
        Ok(beyond == Value::Null || beyond == json!([]))
    }
}

impl StepDone {
    /// The result of the step with deliverables, and with texels as in the step.
    ///
    /// # Errors
    /// [`JobError::Deliverable`].
    pub fn delivering(
        &self,
        mended: Mended<'static>,
        wanted: Deliverables,
    ) -> Result<Mended<'static>, JobError> {
        mended.delivering(Deliverables {
            no_texture: self.no_texture,
            ..wanted
        })
    }
}

/// The extension of the file of patches beside a mesh in a format. STL stores neither the numbers of holes nor expected errors.
pub fn patches_extension(mesh: Format) -> &'static str {
    match mesh {
        Format::Stl => Format::Ply.extension(),
        format => format.extension(),
    }
}

/// The extension of the file of the missing piece beside a mesh in a format.
pub fn piece_extension(mesh: Format) -> &'static str {
    match mesh {
        Format::ThreeMf => mesh.extension(),
        _ => Format::Stl.extension(),
    }
}

/// The file of a deliverable beside the file of a mesh: `bust.ply` has `bust_patches.ply` and `bust_piece.stl`.
///
/// # Errors
/// [`JobError::NoFormat`].
pub fn beside(mesh: &Path, name: &str, extension: &str) -> Result<Output, JobError> {
    let stem = mesh.file_stem().unwrap_or_default().to_string_lossy();
    Output::new(
        mesh.with_file_name(format!("{stem}_{name}.{extension}")),
        None,
    )
}
