//! Writes the deliverables of a mended mesh (patches, missing piece) and reports the invented surface in lines of text.

use serde::Serialize;

use super::components::{Component, components};
use super::invented::{Expected, Invented, Measured, Patch};
use super::patches::Whole;
use super::piece::{ONLY_RESTORED, Piece, piece};
use crate::io::Precision;
use crate::job::documents::FileInfo;
use crate::job::output::Saved;
use crate::job::staging::Staging;
use crate::job::{JobError, Mended, Output};
use crate::report::{counted, error_text, percent};
use isomend_core::mend::Control;
use isomend_core::mesh::{Mesh, Model, Part, Unit, number};

/// Most patches that get a line each in a text report.
const MOST_PATCHES: usize = 30;
/// The deliverables of a mended mesh.
#[derive(Clone, Debug, Default)]
pub(in crate::job) struct Delivered {
    /// Measures of the invented surface; `None` for a copied mesh and for whole level sets.
    pub(in crate::job) invented: Option<Invented>,
    /// The file of the patches.
    pub(in crate::job) patches: Option<FileInfo>,
    /// The file of the piece, or the reason why there is none.
    pub(in crate::job) piece: Option<PieceRow>,
    /// Remarks.
    pub(in crate::job) notes: Vec<String>,
}

/// The piece in a JSON document.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(in crate::job) enum PieceRow {
    /// The file that was written.
    File(FileInfo),
    /// No piece was written.
    Refused {
        /// Why.
        reason: String,
    },
}

impl Delivered {
    /// Whether no piece was refused and all patches are within the tolerance.
    pub(in crate::job) fn is_complete(&self) -> bool {
        let mut patches = self.invented.iter().flat_map(|i| &i.patches);
        let beyond = patches.any(|p| p.is_within == Some(false));
        !beyond && !matches!(self.piece, Some(PieceRow::Refused { .. }))
    }

    /// The totals of the invented surface, in lines.
    pub(in crate::job) fn lines(&self, unit: Option<Unit>, tolerance: Option<f64>) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(invented) = self.invented.as_ref().filter(|i| i.area > 0.0) {
            let square = unit.map_or(String::new(), |unit| format!(" {unit}²"));
            let patches = counted(invented.patches.len(), "patch");
            lines.push(format!(
                "new surface: {patches}, area {}{square}, {} of the whole surface",
                number(invented.area),
                percent(invented.percent)
            ));
            lines.push(expected(&invented.expected_error, unit, tolerance));
        }
        lines
    }

    /// One line per patch, largest area first.
    pub(in crate::job) fn hole_lines(&self, unit: Option<Unit>) -> Vec<String> {
        let square = unit.map_or(String::new(), |unit| format!(" {unit}²"));
        let patches = self.invented.iter().flat_map(|i| &i.patches);
        let mut patches: Vec<&Patch> = patches.collect();
        patches.sort_by(|a, b| b.area.total_cmp(&a.area));
        let line = |patch: &&Patch| {
            let holes: Vec<String> = patch.holes.iter().map(ToString::to_string).collect();
            format!(
                "hole {}: area {}{square}, {} of the whole surface, {}",
                holes.join("+"),
                number(patch.area),
                percent(patch.percent),
                expected(&patch.expected_error, unit, None)
            )
        };
        let mut lines: Vec<String> = patches.iter().take(MOST_PATCHES).map(line).collect();
        if let Some(more) = patches.get(MOST_PATCHES..).filter(|more| !more.is_empty()) {
            lines.push(format!(
                "{} smaller patches are listed in the JSON report only",
                more.len()
            ));
        }
        lines
    }

    /// Warnings, in lines: patches beyond the tolerance, and a piece that was not written.
    pub(in crate::job) fn warnings(
        &self,
        unit: Option<Unit>,
        tolerance: Option<f64>,
    ) -> Vec<String> {
        let mut lines = Vec::new();
        if let (Some(invented), Some(tolerance)) = (&self.invented, tolerance) {
            let limit = Unit::text(unit, tolerance);
            let beyond = invented
                .patches
                .iter()
                .filter(|p| p.is_within == Some(false));
            for patch in beyond {
                let part = 100.0 - patch.expected_error.within_percent.unwrap_or(0.0);
                let holes: Vec<String> = patch.holes.iter().map(ToString::to_string).collect();
                let name = match holes.is_empty() {
                    true => format!("region {}", patch.region),
                    false => format!("hole {}", holes.join("+")),
                };
                lines.push(format!(
                    "{name}: {} of its patch may err by more than {limit}{}",
                    percent(part),
                    match patch.expected_error.mean {
                        Some(_) => "",
                        None => "; its expected error is not known",
                    }
                ));
            }
        }
        if let Some(PieceRow::Refused { reason }) = &self.piece {
            lines.push(format!("no piece was written: {reason}"));
        }
        lines
    }
}

/// Expected errors in one line.
fn expected(all: &Expected, unit: Option<Unit>, tolerance: Option<f64>) -> String {
    let mut line = match (all.mean, all.largest) {
        (Some(mean), Some(largest)) => format!(
            "expected error: mean {}, largest {}",
            error_text(unit, mean),
            error_text(unit, largest)
        ),
        _ => "expected error: not known".to_owned(),
    };
    if all.mean.is_some() && all.unknown_percent >= 0.05 {
        line += &format!(
            ", not known on {} of the new surface",
            percent(all.unknown_percent)
        );
    }
    if let (Some(within), Some(tolerance)) = (all.within_percent, tolerance) {
        line += &format!(
            "; twice the expected error is within {} on {} of the patches",
            Unit::text(unit, tolerance),
            percent(within)
        );
    }
    line
}

impl Mended<'_> {
    /// The connected components of its patches; empty for whole level sets.
    pub(in crate::job) fn components(&self) -> Vec<Component> {
        match self.whole {
            true => Vec::new(),
            false => components(self.mesh(), self.kept_size()[1], &self.report),
        }
    }

    /// Measures of the invented surface; `None` for a copied mesh and for whole level sets.
    pub(in crate::job) fn invented(&self, components: &[Component]) -> Option<Invented> {
        let is_made = !self.whole && !matches!(self.extent, crate::job::OperationReport::Copied);
        let measured = Measured {
            mesh: self.mesh(),
            kept: self.kept_size()[0],
            expected_error: &self.expected_error,
            components,
            report: &self.report,
            tolerance: self.spec.deliverables.tolerance,
        };
        is_made.then(|| measured.invented())
    }

    /// The new faces as a separate mesh, in full precision: one component for each hole. Carries the same columns as
    /// [`Deliverables::patches`](super::Deliverables::patches) in PLY: hole numbers as `isomend_hole`, expected errors as `isomend_sigma`.
    pub fn patches(&self) -> Model {
        let model = self.model();
        let whole = Whole {
            mesh: &model.mesh,
            attributes: &model.attributes,
            kept: self.kept_size()[0],
            expected_error: &self.expected_error,
        };
        whole.patches(&self.components(), crate::io::Format::Ply)
    }

    /// The missing piece, in full precision: the solid between the faces that were cut out and the patches.
    ///
    /// # Errors
    /// [`JobError::Deliverable`] with the reason if there is no solid.
    pub fn piece(&self, control: &Control) -> Result<Model, JobError> {
        let made = self.piece_of(self.mesh(), None, control);
        let made = made.map_err(|what| JobError::Deliverable { what })?;
        Ok(Model {
            mesh: made.mesh,
            notes: made.notes,
            ..Model::default()
        })
    }

    fn piece_of(
        &self,
        mesh: &Mesh,
        stored: Option<glam::DMat4>,
        control: &Control,
    ) -> Result<Piece, String> {
        let is_restored = matches!(self.extent, crate::job::OperationReport::Region(_));
        let Some(before) = self.before.as_ref().filter(|_| is_restored) else {
            return Err(ONLY_RESTORED.to_owned());
        };
        let first = self.kept_size()[1].min(mesh.faces.len());
        let patches = Part::of_faces(&mesh.positions, &mesh.faces[first..], std::iter::empty());
        let cut = before.gone.iter().zip(0u32..).filter(|(gone, _)| **gone);
        let cut: Vec<u32> = cut.map(|(_, f)| f).collect();
        let cut = Part::new(&before.loaded.mesh, &cut, std::iter::empty());
        let clearance = self.spec.deliverables.clearance.unwrap_or(0.0);
        piece(&patches.mesh, &cut.mesh, clearance, stored, control)
    }

    /// The facts of an archived report for the page: unit, invented surface, warnings and hashes. Measures the invented surface if
    /// `delivered` is `None`.
    pub(in crate::job) fn filed_facts(
        &self,
        delivered: Option<&Delivered>,
        written: Option<&str>,
    ) -> Vec<(&'static str, String)> {
        let wanted = &self.spec.deliverables;
        let measured = || Delivered {
            invented: self.invented(&self.components()),
            ..Delivered::default()
        };
        let delivered = delivered.cloned().unwrap_or_else(measured);
        let mut facts = Vec::new();
        if let Some(unit) = wanted.unit {
            facts.push(("unit of lengths", unit.to_string()));
        }
        for line in delivered.lines(wanted.unit, wanted.tolerance) {
            if let Some((name, text)) = line.split_once(": ") {
                let name = match name {
                    "new surface" => "new surface",
                    _ => "expected error",
                };
                facts.push((name, text.to_owned()));
            }
        }
        for line in delivered.warnings(wanted.unit, wanted.tolerance) {
            facts.push(("warning", line));
        }
        let hashes = [
            ("SHA-256 of the input", self.sha256.as_deref()),
            ("SHA-256 of the output", written),
        ];
        facts.extend(
            hashes
                .into_iter()
                .filter_map(|(name, hash)| Some((name, hash?.to_owned()))),
        );
        facts
    }

    /// Writes the patches and the piece of a saved mesh.
    pub(in crate::job) fn deliver(
        &self,
        saved: &Saved,
        components: &[Component],
        delivered: &mut Delivered,
        staging: &mut Staging,
    ) -> Result<(), JobError> {
        let wanted = &self.spec.deliverables;
        if let Some(output) = &wanted.patches {
            let whole = Whole {
                mesh: &saved.mesh,
                attributes: &saved.attributes,
                kept: self.kept_size()[0],
                expected_error: &self.expected_error,
            };
            let model = whole.patches(components, output.format);
            if model.mesh.faces.is_empty() {
                let name = output.place.name();
                delivered
                    .notes
                    .push(format!("{name} was not written: there are no patches"));
                let stale = staging.set_aside(output.place.path());
                delivered.notes.extend(stale);
            } else {
                let file = write_aside(output, &model, delivered, staging)?;
                delivered.patches = Some(file);
            }
        }
        if let Some(output) = &wanted.piece {
            let stored = output.stored(&self.kept_input);
            let control = Control::new().cancel(&self.cancel);
            delivered.piece = Some(match self.piece_of(&saved.mesh, stored, &control) {
                Err(reason) => {
                    let stale = staging.set_aside(output.place.path());
                    delivered.notes.extend(stale);
                    PieceRow::Refused { reason }
                }
                Ok(made) => {
                    let name = output.place.name();
                    let notes = made.notes.iter().map(|note| format!("{name}: {note}"));
                    delivered.notes.extend(notes);
                    let mut model = Model::from(made.mesh);
                    model.attributes.unit = saved.attributes.unit;
                    PieceRow::File(write_aside(output, &model, delivered, staging)?)
                }
            });
        }
        Ok(())
    }
}

/// Writes a model to a file besides the mesh and adds its remarks.
fn write_aside(
    output: &Output,
    model: &Model,
    delivered: &mut Delivered,
    staging: &mut Staging,
) -> Result<FileInfo, JobError> {
    let stored = output.write_beside(model, Precision::of(&model.mesh), staging)?;
    let name = output.place.name();
    let notes = stored.notes.iter().map(|note| format!("{name}: {note}"));
    delivered.notes.extend(notes);
    let info = FileInfo::new(&output.place, output.format, &model.mesh);
    Ok(info.hashed(Some(stored.sha256)))
}
