//! Specifications of jobs, from JSON, names and paths: the work, the output, further outputs.

use std::path::PathBuf;

use isomend::io::Format;
use isomend::job::{Deliverables, JobSpec, Output, Place, Work};
use isomend::{FillParams, Like};

use crate::errors::Failure;

/// A job that keeps its result in memory and writes no file.
pub fn spec(source: &Place, work: Work) -> JobSpec {
    let mut spec = JobSpec::plan(PathBuf::new(), work);
    spec.source.place = source.clone();
    spec.drawings.may_follow = true;
    spec
}

/// The work that JSON describes, such as `{"fill": {"max_diameter": 2.0}}`.
pub fn work(json: &str) -> Result<Work, Failure> {
    serde_json::from_str(json).map_err(|error| {
        // The caller gave keywords, not JSON: the position in the JSON is left out.
        let error = error.to_string();
        let what = error
            .rsplit_once(" at line ")
            .map_or(&*error, |(what, _)| what);
        Failure::parameter(what)
    })
}

/// The format with this name; a `ParameterError` with the list of formats if there is none.
pub fn format(name: Option<&str>) -> Result<Option<Format>, Failure> {
    let parsed = |name: &str| {
        name.parse::<Format>().map_err(|_| {
            let list = Format::LIST;
            Failure::parameter(format!("there is no format '{name}'; there are {list}"))
        })
    };
    name.map(parsed).transpose()
}

/// An output to a file, or to bytes if there is no path; in the format `to`, or the format of the file's extension.
pub fn output(path: Option<PathBuf>, to: Option<&str>, ascii: bool) -> Result<Output, Failure> {
    let place = path.map_or(Place::memory("bytes"), Place::File);
    let mut output = Output::new(place, format(to)?)?;
    output.ascii = ascii;
    output.check()?;
    Ok(output)
}

/// Outputs beside a mended mesh: the files of the patches and of the missing piece, the marks on patches, the unit and the tolerance
/// of the report.
pub fn deliverables(
    [patches, piece]: [Option<PathBuf>; 2],
    mark: Option<&str>,
    unit: Option<&str>,
    tolerance: Option<f64>,
) -> Result<Deliverables, Failure> {
    let file = |path: PathBuf| Output::new(path, None);
    Ok(Deliverables {
        patches: patches.map(file).transpose()?,
        piece: piece.map(file).transpose()?,
        mark: mark
            .map(str::parse)
            .transpose()
            .map_err(Failure::parameter)?,
        unit: unit
            .map(str::parse)
            .transpose()
            .map_err(Failure::parameter)?,
        tolerance,
        ..Deliverables::default()
    })
}

/// The parameters of a fill from JSON, such as `{"max_diameter": 2.0}`.
pub fn fill_params(json: &str) -> Result<FillParams, Failure> {
    match work(&format!("{{\"fill\": {json}}}"))? {
        Work::Fill(params) => with_template(params),
        _ => Err(Failure::parameter("the parameters do not belong to a fill")),
    }
}

/// The parameters of a fill with their template, where they name the file of one.
pub fn with_template(mut params: FillParams) -> Result<FillParams, Failure> {
    if let Some(file) = params.like.as_ref().and_then(Like::unread).cloned() {
        let loaded = isomend::io::read_path(&file, None)?;
        params.like = Some(Like::template(file, loaded.mesh));
    }
    Ok(params)
}
