//! All JSON documents. `docs/json.md` describes the fields. The field names are stable: they do not follow renames of the types that
//! they are made from.

mod check;
mod counterpart;
mod filed;
mod plan;
mod repair;
mod rows;

use serde::Serialize;

use super::deliver::Delivered;
use super::result::OperationReport;
use super::{JobResult, JobSpec, Mended, Place};
use crate::io::Format;
use filed::FiledRow;
use isomend_core::fill::Tally;
use isomend_core::mend::{FairReport, FillReport, InputReport, RestoreReport};
use isomend_core::mesh::Mesh;
use repair::RepairRow;
use rows::{OutcomeRow, RegionRow, some_time};

pub(super) use check::VerdictRow;
pub(super) use rows::HoleRow;

/// The version of the field names and their values. It grows when one is renamed or removed, not when one is added.
const FORMAT: u32 = 3;

/// A JSON document: its content, the command and version that made it, and the version of its fields.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct Document<T> {
    /// The command.
    command: &'static str,
    /// The program's version.
    version: &'static str,
    /// Version of the fields: grows when one is renamed or removed. It does not when one is added.
    format: u32,
    #[serde(flatten)]
    body: T,
}

impl<T> Document<T> {
    /// A document of a command.
    pub fn new(command: &'static str, body: T) -> Self {
        Self {
            command,
            version: env!("CARGO_PKG_VERSION"),
            format: FORMAT,
            body,
        }
    }
}

/// A mesh file.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct FileInfo {
    /// The path, `-` in memory.
    path: String,
    /// The extension of its format.
    format: &'static str,
    /// Number of vertices.
    vertices: usize,
    /// Number of faces.
    faces: usize,
    /// The hash of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    sha256: Option<String>,
}

impl FileInfo {
    /// The row of a mesh in a file, without a hash.
    pub fn new(place: &Place, format: Format, mesh: &Mesh) -> Self {
        Self::of(place, format, [mesh.positions.len(), mesh.faces.len()])
    }

    /// The same from the numbers of vertices and faces.
    pub(super) fn of(place: &Place, format: Format, [vertices, faces]: [usize; 2]) -> Self {
        Self {
            path: shown(place),
            format: format.extension(),
            vertices,
            faces,
            sha256: None,
        }
    }

    /// The same with the hash of the file.
    pub(super) fn hashed(mut self, sha256: Option<String>) -> Self {
        self.sha256 = sha256;
        self
    }
}

/// A place as documents show it: `-` for the caller's memory.
pub(super) fn shown(place: &Place) -> String {
    match place {
        Place::File(path) => path.display().to_string(),
        Place::Memory { .. } => "-".to_owned(),
    }
}

impl JobResult<'_> {
    /// The JSON document of the result.
    pub fn document(&self) -> Document<impl Serialize> {
        let [read, written] = &self.sha256;
        let input = FileInfo::of(&self.spec.source.place, self.format, self.size);
        let output = self.spec.output.as_ref();
        let output = output.map(|o| FileInfo::new(&o.place, o.format, &self.mesh));
        let files = Files {
            input: input.hashed(read.clone()),
            output: output.map(|o| o.hashed(written.clone())),
            notes: &self.notes,
            filed: FiledRow::new(&self.spec, self.delivered.clone()),
        };
        files.document(&self.spec, &self.extent, &self.report)
    }
}

impl Mended<'_> {
    /// The JSON document of a mesh that is not written to a file. Its output row names memory (`-`) and the format of the input.
    pub fn document(&self) -> Document<impl Serialize> {
        let (source, format) = (&self.spec.source.place, self.kept_input.format);
        let here = Place::memory("");
        let delivered = Delivered {
            invented: self.invented(&self.components()),
            ..Delivered::default()
        };
        let input = FileInfo::of(source, format, self.size);
        let files = Files {
            input: input.hashed(self.sha256.clone()),
            output: Some(FileInfo::new(&here, format, self.mesh())),
            notes: &self.kept_input.notes,
            filed: FiledRow::new(&self.spec, delivered),
        };
        files.document(&self.spec, &self.extent, &self.report)
    }
}

/// A document of work that changes a mesh: its files and options.
#[derive(Serialize)]
struct Files<'a> {
    /// The input file.
    input: FileInfo,
    /// The written file.
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<FileInfo>,
    /// Remarks.
    notes: &'a [String],
    #[serde(flatten)]
    filed: FiledRow,
}

impl<'a> Files<'a> {
    fn document(
        self,
        spec: &JobSpec,
        extent: &'a OperationReport,
        report: &'a FillReport,
    ) -> Document<Body<'a>> {
        let fill = FillRow::new(report, spec.each_step);
        let body = match extent {
            OperationReport::Copied => Body::Copy(self),
            OperationReport::Faired(faired) => Body::Fair(FairBody {
                files: self,
                complete: extent.is_complete(report),
                volume_drift: faired.volume_drift(),
                fair: faired,
                fill,
            }),
            OperationReport::Repaired(repair) => Body::Repair(Box::new(RepairBody {
                files: self,
                complete: extent.is_complete(report),
                repair: RepairRow::new(repair),
                fill,
            })),
            OperationReport::Holes | OperationReport::Region(_) => Body::Fill(FillBody {
                files: self,
                flawless: report.flawless(),
                outcomes: report.tally(),
                complete: extent.is_complete(report),
                cut: match extent {
                    OperationReport::Region(report) => Some(report),
                    _ => None,
                },
                fill,
            }),
        };
        Document::new(spec.work.name(), body)
    }
}

/// The documents of several jobs.
#[derive(Default)]
pub(super) struct DocumentList(Vec<String>);

impl DocumentList {
    pub(super) fn add(&mut self, document: &impl Serialize) {
        // Never fails: JSON writes NaN and infinity as null, and all keys are strings.
        self.0
            .push(serde_json::to_string_pretty(document).unwrap_or_default());
    }

    /// The only document, or a JSON list of all.
    pub(super) fn text(&self, list: bool) -> String {
        let mut text = self.0.join(",\n");
        if list {
            // Indenting is safe: strings in JSON contain no line breaks.
            text = format!("[\n  {}\n]", text.replace('\n', "\n  "));
        }
        text + "\n"
    }
}

/// The document of an input whose job failed: its path and the error.
pub fn failed_document(
    command: &'static str,
    place: &Place,
    error: &str,
) -> Document<impl Serialize + use<>> {
    let input = FailedFileRow { path: shown(place) };
    let error = error.to_owned();
    Document::new(command, FailedBody { input, error })
}

/// An input whose job failed.
#[derive(Serialize)]
struct FailedBody {
    /// The input.
    input: FailedFileRow,
    /// What was wrong, where, and what to do.
    error: String,
}

/// The file of a failed job.
#[derive(Serialize)]
struct FailedFileRow {
    /// The path, `-` in memory.
    path: String,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Body<'a> {
    Fill(FillBody<'a>),
    Fair(FairBody<'a>),
    Repair(Box<RepairBody<'a>>),
    Copy(Files<'a>),
}

/// The document of a repair. The holes that the repair made come after the holes of the input.
#[derive(Serialize)]
struct RepairBody<'a> {
    #[serde(flatten)]
    files: Files<'a>,
    /// Whether the result is sound.
    complete: bool,
    #[serde(flatten)]
    repair: RepairRow<'a>,
    #[serde(flatten)]
    fill: FillRow<'a>,
}

/// The document of a fill or restoration. The holes of a restoration are numbered after the cut.
#[derive(Serialize)]
struct FillBody<'a> {
    #[serde(flatten)]
    files: Files<'a>,
    /// The condition of `--strict`.
    flawless: bool,
    /// Numbers of holes by outcome.
    outcomes: Tally,
    /// Whether nothing that was to be filled is open. That is no hole and, if `all_holes`, no boundary chain.
    complete: bool,
    /// The faces that a restoration cut out.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    cut: Option<&'a RestoreReport>,
    #[serde(flatten)]
    fill: FillRow<'a>,
}

/// The document of a fairing.
#[derive(Serialize)]
struct FairBody<'a> {
    #[serde(flatten)]
    files: Files<'a>,
    /// Whether no object of a 3MF file stayed unchanged because it could not be faired.
    complete: bool,
    /// Relative change of the volume. Null if the mesh is open.
    volume_drift: Option<f64>,
    #[serde(flatten)]
    fair: &'a FairReport,
    #[serde(flatten)]
    fill: FillRow<'a>,
}

/// The holes and regions.
#[derive(Serialize)]
struct FillRow<'a> {
    #[serde(flatten)]
    input: &'a InputReport,
    /// Whether no holes were chosen.
    all_holes: bool,
    /// The holes.
    holes: Vec<OutcomeRow>,
    /// Holes that were filled together.
    regions: Vec<RegionRow<'a>>,
    /// Time of the filling. Without reading and writing; left out with `--unit` or `--tolerance`.
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<f64>,
}

impl<'a> FillRow<'a> {
    fn new(report: &'a FillReport, each_step: bool) -> Self {
        let walls = report.joined_walls().concat();
        let region = |r| RegionRow::new(r, &walls, each_step);
        Self {
            input: &report.input,
            all_holes: report.all_holes,
            holes: report.holes.iter().map(OutcomeRow::new).collect(),
            regions: report.regions.iter().map(region).collect(),
            seconds: some_time(report.seconds),
        }
    }
}
