//! Thresholds for regions (`region`): grouping of holes, grid resolution, box size, the nested solve.

thresholds! {
    /// Thresholds for regions (`region`): grouping of holes, grid resolution, box size, the nested solve.
    RegionTuning {
        /// Diameters of the larger rim. Rims that face each other belong to one opening up to this gap.
        facing_gap: f64 = 1.0,
        /// Diameters of the smaller rim. Rims closer than this share a region.
        near_gap: f64 = 0.1,
        /// Rims. Upper bound of the larger rims that a rim is compared with. In a mesh of loose triangles all rims are near all
        /// others; in scans a rim has a few neighbours.
        most_nearby: usize = 128,
        /// Edge midpoints of each rim that are compared, at most.
        rim_samples: usize = 240,
        /// Voxels across a hole.
        across: f64 = 32.0,
        /// Voxels across a hole where the patch is finished on its own triangles. On 143 holes of scans finished patches with 12
        /// and a margin of 6 nodes were 1.3 % farther from the true surface, with 24 and more no closer.
        across_coarse: f64 = 16.0,
        /// Edges. A single rim of at most this many edges is simple: its patch has about fifty vertices, for which coarser voxels
        /// suffice.
        short_rim: usize = 25,
        /// Edges. A single rim of at most this many edges is simple if the surface around it bends little.
        medium_rim: usize = 60,
        /// Sine of the angle between the surface around a hole and the plane of its rim. Up to this angle the surface bends little.
        /// Patches that bend more had other, wrong shapes with coarser voxels, with seams three times as sharp.
        slight_tilt: f64 = 0.5,
        /// Voxels across a hole with a simple rim whose patch is finished. On 99 holes of scans with at most 60 edges patches were
        /// as close to the true surface as with 16 and a margin of 7 nodes; with 8 or 12 they were 1 % farther from it.
        across_simple: f64 = 10.0,
        /// Ratio of diameter to width. Slots are resolved across their width up to this ratio; where the patch is finished,
        /// across the geometric mean of both: on 143 holes of scans that gave patches as close to the true surface in three
        /// quarters of the time.
        narrowest: f64 = 2.0,
        /// Voxels across a hole on the coarsest level.
        coarsest: f64 = 16.0,
        /// Voxels across the smallest loop of a region of several loops, at least.
        across_smallest: f64 = 14.0,
        /// Voxels across a hole in a finer retry, at most, unless the first attempt had more.
        across_retry: f64 = 72.0,
        /// Voxels across a hole where the voxel is chosen automatically, at most.
        across_limit: f64 = 160.0,
        /// Voxels across a hole where the voxel is given, at most.
        finest: f64 = 1024.0,
        /// Widths of the widest hole. Free space around the rims.
        margin_part: f64 = 0.5,
        /// Coarse voxels. Free space around the rims in addition to [`Self::margin_part`].
        margin_nodes: f64 = 7.0,
        /// The same for a simple rim whose patch is finished. With 4 patches were 1 % farther from the true surface.
        margin_simple: f64 = 5.0,
        /// Blocks of nodes in a box on its coarsest level, at most: 16 million nodes. The box of a hole has about 1300, the box
        /// of facing rims a few diameters apart up to 1e5.
        most_blocks: f64 = 2.5e5,
        /// Blocks of nodes in a box on its coarsest level. Above this, four times the count of a round hole, the box gets a
        /// coarser level if the hole is wide enough there.
        many_blocks: f64 = 5000.0,
        /// Extents of the rims along an axis. The margin of [`Self::margin_part`] is reduced by this along that axis.
        margin_taken: f64 = 0.35,
        /// Widths of the widest hole. Lower bound of the margin.
        least_margin: f64 = 0.15,
        /// Finer voxels. Blocks farther than this from the coarse surface are not stored.
        stored: f64 = 8.0,
        /// Voxels. Nodes farther than this from the initial surface are not pulled.
        pulled: f64 = 8.0,
        /// Relative residual of the biharmonic fill that initialises the flow.
        start_tolerance: f64 = 3e-3,
        /// Steps on a coarser level, at most.
        coarse_steps: usize = 14,
        /// Ratio of the tolerance on a coarser level to the tolerance on the finest.
        coarse_tolerance: f64 = 20.0,
        /// Voxels. Upper bound of the tolerance on a coarser level, unless the tolerance on the finest is larger.
        most_coarse_tolerance: f64 = 0.4,
        /// Voxels. A level whose last update was longer than this is far from converged.
        far_from_converged: f64 = 0.05,
        /// Ratio of the energy at the start of a level to the energy at the end of the coarser one. Above this, if the latter was
        /// above [`Self::energy_blowup_least`], the data are inconsistent: the energy of a surface tends to a limit as voxels
        /// shrink. Of 577 levels of 52 meshes all with such a start belonged to regions that ended without a surface.
        energy_blowup: f64 = 3.0,
        /// Energy at the end of the coarser level. Lower bound for the test of [`Self::energy_blowup`].
        energy_blowup_least: f64 = 300.0,
        /// Rim radii, and half widths of the hole. Deep nodes are free within this distance of the rim's centre and, in half
        /// widths, of the rim.
        deep_reach: f64 = 1.3,
        /// Voxels. A node near a hole that is farther than this from the known surface is a deep node: it may be free although a
        /// rim is not the nearest part of the surface.
        deep: f64 = 5.5,
        /// Voxels. Upper bound of the distance between a node and the nearest coarser node, with a margin for the difference
        /// between the triangles and the smooth surface.
        spacing: f64 = 2.0,
        /// Diameters, root mean square over positions and normals. Rims closer to a sphere than this lie on it.
        sphere_fits: f64 = 0.05,
        /// Diameters. Spheres with larger radius are not considered: their box would be large, and the missing part may as well
        /// be a shallow cap.
        largest_sphere: f64 = 1.25,
        /// Nodes along each axis. The zero set that meets a rim is searched within this distance of the rim's vertices.
        round_rims: i32 = 3,
        /// Nodes. No node is held fixed within this distance of a component of the zero set that touches a rim.
        evolving: usize = 3,
    }
}
