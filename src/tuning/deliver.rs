//! Thresholds of what is handed on beside a mended mesh (`job`): marks of patches, pieces, tolerances.

thresholds! {
    /// Thresholds of what is handed on beside a mended mesh (`job`).
    DeliverTuning {
        /// Mean edges of the patch. Width of the stripes of hatched patches, at least: colours of vertices show no finer ones.
        stripe_edges: f64 = 2.5,
        /// Stripes across a patch, at most.
        stripes: f64 = 24.0,
        /// Part of the volume of a piece's largest component below which another component is left out: where a patch and the faces that were
        /// cut out are the same surface but for noise, thin slivers lie between them.
        piece_part: f64 = 1e-3,
        /// Part of a patch that may err by more than the tolerance before its hole is listed.
        beyond_part: f64 = 0.05,
        /// Expected errors that have to be within the tolerance: about 92 % of the vertices of a patch are nearer to the true surface than
        /// twice their expected error.
        sigmas: f64 = 2.0,
    }
}
