//! Thresholds of the finish of a patch on its own triangles (`finish`).

thresholds! {
    /// Thresholds of the finish of a patch on its own triangles (`finish`).
    FinishTuning {
        /// Upper bound of E_minimum / E_before: a minimum of higher energy is refused.
        energy_rise: f64 = 1.02,
        /// Ratio of energies. A converged minimum below this part of the energy before is taken however far it lies; where the
        /// biharmonic fill is below this part of a minimum's energy, it is the second initialisation. The level set bulges over
        /// holes in walls thinner than 0.35 diameters: of 300 holes of scans and models two were of this kind; their error fell
        /// from 165 to 2.6 ‰ of the diameter.
        much_lower: f64 = 0.5,
        /// Harmonic fills towards a minimal surface, at most.
        minimal_steps: usize = 20,
        /// Diameters. Harmonic fills end when no vertex moves farther than this.
        minimal_tolerance: f64 = 1e-5,
        /// Diameters. Lower bound of an error on the rings.
        least_ring_error: f64 = 1e-6,
        /// Lower bound of a continuation's own part of its error on a ring; the rest is noise of the ring's vertices.
        least_own_error: f64 = 0.3,
        /// Weights fall with this power of the error on the rings. Inverse squares would be the weights of least variance for
        /// uncorrelated errors, but errors on the ring and in the hole are correlated: on 143 holes of scans the error was 0.7 %
        /// lower than with 2, and 6 differed by 0.1 %.
        sharpness: i32 = 4,
        /// Weight of a kriged surface before its errors: up to two are kriged, which are much alike.
        alike_weight: f64 = 0.5,
        /// Mean edges. Upper bound of the width of the ring round a large patch.
        widest_ring: f64 = 4.0,
        /// Widths of that ring. Vertices deeper in a large patch than this stay at the minimum.
        blend_depth: f64 = 2.0,
        /// Points. With fewer, nothing is kriged.
        fewest_data: usize = 15,
        /// Mean edges over which the mismatch of a kriged surface at the rim decays.
        rim_decay: f64 = 1.5,
        /// The biharmonic fill is a candidate where nearly all normals have at least this cosine with their mean (37°): it is the
        /// linear theory of plates and too flat beyond. On 143 holes of scans it made patches that bend more worse by 2 %.
        slight_cosine: f64 = 0.8,
        /// Part of the normals that may be steeper than [`Self::slight_cosine`].
        steeper_part: f64 = 0.02,
        /// A chart is refused when more than this part of the normals has a smaller cosine than [`Self::chart_cosine`].
        chart_outliers: f64 = 0.02,
        /// Least cosine of a normal with the direction of a chart: 75.5°.
        chart_cosine: f64 = 0.25,
        /// Rounds of the robust fit of a sphere.
        chart_rounds: usize = 3,
        /// Medians of the residuals above which a residual has less weight: 1.5 standard deviations.
        chart_robust: f64 = 1.5 * 1.4826,
        /// Diameters, root mean square. Points closer to a sphere than this lie on it.
        on_sphere: f64 = 1e-6,
        /// Diameters. Spheres of larger radius are taken for planes: rounding hides their curvature.
        farthest_sphere: f64 = 100.0,
        /// Diameters. Added to the median residual: exact spheres have none.
        chart_exact: f64 = 1e-12,
        /// Lower bound of a face's area over the largest one's, in divisions by it.
        least_face: f64 = 1e-12,
        /// Lower bound of a vertex's area over the median one.
        least_vertex: f64 = 1e-3,
        /// Part of the kernel's largest eigenvalue that is added to the noise, so that the system can be solved.
        kriging_ridge: f64 = 1e-10,
        /// Edges. Least width of the neighbourhood of a patch.
        rings: usize = 4,
        /// Mean edges by which the neighbourhood is wider than the data, for the normals there.
        data_margin: f64 = 3.0,
        /// Diameters. Least length of an edge in distances.
        least_edge: f64 = 1e-12,
        /// Points. Up to this many their diameter is that of all pairs; above, it is found by going to the farthest point
        /// repeatedly.
        all_pairs: usize = 1500,
        /// Diameters. Width of the collar that data are taken from. On 12 holes of scans 0.32 made patches 4 % worse, 0.63 changed
        /// less than 1 %.
        collar: f64 = 0.45,
        /// Error of slope on the ring of a median patch, where no ring could be tested.
        median_slope: f64 = 0.25,
        /// Mean edges. Upper bound of the displacement of a vertex in a step.
        longest_step: f64 = 2.0,
        /// Diameters. Vertices are spread along the surface as long as steps are longer than this.
        spread_above: f64 = 5e-3,
        /// Part of the way to the mean of its neighbours that a vertex is spread.
        spread: f64 = 0.3,
        /// Halvings of a step, at most.
        halvings: usize = 5,
        /// Steps are extrapolated where the cosine of the angle between one and the next is above this,
        alike_cosine: f64 = 0.98,
        /// Steps for which a large patch may stay folded.
        most_folded_steps: usize = 3,
        /// Vertices. Of larger patches the roughness in the system is bounded. On 143 holes of scans the same for smaller ones
        /// made errors larger by 0.3 %.
        many_vertices: usize = 1200,
        /// Diameters. Width of the strip along the rim of a large patch that is filled anew before the first step.
        strip: f64 = 0.1,
        /// Times that the vertices of folded faces are moved to unfold them, at most.
        unfoldings: usize = 10,
        /// Part of the diagonal of the Hessian that is added to it.
        willmore_ridge: f64 = 1e-10,
        /// ½∫h². Minima below this get no second initialisation: a hemisphere has 4π, and every initialisation found minima below
        /// that.
        second_start_bent: f64 = 8.0,
        /// A face is folded when the cosines of its normal with those at its corners are all below this. On patches of scans this
        /// found all that intersected themselves and no others.
        folded_cosine: f64 = -0.2,
        /// Diameters. Largest radius of a sphere as chart of a kriged surface. Another sphere, from a collar of 0.6 diameters,
        /// made 143 holes of scans worse by 0.5 %, those that hardly bend by 3 %, and took a third of the time.
        largest_sphere: f64 = 4.0,
        /// Lower bound of the cotangent of a corner: of larger angles (153°) the weights would spoil the systems.
        least_cotangent: f64 = -2.0,
        /// Upper bound of the cotangent of a corner: 7°.
        largest_cotangent: f64 = 8.0,
        /// Diameters. The narrow ring of the test: known vertices nearer to the rim than this. It tests the rim alone; the wide
        /// one has more data where there is noise. Each alone left errors larger by 0.7 to 1.5 % on 143 holes of scans.
        narrow_ring: f64 = 0.06,
        /// Mean edges. Least width of the narrow ring: just above 1, so that it holds the first ring of vertices of a small hole and no
        /// other. On four holes of scans 0.7, with which the ring of a small hole is empty, made the error larger by 9.5 %, 1.4 by
        /// 4.6 %.
        narrow_ring_edges: f64 = 1.01,
        /// Diameters. Width of the wide ring of the test. On 12 holes of scans 0.08 made patches 3 % worse, 0.17 changed less than
        /// 1 %.
        wide_ring: f64 = 0.12,
        /// Mean edges. Least width of the wide ring.
        wide_ring_edges: f64 = 1.5,
        /// Diameters. A step shorter than this and than [`Self::always_below_edges`] is taken though the energy rises: at
        /// rounding, or by the spread of the vertices.
        always_below: f64 = 2e-3,
        /// Mean edges, for the same.
        always_below_edges: f64 = 0.04,
        /// Least ratio of a step to the one before for an extrapolation.
        shrinking_least: f64 = 0.5,
        /// Largest ratio of a step to the one before for an extrapolation.
        shrinking_most: f64 = 0.96,
        /// Factor `a` of the expected error `a bᵏ d̄ᵖ √((d/d̄)² + f²)` from the deviation `d` of kriging and the bend `b`: a
        /// regression over 80 holes of eleven meshes, such that 0.70 of the vertices of a mean hole are nearer to the truth than
        /// it.
        kriged_error: f64 = 0.25,
        /// Its exponent `k`.
        kriged_error_bend: f64 = 0.15,
        /// Its exponent `p`.
        kriged_error_deviation: f64 = 0.65,
        /// Its floor `f`.
        kriged_error_floor: f64 = 0.33,
        /// Factor `a` of the expected error `a bᵏ sᵖ √(u² + f²)` from the error of slope `s` on the ring and the depth `u`, where
        /// nothing could be kriged: a regression over 48 holes.
        ring_error: f64 = 0.13,
        /// Its exponent `k`.
        ring_error_bend: f64 = 0.2,
        /// Its exponent `p`.
        ring_error_slope: f64 = 0.45,
        /// Its floor `f`.
        ring_error_floor: f64 = 0.15,
    }
}
