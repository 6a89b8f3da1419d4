//! Meshes of several bodies: the objects of a 3MF file and their parts. Each is checked by itself.

use super::result::OperationReport;
use crate::io::{Format, Loaded};
use isomend_core::check::{CheckParams, Verdict};
use isomend_core::mend::{FillError, Inspection};
use isomend_core::mesh::Bodies;

/// Checks a mesh that has been inspected; its bodies by themselves, if there are several.
pub(super) fn checked(
    found: &Inspection,
    bodies: Option<&Bodies>,
    params: &CheckParams,
) -> Result<Verdict, FillError> {
    let Some(bodies) = bodies else {
        return Ok(found.check(params));
    };
    let verdict = |body: usize| {
        let mesh = bodies.mesh(&found.input, body);
        let verdict = Inspection::new(&mesh)?.check(params);
        let verdict = verdict.in_whole(&bodies.faces[body]);
        Ok((bodies.names[body].clone(), verdict))
    };
    let all: Result<Vec<_>, FillError> = (0..bodies.count()).map(verdict).collect();
    Ok(Verdict::of_bodies(all?))
}

/// The number of bodies that were mended as one mesh; none if there is one body, or each was mended by itself.
pub(super) fn mended_as_one(extent: &OperationReport, input: &Loaded) -> Option<usize> {
    let as_one = match extent {
        OperationReport::Repaired(report) => report.objects.is_empty(),
        _ => false,
    };
    as_one.then(|| input.bodies()).flatten().map(|b| b.count())
}

/// A remark on bodies that were repaired as one mesh, because the format holds no objects.
pub(super) fn one_mesh_note(count: usize, format: Format) -> String {
    format!(
        "the {count} objects were treated as one mesh, because {format} holds no objects; write 3MF to repair each by itself"
    )
}
