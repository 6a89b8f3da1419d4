//! JSON rows of a repair's report.

use glam::DVec3;
use serde::Serialize;

use super::VerdictRow;
use isomend_core::check::Component;
use isomend_core::repair::{LostComponents, RepairReport, RepairSteps};

/// The repair section of a report.
#[derive(Serialize)]
pub(super) struct RepairRow<'a> {
    /// What the steps changed.
    steps: &'a RepairSteps,
    /// Input faces that are gone.
    lost_faces: usize,
    /// Input vertices that are gone.
    lost_vertices: usize,
    /// Input components that are gone.
    lost_components: LostComponents,
    /// Components with offset shells.
    offset_shells: Vec<OffsetShellRow>,
    /// The verdict of `check` on the input.
    before: Option<VerdictRow<'a>>,
    /// The same on the result as written.
    after: Option<VerdictRow<'a>>,
}

/// A component of the result with an offset shell, partial or whole.
#[derive(Serialize)]
struct OffsetShellRow {
    /// The component's number, from 1 in the order of first faces.
    component: usize,
    /// Number of faces.
    faces: usize,
    /// The least wall thickness.
    least_wall: Option<f64>,
    /// The mean wall thickness.
    mean_wall: Option<f64>,
    /// Where the thinnest wall is.
    thinnest_at: Option<DVec3>,
    /// The thickness that walls should have, if too many are thinner.
    too_thin: Option<f64>,
}

impl<'a> RepairRow<'a> {
    pub(super) fn new(r: &'a RepairReport) -> Self {
        let shells = r.offset_shells.iter();
        Self {
            steps: &r.steps,
            lost_faces: r.lost_faces,
            lost_vertices: r.lost_vertices,
            lost_components: r.lost_components,
            offset_shells: shells.map(|shell| OffsetShellRow::new(shell, r)).collect(),
            before: r.before.as_ref().map(VerdictRow::new),
            after: r.after.as_ref().map(VerdictRow::new),
        }
    }
}

impl OffsetShellRow {
    fn new((number, component): &(usize, Component), report: &RepairReport) -> Self {
        let thin = report.thin_offset_shells.iter().find(|(n, _)| n == number);
        Self {
            component: *number,
            faces: component.faces,
            least_wall: component.least_wall,
            mean_wall: component.mean_wall,
            thinnest_at: component.thinnest_at,
            too_thin: thin.map(|(_, limit)| *limit),
        }
    }
}
