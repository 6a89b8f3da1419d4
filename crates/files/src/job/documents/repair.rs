//! JSON rows of a repair's report.

use glam::DVec3;
use serde::Serialize;

use super::VerdictRow;
use isomend_core::check::Component;
use isomend_core::repair::{RepairReport, SelfIntersectionPass};

/// The repair section of a report.
#[derive(Serialize)]
pub(super) struct RepairRow<'a> {
    /// What the steps changed.
    steps: RepairStepsRow<'a>,
    /// Input faces that are gone.
    lost_faces: usize,
    /// Input vertices that are gone.
    lost_vertices: usize,
    /// Input components that are gone.
    lost_components: LostComponentsRow,
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

/// Input components without a face in the result.
#[derive(Serialize)]
struct LostComponentsRow {
    /// Number of components.
    count: usize,
    /// Faces of the smallest.
    fewest_faces: usize,
    /// Faces of the largest.
    most_faces: usize,
}

/// What the steps of a repair changed.
#[derive(Serialize)]
struct RepairStepsRow<'a> {
    /// Coinciding vertices that were merged.
    merged_vertices: usize,
    /// Boundary vertices that were merged with a nearby one.
    welded_vertices: usize,
    /// Boundary vertices at which the edge they lay on was split.
    stitched_junctions: usize,
    /// The width of the widest cracks that were closed beyond the precision of the coordinates.
    crack_width: f64,
    /// Degenerate faces that were removed.
    degenerate_faces: usize,
    /// Faces added where bodies that share edges lacked one.
    closing_faces: usize,
    /// Faces without area that were merged into a neighbour by flipping an edge.
    flipped_edges: usize,
    /// Duplicate faces that were removed.
    duplicate_faces: usize,
    /// Faces that were reversed.
    reoriented_faces: usize,
    /// Copies of vertices that separate surfaces.
    split_vertices: usize,
    /// Faces cut out at edges with more than two faces.
    non_manifold_faces: usize,
    /// Components that were removed by their numbers.
    dropped_components: usize,
    /// Their faces.
    dropped_faces: usize,
    /// Small components that were removed.
    debris_components: usize,
    /// Their faces.
    debris_faces: usize,
    /// Components inside others that were removed.
    inside_components: usize,
    /// Their faces.
    inside_faces: usize,
    /// Inner skins that were removed.
    inner_skins: usize,
    /// Their faces, with the necks of pinholes.
    inner_skin_faces: usize,
    /// Pinholes into these that were closed.
    pinholes: usize,
    /// The largest distance between an outer skin and its inner one.
    skin_thickness: f64,
    /// Closed bodies that were united.
    united_bodies: usize,
    /// Faces that were split where they intersect another body.
    split_faces: usize,
    /// Faces of united bodies that were removed, because they lay inside other bodies or on their faces.
    inner_faces: usize,
    /// Vertices moved before a union.
    moved_vertices: usize,
    /// The largest displacement of these.
    largest_move: f64,
    /// Vertices moved where folds or noise intersected.
    relaxed_vertices: usize,
    /// The largest displacement of these.
    largest_relaxation: f64,
    /// Passes in which intersecting faces were cut out.
    intersection_passes: &'a [SelfIntersectionPass],
    /// Input faces that were removed, because they lay inside a surface that intersected theirs, or were covered by it.
    covered_faces: usize,
    /// Components that still intersect themselves, because cutting would have removed them.
    components_left_intersecting: usize,
}

impl<'a> RepairRow<'a> {
    pub(super) fn new(r: &'a RepairReport) -> Self {
        Self {
            steps: RepairStepsRow {
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
                dropped_components: r.dropped[0],
                dropped_faces: r.dropped[1],
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
                LostComponentsRow {
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
