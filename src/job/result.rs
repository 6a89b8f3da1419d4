//! What a job's work makes, before it is written.

use std::sync::Arc;

use glam::DMat4;
use serde::{Deserialize, Serialize};

use super::JobError;
use crate::check::{CheckParams, Verdict};
use crate::io::Loaded;
use crate::mend::{
    Control, FairReport, Faired, FillReport, Filled, Inspection, RestoreReport, Restored,
};
use crate::mesh::cut::Remainder;
use crate::mesh::{FaceOrigin, Mesh, Origins};
use crate::repair::{Carried, RepairParams, RepairReport, repair};

/// For each vertex and each face of a mesh whether it is kept.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Kept {
    /// For each vertex.
    pub vertices: Vec<bool>,
    /// For each face.
    pub faces: Vec<bool>,
}

/// What of the mesh was replaced, beside its holes.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Extent {
    /// Nothing.
    Holes,
    /// A marked region. The report of its fill is [`report`](super::JobResult::report), and empty here.
    Region(RestoreReport),
    /// The surface or a region of it, faired. The report of its regions is [`report`](super::JobResult::report), and empty here.
    Faired(FairReport),
    /// What was wrong. The report of its fills is [`report`](super::JobResult::report), and empty here.
    Repaired(Box<RepairReport>),
    /// Nothing, and no hole was looked for either: the report of fills is empty.
    Copied,
}

impl Extent {
    /// After a repair adds the verdict on the result: that on the bytes which were written, where it is known.
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

    /// How the result is judged, if it is: as the input was.
    pub(super) fn judged_by(&self) -> Option<CheckParams> {
        match self {
            Self::Repaired(report) => {
                let before = report.before.as_ref();
                Some(before.map_or_else(CheckParams::default, |v| v.params.clone()))
            }
            _ => None,
        }
    }

    /// Whether the work is complete: after a fill or a restoration no hole that was to be filled is open, after a repair the mesh is
    /// sound; a fairing always is.
    pub(super) fn is_complete(&self, fill: &FillReport) -> bool {
        match self {
            Self::Faired(_) | Self::Copied => true,
            Self::Repaired(report) => match &report.after {
                Some(verdict) => verdict.is_sound(),
                None => !fill.incomplete(),
            },
            Self::Holes | Self::Region(_) => !fill.incomplete(),
        }
    }
}

/// What the work made.
pub(super) struct Made {
    pub(super) mesh: Mesh,
    pub(super) expected_error: Vec<Option<f64>>,
    pub(super) first: First,
    pub(super) extent: Extent,
    pub(super) report: FillReport,
}

impl From<Filled> for Made {
    fn from(filled: Filled) -> Self {
        Self {
            mesh: filled.mesh,
            expected_error: filled.expected_error,
            first: First::All,
            extent: Extent::Holes,
            report: filled.report,
        }
    }
}

impl From<Restored> for Made {
    fn from(mut restored: Restored) -> Self {
        Self {
            mesh: restored.mesh,
            expected_error: restored.expected_error,
            first: First::Cut(restored.kept),
            report: std::mem::take(&mut restored.report.fill),
            extent: Extent::Region(restored.report),
        }
    }
}

impl From<Faired> for Made {
    fn from(mut faired: Faired) -> Self {
        Self {
            mesh: faired.mesh,
            expected_error: Vec::new(),
            first: faired.kept.map_or(First::All, First::Cut),
            report: std::mem::take(&mut faired.report.fill),
            extent: Extent::Faired(faired.report),
        }
    }
}

impl Made {
    /// A copy of a mesh, which is that of the input itself: there is none of its own.
    pub(super) fn copy(mesh: &Mesh) -> Self {
        Self {
            mesh: Mesh::default(),
            expected_error: Vec::new(),
            first: First::All,
            extent: Extent::Copied,
            report: FillReport {
                vertices: mesh.positions.len(),
                faces: mesh.faces.len(),
                ..FillReport::default()
            },
        }
    }
}

/// What of the input is before the patches.
pub(super) enum First {
    /// All of it.
    All,
    /// What a cut left.
    Cut(Remainder),
    /// What a repair made of it.
    Repaired { first: Mesh, origins: Origins },
}

impl First {
    /// The input's part of the output, and which vertices and faces of the input are kept where not all are.
    pub(super) fn of(self, loaded: Arc<Loaded>) -> (Arc<Loaded>, Option<Kept>) {
        match self {
            Self::All => (loaded, None),
            Self::Cut(kept) => {
                let first = loaded.restricted(kept.mesh, [&kept.vertices, &kept.faces]);
                let (vertices, faces) = (kept.vertices, kept.faces);
                (Arc::new(first), Some(Kept { vertices, faces }))
            }
            Self::Repaired { first, origins } => {
                let mut kept = Kept {
                    vertices: vec![false; loaded.mesh.positions.len()],
                    faces: vec![false; loaded.mesh.faces.len()],
                };
                for (face, origin) in first.faces.iter().zip(&origins.faces) {
                    let old = origin.face as usize;
                    kept.faces[old] |=
                        *origin == FaceOrigin::same(origin.face) && *face == loaded.mesh.faces[old];
                }
                for &old in &origins.vertices {
                    kept.vertices[old as usize] = true;
                }
                let first = loaded.derived(first, &origins, &kept.faces);
                (Arc::new(first), Some(kept))
            }
        }
    }

    /// For each face of the input's part of the output the face of the input, of which there are `faces`, that it is or was made of.
    pub(super) fn face_origins(&self, faces: usize) -> Vec<u32> {
        let all = 0..faces as u32;
        match self {
            Self::All => all.collect(),
            Self::Cut(kept) => all.filter(|f| kept.faces[*f as usize]).collect(),
            Self::Repaired { origins, .. } => origins.faces.iter().map(|o| o.face).collect(),
        }
    }

    /// For each face of the input whether it is gone; none where none is.
    pub(super) fn gone(&self, faces: usize) -> Option<Vec<bool>> {
        let kept = match self {
            Self::All => return None,
            Self::Cut(kept) => kept.faces.clone(),
            Self::Repaired { origins, .. } => origins.living(faces),
        };
        Some(kept.iter().map(|kept| !kept).collect())
    }
}

/// A mesh repaired. `in_place` keeps the numbers of its vertices, `stored` is as in [`Carried::stored`].
pub(super) fn repaired(
    loaded: &Loaded,
    (in_place, stored): (bool, Option<DMat4>),
    params: &RepairParams,
    control: &Control,
) -> Result<Made, JobError> {
    let alike = |a, b| !in_place && loaded.attributes.are_alike(a, b);
    let carried = Carried {
        alike: &alike,
        in_place,
        stored,
    };
    let mut done = repair(&loaded.mesh, params, &carried, control)?;
    let (vertices, faces) = (done.origins.vertices.len(), done.origins.faces.len());
    let first = Mesh::new(
        done.mesh.positions[..vertices].to_vec(),
        done.mesh.faces[..faces].to_vec(),
    );
    Ok(Made {
        mesh: done.mesh,
        expected_error: done.expected_error,
        first: First::Repaired {
            first,
            origins: done.origins,
        },
        report: std::mem::take(&mut done.report.fill),
        extent: Extent::Repaired(Box::new(done.report)),
    })
}
