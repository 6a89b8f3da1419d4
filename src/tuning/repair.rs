//! Thresholds of repairs (`repair`).

thresholds! {
    /// Thresholds of repairs (`repair`).
    RepairTuning {
        /// Maximum number of union rounds: rounded vertices may let faces intersect again.
        union_rounds: usize = 6,
        /// Pairs of faces whose boxes intersect, each counted twice, up to which a union is attempted; a limit of time, a few
        /// microseconds per pair. 1000 boxes in a heap have 0.6 million.
        union_pairs: usize = 20_000_000,
        /// Diagonals of the mesh's bounding box. Edges of new union vertices shorter than this are collapsed: they come from
        /// curves that pass a vertex by a rounding error.
        short_edge: f64 = 1e-9,
        /// Units in the last place of the largest coordinate as a 32-bit float. Smallest growth of bodies that touch except for
        /// rounding.
        contact_units: f64 = 8.0,
        /// Maximum number of growth lengths that are tried, each twice the one before.
        growths: usize = 3,
        /// Maximum number of passes that cut out intersecting faces and fill the holes, each with one more ring of faces.
        passes: usize = 2,
        /// Rings of faces. Maximum widening of holes that cannot be closed without self-intersections.
        wider: usize = 3,
        /// Because of intersecting patches at most one in this many input faces is cut out, plus [`Self::lost_crossing`] times
        /// the input's intersecting faces: caps of sheets that overlap each other must intersect.
        lost_part: usize = 30,
        /// Maximum number of faces cut out for each intersecting face of the input.
        lost_crossing: usize = 2,
        /// Rings of faces round intersecting faces that are cut out with them.
        rings: usize = 1,
        /// Maximum number of rounds of edge flips: faces without area may be adjacent.
        clean_rounds: usize = 20,
        /// Edges. Longer rims are first shortened by cutting ears. The memory of a search grows with the cube of this: 1 MB.
        clear_edges: usize = 200,
        /// Rounds after which the search for a rim triangulation is abandoned; each rules out some triangles. On two scans with
        /// rims of hundreds of edges, 300 rounds and 450 edges closed no further hole.
        clear_rounds: usize = 60,
        /// Relative to the size of coordinates: distance of a face from a triangle's plane above which it cannot intersect the
        /// triangle in spite of rounding.
        clearly: f64 = 1e-9,
        /// Weight of a diagonal's squared length relative to the area: of triangulations of equal area the one with short
        /// diagonals is taken.
        diagonal: f64 = 0.1,
        /// Faces. Components of at most this many faces enclose nothing.
        small_faces: usize = 2,
        /// Number of faces of a part that are tested to decide whether it lies inside another surface.
        samples: usize = 64,
        /// Winding number above which a point in front of a face is inside another surface; the majority of points decides.
        inside: f64 = 0.5,
        /// Square roots of the face's area. Distance of these points from the face.
        before: f64 = 1e-2,
        /// Mean edges. Maximum distance at which one surface covers another.
        cover: f64 = 4.0,
        /// Least cosine between the normals of two surfaces of which one covers the other: 60°.
        same_way: f64 = 0.5,
        /// Fraction of a component's area inside others above which its inner part is kept and its visible part is removed.
        submerged: f64 = 0.9,
        /// Shortest local edges. Depth of an offset shell below the surface.
        shell_depth: f64 = 0.1,
        /// Factor that reduces the depth where the shell intersects anything.
        shell_nearer: f64 = 0.25,
        /// Maximum number of depth reductions of a shell.
        shell_rounds: usize = 5,
        /// Mean edges of the surface. Default thickness of the walls of an open sheet.
        wall: f64 = 1.0,
        /// Fraction of the distance to the next surface below: upper bound of a wall's depth.
        room: f64 = 0.8,
        /// Factor that reduces the depth of a wall where it intersects anything, in the first `wall_steps` reductions.
        wall_nearer: f64 = 0.7,
        /// Number of reductions by `wall_nearer`; later ones use `shell_nearer`, since few places remain.
        wall_steps: usize = 10,
        /// Fraction of the wanted depth. A wall that would have to be thinner anywhere is rejected.
        wall_least: f64 = 2e-4,
        /// Maximum number of depth reductions of a wall.
        wall_rounds: usize = 24,
        /// Mean edges, or requested thicknesses if smaller. Walls made by a repair that are thinner than this count as thin.
        least_wall: f64 = 0.5,
        /// Fraction of a component's area with thin walls above which the walls count as foil. A shell has an inner and an outer
        /// side, so this is a quarter of the sheet.
        thin_part: f64 = 0.125,
        /// Diameters of the smaller border. The borders of two sheets are the sides of one gap if half of the shorter one is
        /// nearer to the other than this; otherwise each gets a cap, or its sheet gets walls.
        gap: f64 = 0.25,
        /// Least fraction of a flat cap's area above parts of the body that are not foil: otherwise the sheet gets walls.
        thick_cap: f64 = 0.75,
        /// Maximum number of steps of the search for an inward direction at a vertex; twenty are rarely needed.
        shell_steps: usize = 100,
        /// Maximum number of faces of an offset shell for one hole; limits time, not shape.
        shell_faces: usize = 20_000,
        /// Maximum number of faces of a component that gets a whole offset shell, the last resort.
        shell_whole: usize = 250_000,
        /// Maximum number of faces of all whole offset shells together.
        shell_whole_work: usize = 1_000_000,
        /// Edges. Longer loops of a shell are not closed: where hundreds of edges could not be closed at the rim, they seldom can
        /// be farther away.
        shell_edges: usize = 200,
        /// Maximum number of faces visited by the searches for partial offset shells.
        shell_work: usize = 400_000,
        /// Maximum number of faces visited for one hole, or for the holes of one component together.
        shell_work_each: usize = 40_000,
        /// Closing a loop costs its squared number of edges divided by this, counted as visited faces.
        shell_edges_work: usize = 2,
        /// Square roots of the component's area. An open component with shorter boundary counts as closed if it encloses
        /// [`Self::least_volume`].
        short_border: f64 = 1.0,
        /// Area to the power 3/2. Least volume of such a component; a sphere has 0.094.
        least_volume: f64 = 0.02,
        /// Maximum number of rounds of offset shells: each shell adds surface along which further holes can be closed.
        shell_passes: usize = 4,
        /// Maximum number of places where blocking faces are cut out so that a shell can be made.
        shell_cuts: usize = 30,
        /// Fraction of the host component's area below which a sheet counts as a dangling sheet.
        dangling: f64 = 0.01,
        /// Maximum number of rounds of separations and cuts: each changes which sheets touch.
        sheet_rounds: usize = 8,
        /// Maximum number of rounds of T-junction splits: each splits one edge per face.
        stitch_rounds: usize = 12,
        /// Units in the last place of 32-bit floats. Components of at most this size are points in 32-bit output: a body needs
        /// several units along each axis.
        point: f64 = 4.0,
        /// In this many first rounds non-manifold edges whose ends cannot be separated get a vertex in the middle.
        halving_rounds: usize = 3,
        /// Shortest local edges. Displacement of separated vertices, but not below `least_apart`.
        apart: f64 = 1e-3,
        /// Units in the last place of 32-bit floats. Least displacement of separated vertices and least depth of an offset shell.
        least_apart: f64 = 16.0,
    }
}
