//! Thresholds for nearly closed boundaries, wall thickness and the precision of coordinates (`check`).

thresholds! {
    /// Thresholds for nearly closed boundaries, wall thickness and the precision of coordinates (`check`).
    CheckTuning {
        /// Edge lengths. A boundary vertex within this distance of an edge lies on it (T-junction). In CAD files with 64-bit
        /// floats
        /// T-junction vertices lay within 1e-12 of the edge; after rounding to 32-bit floats, within 3e-7 where edges are a
        /// hundredth of the largest coordinate. The resolution of the file's coordinates is used where it is larger.
        junction: f64 = 1e-6,
        /// Edge lengths. Upper bound of the T-junction tolerance.
        junction_most: f64 = 1e-3,
        /// T-junction tolerances. A vertex closer than this to an end of an edge counts as at the end, not on the edge.
        junction_ends: f64 = 4.0,
        /// Diagonals of the bounding box. Boundary vertices within this distance are merged by default.
        weld: f64 = 1e-9,
        /// Units in the last place of the file's coordinates. Boundary vertices within this distance are merged by default:
        /// positions that were computed twice differed by up to three units.
        weld_units: f64 = 4.0,
        /// Diagonals of the bounding box. Upper bound of the distance of [`Self::weld_units`]: coordinates with few digits, such as voxel
        /// coordinates, are often exact.
        weld_most: f64 = 1e-5,
        /// Lengths of the shorter of two boundary edges. The ends of the edges are merged by default only within this distance.
        weld_edge: f64 = 0.1,
        /// Lengths of the shorter of two boundary edges. Edges whose ends are within this distance count as nearly coinciding in
        /// the merge advice. On 20 000 triangles at random places 0.25 took ten times as long.
        weld_part: f64 = 0.1,
        /// Fraction of the boundary edges. A merge distance is advised only if it closes at least this fraction.
        weld_least: f64 = 0.05,
        /// Boundary edges. A merge distance is tried before it is advised only where there are at most this many: in a heap of loose
        /// triangles this takes seconds.
        weld_tested: usize = 5000,
        /// Decimal digits. Smallest precision looked for in the coordinates of text files.
        least_digits: i32 = 4,
        /// Decimal digits. Largest precision looked for in the coordinates of text files.
        most_digits: i32 = 12,
        /// Cosine. The two sides of a wall count as parallel within this angle (15°). Beyond it they form a wedge, whose
        /// thickness at any point is less than four times the distance from its edge.
        parallel: f64 = 0.966,
        /// Squares of the thickness. The least wall thickness of a component is one at which at least this area is no thicker:
        /// about a disk whose radius is a third of the thickness, so that single slivers do not count as walls. A hemisphere with
        /// a flat cap has 0.4.
        wall_patch: f64 = 0.25,
        /// Faces. Number of faces at which wall thickness is measured, shared among components by face count. On 1.1 million
        /// faces the mean agreed with the mean over all faces to a thousandth.
        wall_samples: usize = 20_000,
        /// Faces. Least number of samples in each component that has as many faces.
        wall_samples_least: usize = 64,
        /// Relative distance. A coordinate this close to a 32-bit float counts as one written with nine digits or more.
        single: f64 = 5e-9,
    }
}
