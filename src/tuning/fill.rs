//! Thresholds of the search for a closure of a region (`fill`).

thresholds! {
    /// Thresholds of the search for a closure of a region (`fill`).
    FillTuning {
        /// Edges. Rims with more edges get no faired triangulation: its time grows with the cube of their number, and the shape
        /// of so wide a hole is seldom determined by its rim alone.
        most_faired_edges: usize = 400,
        /// Rounds in which a triangulation is filled and its edges flipped, before it is filled for the last time.
        fairings: usize = 2,
        /// Level sets of a region with one energy, at most; the same number again with the fallback energy.
        most_tries: usize = 6,
        /// Upper bound of the factor that divides the automatic voxel in a retry: finer grids repeat the result.
        most_refined: f64 = 2.0,
        /// Factor by which the box grows when the surface reaches its side.
        box_growth: f64 = 1.8,
        /// The box grows while it is less than this many times as wide as at first, that is, twice: a missing part much wider
        /// than its rim, such as the rest of a sphere of which a cap of 30 degrees is left, takes two.
        box_wide: f64 = 3.0,
        /// Diameters of the region. Two failures to join a surface nearer to each other than this are the same failure.
        same_place: f64 = 0.05,
        /// Edges. Rims of at most this many edges are solved once only: their few edges determine little of the surface, and a
        /// finer grid adds nothing.
        small_edges: usize = 16,
        /// Edges. A single rim of at most this many edges is closed by its faired triangulation alone, where that converges and
        /// intersects nothing: so few edges leave no choice between minima.
        few_for_level_set: usize = 12,
        /// Voxels. An unconverged level set initialises the next one only if its last update was below this: larger updates
        /// usually lead to a worse minimum, and a triangulation is the better initialisation.
        worth_a_start: f64 = 0.1,
        /// Unknowns times steps that retries at a region may cost: about six seconds of one core.
        budget: u64 = 1_000_000,
        /// Diameters. A rim is the end of a tube when its vertices lie this close to a plane, and [`Self::parallel`] holds.
        flat_rim: f64 = 0.01,
        /// Least length of the mean of the directions in which the surface continues at the end of a tube: 1 for a straight tube.
        parallel: f64 = 0.98,
        /// Unknowns times steps. A faired triangulation that is expected to cost no more than this, that of a rim of 60 edges (93
        /// ms), is computed beside the level set where that may help. Other rims get a second level set instead, from a
        /// triangulation.
        cheap: f64 = 15_480.0,
        /// ½∫h² of a finished patch above which a faired triangulation is computed beside it: a surface as bent as a cap of 140°
        /// of a sphere may be one minimum of several.
        bent: f64 = 8.0,
        /// ½∫h² of a zero set above which a second level set is computed from a triangulation: nearly that of a sphere (8π).
        level_set_bent: f64 = 20.0,
        /// Ratio of energies above which one patch is clearly worse: smaller ratios are those of triangulations of one surface.
        clearly_higher: f64 = 1.1,
        /// Ratio of energies of two kinds of surfaces. On 143 holes of scans patches with lower energies, down to 1/1.5, were
        /// farther from the truth than the first.
        much_higher: f64 = 2.0,
        /// Part of the extracted surface's size by which the mesh round it is known to the stitcher: more than the stitcher's own
        /// margin.
        stitch_margin: f64 = 0.15,
        /// Voxels. An unconverged surface may be taken for want of a better one when its last update was below this.
        nearly_steady: f64 = 1.0,
        /// Nodes. A surface that does not converge this close to the side of its box may need a wider box.
        near_side: i32 = 9,
        /// Voxels. Largest update of a level set that counts as converged before a finish, which continues from there. On 143
        /// holes of scans a tenth of it made patches no better and took two steps more.
        before_finish: f64 = 0.2,
        /// Steps on a grid with the paper's variants, which converge linearly, at most.
        most_linear_steps: usize = 200,
        /// Edges. Rims of at most this many edges are closed by triangles between their vertices.
        few_edges: usize = 4,
        /// Diameters. A patch that rises higher above its rim balloons: half a sphere rises by 0.5, caps of cut necks and limbs
        /// by 0.4, patches of holes in a surface that continues by less than 0.2.
        balloon: f64 = 0.3,
        /// Diagonals of the rims' bounding box: how far round the rims the mesh is known to the finish, which asks for 0.68 of a
        /// hole's diameter along the surface.
        rim_reach: f64 = 0.8,
        /// Length of the patch's edges over that of the edges round the hole, where patches are finished. On 12 holes of scans 0.5
        /// made patches 9 % worse, 1 made them 6 % worse.
        finished_edge_ratio: f64 = 0.7,
        /// Unknowns times steps for the square of a rim's number of edges: expected cost of a faired triangulation, most of it
        /// for the finish. 26 µs on 28 holes of scans and models.
        faired_cost: f64 = 4.3,
        /// Unknowns times steps for each face: expected cost of a finish. 0.13 ms on 274 holes of scans and models.
        finish_cost: f64 = 21.0,
        /// Expected steps of the flow on each grid, with the time that the distances take: on 290 level sets of scans and models.
        expected_steps: f64 = 11.0,
    }
}

impl FillTuning {
    /// The most that the box grows by: twice.
    pub const fn widest(&self) -> f64 {
        self.box_growth * self.box_growth
    }
}
