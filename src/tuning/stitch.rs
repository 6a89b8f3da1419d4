//! Thresholds of joining a patch to its rim and of remeshing it (`stitch`).

thresholds! {
    /// Thresholds of joining a patch to its rim and of remeshing it (`stitch`).
    StitchTuning {
        /// Least mean cosine between the faces of a gap and the surface; below it the loops were matched wrongly.
        least_agreement: f64 = 0.3,
        /// Voxels. A border of the kept part whose mean distance from the rim is larger does not belong to it.
        far_border: f64 = 6.0,
        /// Vertices of a border loop that have to be nearest to a rim loop for the two to bound the same gap.
        votes: usize = 2,
        /// A face is divided at its centroid where this times the centroid's distance from each corner is more than the lengths
        /// of the edges there. Liepa's α, √2, gives faces of about the size of those round the hole. Of 660 vertices cut out of
        /// scans, with rims of 5 to 12 edges, finished patches were 1 % farther off than those of level sets with 1.7, 8 % with √2.
        density: f64 = 1.7,
        /// Rounds of division of a triangulation, at most: each divides lengths by about two.
        refinements: usize = 40,
        /// Rounds of flips after each, at most.
        refined_flips: usize = 60,
        /// Faces of a refined triangulation for each square of the rim's number of edges, at most.
        refined_faces_of_rim: usize = 16,
        /// Faces beside those, at most.
        refined_faces_besides: usize = 5000,
        /// Rings of free vertices over which the compensation of the chords grows to its full size.
        compensation_fade: u32 = 2,
        /// Mean lengths of the edges at a vertex: its largest displacement.
        most_compensation: f64 = 0.1,
        /// Target lengths. Longer edges are split. On 12 holes of scans 0.93 made
        /// patches 3 % worse, 1.87 made them 22 % worse, one 2.8 times.
        long_edge: f64 = 4.0 / 3.0,
        /// Target lengths. Shorter edges are collapsed. On four holes of scans 0.56 made the error larger by 3.5 %.
        short_edge: f64 = 4.0 / 5.0,
        /// Passes over all edges within one round.
        passes: usize = 4,
        /// Least cosine between a face and the surface normals at its corners: a change must keep it, or not make it less.
        least_cosine: f64 = 0.5,
        /// Faces. From this many on a patch is refused if [`Self::most_tilted`] of them are tilted after untangling.
        large_patch: usize = 3000,
        /// Part of the faces of a large patch that may be tilted. On patches of scans it is below a hundredth.
        most_tilted: f64 = 0.25,
        /// Rounds of flips and smoothing at the end.
        polish: usize = 8,
        /// Target lengths, root mean square. The rounds of a large patch end when smoothing moves its vertices by less. With
        /// [`Self::settled_polish`] that saves a third of the time on a patch of 14,500 vertices, and the mean quality falls from
        /// 0.976 to 0.973.
        settled: f64 = 0.06,
        /// The same for the rounds at the end.
        settled_polish: f64 = 0.01,
        /// Where the mean angle across the rim is larger than that across the mesh's own edges at the rim, it is brought towards
        /// this part of the latter.
        seam_goal: f64 = 0.85,
        /// Part of the angles that is not of the surface's curvature: angles with less are left.
        seam_rough: f64 = 0.4,
        /// Radians. Angles that are smaller on average are left.
        seam_visible: f64 = 0.01,
        /// Rings of free vertices that are moved for the angles across the rim.
        seam_rings: u32 = 3,
        /// Weight of the angles across the rim beside those within the patch.
        seam_weight: f64 = 32.0,
        /// Weight of the displacements, in edge lengths, beside the angles.
        seam_stay: f64 = 0.1,
        /// Edge lengths. Largest displacement for the angles across the rim.
        seam_most: f64 = 0.25,
        /// Rounds of repair of a patch's faces.
        repair_rounds: usize = 9,
        /// Growth of the target length per unit of length, at most.
        size_growth: f64 = 0.3,
        /// Sweeps in which target lengths of neighbours are evened out.
        size_sweeps: usize = 12,
        /// Part of the rim's target length below which curvature never asks for shorter edges.
        size_least: f64 = 0.25,
        /// Voxels. Least target length.
        size_least_voxel: f64 = 0.02,
        /// Faces of a patch, about, at most.
        most_faces: f64 = 1e6,
        /// Faces of a patch for each square of a rim's number of edges, about, at most. A disc with equal edges round it gets
        /// 0.3; rims a part of which is finer by orders of magnitude would otherwise be filled to the limit above.
        most_faces_of_rim: f64 = 16.0,
        /// Faces of a patch beside those, about, at most.
        most_faces_besides: f64 = 5000.0,
        /// Power of the distance in the interpolation of target lengths from the rim.
        size_power: i32 = 3,
        /// Part of the way to its goal that a vertex moves in smoothing.
        smooth_step: f64 = 0.7,
        /// Rounds over all folded faces.
        untangle_rounds: usize = 3,
        /// Mean edges. Rims whose vertices are closer than this coincide.
        seam_apart: f64 = 1e-3,
        /// Voxels times the length of a loop: the area up to which a loop with nothing kept within is thin.
        thin: f64 = 2.0,
        /// Cells of the table above which only a strip of it is searched.
        full_table: usize = 8_000_000,
        /// Inner vertices. Least half-width of the strip.
        strip: usize = 256,
        /// Triangles whose cosine to the surface normal is below this are penalised.
        tilt_cosine: f64 = 0.5,
        /// Weight of what their cosine falls short by.
        tilt_weight: f64 = 40.0,
        /// Weight of an edge that leaves the gap.
        astray_weight: f64 = 20.0,
    }
}
