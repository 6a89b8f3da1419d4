//! Thresholds of what nearly closes a border (`check`).

thresholds! {
    /// Thresholds of what nearly closes a border (`check`).
    CheckTuning {
        /// Part of an edge's length within which a border vertex lies on the edge (T-junction). Vertices of CAD files in 64-bit
        /// floats lay within 1e-12 of it, after rounding to 32-bit floats within 3e-7 where edges measure a hundredth of the
        /// largest coordinate; the unit of the file is taken where that is more.
        junction: f64 = 1e-6,
        /// Part of an edge's length that this tolerance may be, at most.
        junction_most: f64 = 1e-3,
        /// Tolerances from an end of an edge within which a vertex lies at the end, not on the edge.
        junction_ends: f64 = 4.0,
        /// Part of the bounding box's diagonal within which border vertices are merged by default.
        weld: f64 = 1e-9,
        /// Units in the last place of the file's coordinates within which they are merged by default: positions that were computed
        /// twice differed by up to three.
        weld_units: f64 = 4.0,
        /// Part of the diagonal that this is, at most: coordinates of few digits are often meant, such as those of voxels.
        weld_most: f64 = 1e-5,
        /// Part of the shorter one of two border edges within which their ends are merged by default.
        weld_edge: f64 = 0.1,
        /// Part of the shorter one of two border edges within which they count as nearly coinciding, for advice. Of 20 000 triangles
        /// at random places 0.25 took ten times as long.
        weld_part: f64 = 0.1,
        /// Part of the border's edges that a length has to close to be advised.
        weld_least: f64 = 0.05,
        /// Digits of coordinates that are looked for in text files, at least and
        least_digits: i32 = 4,
        /// at most.
        most_digits: i32 = 12,
        /// Cosine of the angle within which the two sides of a wall are parallel: 15°. Beyond it they are a wedge, whose thickness at any
        /// place is less than four times its distance from the edge.
        parallel: f64 = 0.966,
        /// Squares of the thickness. Area of the surface that is no thicker than the least wall of a component, at least: that of a
        /// disk of a third of the thickness, so that single slivers are no walls. Half a ball with a flat cap has 0.4.
        wall_patch: f64 = 0.25,
        /// Faces at which walls are measured, in parts by the faces of the components: of 1.1 million faces the mean was the same to
        /// a thousandth as that of all.
        wall_samples: usize = 20_000,
        /// Faces of each component at which they are measured, where it has as many.
        wall_samples_least: usize = 64,
        /// Relative distance from a 32-bit float within which a number is one that was written with nine digits or more.
        single: f64 = 5e-9,
    }
}
