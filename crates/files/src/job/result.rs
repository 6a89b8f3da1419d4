//! The mesh and reports that the work of a job makes, before attributes are transferred: fill, restoration, fairing, repair or copy.

use std::ops::Range;
use std::sync::Arc;

use glam::DMat4;
use serde::{Deserialize, Serialize};

use super::JobError;
use crate::io::Loaded;
use isomend_core::check::{CheckParams, Verdict};
use isomend_core::mend::{
    Control, FairReport, Faired, FillReport, Filled, Inspection, RestoreReport, Restored,
};
use isomend_core::mesh::attributes::{LabelKind, Labels, NONE};
use isomend_core::mesh::cut::Remainder;
use isomend_core::mesh::{Attributes, FaceOrigin, Mesh, Origins};
use isomend_core::repair::{Carried, RepairParams, RepairReport, repair};

/// The vertices and faces of a mesh that are kept.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct KeptElements {
    /// For each vertex, whether it is kept.
    pub vertices: Vec<bool>,
    /// For each face, whether it is kept.
    pub faces: Vec<bool>,
}

/// The kind of work that was done, with its report. The reports here do not contain the fill: it is in
/// [`JobResult::report`](super::JobResult::report).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum OperationReport {
    /// Only holes were filled.
    Holes,
    /// A marked region was replaced.
    Region(RestoreReport),
    /// The surface, or a region of it, was faired.
    Faired(FairReport),
    /// Defects were repaired.
    Repaired(Box<RepairReport>),
    /// The mesh was copied; holes were not looked for.
    Copied,
}

impl OperationReport {
    /// After a repair, adds the verdict on the result. `known` is the verdict on the written bytes; without it `after` is checked.
    pub(super) fn judge(&mut self, after: &Mesh, known: Option<Verdict>) -> Result<(), JobError> {
        let params = self.judged_by();
        if let (Self::Repaired(report), Some(params)) = (self, params) {
            let verdict = match known {
                Some(verdict) => verdict,
                None => Inspection::new(after)?.check(&params),
            };
            report.judge(verdict);
        }
        Ok(())
    }

    /// The parameters for checking the result of a repair: those with which the input was checked. `None` for other work.
    pub(super) fn judged_by(&self) -> Option<CheckParams> {
        match self {
            Self::Repaired(report) => {
                let before = report.before.as_ref();
                Some(before.map_or_else(CheckParams::default, |v| v.params.clone()))
            }
            _ => None,
        }
    }

    /// Whether the work is complete: after a fill or a restoration, no hole that was to be filled is open; after a repair, the mesh is
    /// sound; after a fairing, no object stayed unchanged. A copy is always complete.
    pub(super) fn is_complete(&self, fill: &FillReport) -> bool {
        match self {
            Self::Faired(report) => report.kept_objects.is_empty(),
            Self::Copied => true,
            Self::Repaired(report) => match &report.after {
                Some(verdict) => verdict.is_sound(),
                None => !fill.incomplete(),
            },
            Self::Holes | Self::Region(_) => !fill.incomplete(),
        }
    }
}

/// The mesh that the work made, with its reports.
pub(super) struct Made {
    pub(super) mesh: Mesh,
    /// The expected error of each new vertex.
    pub(super) expected_error: Vec<Option<f64>>,
    pub(super) kept_input: KeptInput,
    pub(super) extent: OperationReport,
    pub(super) report: FillReport,
    pub(super) replaced: Vec<ReplacedBody>,
}

/// The faces of a body that was replaced as a whole, by one surface. They keep the names of its object and part.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct ReplacedBody {
    /// The range of its faces in the mended mesh.
    pub(super) faces: Range<usize>,
    /// Its labels by kind, as indices of the input's names.
    pub(super) labels: Vec<(LabelKind, u32)>,
}

/// Labels the faces of bodies that were replaced. `input` has the names of the mesh that was read, `attributes` belong to the mended mesh,
/// which has this number of faces.
pub(super) fn label_replaced(
    replaced: &[ReplacedBody],
    input: &Attributes,
    attributes: &mut Attributes,
    faces: usize,
) {
    for body in replaced {
        for (kind, label) in &body.labels {
            let known = attributes.labels.iter().position(|l| l.kind == *kind);
            let at = known.unwrap_or_else(|| {
                let names = input.labels_of(*kind).map(|l| l.names.clone());
                attributes.labels.push(Labels {
                    names: names.unwrap_or_default(),
                    of_face: vec![NONE; faces],
                    kind: *kind,
                });
                attributes.labels.len() - 1
            });
            attributes.labels[at].of_face[body.faces.clone()].fill(*label);
        }
    }
    attributes.separate |= !replaced.is_empty();
}

impl From<Filled> for Made {
    fn from(filled: Filled) -> Self {
        Self {
            mesh: filled.mesh,
            expected_error: filled.expected_error,
            kept_input: KeptInput::All,
            extent: OperationReport::Holes,
            report: filled.report,
            replaced: Vec::new(),
        }
    }
}

impl From<Restored> for Made {
    fn from(restored: Restored) -> Self {
        Self {
            mesh: restored.mesh,
            expected_error: restored.expected_error,
            kept_input: KeptInput::Cut(restored.kept),
            report: restored.fill,
            replaced: Vec::new(),
            extent: OperationReport::Region(restored.report),
        }
    }
}

impl From<Faired> for Made {
    fn from(faired: Faired) -> Self {
        Self {
            mesh: faired.mesh,
            expected_error: Vec::new(),
            kept_input: faired.kept.map_or(KeptInput::Nothing, KeptInput::Cut),
            report: faired.fill,
            replaced: Vec::new(),
            extent: OperationReport::Faired(faired.report),
        }
    }
}

impl Made {
    /// A copy of the input. Its mesh stays empty; the input is used in its place.
    pub(super) fn copy(mesh: &Mesh) -> Self {
        Self {
            mesh: Mesh::default(),
            expected_error: Vec::new(),
            kept_input: KeptInput::All,
            extent: OperationReport::Copied,
            report: FillReport::unchanged(mesh),
            replaced: Vec::new(),
        }
    }
}

/// The part of the input with which the mended mesh starts, before the patches.
pub(super) enum KeptInput {
    /// The whole input.
    All,
    /// Nothing: one surface replaces all of the input.
    Nothing,
    /// The faces that remain after a cut.
    Cut(Remainder),
    /// The repaired input, with the origins of its vertices and faces.
    Repaired { mesh: Mesh, origins: Origins },
}

impl KeptInput {
    /// The kept part with its attributes, and which vertices and faces of the input are kept; `None` if all are.
    pub(super) fn of(self, loaded: Arc<Loaded>) -> (Arc<Loaded>, Option<KeptElements>) {
        match self {
            Self::All | Self::Nothing => (loaded, None),
            Self::Cut(kept) => {
                let kept_input = loaded.restricted(kept.mesh, [&kept.vertices, &kept.faces]);
                let (vertices, faces) = (kept.vertices, kept.faces);
                (Arc::new(kept_input), Some(KeptElements { vertices, faces }))
            }
            Self::Repaired { mesh, origins } => {
                let mut kept = KeptElements {
                    vertices: vec![false; loaded.mesh.positions.len()],
                    faces: vec![false; loaded.mesh.faces.len()],
                };
                for (face, origin) in mesh.faces.iter().zip(&origins.faces) {
                    let old = origin.face as usize;
                    kept.faces[old] |=
                        *origin == FaceOrigin::same(origin.face) && *face == loaded.mesh.faces[old];
                }
                for &old in &origins.vertices {
                    kept.vertices[old as usize] = true;
                }
                let kept_input = loaded.derived(mesh, &origins, &kept.faces);
                (Arc::new(kept_input), Some(kept))
            }
        }
    }

    /// For each face of the kept part, the face of the input that it is or was made from. The input has `faces` faces.
    pub(super) fn face_origins(&self, faces: usize) -> Vec<u32> {
        let all = 0..faces as u32;
        match self {
            Self::All | Self::Nothing => all.collect(),
            Self::Cut(kept) => all.filter(|f| kept.faces[*f as usize]).collect(),
            Self::Repaired { origins, .. } => origins.faces.iter().map(|o| o.face).collect(),
        }
    }

    /// For each face of the input, whether it was removed; `None` if the whole input is kept.
    pub(super) fn gone(&self, faces: usize) -> Option<Vec<bool>> {
        let kept = match self {
            Self::All | Self::Nothing => return None,
            Self::Cut(kept) => kept.faces.clone(),
            Self::Repaired { origins, .. } => origins.living(faces),
        };
        Some(kept.iter().map(|kept| !kept).collect())
    }
}

/// Repairs a mesh. Vertices that are `alike` have equal attributes. With `in_place` vertices keep their numbers; `stored` is as in
/// [`Carried::stored`].
pub(super) fn repaired(
    mesh: &Mesh,
    alike: &(dyn Fn(u32, u32) -> bool + Sync),
    (in_place, stored): (bool, Option<DMat4>),
    params: &RepairParams,
    control: &Control,
) -> Result<Made, JobError> {
    let alike = |a, b| !in_place && alike(a, b);
    let carried = Carried {
        alike: &alike,
        in_place,
        stored,
    };
    let done = repair(mesh, params, &carried, control)?;
    let (vertices, faces) = (done.origins.vertices.len(), done.origins.faces.len());
    let kept_mesh = Mesh::new(
        done.mesh.positions[..vertices].to_vec(),
        done.mesh.faces[..faces].to_vec(),
    );
    Ok(Made {
        mesh: done.mesh,
        expected_error: done.expected_error,
        kept_input: KeptInput::Repaired {
            mesh: kept_mesh,
            origins: done.origins,
        },
        report: done.fill,
        replaced: Vec::new(),
        extent: OperationReport::Repaired(Box::new(done.report)),
    })
}
