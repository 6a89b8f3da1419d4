//! Inspecting, checking and comparing meshes without changing them, with their JSON documents and drawings.

use glam::DVec3;
use serde::Serialize;

use super::bodies::checked;
use super::documents::{HoleRow, VerdictRow};
use super::{Document, Drawings, FileInfo, JobError, Marked, MaskSpec, Place, Source, Unchanged};
use crate::io::Loaded;
use isomend_core::check::{CheckParams, Verdict};
use isomend_core::compare::{Comparison, compare as compare_meshes};
use isomend_core::mend::{Control, CreaseEnd, FillError, Inspection};
use isomend_core::mesh::mask::Selection;
use isomend_core::mesh::{Bodies, Defects, OpenChain, Unit};

/// The holes and properties of a mesh file.
#[non_exhaustive]
pub struct Inspected<'a> {
    place: &'a Place,
    /// The mesh that was read.
    pub loaded: &'a Loaded,
    /// Its topology, holes and defects.
    pub found: Inspection<'a>,
    /// Rim vertices of its holes at which sharp edges end.
    pub crease_ends: Vec<CreaseEnd>,
    /// The faces that a mask marks, if one was given.
    pub marked: Option<(Selection, Marked)>,
    /// The unit of the coordinates, where it was given.
    pub unit: Option<Unit>,
}

/// The inspection of a mesh and its bodies.
fn found<'a>(
    place: &Place,
    loaded: &'a Loaded,
    bodies: Option<&Bodies>,
) -> Result<Inspection<'a>, JobError> {
    Inspection::of_bodies(&loaded.mesh, bodies).map_err(|error| JobError::Inspect {
        name: place.name(),
        error,
    })
}

/// Ends the work between two stages if the run is cancelled.
fn go_on(control: &Control) -> Result<(), FillError> {
    match control.token().is_cancelled() {
        true => Err(FillError::Cancelled),
        false => Ok(()),
    }
}

/// Inspects a mesh, draws it if requested, and applies a mask if one is given.
///
/// # Errors
/// If the mesh cannot be inspected, the mask does not fit it, a file cannot be written, or the run is cancelled, which is seen between the
/// stages. A mask that marks no face is not an error.
pub fn inspect<'a>(
    source: &'a Source,
    loaded: &'a Loaded,
    mask: Option<&MaskSpec>,
    unit: Option<Unit>,
    drawings: &Drawings,
    control: &Control,
) -> Result<Inspected<'a>, JobError> {
    let place = &source.place;
    let bodies = loaded.bodies();
    let found = found(place, loaded, bodies.as_ref())?;
    go_on(control)?;
    let crease_ends = found.crease_ends(control)?;
    go_on(control)?;
    let marked = mask.map(|mask| mask.marked(loaded)).transpose()?;
    let marked = marked.map(|marked| (Selection::new(&loaded.mesh, &marked.faces), marked));
    drawings.write_unchanged(&Unchanged {
        place,
        loaded,
        found: &found,
        crease_ends: &crease_ends,
        verdict: None,
        unit,
    })?;
    Ok(Inspected {
        place,
        loaded,
        found,
        crease_ends,
        marked,
        unit,
    })
}

/// The document of an inspection.
#[derive(Serialize)]
struct InspectBody<'a> {
    /// The input file.
    input: FileInfo,
    /// Remarks.
    notes: &'a [String],
    /// As of `--unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<Unit>,
    /// Number of vertices.
    vertices: usize,
    /// Number of faces.
    faces: usize,
    /// Smallest and largest coordinates.
    bounds: [DVec3; 2],
    /// Number of connected components.
    components: usize,
    /// Faces of each component.
    component_faces: &'a [usize],
    /// Numbers of defects.
    defects: Defects,
    /// Boundary chains that do not close.
    open_chains: &'a [OpenChain],
    /// The holes.
    holes: Vec<HoleRow>,
    /// Rim vertices at which sharp edges end.
    crease_ends: &'a [CreaseEnd],
    /// Marked faces.
    #[serde(skip_serializing_if = "Option::is_none")]
    mask: Option<&'a Selection>,
}

impl Inspected<'_> {
    /// The JSON document of the inspection.
    pub fn document(&self) -> Document<impl Serialize> {
        Document::new("inspect", self.body())
    }

    fn body(&self) -> InspectBody<'_> {
        let Self { loaded, found, .. } = self;
        InspectBody {
            input: FileInfo::new(self.place, loaded.format, &loaded.mesh),
            notes: &loaded.notes,
            unit: self.unit,
            vertices: loaded.mesh.positions.len(),
            faces: loaded.mesh.faces.len(),
            bounds: loaded.mesh.bounds(),
            components: found.topology.component_faces.len(),
            component_faces: &found.topology.component_faces,
            defects: found.topology.defects,
            open_chains: &found.open_chains,
            holes: found.holes.iter().map(HoleRow::new).collect(),
            crease_ends: &self.crease_ends,
            mask: self.marked.as_ref().map(|(selection, _)| selection),
        }
    }
}

/// What work that only looks at a mesh has found.
pub enum Looked<'a> {
    /// Its holes and properties.
    Inspected(Inspected<'a>),
    /// The verdict on it.
    Checked(Checked<'a>),
}

impl Looked<'_> {
    /// Whether the answer is what one wishes: a check's verdict is sound.
    pub fn is_good(&self) -> bool {
        match self {
            Self::Inspected(_) => true,
            Self::Checked(checked) => checked.verdict.is_sound(),
        }
    }

    /// The JSON document.
    pub fn document(&self) -> Document<impl Serialize> {
        #[derive(Serialize)]
        #[serde(untagged)]
        enum Body<'a> {
            Inspect(InspectBody<'a>),
            Check(CheckBody<'a>),
        }
        match self {
            Self::Inspected(found) => Document::new("inspect", Body::Inspect(found.body())),
            Self::Checked(found) => Document::new("check", Body::Check(found.body())),
        }
    }
}

/// A mesh file and the verdict on it.
#[non_exhaustive]
pub struct Checked<'a> {
    place: &'a Place,
    /// The mesh that was read.
    pub loaded: &'a Loaded,
    /// Its topology, holes and defects.
    pub found: Inspection<'a>,
    /// The verdict.
    pub verdict: Verdict,
    /// The unit of the coordinates, where it was given.
    pub unit: Option<Unit>,
}

/// Checks a mesh for all kinds of defects, and draws it if requested.
///
/// # Errors
/// If the parameters are invalid, the mesh cannot be inspected, a file cannot be written, or the run is cancelled, which is seen between
/// the stages.
pub fn check<'a>(
    source: &'a Source,
    loaded: &'a Loaded,
    params: &CheckParams,
    unit: Option<Unit>,
    drawings: &Drawings,
    control: &Control,
) -> Result<Checked<'a>, JobError> {
    params.check().map_err(FillError::from)?;
    let place = &source.place;
    let bodies = loaded.bodies();
    let found = found(place, loaded, bodies.as_ref())?;
    go_on(control)?;
    let verdict = checked(&found, bodies.as_ref(), params)?;
    go_on(control)?;
    drawings.write_unchanged(&Unchanged {
        place,
        loaded,
        found: &found,
        crease_ends: &[],
        verdict: Some(&verdict),
        unit,
    })?;
    Ok(Checked {
        place,
        loaded,
        found,
        verdict,
        unit,
    })
}

/// The document of a check.
#[derive(Serialize)]
struct CheckBody<'a> {
    /// The input file.
    input: FileInfo,
    /// Remarks.
    notes: &'a [String],
    /// As of `--unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<Unit>,
    #[serde(flatten)]
    verdict: VerdictRow<'a>,
}

impl Checked<'_> {
    /// The JSON document of the check.
    pub fn document(&self) -> Document<impl Serialize> {
        Document::new("check", self.body())
    }

    fn body(&self) -> CheckBody<'_> {
        CheckBody {
            input: FileInfo::new(self.place, self.loaded.format, &self.loaded.mesh),
            notes: &self.loaded.notes,
            unit: self.unit,
            verdict: VerdictRow::new(&self.verdict),
        }
    }
}

/// The document of a comparison.
#[derive(Serialize)]
struct CompareBody<'a> {
    /// The first file.
    first: &'a FileInfo,
    /// The second file.
    second: &'a FileInfo,
    /// As of `--unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<Unit>,
    #[serde(flatten)]
    comparison: &'a Comparison,
}

/// The comparison of two mesh files.
#[non_exhaustive]
pub struct Compared {
    files: [FileInfo; 2],
    /// The distances between the meshes.
    pub comparison: Comparison,
    /// The unit of the coordinates, where it was given.
    pub unit: Option<Unit>,
}

/// Compares two meshes, with `samples` sample points on each.
///
/// # Errors
/// [`JobError::Compare`] when there is nothing to compare.
pub fn compare(
    meshes: [(&Source, &Loaded); 2],
    samples: usize,
    unit: Option<Unit>,
) -> Result<Compared, JobError> {
    let [(first, a), (second, b)] = meshes;
    let comparison = compare_meshes(&a.mesh, &b.mesh, samples);
    let comparison = comparison.map_err(|error| JobError::Compare {
        first: first.place.name(),
        second: second.place.name(),
        error,
    })?;
    let info = |(source, loaded): (&Source, &Loaded)| {
        FileInfo::new(&source.place, loaded.format, &loaded.mesh)
    };
    Ok(Compared {
        files: meshes.map(info),
        comparison,
        unit,
    })
}

impl Compared {
    /// The JSON document of the comparison.
    pub fn document(&self) -> Document<impl Serialize> {
        let [first, second] = &self.files;
        let comparison = &self.comparison;
        let body = CompareBody {
            first,
            second,
            unit: self.unit,
            comparison,
        };
        Document::new("compare", body)
    }
}
