//! Thresholds of repairs (`repair`).

thresholds! {
    /// Thresholds of repairs (`repair`).
    RepairTuning {
        /// Rounds of unions at most: rounded vertices may let faces intersect again.
        union_rounds: usize = 6,
        /// Pairs of faces whose boxes meet for which a union is tried, each counted twice: a matter of time, a few microseconds each. 1000
        /// boxes in a heap have 0.6 million.
        union_pairs: usize = 20_000_000,
        /// Diagonals of the mesh's box. Edges of new vertices of unions that are shorter are taken out: they come from curves that pass a
        /// vertex by a rounding error.
        short_edge: f64 = 1e-9,
        /// Units in the last place of the largest coordinate as a 32-bit float. Bodies that touch but for rounding grow by so much at least.
        contact_units: f64 = 8.0,
        /// Lengths by which they grow that are tried, each twice the one before, at most.
        growths: usize = 3,
        /// Times that faces which intersect others are cut out and filled, with one more ring of faces each time, at most.
        passes: usize = 2,
        /// Rings of faces by which holes that nothing closes without intersections are widened, at most.
        wider: usize = 3,
        /// For patches that intersect others one in this many faces of the input is cut out at most, and [`Self::lost_crossing`]
        /// times those that intersected others in the input: caps of sheets that lie in each other cannot but intersect.
        lost_part: usize = 30,
        /// Faces cut out for each that intersected others in the input, at most.
        lost_crossing: usize = 2,
        /// Rings of faces round intersecting ones that are cut out with them.
        rings: usize = 1,
        /// Rounds of edge turns: faces without area may lie side by side.
        clean_rounds: usize = 20,
        /// Edges. Longer rims are first reduced by cutting ears. The memory of a search grows with the cube of it: 1 MB.
        clear_edges: usize = 200,
        /// Rounds after which a search is given up; each rules some triangles out. On two scans with rims of hundreds of edges
        /// 300 rounds and 450 edges closed no hole more.
        clear_rounds: usize = 60,
        /// Part of the size of coordinates by which faces on one side of a triangle's plane are far enough from it not to
        /// intersect it in rounded numbers.
        clearly: f64 = 1e-9,
        /// Weight of the square of a diagonal's length beside the area: of triangulations of one area that with short diagonals
        /// is taken.
        diagonal: f64 = 0.1,
        /// Faces. Components of this many have no inside.
        small_faces: usize = 2,
        /// Faces of a component that are tested to say whether it lies inside another.
        samples: usize = 64,
        /// Winding number of the other component above which a point before a face lies inside it; half of the points decide.
        inside: f64 = 0.5,
        /// Roots of the face's area. Distance of those points from the face.
        before: f64 = 1e-2,
        /// Mean edges. A layer covers another one that is no farther below it than this.
        cover: f64 = 4.0,
        /// Least cosine between the faces of two layers: 60°.
        same_way: f64 = 0.5,
        /// Part of a component inside others above which the component is kept for what it is and its visible part is removed.
        submerged: f64 = 0.9,
        /// Shortest edges. Depth of an offset shell under the surface.
        shell_depth: f64 = 0.1,
        /// Factor of the depth where the shell intersects anything.
        shell_nearer: f64 = 0.25,
        /// Times that a shell comes nearer to the surface, at most.
        shell_rounds: usize = 5,
        /// Mean edges of the surface. Thickness of the walls that an open sheet gets, where none is asked for.
        wall: f64 = 1.0,
        /// Part of the distance to the next surface under it that the depth of a wall is at most.
        room: f64 = 0.8,
        /// Factor of the depth of a wall where it intersects anything, the first
        wall_nearer: f64 = 0.7,
        /// times; later it is that of a shell, since what is left is a matter of few places.
        wall_steps: usize = 10,
        /// Part of the depth that was wanted. A wall that would have to be thinner anywhere is none.
        wall_least: f64 = 2e-4,
        /// Times that a wall gets thinner, at most.
        wall_rounds: usize = 24,
        /// Mean edges, and thicknesses that were asked for. Walls made by a repair that are thinner count as foil,
        least_wall: f64 = 0.5,
        /// where they make up this part of their component's surface. A shell has its inner side and its outer one: a quarter of the sheet.
        thin_part: f64 = 0.125,
        /// Diameters of the smaller one. Borders of two sheets are the sides of one gap where half of the shorter one is nearer to the other
        /// than this; else each is capped, or its sheet gets walls.
        gap: f64 = 0.25,
        /// Part of a flat cap's area at which the body under it is not foil, at least: else its sheet gets walls.
        thick_cap: f64 = 0.75,
        /// Steps of the search for a direction into the surface at a vertex, at most; twenty are rarely needed.
        shell_steps: usize = 100,
        /// Faces lined for the sake of one hole, at most; a matter of time, not of shape.
        shell_faces: usize = 20_000,
        /// Faces of a component that is lined as a whole, as the last resort, at most.
        shell_whole: usize = 250_000,
        /// Faces of all components that are lined as a whole, at most.
        shell_whole_work: usize = 1_000_000,
        /// Edges. Borders with more are not closed: where hundreds of edges could not be closed at the rim, they seldom can be
        /// farther on.
        shell_edges: usize = 200,
        /// Faces visited by the searches for offset shells of parts of a mesh, at most.
        shell_work: usize = 400_000,
        /// Faces visited for one hole or the holes of one component, at most.
        shell_work_each: usize = 40_000,
        /// The search for triangles that close a border costs as much as the square of its edges over this many faces.
        shell_edges_work: usize = 2,
        /// Roots of its area. An open component whose borders are shorter counts as closed if it encloses [`Self::least_volume`].
        short_border: f64 = 1.0,
        /// Powers 3/2 of its area. Least volume of such a component: 0.094 for a sphere.
        least_volume: f64 = 0.02,
        /// Rounds: each shell adds surface along which further holes can be closed.
        shell_passes: usize = 4,
        /// Times that faces are cut out of surfaces which no shell can be made of, at most.
        shell_cuts: usize = 30,
        /// Part of the area of the component it hangs on, below which a sheet is a dangling sheet.
        dangling: f64 = 0.01,
        /// Rounds of cuts: each changes which sheets touch.
        sheet_rounds: usize = 8,
        /// Rounds of splits at T-junctions, at most: each splits one edge of a face.
        stitch_rounds: usize = 12,
        /// Units in the last place of 32-bit floats. Components that measure no more are points in an output of these: a body needs
        /// several units along each axis.
        point: f64 = 4.0,
        /// The first of these rounds, in which edges that cannot be separated at their ends get a vertex between them.
        halving_rounds: usize = 3,
        /// Shortest edges. Separated vertices are moved apart by this,
        apart: f64 = 1e-3,
        /// and by at least this many units in the last place of 32-bit floats.
        least_apart: f64 = 16.0,
    }
}
