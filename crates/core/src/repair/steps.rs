//! What the steps of a repair changed, as the report counts it.

use serde::{Deserialize, Serialize};

/// What the steps of a repair changed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct RepairSteps {
    /// Coinciding vertices that were merged.
    pub merged_vertices: usize,
    /// Boundary vertices that were merged with a nearby one.
    pub welded_vertices: usize,
    /// Boundary vertices at which the edge they lay on was split.
    pub stitched_junctions: usize,
    /// The width of the widest cracks that were closed beyond the precision of the coordinates.
    pub crack_width: f64,
    /// Degenerate faces that were removed.
    pub degenerate_faces: usize,
    /// Faces added where bodies that share edges lacked one.
    pub closing_faces: usize,
    /// Faces without area that were merged into a neighbour by flipping an edge.
    pub flipped_edges: usize,
    /// Duplicate faces that were removed.
    pub duplicate_faces: usize,
    /// Faces of the input that were reversed.
    pub reoriented_faces: usize,
    /// Copies of vertices that separate surfaces.
    pub split_vertices: usize,
    /// Faces cut out at edges with more than two faces.
    pub non_manifold_faces: usize,
    /// Components that were removed by their numbers.
    pub dropped_components: usize,
    /// Their faces.
    pub dropped_faces: usize,
    /// Small components that were removed.
    pub debris_components: usize,
    /// Their faces.
    pub debris_faces: usize,
    /// Components inside others that were removed.
    pub inside_components: usize,
    /// Their faces.
    pub inside_faces: usize,
    /// Inner skins that were removed.
    pub inner_skins: usize,
    /// Their faces, with the necks of pinholes.
    pub inner_skin_faces: usize,
    /// Pinholes into these that were closed.
    pub pinholes: usize,
    /// The largest distance between an outer skin and its inner one.
    pub skin_thickness: f64,
    /// Closed bodies that were united.
    pub united_bodies: usize,
    /// Faces that were split where they intersect another body.
    pub split_faces: usize,
    /// Faces of united bodies that were removed, because they lay inside other bodies or on their faces.
    pub inner_faces: usize,
    /// Vertices moved before a union.
    pub moved_vertices: usize,
    /// The largest displacement of these.
    pub largest_move: f64,
    /// Vertices moved where folds or noise intersected.
    pub relaxed_vertices: usize,
    /// The largest displacement of these.
    pub largest_relaxation: f64,
    /// Passes in which intersecting faces were cut out.
    pub intersection_passes: Vec<SelfIntersectionPass>,
    /// Input faces that were removed, because they lay inside a surface that intersected theirs, or were covered by it.
    pub covered_faces: usize,
    /// Components that still intersect themselves, because cutting would have removed them.
    pub components_left_intersecting: usize,
}

/// One pass in which intersecting faces were cut out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SelfIntersectionPass {
    /// Faces that intersected others.
    pub intersecting_faces: usize,
    /// Faces cut out.
    pub cut_faces: usize,
    /// Rings of faces round the intersecting ones that were cut out too.
    pub rings: usize,
}

impl RepairSteps {
    /// Adds the changes of another body: counts are summed, of lengths the largest stays.
    pub(super) fn add(&mut self, own: &Self) {
        self.crack_width = self.crack_width.max(own.crack_width);
        self.skin_thickness = self.skin_thickness.max(own.skin_thickness);
        self.largest_move = self.largest_move.max(own.largest_move);
        self.largest_relaxation = self.largest_relaxation.max(own.largest_relaxation);
        self.merged_vertices += own.merged_vertices;
        self.welded_vertices += own.welded_vertices;
        self.stitched_junctions += own.stitched_junctions;
        self.degenerate_faces += own.degenerate_faces;
        self.closing_faces += own.closing_faces;
        self.flipped_edges += own.flipped_edges;
        self.duplicate_faces += own.duplicate_faces;
        self.reoriented_faces += own.reoriented_faces;
        self.split_vertices += own.split_vertices;
        self.non_manifold_faces += own.non_manifold_faces;
        self.dropped_components += own.dropped_components;
        self.dropped_faces += own.dropped_faces;
        self.debris_components += own.debris_components;
        self.debris_faces += own.debris_faces;
        self.inside_components += own.inside_components;
        self.inside_faces += own.inside_faces;
        self.inner_skins += own.inner_skins;
        self.inner_skin_faces += own.inner_skin_faces;
        self.pinholes += own.pinholes;
        self.united_bodies += own.united_bodies;
        self.split_faces += own.split_faces;
        self.inner_faces += own.inner_faces;
        self.moved_vertices += own.moved_vertices;
        self.relaxed_vertices += own.relaxed_vertices;
        self.covered_faces += own.covered_faces;
        self.components_left_intersecting += own.components_left_intersecting;
        for (k, pass) in own.intersection_passes.iter().enumerate() {
            match self.intersection_passes.get_mut(k) {
                None => self.intersection_passes.push(*pass),
                Some(sum) => {
                    sum.intersecting_faces += pass.intersecting_faces;
                    sum.cut_faces += pass.cut_faces;
                    sum.rings = sum.rings.max(pass.rings);
                }
            }
        }
    }
}
