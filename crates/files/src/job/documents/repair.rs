//! JSON rows of a repair's report.

use glam::DVec3;
use serde::Serialize;

use super::VerdictRow;
use isomend_core::check::Component;
use isomend_core::repair::{RepairReport, SelfIntersectionPass};

/// The repair section of a report.
#[derive(Serialize)]
pub(super) struct RepairRow<'a> {
    steps: Steps<'a>,
    lost_faces: usize,
    lost_vertices: usize,
    lost_components: Gone,
    /// Components of the result with offset shells, and the walls that these form.
    offset_shells: Vec<OffsetShellRow>,
    /// The verdict on the input.
    before: Option<VerdictRow<'a>>,
    /// The verdict on the written file.
    after: Option<VerdictRow<'a>>,
}

/// A component of the result with an offset shell, partial or whole.
#[derive(Serialize)]
struct OffsetShellRow {
    /// The component's number, from 1 in the order of first faces.
    component: usize,
    faces: usize,
    /// The smallest and the mean wall thickness, and the place of the smallest.
    least_wall: Option<f64>,
    mean_wall: Option<f64>,
    thinnest_at: Option<DVec3>,
    /// The thickness that walls should have, if too many are thinner; else null.
    too_thin: Option<f64>,
}

/// Input components with no face left in the result.
#[derive(Serialize)]
struct Gone {
    count: usize,
    fewest_faces: usize,
    most_faces: usize,
}

#[derive(Serialize)]
struct Steps<'a> {
    merged_vertices: usize,
    welded_vertices: usize,
    stitched_junctions: usize,
    /// The width of the widest cracks that were closed beyond the precision of the coordinates.
    crack_width: f64,
    degenerate_faces: usize,
    closing_faces: usize,
    flipped_edges: usize,
    duplicate_faces: usize,
    reoriented_faces: usize,
    split_vertices: usize,
    non_manifold_faces: usize,
    debris_components: usize,
    debris_faces: usize,
    inside_components: usize,
    inside_faces: usize,
    inner_skins: usize,
    inner_skin_faces: usize,
    pinholes: usize,
    /// The largest distance between an outer skin and its inner one, in mesh units.
    skin_thickness: f64,
    united_bodies: usize,
    split_faces: usize,
    inner_faces: usize,
    moved_vertices: usize,
    largest_move: f64,
    relaxed_vertices: usize,
    largest_relaxation: f64,
    intersection_passes: &'a [SelfIntersectionPass],
    covered_faces: usize,
    components_left_intersecting: usize,
}

impl<'a> RepairRow<'a> {
    pub(super) fn new(r: &'a RepairReport) -> Self {
        Self {
            steps: Steps {
                merged_vertices: r.merged_vertices,
                welded_vertices: r.welded_vertices,
                stitched_junctions: r.stitched_junctions,
                crack_width: r.crack_width,
                degenerate_faces: r.degenerate_faces,
                closing_faces: r.closing_faces,
                flipped_edges: r.flipped_edges,
                duplicate_faces: r.duplicate_faces,
                reoriented_faces: r.reoriented_faces,
                split_vertices: r.split_vertices,
                non_manifold_faces: r.non_manifold_faces,
                debris_components: r.debris[0],
                debris_faces: r.debris[1],
                inside_components: r.inside[0],
                inside_faces: r.inside[1],
                inner_skins: r.inner_skins[0],
                inner_skin_faces: r.inner_skins[1],
                pinholes: r.pinholes,
                skin_thickness: r.skin_thickness,
                united_bodies: r.united_bodies,
                split_faces: r.split_faces,
                inner_faces: r.inner_faces,
                moved_vertices: r.moved_vertices,
                largest_move: r.largest_move,
                relaxed_vertices: r.relaxed_vertices,
                largest_relaxation: r.largest_relaxation,
                intersection_passes: &r.passes,
                covered_faces: r.covered_faces,
                components_left_intersecting: r.left_self_intersecting,
            },
            lost_faces: r.lost_faces,
            lost_vertices: r.lost_vertices,
            lost_components: {
                let [count, fewest_faces, most_faces] = r.lost_components;
                Gone {
                    count,
                    fewest_faces,
                    most_faces,
                }
            },
            offset_shells: r
                .offset_shells
                .iter()
                .map(|l| OffsetShellRow::new(l, r))
                .collect(),
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
