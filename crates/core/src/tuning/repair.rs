//! Thresholds for repairs (`repair`): unions, removal of intersecting faces, triangulations, offset shells, walls, dangling
//! sheets.

thresholds! {
    /// Thresholds for repairs (`repair`).
    RepairTuning {
        /// Rounds of unions, at most: rounded vertices may make faces intersect again.
        union_rounds: usize = 6,
        /// Fraction of the boundary edges as given. If cleaning leaves fewer, they were cracks, and holes are not filled before cleaning:
        /// a tube of 2,500 faces with cracks spent three of four seconds on patches of cracks, which destroyed it.
        cracked_rest: f64 = 0.5,
        /// Pairs of faces whose boxes meet, each counted twice. A union is attempted up to this many: it bounds the time, a few
        /// microseconds each. 1000 boxes in a heap have 0.6 million.
        union_pairs: usize = 20_000_000,
        /// Diagonals of the mesh's bounding box. Shorter edges at new vertices of unions are collapsed: they come from
        /// intersection curves that pass a vertex by a rounding error.
        short_edge: f64 = 1e-9,
        /// Units in the last place of the largest coordinate as a 32-bit float. Bodies that touch up to rounding are grown by at
        /// least this much.
        contact_units: f64 = 8.0,
        /// Faces. With more intersecting faces than this, bodies are grown no further after a growth that changes nothing: each
        /// takes as long as the union.
        growth_faces: usize = 500,
        /// Rounds of a union after the best one.
        vain_rounds: usize = 2,
        /// Factor. If a round of a union leaves more than this many times as many intersecting faces as before, the next one would leave
        /// more still: a torus thicker than its ring went from 144 to 1,500 and 18,000 in a minute.
        union_growth: usize = 2,
        /// Faces. With fewer intersecting faces than this a union goes on, even if they multiply.
        union_growth_faces: usize = 100,
        /// Edges. Longer rims are not closed while bodies are united.
        capped_edges: usize = 300,
        /// Intersecting faces left by all unions, and their fraction of all faces, above which none are cut out.
        left_faces: usize = 200,
        left_part: f64 = 0.1,
        /// A union of the mesh as given is gone on with if at most one of this many intersecting faces is left.
        few_left: usize = 20,
        /// Edges. Where more faces run one way than the other along more edges than this, no faces are added there.
        chain_edges: usize = 2000,
        /// Edges. Longer loops of such edges are left to the fill.
        chain_loop: usize = 60,
        /// Fraction of the area. Larger loops of more than three edges are left to the fill.
        chain_area: f64 = 0.01,
        /// Faces. If each intersecting face intersects more others than this on average, the exact union has thousands of triangles to
        /// classify around one point, and vertices are moved before it: 6,600 pairs of 350 faces at the axis of a torus that is thicker
        /// than its ring took 20 s, and rounding let 4,300 intersect.
        dense_partners: usize = 10,
        /// Fraction of the input's area. A plan without faults that loses less ends the search in meshes of any size.
        little_lost: f64 = 2e-3,
        /// Faces. In larger meshes a plan without faults whose solid agrees ends the search, even if it loses more than
        /// [`Self::doubtful_loss`]: each further plan may take ten seconds.
        settled_faces: usize = 5000,
        /// Lengths by which bodies are grown in turn, each twice the one before, at most.
        growths: usize = 3,
        /// Passes, at most. Each cuts intersecting faces out and fills the holes; each later pass cuts one more ring of faces.
        passes: usize = 2,
        /// Rings of faces, at most, by which a hole is widened that cannot be closed without self-intersections.
        wider: usize = 3,
        /// For patches that intersect other faces, at most one in this many faces of the input is cut out, plus
        /// [`Self::lost_crossing`] for each face that intersected others in the input: caps of sheets inside each other always
        /// intersect.
        lost_part: usize = 30,
        /// Faces cut out for each face that intersected others in the input, at most.
        lost_crossing: usize = 2,
        /// Rings of faces around intersecting faces that are cut out with them.
        rings: usize = 1,
        /// Rounds of edge flips: faces without area may be adjacent.
        clean_rounds: usize = 20,
        /// Edges. Longer rims are first reduced by cutting ears. The memory of a search grows with the cube of their number: 1
        /// MB.
        clear_edges: usize = 200,
        /// Intersecting faces. With more than this, no vertices are moved: it bounds the time.
        relaxed_faces: usize = 50_000,
        /// Rings of faces round intersecting ones. If the faces are connected with these, they are a fold or noise, whose vertices
        /// may move.
        relaxed_rings: usize = 2,
        /// Rounds in which vertices move, at most.
        relaxed_rounds: usize = 60,
        /// The first of these rounds in which vertices on boundaries slide along these.
        sliding_round: usize = 5,
        /// Fraction of the way to the mean of the neighbours by which a vertex moves in a round.
        relaxed_step: f64 = 0.5,
        /// Mean lengths of the edges at a vertex. It moves by this at most.
        relaxed_reach: f64 = 1.5,
        /// Fraction of the intersecting faces of a fold or of noise. If more intersect still, the vertices are put back.
        relaxed_left: f64 = 0.1,
        /// Diagonals of the bounding box. No vertex moves by more than this.
        relaxed_most: f64 = 0.1,
        /// Rounds after which a search is given up; each excludes some triangles. On two scans with rims of hundreds of edges 300
        /// rounds and 450 edges closed no further hole.
        clear_rounds: usize = 60,
        /// Fraction of the size of the coordinates. Faces on one side of a triangle's plane, farther from it than this, do not
        /// intersect it in rounded arithmetic.
        clearly: f64 = 1e-9,
        /// Weight of a diagonal's squared length relative to area: among triangulations of equal area the one with short
        /// diagonals is taken.
        diagonal: f64 = 0.1,
        /// Faces. Components of at most this many faces have no inside.
        small_faces: usize = 2,
        /// Faces of a component that are tested to decide whether it lies inside another.
        samples: usize = 64,
        /// Winding number of the other component. A sample point in front of a face lies inside the other component above this;
        /// half of the points decide.
        inside: f64 = 0.5,
        /// Square roots of the face's area. Distance of the sample points from the face.
        before: f64 = 1e-2,
        /// Mean edges. A sheet covers another one that is at most this far below it.
        cover: f64 = 4.0,
        /// Least cosine between the faces of two such sheets: 60°.
        same_way: f64 = 0.5,
        /// Fraction of a component inside others. Above this the component is kept as an inner one, and its visible part is
        /// removed.
        submerged: f64 = 0.9,
        /// Shortest edges. Depth of an offset shell under the surface.
        shell_depth: f64 = 0.1,
        /// Factor of the depth where the shell intersects anything.
        shell_nearer: f64 = 0.25,
        /// Times that a shell is moved closer to the surface, at most.
        shell_rounds: usize = 5,
        /// Mean edges of the surface. Default thickness of the walls of an open sheet.
        wall: f64 = 1.0,
        /// Fraction of the distance to the next surface below. Upper bound of the depth of a wall.
        room: f64 = 0.8,
        /// Factor of the depth of a wall where it intersects anything, in the first [`Self::wall_steps`] rounds.
        wall_nearer: f64 = 0.7,
        /// Rounds with [`Self::wall_nearer`]; later rounds use the factor of a shell, since only a few places remain.
        wall_steps: usize = 10,
        /// Fraction of the wanted depth. A wall that would have to be thinner anywhere is not made.
        wall_least: f64 = 2e-4,
        /// Times that a wall is made thinner, at most.
        wall_rounds: usize = 24,
        /// Mean edges, or requested thicknesses. Thinner walls made by a repair count as foil where they exceed
        /// [`Self::thin_part`].
        least_wall: f64 = 0.5,
        /// Fraction of a component's surface with walls below [`Self::least_wall`]. A shell has an inner and an outer side: the
        /// fraction is a quarter of the sheet.
        thin_part: f64 = 0.125,
        /// Diameters of the smaller boundary loop. The loops of two sheets are the two sides of one gap where half of the shorter
        /// one is closer to the other than this; otherwise each is capped, or its sheet gets walls.
        gap: f64 = 0.25,
        /// Fraction of a flat cap's area, at least, over which the body under it is not foil; otherwise its sheet gets walls.
        thick_cap: f64 = 0.75,
        /// Steps of the search for a direction into the surface at a vertex, at most; twenty are rarely needed.
        shell_steps: usize = 100,
        /// Faces of an offset shell for one hole, at most; it bounds the time, not the shape.
        shell_faces: usize = 20_000,
        /// Faces of a component that gets an offset shell as a whole, as the last resort, at most.
        shell_whole: usize = 250_000,
        /// Faces of all components that get an offset shell as a whole, at most.
        shell_whole_work: usize = 1_000_000,
        /// Edges. Longer boundary loops are not closed: where hundreds of edges could not be closed at the rim, they seldom can
        /// be farther away.
        shell_edges: usize = 200,
        /// Faces visited by the searches for offset shells of parts of a mesh, at most.
        shell_work: usize = 400_000,
        /// Faces visited for one hole or for the holes of one component, at most.
        shell_work_each: usize = 40_000,
        /// The search for triangles that close a boundary loop counts as the square of its number of edges over this, in visited
        /// faces.
        shell_edges_work: usize = 2,
        /// Square roots of the component's area. An open component with shorter boundary loops counts as closed if it encloses
        /// [`Self::least_volume`].
        short_border: f64 = 1.0,
        /// Area to the power 3/2. Least volume of such a component: 0.094 for a sphere.
        least_volume: f64 = 0.02,
        /// Rounds: each shell adds surface along which further holes can be closed.
        shell_passes: usize = 4,
        /// Times that faces are cut out of surfaces for which no shell can be made, at most.
        shell_cuts: usize = 30,
        /// Fraction of the area of the component that it is attached to. A smaller sheet is a dangling sheet.
        dangling: f64 = 0.01,
        /// Faces. Open sheets inside a solid are looked for among components of at most this many: the work grows with its square.
        sheet_faces: usize = 2000,
        /// Rounds of cuts: each changes which sheets touch.
        sheet_rounds: usize = 8,
        /// Fraction of the input's area. If more is cut out, beside faces inside other bodies, the shape of the result is doubtful.
        doubtful_loss: f64 = 0.02,
        /// Fraction of the volume of the input's and the result's solids together. If more belongs to only one of them, the shape
        /// of the result is doubtful.
        doubtful_difference: f64 = 0.01,
        /// Fraction of area or of volume. A plan that loses more is taken only if all others do.
        destroyed: f64 = 0.1,
        /// Diagonals of the bounding box. A face that was cut out is not lost if the result's surface is this near to its centre.
        replaced: f64 = 1e-3,
        /// Of [`Self::before`]. A sheet that has nothing of the solid within this distance of both sides has no thickness.
        touching: f64 = 1e-4,
        /// Points at which the solids are compared, before those that decide nothing are left out.
        witness_points: usize = 8192,
        /// Diagonals of the bounding box. The box of these points is at least this wide: a flat mesh is compared beside it too.
        least_side: f64 = 0.1,
        /// Distance of a winding number from one half. Points nearer to it decide nothing: they lie near large holes.
        undecided: f64 = 0.1,
        /// Diameters of a hole. Points nearer to its centre decide nothing, unless they are [`Self::deep`] inside: the patch there is
        /// not the input's.
        near_hole: f64 = 0.75,
        /// By how much a winding number exceeds one half deep inside. A half ball has 0.65 at the middle between its pole and centre.
        deep: f64 = 0.2,
        /// Fraction of the bounding box. A mesh with less than this deep inside may be a sheet or a bowl: 0.003 of a scan of an
        /// excavation, 0.2 of half a ball, 0.4 to 0.7 of open housings.
        least_deep: f64 = 0.3,
        /// Diagonals of the mesh's bounding box. Cracks up to this width are closed. Of 24 solids of a program that makes boolean
        /// operations with a tolerance of 1e-5 the widest cracks were 3e-5.
        crack: f64 = 1e-3,
        /// Factor from one width at which cracks are closed to the next.
        crack_growth: f64 = 4.0,
        /// Attempts at each width, at most: each leaves out the vertices at which the one before made faces intersect.
        crack_attempts: usize = 4,
        /// Cosine. Faces at an edge whose angle is below this (60°) lie on each other.
        folded: f64 = 0.5,
        /// Rounds of merging vertices and splitting edges in an attempt, at most.
        crack_rounds: usize = 6,
        /// Rounds of splits at T-junctions, at most: each splits one edge of a face.
        stitch_rounds: usize = 12,
        /// Units in the last place of 32-bit floats. Components no larger than this are points in an output of 32-bit floats: a
        /// body needs several units along each axis.
        point: f64 = 4.0,
        /// The first rounds of separating sheets, in which an edge that cannot be separated at its ends gets a vertex in its
        /// middle.
        halving_rounds: usize = 3,
        /// Shortest edges. Separated vertices are moved apart by this.
        apart: f64 = 1e-3,
        /// Factor of [`Self::apart`] where faces would intersect; then its inverse.
        apart_nearer: f64 = 0.1,
        /// Units in the last place of 32-bit floats. Separated vertices are moved apart by at least this.
        least_apart: f64 = 16.0,
    }
}
