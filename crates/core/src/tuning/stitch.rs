//! Thresholds for joining a patch to its rim and for remeshing it (`stitch`).

thresholds! {
    /// Thresholds for joining a patch to its rim and for remeshing it (`stitch`).
    StitchTuning {
        /// Least mean cosine between the faces of a gap and the surface; below it the loops were matched wrongly.
        least_agreement: f64 = 0.3,
        /// Voxels. A boundary of the kept part whose mean distance from the rim is larger does not belong to the rim.
        far_border: f64 = 6.0,
        /// Vertices of a boundary loop that have to be nearest to a rim loop for the two to bound the same gap.
        votes: usize = 2,
        /// Factor of a centroid's distance from each corner. A face is divided at its centroid where this product exceeds the
        /// edge lengths there. Liepa's α, √2, gives faces of about the size of the faces around the hole. For 660 vertices cut
        /// out of scans, with rims of 5 to 12 edges, finished patches were 1 % farther from the true surface than level-set
        /// patches with 1.7, 8 % with √2.
        density: f64 = 1.7,
        /// Rounds of division of a triangulation, at most: each about halves the lengths.
        refinements: usize = 40,
        /// Rounds of edge flips after each division, at most.
        refined_flips: usize = 60,
        /// Faces of a refined triangulation per square of the rim's number of edges, at most.
        refined_faces_of_rim: usize = 16,
        /// Faces in addition to [`Self::refined_faces_of_rim`], at most.
        refined_faces_besides: usize = 5000,
        /// Rings of free vertices over which the compensation for chords grows to its full size.
        compensation_fade: u32 = 2,
        /// Mean edge lengths at a vertex. Upper bound of its displacement by the compensation.
        most_compensation: f64 = 0.1,
        /// Target lengths. Longer edges are split. On 12 holes of scans 0.93 made patches 3 % worse; 1.87 made them 22 % worse,
        /// one by a factor of 2.8.
        long_edge: f64 = 4.0 / 3.0,
        /// Target lengths. Shorter edges are collapsed. On four holes of scans 0.56 made the error larger by 3.5 %.
        short_edge: f64 = 4.0 / 5.0,
        /// Passes over all edges within one round.
        passes: usize = 4,
        /// Least cosine between a face and the surface normals at its corners: a change must keep above it, or not lower the
        /// cosine.
        least_cosine: f64 = 0.5,
        /// Faces. A patch of at least this many faces is refused if more than [`Self::most_tilted`] of them are tilted after
        /// untangling.
        large_patch: usize = 3000,
        /// Fraction of the faces of a large patch that may be tilted. On patches of scans it is below a hundredth.
        most_tilted: f64 = 0.25,
        /// The same before untangling, which costs hundreds of times as much for a tilted face as all else for another.
        most_tangled: f64 = 0.4,
        /// Rounds of flips and smoothing at the end.
        polish: usize = 8,
        /// Target lengths, root mean square. The rounds of a large patch end when smoothing moves its vertices by less. Together
        /// with [`Self::settled_polish`] this saves a third of the time on a patch of 14,500 vertices; the mean quality falls
        /// from 0.976 to 0.973.
        settled: f64 = 0.06,
        /// The same for the rounds at the end.
        settled_polish: f64 = 0.01,
        /// Fraction of the mean angle across the mesh's own edges at the rim. A larger mean angle across the rim is reduced
        /// towards this.
        seam_goal: f64 = 0.85,
        /// Fraction of the angles across the rim that curvature does not explain. With a smaller fraction the angles are left.
        seam_rough: f64 = 0.4,
        /// Radians. Mean angles below this are left.
        seam_visible: f64 = 0.01,
        /// Rings of free vertices that are moved to reduce the angles across the rim.
        seam_rings: u32 = 3,
        /// Weight of the angles across the rim relative to the angles within the patch.
        seam_weight: f64 = 32.0,
        /// Weight of the displacements, in edge lengths, relative to the angles.
        seam_stay: f64 = 0.1,
        /// Edge lengths. Upper bound of a displacement that reduces the angles across the rim.
        seam_most: f64 = 0.25,
        /// Rounds of repair of a patch's faces.
        repair_rounds: usize = 9,
        /// Growth of the target length per unit of length, at most.
        size_growth: f64 = 0.3,
        /// Sweeps that smooth the target lengths between neighbours.
        size_sweeps: usize = 12,
        /// Fraction of the rim's target length. Lower bound of the target length that curvature asks for.
        size_least: f64 = 0.25,
        /// Voxels. Least target length.
        size_least_voxel: f64 = 0.02,
        /// Faces of a patch, at most, approximately.
        most_faces: f64 = 1e6,
        /// Faces of a patch per square of a rim's number of edges, at most, approximately. A disc with equal edges around it gets
        /// 0.3; rims of which a part is finer by orders of magnitude would otherwise reach [`Self::most_faces`].
        most_faces_of_rim: f64 = 16.0,
        /// Faces of a patch per equilateral triangle of its area whose edges have the rim's mean length, at most, approximately.
        most_faces_of_area: f64 = 16.0,
        /// Faces of a patch in addition to these, at most, approximately.
        most_faces_besides: f64 = 5000.0,
        /// Faces. A patch with more, if all had the size of those at the rim, gets larger faces inward. A disc has this many with a rim of
        /// 800 edges and takes 15 s; with 20,000 edges it would have 1e8.
        most_even_faces: f64 = 2e5,
        /// Growth of the target length per unit of distance from the rim of such a patch, at most.
        steepest_growth: f64 = 1.0,
        /// Exponent of the distance in the interpolation of target lengths from the rim.
        size_power: i32 = 3,
        /// Fraction of the way to its goal that a vertex moves in smoothing.
        smooth_step: f64 = 0.7,
        /// Rounds over all folded faces.
        untangle_rounds: usize = 3,
        /// Mean edges. Rims whose vertices are closer than this coincide.
        seam_apart: f64 = 1e-3,
        /// Voxels times the length of a loop. A loop that keeps nothing inside is thin up to this area.
        thin: f64 = 2.0,
        /// Cells. Of a larger table only a strip is searched.
        full_table: usize = 8_000_000,
        /// Inner vertices. Least half-width of the strip.
        strip: usize = 256,
        /// Triangles whose cosine to the surface normal is below this are penalised.
        tilt_cosine: f64 = 0.5,
        /// Weight of the difference between their cosine and [`Self::tilt_cosine`].
        tilt_weight: f64 = 40.0,
        /// Weight of an edge that leaves the gap.
        astray_weight: f64 = 20.0,
    }
}
