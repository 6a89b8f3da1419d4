//! Thresholds for outputs beside the mended mesh (`job`): patch colours, separate parts, error tolerances.

thresholds! {
    /// Thresholds for outputs beside the mended mesh (`job`): patch colours, separate parts, error tolerances.
    DeliverTuning {
        /// Mean edge lengths of the patch. Lower bound of the stripe width on hatched patches: vertex colours cannot show finer
        /// stripes.
        stripe_edges: f64 = 2.5,
        /// Number of stripes across a patch, at most.
        stripes: f64 = 24.0,
        /// Fraction of the volume of the part's largest component. Smaller components are left out: where a patch and the removed
        /// faces are the same surface up to noise, there are thin slivers between them.
        piece_part: f64 = 1e-3,
        /// Fraction of a patch. A hole is listed if more of its patch than this may be farther off than the tolerance.
        beyond_part: f64 = 0.05,
        /// Expected errors. This multiple of a vertex's expected error has to be within the tolerance: about 92 % of the vertices
        /// of a patch are closer to the true surface than twice their expected error.
        sigmas: f64 = 2.0,
    }
}
