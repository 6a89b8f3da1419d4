//! Thresholds for choosing the patch of a region: candidates, retries, budgets (`fill`).

thresholds! {
    /// Thresholds for choosing the patch of a region: candidates, retries, budgets (`fill`).
    FillTuning {
        /// Diameters of a rim. A rim whose vertices deviate less from a plane is planar: twenty units in the last place of 32-bit
        /// floats at ten diameters from the origin.
        planar_rim: f64 = 3e-5,
        /// Cosine. Walls whose normals are at least this far from a rim's normal stand steeply on its plane (53°).
        steep: f64 = 0.6,
        /// Cosine. Faces whose normals are farther than this from a rim's normal leave its plane (18°): a plane cut through a body.
        leaving: f64 = 0.95,
        /// Cosine. The normals of straight walls differ by less than this in their angle with the rim's normal. On a ball that was
        /// cut through its middle they differ by 0.5 within [`Self::wall_depth`].
        straight: f64 = 0.03,
        /// Cosine. A wall ends at edges with larger dihedral angles (50°): a prism of eight sides has 45° between its sides and 90°
        /// at its bottom, a coarse ball of 80 faces 36°.
        wall_edge: f64 = 0.64,
        /// Diameters of a rim. The depth to which its walls are looked at.
        wall_depth: f64 = 0.35,
        /// Edges. Rims with more edges get no faired triangulation: its time grows with the cube of their number, and the rim
        /// alone seldom determines the shape of so wide a hole.
        most_faired_edges: usize = 400,
        /// Edges. Regions with longer rims are solved with fewer vertices of these, and fans of faces to those between, if the faces around
        /// them are much larger. A flat plate whose hole has 20,000 edges took 10 to 100 s with all of them. Where the faces around are as
        /// small as the rim's edges, a coarse patch in fine surroundings takes five times as long as a fine one.
        dense_rim: usize = 2000,
        /// Edges of such a rim in the solve, at least: they are as long as the edges that leave the rim. Where its shape needs more, two to
        /// eight times as many. A disc with this many takes about a second.
        coarse_rim: usize = 256,
        /// Lengths of an edge of the coarse rim. The vertices between its ends are at most this far from it. On a circle of 256 edges
        /// they are at 0.003.
        coarse_rim_error: f64 = 0.02,
        /// Cosine. The faces at the rim turn by less when its vertices move to those that stay (3°): their normals are data of the fill.
        coarse_rim_turn: f64 = 0.9986,
        /// Rounds. A triangulation is faired and its edges are flipped this many times before it is faired for the last time.
        fairings: usize = 2,
        /// Attempts. Upper bound of the level-set solves of a region with one energy, and again with the fallback energy.
        most_attempts: usize = 6,
        /// Upper bound of the factor that divides the automatic voxel in a retry: finer grids gave the same result.
        most_refined: f64 = 2.0,
        /// Factor by which the margin of the box around the rims grows when the surface reaches its side.
        box_growth: f64 = 1.8,
        /// Margins of the first box. The box grows while its margin is narrower than this, which allows two steps. A missing part
        /// much wider than its rim, such as a sphere of which only a cap of 30° remains, needs both.
        box_wide: f64 = 3.0,
        /// Diameters of the region. Two failures to join a surface at places closer than this count as the same failure.
        same_place: f64 = 0.05,
        /// Edges. Rims of at most this many edges get one solve only: they determine little of the surface, and a finer grid adds
        /// nothing.
        small_edges: usize = 16,
        /// Edges. A single rim of at most this many edges is closed by its faired triangulation alone, if that converges and does
        /// not intersect anything: with so few edges there is only one minimum.
        few_for_level_set: usize = 12,
        /// Voxels. An unconverged level set initialises the next one only if its last update was below this: larger updates
        /// usually lead to a worse minimum, and a triangulation is the better initialisation.
        initialising_update: f64 = 0.1,
        /// Unknowns times steps. Budget of the retries at a region: about six seconds of one core.
        budget: u64 = 1_000_000,
        /// Diameters. A rim is the end of a tube when its vertices are this close to a plane and [`Self::parallel`] holds.
        flat_rim: f64 = 0.01,
        /// Length of the mean conormal (the direction in which the surface continues) of a rim, at least, for the end of a tube:
        /// 1 for a straight tube.
        parallel: f64 = 0.98,
        /// Unknowns times steps. A faired triangulation with at most this expected cost (a rim of 60 edges, 93 ms) is computed
        /// beside the level set where it may help. More costly rims get a second level set, initialised from a triangulation.
        cheap: f64 = 15_480.0,
        /// ½∫h². If a finished patch has more energy than this, a faired triangulation is computed beside it: a surface bent as
        /// much as a spherical cap of 140° may be one of several minima.
        bent: f64 = 8.0,
        /// ½∫h². If a zero set has more energy than this, a second level set is computed from a triangulation: nearly the energy
        /// of a sphere (8π).
        level_set_bent: f64 = 20.0,
        /// Ratio of energies above which one patch is clearly worse. Triangulations of the same surface differ by smaller ratios.
        clearly_higher: f64 = 1.1,
        /// Ratio of energies above which one kind of surface replaces another. On 143 holes of scans patches with lower energies,
        /// down to 1/1.5, were farther from the true surface than the first patch.
        much_higher: f64 = 2.0,
        /// Sizes of the extracted surface. The mesh is given to the stitcher this far around it: farther than the stitcher's own
        /// margin.
        stitch_margin: f64 = 0.15,
        /// Voxels. An unconverged surface may be taken, if there is no better one, when its last update was below this.
        usable_update: f64 = 1.0,
        /// Nodes. An unconverged surface this close to the side of its box may need a wider box.
        near_side: i32 = 9,
        /// Voxels. A level set that is followed by a finish counts as converged when its update is below this; the finish
        /// continues from there. On 143 holes of scans a tenth of it gave no better patches and took two steps more.
        before_finish: f64 = 0.2,
        /// Fraction of the faces. Faired triangulations of several rims of which more intersect are not finished, since the finish
        /// moves vertices little.
        most_crossing: f64 = 0.02,
        /// Edges. Rims of at most this many edges are closed by triangles between their own vertices.
        few_edges: usize = 4,
        /// Diameters. A patch that rises higher than this above its rim balloons. Hemispheres rise by 0.5, caps of cut necks and
        /// limbs by 0.4, patches of holes in a smoothly continued surface by less than 0.2.
        balloon: f64 = 0.3,
        /// Diagonals of the rims' bounding box. The mesh is given to the finish this far around the rims; the finish uses it up
        /// to 0.68 of a hole's diameter along the surface.
        rim_reach: f64 = 0.8,
        /// Edge length of a finished patch over the edge length around the hole. On 12 holes of scans 0.5 made patches 9 % worse,
        /// 1 made them 6 % worse.
        finished_edge_ratio: f64 = 0.7,
        /// Unknowns times steps, per square of a rim's number of edges. Expected cost of a faired triangulation, mostly of its
        /// finish: 26 µs on 28 holes of scans and models.
        faired_cost: f64 = 4.3,
        /// Unknowns times steps, per face. Expected cost of a finish: 0.13 ms on 274 holes of scans and models.
        finish_cost: f64 = 21.0,
        /// Expected steps of the flow on each grid, including the time for the distances: measured on 290 level sets of scans and
        /// models.
        expected_steps: f64 = 11.0,
    }
}

impl FillTuning {
    /// Upper bound of the growth of the box's margin: two steps.
    pub const fn widest(&self) -> f64 {
        self.box_growth * self.box_growth
    }
}
