//! Deliverables besides the mended mesh: the patches alone, the missing piece as a solid, marks on patches, units, and measures of the
//! invented surface.

mod components;
mod invented;
mod mark;
mod mark_surface;
mod patches;
mod piece;
mod write;

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{JobError, JobSpec, Output, Place, Work};
use isomend_core::mend::FillReport;
use isomend_core::mesh::Unit;
use isomend_core::tuning::{Tunable, tunable};

pub(super) use components::Component;
pub(super) use invented::Invented;
pub use mark::Mark;
pub(super) use patches::has_columns;
pub(super) use write::{Delivered, PieceRow};

/// Fraction of a patch. A hole is listed if more of its patch than this may be farther off than the tolerance.
const BEYOND_PART: Tunable<f64> = tunable("deliver.beyond_part", 0.05);

/// Further files besides a mended mesh, and how patches are marked and reported.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Deliverables {
    /// File for the new faces alone: one component for each hole, with the number of the hole and the expected errors if the format can
    /// store them.
    pub patches: Option<Output>,
    /// File for the solid between the faces that were cut out and the patches; only after a restoration.
    pub piece: Option<Output>,
    /// How far the contact surface of the piece, the faces that were cut out, is moved into the piece, in the mesh's units; the rim of the
    /// patch stays.
    pub clearance: Option<f64>,
    /// How patches are marked in the files.
    pub mark: Option<Mark>,
    /// The unit of the mesh's coordinates; reports print it with every length. With a unit or a tolerance, reports contain no run times, so
    /// that equal runs give equal bytes.
    pub unit: Option<Unit>,
    /// The largest error allowed, in the mesh's units. Reports list a hole if twice the expected error exceeds this on more than the
    /// fraction `BEYOND_PART.get()` of its patch.
    pub tolerance: Option<f64>,
    /// Leave patches across seams of a texture without texels, with a plain material.
    pub no_texture: bool,
    /// Paint patches as their neighbours, where a 3MF file with the paint of a slicer is written again. Without it they have no paint.
    pub continue_paint: bool,
}

impl Deliverables {
    /// Whether reports are meant for an archive; they then contain no run times.
    pub fn is_filed(&self) -> bool {
        self.unit.is_some() || self.tolerance.is_some()
    }

    /// Whether patches across seams of a texture stay without texels: if requested, and if they are marked, since a texture would show
    /// through the mark.
    pub(super) fn has_plain_patches(&self) -> bool {
        self.no_texture || self.mark.is_some()
    }

    /// Checks the deliverables before anything is read.
    pub(super) fn check(&self, spec: &JobSpec) -> Result<(), JobError> {
        let wrong = |what: String| Err(JobError::Deliverable { what });
        if let Some(tolerance) = self.tolerance.filter(|t| !(t.is_finite() && *t > 0.0)) {
            return wrong(format!(
                "the tolerance must be a positive number, but it is {tolerance}"
            ));
        }
        if let Some(clearance) = self.clearance.filter(|c| !(c.is_finite() && *c > 0.0)) {
            return wrong(format!(
                "the clearance must be a positive number, but it is {clearance}"
            ));
        }
        if self.clearance.is_some() && self.piece.is_none() {
            return wrong(
                "a clearance belongs to the missing piece, and none is to be written; name a file for the piece".to_owned(),
            );
        }
        if self.piece.is_some() && !matches!(spec.work, Work::Restore(..)) {
            return wrong(piece::ONLY_RESTORED.to_owned());
        }
        let makes_patches = !matches!(spec.work, Work::Copy);
        if !makes_patches && (self.patches.is_some() || self.mark.is_some()) {
            return wrong(
                "a conversion makes no patches, so there is nothing to mark or to write alone"
                    .to_owned(),
            );
        }
        let marked = spec.output.as_ref().filter(|_| self.mark.is_some());
        if let Some(output) = marked.filter(|o| !mark::has_colours(o.format)) {
            return wrong(format!(
                "{} has no colours, so patches cannot be marked in {}; write PLY, OBJ, glTF or VTK, or write the patches alone to a \
                 separate file",
                output.format,
                output.place.name()
            ));
        }
        self.check_places(spec)
    }

    /// Refuses files that cannot be written, and files that the job uses already.
    fn check_places(&self, spec: &JobSpec) -> Result<(), JobError> {
        let mut taken = vec![("the input", spec.source.place.clone())];
        taken.extend(spec.output.iter().map(|o| ("the mesh", o.place.clone())));
        let drawn = [&spec.drawings.page, &spec.drawings.picture];
        let file = |path: &PathBuf| ("a drawing", Place::from(path.clone()));
        taken.extend(drawn.into_iter().flatten().map(file));
        let own = [("the patches", &self.patches), ("the piece", &self.piece)];
        for (name, output) in own {
            let Some(output) = output else {
                continue;
            };
            output.check()?;
            let place = &output.place;
            if let Some((what, _)) = taken.iter().find(|(_, t)| place.is_same_file(t)) {
                let what = format!(
                    "{name} would be written to {}, which is the file of {what}; name another file",
                    place.name()
                );
                return Err(JobError::Deliverable { what });
            }
            taken.push((name, place.clone()));
        }
        Ok(())
    }
}

/// Sets the run times of a report to 0; those are left out of documents and texts.
pub(super) fn clear_run_times(report: &mut FillReport) {
    report.seconds = 0.0;
    for region in &mut report.regions {
        region.seconds = 0.0;
        region.levels.iter_mut().for_each(|l| l.seconds = [0.0; 2]);
    }
}
