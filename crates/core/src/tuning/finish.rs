//! Thresholds for the finish of a patch on its own triangles (`finish`): Gauss-Newton steps, kriging, blending, expected error.

thresholds! {
    /// Thresholds for the finish of a patch on its own triangles (`finish`).
    FinishTuning {
        /// Upper bound of E_minimum / E_before: a minimum with a higher energy is refused.
        energy_rise: f64 = 1.02,
        /// Ratio of energies. A converged minimum below this fraction of the energy before it is taken however far it moved.
        /// Where the biharmonic fill is below this fraction of a minimum's energy, it is the second initialisation. The level set
        /// bulges over holes in walls thinner than 0.35 diameters: two of 300 holes of scans and models were of this kind; their
        /// error fell from 165 to 2.6 ‰ of the diameter.
        much_lower: f64 = 0.5,
        /// Harmonic fills towards a minimal surface, at most.
        minimal_steps: usize = 20,
        /// Diameters. Harmonic fills have converged when no vertex moves farther than this.
        minimal_tolerance: f64 = 1e-5,
        /// Diameters. Lower bound of an error on the rings.
        least_ring_error: f64 = 1e-6,
        /// Fraction of a continuation's error on a ring. After the noise of the ring's vertices is subtracted, at least this
        /// fraction remains.
        least_own_error: f64 = 0.3,
        /// Exponent: weights are the inverse of this power of the error on the rings. Inverse squares would have the least
        /// variance if errors were uncorrelated, but errors on the ring and in the hole are correlated: on 143 holes of scans the
        /// error was 0.7 % lower than with 2; 6 differed by 0.1 %.
        sharpness: i32 = 4,
        /// Factor of the expected error of a large patch that has a continuation: on 32 rims of 16 defects of a skull 0.74 of the vertices of
        /// a patch were nearer to the bone than 0.6 of the expected error without it, 0.95 than twice this.
        large_error: f64 = 0.6,
        /// Weight of the kriged surface of a large patch; the energy's minimum has the rest. On 16 defects of a skull the Dice coefficient of
        /// the implant was 0.939 with the minimum alone and 0.944 with 0.6.
        large_kriged: f64 = 0.6,
        /// Diameters. Width of the collar to which the sphere of a large patch is fitted.
        large_chart: f64 = 0.15,
        /// Diameters. Width of the collar from which the data of a large patch are taken. On 13 defects of a skull the
        /// Dice coefficient of the kriged surface alone differed by 0.001 in the mean with 0.2.
        large_collar: f64 = 0.12,
        /// Least cosine between the normal of a datum of a large patch and the direction of the chart: 60°.
        large_facing: f64 = 0.5,
        /// Prior weight of a kriged surface in the blend: there are up to two, and they are nearly alike.
        alike_weight: f64 = 0.5,
        /// Mean edges. Upper bound of the width of the ring around a large patch.
        widest_ring: f64 = 4.0,
        /// Widths of that ring. Vertices deeper in a large patch than this stay at the energy's minimum.
        blend_depth: f64 = 2.0,
        /// Points. With fewer data nothing is kriged.
        fewest_data: usize = 15,
        /// Mean edges. The mismatch of a kriged surface at the rim decays over this distance.
        rim_decay: f64 = 1.5,
        /// Cosine (37°). The biharmonic fill is a candidate where nearly all normals are within this angle of their mean: it is
        /// the linear plate theory and too flat beyond. On 143 holes of scans it made more strongly bent patches worse by 2 %.
        slight_cosine: f64 = 0.8,
        /// Fraction of the normals that may be steeper than [`Self::slight_cosine`].
        steeper_part: f64 = 0.02,
        /// Fraction of the normals. A chart is refused when more of them than this have a smaller cosine than
        /// [`Self::chart_cosine`].
        chart_outliers: f64 = 0.02,
        /// Least cosine between a normal and the direction of a chart: 75.5°.
        chart_cosine: f64 = 0.25,
        /// Rounds of the robust sphere fit.
        chart_rounds: usize = 3,
        /// Medians of the residuals. Larger residuals are down-weighted: 1.5 standard deviations.
        chart_robust: f64 = 1.5 * 1.4826,
        /// Diameters, root mean square. Points closer to a sphere than this lie on it.
        on_sphere: f64 = 1e-6,
        /// Diameters. Spheres with larger radius are treated as planes: rounding hides their curvature.
        farthest_sphere: f64 = 100.0,
        /// Diameters. Added to the median residual, which is zero on exact spheres.
        chart_exact: f64 = 1e-12,
        /// Lower bound of a face's area over the largest face's area where it is a divisor.
        least_face: f64 = 1e-12,
        /// Lower bound of a vertex's area over the median vertex area.
        least_vertex: f64 = 1e-3,
        /// Fraction of the kernel's largest eigenvalue. Added to the noise so that the system can be solved.
        kriging_ridge: f64 = 1e-10,
        /// Rings of edges. Least width of the neighbourhood of a patch.
        rings: usize = 4,
        /// Mean edges. The neighbourhood is wider than the data by this, so that normals are known at the data.
        data_margin: f64 = 3.0,
        /// Diameters. Lower bound of an edge length in distances along edges.
        least_edge: f64 = 1e-12,
        /// Points. Up to this many points their diameter is the maximum over all pairs; above, it is found by repeatedly going to
        /// the farthest point.
        all_pairs: usize = 1500,
        /// Diameters. Width of the collar from which data are taken. On 12 holes of scans 0.32 made patches 4 % worse, 0.63
        /// changed less than 1 %.
        collar: f64 = 0.45,
        /// Slope error on the ring of a median patch; used where no ring could be tested.
        median_slope: f64 = 0.25,
        /// Mean edges. Upper bound of the displacement of a vertex in one step.
        longest_step: f64 = 2.0,
        /// Diameters. After a step longer than this, vertices are spread along the surface.
        spread_above: f64 = 5e-3,
        /// Fraction of the way to the mean of its neighbours by which a vertex is spread.
        spread: f64 = 0.3,
        /// Halvings of a step, at most.
        halvings: usize = 5,
        /// Cosine. Steps are extrapolated where the angle between two successive steps has a larger cosine.
        alike_cosine: f64 = 0.98,
        /// Steps. A large patch may stay folded for this many steps in a row.
        most_folded_steps: usize = 3,
        /// Vertices. For larger patches the roughness that enters the system is bounded. On 143 holes of scans the bound made the
        /// errors of smaller patches larger by 0.3 %.
        many_vertices: usize = 1200,
        /// Diameters. Width of the strip along the rim of a large patch that is filled biharmonically before the first step.
        strip: f64 = 0.1,
        /// Times that the vertices of folded faces are moved to unfold them, at most.
        unfoldings: usize = 10,
        /// Fraction of the Hessian's diagonal that is added to it.
        willmore_ridge: f64 = 1e-10,
        /// ½∫h². Minima below this get no second initialisation: a hemisphere has 4π, and below that every initialisation led to
        /// a minimum.
        second_start_bent: f64 = 8.0,
        /// Cosine. A face is folded when the cosines between its normal and the normals at its corners are all below this. On
        /// patches of scans this found all self-intersecting patches and no others.
        folded_cosine: f64 = -0.2,
        /// Diameters. Largest radius of a sphere as the chart of a kriged surface. A second sphere, fitted to a collar of 0.6
        /// diameters, made 143 holes of scans worse by 0.5 %, nearly flat ones by 3 %, and took a third of the time.
        largest_sphere: f64 = 4.0,
        /// Lower bound of a corner's cotangent: larger angles (153°) would make the systems ill-conditioned.
        least_cotangent: f64 = -2.0,
        /// Upper bound of a corner's cotangent: 7°.
        largest_cotangent: f64 = 8.0,
        /// Diameters. Width of the narrow test ring: known vertices closer to the rim than this. It tests the rim alone; the wide
        /// ring has more data where there is noise. With either ring alone errors were larger by 0.7 to 1.5 % on 143 holes of
        /// scans.
        narrow_ring: f64 = 0.06,
        /// Mean edges. Least width of the narrow ring: just above 1, so that it holds the first ring of vertices of a small hole
        /// and no other. On four holes of scans 0.7, which leaves the ring of a small hole empty, made the error larger by 9.5 %,
        /// 1.4 by 4.6 %.
        narrow_ring_edges: f64 = 1.01,
        /// Diameters. Width of the wide test ring. On 12 holes of scans 0.08 made patches 3 % worse, 0.17 changed less than 1 %.
        wide_ring: f64 = 0.12,
        /// Mean edges. Least width of the wide ring.
        wide_ring_edges: f64 = 1.5,
        /// Diameters. A step shorter than this and than [`Self::always_below_edges`] is taken even if the energy rises, as it may
        /// by rounding or by the spreading of vertices.
        always_below: f64 = 2e-3,
        /// Mean edges. See [`Self::always_below`].
        always_below_edges: f64 = 0.04,
        /// Least ratio of a step to the one before for an extrapolation.
        shrinking_least: f64 = 0.5,
        /// Largest ratio of a step to the one before for an extrapolation.
        shrinking_most: f64 = 0.96,
        /// Factor `a` of the expected error `a bᵏ d̄ᵖ √((d/d̄)² + f²)`, where `d` is the kriging standard deviation, `d̄` its
        /// mean and `b` the bend: a regression over 80 holes of eleven meshes, fitted so that in the mean hole 0.70 of the
        /// vertices are closer to the true surface than the expected error.
        kriged_error: f64 = 0.25,
        /// Exponent `k` in the same formula.
        kriged_error_bend: f64 = 0.15,
        /// Exponent `p` in the same formula.
        kriged_error_deviation: f64 = 0.65,
        /// Floor `f` in the same formula.
        kriged_error_floor: f64 = 0.33,
        /// Factor `a` of the expected error `a bᵏ sᵖ √(u² + f²)`, where `s` is the slope error on the ring and `u` the depth;
        /// used where nothing could be kriged: a regression over 48 holes.
        ring_error: f64 = 0.13,
        /// Exponent `k` in that formula.
        ring_error_bend: f64 = 0.2,
        /// Exponent `p` in that formula.
        ring_error_slope: f64 = 0.45,
        /// Floor `f` in that formula.
        ring_error_floor: f64 = 0.15,
    }
}
