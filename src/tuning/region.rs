//! Thresholds of regions: groups of holes, their grids, and the nested solve (`region`).

thresholds! {
    /// Thresholds of regions: groups of holes, their grids, and the nested solve (`region`).
    RegionTuning {
        /// Diameters of the larger rim. Rims that face each other are one opening up to this gap.
        facing_gap: f64 = 1.0,
        /// Diameters of the larger rim. Rims closer than this share a region.
        near_gap: f64 = 0.1,
        /// Larger rims that a rim is compared with, at most. In a mesh of loose triangles all rims are near all others; in scans
        /// a rim has a few neighbours.
        most_nearby: usize = 128,
        /// Vertices of each rim that are compared.
        rim_samples: usize = 240,
        /// Voxels across a hole.
        across: f64 = 32.0,
        /// Voxels across a hole where the patch is finished on its own triangles. On 44 holes of scans patches with 12 were 4 %
        /// farther from the truth after the finish, with 24 and more no nearer.
        across_coarse: f64 = 16.0,
        /// Edges. A single rim of at most this many edges counts as short: its patch has some fifty vertices, for which coarser
        /// voxels do.
        short_rim: usize = 25,
        /// Voxels across a hole with a short rim whose patch is finished. On 43 such holes of scans patches were 1 % farther off
        /// than with 16.
        across_short: f64 = 12.0,
        /// Ratio of diameter to width. Slots are resolved across their width up to this ratio; where the patch is finished,
        /// across the geometric mean of both: on 143 holes of scans its square root gave patches as near to the truth in three
        /// quarters of the time.
        narrowest: f64 = 2.0,
        /// Voxels across a hole on the coarsest level.
        coarsest: f64 = 16.0,
        /// Voxels across the smallest loop of a region, at least.
        across_smallest: f64 = 14.0,
        /// Voxels across a hole in a finer retry, at most, unless the first attempt had more.
        across_retry: f64 = 72.0,
        /// Voxels across a hole where the voxel is chosen automatically, at most.
        across_limit: f64 = 160.0,
        /// Voxels across a hole where the voxel is given, at most.
        finest: f64 = 1024.0,
        /// Part of the width of the widest hole: free space round the rims.
        margin_part: f64 = 0.5,
        /// Coarse voxels of free space round the rims beside that.
        margin_nodes: f64 = 7.0,
        /// The same for a short rim whose patch is finished. On 43 such holes of scans as accurate as 7; round longer rims 6 made
        /// patches 1 to 4 % worse.
        margin_short: f64 = 5.0,
        /// Blocks of nodes of a box on its coarsest level, at most: 16 million nodes. The box of a hole has about 1300, that of
        /// facing rims a few diameters apart up to 1e5.
        most_blocks: f64 = 2.5e5,
        /// Blocks of a box on its coarsest level, four times those of a round hole, above which it gets another level below it if
        /// the hole is wide enough there.
        many_blocks: f64 = 5000.0,
        /// Part of the rims' extent along an axis by which [`Self::margin_part`] is less along it.
        margin_taken: f64 = 0.35,
        /// Part of the width of the widest hole: the margin is not less than this.
        least_margin: f64 = 0.15,
        /// Finer voxels. Blocks farther than this from the coarse surface are not stored.
        stored: f64 = 8.0,
        /// Voxels. Nodes farther than this from the surface at the start are not pulled.
        pulled: f64 = 8.0,
        /// Relative residual of the biharmonic fill that the flow starts from.
        start_tolerance: f64 = 3e-3,
        /// Steps on a coarser level, at most.
        coarse_steps: usize = 14,
        /// Tolerance on a coarser level over that of the finest.
        coarse_tolerance: f64 = 20.0,
        /// Voxels. Upper bound of the tolerance on a coarser level, unless that of the finest is larger.
        most_coarse_tolerance: f64 = 0.4,
        /// Voxels. A level whose last update was longer than this is far from steady.
        far_from_steady: f64 = 0.05,
        /// Ratio of the energy at the start of a level to that at the end of the coarser one, above which, if that was more than
        /// [`Self::energy_blowup_least`], the data contradict each other: the energy of a surface tends to a limit as voxels get
        /// smaller. Of 577 levels of 52 meshes all with such a start were of regions that ended without a surface.
        energy_blowup: f64 = 3.0,
        /// Energy at the end of the coarser level for that, at least.
        energy_blowup_least: f64 = 300.0,
        /// Rim radii. Deep nodes are free within this distance of the rim's centre.
        deep_reach: f64 = 1.3,
        /// Voxels. Nodes round a hole are free where they are farther than this from the known surface.
        deep: f64 = 5.5,
        /// Voxels. Upper bound of the distance of a node from the coarser one beside it, with room for the difference between the
        /// triangles and the smooth surface.
        spacing: f64 = 2.0,
        /// Diameters, root mean square, normals included. Rims closer to a sphere than this lie on it.
        sphere_fits: f64 = 0.05,
        /// Diameters. Spheres of larger radius are not looked for: a box that holds one would be large, and the missing part may
        /// as well be a shallow cap.
        largest_sphere: f64 = 1.25,
        /// Nodes along each axis within which of a rim's vertices the zero set is looked for.
        round_rims: i32 = 3,
        /// Nodes from a component of the zero set that touches a rim within which no node is held.
        evolving: usize = 3,
    }
}
